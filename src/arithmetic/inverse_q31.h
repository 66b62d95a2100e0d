/*
 * 1 / sqrt(v) and 1 / v of normalised 32-bit numbers, correct to about one part in 2^31:
 * a table or a short division for the first digits, then Newton's steps.
 */
#ifndef KQ_SRC_ARITHMETIC_INVERSE_Q31_H
#define KQ_SRC_ARITHMETIC_INVERSE_Q31_H

#include "compiler.h"
#include "kalmanq/port/integer.h"

static inline int leading_zeros_wide(uint64_t a)
{
    const uint32_t high = upper_word(a);
    return high ? leading_zeros(high) : 32 + leading_zeros((uint32_t)a);
}

/* The upper word of a 2^zeros, a != 0 having so many leading zeros, or one more */
static inline uint32_t upper_word_raised(uint64_t a, int zeros)
{
    const uint32_t high = upper_word(a), low = (uint32_t)a;
    if (high == 0) return low << (zeros - 32);
    return high << zeros | low >> 1 >> (31 - zeros);
}

/* round(256 / sqrt((k + 16.5) / 64)) - 256 */
static const uint8_t inverse_root_start[48] = {
    248, 234, 220, 208, 196, 186, 176, 166, 158, 150, 142, 135, 128, 121, 115, 109,
    103, 98,  93,  88,  83,  78,  74,  70,  66,  62,  58,  55,  51,  48,  44,  41,
    38,  35,  32,  29,  27,  24,  21,  19,  16,  14,  12,  10,  7,   5,   3,   1};

/* y + (y/2) error 2^-(32 + shift), rounded; the upper word of the product is enough for that.  What
   it comes to is 2^30 or more, or has wrapped: then it is held just below 2^32. */
static inline uint32_t improved(uint32_t y, int32_t error, int shift)
{
    const int32_t more = (int32_t)upper_word((uint64_t)product((int32_t)(y >> 1), error));
    const uint32_t next = y + (uint32_t)shift_rounded(more, shift);
    return next < UINT32_C(1) << 30 ? UINT32_MAX : next;
}

/*
 * y = 1 / sqrt(v 2^-32) in Q31, for 2^30 <= v < 2^32: 2^31 <= y < 2^32 (1/sqrt(1/4) = 2 is held
 * just below).  y <- y + y (1 - v y^2) / 2, each step doubling 6 bits, 11, 22.
 */
KQ_SHARED uint32_t inverse_root(uint32_t v)
{
    uint32_t y = inverse_root_start[(v >> 26) - 16] + UINT32_C(256);        /* Q8, y <= 504 */
    const uint32_t square8 = ((y * y >> 3) * (v >> 17)) >> 9;               /* v y^2: Q19, < 2^20 */
    const int32_t error8 = (int32_t)(UINT32_C(1) << 19) - (int32_t)square8; /* < 2^14 */
    y = (y << 8) + (uint32_t)(((int32_t)y * error8) >> 12); /* Q16, to 11 bits; <= 0x1ffd0 */
    y &= ~UINT32_C(3); /* so that a quarter of y^2, below 2^32, is exact */

    const uint32_t square16 = product_high(y * (y >> 2), v);           /* v y^2: Q30 */
    const int32_t error16 = (int32_t)((UINT32_C(1) << 30) - square16); /* < 2^20 */
    y <<= 15;                                                          /* Q31 */
    y += (uint32_t)(((int32_t)(y >> 16) * (error16 >> 6)) >> 9);       /* to 21 bits */

    const uint64_t square = product_unsigned(y, y);
    const uint32_t square31 = upper_word(square) + ((uint32_t)square >> 31);
    const int64_t error31 =
        (INT64_C(1) << 62) - (int64_t)product_unsigned(square31, v); /* < 2^42 */
    return improved(y, (int32_t)(error31 >> 12), 18);
}

/* sqrt(v 2^-32) in Q31 from that, truncated: v y = sqrt(v) */
static inline uint32_t root_by_inverse(uint32_t v, uint32_t y) { return product_high(v, y); }

/* 2^63 / d for 2^31 <= d < 2^32, held below 2^32 */
KQ_SHARED uint32_t reciprocal(uint32_t d)
{
    uint32_t y = quotient(d >> 16) << 15; /* to 15 bits; the quotient is below 2^17 */
    for (int k = 0; k < 2; k++) {
        const int64_t error = (int64_t)((UINT64_C(1) << 63) - product_unsigned(y, d)); /* < 2^49 */
        y = improved(y, (int32_t)(error >> 19), 11);
    }
    return y;
}

#endif
