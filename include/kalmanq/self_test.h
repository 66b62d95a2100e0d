/*
 * kalmanq: does this build compute correctly?  Call this once at start-up.
 *
 *     if (kq_self_test_f32() != KQ_OK) stop_here();
 *
 * The headers refuse -ffast-math and -ffinite-math-only, and with gcc from version 12 on -fassociative-math.  The
 * test finds what a header cannot see: these flags with clang and older gcc, a wrong rounding mode, a wrong port.
 * f32, f64: NaN and infinity are refused, rounding is to nearest, mean and sums keep what is below their last bit.
 * q31: a small run gives the raw values that it gives everywhere.  It does not see the flags of other files
 * (kq_fixed_<T>.h).
 */
#ifndef KALMANQ_SELF_TEST_H
#define KALMANQ_SELF_TEST_H

#include "status.h"

#ifdef __cplusplus
extern "C" {
#endif

/** KQ_OK, or KQ_ERR_ARITHMETIC: do not trust this build.
 * Cost: about 50 updates of one state.  Stack: 0.3 kB (M4F) and the stack of kq_process_init. */
KQ_NODISCARD kq_status kq_self_test_f32(void);
KQ_NODISCARD kq_status kq_self_test_f64(void);
KQ_NODISCARD kq_status kq_self_test_q31(void);

#ifdef __cplusplus
}
#endif
#endif
