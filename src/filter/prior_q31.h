#ifndef KQ_SRC_FILTER_PRIOR_Q31_H
#define KQ_SRC_FILTER_PRIOR_Q31_H

#include "kalmanq/filter.h"
#include "kalmanq/fixed_point.h"
#include "kalmanq/status.h"

#include "../arithmetic/q31.h"
#include "../arithmetic/compiler.h"
#include "../arithmetic/fixed.h"
#include "../arithmetic/mean.h"
#include "../arithmetic/root.h"
#include "../arithmetic/rows.h"
#include "../model/definitions.h"
#include "../model/types.h"
#include "../model/units.h"
#include "filter.h"
#include "likelihood.h"

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

KQ_COLD static kq_status filter_init(filter *f, const kq_prior_table_q31 *prior,
                                     kq_misfit_q31 *misfit)
{
    kq_status status = filter_check_memory(f);
    if (status) return status;
    const int n = f->states;
    status = prior_check(prior, n, misfit);
    if (status) return status;
    for (int i = 0; i < n; i++) wide_set(f->memory, n, i, raise_wide(prior->mean[i], 24, 55));
    copy(filter_root(f), prior->root, ROOT_LEN(n));
    renormalise(filter_root(f), n);
    f->state_format = prior->state_format;
    f->history = 0; /* not looked at: it may be gone */
    f->events = 0;
    likelihood_clear(&f->last);
    likelihood_run_clear(&f->run);
    filter_set_ready(f, FILTER_READY);
    say_all_fit(misfit);
    return KQ_OK;
}

#endif
