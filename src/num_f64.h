/*
 * The number layer for double: the type, its constants, and the closed list of operations that
 * differ between the arithmetics.  num_f32.h is its twin.  The mean is one double.
 */
#ifndef KALMANQ_NUM_F64_H
#define KALMANQ_NUM_F64_H

#include <float.h>
#include <math.h>
#include <stdint.h>

#ifdef __FAST_MATH__
#error "kalmanq needs IEEE arithmetic: the NaN tests do not survive -ffast-math"
#endif

typedef double num;

#define MEAN_PLANES 1

static const num num_epsilon = DBL_EPSILON;
static const num num_max = DBL_MAX;
static const num num_tiny = 0x1p-400;           /* smallest variance of a noise */
static const num num_tiny_root = 0x1p-200;      /* and its root */
static const num num_zero_variance = 0x1p-360;  /* an innovation variance below it counts as 0 */
static const num num_sharp = 0x1p-44;           /* r below this share of S is taken in stages, */
static const num num_stage = 0x1p-40;           /* each with this share for its noise */
static const num num_window = 0x1p256;          /* determinant kept within 1/window .. window */
static const int num_window_bits = 256;
static const num num_half = 0.5;
static const num num_root_half = 0.70710678118654752;
static const num num_log_2 = 0.69314718055994531;
static const num num_log_2_pi = 1.83787706640934548;

static inline num num_root(num a) { return sqrt(a); }
static inline num num_magnitude(num a) { return a < 0 ? -a : a; }
static inline int num_is_finite(num a) { return a - a == 0; }
static inline num num_nan(void) { return (num)NAN; }

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
