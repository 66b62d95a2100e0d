/*
 * kalmanq: makes a model of doubles into the tables of the q31 arithmetic.
 *
 * Use it on the host to write tables for flash, or on the target at start-up: the bytes are the same on every machine
 * whose double has 64 bits (avr-gcc: -mdouble=64).  It is the only floating-point code of q31, in a separate file:
 * firmware with tables in flash does not link it.
 *
 *     double              becomes        by
 *     range               kq_format_q31  kq_format_prepare
 *     A, B, H             kq_scaled_q31  kq_matrix_prepare, rows x columns
 *     Q = G G', P0        root words     kq_root_prepare, kq_root_prepare_factor
 *     R                   kq_scaled_q31  kq_noise_prepare, kq_noise_prepare_diagonal
 *     x0, u, z            raw values     kq_vector_prepare
 *
 * A refused call writes nothing but the range_error.
 */
#ifndef KALMANQ_PREPARE_H
#define KALMANQ_PREPARE_H

#include "fixed_point.h"

#ifdef __cplusplus
extern "C" {
#endif

/** A format for the range +-range.
 *   format       written
 *   fraction     n of Qm.n, or KQ_FRACTION_BEST_Q31: the most fraction bits that hold the range
 *   range        > 0, in the component's unit; 2^-64 .. (2^31 - 1) 2^64
 *   range_error  written if the range does not fit the fraction: `bits` more integer bits are needed; you fill in
 *                quantity and component.  Or NULL.
 * KQ_ERR_NULL, KQ_ERR_NOT_FINITE, KQ_ERR_SIZE (fraction), KQ_ERR_RANGE (it does not fit, is not positive, is outside
 * the limits above, or is below half of the last bit).
 * Cost of each number, here and below: multiplications of doubles, in proportion to |log2| of it and of its unit. */
KQ_NODISCARD kq_status kq_format_prepare_q31(kq_format_q31 *format, int fraction, double range,
    kq_range_error_q31 *range_error);

/** table_ij = M_ij * 2^(fraction of row i - fraction of column j), to 31 bits.
 *   table        rows x columns, written
 *   M            rows x columns, row-major
 *   rows         1..16
 *   columns      1..16
 *   row_format   `rows`: of A and B the states', of H the measurements'
 *   column_format  `columns`: of A and H the states', of B the controls'
 * KQ_ERR_NULL, KQ_ERR_SIZE (rows, columns, a fraction), KQ_ERR_NOT_FINITE, KQ_ERR_COEFFICIENT (the exponent of an
 * entry is beyond KQ_EXPONENT_MAX_Q31).  Cost: as kq_format_prepare. */
KQ_NODISCARD kq_status kq_matrix_prepare_q31(kq_scaled_q31 *table, const double *M, int rows, int columns,
    const kq_format_q31 *row_format, const kq_format_q31 *column_format);

/** The root of a covariance of the states, Q or P0.
 *   root     KQ_ROOT_LEN_Q31(n) words, written
 *   P        n x n, symmetric positive semi-definite, may be singular or 0
 *   n        1..16
 *   format   n, the states'
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_NOT_FINITE, KQ_ERR_NOT_SYMMETRIC, KQ_ERR_NOT_SEMIDEFINITE, KQ_ERR_RANGE (a
 * variance above 2^1000), KQ_ERR_COEFFICIENT.
 * Accuracy: as kq_process_init_f64, then half a unit in each entry; the largest entry of a row has 28 bits (30 in the
 * last row, 29 in the three above it).  Cost: as kq_process_init_f64 and kq_format_prepare. */
KQ_NODISCARD kq_status kq_root_prepare_q31(int32_t *root, const double *P, int n, const kq_format_q31 *format);

/** As kq_root_prepare, P = F F' given by a factor: exact if P is singular.
 *   F        n x r, any rank; may be NULL if r = 0
 *   r        0..16 columns */
KQ_NODISCARD kq_status kq_root_prepare_factor_q31(int32_t *root, const double *F, int n, int r,
    const kq_format_q31 *format);

/** The noise of a sensor.
 *   table    KQ_TRIANGLE(m) numbers, written: R = U D U', U unit upper by columns, D on its diagonal
 *   R        m x m, symmetric positive semi-definite, may be singular.  What the other components leave of a variance
 *            counts as 0 up to 8 m 2^-52 of it.
 *   m        1..16
 *   format   m, the measurements'
 * Errors: as kq_root_prepare. */
KQ_NODISCARD kq_status kq_noise_prepare_q31(kq_scaled_q31 *table, const double *R, int m,
    const kq_format_q31 *format);

/** As kq_noise_prepare, of independent components.
 *   table    m numbers, written
 *   r        m variances >= 0; 0 for a noise-free component */
KQ_NODISCARD kq_status kq_noise_prepare_diagonal_q31(kq_scaled_q31 *table, const double *r, int m,
    const kq_format_q31 *format);

/** Raw values of x, rounded to nearest.
 *   raw          count, written
 *   x            count, in the components' units
 *   count        1..16
 *   format       count
 *   range_error  written if a value is beyond its declared range: component and bits, and KQ_STATE, for which you
 *                fill in the quantity.  Or NULL.
 * KQ_ERR_NULL, KQ_ERR_SIZE (count, a fraction), KQ_ERR_NOT_FINITE, KQ_ERR_RANGE.  Cost: as kq_format_prepare. */
KQ_NODISCARD kq_status kq_vector_prepare_q31(int32_t *raw, const double *x, int count,
    const kq_format_q31 *format, kq_range_error_q31 *range_error);

#ifdef __cplusplus
}
#endif
#endif
