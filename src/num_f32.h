/*
 * The number layer for float: the type, its constants, and the closed list of operations that
 * differ between the arithmetics.  num_f64.h is its twin.
 *
 * The mean is held as a pair x = hi + lo in two planes of n words: hi is where the last
 * predict left it, lo collects what came since.  Only the increment is ever rounded, so a
 * correction of a millionth of an ulp of x still counts.
 */
#ifndef KALMANQ_NUM_F32_H
#define KALMANQ_NUM_F32_H

#include <float.h>
#include <math.h>
#include <stdint.h>

#ifdef __FAST_MATH__
#error "kalmanq needs IEEE arithmetic: the pair of floats and the NaN tests do not survive -ffast-math"
#endif

typedef float num;

#define MEAN_PLANES 2

static const num num_epsilon = FLT_EPSILON;
static const num num_max = FLT_MAX;
static const num num_tiny = 0x1p-120f;          /* smallest variance of a noise */
static const num num_tiny_root = 0x1p-60f;      /* and its root */
static const num num_zero_variance = 0x1p-96f;  /* an innovation variance below it counts as 0 */
static const num num_sharp = 0x1p-20f;          /* r below this share of S is taken in stages, */
static const num num_stage = 0x1p-16f;          /* each with this share for its noise */
static const num num_window = 0x1p32f;          /* determinant kept within 1/window .. window */
static const int num_window_bits = 32;
static const num num_half = 0.5f;
static const num num_root_half = 0.70710678f;
static const num num_log_2 = 0.69314718f;
static const num num_log_2_pi = 1.83787707f;

static inline num num_root(num a) { return sqrtf(a); }
static inline num num_magnitude(num a) { return a < 0 ? -a : a; }
static inline int num_is_finite(num a) { return a - a == 0; }
static inline num num_nan(void) { return NAN; }

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

/* x_i += d */
static inline void mean_add(num *x, int n, int i, num d) { x[n + i] += d; }

/* The same for a d of any size: hi and lo are brought apart again, the sum is exact. */
static inline void mean_add_exactly(num *x, int n, int i, num d)
{
    const num low = x[n + i] + d;
    const num low_error = (d - (low - x[n + i])) + (x[n + i] - (low - (low - x[n + i])));
    const num high = x[i] + low;
    const num moved = high - x[i];
    x[n + i] = ((x[i] - (high - moved)) + (low - moved)) + low_error;
    x[i] = high;
}

/* z - h'x: the high parts cancel first */
static inline num mean_residual(num z, const num *h, const num *x, int n)
{
    for (int k = 0; k < n; k++) z -= h[k] * x[k];
    for (int k = 0; k < n; k++) z -= h[k] * x[n + k];
    return z;
}

/* x_i <- row'x + drive as x_i + ((row - e_i)'x + drive), where t holds x rounded and the row
   is zero left of `first`.  row_i - 1 is exact for 1/2 <= row_i <= 2. */
static inline void mean_advance(num *x, int n, int i, const num *row, int first, const num *t,
                                num drive)
{
    num d = x[n + i] + drive + (row[i] - 1) * t[i];
    for (int k = first; k < i; k++) d += row[k] * t[k];
    for (int k = i + 1; k < n; k++) d += row[k] * t[k];
    const num high = x[i] + d;
    x[n + i] = d - (high - x[i]);
    x[i] = high;
}

#endif
