/*
 * kalmanq in float: the model builders' public names.
 */
#include "arithmetic/f32.h"

#include "arithmetic/root.h"

#include "model/process.h"

#include "model/units.h"

#include "statistics/models_float.h"

kq_status kq_model_assign_f32(kq_model_f32 *model, int n, int r, int m, float *memory,
                              size_t length)
{
    return model_assign(model, n, r, m, memory, length);
}

kq_status kq_model_ar_f32(kq_model_f32 *model, const float *phi, int p, float variance, float noise)
{
    return model_ar(model, phi, p, variance, noise);
}

kq_status kq_model_ma_f32(kq_model_f32 *model, const float *theta, int q, float variance,
                          float noise)
{
    return model_ma(model, theta, q, variance, noise);
}

kq_status kq_model_arma_f32(kq_model_f32 *model, const float *phi, int p, const float *theta, int q,
                            float variance, float noise)
{
    return model_arma(model, phi, p, theta, q, variance, noise);
}

kq_status kq_model_regression_f32(kq_model_f32 *model, const float *regressors, int k,
                                  const float *drift, float noise, const float *mean,
                                  const float *variance)
{
    return model_regression(model, regressors, k, drift, noise, mean, variance);
}

kq_status kq_model_level_f32(kq_model_f32 *model, float drift, float noise, float mean,
                             float variance)
{
    return model_level(model, drift, noise, mean, variance);
}

kq_status kq_model_trend_f32(kq_model_f32 *model, const float *drift, float noise,
                             const float *mean, const float *variance)
{
    return model_trend(model, drift, noise, mean, variance);
}

kq_status kq_model_season_f32(kq_model_f32 *model, int seasons, float drift, float noise,
                              const float *mean, const float *variance)
{
    return model_season(model, seasons, drift, noise, mean, variance);
}

kq_status kq_model_trend_season_f32(kq_model_f32 *model, int seasons, const float *drift,
                                    float noise, const float *mean, const float *variance)
{
    return model_trend_season(model, seasons, drift, noise, mean, variance);
}

kq_status kq_model_factor_f32(kq_model_f32 *model, int k, int m, const float *loadings,
                              const float *transition, const float *drift, const float *noise)
{
    return model_factor(model, k, m, loadings, transition, drift, noise);
}

kq_status kq_stationary_covariance_f32(float *P, const float *A, const float *F, int n, int r)
{
    return stationary_covariance(P, A, F, n, r);
}

kq_status kq_model_velocity_f32(kq_model_f32 *model, int d, float dt, const float *density,
                                const float *noise, const float *mean, const float *variance)
{
    return model_velocity(model, d, dt, density, noise, mean, variance);
}

kq_status kq_model_acceleration_f32(kq_model_f32 *model, int d, float dt, const float *density,
                                    const float *noise, const float *mean, const float *variance)
{
    return model_acceleration(model, d, dt, density, noise, mean, variance);
}
