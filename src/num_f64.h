/*
 * The number layer for double: the type, its constants, and the closed list of operations that
 * differ between the arithmetics.  num_f32.h is its twin.
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

static const num num_epsilon = DBL_EPSILON;
static const num num_max = DBL_MAX;
static const num num_tiny = 0x1p-400;          /* smallest variance of a noise */
static const num num_tiny_root = 0x1p-200;     /* and its root */
static const num num_zero_variance = 0x1p-360; /* an innovation variance below it counts as 0 */
static const num num_stage = 0x1p-44;          /* of f'f: the noise of a stage */
static const num num_window = 0x1p256;         /* determinant kept within 1/window .. window */
static const int num_window_bits = 256;
static const num num_half = 0.5;
static const num num_root_half = 0.70710678118654752;
static const num num_log_2 = 0.69314718055994531;
static const num num_log_2_pi = 1.83787706640934548;

static inline num num_root(num a) { return sqrt(a); }
static inline num num_magnitude(num a) { return a < 0 ? -a : a; }
static inline int num_is_finite(num a) { return a - a == 0; }
static inline num num_nan(void) { return (num)NAN; }

#include "rows_float.h"

/* r below this share of s is taken in stages */
static inline num sharp_share(num s) { return s * 0x1p-48; }

#include "mean_single.h"

#include "coordinates_float.h"

#endif
