/*
 * kalmanq: least squares, the filter without a process, and fading memory.
 *
 *     min over x of   sum_k lambda^(N-k) (z_k - h_k x)^2 / r_k
 *                     + lambda^N (x - x0)' P0^-1 (x - x0)            k = 1 .. N
 *
 * is the filter with A = I, Q = 0 that starts from x0, P0 and whose covariance is divided by
 * lambda before every measurement: lambda = 1 is weighted least squares (in a batch, or as the
 * measurements come), lambda < 1 recursive least squares with exponential forgetting, memory
 * about 1 / (1 - lambda) measurements.  The filter does the arithmetic and is read as ever: the
 * solution is kq_mean, its covariance kq_covariance, its standard errors kq_sigma, the
 * prediction z^ = h x and its variance are kq_measurement.  The start is the filter's: whatever
 * initialises a filter gives the prior.
 *
 * Fading memory: kq_forget before kq_predict makes that one P- = A P A' / lambda + Q, a filter
 * that forgets measurements older than the model can be trusted for.
 *
 *     kq_filter_init_f32(&line, x0, P0);
 *     kq_least_squares_init_f32(&fit, &line, 1);
 *     ... kq_least_squares_add_f32(&fit, h, z, r) for every measurement ...
 *     kq_mean_f32(&line, 0);
 *
 * Wind-up: where the measurements say nothing of some direction of x for long, its variance grows
 * as lambda^-N.  It is stopped at 2^96 (f32), 2^360 (f64) or 2^200 squared words (q31).
 *
 * Sources: Haykin, Adaptive Filter Theory (RLS, the weights lambda^(N-k)); Sorenson and Sacks,
 * Recursive fading memory filtering, Inform. Sci. 3 (1971).
 */
#ifndef KALMANQ_LEAST_SQUARES_H
#define KALMANQ_LEAST_SQUARES_H

#include "filter.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * P <- P / lambda; the mean stays.
 *   lambda   0 < lambda <= 1; 1 changes nothing.  q31: a mantissa and an exponent, as every
 *            coefficient (0.99 is {(int32_t)(0.99 * 0x1p31), -31}, 1 is {(int32_t)0x1p30, -30})
 * Call it before predict for P- = A P A' / lambda + Q, or after it for (A P A' + Q) / lambda.
 * Cost: n^2 multiplications, one root, one division; stack: nothing to speak of.
 * Accuracy: S is multiplied by 1 + g, g = 1 / sqrt(lambda) - 1 being formed without cancellation:
 * only the increment is rounded, and a row of S by an eps of its size (f32 2^-24, f64 2^-53, q31
 * 2^-30), so that errors do not add up in one direction.  1 - lambda below that eps is nothing.
 * Events: KQ_EVENT_OVERFLOW: a variance would have passed the limit above; P stays as it is.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_NOT_FINITE (lambda), KQ_ERR_COEFFICIENT (q31: lambda has
 * no normal mantissa), KQ_ERR_RANGE (lambda <= 0 or > 1), KQ_ERR_RECORDING (a history, a lag or
 * an instant is attached and lambda < 1: there is no record for this).
 */
KQ_NODISCARD kq_status kq_forget_f32(kq_filter_f32 *f, float lambda);
KQ_NODISCARD kq_status kq_forget_f64(kq_filter_f64 *f, double lambda);
KQ_NODISCARD kq_status kq_forget_q31(kq_filter_q31 *f, kq_scaled_q31 lambda);

/* The fields of these four are the library's. */

typedef struct {
    int64_t sum; /* Q39.24 */
} kq_compensated_q31;

/* A filter with what a sequence of scalar measurements needs beside it; it has no memory. */
typedef struct {
    kq_filter_f32 *filter; /* the caller's; NULL until initialised */
    float lambda;
    kq_compensated_f32 residual; /* sum of lambda^(N-k) e_k^2 / s_k */
    kq_compensated_f32 weight;   /* sum of lambda^(N-k) */
} kq_least_squares_f32;

typedef struct {
    kq_filter_f64 *filter;
    double lambda;
    kq_compensated_f64 residual;
    kq_compensated_f64 weight;
} kq_least_squares_f64;

typedef struct {
    kq_filter_q31 *filter;
    const kq_format_q31 *measurement_format;
    kq_scaled_q31 lambda;
    kq_compensated_q31 residual;
    kq_compensated_q31 weight;
} kq_least_squares_q31;

/**
 * Begins: no measurements yet.
 *   q        written
 *   f        kept by reference; its state is the prior, and may be given before or after this.
 *            Nothing else should move it while residual and weight are of interest.
 *   lambda   as kq_forget
 * KQ_ERR_NULL, KQ_ERR_NOT_FINITE, KQ_ERR_RANGE (lambda).
 */
KQ_NODISCARD kq_status kq_least_squares_init_f32(kq_least_squares_f32 *q, kq_filter_f32 *f, float lambda);
KQ_NODISCARD kq_status kq_least_squares_init_f64(kq_least_squares_f64 *q, kq_filter_f64 *f, double lambda);

/** The same; the measurement's format is kept by reference.  KQ_ERR_COEFFICIENT (lambda) and
    KQ_ERR_TABLE (a fraction or a range out of its limits), too. */
KQ_NODISCARD kq_status kq_least_squares_init_q31(kq_least_squares_q31 *q, kq_filter_q31 *f, kq_scaled_q31 lambda,
                                    const kq_format_q31 *measurement_format);

/**
 * Takes z = h x + v, v ~ N(0, r): the filter fades, then it is updated.
 *   h        n, another one at each call if you like; not kept
 *   r        variance, >= 0; 1 / r is the weight (all r = 1: ordinary least squares)
 *   q31      z is a word of the measurement's format, h and r in words (fixed_point.h: h_k as
 *            H_ck, r as R_cc)
 * Cost: that of an update by one component, and of kq_forget where lambda < 1.
 * Stack: about 90 bytes more than the update's.
 * Accuracy: that of the update (filter.h).
 * Errors and events of kq_sensor_init_diagonal (q31: kq_sensor_init), kq_forget and kq_update.
 */

/**
 * A batch, refused as a whole: the same as one call of the above for every row, in their order.
 *   H        count x n
 *   z, r     count
 *   count    0 .. KQ_COUNT_MAX
 * KQ_ERR_SIZE (count), and the errors of the above.
 */
KQ_NODISCARD kq_status kq_least_squares_add_f32(kq_least_squares_f32 *q, const float *H, const float *z,
                                       const float *r, size_t count);
KQ_NODISCARD kq_status kq_least_squares_add_f64(kq_least_squares_f64 *q, const double *H, const double *z,
                                       const double *r, size_t count);
KQ_NODISCARD kq_status kq_least_squares_add_q31(kq_least_squares_q31 *q, const kq_scaled_q31 *H,
                                       const int32_t *z, const kq_scaled_q31 *r, size_t count);

/**
 * The minimum itself: the weighted sum of squared residuals of the solution, with the prior's term,
 * and the sum of the weights lambda^(N-k) of the measurements taken.  It is the sum of the NIS,
 * faded as the measurements are: nothing is stored and nothing is computed twice.
 * If the r are right, residual / weight is 1 but for chance; if they are right up to one unknown
 * factor, residual / weight estimates it, and P times it is the covariance of the solution.
 * f32: each to 2^-23 of its size, whatever the number of measurements.
 * q31: Q39.24, held at 2^61, which is 1.4e11 measurements; once held they stay so.
 * NaN (KQ_NOT_A_SCORE_Q31) where q is NULL or not initialised.
 */
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
