#ifndef KQ_SRC_FILTER_PRIOR_FLOAT_H
#define KQ_SRC_FILTER_PRIOR_FLOAT_H

#include "kalmanq/size.h"
#include "kalmanq/status.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/compiler.h"
#include "../arithmetic/mean.h"
#include "../arithmetic/root.h"
#include "../model/definitions.h"
#include "../model/factor.h"
#include "../model/types.h"
#include "../model/units.h"
#include "filter.h"
#include "likelihood.h"

/* ------------------------------------------------------------------ prior */

/* Nor is a mean beyond what predict holds. */
KQ_COLD static kq_status largest_mean_check(const num *x, int n)
{
    for (int i = 0; i < n; i++) {
        if (num_magnitude(x[i]) > num_most_sigma * num_most_sigma) return KQ_ERR_RANGE;
    }
    return KQ_OK;
}

/* With the root that is in its memory */
KQ_COLD static void filter_begin(filter *f, const num *x0)
{
    const int n = f->states;
    for (int i = 0; i < n; i++) mean_set(f->memory, n, i, x0[i]);
    f->history = 0; /* not looked at: it may be gone */
    f->events = 0;
    likelihood_clear(&f->last);
    likelihood_run_clear(&f->run);
    filter_set_ready(f, FILTER_READY);
}

KQ_COLD static kq_status filter_init(filter *f, const num *x0, const num *P0)
{
    kq_status status = filter_check_memory(f);
    if (status) return status;
    if (!x0 || !P0) return KQ_ERR_NULL;
    const int n = f->states;
    if (!all_finite(x0, n)) return KQ_ERR_NOT_FINITE;
    status = largest_mean_check(x0, n);
    if (!status) status = state_covariance_check(P0, n);
    if (!status) status = root_or_refuse(filter_root(f), P0, n);
    if (!status) filter_begin(f, x0);
    return status;
}

KQ_COLD static kq_status filter_init_root(filter *f, const num *x0, const num *S)
{
    kq_status status = filter_check_memory(f);
    if (status) return status;
    if (!x0 || !S) return KQ_ERR_NULL;
    if (!all_finite(x0, f->states)) return KQ_ERR_NOT_FINITE;
    status = largest_mean_check(x0, f->states);
    if (!status) status = root_check(S, f->states);
    if (status) return status;
    copy(filter_root(f), S, KQ_TRIANGLE(f->states));
    filter_begin(f, x0);
    return KQ_OK;
}

#endif
