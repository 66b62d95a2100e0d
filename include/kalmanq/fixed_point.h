/*
 * kalmanq: fixed point, the numbers of the q31 arithmetic.
 *
 * A state, a control and a measurement is an int32_t in a Qm.n of the user's choice, another one
 * for every component: value = word * 2^-n, m = 31 - n integer bits.  Metres in Q16.15, a bias
 * in Q1.30, an ADC count in Q31.0.  Behind a state's word the filter keeps 24 more bits.
 *
 * What has no natural range (a coefficient of A, an entry of P or K) is a kq_scaled_q31, a
 * mantissa and an exponent.  Wherever one is given to the library or comes from it, its unit
 * is that of the words: the last bits of the components that it belongs to.
 *     A_ik (word of x_k to word of x_i) = A_ik (physical) * 2^(n_i - n_k)
 *     P_ij (words)                      = P_ij (physical) * 2^(n_i + n_j)
 *     K_ic (words)                      = K_ic (physical) * 2^(n_i - n_c)
 * prepare.h makes all of this from doubles, on the host or on the target.
 *
 * The range of every component is declared.  From the ranges and the coefficients, init checks
 * that no sum of products can overflow, and says in a kq_range_error_q31 which component needs how
 * many more integer bits.  At run time a measurement or a control outside its range is refused; a
 * state that leaves its word is held at the word's end, KQ_EVENT_SATURATED is set, and the
 * measurements bring it back.
 *
 * Only what a call leaves is held: the range that counts is that of the states that can be read.
 * Between the components of one measurement a state may be up to 64 words from 0 (a word: 2^31 last
 * bits); of a smoothed mean no part is held, and its distance from the filtered one may be 32768
 * sigma in each of S's directions.  Where one of these ends, KQ_EVENT_SATURATED is set, too.
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

/**
 * mantissa * 2^exponent, 2^30 <= |mantissa| < 2^31, or both 0.  In a table |exponent| is at most
 * KQ_EXPONENT_MAX_Q31.  By hand: 0.01 is {(int32_t)(0.01 * 0x1p37 + 0.5), -37}, 1 is
 * {(int32_t)0x1p30, -30}.
 */
typedef struct {
    int32_t mantissa;
    int32_t exponent;
} kq_scaled_q31;

#define KQ_EXPONENT_MAX_Q31 1000

/** The format of one component: value = word * 2^-fraction, |word| <= range. */
typedef struct {
    int32_t range;    /* the declared range, in words: 1 .. 2^31 - 1 */
    int32_t fraction; /* n of Qm.n: KQ_FRACTION_MIN_Q31 .. KQ_FRACTION_MAX_Q31 */
} kq_format_q31;

#define KQ_FRACTION_MIN_Q31 (-64)
#define KQ_FRACTION_MAX_Q31 94

/** In the place of a fraction: the most fraction bits that hold the range (kq_format_prepare_q31). */
#define KQ_FRACTION_BEST_Q31 1000

/** What a reading of the library gives for a bad argument (f32 and f64: NaN). */
#define KQ_NOT_A_VALUE_Q31 INT32_MIN
#define KQ_NOT_A_SCORE_Q31 INT64_MIN

/** Words of a root: the triangle by columns, mantissas of row i in units of 2^exponent_i, then
    the n exponents.  S_ij = root[j (j + 1) / 2 + i] * 2^root[n (n + 1) / 2 + i], i <= j. */
#define KQ_ROOT_LEN_Q31(n) (KQ_TRIANGLE(n) + (n))

/** Whose format does not fit; KQ_NO_RANGE_ERROR: none. */
typedef enum {
    KQ_STATE,
    KQ_CONTROL,
    KQ_MEASUREMENT,
    KQ_NO_RANGE_ERROR,
    KQ_QUANTITY_IS_INT = INT_MAX
} kq_quantity;

/** What KQ_ERR_RANGE means (written where a call answers that; where the init of a process, sensor,
    filter or start answers KQ_OK it writes KQ_NO_RANGE_ERROR): `component` of the states, controls or measurements needs `bits` more
    integer bits (a fraction that is smaller by `bits`).  bits = 0: its word would hold the value,
    its declared range does not. */
typedef struct {
    kq_quantity quantity;
    int32_t component;
    int32_t bits;
} kq_range_error_q31;

/**
 * The range_error in words, such as "state 2 needs 3 more integer bits" or "all formats fit".
 *   text     `length` characters, written: the sentence, cut where it is too long, and a 0
 * Returns the length of the whole sentence.  A NULL range_error gives "".
 */
size_t kq_range_error_text_q31(const kq_range_error_q31 *range_error, char *text, size_t length);

#ifdef __cplusplus
}
#endif
#endif
