/*
 * kalmanq in double: the algorithm over num_f64.h, and its public names.
 */
#include "has_double.h"

#if KQ_HAS_DOUBLE
#include "types_f64.h"

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

kq_status kq_process_assign_f64(kq_process_f64 *p, int n, int l, double *memory, size_t length)
{
    return process_assign(p, n, l, memory, length);
}

kq_status kq_process_init_f64(kq_process_f64 *p, const double *A, const double *B, const double *Q)
{
    return process_init(p, A, B, Q);
}

kq_status kq_process_init_factor_f64(kq_process_f64 *p, const double *A, const double *B,
                                     const double *F, int r)
{
    return process_init_factor(p, A, B, F, r);
}

kq_status kq_process_init_root_f64(kq_process_f64 *p, const double *A, const double *B,
                                   const double *G)
{
    return process_init_root(p, A, B, G);
}

kq_status kq_process_change_transition_f64(kq_process_f64 *p, const double *A)
{
    return process_change_transition(p, A);
}

kq_status kq_sensor_assign_f64(kq_sensor_f64 *s, int n, int m, double *memory, size_t length)
{
    return sensor_assign(s, n, m, memory, length);
}

kq_status kq_sensor_init_f64(kq_sensor_f64 *s, const double *H, const double *R)
{
    return sensor_init(s, H, R);
}

kq_status kq_sensor_init_diagonal_f64(kq_sensor_f64 *s, const double *H, const double *r)
{
    return sensor_init_diagonal(s, &SENSOR_INDEPENDENT, H, r);
}

kq_status kq_sensor_init_lean_f64(kq_sensor_f64 *s, const double *H, const double *r)
{
    return sensor_init_diagonal(s, &SENSOR_LEAN, H, r);
}

kq_status kq_sensor_change_measurement_f64(kq_sensor_f64 *s, const double *H)
{
    return sensor_change_measurement(s, H);
}

kq_status kq_filter_assign_f64(kq_filter_f64 *f, int n, double *memory, size_t length)
{
    return filter_assign(f, n, memory, length);
}

kq_status kq_filter_init_f64(kq_filter_f64 *f, const double *x0, const double *P0)
{
    return filter_init(f, x0, P0);
}

kq_status kq_filter_init_root_f64(kq_filter_f64 *f, const double *x0, const double *S)
{
    return filter_init_root(f, x0, S);
}

kq_status kq_predict_f64(kq_filter_f64 *f, const kq_process_f64 *p, const double *u)
{
    return filter_predict(f, p, u);
}

kq_status kq_update_f64(kq_filter_f64 *f, const kq_sensor_f64 *s, const double *z)
{
    return filter_update(f, s, z);
}

kq_status kq_update_subset_f64(kq_filter_f64 *f, const kq_sensor_f64 *s, const double *z,
                               uint32_t present)
{
    return filter_update_subset(f, s, z, present);
}

kq_status kq_step_f64(kq_filter_f64 *f, const kq_process_f64 *p, const double *u,
                      const kq_sensor_f64 *s, const double *z)
{
    return filter_step(f, p, u, s, z);
}

double kq_mean_f64(const kq_filter_f64 *f, int i) { return filter_mean(f, i); }

double kq_mean_low_f64(const kq_filter_f64 *f, int i) { return filter_mean_low(f, i); }

double kq_sigma_f64(const kq_filter_f64 *f, int i) { return filter_sigma(f, i); }

kq_status kq_covariance_f64(const kq_filter_f64 *f, double *P) { return filter_covariance(f, P); }

kq_status kq_measurement_f64(const kq_filter_f64 *f, const kq_sensor_f64 *s, double *z, double *S)
{
    return filter_measurement(f, s, z, S);
}

double kq_measurement_low_f64(const kq_filter_f64 *f, const kq_sensor_f64 *s, int c)
{
    return filter_measurement_low(f, s, c);
}

kq_status kq_innovation_f64(const kq_filter_f64 *f, const kq_sensor_f64 *s, const double *z,
                            double *e)
{
    return filter_innovation(f, s, z, e);
}

kq_status kq_gain_f64(const kq_filter_f64 *f, const kq_sensor_f64 *s, double *K)
{
    return filter_gain(f, s, K);
}

double kq_nis_f64(const kq_filter_f64 *f) { return filter_nis(f); }

int kq_taken_f64(const kq_filter_f64 *f) { return filter_taken(f); }

double kq_log_likelihood_last_f64(const kq_filter_f64 *f) { return filter_log_likelihood(f, 0); }

double kq_log_likelihood_f64(const kq_filter_f64 *f) { return filter_log_likelihood(f, 1); }

unsigned kq_events_f64(const kq_filter_f64 *f) { return f ? f->events : 0; }

void kq_events_clear_f64(kq_filter_f64 *f)
{
    if (f) f->events = 0;
}

kq_status kq_forecast_f64(const kq_filter_f64 *f, const kq_process_f64 *p, const double *u,
                          int steps, kq_filter_f64 *ahead)
{
    return filter_forecast(f, p, u, steps, ahead);
}

kq_status kq_filter_copy_f64(kq_filter_f64 *to, const kq_filter_f64 *from)
{
    return filter_copy(to, from);
}

kq_status kq_history_assign_f64(kq_history_f64 *h, int n, double *memory, size_t length)
{
    return history_assign(h, n, memory, length);
}

kq_status kq_history_attach_f64(kq_history_f64 *h, kq_filter_f64 *f)
{
    return history_attach(h, f);
}

kq_status kq_history_detach_f64(kq_history_f64 *h) { return history_detach(h); }

size_t kq_history_steps_f64(const kq_history_f64 *h) { return h ? (size_t)h->steps : 0; }

kq_status kq_smooth_f64(kq_history_f64 *h) { return smooth_all(h, HISTORY_SMOOTHING); }

kq_status kq_smooth_states_f64(kq_history_f64 *h) { return smooth_all(h, HISTORY_STATES); }

kq_status kq_smooth_step_f64(kq_history_f64 *h, const kq_process_f64 *p,
                             const kq_smooth_extras_f64 *extras)
{
    return smooth_step(h, p, extras);
}

kq_status kq_smoothed_measurement_noise_f64(const kq_history_f64 *h, int k, double *mean,
                                            double *variance)
{
    return smoothed_measurement_noise(h, k, mean, variance);
}

double kq_smoothed_mean_f64(const kq_history_f64 *h, size_t t, int i)
{
    return smoothed_mean(h, t, i);
}

double kq_smoothed_mean_low_f64(const kq_history_f64 *h, size_t t, int i)
{
    return smoothed_mean_low(h, t, i);
}

double kq_smoothed_sigma_f64(const kq_history_f64 *h, size_t t, int i)
{
    return smoothed_sigma(h, t, i);
}

unsigned kq_history_events_f64(const kq_history_f64 *h) { return h ? h->events : 0; }

kq_status kq_smoothed_covariance_f64(const kq_history_f64 *h, size_t t, double *P)
{
    return smoothed_covariance(h, t, P);
}

#include "kq_robust_f64.inc"
#include "kq_on_line_f64.inc"
#include "kq_start_f64.inc"

#endif
