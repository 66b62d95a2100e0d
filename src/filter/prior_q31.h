#ifndef KQ_SRC_FILTER_PRIOR_Q31_H
#define KQ_SRC_FILTER_PRIOR_Q31_H

#include "kalmanq/filter.h"
#include "kalmanq/fixed_point.h"
#include "kalmanq/status.h"

#include "../arithmetic/q31.h"
#include "../arithmetic/compiler.h"
#include "../model/definitions.h"
#include "../model/units.h"

/* ------------------------------------------------------------------ prior */

KQ_COLD static kq_status prior_check(const kq_prior_table_q31 *prior, int n, kq_misfit_q31 *misfit)
{
    if (!prior || !prior->state_format || !prior->mean || !prior->root) return KQ_ERR_NULL;
    if (prior->states != n) return KQ_ERR_MISMATCH;
    kq_status status = formats_check(prior->state_format, n);
    if (!status) status = root_check(prior->root, n);
    for (int i = 0; i < n && !status; i++) {
        status = ranges_check(prior->mean + i, prior->state_format + i, 1, 1);
        if (!status || !misfit) continue;
        *misfit = (kq_misfit_q31){.quantity = KQ_STATE, .component = i, .bits = 0};
    }
    return status;
}

#endif
