/*
 * kalmanq: fixed point, the numbers of the q31 arithmetic.
 *
 * A state, control or measurement is a RAW VALUE: an int32_t in a format Qm.n that you choose for each component.
 * value = raw value * 2^-n, with m = 31 - n integer bits: metres in Q16.15, a bias in Q1.30, an ADC count in Q31.0.
 * The filter keeps 24 more bits of a state.
 *
 * Numbers without a natural range (coefficients of A, entries of P or K) are kq_scaled_q31: a mantissa and an
 * exponent, always in units of raw values.
 *     A_ik (raw value of x_k to raw value of x_i) = A_ik (physical) * 2^(n_i - n_k)
 *     P_ij (raw values)                           = P_ij (physical) * 2^(n_i + n_j)
 *     K_ic (raw values)                           = K_ic (physical) * 2^(n_i - n_c)
 * prepare.h makes them from doubles, on the host or on the target.
 *
 * You declare the range of each component.  From ranges and coefficients init checks that no sum of products can
 * overflow, and says in a kq_range_error_q31 which component needs how many more integer bits.  At run time a
 * measurement or control outside its range is refused.  A state beyond +-2^31 raw values is saturated, with
 * KQ_EVENT_SATURATED, and measurements bring it back.  Only the state that a call leaves is saturated.  Between the
 * components of one measurement a state may reach 64 * 2^31 raw values.  A smoothed mean may be 32768 sigma from the
 * filtered one in each direction of the root.  Beyond these limits KQ_EVENT_SATURATED is set too.
 */
#ifndef KALMANQ_FIXED_POINT_H
#define KALMANQ_FIXED_POINT_H

#include <stddef.h>
#include <stdint.h>

#include "size.h"
#include "status.h"

#ifdef __cplusplus
extern "C" {
#endif

/** mantissa * 2^exponent, 2^30 <= |mantissa| < 2^31, or both 0.  In a table |exponent| <= KQ_EXPONENT_MAX_Q31. By
 * hand: 0.01 is {(int32_t)(0.01 * 0x1p37 + 0.5), -37}, 1 is {(int32_t)0x1p30, -30}. */
typedef struct { int32_t mantissa, exponent; } kq_scaled_q31;

#define KQ_EXPONENT_MAX_Q31 1000

/** The format of one component: value = raw value * 2^-fraction, |raw value| <= range. */
typedef struct {
    int32_t range;    /* the declared range in raw values: 1 .. 2^31 - 1 */
    int32_t fraction; /* n of Qm.n: KQ_FRACTION_MIN_Q31 .. KQ_FRACTION_MAX_Q31 */
} kq_format_q31;

#define KQ_FRACTION_MIN_Q31 (-64)
#define KQ_FRACTION_MAX_Q31 94
/** For kq_format_prepare_q31: the most fraction bits that hold the range. */
#define KQ_FRACTION_BEST_Q31 1000

/** What a reading answers for a bad argument (f32 and f64: NaN). */
#define KQ_NOT_A_VALUE_Q31 INT32_MIN
#define KQ_NOT_A_SCORE_Q31 INT64_MIN

/** Words of a root: the triangle by columns, mantissas of row i in units of 2^exponent_i, then the n exponents. S_ij =
 * root[j (j + 1) / 2 + i] * 2^root[n (n + 1) / 2 + i], i <= j. */
#define KQ_ROOT_LEN_Q31(n) (KQ_TRIANGLE(n) + (n))

/** Whose format does not fit; KQ_NO_RANGE_ERROR: all formats fit. */
typedef enum { KQ_STATE, KQ_CONTROL, KQ_MEASUREMENT, KQ_NO_RANGE_ERROR, KQ_QUANTITY_IS_INT = INT_MAX
} kq_quantity;

/** The reason of KQ_ERR_RANGE: `component` of the states, controls or measurements needs `bits` more integer bits (a
 * fraction smaller by `bits`).  bits = 0: the value fits the format but not the declared range.  An init that answers
 * KQ_OK writes KQ_NO_RANGE_ERROR. */
typedef struct { kq_quantity quantity; int32_t component, bits; } kq_range_error_q31;

/** The range error in words: "state 2 needs 3 more integer bits", "all formats fit".
 *   range_error  read; NULL gives ""
 *   text         written: the sentence, cut if it is too long, and a 0
 *   length       characters at text
 * Returns the length of the whole sentence.  Cost: a copy of it, a division for each digit. */
size_t kq_range_error_text_q31(const kq_range_error_q31 *range_error, char *text, size_t length);

#ifdef __cplusplus
}
#endif
#endif
