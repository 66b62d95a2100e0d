/* The state before the first measurement, in fixed point. */
#ifndef KQ_SRC_FILTER_INIT_Q31_H
#define KQ_SRC_FILTER_INIT_Q31_H

#include "likelihood_q31.h"
#include "prior_q31.h"

KQ_COLD kq_status T(kq_filter_init)(filter *f, const kq_prior_table_q31 *prior,
                                    kq_range_error_q31 *range_error)
{
    kq_status status = filter_check_memory(f);
    if (status) return status;
    const int n = f->states;
    status = prior_check(prior, n, range_error);
    if (status) return status;
    for (int i = 0; i < n; i++) wide_set(f->memory, n, i, shift_up_wide(prior->mean[i], 24, 55));
    copy(filter_root(f), prior->root, ROOT_LEN(n));
    renormalise(filter_root(f), n);
    f->state_format = prior->state_format;
    f->events = 0;
    f->weak = f->losses = 0;
    likelihood_clear(&f->last);
    likelihood_run_clear(&f->run);
    filter_make_ready(f);
    say_all_fit(range_error);
    return KQ_OK;
}

#endif
