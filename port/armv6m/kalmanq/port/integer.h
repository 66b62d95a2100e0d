/*
 * Cortex-M0 and M0+ (ARMv6-M): it multiplies 32 bits by 32 into 32, so that a product of 64 bits is
 * four of halves.  include/kalmanq/port/integer.h says what each operation is.
 *
 * Functions of assembly are called from assembly, which tells the compiler what they leave alone:
 * more than C's convention does.
 */
#ifndef KALMANQ_PORT_INTEGER_H
#define KALMANQ_PORT_INTEGER_H

#include <stdint.h>

static inline uint32_t upper_word(uint64_t a) { return (uint32_t)(a >> 32); }

#define KQ_ASSEMBLY __attribute__((naked, noinline, unused)) static void

/* r1:r0 <- r0 r1; r2, r3 and r4 are lost */
KQ_ASSEMBLY kq_product(void)
{
    __asm(".syntax unified\n\t"
          "uxth r2, r0\n\t"
          "asrs r3, r0, #16\n\t"
          "uxth r0, r1\n\t"
          "asrs r1, r1, #16\n\t"
          "mov r4, r2\n\t"
          "muls r4, r1, r4\n\t"
          "muls r1, r3, r1\n\t"
          "muls r3, r0, r3\n\t"
          "muls r0, r2, r0\n\t"
          "lsls r2, r4, #16\n\t" /* each mixed product fits a signed word */
          "asrs r4, r4, #16\n\t"
          "adds r0, r0, r2\n\t"
          "adcs r1, r1, r4\n\t"
          "lsls r2, r3, #16\n\t"
          "asrs r3, r3, #16\n\t"
          "adds r0, r0, r2\n\t"
          "adcs r1, r1, r3\n\t"
          "bx lr");
}

/* The same, unsigned */
KQ_ASSEMBLY kq_product_unsigned(void)
{
    __asm(".syntax unified\n\t"
          "uxth r2, r0\n\t"
          "lsrs r3, r0, #16\n\t"
          "uxth r0, r1\n\t"
          "lsrs r1, r1, #16\n\t"
          "mov r4, r2\n\t"
          "muls r4, r1, r4\n\t"
          "muls r1, r3, r1\n\t"
          "muls r3, r0, r3\n\t"
          "muls r0, r2, r0\n\t"
          "lsls r2, r4, #16\n\t"
          "lsrs r4, r4, #16\n\t"
          "adds r0, r0, r2\n\t"
          "adcs r1, r1, r4\n\t"
          "lsls r2, r3, #16\n\t"
          "lsrs r3, r3, #16\n\t"
          "adds r0, r0, r2\n\t"
          "adcs r1, r1, r3\n\t"
          "bx lr");
}

static inline int64_t product(int32_t a, int32_t b)
{
    register int32_t low __asm("r0") = a;
    register int32_t high __asm("r1") = b;
    __asm("bl %c2" : "+r"(low), "+r"(high) : "i"(kq_product) : "r2", "r3", "r4", "lr", "cc");
    return (int64_t)((uint64_t)(uint32_t)high << 32 | (uint32_t)low);
}

static inline uint64_t product_unsigned(uint32_t a, uint32_t b)
{
    register uint32_t low __asm("r0") = a;
    register uint32_t high __asm("r1") = b;
    __asm("bl %c2"
          : "+r"(low), "+r"(high)
          : "i"(kq_product_unsigned)
          : "r2", "r3", "r4", "lr", "cc");
    return (uint64_t)high << 32 | low;
}

static inline uint32_t product_high(uint32_t a, uint32_t b)
{
    return (uint32_t)(product_unsigned(a, b) >> 32);
}

static inline int32_t shift_rounded(int32_t a, int shift)
{
    __asm(".syntax unified\n\t"
          "asrs %0, %0, %1\n\t" /* leaves the half in the carry */
          "adcs %0, %0, %2"
          : "+&l"(a)
          : "l"(shift), "l"(0)
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
    const uint32_t high = (uint32_t)((uint64_t)a >> 32) << (32 - shift);
    __asm(".syntax unified\n\t"
          "lsrs %0, %0, %2\n\t"
          "adcs %0, %0, %1"
          : "+&l"(low)
          : "l"(high), "I"(shift)
          : "cc");
    return (int32_t)low;
}

static inline int64_t shift_rounded_long(int64_t a, int shift)
{
    uint32_t low = (uint32_t)a, zero = 0;
    int32_t high = (int32_t)((uint64_t)a >> 32);
    const uint32_t down = (uint32_t)high << (32 - shift);
    __asm(".syntax unified\n\t"
          "asrs %1, %1, %4\n\t"
          "lsrs %0, %0, %4\n\t"
          "adcs %0, %0, %3\n\t" /* carries only if all below bit 32 was 1 */
          "adcs %1, %1, %2"
          : "+&l"(low), "+&l"(high)
          : "l"(zero), "l"(down), "l"(shift)
          : "cc");
    return (int64_t)((uint64_t)(uint32_t)high << 32 | low);
}

/* Newton's steps from a straight line: its error of 0.086 is squared by each.  The last one's and
   what the shifts leave out is a few units, which the remainder shows. */
static inline uint32_t quotient(uint32_t d)
{
    uint32_t y = 190990 - 2 * d;
    for (int k = 0; k < 3; k++) {
        y += (uint32_t)((int32_t)y * ((int32_t)(0 - d * y) >> 15) >> 17); /* < 2^17 2^14 */
    }
    int32_t rest = (int32_t)(UINT32_MAX - d * y);
    while (rest < 0) {
        y--;
        rest += (int32_t)d;
    }
    while (rest >= (int32_t)d) {
        y++;
        rest -= (int32_t)d;
    }
    return y;
}

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
