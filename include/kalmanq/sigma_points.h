/*
 * kalmanq: nonlinear models, sigma points and iteration (f32, f64).
 *
 * No Jacobians: f and h are called at 2n + 1 points about the mean, as in the unscented Kalman filter (UKF), which gives
 * the linear function nearest to them under the whole density.  With P = S S' and columns S_j, the points are x (first) and x +- h S_j:
 *     KQ_SIGMA_POINTS_CUBATURE   h^2 = n    the third-degree cubature rule
 *     KQ_SIGMA_POINTS_CENTRAL    h^2 = 3    central differences; use it for n = 1 and 2
 * For n > 2 they hardly differ.  No weight is negative, so no covariance is lowered.
 *
 * The result goes into the filter as a linear step with more noise (extended.h), which all smoothers smooth.  Your
 * functions give INCREMENTS f(x) - x and INNOVATIONS z - h(x), formed as there.  An angle must not jump between the
 * points: wrap z - h(x) to -pi .. pi if the innovation is far from +-pi, else unwrap it around its value at the first
 * point.
 *
 *     take                     when
 *     Jacobians (extended.h)   f and h hardly bend over a sigma or two: the cheapest
 *     sigma points             they bend, and the extended filter is overconfident (NIS too large): 3 to 4
 *                              times the cost
 *     an iterated update       sqrt(R) is far below what h bends over P
 *     an iterated smoother     all data are at hand, and the start is poor
 *
 * The iterated update (posterior linearisation).  track is the filter, trial is where to linearise.  With Jacobians
 * at the mean of `trial` and kq_sensor_change_measurement it is the iterated extended filter.
 *
 *     kq_filter_copy_f32(&trial, &track);
 *     for (k = 0; k < 4; k++) {
 *         kq_linearise_f32(&trial, innovation, context, M, KQ_SIGMA_POINTS_CUBATURE, e, J, E);
 *         for (i ...) H[i] = -J[i];
 *         for (c, i ...) e[c] += J[c * N + i] * (kq_mean_f32(&track, i) - kq_mean_f32(&trial, i));
 *         kq_sensor_linearise_f32(&at, &radar, H, E, R);
 *         kq_filter_copy_f32(&trial, &track);
 *         kq_update_f32(&trial, &at, e);
 *     }
 *     kq_update_f32(&track, &at, e);                                     what trial has become, track becomes
 *
 * The iterated smoother.  A pass is a filter run and kq_smooth.  The next pass linearises step t at the view of
 * kq_smoothed(&last, t, &at), `last` being the last pass's history, with d = y + J (x - c): x the filter's mean, c
 * the mean of `at`.  Or keep y, J, E of every step.  Six passes are enough; stop if no mean moves by more than 0.01
 * sigma.  A filter in such a pass has used the future: only smoothed states are results.
 * If sum (z - h)' R^-1 (z - h) + sum w' Q^-1 w + (x0's term) of the smoothed states rises (with sigma
 * points: by 1 or more), go half of the way: linearise at c + (c' - c) / 2, halve up to 4 times, stop.  If it rises
 * at the first pass, the model has several solutions: trust no smoother of this kind.
 * In f32 the smoothed density may be too narrow for differences (kq_linearise): use Jacobians or f64.
 */
#ifndef KALMANQ_SIGMA_POINTS_H
#define KALMANQ_SIGMA_POINTS_H

#include "extended.h"

#ifdef __cplusplus
extern "C" {
#endif

/** y = g(x).  Must not change the filter that is being linearised at.
 *   context  yours: time, controls, the measurement
 *   x        n, in the states' units, read
 *   y        `rows` numbers: write all of them and no more; one left out counts as not finite */
typedef void kq_function_f32(void *context, const float *x, float *y);
typedef void kq_function_f64(void *context, const double *x, double *y);

typedef enum { KQ_SIGMA_POINTS_CUBATURE, KQ_SIGMA_POINTS_CENTRAL, KQ_SIGMA_POINTS_IS_INT = INT_MAX
} kq_sigma_points;

/** The linear function nearest to g under a density.
 *   at       the density: a filter, or a view of a smoothed step; read
 *   g        y = g(x), called 2n + 1 times
 *   context  passed to g; may be NULL
 *   rows     1..16, of g
 *   rule     KQ_SIGMA_POINTS_...
 *   y        rows, written: E[g(x)]
 *   J        rows x n, written: Cov(g, x) = J P
 *   E        rows x n, written: Cov(g) = J P J' + E E'
 * y, J and E must not overlap.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_SIZE (rows), KQ_ERR_RANGE (rule), KQ_ERR_NOT_FINITE (a value of g; then y, J
 * and E are useless).
 * Accuracy: J has the noise of differences, eps |x| / sigma and eps |g| / (sigma J): in f32 sigmas should exceed 1e-4
 * of |x|.  If P is singular, J is one of many solutions.
 * Cost: 2n + 1 calls, about 5 n rows + n^2 rows / 2 multiplications.  Stack: 80 words and what g needs. */
KQ_NODISCARD kq_status kq_linearise_f32(const kq_filter_f32 *at, kq_function_f32 *g, void *context, int rows,
    kq_sigma_points rule, float *y, float *J, float *E);
KQ_NODISCARD kq_status kq_linearise_f64(const kq_filter_f64 *at, kq_function_f64 *g, void *context, int rows,
    kq_sigma_points rule, double *y, double *J, double *E);

/** Makes a process of A and the noise Q + E E', for kq_predict_extended.
 *   p        n states, its own memory; written
 *   base     has Q; read; may be a const table
 *   A        n x n, kept by reference: J + I of an increment
 *   E        n x n, read and overwritten
 * KQ_ERR_NULL, KQ_ERR_NOT_READY (base), KQ_ERR_SIZE, KQ_ERR_MEMORY (p), KQ_ERR_MISMATCH (states, or p is base or has
 * its memory), KQ_ERR_NOT_FINITE, KQ_ERR_RANGE (an entry of E above 2^60 in f32, 2^500 in f64).
 * Cost: about n^3 multiplications. */
KQ_NODISCARD kq_status kq_process_linearise_f32(kq_process_f32 *p, const kq_process_f32 *base, const float *A,
    float *E);
KQ_NODISCARD kq_status kq_process_linearise_f64(kq_process_f64 *p, const kq_process_f64 *base,
    const double *A, double *E);

/** Makes a sensor that takes innovations (extended.h), of H and the noise R + E E'.
 *   s        n states, m components, the memory of a correlated R (KQ_SENSOR); written
 *   base     has the R; read
 *   H        m x n, kept by reference: -J of an innovation
 *   E        m x n, read
 *   R        m x m, written: R + E E', kept by reference; not base's
 * KQ_ERR_NULL, KQ_ERR_NOT_READY (base), KQ_ERR_SIZE, KQ_ERR_MEMORY (s), KQ_ERR_MISMATCH (sizes, or s is base or has
 * its memory, or R is base's), KQ_ERR_NOT_FINITE, KQ_ERR_RANGE (E, as above).
 * Cost: m^2 n / 2 + m^3 / 2 multiplications. */
KQ_NODISCARD kq_status kq_sensor_linearise_f32(kq_sensor_f32 *s, const kq_sensor_f32 *base, const float *H,
    const float *E, float *R);
KQ_NODISCARD kq_status kq_sensor_linearise_f64(kq_sensor_f64 *s, const kq_sensor_f64 *base, const double *H,
    const double *E, double *R);

/** Words of `work` of the two functions below, for n states and at most m components of a sensor. */
#define KQ_PRIVATE_PREDICT_SIGMA_POINTS_LEN(n) (2 * (n) * (n) + 3 * (n) + KQ_TRIANGLE(n))
#define KQ_PRIVATE_UPDATE_SIGMA_POINTS_LEN(n, m) ((m) + 2 * (m) * (n) + KQ_TRIANGLE(m) + 1)
#define KQ_SIGMA_POINTS_LEN(n, m) \
    (KQ_PRIVATE_PREDICT_SIGMA_POINTS_LEN(n) > KQ_PRIVATE_UPDATE_SIGMA_POINTS_LEN(n, m) \
        ? KQ_PRIVATE_PREDICT_SIGMA_POINTS_LEN(n) \
        : KQ_PRIVATE_UPDATE_SIGMA_POINTS_LEN(n, m))

/** kq_linearise, kq_process_linearise and kq_predict_extended in one.  With nothing attached A is
 * never formed and P may be singular.
 *   f          changed
 *   p          only its Q is read
 *   increment  n numbers: f(x) - x
 *   context    passed to increment; may be NULL
 *   rule       KQ_SIGMA_POINTS_...
 *   work       KQ_SIGMA_POINTS_LEN(n, m) words, written
 * KQ_ERR_RANGE (rule), KQ_ERR_NOT_FINITE (a value of increment), the errors of kq_predict_extended.
 * Cost: 2n + 1 calls, about 2.5 n^3 multiplications. */
KQ_NODISCARD kq_status kq_predict_sigma_points_f32(kq_filter_f32 *f, const kq_process_f32 *p,
    kq_function_f32 *increment, void *context, kq_sigma_points rule, float *work);
KQ_NODISCARD kq_status kq_predict_sigma_points_f64(kq_filter_f64 *f, const kq_process_f64 *p,
    kq_function_f64 *increment, void *context, kq_sigma_points rule, double *work);

/** kq_linearise, kq_sensor_linearise and kq_update in one.  H is never formed; P may be singular.
 *   f           changed
 *   s           only its R is read
 *   innovation  m numbers: z - h(x)
 *   context     passed to innovation; may be NULL
 *   rule        KQ_SIGMA_POINTS_...
 *   work        KQ_SIGMA_POINTS_LEN(n, m) words, written
 * The components are decorrelated by R + E E'; what is left in the last 7 bits of its terms counts as 0.
 * KQ_ERR_RANGE (rule; what a linear function leaves of innovation is above 2^60 in f32, 2^500 in f64),
 * KQ_ERR_NOT_FINITE (a value of innovation), KQ_ERR_RECORDING (an adaptation or a freeze), the errors of kq_update.
 * Cost: 2n + 1 calls, 6 n m + m^2 n + n^3 / 6 multiplications, kq_update. */
KQ_NODISCARD kq_status kq_update_sigma_points_f32(kq_filter_f32 *f, const kq_sensor_f32 *s,
    kq_function_f32 *innovation, void *context, kq_sigma_points rule, float *work);
KQ_NODISCARD kq_status kq_update_sigma_points_f64(kq_filter_f64 *f, const kq_sensor_f64 *s,
    kq_function_f64 *innovation, void *context, kq_sigma_points rule, double *work);

#ifdef __cplusplus
}
#endif
#endif
