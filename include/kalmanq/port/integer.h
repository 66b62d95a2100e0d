/*
 * The integer operations that a core may do better than C says them: the portable form.  A
 * directory of port/ that comes before this one on the include path replaces it (port/README.md);
 * results are the same bits.  Not for callers of the library.
 */
#ifndef KALMANQ_PORT_INTEGER_H
#define KALMANQ_PORT_INTEGER_H

#include <stdint.h>

/* The upper word of 64 bits */
static inline uint32_t upper_word(uint64_t a) { return (uint32_t)(a >> 32); }

KQ_KERNEL int64_t product(int32_t a, int32_t b) { return (int64_t)a * b; }

KQ_KERNEL int64_t multiply_add(int64_t total, int32_t a, int32_t b)
{
    return total + (int64_t)a * b;
}

KQ_KERNEL uint64_t product_unsigned(uint32_t a, uint32_t b) { return (uint64_t)a * b; }

/* The upper word of that */
KQ_KERNEL uint32_t product_high(uint32_t a, uint32_t b)
{
    return (uint32_t)(((uint64_t)a * b) >> 32);
}

/* a 2^-shift rounded to nearest, halves up, 1 <= shift <= 31 */
KQ_KERNEL int32_t shift_rounded(int32_t a, int shift)
{
    return (a >> shift) + (a >> (shift - 1) & 1);
}

/* The same of a product, as a word */
KQ_KERNEL int32_t shift_rounded_wide(int64_t a, int shift)
{
    return (int32_t)((a + (INT64_C(1) << (shift - 1))) >> shift);
}

/* Those of products, and of the sum of two */
KQ_KERNEL int32_t product_rounded(int32_t a, int32_t b, int shift)
{
    return shift_rounded_wide(product(a, b), shift);
}

KQ_KERNEL int32_t products_rounded(int32_t a, int32_t b, int32_t c, int32_t d, int shift)
{
    return shift_rounded_wide(multiply_add(product(a, b), c, d), shift);
}

/* The same of any number below 2^63 - 1, 1 <= shift <= 31 */
static inline int64_t shift_rounded_long(int64_t a, int shift)
{
    const uint32_t low = (uint32_t)a, high = (uint32_t)((uint64_t)a >> 32);
    const uint32_t moved = low >> shift | high << (32 - shift);
    const int32_t top = (int32_t)high >> shift;
    return (int64_t)((uint64_t)(int64_t)top << 32 | moved) + (low >> (shift - 1) & 1);
}

/* (2^32 - 1) / d for 2^15 <= d < 2^16 */
static inline uint32_t quotient(uint32_t d) { return UINT32_MAX / d; }

#endif
