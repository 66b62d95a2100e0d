/*
 * What C11 cannot say.  How functions are compiled, by intent:
 *
 *                at -O2              at -Os              sizes constant (fixed_size/)
 *   KQ_INLINE    inline              inline              inline            for what it is called with
 *   KQ_KERNEL    inline              as it likes         inline            a kernel, for its sizes
 *   KQ_PART      inline              a frame of its own  inline            of a long function: AVR reaches 64 bytes of a frame
 *   KQ_SHARED    one copy            one copy            as it likes       large, and called by many
 *   KQ_OUTLINE   a frame of its own  a frame of its own  inline            with scratch of its own
 *   KQ_NOINLINE  a frame of its own  a frame of its own  a frame of its own
 *   KQ_COLD      for size            for size            for size          init, errors, what is unusual
 */
#ifndef KQ_SRC_ARITHMETIC_COMPILER_H
#define KQ_SRC_ARITHMETIC_COMPILER_H

#include <limits.h>
#include <stdint.h>

/* An instance uses a part of what it includes. */
#if defined(__GNUC__) && !defined(KQ_SIZES_ARE_CONSTANT)
#pragma GCC diagnostic ignored "-Wunused-function"
#endif

/* Memory counts more than time: the user said so, or it is a chip of 8 or 16 bits. */
#if defined(__OPTIMIZE_SIZE__) || UINT_MAX < UINT32_MAX
#define KQ_SMALL_CODE
#endif

#if defined(__GNUC__)
#define KQ_INLINE static inline __attribute__((always_inline))
#define KQ_NOINLINE __attribute__((noinline))
#else
#define KQ_INLINE static inline
#define KQ_NOINLINE
#endif

#if !defined(KQ_SMALL_CODE)
#define KQ_KERNEL KQ_INLINE
#define KQ_PART KQ_INLINE
#else
#define KQ_KERNEL static inline
#define KQ_PART KQ_NOINLINE static
#endif

#if defined(KQ_SIZES_ARE_CONSTANT)
#define KQ_SHARED static inline
#define KQ_OUTLINE KQ_INLINE
#elif defined(__GNUC__)
#define KQ_SHARED static __attribute__((noinline, unused))
#define KQ_OUTLINE KQ_NOINLINE static
#else
#define KQ_SHARED static
#define KQ_OUTLINE KQ_NOINLINE static
#endif

#if defined(__clang__)
#define KQ_COLD __attribute__((cold, minsize))
#elif defined(__GNUC__)
#define KQ_COLD __attribute__((cold))
#else
#define KQ_COLD
#endif

/* Before a loop over states: unrolled where the sizes are constants, its numbers in registers. */
#if defined(KQ_SIZES_ARE_CONSTANT)
#define KQ_UNROLL _Pragma("GCC unroll 16")
#else
#define KQ_UNROLL
#endif

/* Between two parts of a kernel: where the sizes are constants gcc would move instructions of the one into
   the other, and keep more numbers in registers than there are. */
#if defined(KQ_SIZES_ARE_CONSTANT) && defined(__GNUC__)
#define KQ_IN_ORDER __asm__ volatile("")
#else
#define KQ_IN_ORDER ((void)0)
#endif

/* Up to how many states the smoothers on line have code of their own: a sample of theirs is to cost
   no more than three steps of the filter, 3.5 with the covariance. */
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

/* Does the compiler know that a condition is true? */
#if defined(__GNUC__)
#define KQ_IS_KNOWN(condition) (__builtin_constant_p(condition) && (condition))
#else
#define KQ_IS_KNOWN(condition) 0
#endif

/* The longest float, in bits, that the core has instructions for; all, where that is not known */
#if defined(__SOFTFP__) || defined(__AVR__) || (defined(__riscv) && !defined(__riscv_flen))
#define KQ_FLOAT_BITS 0
#elif defined(__riscv_flen)
#define KQ_FLOAT_BITS __riscv_flen
#elif defined(__ARM_FP)
#define KQ_FLOAT_BITS (__ARM_FP & 8 ? 64 : 32)
#else
#define KQ_FLOAT_BITS 64
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
