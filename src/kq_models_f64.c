/*
 * kalmanq in double: the model builders' public names.
 */
#include "arithmetic/has_double.h"

#if KQ_HAS_DOUBLE
#include "arithmetic/f64.h"

#include "arithmetic/root.h"

#include "model/process.h"

#include "model/units.h"

#include "statistics/models_float.h"

kq_status kq_model_assign_f64(kq_model_f64 *model, int n, int r, int m, double *memory,
                              size_t length)
{
    return model_assign(model, n, r, m, memory, length);
}

kq_status kq_model_ar_f64(kq_model_f64 *model, const double *phi, int p, double variance,
                          double noise)
{
    return model_ar(model, phi, p, variance, noise);
}

kq_status kq_model_ma_f64(kq_model_f64 *model, const double *theta, int q, double variance,
                          double noise)
{
    return model_ma(model, theta, q, variance, noise);
}

kq_status kq_model_arma_f64(kq_model_f64 *model, const double *phi, int p, const double *theta,
                            int q, double variance, double noise)
{
    return model_arma(model, phi, p, theta, q, variance, noise);
}

kq_status kq_model_regression_f64(kq_model_f64 *model, const double *regressors, int k,
                                  const double *drift, double noise, const double *mean,
                                  const double *variance)
{
    return model_regression(model, regressors, k, drift, noise, mean, variance);
}

kq_status kq_model_level_f64(kq_model_f64 *model, double drift, double noise, double mean,
                             double variance)
{
    return model_level(model, drift, noise, mean, variance);
}

kq_status kq_model_trend_f64(kq_model_f64 *model, const double *drift, double noise,
                             const double *mean, const double *variance)
{
    return model_trend(model, drift, noise, mean, variance);
}

kq_status kq_model_season_f64(kq_model_f64 *model, int seasons, double drift, double noise,
                              const double *mean, const double *variance)
{
    return model_season(model, seasons, drift, noise, mean, variance);
}

kq_status kq_model_trend_season_f64(kq_model_f64 *model, int seasons, const double *drift,
                                    double noise, const double *mean, const double *variance)
{
    return model_trend_season(model, seasons, drift, noise, mean, variance);
}

kq_status kq_model_factor_f64(kq_model_f64 *model, int k, int m, const double *loadings,
                              const double *transition, const double *drift, const double *noise)
{
    return model_factor(model, k, m, loadings, transition, drift, noise);
}

kq_status kq_stationary_covariance_f64(double *P, const double *A, const double *F, int n, int r)
{
    return stationary_covariance(P, A, F, n, r);
}

kq_status kq_model_velocity_f64(kq_model_f64 *model, int d, double dt, const double *density,
                                const double *noise, const double *mean, const double *variance)
{
    return model_velocity(model, d, dt, density, noise, mean, variance);
}

kq_status kq_model_acceleration_f64(kq_model_f64 *model, int d, double dt, const double *density,
                                    const double *noise, const double *mean, const double *variance)
{
    return model_acceleration(model, d, dt, density, noise, mean, variance);
}

#endif
