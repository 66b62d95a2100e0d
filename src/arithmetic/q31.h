/*
 * Fixed point: 32-bit words, in rows with an exponent (rows_q31.h), numbers of any size (scaled_q31.h),
 * the mean in 56 bits (mean_q31.h).  Integer operations only; what could lose a bit is in fixed.h, where
 * tests/checked watches it.
 */
#ifndef KQ_SRC_ARITHMETIC_Q31_H
#define KQ_SRC_ARITHMETIC_Q31_H

#include "language.h"
#include "kalmanq/kalmanq.h"
#include "scaled_q31.h"

/* The public name of this arithmetic */
#define T(name) name##_q31

#define KQ_FLOATING 0

typedef int32_t num;

static const scaled num_tiny = {0, 0}; /* a noise of it is none */
static const scaled num_left_over = {0, 0};
static const scaled num_row_rounding = SCALED_POWER(-28); /* of what a row was: entries below it are rounding */
static const scaled num_most_sure = SCALED_POWER(50); /* NIS that says that the sigma is rounding */
enum { num_watched = -58 }; /* 2^-58 of the terms of h'S, squared: the most that an update rounds it by */
static const scaled num_tape_rounding = SCALED_POWER(-58); /* of a filtered sigma, squared: what a measurement leaves in the smoothed one */
static const scaled num_known_exactly = SCALED_POWER(-50); /* the same: a smoothed one below it is rounding */
static const scaled num_most_condition = SCALED_POWER(54); /* of S, squared: above it rounding counts */
static const scaled num_zero_variance = SCALED_POWER(-200); /* words squared: it counts as 0 */
static const scaled num_most_variance = SCALED_POWER(200); /* fading stops there */

/* What tells a number from others, in 32 bits */
static inline uint32_t num_bits(num a) { return (uint32_t)a; }

/* Its bits in 32: one that is turned turns one. */
static inline uint32_t num_folded(num a) { return (uint32_t)a; }

/* After a measurement with r below this share of s the root is matched (filter/match.h). */
static inline scaled low_noise_share(scaled s) { return scaled_shift(s, -8); }

enum { num_loss_bits = 24 }; /* of what rounding takes (filter/rounding.h) */

/* Is s above r > 0 by less than 2^-17 of itself?  Of the cosines 14 bits are left then. */
static inline int is_weak(scaled r, scaled s)
{
    return s.exponent == r.exponent && (uint32_t)s.mantissa - (uint32_t)r.mantissa < 8192;
}

static inline num num_nan(void) { return KQ_NOT_A_VALUE_Q31; }

enum { freeze_bits_max = KQ_FREEZE_BITS_MAX_Q31 };
enum { mean_moves = 1 }; /* no mean is far off */

typedef int64_t score;

/* Lengths of memory, in numbers (kalmanq/) */
#define FILTER_LEN KQ_FILTER_LEN_Q31
#define CONSISTENCY_LEN KQ_CONSISTENCY_LEN_Q31
#define HISTORY_LEN KQ_HISTORY_LEN_Q31
#define HISTORY_CHANGE_LEN KQ_PRIVATE_HISTORY_CHANGE_LEN_Q31
#define HISTORY_WORKSPACE_LEN KQ_PRIVATE_HISTORY_WORKSPACE_LEN_Q31
#define STEADY_LEN KQ_STEADY_LEN_Q31
#define FREEZE_LEN KQ_FREEZE_LEN_Q31
#define MAP_LEN KQ_PRIVATE_MAP_LEN_Q31
#define ON_LINE_LEN KQ_PRIVATE_ON_LINE_LEN_Q31
#define LAG_LEN KQ_LAG_LEN_Q31
#define JACOBIANS_LEN KQ_JACOBIANS_LEN_Q31
#define INSTANT_LEN KQ_INSTANT_LEN_Q31
#define DIFFUSE_LEN KQ_DIFFUSE_LEN_Q31
#define DIFFUSE_RANGE_LEN SCALED_WORDS
#define ADAPTATION_LEN KQ_ADAPTATION_LEN_Q31
#define DIFFUSE_PAST_LEN KQ_PRIVATE_DIFFUSE_PAST_LEN_Q31

#endif
