/* The state before the first measurement, in floating point. */
#ifndef KQ_SRC_FILTER_INIT_FLOAT_H
#define KQ_SRC_FILTER_INIT_FLOAT_H

#include "prior_float.h"

KQ_COLD kq_status T(kq_filter_init)(filter *f, const num *x0, const num *P0)
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

KQ_COLD kq_status T(kq_filter_init_root)(filter *f, const num *x0, const num *S)
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
