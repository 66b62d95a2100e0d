/*
 * kalmanq: nonlinear models, sigma points and iteration (f32, f64).
 *
 * No Jacobians: f and h are called at points about the mean, and give the linear function that is nearest to them
 * under all of the density, not at its mean alone.  With P = S S', S_j its columns, the points are x and
 * x +- h S_j, 2n + 1 calls, the centre first:
 *     KQ_SIGMA_POINTS_CUBATURE   h^2 = n    the third-degree cubature rule
 *     KQ_SIGMA_POINTS_CENTRAL    h^2 = 3    central differences; the one to take for n = 1 and 2
 * No weight is negative, so no covariance is ever lowered; which of the two hardly matters for n > 2.
 *
 * What is found goes into the filter as a linear step does (extended.h), with an A (or H), an increment (or an
 * innovation) and more noise: so all smoothers of extended.h smooth it.  A filter by sigma points is the extended
 * filter with another A and more noise.
 *
 * g gives INCREMENTS and INNOVATIONS: f(x) - x, and z - h(x), each formed so that no bits are lost (extended.h).
 * An angle in it is to be without jumps over all the points: wrap z - h(x) to -pi .. pi where the innovation is
 * far from +-pi, otherwise unwrap it around its value at the centre, which is called first.
 *
 * When to take what.
 *     Jacobians (extended.h)     the cheapest.  Good where f and h hardly bend over a sigma or two.
 *     points                     3 to 4 times the cost.  Where they bend, and the extended filter is overconfident:
 *                                NIS and errors larger than they should be.
 *     iterate the update         a sensor is sharp beside what was known: sqrt(R) far below what h bends over P.
 *                                A range of 0.1 mm and a bearing of 1e-6 rad with P0 of metres: without, errors are
 *                                300 times their sigma, with 4 iterations they are right.
 *     iterate the smoother       all of the data at hand, and a poor start: each pass linearises at the smoothed
 *                                states of the last one.
 * Iterating does harm where there are two solutions far apart: see the step rule below.
 *
 * The iterated update (posterior linearisation; with Jacobians at the mean of `trial` in the place of kq_linearise,
 * and kq_sensor_change_measurement, the iterated extended filter).  track is at x, trial is where to linearise:
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
 * The iterated smoother.  A pass is a filter run and kq_smooth; in the next one step t's f and h are linearised at
 * the view of kq_smoothed(&last, t, &at), `last` being the last pass's history, or the numbers y, J, E of every step
 * are kept, and d = y + J (x - c), x the filter's mean, c that of `at`.  Six passes are enough; stop where no mean moves by
 * more than 0.01 sigma.  What the filter says in such a pass knows the future: only the smoothed states are results.
 *     Step rule.  Where the pass's smoothed states make sum (z - h)' R^-1 (z - h) + sum w' Q^-1 w + (x0's) larger than
 * before, go half of the way: linearise at c + (c' - c) / 2, halve again up to 4 times, and stop.  (By Jacobians the
 * passes end where that sum is least; by points only near it, and there a rise by less than 1 is none.)  Where this
 * happens at the first pass, the model has more than one solution, and no smoother of this kind is to be trusted.
 *     In f32 the smoothed density is far narrower than the filtered one: kq_linearise's J has the noise of
 * differences (below).  There, take Jacobians for the passes, or f64.
 *
 * Sources: Arasaratnam and Haykin, Cubature Kalman filters, IEEE Trans. Automatic Control 54 (2009); Norgaard,
 * Poulsen and Ravn, New developments in state estimation for nonlinear systems, Automatica 36 (2000);
 * Garcia-Fernandez, Svensson, Morelande and Sarkka, Posterior linearization filter, IEEE Trans. Signal Processing 63
 * (2015); Garcia-Fernandez, Svensson and Sarkka, Iterated posterior linearization smoother, IEEE Trans. Automatic
 * Control 62 (2017); Bell, The iterated Kalman smoother as a Gauss-Newton method, SIAM J. Optimization 4 (1994).
 */
#ifndef KALMANQ_SIGMA_POINTS_H
#define KALMANQ_SIGMA_POINTS_H

#include "extended.h"

#ifdef __cplusplus
extern "C" {
#endif

/** y = g(x).
 *   context  yours: time, controls, the measurement
 *   x        n, in the states' units, read
 *   y        `rows` numbers, all to be written (one that is not counts as not finite), no more
 * May not change the filter that is being linearised at. */
typedef void kq_function_f32(void *context, const float *x, float *y);
typedef void kq_function_f64(void *context, const double *x, double *y);

typedef enum {
    KQ_SIGMA_POINTS_CUBATURE,
    KQ_SIGMA_POINTS_CENTRAL,
    KQ_SIGMA_POINTS_IS_INT = INT_MAX
} kq_sigma_points;

/**
 * The linear function nearest to g under a density.
 *   at       the density: a filter, which does not change; any, also a view of a smoothed step
 *   rows     1..16
 *   y        rows, written: E[g(x)]
 *   J        rows x n, written: Cov(g, x) = J P
 *   E        rows x n, written: Cov(g) = J P J' + E E'
 * y, J and E do not overlap each other.
 * Cost: 2n + 1 calls, about 5 n rows + n^2 rows / 2 multiplications.  Stack: 5 x 16 words and what g needs.
 * Accuracy: J has the noise of differences, eps |x| / sigma and eps |g| / (sigma J): in f32 the density's sigmas
 * should be more than 1e-4 of |x|.  Where P is singular J is one of those that do.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_SIZE (rows), KQ_ERR_RANGE (rule), KQ_ERR_NOT_FINITE (a value of g: y, J and E
 * are of no use then).
 */
KQ_NODISCARD kq_status kq_linearise_f32(const kq_filter_f32 *at, kq_function_f32 *g, void *context, int rows,
                           kq_sigma_points rule, float *y, float *J, float *E);
KQ_NODISCARD kq_status kq_linearise_f64(const kq_filter_f64 *at, kq_function_f64 *g, void *context, int rows,
                           kq_sigma_points rule, double *y, double *J, double *E);

/**
 * A process of A and the noise Q + E E', for kq_predict_extended.
 *   p        n states, with its own memory; written
 *   base     Q; read; may be a const table
 *   A        n x n, kept by reference: J + I of an increment
 *   E        n x n, read and overwritten
 * Cost: about n^3 multiplications.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY (base), KQ_ERR_SIZE, KQ_ERR_MEMORY (p), KQ_ERR_MISMATCH (states, or p is base or has
 * its memory), KQ_ERR_NOT_FINITE, KQ_ERR_RANGE (a number of E above 2^60 in f32, 2^500 in f64).
 */
KQ_NODISCARD kq_status kq_process_linearise_f32(kq_process_f32 *p, const kq_process_f32 *base, const float *A,
                                   float *E);
KQ_NODISCARD kq_status kq_process_linearise_f64(kq_process_f64 *p, const kq_process_f64 *base, const double *A,
                                   double *E);

/**
 * A sensor that takes innovations (extended.h), of H and the noise R + E E'.
 *   s        n states, m components, with the memory of a correlated R (KQ_SENSOR); written
 *   base     its R; read
 *   H        m x n, kept by reference: -J of an innovation
 *   E        m x n, read
 *   R        m x m, written: R + E E', kept by reference; not base's
 * Cost: m^2 n / 2 + m^3 / 2 multiplications.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY (base), KQ_ERR_SIZE, KQ_ERR_MEMORY (s), KQ_ERR_MISMATCH (sizes, or s is base or has its
 * memory, or R is base's), KQ_ERR_NOT_FINITE, KQ_ERR_RANGE (E, as above).
 */
KQ_NODISCARD kq_status kq_sensor_linearise_f32(kq_sensor_f32 *s, const kq_sensor_f32 *base, const float *H,
                                  const float *E, float *R);
KQ_NODISCARD kq_status kq_sensor_linearise_f64(kq_sensor_f64 *s, const kq_sensor_f64 *base, const double *H,
                                  const double *E, double *R);

/** Words of `work` of the two functions below, for n states and at most m components of a sensor. */
#define KQ_PRIVATE_PREDICT_SIGMA_POINTS_LEN(n) (2 * (n) * (n) + 3 * (n) + KQ_TRIANGLE(n))
#define KQ_PRIVATE_UPDATE_SIGMA_POINTS_LEN(n, m) ((m) + 2 * (m) * (n) + KQ_TRIANGLE(m) + 1)
#define KQ_SIGMA_POINTS_LEN(n, m)                                                                        \
    (KQ_PRIVATE_PREDICT_SIGMA_POINTS_LEN(n) > KQ_PRIVATE_UPDATE_SIGMA_POINTS_LEN(n, m)                         \
         ? KQ_PRIVATE_PREDICT_SIGMA_POINTS_LEN(n)                                                        \
         : KQ_PRIVATE_UPDATE_SIGMA_POINTS_LEN(n, m))

/**
 * kq_linearise, kq_process_linearise and kq_predict_extended in one.  Where nothing is attached A is never formed, and
 * P is as sound where S is singular.
 *   p          its Q alone is read
 *   increment  f(x) - x: n numbers
 *   work       KQ_SIGMA_POINTS_LEN(n, m) words, written
 * Cost: 2n + 1 calls, about 2.5 n^3 multiplications.
 * KQ_ERR_RANGE (rule), KQ_ERR_NOT_FINITE (a value of increment), the errors of kq_predict_extended.
 */
KQ_NODISCARD kq_status kq_predict_sigma_points_f32(kq_filter_f32 *f, const kq_process_f32 *p,
                                kq_function_f32 *increment, void *context, kq_sigma_points rule,
                                float *work);
KQ_NODISCARD kq_status kq_predict_sigma_points_f64(kq_filter_f64 *f, const kq_process_f64 *p,
                                kq_function_f64 *increment, void *context, kq_sigma_points rule,
                                double *work);

/**
 * kq_linearise, kq_sensor_linearise and kq_update in one.  H is never formed, and the update is as sound where S is
 * singular.
 *   s           its R alone is read
 *   innovation  z - h(x): m numbers
 *   work        KQ_SIGMA_POINTS_LEN(n, m) words, written
 * The components are decorrelated by R + E E' first: what is left of one in the last 7 bits of its terms is nothing.
 * Cost: 2n + 1 calls, 6 n m + m^2 n + n^3 / 6 multiplications, kq_update.
 * KQ_ERR_RANGE (rule; what a linear function leaves of innovation is above 2^60 in f32, 2^500 in f64),
 * KQ_ERR_NOT_FINITE (a value of innovation), the errors of kq_update with an innovation (extended.h).
 */
KQ_NODISCARD kq_status kq_update_sigma_points_f32(kq_filter_f32 *f, const kq_sensor_f32 *s,
                               kq_function_f32 *innovation, void *context, kq_sigma_points rule,
                               float *work);
KQ_NODISCARD kq_status kq_update_sigma_points_f64(kq_filter_f64 *f, const kq_sensor_f64 *s,
                               kq_function_f64 *innovation, void *context, kq_sigma_points rule,
                               double *work);

#ifdef __cplusplus
}
#endif
#endif
