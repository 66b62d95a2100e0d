/*
 * kalmanq in fixed point: the algorithm over num_q31.h, and its public names.
 */
#include "types_q31.h"

#include "triangle.inc"

#include "process.inc"
#include "predict.inc"
#include "update.inc"

#include "fit_q31.inc"
#include "sensor.inc"
#include "likelihood_q31.inc"
#include "filter.inc"

#include "table.inc"

#include "read.inc"
#include "measured_q31.inc"
#include "history.inc"

#include "sharp.inc"
#include "care.inc"
#include "take.inc"
#include "independent.inc"
#include "correlated.inc"
#include "step.inc"
#include "gain.inc"
#include "forecast.inc"
#include "smooth_kernels.inc"
#include "smoother.inc"

#include "robust_q31.inc"
#include "robust.inc"
#include "gate.inc"
#include "student_scale.inc"
#include "student_step.inc"
#include "smooth_reweighted.inc"

#include "backward_map.inc"
#include "lag.inc"
#include "point.inc"

#include "inexact.inc"
#include "start_unknown.inc"
#include "start_rounding.inc"
#include "start_columns.inc"
#include "start_past.inc"
#include "start_take.inc"
#include "start.inc"
#include "start_smooth.inc"
#include "start_q31.inc"

kq_status kq_process_init_q31(kq_process_q31 *p, const kq_process_table_q31 *table,
                              kq_misfit_q31 *misfit)
{
    return process_init(p, table, misfit);
}

kq_status kq_process_change_transition_q31(kq_process_q31 *p, const kq_scaled_q31 *A)
{
    return process_change_transition(p, A);
}

kq_status kq_sensor_init_q31(kq_sensor_q31 *s, const kq_sensor_table_q31 *table,
                             kq_misfit_q31 *misfit)
{
    return sensor_init(s, table, misfit);
}

kq_status kq_sensor_init_diagonal_q31(kq_sensor_q31 *s, const kq_sensor_table_q31 *table,
                                      kq_misfit_q31 *misfit)
{
    return sensor_init_diagonal(s, table, &SENSOR_INDEPENDENT, misfit);
}

kq_status kq_sensor_init_lean_q31(kq_sensor_q31 *s, const kq_sensor_table_q31 *table,
                                  kq_misfit_q31 *misfit)
{
    return sensor_init_diagonal(s, table, &SENSOR_LEAN, misfit);
}

kq_status kq_sensor_change_measurement_q31(kq_sensor_q31 *s, const kq_scaled_q31 *H)
{
    return sensor_change_measurement(s, H);
}

kq_status kq_filter_assign_q31(kq_filter_q31 *f, int n, int32_t *memory, size_t length)
{
    return filter_assign(f, n, memory, length);
}

kq_status kq_filter_init_q31(kq_filter_q31 *f, const kq_prior_table_q31 *prior,
                             kq_misfit_q31 *misfit)
{
    return filter_init(f, prior, misfit);
}

kq_status kq_predict_q31(kq_filter_q31 *f, const kq_process_q31 *p, const int32_t *u)
{
    return filter_predict(f, p, u);
}

kq_status kq_update_q31(kq_filter_q31 *f, const kq_sensor_q31 *s, const int32_t *z)
{
    return filter_update(f, s, z);
}

kq_status kq_update_subset_q31(kq_filter_q31 *f, const kq_sensor_q31 *s, const int32_t *z,
                               uint32_t present)
{
    return filter_update_subset(f, s, z, present);
}

kq_status kq_step_q31(kq_filter_q31 *f, const kq_process_q31 *p, const int32_t *u,
                      const kq_sensor_q31 *s, const int32_t *z)
{
    return filter_step(f, p, u, s, z);
}

int32_t kq_mean_q31(const kq_filter_q31 *f, int i) { return filter_mean(f, i); }

int32_t kq_mean_low_q31(const kq_filter_q31 *f, int i) { return filter_mean_low(f, i); }

int32_t kq_sigma_q31(const kq_filter_q31 *f, int i) { return filter_sigma(f, i); }

kq_status kq_covariance_q31(const kq_filter_q31 *f, kq_scaled_q31 *P)
{
    return filter_covariance(f, P);
}

kq_status kq_measurement_q31(const kq_filter_q31 *f, const kq_sensor_q31 *s, int32_t *z,
                             kq_scaled_q31 *S)
{
    return filter_measurement(f, s, z, S);
}

kq_status kq_innovation_q31(const kq_filter_q31 *f, const kq_sensor_q31 *s, const int32_t *z,
                            int32_t *e)
{
    return filter_innovation(f, s, z, e);
}

int32_t kq_measurement_low_q31(const kq_filter_q31 *f, const kq_sensor_q31 *s, int c)
{
    return filter_measurement_low(f, s, c);
}

kq_status kq_gain_q31(const kq_filter_q31 *f, const kq_sensor_q31 *s, kq_scaled_q31 *K)
{
    return filter_gain(f, s, K);
}

int64_t kq_nis_q31(const kq_filter_q31 *f) { return filter_nis(f); }

int kq_taken_q31(const kq_filter_q31 *f) { return filter_taken(f); }

int64_t kq_log_likelihood_last_q31(const kq_filter_q31 *f) { return filter_log_likelihood(f, 0); }

int64_t kq_log_likelihood_q31(const kq_filter_q31 *f) { return filter_log_likelihood(f, 1); }

kq_status kq_log_likelihood_scaled_q31(const kq_filter_q31 *f, kq_scaled_q31 *value)
{
    const kq_status status = filter_check(f);
    if (status) return status;
    if (!value) return KQ_ERR_NULL;
    *value = likelihood_run_log_scaled(&f->run);
    return KQ_OK;
}

unsigned kq_events_q31(const kq_filter_q31 *f) { return f ? f->events : 0; }

void kq_events_clear_q31(kq_filter_q31 *f)
{
    if (f) f->events = 0;
}

kq_status kq_forecast_q31(const kq_filter_q31 *f, const kq_process_q31 *p, const int32_t *u,
                          int steps, kq_filter_q31 *ahead)
{
    return filter_forecast(f, p, u, steps, ahead);
}

kq_status kq_filter_copy_q31(kq_filter_q31 *to, const kq_filter_q31 *from)
{
    return filter_copy(to, from);
}

kq_status kq_history_assign_q31(kq_history_q31 *h, int n, int32_t *memory, size_t length)
{
    return history_assign(h, n, memory, length);
}

kq_status kq_history_attach_q31(kq_history_q31 *h, kq_filter_q31 *f)
{
    return history_attach(h, f);
}

kq_status kq_history_detach_q31(kq_history_q31 *h) { return history_detach(h); }

size_t kq_history_steps_q31(const kq_history_q31 *h) { return h ? (size_t)h->steps : 0; }

kq_status kq_smooth_q31(kq_history_q31 *h) { return smooth_all(h, HISTORY_SMOOTHING); }

kq_status kq_smooth_states_q31(kq_history_q31 *h) { return smooth_all(h, HISTORY_STATES); }

kq_status kq_smooth_step_q31(kq_history_q31 *h, const kq_process_q31 *p,
                             const kq_smooth_extras_q31 *extras)
{
    return smooth_step(h, p, extras);
}

kq_status kq_smoothed_measurement_noise_q31(const kq_history_q31 *h, int k, kq_scaled_q31 *mean,
                                            kq_scaled_q31 *variance)
{
    return smoothed_measurement_noise(h, k, mean, variance);
}

int32_t kq_smoothed_mean_q31(const kq_history_q31 *h, size_t t, int i)
{
    return smoothed_mean(h, t, i);
}

int32_t kq_smoothed_mean_low_q31(const kq_history_q31 *h, size_t t, int i)
{
    return smoothed_mean_low(h, t, i);
}

int32_t kq_smoothed_sigma_q31(const kq_history_q31 *h, size_t t, int i)
{
    return smoothed_sigma(h, t, i);
}

unsigned kq_history_events_q31(const kq_history_q31 *h) { return h ? h->events : 0; }

kq_status kq_smoothed_covariance_q31(const kq_history_q31 *h, size_t t, kq_scaled_q31 *P)
{
    return smoothed_covariance(h, t, P);
}

#include "kq_robust_q31.inc"
#include "kq_on_line_q31.inc"
#include "kq_start_q31.inc"
