/* The mean, in more bits than a number has where that pays. */
#ifndef KQ_SRC_ARITHMETIC_MEAN_FLOAT_H
#define KQ_SRC_ARITHMETIC_MEAN_FLOAT_H

#include "scaled_float.h"
#if KQ_MEAN_IS_PAIR
#include "mean_pair.h"
#else
#include "mean_single.h"
#endif

static inline num control_drive(const num *row, const num *u, int count)
{
    return dot(0, row, u, count);
}

/* The terms of a'x that are rounded, as sizes.  own: the component that a'x is to be, of which a pair adds but what it
   changes by, or -1 */
KQ_COLD static num mean_terms(const num *a, const num *x, int n, int own)
{
    num total = 0;
    for (int k = 0; k < n; k++) {
        const num share = MEAN_PLANES == 2 && k == own ? a[k] - 1 : a[k];
        total += num_magnitude(share * mean_get(x, n, k));
    }
    return total;
}

/* As mean_terms, of a row that is not known: of x_i */
static inline num mean_size(const num *x, int n, int i) { return num_magnitude(mean_get(x, n, i)); }

/* The square of what a'x is rounded by */
KQ_COLD static num mean_rounding(const num *a, const num *x, int n, int own)
{
    const num rounding = num_epsilon * mean_terms(a, x, n, own);
    return rounding * rounding;
}

static inline scaled mean_residual_carried(num z, const num *h, const num *x, int n)
{
    return mean_residual(z, h, x, n, 0, n);
}

static inline void mean_take_carries(scaled *e, const num *h, const num *x, int n)
{
    (void)e, (void)h, (void)x, (void)n;
}

#endif
