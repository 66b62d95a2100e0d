/*
 * Numbers of any size in floating point: every number is one.  scaled_q31.h has the same
 * operations in integers.
 */
#ifndef KQ_SRC_ARITHMETIC_SCALED_FLOAT_H
#define KQ_SRC_ARITHMETIC_SCALED_FLOAT_H

#include <stdint.h>

#include "arithmetic.h"

typedef num scaled;

static inline uint32_t scaled_bits(scaled a) { return num_bits(a); }

static const scaled scaled_one = 1;

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

static inline scaled scaled_products(scaled a, scaled b, scaled c, scaled d)
{
    return a * b + c * d;
}

static inline scaled scaled_root(scaled a) { return num_root(a); }
static inline scaled scaled_of_word(num a) { return a; }
static inline int scaled_is_less(scaled a, scaled b) { return a < b; }
static inline scaled scaled_magnitude(scaled a) { return num_magnitude(a); }
static inline int scaled_is_finite(scaled a) { return num_is_finite(a); }

/* More than an operation rounds a number by, of its size: 16 units, as in rounding_floor */
static inline scaled scaled_rounding(void) { return 16 * num_epsilon; }

/* Within num_tiny .. 1 / num_tiny, so that squares of ratios stay numbers; below it, 0 */
static inline scaled scaled_held(scaled a)
{
    const scaled size = num_magnitude(a), most = 1 / num_tiny;
    if (size < num_tiny) return 0;
    if (size > most) return a < 0 ? -most : most;
    return a;
}

static inline num word_of(scaled a) { return a; }

/* *word <- a; answers the events, here none */
static inline unsigned word_take(num *word, scaled a)
{
    *word = a;
    return 0;
}

#endif
