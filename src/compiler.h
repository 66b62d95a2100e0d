/* What C11 cannot say. */
#ifndef KALMANQ_COMPILER_H
#define KALMANQ_COMPILER_H

#include <limits.h>
#include <stdint.h>

/* Keeps a function's large scratch array off the stack of its caller.  Without it the library
   is as right, and its stack is deeper. */
#if defined(__GNUC__)
#define KQ_NOINLINE __attribute__((noinline))
#else
#define KQ_NOINLINE
#endif

/* Off the ordinary path (init, errors, what is unusual): compiled for size at every level. */
#if defined(__clang__)
#define KQ_COLD __attribute__((cold, minsize))
#elif defined(__GNUC__)
#define KQ_COLD __attribute__((cold))
#else
#define KQ_COLD
#endif

/* Memory counts more than time: the user said so, or it is a chip of 8 or 16 bits. */
#if defined(__OPTIMIZE_SIZE__) || UINT_MAX < UINT32_MAX
#define KQ_SMALL_CODE
#endif

/* A function that is to be compiled for what it is called with. */
#if defined(__GNUC__)
#define KQ_ALWAYS_INLINE static inline __attribute__((always_inline))
#else
#define KQ_ALWAYS_INLINE static inline
#endif

/* A kernel of which the same is true of the sizes, unless memory counts more. */
#if !defined(KQ_SMALL_CODE)
#define KQ_INLINE KQ_ALWAYS_INLINE
#else
#define KQ_INLINE static inline
#endif

/* A function of some size that many call: one copy of it; where sizes are constants (fixed_sizes.h),
   time counts more. */
#ifndef KQ_SHARED
#if defined(__GNUC__)
#define KQ_SHARED static __attribute__((noinline, unused))
#else
#define KQ_SHARED static
#endif
#endif

/* Up to how many states the smoothers on line have code of their own: a sample of theirs is to cost
   no more than three steps of the filter. */
#if defined(KQ_SMALL_CODE)
#define KQ_STATES_APART 0
#else
#define KQ_STATES_APART 3
#endif

/* The compiler is not to know what this address is: what is read there in a rare case is not read
   beforehand in every one. */
#if defined(__GNUC__)
#define KQ_READ_APART(address) __asm__("" : "+r"(address))
#else
#define KQ_READ_APART(address) ((void)0)
#endif

/* A condition that is mostly true */
#if defined(__GNUC__)
#define KQ_MOSTLY(condition) __builtin_expect(!!(condition), 1)
#else
#define KQ_MOSTLY(condition) (condition)
#endif

/* Before a loop over states: where the sizes are constants (fixed_sizes.h) it is unrolled. */
#ifndef KQ_UNROLL
#define KQ_UNROLL
#endif

/* Between two parts of a kernel: where the sizes are constants, instructions of the one are not moved
   into the other, which would keep more numbers in registers than there are. */
#ifndef KQ_IN_ORDER
#define KQ_IN_ORDER ((void)0)
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

#endif
