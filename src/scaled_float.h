/*
 * Numbers of any size in floating point: every number is one.  scaled_q31.h has the same
 * operations in integers.
 */
#ifndef KALMANQ_SCALED_FLOAT_H
#define KALMANQ_SCALED_FLOAT_H

typedef num scaled;

static const scaled scaled_one = 1;

static inline scaled scaled_normal(scaled a) { return a; }
static inline scaled scaled_count(int32_t a) { return (num)a; }
static inline int scaled_is_zero(scaled a) { return a == 0; }
/* Does a factor of a leave every bit as it is? */
static inline int scaled_is_unit(scaled a) { return a == 1; }
static inline int scaled_is_negative(scaled a) { return a < 0; }
static inline scaled scaled_of_count(int32_t count) { return (num)count; }
static inline scaled scaled_negative(scaled a) { return -a; }
static inline scaled scaled_times(scaled a, scaled b) { return a * b; }
static inline scaled scaled_over(scaled a, scaled b) { return a / b; }
static inline scaled scaled_plus(scaled a, scaled b) { return a + b; }
static inline scaled scaled_minus(scaled a, scaled b) { return a - b; }
static inline scaled scaled_root(scaled a) { return num_root(a); }
static inline int scaled_is_less(scaled a, scaled b) { return a < b; }
static inline num word_of(scaled a) { return a; }
static inline scaled scaled_of_word(num a) { return a; }

/* a 2^shift, shift <= 0 */
static inline scaled scaled_shift(scaled a, int32_t shift)
{
    for (; shift < 0; shift++) a *= num_half;
    return a;
}

#endif
