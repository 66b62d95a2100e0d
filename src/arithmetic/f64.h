/*
 * Double: the type, its constants, and the operations on one number that differ between the
 * arithmetics.  f32.h is its twin.
 */
#ifndef KQ_SRC_ARITHMETIC_F64_H
#define KQ_SRC_ARITHMETIC_F64_H

#include "language.h"
#include <float.h>
#include <math.h>
#include "kalmanq/kalmanq.h"
#include "ieee.h"

/* The public name of this arithmetic */
#define T(name) name##_f64

#define KQ_FLOATING 1
#define KQ_MEAN_IS_PAIR 0
#define KQ_NUM_BITS 64

typedef double num;

static const num num_epsilon = DBL_EPSILON;
static const num num_max = DBL_MAX;
static const num num_tiny = 0x1p-400;          /* smallest variance of a noise */
static const num num_left_over = 0x1p-397;        /* of a variance that is smallest, and its rounding */
static const num num_row_rounding = 0x1p-50;  /* of what a row was: entries below it are rounding */
static const num num_tiny_root = 0x1p-200;     /* and its root */
static const num num_most_nis = 0x1p1020;      /* of a scalar measurement: 16 add up */
static const num num_most_sure = 0x1p53;        /* NIS that says that the sigma is rounding */
enum { num_watched = -104, num_exponent_bits = 11 }; /* 2^-104 of the terms of h'S, squared: the most that an update rounds it by */
static const num num_tape_rounding = 0x1p-113; /* of a filtered sigma, squared: what a measurement leaves in the smoothed one */
static const num num_known_exactly = 0x1p-98; /* the same: a smoothed one below it is rounding */
static const num num_most_condition = 0x1.8p103; /* of S, squared: above it rounding counts */
static const num num_zero_variance = 0x1p-360; /* an innovation variance below it counts as 0 */
static const num num_most_variance = 0x1p360;  /* fading raises no variance beyond it */
static const num num_most_sigma = 0x1p500;     /* the largest of a state; a mean's is its square */
static const num num_saturation_unit = 0x1p600;     /* in units of it every square is a number */
static const num num_low_noise = 0x1p-44;          /* least share of noise where doubling begins */
static const num num_huge = 0x1p500;           /* and where it is given up */
static const num num_growth = 1.25;            /* of a covariance that does not settle, a row */
static const num num_unsettled = 0x1p-20;      /* a change beyond it is not rounding */
enum { freeze_bits_max = KQ_FREEZE_BITS_MAX_F64, num_refinements = 30 };
enum { mean_moves = 20 }; /* a mean near 2^1000 is where it belongs after so many moves */
enum { num_digits = 53 }; /* of a number; doublings, too */
enum { FLOW_TERMS = 14 };
static const num num_half = 0.5;
static const num num_root_half = 0.70710678118654752;
static const num num_log_2 = 0.69314718055994531;
static const num num_log_2_pi = 1.83787706640934548;

static inline num num_root(num a) { return sqrt(a); }
#if defined(__GNUC__)
static inline num num_magnitude(num a) { return __builtin_fabs(a); } /* one instruction, or a bit */
#else
static inline num num_magnitude(num a) { return a < 0 ? -a : a; }
#endif
static inline int num_is_finite(num a) { return a - a == 0; }
static inline num num_nan(void) { return (num)NAN; }

static inline uint64_t num_all_bits(num a)
{
    const union {
        num value;
        uint64_t bits;
    } both = {a};
    return both.bits;
}

/* What tells a number from others, in 32 bits */
static inline uint32_t num_bits(num a)
{
    const uint64_t bits = num_all_bits(a);
    return (uint32_t)bits ^ (uint32_t)(bits >> 32) * UINT32_C(0x9e3779b1);
}

/* Its 32 highest bits */
static inline uint32_t num_top_bits(num a) { return (uint32_t)(num_all_bits(a) >> 32); }

/* Its bits in 32: one that is turned turns one. */
static inline uint32_t num_folded(num a)
{
    const uint64_t bits = num_all_bits(a);
    return (uint32_t)(bits ^ bits >> 32);
}

/* Is a >= 0 beyond `most`, or not a number? */
static inline int num_exceeds(num a, num most) { return !(a <= most); }

/* The upper half of its digits: a product of two halves is exact. */
static inline num num_upper_half(num a)
{
    union {
        num value;
        uint64_t bits;
    } both = {a};
    both.bits &= ~UINT64_C(0x7ffffff);
    return both.value;
}

/* a > 0, not subnormal, as m 2^e with m in [1/2, 1): e is added to *exponent. */
static inline num num_split(num a, int32_t *exponent)
{
    union {
        num value;
        uint64_t bits;
    } both = {a};
    *exponent += (int32_t)(both.bits >> 52) - 1022;
    both.bits = (both.bits & UINT64_C(0xfffffffffffff)) | UINT64_C(1022) << 52;
    return both.value;
}

/* The power of 2 of |a|, 0 for 0 */
static inline num num_power(num a)
{
    union {
        num value;
        uint64_t bits;
    } both = {a};
    both.bits &= UINT64_C(0x7ff) << 52;
    return both.value;
}

enum { num_loss_bits = 31 }; /* of what rounding takes (filter/rounding.h) */

/* It takes 1e13 measurements within the last bits of s before that shows. */
static inline int is_weak(num r, num s)
{
    (void)r, (void)s;
    return 0;
}

/* After a measurement with r below this share of s the root is matched (filter/match.h). */
static inline num low_noise_share(num s) { return s * 0x1p-48; }
static const num num_sure_share = 0x1p-47; /* twice that */

typedef num score;

/* Lengths of memory, in numbers (kalmanq/) */
#define FILTER_LEN KQ_FILTER_LEN_F64
#define CONSISTENCY_LEN KQ_CONSISTENCY_LEN_F64
#define HISTORY_LEN KQ_HISTORY_LEN_F64
#define HISTORY_CHANGE_LEN KQ_PRIVATE_HISTORY_CHANGE_LEN_F64
#define HISTORY_WORKSPACE_LEN KQ_PRIVATE_HISTORY_WORKSPACE_LEN
#define STEADY_LEN KQ_STEADY_LEN_F64
#define STEADY_SOLVE_LEN KQ_STEADY_SOLVE_LEN_F64
#define FREEZE_LEN KQ_FREEZE_LEN_F64
#define MAP_LEN KQ_PRIVATE_MAP_LEN_F64
#define ON_LINE_LEN KQ_PRIVATE_ON_LINE_LEN_F64
#define CONTINUOUS_LEN KQ_CONTINUOUS_LEN
#define CORRELATED_LEN KQ_CORRELATED_LEN
#define LAG_LEN KQ_LAG_LEN_F64
#define JACOBIANS_LEN KQ_JACOBIANS_LEN_F64
#define INSTANT_LEN KQ_INSTANT_LEN_F64
#define DIFFUSE_LEN KQ_DIFFUSE_LEN_F64
#define DIFFUSE_RANGE_LEN 0
#define HISTORY_STEP_LEN KQ_PRIVATE_HISTORY_STEP_LEN_F64
#define EM_LEN KQ_EM_LEN_F64
#define ADAPTATION_LEN KQ_ADAPTATION_LEN_F64
#define DIFFUSE_PAST_LEN KQ_PRIVATE_DIFFUSE_PAST_LEN_F64

#endif
