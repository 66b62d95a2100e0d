/*
 * The mean in a wider word than the arithmetic's: a pair x = hi + lo, in two planes of n words.
 * hi is x rounded, lo what that leaves and what is being added.  Only the increment is ever
 * rounded, so a correction of a millionth of an ulp of x still counts.
 */
#ifndef KQ_SRC_ARITHMETIC_MEAN_PAIR_H
#define KQ_SRC_ARITHMETIC_MEAN_PAIR_H

#include "rows_float.h"

#define MEAN_PLANES 2

/* No mean ever leaves its word (mean_q31.h). */
enum { MEAN_WIDE = 0x4000, mean_widens = 0 };

/* x_i as one number, and what that leaves */
static inline num mean_get(const num *x, int n, int i) { return x[i] + x[n + i]; }
static inline num mean_low(const num *x, int n, int i)
{
    return x[n + i] - (mean_get(x, n, i) - x[i]);
}

static inline void mean_set(num *x, int n, int i, num value)
{
    x[i] = value;
    x[n + i] = 0;
}

/* x_i += b w: into lo, which mean_settle takes into hi at the end of an update */
KQ_KERNEL unsigned mean_correct(num *x, int n, int i, num b, num w)
{
    x[n + i] += b * w;
    return 0;
}

/* lo is left below an ulp of hi, for the next increment to be added to. */
KQ_KERNEL void mean_settle(num *x, int n)
{
    KQ_UNROLL
    for (int i = 0; i < n; i++) {
        const num low = x[n + i], high = x[i] + low;
        x[n + i] = low - (high - x[i]);
        x[i] = high;
    }
}

/* mean_correct for an increment of any size: hi and lo are brought apart again, the sum is exact. */
static inline unsigned mean_correct_exactly(num *x, int n, int i, num b, num w)
{
    const num d = b * w;
    const num low = x[n + i] + d;
    const num low_error = (d - (low - x[n + i])) + (x[n + i] - (low - (low - x[n + i])));
    const num high = x[i] + low;
    const num moved = high - x[i];
    x[n + i] = ((x[i] - (high - moved)) + (low - moved)) + low_error;
    x[i] = high;
    return 0;
}

/* x += d + low, of any size; low: NULL for none.  What the sum of the high parts leaves is exact.  Where the low part
   is not a number x is not, either.  The low part of a large x may be 0: how far it reaches is read from x. */
KQ_SHARED extent pairs_add(num *x, int n, const num *d, const num *low)
{
    extent far = 0;
    for (int i = 0; i < n; i++) {
        const num total = x[i] + d[i], part = total - d[i];
        const num left = (d[i] - (total - part)) + (x[i] - part);
        const num rest = left + (low ? x[n + i] + low[i] : x[n + i]), high = total + rest;
        x[n + i] = rest - (high - total);
        x[i] = high;
        far = extent_join(far, extent_of(high));
    }
    return far;
}

static inline extent mean_shift(num *x, int n, const num *d, const num *low)
{
    return pairs_add(x, n, d, low);
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

/* z - h'x, h being 0 outside of from .. to-1: the high parts cancel first */
KQ_KERNEL num mean_residual(num z, const num *h, const num *x, int n, int from, int to)
{
    num low = h[from] * x[n + from];
    z -= h[from] * x[from];
    KQ_UNROLL
    for (int k = from + 1; k < to; k++) {
        z -= h[k] * x[k];
        low += h[k] * x[n + k];
    }
    return z - low;
}

/* t <- x rounded, to be read while x is overwritten */
KQ_KERNEL void mean_copy(num *t, const num *x, int n)
{
    KQ_UNROLL
    for (int i = 0; i < n; i++) t[i] = mean_get(x, n, i);
}

/* A_ii - 1 is rounded where A_ii < 1/2: a_ii less what it stands for then */
static inline num mean_rest(num a_ii) { return a_ii - ((a_ii - 1) + 1); }

enum { mean_rounds = 1 };

static inline int transition_is_rounded(const num *A, int n)
{
    for (int i = 0; i < n; i++) {
        if (mean_rest(A[i * (n + 1)]) != 0) return 1;
    }
    return 0;
}

/* What mean_advance leaves out of such rows, which would be the same error of A at every step */
KQ_OUTLINE void mean_take_rests(num *x, const num *A, num *t, int n)
{
    KQ_UNROLL
    for (int i = 0; i < n; i++) x[n + i] += mean_rest(A[i * (n + 1)]) * t[i];
}

/* x_i <- row'x + *drive as x_i + ((row - e_i)'x + *drive), where t holds x rounded and the row
   is zero left of `first`; drive is NULL where there is none */
KQ_KERNEL extent mean_advance(num *x, int n, int i, const num *row, int first, const num *t,
                                const num *drive)
{
    num d = x[n + i];
    if (drive) d += *drive;
    d += (row[i] - 1) * t[i];
    d = dot(d, row + first, t + first, i - first);
    d = dot(d, row + i + 1, t + i + 1, n - 1 - i);
    const num high = x[i] + d, low = d - (high - x[i]);
    x[n + i] = low;
    x[i] = high;
    return extent_of(high);
}

/* Can a call have left this pair?  lo is what the rounding of hi has left. */
static inline int mean_is_possible(const num *x, int n, int i)
{
    return num_magnitude(x[n + i]) <= 4 * num_epsilon * num_magnitude(x[i]);
}

#endif
