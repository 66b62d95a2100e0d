/*
 * The scales of the noises, learnt from innovations: recursive maximum likelihood over (log q, log r), scalar
 * measurement by scalar measurement.  Beside the filter run the slopes of P and x with log q,
 *
 *     D- = A D A' + q Q        D+ = (I - K H) D- (I - K H)'
 *     d- = A d                 d+ = (I - K H) (d- + D- H' nu / sqrt(s))
 *
 * with log r they are P - D and -d, as a gain stays where q and r grow together.  A scalar measurement, of innovation e
 * and variance s, has with nu = e / sqrt(s), a = H D- H' / s, y = H d- / sqrt(s), nu and y within -4 .. 4, the scores
 * and the information
 *
 *     g_q = a (nu^2 - 1) / 2 + nu y              J_qq = a^2 / 2 + y^2
 *     g_r = (1 - a) (nu^2 - 1) / 2 - nu y        J_rr = (1 - a)^2 / 2 + y^2
 *                                                J_qr = a (1 - a) / 2 - y^2
 *
 * nu^2 says how large both scales are together; nu y, whether innovations are white, which of the two is too small.
 * Summed over the measurements of an update,
 *
 *     J <- (1 - 1/M) J + J(z)        (c_q, c_r) = (J + 4 I)^-1 (g_q, g_r)
 *     q <- q (1 + c_q) where c_q >= 0, q / (1 + |c_q|) where c_q < 0, and so r by c_r
 *
 * which is log q += c_q to first order, the same up as down, without an exponential.  4 is the information that the
 * scales are worth before anything is measured.  |c_q| and |c_r| count up to `step`.  Where one scale alone is learnt
 * J_qr counts as 0.
 */
#ifndef KQ_SRC_ADAPTATION_ADAPTATION_H
#define KQ_SRC_ADAPTATION_ADAPTATION_H

#include "slopes.h"

/* ------------------------------------------------------------------ predict */

/* The adaptation that is attached to f.  A copy of its filter goes on without it. */
static adaptation *adaptation_of(filter *f)
{
    adaptation *a = (adaptation *)f->attached;
    if (a->filter == f) return a;
    filter_set_attached(f, 0);
    return 0;
}

static kq_status adaptation_check_predict(const adaptation *a, const filter *f, const num *u)
{
    const kq_status status = predict_check(f, a->process, u);
    return status ? status : process_at_scale(a, a->process, a->process_scale);
}

/* Another process predicts as it is, and teaches nothing. */
static kq_status adaptation_predict(filter *f, const process *p, const num *u)
{
    adaptation *a = adaptation_of(f);
    if (!a || p != a->process) return predict_alone(f, p, u);
    kq_status status = adaptation_check_predict(a, f, u);
    if (status) return status;
    scale_process(a);
    status = predict_alone(f, &a->scaled_process, u);
    advance_covariance(covariance_slope(a), &a->scaled_process);
    advance(mean_slope(a), 1, &a->scaled_process);
    return status;
}

/* ------------------------------------------------------------------ learning */

/* scale <- scale (1 + move), or as much down, within its limits */
static scaled moved_scale(const adaptation *a, scaled scale, scaled move, scaled least, scaled most)
{
    if (!scaled_is_finite(move)) return scale;
    move = within(move, a->rule.step);
    const scaled factor = scaled_plus(scaled_one, scaled_magnitude(move));
    scale = scaled_is_negative(move) ? scaled_over(scale, factor) : scaled_times(scale, factor);
    if (scaled_is_less(scale, least)) return least;
    return scaled_is_less(most, scale) ? most : scale;
}

/* (J + WORTH I)^-1 g; where one scale is learnt, as if the other said nothing */
static void find_moves(const adaptation *a, const lesson *l, scaled *process_move,
                       scaled *sensor_move)
{
    const scaled none = {0}, worth = scaled_of_count(WORTH);
    const scaled qq = scaled_plus(a->information[0], worth);
    const scaled rr = scaled_plus(a->information[2], worth);
    const scaled qr = a->rule.scales == KQ_ADAPT_BOTH ? a->information[1] : none;
    const scaled determinant = scaled_minus(scaled_times(qq, rr), squared(qr));
    const scaled q = scaled_minus(scaled_times(rr, l->process), scaled_times(qr, l->sensor));
    const scaled r = scaled_minus(scaled_times(qq, l->sensor), scaled_times(qr, l->process));
    *process_move = a->rule.scales == KQ_ADAPT_SENSOR ? none : scaled_over(q, determinant);
    *sensor_move = a->rule.scales == KQ_ADAPT_PROCESS ? none : scaled_over(r, determinant);
}

static void learn(adaptation *a, const lesson *l)
{
    scaled process_move, sensor_move;
    const adaptation_rule *rule = &a->rule;
    const scaled memory = scaled_of_count(rule->memory);
    for (int k = 0; k < 3; k++) {
        const scaled old = a->information[k];
        const scaled change = scaled_minus(l->information[k], scaled_over(old, memory));
        a->information[k] = scaled_plus(old, change);
    }
    find_moves(a, l, &process_move, &sensor_move);
    a->process_scale =
        moved_scale(a, a->process_scale, process_move, rule->process_least, rule->process_most);
    a->sensor_scale =
        moved_scale(a, a->sensor_scale, sensor_move, rule->sensor_least, rule->sensor_most);
}

/* Has a measurement, or a state that nothing measures, led beyond what can be represented? */
static int is_lost(const adaptation *a, const lesson *l)
{
    const int n = a->states;
    int lost = !scaled_is_finite(l->process) || !scaled_is_finite(l->sensor);
    for (int k = 0; k < 3; k++) lost |= !scaled_is_finite(l->information[k]);
    for (int k = 0; k < n * n + n; k++) lost |= !scaled_is_finite(a->memory[k]);
    return lost;
}

static void take_lesson(adaptation *a, const lesson *l)
{
    if (is_lost(a, l)) begin_anew(a);
    else if (a->waiting) a->waiting = (uint8_t)(l->count < a->waiting ? a->waiting - l->count : 0);
    else if (l->count) learn(a, l);
}

static kq_status adaptation_check_update(const adaptation *a, const filter *f, const num *z,
                                         uint32_t present)
{
    const kq_status status = update_check(f, a->sensor, z, present);
    return status ? status : sensor_at_scale(a, a->sensor, a->sensor_scale);
}

/* Another sensor updates as it is, and teaches nothing. */
static kq_status adaptation_update(filter *f, const sensor *given, const num *z, uint32_t present)
{
    lesson l = {.count = 0};
    adaptation *a = adaptation_of(f);
    if (!sensor_check(given) && takes_innovations(given)) return KQ_ERR_RECORDING;
    if (!a || given != a->sensor) return update_alone(f, given, z, present);
    kq_status status = adaptation_check_update(a, f, z, present);
    if (status) return status;
    scale_sensor(a);
    const sensor *s = &a->scaled_sensor;
    const reading now = {s, s->noise, z, present};
    if (noise_is_of_others(s, present)) study_present(a, f, &now, &l);
    else study_scalars(a, f, &now, &l);
    status = update_alone(f, s, z, present);
    take_lesson(a, &l);
    return status;
}

static kq_status adaptation_step(filter *f, const process *p, const num *u, const sensor *s, const num *z)
{
    kq_status status = step_check(f, p, u, s, z);
    if (!status) status = takes_measurements(s, KQ_ERR_RECORDING);
    const adaptation *a = adaptation_of(f);
    if (!status && a && p == a->process) status = adaptation_check_predict(a, f, u);
    if (!status && a && s == a->sensor) status = adaptation_check_update(a, f, z, UINT32_MAX);
    if (!status) status = T(kq_predict)(f, p, u);
    return status ? status : T(kq_update)(f, s, z);
}

/* ------------------------------------------------------------------ the object */

static kq_status adaptation_attach(filter *f, attached *object)
{
    adaptation *a = (adaptation *)object;
    kq_status status = adaptation_check(a);
    if (!status) status = filter_check(f);
    if (status) return status;
    if (f->states != a->states) return KQ_ERR_MISMATCH;
    if (has_other_filter(a->filter, f) || has_other_attached(f, &a->attached)) return KQ_ERR_RECORDING;
    begin_anew(a);
    a->filter = f;
    filter_set_attached(f, &a->attached);
    return KQ_OK;
}

static kq_status adaptation_detach(attached *object)
{
    adaptation *a = (adaptation *)object;
    const kq_status status = adaptation_check(a);
    if (status) return status;
    if (a->filter && a->filter->attached == &a->attached) filter_set_attached(a->filter, 0);
    a->filter = 0;
    return KQ_OK;
}

const hooks T(kq_adaptation_hooks) = {
    .attach = adaptation_attach, .detach = adaptation_detach, .predict = adaptation_predict, .update = adaptation_update, .step = adaptation_step,
    KQ_RECORDS_NOTHING};

kq_status T(kq_adaptation_scales)(const adaptation *a, scaled *q, scaled *r)
{
    const kq_status status = adaptation_check(a);
    if (status) return status;
    if (q) *q = a->process_scale;
    if (r) *r = a->sensor_scale;
    return KQ_OK;
}

#endif
