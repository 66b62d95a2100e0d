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

/* t <- x, to be read while x is overwritten */
KQ_INLINE void steady_copy(num *t, const num *x, int n)
{
    KQ_UNROLL
    for (int i = 0; i < n; i++) t[i] = x[i];
}

/* x_i <- row't + drive, where the row is zero left of `first` */
KQ_INLINE unsigned steady_advance(num *x, int n, int i, const num *row, int first, const num *t,
                                  num drive)
{
    x[i] = dot(drive, row + first, t + first, n - first);
    return 0;
}

/* z - h'x */
KQ_INLINE num steady_residual(num z, const num *h, const num *x, int n)
{
    KQ_UNROLL
    for (int k = 0; k < n; k++) z -= h[k] * x[k];
    return z;
}

/* x_i += row'e */
KQ_INLINE unsigned steady_add(num *x, int n, int i, const num *row, const num *e, int m)
{
    (void)n;
    x[i] = dot(x[i], row, e, m);
    return 0;
}

#endif
