/*
 * Fixed point: the integer operations that the q31 arithmetic is made of.
 *
 * Every operation that changes a scale is told the bound of its result: `bits` promises
 * |result| <= 2^bits.  Here the promise costs nothing; tests/checked/fixed.h has the same
 * operations and stops the program where one is not kept, or where a bit is lost on the left.
 *
 * What rounds, each time to nearest:
 *
 *   round_to_word              64 bits to a word          round_product_to_word    a b
 *   shift_down_rounded         a word                     round_products_to_word   a b + c d
 *   shift_down_rounded_wide    64 bits
 *
 * shift_up, shift_up_wide, shift_up_word, sum_of and accumulate are exact.
 *
 * Right shifts of negative numbers are arithmetic, as on every compiler for these targets.
 */
#ifndef KQ_SRC_ARITHMETIC_FIXED_H
#define KQ_SRC_ARITHMETIC_FIXED_H

#include "compiler.h"
#include "kalmanq/port/integer.h"

_Static_assert((-3 >> 1) == -2, "kalmanq needs arithmetic right shifts");

static inline uint32_t magnitude(int32_t a) { return a < 0 ? 0 - (uint32_t)a : (uint32_t)a; }

/* a 2^-shift rounded to nearest, 1 <= shift <= 62 */
KQ_KERNEL int32_t round_to_word(int64_t a, int shift, int bits)
{
    (void)bits;
    return shift_rounded_wide(a, shift);
}

/* a b 2^-shift and (a b + c d) 2^-shift, rounded to nearest; the sum is below 2^62 */
KQ_KERNEL int32_t round_product_to_word(int32_t a, int32_t b, int shift, int bits)
{
    (void)bits;
    return product_rounded(a, b, shift);
}

KQ_KERNEL int32_t round_products_to_word(int32_t a, int32_t b, int32_t c, int32_t d, int shift,
                                         int bits)
{
    (void)bits;
    return products_rounded(a, b, c, d, shift);
}

/* a 2^-shift rounded to nearest, for any shift >= 0: never larger than a */
static inline int32_t shift_down_rounded(int32_t a, int32_t shift)
{
    if (shift == 0) return a;
    return shift > 31 ? 0 : shift_rounded(a, (int)shift);
}

/* shift_down_rounded_wide by 0, or by 32 and more */
KQ_COLD KQ_NOINLINE static int64_t shift_far_rounded(int64_t a, int32_t shift)
{
    if (shift == 0) return a;
    return shift > 63 ? 0 : ((a >> (shift - 1)) + 1) >> 1;
}

/* a 2^-shift rounded to nearest, |a| < 2^63 - 1; most shifts are below 32, and cost a 32-bit core less */
static inline int64_t shift_down_rounded_wide(int64_t a, int32_t shift)
{
    return shift > 0 && shift < 32 ? shift_rounded_long(a, (int)shift) : shift_far_rounded(a, shift);
}

/* a 2^shift, 0 <= shift <= 31 (63) */
KQ_KERNEL int32_t shift_up(int32_t a, int shift, int bits)
{
    (void)bits;
    return (int32_t)((uint32_t)a << shift);
}

KQ_KERNEL int64_t shift_up_wide(int64_t a, int shift, int bits)
{
    (void)bits;
    return (int64_t)((uint64_t)a << shift);
}

/* One word as 64 bits, a 2^shift, 0 <= shift <= 31, |a 2^shift| <= 2^bits */
KQ_KERNEL int64_t shift_up_word(int32_t a, int shift, int bits)
{
    (void)bits;
    const uint32_t high = (uint32_t)(a >> 1 >> (31 - shift));
    return (int64_t)((uint64_t)high << 32 | (uint32_t)a << shift);
}

/* a + b; |a + b| <= 2^bits */
KQ_KERNEL int64_t sum_of(int64_t a, int64_t b, int bits)
{
    (void)bits;
    return a + b;
}

/* total + a b; |total + a b| <= 2^bits */
KQ_KERNEL int64_t accumulate(int64_t total, int32_t a, int32_t b, int bits)
{
    (void)bits;
    return multiply_add(total, a, b);
}

#endif
