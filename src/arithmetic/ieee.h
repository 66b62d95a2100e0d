/* What floating point has to be: numbers that are not finite are seen, and sums are taken as they are
   written.  kq_self_test finds what no macro tells. */
#ifndef KQ_SRC_ARITHMETIC_IEEE_H
#define KQ_SRC_ARITHMETIC_IEEE_H

#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "kalmanq tests for NaN and infinity: compile without -ffast-math and -ffinite-math-only"
#endif

#if defined(__FLT_EVAL_METHOD__) && (__FLT_EVAL_METHOD__ < 0 || __FLT_EVAL_METHOD__ == 1 || __FLT_EVAL_METHOD__ == 2)
#error "kalmanq: compile with floats that are evaluated as floats: -msse2 -mfpmath=sse on x86 (FLT_EVAL_METHOD)"
#endif

#if defined(__ASSOCIATIVE_MATH__)
#error                                                                                             \
    "kalmanq's pairs need sums as written: no -fassociative-math, no -funsafe-math-optimizations"
#endif

#endif
