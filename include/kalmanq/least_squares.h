/*
 * kalmanq: least squares, and forgetting.
 *
 *     min over x of   sum_k lambda^(N-k) (z_k - h_k x)^2 / r_k  +  lambda^N (x - x0)' P0^-1 (x - x0)
 *
 * (k = 1 .. N) is the filter with A = I, Q = 0 whose covariance is divided by lambda before every measurement.
 * lambda = 1 is weighted least squares, lambda < 1 recursive least squares with a memory of about 1 / (1 - lambda)
 * measurements.  The filter holds the solution: kq_mean, kq_sigma (standard errors), kq_covariance, kq_measurement
 * (predictions).  Its state is the prior.
 *
 *     kq_filter_init_f32(&line, x0, P0);
 *     kq_least_squares_init_f32(&fit, &line, 1);
 *     ... kq_least_squares_add_f32(&fit, h, &z, &r, 1) for every measurement ...
 *     kq_mean_f32(&line, 0);
 *
 * Wind-up: a direction of x that is not measured for long has a variance that grows as lambda^-N, up to 2^96 (f32),
 * 2^360 (f64), 2^200 squared raw values (q31).
 */
#ifndef KALMANQ_LEAST_SQUARES_H
#define KALMANQ_LEAST_SQUARES_H

#include "filter.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Forgets: P <- P / lambda, the mean stays.  Before kq_predict it gives P- = A P A' / lambda + Q.
 *   f        changed
 *   lambda   0 < lambda <= 1; 1 changes nothing.  q31: 0.99 is {(int32_t)(0.99 * 0x1p31), -31}
 * Events: KQ_EVENT_OVERFLOW: a variance would have passed the limit above; P stays.
 * Accuracy: only the increment of S is rounded, to an eps of a row's size (2^-24 f32, 2^-53 f64, 2^-30 q31).
 * Errors do not add up in one direction.  1 - lambda below eps is lost.
 * Cost: n^2 multiplications, one root, one division.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_NOT_FINITE, KQ_ERR_RANGE (lambda), KQ_ERR_COEFFICIENT (q31: lambda is not
 * normalised), KQ_ERR_RECORDING (lambda < 1, and a history, a lag or an instant is attached). */
KQ_NODISCARD kq_status kq_forget_f32(kq_filter_f32 *f, float lambda);
KQ_NODISCARD kq_status kq_forget_f64(kq_filter_f64 *f, double lambda);
KQ_NODISCARD kq_status kq_forget_q31(kq_filter_q31 *f, kq_scaled_q31 lambda);

/* The fields of these four are the library's. */

typedef struct { int64_t sum; /* Q39.24 */ } kq_compensated_q31;

/* A filter, and the sums of a sequence of scalar measurements */
typedef struct {
    kq_filter_f32 *filter; /* the caller's; NULL until initialised */
    float lambda;
    kq_compensated_f32 residual; /* sum of lambda^(N-k) e_k^2 / s_k */
    kq_compensated_f32 weight;   /* sum of lambda^(N-k) */
} kq_least_squares_f32;
typedef struct {
    kq_filter_f64 *filter; double lambda; kq_compensated_f64 residual, weight;
} kq_least_squares_f64;
typedef struct {
    kq_filter_q31 *filter; const kq_format_q31 *measurement_format; kq_scaled_q31 lambda;
    kq_compensated_q31 residual, weight;
} kq_least_squares_q31;

/** Begins a fit without measurements.
 *   q        written
 *   f        kept by reference; initialise it before or after.  Move it by nothing else
 *   lambda   as kq_forget
 *   measurement_format   q31: kept by reference
 * KQ_ERR_NULL, KQ_ERR_NOT_FINITE, KQ_ERR_RANGE (lambda); q31: KQ_ERR_COEFFICIENT, KQ_ERR_TABLE (format).
 * Cost: comparisons. */
KQ_NODISCARD kq_status kq_least_squares_init_f32(kq_least_squares_f32 *q, kq_filter_f32 *f, float lambda);
KQ_NODISCARD kq_status kq_least_squares_init_f64(kq_least_squares_f64 *q, kq_filter_f64 *f, double lambda);
KQ_NODISCARD kq_status kq_least_squares_init_q31(kq_least_squares_q31 *q, kq_filter_q31 *f,
    kq_scaled_q31 lambda, const kq_format_q31 *measurement_format);

/** Takes measurements z = h x + v, v ~ N(0, r), in order: for each one the filter forgets, then it is updated.  One
 * measurement is count = 1.  Refused as a whole.
 *   q        changed, with its filter
 *   H        count x n; copied.  q31: h_k in raw values as H_ck (fixed_point.h)
 *   z        count; q31: raw values of the measurement's format
 *   r        count variances, >= 0; 1 / r is the weight.  q31: as R_cc
 *   count    0 .. KQ_COUNT_MAX
 * Events and accuracy of kq_update.
 * Cost: an update by one component and, for lambda < 1, a kq_forget each.  Stack: 90 bytes more.
 * KQ_ERR_SIZE (count), and the errors of kq_sensor_init_diagonal (q31: kq_sensor_init), kq_forget and kq_update. */
KQ_NODISCARD kq_status kq_least_squares_add_f32(kq_least_squares_f32 *q, const float *H, const float *z,
    const float *r, size_t count);
KQ_NODISCARD kq_status kq_least_squares_add_f64(kq_least_squares_f64 *q, const double *H, const double *z,
    const double *r, size_t count);
KQ_NODISCARD kq_status kq_least_squares_add_q31(kq_least_squares_q31 *q, const kq_scaled_q31 *H,
    const int32_t *z, const kq_scaled_q31 *r, size_t count);

/** The minimum: the weighted sum of squared residuals with the prior's term; and the sum of the weights lambda^(N-k)
 * of the measurements taken.
 *   q        read
 * If the r are right, residual / weight is 1 but for chance.  If they are right up to one factor, it estimates that
 * factor, and P times it is the covariance.
 * Accuracy: f32 to 2^-23 of its size for any number of measurements.  q31: Q39.24, saturates at 2^61 and stays.  NaN
 * (KQ_NOT_A_SCORE_Q31) where q is NULL or not initialised. */
float kq_least_squares_residual_f32(const kq_least_squares_f32 *q);
double kq_least_squares_residual_f64(const kq_least_squares_f64 *q);
int64_t kq_least_squares_residual_q31(const kq_least_squares_q31 *q);
float kq_least_squares_weight_f32(const kq_least_squares_f32 *q);
double kq_least_squares_weight_f64(const kq_least_squares_f64 *q);
int64_t kq_least_squares_weight_q31(const kq_least_squares_q31 *q);

#ifdef __cplusplus
}
#endif
#endif
