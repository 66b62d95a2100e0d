/*
 * kalmanq: does this build compute as the library was written to?
 *
 * A compiler may be told to break the rules of arithmetic, and says nothing.  Headers refuse what they
 * can see: -ffast-math and -ffinite-math-only (a NaN would be taken for a measurement), with gcc from
 * version 12 also -fassociative-math (the pairs of numbers that hold a mean and a long sum would be
 * simplified to nothing).  clang and older versions of gcc do not tell their headers of the last, a wrong
 * rounding mode is set at run time, and a port of one's own may be wrong: a product calls this once, at
 * start-up.
 *
 *     if (kq_self_test_f32() != KQ_OK) stop_here();
 *
 * f32, f64: NaN and infinity are refused, rounding is to nearest, the mean and the sums of a run keep
 * what is far below their last bit.  q31: a small run gives the words that it gives everywhere.
 * What is in a file of its own (kq_fixed_<T>.h) has its own flags, which this does not see.
 *
 * Cost: about 50 updates of one state.  Stack: 0.3 kB (M4F) and that of kq_process_init.
 */
#ifndef KALMANQ_SELF_TEST_H
#define KALMANQ_SELF_TEST_H

#include "status.h"

#ifdef __cplusplus
extern "C" {
#endif

/** KQ_OK, or KQ_ERR_ARITHMETIC: what this build computes is not to be trusted. */
KQ_NODISCARD kq_status kq_self_test_f32(void);
KQ_NODISCARD kq_status kq_self_test_f64(void);
KQ_NODISCARD kq_status kq_self_test_q31(void);

#ifdef __cplusplus
}
#endif
#endif
