/*
 * Float: the type, its constants, and the operations on one number that differ between the
 * arithmetics.  f64.h is its twin.
 */
#ifndef KQ_SRC_ARITHMETIC_F32_H
#define KQ_SRC_ARITHMETIC_F32_H

#include "language.h"
#include <float.h>
#include <math.h>
#include "kalmanq/kalmanq.h"
#include "ieee.h"

/* The public name of this arithmetic */
#define T(name) name##_f32

#define KQ_FLOATING 1
#define KQ_MEAN_IS_PAIR 1
#define KQ_NUM_BITS 32

typedef float num;

static const num num_epsilon = FLT_EPSILON;
static const num num_max = FLT_MAX;
static const num num_tiny = 0x1p-120f;         /* smallest variance of a noise */
static const num num_left_over = 0x1p-117f;     /* of a variance that is smallest, and its rounding */
static const num num_row_rounding = 0x1p-21f;   /* of what a row was: entries below it are rounding */
static const num num_tiny_root = 0x1p-60f;     /* and its root */
static const num num_most_nis = 0x1p124f;      /* of a scalar measurement: 16 add up */
static const num num_most_sure = 0x1p24f;      /* NIS that says that the sigma is rounding */
enum { num_watched = -46, num_exponent_bits = 8 }; /* 2^-46 of the terms of h'S, squared: the most that an update rounds it by */
static const num num_tape_rounding = 0x1p-62f; /* of a filtered sigma, squared: what a measurement leaves in the smoothed one */
static const num num_known_exactly = 0x1p-40f; /* the same: a smoothed one below it is rounding */
static const num num_most_condition = 0x1.8p45f; /* of S, squared: above it rounding counts */
static const num num_zero_variance = 0x1p-96f; /* an innovation variance below it counts as 0 */
static const num num_most_variance = 0x1p96f;  /* fading raises no variance beyond it */
static const num num_most_sigma = 0x1p60f;     /* the largest of a state; a mean's is its square */
static const num num_saturation_unit = 0x1p70f;      /* in units of it every square is a number */
static const num num_low_noise = 0x1p-15f;         /* least share of noise where doubling begins */
static const num num_huge = 0x1p60f;           /* and where it is given up */
static const num num_growth = 1.25f;           /* of a covariance that does not settle, a row */
static const num num_unsettled = 0x1p-6f;      /* a change beyond it is not rounding */
enum { freeze_bits_max = KQ_FREEZE_BITS_MAX_F32, num_refinements = 30 };
enum { mean_moves = 4 }; /* a mean near 2^120 is where it belongs after so many moves */
enum { num_digits = 24 }; /* of a number; doublings, too */
enum { FLOW_TERMS = 8 }; /* of a sum that falls by half a term (model/continuous_float.h) */
static const num num_half = 0.5f;
static const num num_root_half = 0.70710678f;
static const num num_log_2 = 0.69314718f;
static const num num_log_2_pi = 1.83787707f;

static inline num num_root(num a) { return sqrtf(a); }
#if defined(__GNUC__)
static inline num num_magnitude(num a) { return __builtin_fabsf(a); } /* one instruction, or a bit */
#else
static inline num num_magnitude(num a) { return a < 0 ? -a : a; }
#endif
static inline int num_is_finite(num a) { return a - a == 0; }
static inline num num_nan(void) { return NAN; }

/* What tells a number from others, in 32 bits */
static inline uint32_t num_bits(num a)
{
    const union {
        num value;
        uint32_t bits;
    } both = {a};
    return both.bits;
}

/* Its 32 highest bits */
static inline uint32_t num_top_bits(num a) { return num_bits(a); }

/* Its bits in 32: one that is turned turns one. */
static inline uint32_t num_folded(num a) { return num_bits(a); }

/* Is a >= 0 beyond `most`, or not a number?  As integers, where the FPU would have to load it. */
static inline int num_exceeds(num a, num most) { return num_bits(a) > num_bits(most); }

/* The upper half of its digits: a product of two halves is exact. */
static inline num num_upper_half(num a)
{
    union {
        num value;
        uint32_t bits;
    } both = {a};
    both.bits &= ~UINT32_C(0xfff);
    return both.value;
}

/* a > 0, not subnormal, as m 2^e with m in [1/2, 1): e is added to *exponent. */
static inline num num_split(num a, int32_t *exponent)
{
    union {
        num value;
        uint32_t bits;
    } both = {a};
    *exponent += (int32_t)(both.bits >> 23) - 126;
    both.bits = (both.bits & UINT32_C(0x7fffff)) | UINT32_C(126) << 23;
    return both.value;
}

/* The power of 2 of |a|, 0 for 0 */
static inline num num_power(num a)
{
    union {
        num value;
        uint32_t bits;
    } both = {a};
    both.bits &= UINT32_C(0x7f800000);
    return both.value;
}

enum { num_loss_bits = 19 }; /* of what rounding takes (filter/rounding.h) */

/* Is s above r > 0 by less than 2^-14 of itself?  Of the cosines 11 bits are left then. */
static inline int is_weak(num r, num s)
{
    union {
        num value;
        uint32_t bits;
    } lower = {r}, upper = {s};
    return upper.bits - lower.bits < 512;
}

/* After a measurement with r below this share of s the root is matched (filter/match.h). */
static inline num low_noise_share(num s) { return s * 0x1p-16f; }
static const num num_sure_share = 0x1p-15f; /* twice that */

typedef num score;

/* Lengths of memory, in numbers (kalmanq/) */
#define FILTER_LEN KQ_FILTER_LEN_F32
#define CONSISTENCY_LEN KQ_CONSISTENCY_LEN_F32
#define HISTORY_LEN KQ_HISTORY_LEN_F32
#define HISTORY_CHANGE_LEN KQ_PRIVATE_HISTORY_CHANGE_LEN_F32
#define HISTORY_WORKSPACE_LEN KQ_PRIVATE_HISTORY_WORKSPACE_LEN
#define STEADY_LEN KQ_STEADY_LEN_F32
#define STEADY_SOLVE_LEN KQ_STEADY_SOLVE_LEN_F32
#define FREEZE_LEN KQ_FREEZE_LEN_F32
#define MAP_LEN KQ_PRIVATE_MAP_LEN_F32
#define ON_LINE_LEN KQ_PRIVATE_ON_LINE_LEN_F32
#define CONTINUOUS_LEN KQ_CONTINUOUS_LEN
#define CORRELATED_LEN KQ_CORRELATED_LEN
#define LAG_LEN KQ_LAG_LEN_F32
#define JACOBIANS_LEN KQ_JACOBIANS_LEN_F32
#define INSTANT_LEN KQ_INSTANT_LEN_F32
#define DIFFUSE_LEN KQ_DIFFUSE_LEN_F32
#define DIFFUSE_RANGE_LEN 0
#define HISTORY_STEP_LEN KQ_PRIVATE_HISTORY_STEP_LEN_F32
#define EM_LEN KQ_EM_LEN_F32
#define ADAPTATION_LEN KQ_ADAPTATION_LEN_F32
#define DIFFUSE_PAST_LEN KQ_PRIVATE_DIFFUSE_PAST_LEN_F32

#endif
