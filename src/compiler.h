/* What C11 cannot say. */
#ifndef KALMANQ_COMPILER_H
#define KALMANQ_COMPILER_H

#include <stdint.h>

/* Keeps a function's large scratch array off the stack of its caller.  Without it the library
   is as right, and its stack is deeper. */
#if defined(__GNUC__)
#define KQ_NOINLINE __attribute__((noinline))
#else
#define KQ_NOINLINE
#endif

/* A kernel that is to be compiled for the sizes it is called with, unless memory counts more. */
#if defined(__GNUC__) && !defined(__OPTIMIZE_SIZE__)
#define KQ_INLINE static inline __attribute__((always_inline))
#else
#define KQ_INLINE static inline
#endif

/* Up to how many states a step has code of its own: none where memory counts more than time. */
#if defined(__OPTIMIZE_SIZE__)
#define KQ_STATES_APART 0
#else
#define KQ_STATES_APART 3
#endif

/* Before a loop over states: where the sizes are constants (fixed_sizes.h) it is unrolled. */
#ifndef KQ_UNROLL
#define KQ_UNROLL
#endif

/* A function with scratch of its own, inline where the sizes are constants. */
#ifndef KQ_APART
#define KQ_APART KQ_NOINLINE static
#endif

/* Zeros above the highest bit that is set; 32 for 0. */
static inline int leading_zeros(uint32_t a)
{
#if defined(__GNUC__)
    return a ? (sizeof(unsigned) >= 4
                    ? __builtin_clz((unsigned)a) - (int)(8 * sizeof(unsigned) - 32)
                    : __builtin_clzl((unsigned long)a))
             : 32;
#else
    int zeros = 32;
    for (; a; a >>= 1) zeros--;
    return zeros;
#endif
}

/* The upper word of 64 bits; avr-gcc calls a loop for the shift. */
static inline uint32_t upper_word(uint64_t a)
{
#if defined(__AVR__)
    const union {
        uint64_t whole;
        uint32_t word[2];
    } parts = {.whole = a};
    return parts.word[1];
#else
    return (uint32_t)(a >> 32);
#endif
}

static inline int leading_zeros_wide(uint64_t a)
{
    const uint32_t high = upper_word(a);
    return high ? leading_zeros(high) : 32 + leading_zeros((uint32_t)a);
}

#endif
