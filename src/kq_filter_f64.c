/*
 * kalmanq in double: the algorithm over arithmetic/f64.h, and its public names.
 */
#include "arithmetic/has_double.h"

#if KQ_HAS_DOUBLE
#include "arithmetic/f64.h"

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
    return sensor_init_diagonal(s, &T(kq_sensor_independent), H, r);
}

kq_status kq_sensor_init_lean_f64(kq_sensor_f64 *s, const double *H, const double *r)
{
    return sensor_init_diagonal(s, &T(kq_sensor_lean), H, r);
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

/* The public names of updates and steps against outliers and jumps. */

kq_status kq_update_gated_f64(kq_filter_f64 *f, kq_gate_f64 *g, const kq_sensor_f64 *s,
                              const double *z, uint32_t present)
{
    return filter_update_gated(f, g, s, z, present);
}

double kq_chi_square_limit_f64(int m, kq_level level) { return chi_square_limit(m, level); }

kq_status kq_update_huber_f64(kq_filter_f64 *f, const kq_sensor_f64 *s, const double *z,
                              uint32_t present, double k, double *weights)
{
    return filter_update_huber(f, s, z, present, k, weights);
}

kq_status kq_update_student_f64(kq_filter_f64 *f, const kq_sensor_f64 *s, const double *z,
                                uint32_t present, double nu, double *weights)
{
    return filter_update_student(f, s, z, present, nu, weights);
}

kq_status kq_update_jump_f64(kq_filter_f64 *f, const kq_sensor_f64 *s, const double *z,
                             uint32_t present, double g)
{
    return filter_update_jump(f, s, z, present, g);
}

kq_status kq_step_student_f64(kq_filter_f64 *f, const kq_process_f64 *p, const double *u,
                              const kq_sensor_f64 *s, const double *z, uint32_t present, double nu,
                              kq_process_f64 *target, double *q)
{
    return filter_step_student(f, &(student_step){p, u, s, z, present, nu, target, 0}, q);
}

kq_status kq_process_scale_noise_f64(kq_process_f64 *target, const kq_process_f64 *source, double q)
{
    return process_scale_noise(target, source, q, 0);
}

kq_status kq_smooth_reweighted_f64(kq_history_f64 *h, kq_process_f64 *target,
                                   const kq_process_f64 *source, double nu, double *q)
{
    return smooth_reweighted(h, target, source, 0, nu, q);
}

/* The public names of the smoothers on line. */

kq_status kq_lag_assign_f64(kq_lag_f64 *lag, int n, int m, int L, double *memory, size_t length)
{
    return lag_assign(lag, n, m, L, memory, length);
}

kq_status kq_lag_attach_f64(kq_lag_f64 *lag, kq_filter_f64 *f) { return lag_attach(lag, f); }

kq_status kq_lag_detach_f64(kq_lag_f64 *lag) { return lag_detach(lag); }

kq_status kq_lag_predict_f64(kq_lag_f64 *lag, const kq_process_f64 *p, const double *u)
{
    return lag_predict(lag, p, u);
}

int kq_lag_steps_f64(const kq_lag_f64 *lag) { return lag_steps(lag); }

kq_status kq_lag_smooth_f64(kq_lag_f64 *lag, int k) { return lag_smooth(lag, k, 0); }

kq_status kq_lag_smooth_states_f64(kq_lag_f64 *lag, int k) { return lag_smooth(lag, k, 1); }

double kq_lag_mean_f64(const kq_lag_f64 *lag, int i)
{
    return lag_is_smoothed(lag) ? answer_mean(&lag->tape, i) : num_nan();
}

double kq_lag_mean_low_f64(const kq_lag_f64 *lag, int i)
{
    return lag_is_smoothed(lag) ? answer_mean_low(&lag->tape, i) : num_nan();
}

double kq_lag_sigma_f64(const kq_lag_f64 *lag, int i)
{
    return lag_is_smoothed(lag) ? answer_sigma(&lag->tape, lag->columns, i) : num_nan();
}

kq_status kq_lag_covariance_f64(const kq_lag_f64 *lag, double *P)
{
    return lag ? answer_covariance(&lag->tape, lag->columns, P) : KQ_ERR_NULL;
}

kq_status kq_point_assign_f64(kq_point_f64 *point, int n, int m, double *memory, size_t length)
{
    return point_assign(point, n, m, memory, length);
}

kq_status kq_point_attach_f64(kq_point_f64 *point, kq_filter_f64 *f)
{
    return point_attach(point, f);
}

kq_status kq_point_detach_f64(kq_point_f64 *point) { return point_detach(point); }

kq_status kq_point_predict_f64(kq_point_f64 *point, const kq_process_f64 *p, const double *u)
{
    return point_predict(point, p, u);
}

kq_status kq_point_smooth_f64(kq_point_f64 *point) { return point_smooth(point); }

double kq_point_mean_f64(const kq_point_f64 *point, int i)
{
    return point_is_smoothed(point) ? answer_mean(&point->tape, i) : num_nan();
}

double kq_point_mean_low_f64(const kq_point_f64 *point, int i)
{
    return point_is_smoothed(point) ? answer_mean_low(&point->tape, i) : num_nan();
}

double kq_point_sigma_f64(const kq_point_f64 *point, int i)
{
    return point_is_smoothed(point) ? answer_sigma(&point->tape, point->columns, i) : num_nan();
}

kq_status kq_point_covariance_f64(const kq_point_f64 *point, double *P)
{
    return point ? answer_covariance(&point->tape, point->columns, P) : KQ_ERR_NULL;
}

/* The public names of the unknown start. */

kq_status kq_start_assign_f64(kq_start_f64 *s, int n, size_t early, double *memory, size_t length)
{
    return start_assign(s, n, early, memory, length);
}

kq_status kq_start_init_f64(kq_start_f64 *s, kq_filter_f64 *f, const double *x0, const double *P0,
                            uint32_t unknown)
{
    return start_init(s, f, x0, P0, unknown);
}

kq_status kq_start_attach_f64(kq_start_f64 *s, kq_history_f64 *h) { return start_attach(s, h); }

kq_status kq_start_detach_f64(kq_start_f64 *s) { return start_detach(s); }

kq_status kq_start_predict_f64(kq_start_f64 *s, const kq_process_f64 *p, const double *u)
{
    return start_predict(s, p, u);
}

kq_status kq_start_update_f64(kq_start_f64 *s, const kq_sensor_f64 *by, const double *z)
{
    return start_update(s, by, z, UINT32_MAX);
}

kq_status kq_start_update_subset_f64(kq_start_f64 *s, const kq_sensor_f64 *by, const double *z,
                                     uint32_t present)
{
    return start_update(s, by, z, present);
}

int kq_start_count_f64(const kq_start_f64 *s) { return start_count(s); }

int kq_start_is_determined_f64(const kq_start_f64 *s, int i) { return start_is_determined(s, i); }

double kq_start_mean_f64(const kq_start_f64 *s, int i) { return start_mean(s, i); }

double kq_start_mean_low_f64(const kq_start_f64 *s, int i) { return start_mean_low(s, i); }

double kq_start_sigma_f64(const kq_start_f64 *s, int i) { return start_sigma(s, i); }

double kq_start_log_likelihood_last_f64(const kq_start_f64 *s)
{
    return start_log_likelihood(s, 0);
}

double kq_start_log_likelihood_f64(const kq_start_f64 *s) { return start_log_likelihood(s, 1); }

size_t kq_start_steps_f64(const kq_start_f64 *s) { return start_check(s) ? 0 : (size_t)s->steps; }

size_t kq_start_first_f64(const kq_start_f64 *s)
{
    return start_check(s) ? 0 : (size_t)start_first(s);
}

kq_status kq_start_smooth_f64(kq_start_f64 *s) { return start_smooth(s); }

double kq_start_smoothed_mean_f64(const kq_start_f64 *s, size_t t, int i)
{
    return start_smoothed_mean(s, t, i);
}

double kq_start_smoothed_mean_low_f64(const kq_start_f64 *s, size_t t, int i)
{
    return start_smoothed_mean_low(s, t, i);
}

double kq_start_smoothed_sigma_f64(const kq_start_f64 *s, size_t t, int i)
{
    return start_smoothed_sigma(s, t, i);
}

kq_status kq_start_smoothed_covariance_f64(const kq_start_f64 *s, size_t t, double *P)
{
    return start_smoothed_covariance(s, t, P);
}


#endif
