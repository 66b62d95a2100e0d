#ifndef KQ_SRC_FILTER_PRIOR_FLOAT_H
#define KQ_SRC_FILTER_PRIOR_FLOAT_H

#include "likelihood_float.h"
#include "state.h"

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
    f->events = 0;
    f->weak = f->losses = 0;
    likelihood_clear(&f->last);
    likelihood_run_clear(&f->run);
    filter_make_ready(f);
}

static int mean_is_finite(const num *x, int n) { return all_finite(x, n); }

/* The largest entry of row i of a root, NaN where one is no number */
KQ_COLD static num row_size(const num *S, int n, int i)
{
    num most = 0;
    for (int j = i; j < n; j++) {
        const num size = num_magnitude(S[column(j) + i]);
        if (!(size <= most)) most = size;
    }
    return most;
}

/* Row i of a root: nothing above what predict holds, and what a start leaves, which holds 16 directions apart */
KQ_COLD static int row_is_possible(const num *S, int n, int i)
{
    return row_size(S, n, i) <= 8 * num_most_sigma;
}

#endif
