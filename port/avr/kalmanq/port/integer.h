/*
 * AVR with a multiplier: avr-gcc makes a product of 64 bits of four calls, and shifts 64 bits in
 * loops. Out of line, since each of these is dozens of instructions. include/kalmanq/port/integer.h
 * says what each operation is.
 */
#ifndef KALMANQ_PORT_INTEGER_H
#define KALMANQ_PORT_INTEGER_H

#include <stdint.h>

/* avr-gcc calls a loop for the shift. */
static inline uint32_t upper_word(uint64_t a)
{
    const union {
        uint64_t whole;
        uint32_t word[2];
    } parts = {.whole = a};
    return parts.word[1];
}

#define KQ_OUT_OF_LINE __attribute__((noinline, unused)) static

/* 64 bits in parts, which are not shifted out one bit at a time */
typedef union {
    uint64_t whole;
    uint32_t word[2];
    uint8_t byte[8];
} kq_parts;

#define KQ_ADD_PRODUCT(a, b, to, next, last)                                                       \
    "mul %" a ", %" b "\n\t"                                                                       \
    "add %" to ", r0\n\t"                                                                          \
    "adc %" next ", r1\n\t"                                                                        \
    "adc %" last ", %2\n\t"

/* Column by column: what starts at byte k is four products and what was carried there, and ends in
   byte k + 2. */
static inline __attribute__((always_inline)) kq_parts multiplied(uint32_t a, uint32_t b)
{
    kq_parts all;
    uint32_t low, high;
    uint8_t zero;
    /* clang-format off */
    __asm("clr %2\n\t"
          "mul %A3, %A4\n\t"
          "movw %A0, r0\n\t"
          "clr %C0\n\t"
          "clr %D0\n\t"
          "movw %A1, %C0\n\t"
          "movw %C1, %C0\n\t"
          KQ_ADD_PRODUCT("A3", "B4", "B0", "C0", "D0")
          KQ_ADD_PRODUCT("B3", "A4", "B0", "C0", "D0")
          KQ_ADD_PRODUCT("A3", "C4", "C0", "D0", "A1")
          KQ_ADD_PRODUCT("B3", "B4", "C0", "D0", "A1")
          KQ_ADD_PRODUCT("C3", "A4", "C0", "D0", "A1")
          KQ_ADD_PRODUCT("A3", "D4", "D0", "A1", "B1")
          KQ_ADD_PRODUCT("B3", "C4", "D0", "A1", "B1")
          KQ_ADD_PRODUCT("C3", "B4", "D0", "A1", "B1")
          KQ_ADD_PRODUCT("D3", "A4", "D0", "A1", "B1")
          KQ_ADD_PRODUCT("B3", "D4", "A1", "B1", "C1")
          KQ_ADD_PRODUCT("C3", "C4", "A1", "B1", "C1")
          KQ_ADD_PRODUCT("D3", "B4", "A1", "B1", "C1")
          KQ_ADD_PRODUCT("C3", "D4", "B1", "C1", "D1")
          KQ_ADD_PRODUCT("D3", "C4", "B1", "C1", "D1")
          "mul %D3, %D4\n\t"
          "add %C1, r0\n\t"
          "adc %D1, r1\n\t"
          "clr __zero_reg__"
          : "=&r"(low), "=&r"(high), "=&r"(zero)
          : "r"(a), "r"(b));
    /* clang-format on */
    all.word[0] = low;
    all.word[1] = high;
    return all;
}

KQ_OUT_OF_LINE int64_t product(int32_t a, int32_t b)
{
    kq_parts all = multiplied((uint32_t)a, (uint32_t)b);
    if (a < 0) all.word[1] -= (uint32_t)b;
    if (b < 0) all.word[1] -= (uint32_t)a;
    return (int64_t)all.whole;
}

KQ_OUT_OF_LINE uint64_t product_unsigned(uint32_t a, uint32_t b) { return multiplied(a, b).whole; }

KQ_OUT_OF_LINE uint32_t product_high(uint32_t a, uint32_t b) { return multiplied(a, b).word[1]; }

/* Whole bytes first: a loop over bits is what avr-gcc makes of it */
KQ_OUT_OF_LINE int32_t shift_rounded(int32_t a, int shift)
{
    uint8_t left = (uint8_t)(shift - 1);
    for (; left >= 8; left = (uint8_t)(left - 8)) a >>= 8;
    a >>= left;
    return (a >> 1) + (a & 1);
}

/* By 31 and by 30, which is nearly all: the upper word, up, and what the lower one's highest bits
 * make */
KQ_OUT_OF_LINE int32_t shift_rounded_31(uint64_t a)
{
    const kq_parts all = {.whole = a};
    return (int32_t)((all.word[1] << 1) + (uint8_t)(((all.byte[3] >> 6) + 1) >> 1));
}

KQ_OUT_OF_LINE int32_t shift_rounded_30(uint64_t a)
{
    const kq_parts all = {.whole = a};
    return (int32_t)((all.word[1] << 2) + (uint8_t)(((all.byte[3] >> 5) + 1) >> 1));
}

static inline __attribute__((always_inline)) int32_t shift_rounded_wide(int64_t a, int shift)
{
    if (shift == 31) return shift_rounded_31((uint64_t)a);
    if (shift == 30) return shift_rounded_30((uint64_t)a);
    return (int32_t)((a + (INT64_C(1) << (shift - 1))) >> shift);
}

/* |a| is below 2^63 - 1, and the shift that the C library has moves bytes first. */
KQ_OUT_OF_LINE int64_t shift_rounded_long(int64_t a, int shift)
{
    a >>= shift - 1;
    return (a >> 1) + ((uint8_t)a & 1);
}

static inline uint32_t quotient(uint32_t d) { return UINT32_MAX / d; }

static inline int64_t multiply_add(int64_t total, int32_t a, int32_t b)
{
    return total + product(a, b);
}

/* shift_rounded_wide of products, and of the sum of two */
KQ_KERNEL int32_t product_rounded(int32_t a, int32_t b, int shift)
{
    return shift_rounded_wide(product(a, b), shift);
}

KQ_KERNEL int32_t products_rounded(int32_t a, int32_t b, int32_t c, int32_t d, int shift)
{
    return shift_rounded_wide(multiply_add(product(a, b), c, d), shift);
}

#endif
