/* The mean of a steady-state filter in floating point: one number a state. */
#ifndef KALMANQ_STEADY_KERNELS_H
#define KALMANQ_STEADY_KERNELS_H

#define STEADY_PLANES 1

static inline num steady_get(const num *x, int n, int i)
{
    (void)n;
    return x[i];
}

static inline void steady_set(num *x, int n, int i, num value)
{
    (void)n;
    x[i] = value;
}

/* t_i <- row'x, where the row is zero left of `first`; and with a drive */
KQ_INLINE unsigned steady_row(num *t, int n, int i, const num *row, int first, const num *x)
{
    t[i] = dot(row[n - 1] * x[n - 1], row + first, x + first, n - 1 - first);
    return 0;
}

KQ_INLINE unsigned steady_drive(num *t, int n, int i, const num *row, int first, const num *x,
                                num drive)
{
    t[i] = dot(drive, row + first, x + first, n - first);
    return 0;
}

/* z - h'x */
KQ_INLINE num steady_residual(num z, const num *h, const num *x, int n)
{
    KQ_UNROLL
    for (int k = 0; k < n; k++) z -= h[k] * x[k];
    return z;
}

/* x_i <- t_i + row'e */
KQ_INLINE unsigned steady_add(num *x, const num *t, int n, int i, const num *row, const num *e,
                              int m)
{
    (void)n;
    x[i] = dot(t[i], row, e, m);
    return 0;
}

#endif
