/*
 * Numbers of twice the digits, high + low: for differences that leave little of their terms (Dekker, Numer. Math. 18,
 * 1971).  An operation rounds by about eps^2.
 */
#ifndef KQ_SRC_ARITHMETIC_PAIR_FLOAT_H
#define KQ_SRC_ARITHMETIC_PAIR_FLOAT_H

#include "scaled_float.h"

typedef struct {
    num high, low;
} num_pair;

static inline num_pair pair_of(num a) { return (num_pair){a, 0}; }

/* high + low, where low may be the larger one */
static inline num_pair pair_sum(num high, num low)
{
    const num total = high + low, part = total - high;
    return (num_pair){total, (high - (total - part)) + (low - part)};
}

/* By itself, so that no compiler fuses it with the sums that say how it was rounded */
KQ_COLD KQ_NOINLINE static num rounded_product(num a, num b) { return a * b; }

/* a b and what rounding has left of it: products of halves are exact. */
static inline num_pair pair_product(num a, num b)
{
    const num product = rounded_product(a, b), a_high = num_upper_half(a), b_high = num_upper_half(b);
    const num a_low = a - a_high, b_low = b - b_high;
    return (num_pair){product, a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low)};
}

/* a - b c */
KQ_COLD KQ_NOINLINE static num_pair pair_less_product(num_pair a, num_pair b, num_pair c)
{
    const num_pair product = pair_product(b.high, c.high), rest = pair_sum(a.high, -product.high);
    return pair_sum(rest.high, rest.low + (a.low - (product.low + (b.high * c.low + b.low * c.high))));
}

/* a / b */
KQ_COLD static num_pair pair_over(num_pair a, num_pair b)
{
    const num_pair most = pair_of(a.high / b.high);
    return pair_sum(most.high, pair_less_product(a, most, b).high / b.high);
}

#endif
