/* The mean of a steady-state filter in fixed point: that of a filter. */
#ifndef KALMANQ_STEADY_KERNELS_H
#define KALMANQ_STEADY_KERNELS_H

#include "mean_q31.h"

#define STEADY_PLANES MEAN_PLANES

static inline int32_t steady_get(const int32_t *x, int n, int i) { return mean_get(x, n, i); }

static inline void steady_set(int32_t *x, int n, int i, int32_t value)
{
    wide_set(x, n, i, raise_wide(value, 24, 55));
}

/* t_i <- row'x + drive, where the row is zero left of `first` */
KQ_INLINE unsigned steady_drive(int32_t *t, int n, int i, const scaled *row, int first,
                                const int32_t *x, int64_t drive)
{
    return mean_advance(t, n, i, row, first, x, drive);
}

KQ_INLINE unsigned steady_row(int32_t *t, int n, int i, const scaled *row, int first,
                              const int32_t *x)
{
    return mean_advance(t, n, i, row, first, x, 0);
}

KQ_INLINE scaled steady_residual(int32_t z, const scaled *h, const int32_t *x, int n)
{
    return mean_residual(z, h, x, n, 0, n);
}

/* x_i <- t_i + row'e.  A product that is shifted down by 6 bits or more is below 2^56, which others
   are held at: 16 of them and t_i stay below 2^61. */
KQ_INLINE unsigned steady_add(int32_t *x, const int32_t *t, int n, int i, const scaled *row,
                              const scaled *e, int m)
{
    int64_t total = wide_get(t, n, i);
    KQ_UNROLL
    for (int c = 0; c < m; c++) {
        const int64_t p = product(row[c].mantissa, e[c].mantissa);
        const int32_t down = -24 - row[c].exponent - e[c].exponent;
        total = sum_of(total, down >= 6 ? lower_wide(p, down) : wide_from(p, -down), 61);
    }
    return wide_set_held(x, n, i, total);
}

#endif
