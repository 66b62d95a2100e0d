#ifndef KQ_SRC_FILTER_PRIOR_FLOAT_H
#define KQ_SRC_FILTER_PRIOR_FLOAT_H

#include "kalmanq/size.h"
#include "kalmanq/status.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/compiler.h"
#include "../arithmetic/mean.h"
#include "../arithmetic/triangle.h"
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
    f->attached = 0; /* not looked at: it may be gone */
    f->events = 0;
    f->faint = 0;
    likelihood_clear(&f->last);
    likelihood_run_clear(&f->run);
    filter_know_all(f);
    filter_set_ready(f, FILTER_READY);
}

/* Can a call have left this mean and this root? */
KQ_COLD static int state_is_possible(const filter *f)
{
    const int n = f->states;
    const num *S = filter_root(f);
    if (!all_finite(f->memory, MEAN_PLANES * n + KQ_TRIANGLE(n))) return 0;
    for (int i = 0; i < n; i++) {
        if (S[column(i) + i] < 0) return 0;
    }
    return 1;
}

#endif
