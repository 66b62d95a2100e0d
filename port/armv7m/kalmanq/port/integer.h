/*
 * Cortex-M3 and up (ARMv7-M, Thumb-2): rounding by the carry that a shift leaves, which compilers
 * do not use.  include/kalmanq/port/integer.h says what each operation is.
 */
#ifndef KALMANQ_PORT_INTEGER_H
#define KALMANQ_PORT_INTEGER_H

#include <stdint.h>

static inline uint32_t upper_word(uint64_t a) { return (uint32_t)(a >> 32); }

/*
 * Where the loops are unrolled, gcc shares the sign extension of a factor and makes a 64 x 64 bit
 * product of it; elsewhere it knows SMULL and SMLAL better than this.
 */
#ifdef KQ_SIZES_ARE_CONSTANT
KQ_KERNEL int64_t product(int32_t a, int32_t b)
{
    int64_t p;
    __asm("smull %Q0, %R0, %1, %2" : "=r"(p) : "r"(a), "r"(b));
    return p;
}

KQ_KERNEL int64_t multiply_add(int64_t total, int32_t a, int32_t b)
{
    __asm("smlal %Q0, %R0, %1, %2" : "+r"(total) : "r"(a), "r"(b));
    return total;
}
#else
KQ_KERNEL int64_t product(int32_t a, int32_t b) { return (int64_t)a * b; }

KQ_KERNEL int64_t multiply_add(int64_t total, int32_t a, int32_t b)
{
    return total + (int64_t)a * b;
}
#endif

KQ_KERNEL uint64_t product_unsigned(uint32_t a, uint32_t b) { return (uint64_t)a * b; }

KQ_KERNEL uint32_t product_high(uint32_t a, uint32_t b)
{
    return (uint32_t)(((uint64_t)a * b) >> 32);
}

KQ_KERNEL int32_t shift_rounded(int32_t a, int shift)
{
    __asm("asrs %0, %0, %1\n\t"
          "adc %0, %0, #0"
          : "+r"(a)
          : "rI"(shift)
          : "cc");
    return a;
}

/* Where the shift is known: 1 .. 31 */
KQ_KERNEL int32_t shift_rounded_wide(int64_t a, int shift)
{
    if (!__builtin_constant_p(shift) || shift > 31) {
        return (int32_t)((a + (INT64_C(1) << (shift - 1))) >> shift);
    }
    uint32_t low = (uint32_t)a;
    const uint32_t high = (uint32_t)((uint64_t)a >> 32);
    __asm("lsrs %0, %0, %2\n\t"
          "adc %0, %0, %1, lsl %3"
          : "+r"(low)
          : "r"(high), "I"(shift), "I"(32 - shift)
          : "cc");
    return (int32_t)low;
}

/*
 * Those of products, in one piece, of which one register is left: gcc moves pairs of registers about.
 */
KQ_KERNEL int32_t product_rounded(int32_t a, int32_t b, int shift)
{
    if (__builtin_constant_p(shift) && shift <= 31) {
        uint32_t low, high;
        __asm("smull %0, %1, %2, %3\n\t"
              "lsrs %0, %0, %4\n\t"
              "adc %0, %0, %1, lsl %5"
              : "=&r"(low), "=&r"(high)
              : "r"(a), "r"(b), "I"(shift), "I"(32 - shift)
              : "cc");
        return (int32_t)low;
    }
    return shift_rounded_wide(product(a, b), shift);
}

KQ_KERNEL int32_t products_rounded(int32_t a, int32_t b, int32_t c, int32_t d, int shift)
{
    if (__builtin_constant_p(shift) && shift <= 31) {
        uint32_t low, high;
        __asm("smull %0, %1, %2, %3\n\t"
              "smlal %0, %1, %4, %5\n\t"
              "lsrs %0, %0, %6\n\t"
              "adc %0, %0, %1, lsl %7"
              : "=&r"(low), "=&r"(high)
              : "r"(a), "r"(b), "r"(c), "r"(d), "I"(shift), "I"(32 - shift)
              : "cc");
        return (int32_t)low;
    }
    return shift_rounded_wide(multiply_add(product(a, b), c, d), shift);
}

static inline int64_t shift_rounded_long(int64_t a, int shift)
{
    uint32_t low = (uint32_t)a;
    int32_t high = (int32_t)((uint64_t)a >> 32);
    const uint32_t down = (uint32_t)high << (32 - shift);
    __asm("asr %1, %1, %3\n\t"
          "lsrs %0, %0, %3\n\t"
          "orr %0, %0, %2\n\t" /* leaves the carry */
          "adcs %0, %0, #0\n\t"
          "adc %1, %1, #0"
          : "+&r"(low), "+&r"(high)
          : "r"(down), "rI"(shift)
          : "cc");
    return (int64_t)((uint64_t)(uint32_t)high << 32 | low);
}

static inline uint32_t quotient(uint32_t d) { return UINT32_MAX / d; }

#endif
