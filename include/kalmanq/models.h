/*
 * kalmanq: models that are state-space models, built.
 *
 *     x[t+1] = A x[t] + w,  w ~ N(0, F F')        z[t] = H x[t] + v,  v ~ N(0, diag R)
 *     x[0] ~ N(x0, P0), before the first measurement
 *
 * A builder fills in a MODEL's arrays, whose sizes are constant expressions; process, sensor and
 * filter are made of them as of any others, and refer to them:
 *
 *     KQ_MODEL_F32(car, KQ_VELOCITY_STATES(2), KQ_VELOCITY_NOISES(2), 2);
 *     KQ_PROCESS_F32(motion, KQ_VELOCITY_STATES(2), 0);  and a sensor, a filter
 *     kq_model_velocity_f32(&car, 2, 0.1f, density, noise, NULL, variance);
 *     kq_process_init_factor_f32(&motion, car.A, NULL, car.F, car.noises);
 *     kq_sensor_init_diagonal_f32(&gps, car.H, car.R);
 *     kq_filter_init_f32(&track, car.x0, car.P0);
 *
 * The noise is given by its factor F, which is exact where Q = F F' is singular, as it mostly is
 * here.  States are in the order in which A is upper triangular, or nearly (one entry below the
 * diagonal a row): that is where predict is fastest.  Stationary models (ar, ma, arma, factor)
 * have the stationary covariance as P0; the others are given a mean and variances.
 *
 * q31: build in f64, on the host or on the target, and make tables of the arrays (prepare.h):
 * kq_matrix_prepare_q31 of A and H, kq_root_prepare_factor_q31 of F, kq_root_prepare_q31 of P0,
 * kq_noise_prepare_diagonal_q31 of R, kq_vector_prepare_q31 of x0.
 *
 * All builders: KQ_ERR_NULL, KQ_ERR_MEMORY (a model without memory), KQ_ERR_SIZE (an order or a
 * dimension out of range), KQ_ERR_MISMATCH (the model has other sizes), KQ_ERR_NOT_FINITE (an
 * argument, or what becomes of it), KQ_ERR_NOT_SEMIDEFINITE (a negative variance).  Refused as a
 * whole.  Variances may be 0.
 * Stack: a few dozen words, but for the factor model.
 *
 * Sources: Hamilton, Time Series Analysis (1994), 13.1; Harvey, Forecasting, Structural Time Series
 * Models and the Kalman Filter (1989); Durbin and Koopman, Time Series Analysis by State Space
 * Methods (2012); Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and
 * Navigation (2001), 6.2.
 */
#ifndef KALMANQ_MODELS_H
#define KALMANQ_MODELS_H

#include "size.h"
#include "status.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Words of memory of a model with n states, r noises and m components. */
#define KQ_MODEL_LEN(n, r, m) (((n)*2 + (r) + (m) + 1) * (n) + (m))

/** The arrays of a model, to be read by the user; dense and row-major. */
typedef struct {
    uint8_t states;     /* n */
    uint8_t noises;     /* r */
    uint8_t components; /* m */
    float *A;           /* n x n */
    float *F;           /* n x r */
    float *H;           /* m x n */
    float *R;           /* m variances */
    float *x0;          /* n */
    float *P0;          /* n x n */
} kq_model_f32;

typedef struct {
    uint8_t states;
    uint8_t noises;
    uint8_t components;
    double *A;
    double *F;
    double *H;
    double *R;
    double *x0;
    double *P0;
} kq_model_f64;

/** A model `name` of n states, r noises and m components with its storage, in static memory. */
#define KQ_MODEL_F32(name, n, r, m)                                                                \
    static float name##_memory[KQ_MODEL_LEN(n, r, m)];                                             \
    static kq_model_f32 name = {n,                                                                 \
                                r,                                                                 \
                                m,                                                                 \
                                name##_memory,                                                     \
                                name##_memory + (n) * (n),                                         \
                                name##_memory + (n) * ((n) + (r)),                                 \
                                name##_memory + (n) * ((n) + (r) + (m)),                           \
                                name##_memory + (n) * ((n) + (r) + (m)) + (m),                     \
                                name##_memory + (n) * ((n) + (r) + (m) + 1) + (m)}
#define KQ_MODEL_F64(name, n, r, m)                                                                \
    static double name##_memory[KQ_MODEL_LEN(n, r, m)];                                            \
    static kq_model_f64 name = {n,                                                                 \
                                r,                                                                 \
                                m,                                                                 \
                                name##_memory,                                                     \
                                name##_memory + (n) * (n),                                         \
                                name##_memory + (n) * ((n) + (r)),                                 \
                                name##_memory + (n) * ((n) + (r) + (m)),                           \
                                name##_memory + (n) * ((n) + (r) + (m)) + (m),                     \
                                name##_memory + (n) * ((n) + (r) + (m) + 1) + (m)}

/**
 * Sizes and memory known at run time only (the macros do the same at compile time).
 *   model    written
 *   n, r, m  1..16
 *   length   words at memory: KQ_MODEL_LEN(n, r, m)
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY.
 */
kq_status kq_model_assign_f32(kq_model_f32 *model, int n, int r, int m, float *memory,
                              size_t length);
kq_status kq_model_assign_f64(kq_model_f64 *model, int n, int r, int m, double *memory,
                              size_t length);

/* ------------------------------------------------------------------ ARMA */

/** States (one noise, one component). */
#define KQ_AR_STATES(p) (p)
#define KQ_MA_STATES(q) ((q) + 1)
#define KQ_ARMA_STATES(p, q) ((p) > (q) ? (p) : (q) + 1)

/**
 * z[t] = y[t] + v,  y[t] = sum_i phi_i y[t-i] + w[t] + sum_j theta_j w[t-j],  w ~ N(0, variance)
 *   phi       p coefficients, phi_1 first; p >= 1 (ar), >= 0 (arma; NULL if 0)
 *   theta     q coefficients, theta_1 first; q >= 0 (NULL if 0)
 *   variance  of w
 *   noise     variance of v, 0 if y itself is measured
 * States: ar: y[t], y[t-1], ...; arma: u[t], u[t-1], ... of the autoregression u = y without theta,
 * z = (1, theta) u (Hamilton's form); ma: w[t-q], ..., w[t], A strictly upper triangular.
 * P0: the stationary covariance, from the autocovariances, which Durbin's and Levinson's
 * recursions give in p^2 operations; backwards they are the test of stationarity, too.
 * Accuracy of P0, of sigma_i sigma_j: eps times the product of (1 + |k|) / (1 - |k|) over the
 * partial autocorrelations k, which is what the coefficients' own rounding may be worth.  Of 1600
 * random models of order up to 16, |k| < 0.8: 7e-13 (f64), 2e-3 (f32; the median is 6e-7).
 * KQ_ERR_NO_CONVERGENCE: not stationary.
 */
kq_status kq_model_ar_f32(kq_model_f32 *model, const float *phi, int p, float variance,
                          float noise);
kq_status kq_model_ar_f64(kq_model_f64 *model, const double *phi, int p, double variance,
                          double noise);
kq_status kq_model_ma_f32(kq_model_f32 *model, const float *theta, int q, float variance,
                          float noise);
kq_status kq_model_ma_f64(kq_model_f64 *model, const double *theta, int q, double variance,
                          double noise);
kq_status kq_model_arma_f32(kq_model_f32 *model, const float *phi, int p, const float *theta, int q,
                            float variance, float noise);
kq_status kq_model_arma_f64(kq_model_f64 *model, const double *phi, int p, const double *theta,
                            int q, double variance, double noise);

/* ------------------------------------------------------------------ structural models */

/**
 * Regression with coefficients that walk: z[t] = h[t] x[t] + v, x[t+1] = x[t] + w.
 *   regressors  k: h of the first step, into H; at every step put another h there, or elsewhere,
 *               and call kq_sensor_change_measurement
 *   k           1..16 states, k noises, one component
 *   drift       k variances of w, 0 for a constant coefficient
 *   noise       variance of v
 *   mean        k, or NULL: 0.  The coefficients before the first measurement ...
 *   variance    k: ... and their variances
 */
kq_status kq_model_regression_f32(kq_model_f32 *model, const float *regressors, int k,
                                  const float *drift, float noise, const float *mean,
                                  const float *variance);
kq_status kq_model_regression_f64(kq_model_f64 *model, const double *regressors, int k,
                                  const double *drift, double noise, const double *mean,
                                  const double *variance);

/** Local level: z = level + v, the level walks with variance `drift` a step.  1 state, 1 noise, 1
    component; mean and variance of the level before the first measurement. */
kq_status kq_model_level_f32(kq_model_f32 *model, float drift, float noise, float mean,
                             float variance);
kq_status kq_model_level_f64(kq_model_f64 *model, double drift, double noise, double mean,
                             double variance);

/** Local linear trend: states level and slope, 2 noises, 1 component.  A step moves the level by
    the slope, both walk.
 *   drift     2 variances a step: of level and slope
 *   mean      2, or NULL: 0
 *   variance  2
 */
kq_status kq_model_trend_f32(kq_model_f32 *model, const float *drift, float noise,
                             const float *mean, const float *variance);
kq_status kq_model_trend_f64(kq_model_f64 *model, const double *drift, double noise,
                             const double *mean, const double *variance);

/** States (one noise; trend and season: three). */
#define KQ_SEASON_STATES(seasons) ((seasons)-1)
#define KQ_TREND_SEASON_STATES(seasons) ((seasons) + 1)

/**
 * Seasonal effects with noise (dummies): the effects of a whole year add up to w ~ N(0, drift).
 * States: the effect now and those of the seasons - 2 steps before, the last one first.
 *   seasons        2..17: seasons - 1 states, 1 noise, 1 component
 *   mean           seasons - 1, or NULL: 0
 *   variance       seasons - 1
 */
kq_status kq_model_season_f32(kq_model_f32 *model, int seasons, float drift, float noise,
                              const float *mean, const float *variance);
kq_status kq_model_season_f64(kq_model_f64 *model, int seasons, double drift, double noise,
                              const double *mean, const double *variance);

/**
 * Trend and season together (the basic structural model): z = level + effect + v.
 *   seasons   2..15: seasons + 1 states (level, slope, effects), 3 noises, 1 component
 *   drift     3: of level, slope and season
 *   mean      seasons + 1, or NULL: 0
 *   variance  seasons + 1
 */
kq_status kq_model_trend_season_f32(kq_model_f32 *model, int seasons, const float *drift,
                                    float noise, const float *mean, const float *variance);
kq_status kq_model_trend_season_f64(kq_model_f64 *model, int seasons, const double *drift,
                                    double noise, const double *mean, const double *variance);

/**
 * Dynamic factor model: z = loadings x + v, x[t+1] = transition x[t] + w, x stationary.
 *   k, m        1..16 factors (states and noises), 1..16 components
 *   loadings    m x k
 *   transition  k x k, spectral radius below 1
 *   drift       k variances of w (1: the usual normalisation)
 *   noise       m variances of v
 * P0: the stationary covariance, see below, which also says cost, stack, accuracy.
 * KQ_ERR_NO_CONVERGENCE: not stationary.
 */
kq_status kq_model_factor_f32(kq_model_f32 *model, int k, int m, const float *loadings,
                              const float *transition, const float *drift, const float *noise);
kq_status kq_model_factor_f64(kq_model_f64 *model, int k, int m, const double *loadings,
                              const double *transition, const double *drift, const double *noise);

/**
 * The solution of P = A P A' + F F', for a model of your own.
 *   P        n x n, written, exactly symmetric; may be A or F
 *   n, r     1..16, 0..16 (0: P = 0, if A is stable)
 * By doubling: P <- P + A P A', A <- A^2, until A is nothing.
 * Cost: 2.5 n^3 multiplications each time, 6 + log2(1 / (1 - spectral radius)) times in f32, 8 in
 * f64; stack: 3 n^2 words, n = 16.
 * Accuracy: a few n eps of sigma_i sigma_j over (1 - spectral radius); more is lost where powers
 * of A grow before they fall.
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_NOT_FINITE, KQ_ERR_NO_CONVERGENCE (the spectral radius is not
 * below 1 - 1e-5 (f32) or 1 - 2e-13 (f64), where rounding begins to decide).
 */
kq_status kq_stationary_covariance_f32(float *P, const float *A, const float *F, int n, int r);
kq_status kq_stationary_covariance_f64(double *P, const double *A, const double *F, int n, int r);

/* ------------------------------------------------------------------ motion */

/** States and noises of d dimensions (d components). */
#define KQ_VELOCITY_STATES(d) (2 * (d))
#define KQ_VELOCITY_NOISES(d) (2 * (d))
#define KQ_ACCELERATION_STATES(d) (3 * (d))
#define KQ_ACCELERATION_NOISES(d) (3 * (d))

/**
 * Constant velocity but for white-noise acceleration, positions measured; and constant acceleration
 * but for white-noise jerk.  Exact for the step dt: Q is the integral over it, in closed form
 *     velocity      q [dt^3/3  dt^2/2;  .  dt]
 *     acceleration  q [dt^5/20  dt^4/8  dt^3/6;  .  dt^3/3  dt^2/2;  .  .  dt]
 * and F its triangular factor in closed form.  States: position, velocity (, acceleration) of the
 * first axis, then of the next; A is upper triangular.
 *   d         1..3 dimensions
 *   dt        > 0 (KQ_ERR_RANGE)
 *   density   d: q of each axis, e.g. (m/s^2)^2 s, (m/s^3)^2 s
 *   noise     d variances of the measured positions
 *   mean      one for each state, or NULL: 0
 *   variance  one for each state
 */
kq_status kq_model_velocity_f32(kq_model_f32 *model, int d, float dt, const float *density,
                                const float *noise, const float *mean, const float *variance);
kq_status kq_model_velocity_f64(kq_model_f64 *model, int d, double dt, const double *density,
                                const double *noise, const double *mean, const double *variance);
kq_status kq_model_acceleration_f32(kq_model_f32 *model, int d, float dt, const float *density,
                                    const float *noise, const float *mean, const float *variance);
kq_status kq_model_acceleration_f64(kq_model_f64 *model, int d, double dt, const double *density,
                                    const double *noise, const double *mean,
                                    const double *variance);

#ifdef __cplusplus
}
#endif
#endif
