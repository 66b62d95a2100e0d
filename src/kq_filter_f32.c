/*
 * kalmanq in float: the algorithm over arithmetic/f32.h, and its public names.
 */
#include "arithmetic/f32.h"

#include "arithmetic/root.h"

#include "model/process.h"
#include "model/advance.h"
#include "filter/rotate.h"

#include "model/units.h"
#include "model/sensor.h"
#include "filter/likelihood.h"
#include "filter/filter.h"

#include "model/factor.h"
#include "model/definitions.h"
#include "filter/prior.h"

#include "filter/checks.h"
#include "filter/readings.h"
#include "filter/measured.h"
#include "filter/tape.h"

#include "filter/match.h"
#include "filter/sharp.h"
#include "filter/take.h"
#include "filter/independent.h"
#include "filter/correlated.h"
#include "filter/step.h"
#include "filter/gain.h"
#include "filter/forecast.h"
#include "smoother/whitened.h"
#include "smoother/smoother.h"

#include "robust/parameters.h"
#include "robust/robust.h"
#include "robust/gate.h"
#include "robust/student_scale.h"
#include "robust/student_step.h"
#include "robust/reweighted.h"

#include "smoother/map.h"
#include "smoother/estimate.h"
#include "smoother/on_line.h"
#include "smoother/lag.h"
#include "smoother/point.h"

#include "start/entries.h"
#include "start/unknown.h"
#include "start/rounding.h"
#include "start/columns.h"
#include "start/past.h"
#include "start/take.h"
#include "start/start.h"
#include "start/smooth.h"
#include "start/prior.h"

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
    return sensor_init_diagonal(s, &T(kq_sensor_independent), H, r);
}

kq_status kq_sensor_init_lean_f32(kq_sensor_f32 *s, const float *H, const float *r)
{
    return sensor_init_diagonal(s, &T(kq_sensor_lean), H, r);
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

/* The public names of updates and steps against outliers and jumps. */

kq_status kq_update_gated_f32(kq_filter_f32 *f, kq_gate_f32 *g, const kq_sensor_f32 *s,
                              const float *z, uint32_t present)
{
    return filter_update_gated(f, g, s, z, present);
}

float kq_chi_square_limit_f32(int m, kq_level level) { return chi_square_limit(m, level); }

kq_status kq_update_huber_f32(kq_filter_f32 *f, const kq_sensor_f32 *s, const float *z,
                              uint32_t present, float k, float *weights)
{
    return filter_update_huber(f, s, z, present, k, weights);
}

kq_status kq_update_student_f32(kq_filter_f32 *f, const kq_sensor_f32 *s, const float *z,
                                uint32_t present, float nu, float *weights)
{
    return filter_update_student(f, s, z, present, nu, weights);
}

kq_status kq_update_jump_f32(kq_filter_f32 *f, const kq_sensor_f32 *s, const float *z,
                             uint32_t present, float g)
{
    return filter_update_jump(f, s, z, present, g);
}

kq_status kq_step_student_f32(kq_filter_f32 *f, const kq_process_f32 *p, const float *u,
                              const kq_sensor_f32 *s, const float *z, uint32_t present, float nu,
                              kq_process_f32 *target, float *q)
{
    return filter_step_student(f, &(student_step){p, u, s, z, present, nu, target, 0}, q);
}

kq_status kq_process_scale_noise_f32(kq_process_f32 *target, const kq_process_f32 *source, float q)
{
    return process_scale_noise(target, source, q, 0);
}

kq_status kq_smooth_reweighted_f32(kq_history_f32 *h, kq_process_f32 *target,
                                   const kq_process_f32 *source, float nu, float *q)
{
    return smooth_reweighted(h, target, source, 0, nu, q);
}

/* The public names of the smoothers on line. */

kq_status kq_lag_assign_f32(kq_lag_f32 *lag, int n, int m, int L, float *memory, size_t length)
{
    return lag_assign(lag, n, m, L, memory, length);
}

kq_status kq_lag_attach_f32(kq_lag_f32 *lag, kq_filter_f32 *f) { return lag_attach(lag, f); }

kq_status kq_lag_detach_f32(kq_lag_f32 *lag) { return lag_detach(lag); }

kq_status kq_lag_predict_f32(kq_lag_f32 *lag, const kq_process_f32 *p, const float *u)
{
    return lag_predict(lag, p, u);
}

int kq_lag_steps_f32(const kq_lag_f32 *lag) { return lag_steps(lag); }

kq_status kq_lag_smooth_f32(kq_lag_f32 *lag, int k) { return lag_smooth(lag, k, 0); }

kq_status kq_lag_smooth_states_f32(kq_lag_f32 *lag, int k) { return lag_smooth(lag, k, 1); }

float kq_lag_mean_f32(const kq_lag_f32 *lag, int i)
{
    return lag_is_smoothed(lag) ? answer_mean(&lag->tape, i) : num_nan();
}

float kq_lag_mean_low_f32(const kq_lag_f32 *lag, int i)
{
    return lag_is_smoothed(lag) ? answer_mean_low(&lag->tape, i) : num_nan();
}

float kq_lag_sigma_f32(const kq_lag_f32 *lag, int i)
{
    return lag_is_smoothed(lag) ? answer_sigma(&lag->tape, lag->columns, i) : num_nan();
}

kq_status kq_lag_covariance_f32(const kq_lag_f32 *lag, float *P)
{
    return lag ? answer_covariance(&lag->tape, lag->columns, P) : KQ_ERR_NULL;
}

kq_status kq_point_assign_f32(kq_point_f32 *point, int n, int m, float *memory, size_t length)
{
    return point_assign(point, n, m, memory, length);
}

kq_status kq_point_attach_f32(kq_point_f32 *point, kq_filter_f32 *f)
{
    return point_attach(point, f);
}

kq_status kq_point_detach_f32(kq_point_f32 *point) { return point_detach(point); }

kq_status kq_point_predict_f32(kq_point_f32 *point, const kq_process_f32 *p, const float *u)
{
    return point_predict(point, p, u);
}

kq_status kq_point_smooth_f32(kq_point_f32 *point) { return point_smooth(point); }

float kq_point_mean_f32(const kq_point_f32 *point, int i)
{
    return point_is_smoothed(point) ? answer_mean(&point->tape, i) : num_nan();
}

float kq_point_mean_low_f32(const kq_point_f32 *point, int i)
{
    return point_is_smoothed(point) ? answer_mean_low(&point->tape, i) : num_nan();
}

float kq_point_sigma_f32(const kq_point_f32 *point, int i)
{
    return point_is_smoothed(point) ? answer_sigma(&point->tape, point->columns, i) : num_nan();
}

kq_status kq_point_covariance_f32(const kq_point_f32 *point, float *P)
{
    return point ? answer_covariance(&point->tape, point->columns, P) : KQ_ERR_NULL;
}

/* The public names of the unknown start. */

kq_status kq_start_assign_f32(kq_start_f32 *s, int n, size_t early, float *memory, size_t length)
{
    return start_assign(s, n, early, memory, length);
}

kq_status kq_start_init_f32(kq_start_f32 *s, kq_filter_f32 *f, const float *x0, const float *P0,
                            uint32_t unknown)
{
    return start_init(s, f, x0, P0, unknown);
}

kq_status kq_start_attach_f32(kq_start_f32 *s, kq_history_f32 *h) { return start_attach(s, h); }

kq_status kq_start_detach_f32(kq_start_f32 *s) { return start_detach(s); }

kq_status kq_start_predict_f32(kq_start_f32 *s, const kq_process_f32 *p, const float *u)
{
    return start_predict(s, p, u);
}

kq_status kq_start_update_f32(kq_start_f32 *s, const kq_sensor_f32 *by, const float *z)
{
    return start_update(s, by, z, UINT32_MAX);
}

kq_status kq_start_update_subset_f32(kq_start_f32 *s, const kq_sensor_f32 *by, const float *z,
                                     uint32_t present)
{
    return start_update(s, by, z, present);
}

int kq_start_count_f32(const kq_start_f32 *s) { return start_count(s); }

int kq_start_is_determined_f32(const kq_start_f32 *s, int i) { return start_is_determined(s, i); }

float kq_start_mean_f32(const kq_start_f32 *s, int i) { return start_mean(s, i); }

float kq_start_mean_low_f32(const kq_start_f32 *s, int i) { return start_mean_low(s, i); }

float kq_start_sigma_f32(const kq_start_f32 *s, int i) { return start_sigma(s, i); }

float kq_start_log_likelihood_last_f32(const kq_start_f32 *s) { return start_log_likelihood(s, 0); }

float kq_start_log_likelihood_f32(const kq_start_f32 *s) { return start_log_likelihood(s, 1); }

size_t kq_start_steps_f32(const kq_start_f32 *s) { return start_check(s) ? 0 : (size_t)s->steps; }

size_t kq_start_first_f32(const kq_start_f32 *s)
{
    return start_check(s) ? 0 : (size_t)start_first(s);
}

kq_status kq_start_smooth_f32(kq_start_f32 *s) { return start_smooth(s); }

float kq_start_smoothed_mean_f32(const kq_start_f32 *s, size_t t, int i)
{
    return start_smoothed_mean(s, t, i);
}

float kq_start_smoothed_mean_low_f32(const kq_start_f32 *s, size_t t, int i)
{
    return start_smoothed_mean_low(s, t, i);
}

float kq_start_smoothed_sigma_f32(const kq_start_f32 *s, size_t t, int i)
{
    return start_smoothed_sigma(s, t, i);
}

kq_status kq_start_smoothed_covariance_f32(const kq_start_f32 *s, size_t t, float *P)
{
    return start_smoothed_covariance(s, t, P);
}

