/*
 * Numbers of any size in floating point: every number is one.  scaled_q31.h has the same
 * operations in integers.
 */
#ifndef KQ_SRC_ARITHMETIC_SCALED_FLOAT_H
#define KQ_SRC_ARITHMETIC_SCALED_FLOAT_H

#ifndef T
#include "f32.h"
#endif
#include "compiler.h"

typedef num scaled;

static inline uint32_t scaled_bits(scaled a) { return num_bits(a); }

static const scaled scaled_one = 1;

static inline scaled scaled_zero(void) { return 0; }

static inline scaled scaled_negative(scaled a) { return -a; }
static inline scaled scaled_normal(scaled a) { return a; }
static inline int scaled_is_zero(scaled a) { return a == 0; }

/* Does a factor of a leave every bit as it is? */
static inline int scaled_is_unit(scaled a) { return a == 1; }
static inline int scaled_is_negative(scaled a) { return a < 0; }
static inline scaled scaled_of_count(int32_t count) { return (num)count; }

/* a 2^shift, shift <= 0 */
static inline scaled scaled_shift(scaled a, int32_t shift)
{
    for (; shift < 0; shift++) a *= num_half;
    return a;
}

static inline scaled scaled_times(scaled a, scaled b) { return a * b; }
static inline scaled scaled_over(scaled a, scaled b) { return a / b; }
static inline scaled scaled_plus(scaled a, scaled b) { return a + b; }
static inline scaled scaled_minus(scaled a, scaled b) { return a - b; }
static inline void scaled_add(scaled *total, const scaled *a) { *total += *a; }
static inline void scaled_add_times(scaled *total, const scaled *a, const scaled *b) { *total += *a * *b; }

static inline scaled scaled_products(scaled a, scaled b, scaled c, scaled d)
{
    return a * b + c * d;
}

static inline scaled scaled_add_square(scaled total, scaled a) { return total + a * a; }
static inline scaled scaled_root(scaled a) { return num_root(a); }
static inline scaled scaled_of_word(num a) { return a; }
static inline int scaled_is_less(scaled a, scaled b) { return a < b; }

/* floor(log2 |a|), least for a = 0 */
static inline int32_t scaled_log(scaled a)
{
    const uint32_t biased = num_top_bits(a) << 1 >> (32 - num_exponent_bits);
    return (int32_t)biased - ((1 << (num_exponent_bits - 1)) - 1);
}

static inline scaled scaled_magnitude(scaled a) { return num_magnitude(a); }
static inline int scaled_is_finite(scaled a) { return num_is_finite(a); }

/* More than an operation rounds a number by, of its size: 16 units, as in rounding_floor */
static inline scaled scaled_rounding(void) { return 16 * num_epsilon; }

/* Within num_tiny .. 1 / num_tiny, so that squares of ratios stay numbers; below it, 0 */
static inline scaled scaled_saturated(scaled a)
{
    const scaled size = num_magnitude(a), most = 1 / num_tiny;
    if (size < num_tiny) return 0;
    if (size > most) return a < 0 ? -most : most;
    return a;
}

static inline num word_of(scaled a) { return a; }

/*
 * How far numbers reach, found on the way: joined over the entries of a root and over the means, it tells
 * whether one may be beyond num_most_sigma, or is not a number.
 */
#if KQ_FLOAT_BITS >= KQ_NUM_BITS

/* A sum of squares */
typedef num extent;

KQ_KERNEL extent extent_of(num a) { return a * a; }

KQ_KERNEL extent extent_join(extent a, extent b) { return a + b; }

KQ_KERNEL int extent_is_within(extent far)
{
    return !num_exceeds(far, num_most_sigma * num_most_sigma);
}

#else

/* The core has no such numbers: the highest bit is set where one may be a quarter of num_most_sigma or more,
   which 16 entries make a row of it. */
typedef uint32_t extent;

KQ_KERNEL extent extent_of(num a)
{
    const uint32_t sign = UINT32_C(1) << 31;
    return (num_top_bits(a) & ~sign) + (sign - num_top_bits(num_most_sigma / 4));
}

KQ_KERNEL extent extent_join(extent a, extent b) { return a | b; }

KQ_KERNEL int extent_is_within(extent far) { return far >> 31 == 0; }

#endif

#endif
