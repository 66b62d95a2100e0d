/*
 * kalmanq in float: the algorithm over num_f32.h, and its public names.
 */
#include "types_f32.h"

#include "triangle.inc"

#include "process.inc"
#include "predict.inc"
#include "update.inc"

#include "fit_float.inc"
#include "sensor.inc"
#include "likelihood.inc"
#include "filter.inc"

#include "root.inc"
#include "model.inc"

#include "read.inc"
#include "measured_float.inc"
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

#include "robust_float.inc"
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
#include "start_float.inc"

kq_status kq_process_assign_f32(kq_process_f32 *p, int n, int l, float *memory, size_t length)
{
    return process_assign(p, n, l, memory, length);
}

kq_status kq_process_init_f32(kq_process_f32 *p, const float *A, const float *B, const float *Q)
{
    return process_init(p, A, B, Q);
}

kq_status kq_process_init_factor_f32(kq_process_f32 *p, const float *A, const float *B,
                                     const float *F, int r)
{
    return process_init_factor(p, A, B, F, r);
}

kq_status kq_process_init_root_f32(kq_process_f32 *p, const float *A, const float *B,
                                   const float *G)
{
    return process_init_root(p, A, B, G);
}

kq_status kq_process_change_transition_f32(kq_process_f32 *p, const float *A)
{
    return process_change_transition(p, A);
}

kq_status kq_sensor_assign_f32(kq_sensor_f32 *s, int n, int m, float *memory, size_t length)
{
    return sensor_assign(s, n, m, memory, length);
}

kq_status kq_sensor_init_f32(kq_sensor_f32 *s, const float *H, const float *R)
{
    return sensor_init(s, H, R);
}

kq_status kq_sensor_init_diagonal_f32(kq_sensor_f32 *s, const float *H, const float *r)
{
    return sensor_init_diagonal(s, &SENSOR_INDEPENDENT, H, r);
}

kq_status kq_sensor_init_lean_f32(kq_sensor_f32 *s, const float *H, const float *r)
{
    return sensor_init_diagonal(s, &SENSOR_LEAN, H, r);
}

kq_status kq_sensor_change_measurement_f32(kq_sensor_f32 *s, const float *H)
{
    return sensor_change_measurement(s, H);
}

kq_status kq_filter_assign_f32(kq_filter_f32 *f, int n, float *memory, size_t length)
{
    return filter_assign(f, n, memory, length);
}

kq_status kq_filter_init_f32(kq_filter_f32 *f, const float *x0, const float *P0)
{
    return filter_init(f, x0, P0);
}

kq_status kq_filter_init_root_f32(kq_filter_f32 *f, const float *x0, const float *S)
{
    return filter_init_root(f, x0, S);
}

kq_status kq_predict_f32(kq_filter_f32 *f, const kq_process_f32 *p, const float *u)
{
    return filter_predict(f, p, u);
}

kq_status kq_update_f32(kq_filter_f32 *f, const kq_sensor_f32 *s, const float *z)
{
    return filter_update(f, s, z);
}

kq_status kq_update_subset_f32(kq_filter_f32 *f, const kq_sensor_f32 *s, const float *z,
                               uint32_t present)
{
    return filter_update_subset(f, s, z, present);
}

kq_status kq_step_f32(kq_filter_f32 *f, const kq_process_f32 *p, const float *u,
                      const kq_sensor_f32 *s, const float *z)
{
    return filter_step(f, p, u, s, z);
}

float kq_mean_f32(const kq_filter_f32 *f, int i) { return filter_mean(f, i); }

float kq_mean_low_f32(const kq_filter_f32 *f, int i) { return filter_mean_low(f, i); }

float kq_sigma_f32(const kq_filter_f32 *f, int i) { return filter_sigma(f, i); }

kq_status kq_covariance_f32(const kq_filter_f32 *f, float *P) { return filter_covariance(f, P); }

kq_status kq_measurement_f32(const kq_filter_f32 *f, const kq_sensor_f32 *s, float *z, float *S)
{
    return filter_measurement(f, s, z, S);
}

float kq_measurement_low_f32(const kq_filter_f32 *f, const kq_sensor_f32 *s, int c)
{
    return filter_measurement_low(f, s, c);
}

kq_status kq_innovation_f32(const kq_filter_f32 *f, const kq_sensor_f32 *s, const float *z,
                            float *e)
{
    return filter_innovation(f, s, z, e);
}

kq_status kq_gain_f32(const kq_filter_f32 *f, const kq_sensor_f32 *s, float *K)
{
    return filter_gain(f, s, K);
}

float kq_nis_f32(const kq_filter_f32 *f) { return filter_nis(f); }

int kq_taken_f32(const kq_filter_f32 *f) { return filter_taken(f); }

float kq_log_likelihood_last_f32(const kq_filter_f32 *f) { return filter_log_likelihood(f, 0); }

float kq_log_likelihood_f32(const kq_filter_f32 *f) { return filter_log_likelihood(f, 1); }

unsigned kq_events_f32(const kq_filter_f32 *f) { return f ? f->events : 0; }

void kq_events_clear_f32(kq_filter_f32 *f)
{
    if (f) f->events = 0;
}

kq_status kq_forecast_f32(const kq_filter_f32 *f, const kq_process_f32 *p, const float *u,
                          int steps, kq_filter_f32 *ahead)
{
    return filter_forecast(f, p, u, steps, ahead);
}

kq_status kq_filter_copy_f32(kq_filter_f32 *to, const kq_filter_f32 *from)
{
    return filter_copy(to, from);
}

kq_status kq_history_assign_f32(kq_history_f32 *h, int n, float *memory, size_t length)
{
    return history_assign(h, n, memory, length);
}

kq_status kq_history_attach_f32(kq_history_f32 *h, kq_filter_f32 *f)
{
    return history_attach(h, f);
}

kq_status kq_history_detach_f32(kq_history_f32 *h) { return history_detach(h); }

size_t kq_history_steps_f32(const kq_history_f32 *h) { return h ? (size_t)h->steps : 0; }

kq_status kq_smooth_f32(kq_history_f32 *h) { return smooth_all(h, HISTORY_SMOOTHING); }

kq_status kq_smooth_states_f32(kq_history_f32 *h) { return smooth_all(h, HISTORY_STATES); }

kq_status kq_smooth_step_f32(kq_history_f32 *h, const kq_process_f32 *p,
                             const kq_smooth_extras_f32 *extras)
{
    return smooth_step(h, p, extras);
}

kq_status kq_smoothed_measurement_noise_f32(const kq_history_f32 *h, int k, float *mean,
                                            float *variance)
{
    return smoothed_measurement_noise(h, k, mean, variance);
}

float kq_smoothed_mean_f32(const kq_history_f32 *h, size_t t, int i)
{
    return smoothed_mean(h, t, i);
}

float kq_smoothed_mean_low_f32(const kq_history_f32 *h, size_t t, int i)
{
    return smoothed_mean_low(h, t, i);
}

float kq_smoothed_sigma_f32(const kq_history_f32 *h, size_t t, int i)
{
    return smoothed_sigma(h, t, i);
}

unsigned kq_history_events_f32(const kq_history_f32 *h) { return h ? h->events : 0; }

kq_status kq_smoothed_covariance_f32(const kq_history_f32 *h, size_t t, float *P)
{
    return smoothed_covariance(h, t, P);
}

#include "kq_robust_f32.inc"
#include "kq_on_line_f32.inc"
#include "kq_start_f32.inc"
