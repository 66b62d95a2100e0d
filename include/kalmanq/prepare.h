/*
 * kalmanq: a model of doubles made into the tables of the q31 arithmetic.
 *
 * On the host to write a table for flash, or on the target at start-up: the same bytes by
 * either way, and on every machine whose double has 64 bits (avr-gcc: -mdouble=64).  It is the one
 * part of q31 that computes in floating point, in a file of its own: firmware with tables in flash
 * does not link it.
 *
 *     double              becomes        by
 *     range               kq_format_q31  kq_format_prepare, kq_format_prepare_named
 *     A, B, H             kq_scaled_q31  kq_matrix_prepare, rows x columns
 *     Q = G G', P0        root words     kq_root_prepare, kq_root_prepare_factor
 *     R                   kq_scaled_q31  kq_noise_prepare, kq_noise_prepare_diagonal
 *     x0, u, z            words          kq_vector_prepare
 *
 * If a call is refused nothing is written but the range_error, if there is one.
 */
#ifndef KALMANQ_PREPARE_H
#define KALMANQ_PREPARE_H

#include "fixed_point.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * The format with the most fraction bits that holds +-range.
 *   range    > 0, in the component's unit
 * KQ_ERR_NULL, KQ_ERR_NOT_FINITE, KQ_ERR_RANGE (0 or negative, or outside 2^-64 .. (2^31 - 1) 2^64,
 * which no format holds).
 * The format Qm.fraction, m = 31 - fraction, for the range declared.
 *   range_error   written if the range does not fit: bits more integer bits are needed; the caller
 *            fills in whose format it is.  Or NULL.
 * KQ_ERR_NULL, KQ_ERR_NOT_FINITE, KQ_ERR_SIZE (fraction), KQ_ERR_RANGE (it does not fit, is not
 * positive, is below half of the last bit or outside 2^-64 .. (2^31 - 1) 2^64).
 */
KQ_NODISCARD kq_status kq_format_prepare_q31(kq_format_q31 *format, int fraction, double range,
                                      kq_range_error_q31 *range_error);

/**
 * table_ij = M_ij * 2^(fraction of row i - fraction of column j), to 31 bits.
 *   table    rows x columns, written
 *   M        rows x columns, row-major: A with the states' formats twice; B with states, controls;
 *            H with measurements, states
 * KQ_ERR_NULL, KQ_ERR_SIZE (rows, columns: 1..16, or a fraction), KQ_ERR_NOT_FINITE,
 * KQ_ERR_COEFFICIENT (an entry's exponent is beyond KQ_EXPONENT_MAX_Q31).
 */
KQ_NODISCARD kq_status kq_matrix_prepare_q31(kq_scaled_q31 *table, const double *M, int rows, int columns,
                                const kq_format_q31 *row_format,
                                const kq_format_q31 *column_format);

/**
 * The root of a covariance of the states, Q = G G' or P0.
 *   root     KQ_ROOT_LEN_Q31(n) words, written
 *   P        n x n, symmetric positive semi-definite, may be singular or 0
 * Accuracy: that of kq_process_init_f64, then half a unit in each entry, the largest of a row
 * having 28 bits (30 in the last row, 29 in the three above it).
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_NOT_FINITE, KQ_ERR_NOT_SYMMETRIC, KQ_ERR_NOT_SEMIDEFINITE,
 * KQ_ERR_RANGE (a variance above 2^1000), KQ_ERR_COEFFICIENT.
 */
KQ_NODISCARD kq_status kq_root_prepare_q31(int32_t *root, const double *P, int n, const kq_format_q31 *format);

/** The same for P = F F', F n x r, r = 0 .. 16 (F may be NULL for r = 0): exact where P is
    singular. */
KQ_NODISCARD kq_status kq_root_prepare_factor_q31(int32_t *root, const double *F, int n, int r,
                                     const kq_format_q31 *format);

/**
 * The noise of a sensor.
 *   table    KQ_TRIANGLE(m) numbers, written: R = U D U', U unit upper triangular by columns, D in
 *            place of its diagonal
 *   R        m x m, symmetric positive semi-definite, may be singular: what the other components leave
 *            of a variance is none up to 8 m 2^-52 of it
 * Errors as kq_root_prepare.
 */
KQ_NODISCARD kq_status kq_noise_prepare_q31(kq_scaled_q31 *table, const double *R, int m,
                               const kq_format_q31 *format);

/** The same for independent components: m variances r >= 0 (0: noise-free) into m numbers. */
KQ_NODISCARD kq_status kq_noise_prepare_diagonal_q31(kq_scaled_q31 *table, const double *r, int m,
                                        const kq_format_q31 *format);

/**
 * Words of x, rounded to nearest.
 *   words    count, written
 *   range_error   written if a value is beyond its declared range: component and bits (the quantity is
 *            the caller's to fill in, KQ_STATE is written); or NULL
 * KQ_ERR_NULL, KQ_ERR_SIZE (count: 1..16, or a fraction), KQ_ERR_NOT_FINITE, KQ_ERR_RANGE.
 */
KQ_NODISCARD kq_status kq_vector_prepare_q31(int32_t *words, const double *x, int count,
                                const kq_format_q31 *format, kq_range_error_q31 *range_error);

#ifdef __cplusplus
}
#endif
#endif
