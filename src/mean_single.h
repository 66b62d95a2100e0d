/* The mean in one word of the arithmetic's own (mean_pair.h is the wider one). */
#ifndef KALMANQ_MEAN_H
#define KALMANQ_MEAN_H

#define MEAN_PLANES 1

/* x_i as one number, and what that leaves */
static inline num mean_get(const num *x, int n, int i)
{
    (void)n;
    return x[i];
}

static inline num mean_low(const num *x, int n, int i)
{
    (void)x, (void)n, (void)i;
    return 0;
}

static inline void mean_set(num *x, int n, int i, num value)
{
    (void)n;
    x[i] = value;
}

/* x_i += d */
static inline void mean_add(num *x, int n, int i, num d)
{
    (void)n;
    x[i] += d;
}

static inline void mean_add_exactly(num *x, int n, int i, num d) { mean_add(x, n, i, d); }

/* z - h'x */
static inline num mean_residual(num z, const num *h, const num *x, int n)
{
    for (int k = 0; k < n; k++) z -= h[k] * x[k];
    return z;
}

/* x_i <- row'x + drive, where t holds the old x and the row is zero left of `first` */
static inline void mean_advance(num *x, int n, int i, const num *row, int first, const num *t,
                                num drive)
{
    num d = drive;
    for (int k = first; k < n; k++) d += row[k] * t[k];
    x[i] = d;
}

#endif
