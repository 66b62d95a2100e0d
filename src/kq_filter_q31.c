/*
 * kalmanq in fixed point: the algorithm over arithmetic/q31.h, and its public names.
 */
#include "arithmetic/q31.h"

#include "arithmetic/root.h"

#include "model/process.h"
#include "model/advance.h"
#include "filter/rotate.h"

#include "model/units.h"
#include "model/sensor.h"
#include "filter/likelihood.h"
#include "filter/filter.h"

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
    return sensor_init_diagonal(s, table, &T(kq_sensor_independent), misfit);
}

kq_status kq_sensor_init_lean_q31(kq_sensor_q31 *s, const kq_sensor_table_q31 *table,
                                  kq_misfit_q31 *misfit)
{
    return sensor_init_diagonal(s, table, &T(kq_sensor_lean), misfit);
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

/* The public names of updates and steps against outliers and jumps. */

kq_status kq_update_gated_q31(kq_filter_q31 *f, kq_gate_q31 *g, const kq_sensor_q31 *s,
                              const int32_t *z, uint32_t present)
{
    return filter_update_gated(f, g, s, z, present);
}

int64_t kq_chi_square_limit_q31(int m, kq_level level) { return chi_square_limit(m, level); }

kq_status kq_update_huber_q31(kq_filter_q31 *f, const kq_sensor_q31 *s, const int32_t *z,
                              uint32_t present, kq_scaled_q31 k, kq_scaled_q31 *weights)
{
    return filter_update_huber(f, s, z, present, k, weights);
}

kq_status kq_update_student_q31(kq_filter_q31 *f, const kq_sensor_q31 *s, const int32_t *z,
                                uint32_t present, kq_scaled_q31 nu, kq_scaled_q31 *weights)
{
    return filter_update_student(f, s, z, present, nu, weights);
}

kq_status kq_update_jump_q31(kq_filter_q31 *f, const kq_sensor_q31 *s, const int32_t *z,
                             uint32_t present, kq_scaled_q31 g)
{
    return filter_update_jump(f, s, z, present, g);
}

kq_status kq_step_student_q31(kq_filter_q31 *f, const kq_process_q31 *p, const int32_t *u,
                              const kq_sensor_q31 *s, const int32_t *z, uint32_t present,
                              kq_scaled_q31 nu, kq_process_q31 *target, int32_t *root,
                              kq_scaled_q31 *q)
{
    return filter_step_student(f, &(student_step){p, u, s, z, present, nu, target, root}, q);
}

kq_status kq_process_scale_noise_q31(kq_process_q31 *target, const kq_process_q31 *source,
                                     kq_scaled_q31 q, int32_t *root)
{
    return process_scale_noise(target, source, q, root);
}

kq_status kq_smooth_reweighted_q31(kq_history_q31 *h, kq_process_q31 *target,
                                   const kq_process_q31 *source, int32_t *root, kq_scaled_q31 nu,
                                   kq_scaled_q31 *q)
{
    return smooth_reweighted(h, target, source, root, nu, q);
}

/* The public names of the smoothers on line. */

kq_status kq_lag_assign_q31(kq_lag_q31 *lag, int n, int m, int L, int32_t *memory, size_t length)
{
    return lag_assign(lag, n, m, L, memory, length);
}

kq_status kq_lag_attach_q31(kq_lag_q31 *lag, kq_filter_q31 *f) { return lag_attach(lag, f); }

kq_status kq_lag_detach_q31(kq_lag_q31 *lag) { return lag_detach(lag); }

kq_status kq_lag_predict_q31(kq_lag_q31 *lag, const kq_process_q31 *p, const int32_t *u)
{
    return lag_predict(lag, p, u);
}

int kq_lag_steps_q31(const kq_lag_q31 *lag) { return lag_steps(lag); }

kq_status kq_lag_smooth_q31(kq_lag_q31 *lag, int k) { return lag_smooth(lag, k, 0); }

kq_status kq_lag_smooth_states_q31(kq_lag_q31 *lag, int k) { return lag_smooth(lag, k, 1); }

int32_t kq_lag_mean_q31(const kq_lag_q31 *lag, int i)
{
    return lag_is_smoothed(lag) ? answer_mean(&lag->tape, i) : num_nan();
}

int32_t kq_lag_mean_low_q31(const kq_lag_q31 *lag, int i)
{
    return lag_is_smoothed(lag) ? answer_mean_low(&lag->tape, i) : num_nan();
}

int32_t kq_lag_sigma_q31(const kq_lag_q31 *lag, int i)
{
    return lag_is_smoothed(lag) ? answer_sigma(&lag->tape, lag->columns, i) : num_nan();
}

kq_status kq_lag_covariance_q31(const kq_lag_q31 *lag, kq_scaled_q31 *P)
{
    return lag ? answer_covariance(&lag->tape, lag->columns, P) : KQ_ERR_NULL;
}

kq_status kq_point_assign_q31(kq_point_q31 *point, int n, int m, int32_t *memory, size_t length)
{
    return point_assign(point, n, m, memory, length);
}

kq_status kq_point_attach_q31(kq_point_q31 *point, kq_filter_q31 *f)
{
    return point_attach(point, f);
}

kq_status kq_point_detach_q31(kq_point_q31 *point) { return point_detach(point); }

kq_status kq_point_predict_q31(kq_point_q31 *point, const kq_process_q31 *p, const int32_t *u)
{
    return point_predict(point, p, u);
}

kq_status kq_point_smooth_q31(kq_point_q31 *point) { return point_smooth(point); }

int32_t kq_point_mean_q31(const kq_point_q31 *point, int i)
{
    return point_is_smoothed(point) ? answer_mean(&point->tape, i) : num_nan();
}

int32_t kq_point_mean_low_q31(const kq_point_q31 *point, int i)
{
    return point_is_smoothed(point) ? answer_mean_low(&point->tape, i) : num_nan();
}

int32_t kq_point_sigma_q31(const kq_point_q31 *point, int i)
{
    return point_is_smoothed(point) ? answer_sigma(&point->tape, point->columns, i) : num_nan();
}

kq_status kq_point_covariance_q31(const kq_point_q31 *point, kq_scaled_q31 *P)
{
    return point ? answer_covariance(&point->tape, point->columns, P) : KQ_ERR_NULL;
}

/* The public names of the unknown start. */

kq_status kq_start_assign_q31(kq_start_q31 *s, int n, size_t early, int32_t *memory, size_t length)
{
    return start_assign(s, n, early, memory, length);
}

kq_status kq_start_init_q31(kq_start_q31 *s, kq_filter_q31 *f, const kq_prior_table_q31 *prior,
                            uint32_t unknown, kq_misfit_q31 *misfit)
{
    return start_init(s, f, prior, unknown, misfit);
}

kq_status kq_start_attach_q31(kq_start_q31 *s, kq_history_q31 *h) { return start_attach(s, h); }

kq_status kq_start_detach_q31(kq_start_q31 *s) { return start_detach(s); }

kq_status kq_start_predict_q31(kq_start_q31 *s, const kq_process_q31 *p, const int32_t *u)
{
    return start_predict(s, p, u);
}

kq_status kq_start_update_q31(kq_start_q31 *s, const kq_sensor_q31 *by, const int32_t *z)
{
    return start_update(s, by, z, UINT32_MAX);
}

kq_status kq_start_update_subset_q31(kq_start_q31 *s, const kq_sensor_q31 *by, const int32_t *z,
                                     uint32_t present)
{
    return start_update(s, by, z, present);
}

int kq_start_count_q31(const kq_start_q31 *s) { return start_count(s); }

int kq_start_is_determined_q31(const kq_start_q31 *s, int i) { return start_is_determined(s, i); }

int32_t kq_start_mean_q31(const kq_start_q31 *s, int i) { return start_mean(s, i); }

int32_t kq_start_mean_low_q31(const kq_start_q31 *s, int i) { return start_mean_low(s, i); }

int32_t kq_start_sigma_q31(const kq_start_q31 *s, int i) { return start_sigma(s, i); }

int64_t kq_start_log_likelihood_last_q31(const kq_start_q31 *s)
{
    return start_log_likelihood(s, 0);
}

int64_t kq_start_log_likelihood_q31(const kq_start_q31 *s) { return start_log_likelihood(s, 1); }

size_t kq_start_steps_q31(const kq_start_q31 *s) { return start_check(s) ? 0 : (size_t)s->steps; }

size_t kq_start_first_q31(const kq_start_q31 *s)
{
    return start_check(s) ? 0 : (size_t)start_first(s);
}

kq_status kq_start_smooth_q31(kq_start_q31 *s) { return start_smooth(s); }

int32_t kq_start_smoothed_mean_q31(const kq_start_q31 *s, size_t t, int i)
{
    return start_smoothed_mean(s, t, i);
}

int32_t kq_start_smoothed_mean_low_q31(const kq_start_q31 *s, size_t t, int i)
{
    return start_smoothed_mean_low(s, t, i);
}

int32_t kq_start_smoothed_sigma_q31(const kq_start_q31 *s, size_t t, int i)
{
    return start_smoothed_sigma(s, t, i);
}

kq_status kq_start_smoothed_covariance_q31(const kq_start_q31 *s, size_t t, kq_scaled_q31 *P)
{
    return start_smoothed_covariance(s, t, P);
}

