/* The mean in one word of the arithmetic's own (mean_pair.h is the wider one). */
#ifndef KQ_SRC_ARITHMETIC_MEAN_SINGLE_H
#define KQ_SRC_ARITHMETIC_MEAN_SINGLE_H

#include "rows_float.h"

#define MEAN_PLANES 1

/* No mean ever leaves its word (mean_q31.h). */
enum { MEAN_WIDE = 0x4000, mean_widens = 0 };

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

/* x_i += b w */
KQ_KERNEL unsigned mean_correct(num *x, int n, int i, num b, num w)
{
    (void)n;
    x[i] += b * w;
    return 0;
}

KQ_KERNEL void mean_settle(num *x, int n) { (void)x, (void)n; }

static inline unsigned mean_correct_exactly(num *x, int n, int i, num b, num w)
{
    return mean_correct(x, n, i, b, w);
}

/* x += d */
static inline extent mean_shift(num *x, int n, const num *d, const num *low)
{
    extent far = 0;
    (void)low;
    for (int i = 0; i < n; i++) {
        x[i] += d[i];
        far = extent_join(far, extent_of(x[i]));
    }
    return far;
}

static inline unsigned mean_saturate(num *x, int n, int i)
{
    (void)x, (void)n, (void)i;
    return 0;
}

static inline extent mean_extent(const num *x, int n, int i)
{
    (void)n;
    return extent_of(x[i]);
}

/* z - h'x, h being 0 outside of from .. to-1 */
KQ_KERNEL num mean_residual(num z, const num *h, const num *x, int n, int from, int to)
{
    (void)n;
    KQ_UNROLL
    for (int k = from; k < to; k++) z -= h[k] * x[k];
    return z;
}

/* t <- x, to be read while x is overwritten */
KQ_KERNEL void mean_copy(num *t, const num *x, int n)
{
    KQ_UNROLL
    for (int i = 0; i < n; i++) t[i] = x[i];
}

/* Nothing of A is rounded here. */
enum { mean_rounds = 0 };

static inline int transition_is_rounded(const num *A, int n)
{
    (void)A, (void)n;
    return 0;
}

static inline void mean_take_rests(num *x, const num *A, num *t, int n)
{
    (void)x, (void)A, (void)t, (void)n;
}

/* x_i <- row't + *drive, where t is a copy of x and the row is zero left of `first` */
KQ_KERNEL extent mean_advance(num *x, int n, int i, const num *row, int first, const num *t,
                                const num *drive)
{
    num d = drive ? *drive : 0;
    for (int k = first; k < n; k++) d += row[k] * t[k];
    x[i] = d;
    return extent_of(d);
}

static inline int mean_is_possible(const num *x, int n, int i)
{
    (void)x, (void)n, (void)i;
    return 1;
}

#endif
