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

#include "../robust/robust.h"
#if KQ_FLOATING
#include "adaptation_float.h"
#else
#include "adaptation_q31.h"
#endif

typedef T(kq_adaptation_rule) adaptation_rule;

/* What the scales as given are worth, as information; and how far nu and its slope count. */
enum { WORTH = 4, MOST = 4 };

/* The memory: D = dP / d log q, n x n; d = dx / d log q; then, of an update's scalar measurements
   as they are taken, k = P h / sqrt(s), m x n, and nu = e / sqrt(s); the noise of the scaled
   sensor, as in the sensor that was given. */
static scaled *covariance_slope(const adaptation *a) { return a->memory; }
static scaled *mean_slope(const adaptation *a) { return a->memory + a->states * a->states; }
static scaled *scalar_gains(const adaptation *a) { return mean_slope(a) + a->states; }

static scaled *scalar_units(const adaptation *a)
{
    return scalar_gains(a) + a->components * a->states;
}

static scaled *sensor_noise(const adaptation *a) { return scalar_units(a) + a->components; }

/* ------------------------------------------------------------------ checks */

static kq_status limits_check(scaled least, scaled most)
{
    kq_status status = parameter_check(least);
    if (!status) status = parameter_check(most);
    if (status) return status;
    const int holds_1 = !scaled_is_less(scaled_one, least) && !scaled_is_less(most, scaled_one);
    return holds_1 ? KQ_OK : KQ_ERR_RANGE;
}

static kq_status rule_check(const adaptation_rule *rule)
{
    const int scales = (int)rule->scales;
    if (rule->memory < KQ_ADAPTATION_MEMORY_MIN) return KQ_ERR_SIZE;
    if (rule->memory > KQ_ADAPTATION_MEMORY_MAX) return KQ_ERR_SIZE;
    if (scales < KQ_ADAPT_BOTH || scales > KQ_ADAPT_SENSOR) return KQ_ERR_RANGE;
    kq_status status = parameter_check(rule->step);
    if (status) return status;
    if (scaled_is_less(scaled_one, rule->step)) return KQ_ERR_RANGE;
    status = limits_check(rule->process_least, rule->process_most);
    return status ? status : limits_check(rule->sensor_least, rule->sensor_most);
}

static kq_status process_at_scale(const adaptation *a, const process *p, scaled q)
{
    const kq_status status = process_check(p);
    if (status) return status;
    if (p->states != a->states) return KQ_ERR_MISMATCH;
    const process target = process_to_scale(a);
    return scaled_noise_check(&target, p, process_root(a), scaled_root(q));
}

static kq_status sensor_at_scale(const adaptation *a, const sensor *s, scaled r)
{
    const kq_status status = sensor_check(s);
    if (status) return status;
    if (s->states != a->states || s->components != a->components) return KQ_ERR_MISMATCH;
    return sensor_scale_check(s, r);
}

static kq_status models_check(const adaptation *a, const process *p, const sensor *s,
                              const adaptation_rule *rule)
{
    kq_status status = process_at_scale(a, p, rule->process_least);
    if (!status) status = process_at_scale(a, p, rule->process_most);
    if (!status) status = sensor_at_scale(a, s, rule->sensor_least);
    if (!status) status = sensor_at_scale(a, s, rule->sensor_most);
    if (status) return status;
    return models_agree(p, s) ? KQ_OK : KQ_ERR_MISMATCH;
}

static kq_status adaptation_check(const adaptation *a)
{
    if (!a) return KQ_ERR_NULL;
    return a->process ? KQ_OK : KQ_ERR_NOT_READY;
}

/* ------------------------------------------------------------------ the scaled models */

static void begin_anew(adaptation *a)
{
    static const scaled zero;
    const int n = a->states;
    for (int k = 0; k < n * n + n; k++) a->memory[k] = zero; /* D, d */
    a->waiting = (uint8_t)n;
}

kq_status T(kq_adaptation_init)(adaptation *a, const process *p, const sensor *s,
                                const adaptation_rule *rule)
{
    static const scaled zero;
    if (!a || !p || !s || !rule) return KQ_ERR_NULL;
    if (!size_is_valid(a->states) || !size_is_valid(a->components)) return KQ_ERR_SIZE;
    if (!adaptation_has_memory(a)) return KQ_ERR_MEMORY;
    if ((int)a->length < ADAPTATION_LEN(a->states, a->components)) return KQ_ERR_MEMORY;
    kq_status status = rule_check(rule);
    if (!status) status = models_check(a, p, s, rule);
    if (status) return status;
    a->process = p;
    a->sensor = s;
    a->rule = *rule;
    a->process_scale = scaled_one;
    a->sensor_scale = scaled_one;
    for (int k = 0; k < 3; k++) a->information[k] = zero;
    a->scaled_process = process_to_scale(a);
    begin_anew(a);
    return KQ_OK;
}

static void scale_process(adaptation *a)
{
    set_scaled_noise(&a->scaled_process, a->process, process_root(a),
                     scaled_root(a->process_scale));
}

static void scale_sensor(adaptation *a)
{
    set_scaled_sensor(a, a->sensor, a->sensor_scale, sensor_noise(a));
    if (sensor_is_correlated(a->sensor)) return;
    /* What teaches is taken: a lean sensor refuses some of it. */
    a->scaled_sensor.kind = &T(kq_sensor_independent);
}

const process *T(kq_adaptation_process)(adaptation *a)
{
    if (adaptation_check(a) || process_at_scale(a, a->process, a->process_scale)) return 0;
    scale_process(a);
    return &a->scaled_process;
}

const sensor *T(kq_adaptation_sensor)(adaptation *a)
{
    if (adaptation_check(a) || sensor_at_scale(a, a->sensor, a->sensor_scale)) return 0;
    scale_sensor(a);
    return &a->scaled_sensor;
}

/* ------------------------------------------------------------------ predict */

/* (A v)_i; v: `stride` apart */
static scaled transition_times(const process *p, int i, const scaled *v, int stride)
{
    const scaled *row = p->transition + i * p->states;
    scaled total = {0};
    for (int k = p->first[i]; k < p->states; k++) {
        if (scaled_is_zero(row[k])) continue;
        total = scaled_plus(total, scaled_times(row[k], v[k * stride]));
    }
    return total;
}

/* v <- A v */
static void advance(scaled *v, int stride, const process *p)
{
    scaled moved[KQ_SIZE_MAX];
    const int n = p->states;
    for (int i = 0; i < n; i++) moved[i] = scaled_saturated(transition_times(p, i, v, stride));
    for (int i = 0; i < n; i++) v[i * stride] = moved[i];
}

/* The lower triangle as the upper one */
static void mirror_triangle(scaled *D, int n)
{
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < i; j++) D[i * n + j] = D[j * n + i];
    }
}

/* D <- A D A' + G G': columns, then what is needed of the rows */
static void advance_covariance(scaled *D, const process *p)
{
    scaled moved[KQ_SIZE_MAX];
    const int n = p->states;
    for (int j = 0; j < n; j++) advance(D + j, n, p);
    for (int i = 0; i < n; i++) {
        for (int j = i; j < n; j++) {
            const scaled noise = root_product(p->noise_root, n, i, j);
            moved[j] = scaled_plus(transition_times(p, j, D + i * n, 1), noise);
        }
        for (int j = i; j < n; j++) D[i * n + j] = scaled_saturated(moved[j]);
    }
    mirror_triangle(D, n);
}

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

/* ------------------------------------------------------------------ what an update says */

/* Scores and information of an update */
typedef struct {
    scaled process, sensor;
    scaled information[3];
    int count; /* scalar measurements */
} lesson;

/* One scalar measurement */
typedef struct {
    const scaled *h;
    scaled r, whole; /* its noise; its variance without the others of the update */
    scaled *k;       /* P h, then P h / sqrt(s) */
    scaled *unit;    /* its innovation, then nu */
} scalar;

static scaled inner(const scaled *h, const scaled *v, int n)
{
    scaled total = {0};
    for (int i = 0; i < n; i++) {
        if (scaled_is_zero(h[i])) continue;
        total = scaled_plus(total, scaled_times(h[i], v[i]));
    }
    return total;
}

/* v <- v - c w */
static void subtract(scaled *v, scaled c, const scaled *w, int n)
{
    for (int i = 0; i < n; i++) v[i] = scaled_minus(v[i], scaled_times(c, w[i]));
}

static scaled half(scaled a) { return scaled_shift(a, -1); }

static scaled squared(scaled a) { return scaled_times(a, a); }

/* Within -most .. most */
static scaled within(scaled a, scaled most)
{
    if (!scaled_is_less(most, scaled_magnitude(a))) return a;
    return scaled_is_negative(a) ? scaled_negative(most) : most;
}

/* P h = S (S'h), and h'P h + r */
static void begin_scalar(scalar *one, const filter *f)
{
    num F[ROW_LEN(KQ_SIZE_MAX)];
    const num *S = filter_root(f);
    const int n = f->states;
    project(F, S, one->h, n);
    root_times_row(one->k, S, F, n);
    one->whole = scaled_plus(row_product(F, F, n), one->r);
}

/* P h and e as they are after the `count` scalar measurements before it */
static void follow(scalar *one, const adaptation *a, int count)
{
    const int n = a->states;
    for (int j = 0; j < count; j++) {
        const scaled *before = scalar_gains(a) + j * n;
        const scaled along = inner(one->h, before, n);
        *one->unit = scaled_minus(*one->unit, scaled_times(along, scalar_units(a)[j]));
        subtract(one->k, along, before, n);
    }
}

/* Divides by sqrt(s); answers 1 / sqrt(s), or 0 where the others explain s up to rounding. */
static scaled normalise(scalar *one, int n)
{
    const scaled none = {0};
    const scaled s = scaled_plus(inner(one->h, one->k, n), one->r);
    if (scaled_is_negative(s) || !scaled_is_less(num_zero_variance, s)) return none;
    if (!scaled_is_less(scaled_times(one->whole, scaled_rounding()), s)) return none;
    const scaled over_sigma = scaled_over(scaled_one, scaled_root(s));
    for (int i = 0; i < n; i++) one->k[i] = scaled_times(one->k[i], over_sigma);
    *one->unit = scaled_times(*one->unit, over_sigma);
    return scaled_is_finite(over_sigma) && scaled_is_finite(*one->unit) ? over_sigma : none;
}

/* nu; a; y */
static void add_scores(lesson *l, scaled unit, scaled share, scaled slope)
{
    const scaled rest = scaled_minus(scaled_one, share), steep = squared(slope);
    const scaled excess = half(scaled_minus(squared(unit), scaled_one));
    const scaled along = scaled_times(unit, slope);
    scaled *J = l->information;
    l->process = scaled_plus(l->process, scaled_plus(scaled_times(share, excess), along));
    l->sensor = scaled_plus(l->sensor, scaled_minus(scaled_times(rest, excess), along));
    J[0] = scaled_plus(J[0], scaled_plus(half(squared(share)), steep));
    J[1] = scaled_plus(J[1], scaled_minus(half(scaled_times(share, rest)), steep));
    J[2] = scaled_plus(J[2], scaled_plus(half(squared(rest)), steep));
    l->count++;
}

/* D <- (I - K h') D (I - K h')'; v = D h / sqrt(s), a = h'v / sqrt(s) */
static void correct_covariance(scaled *D, const scaled *k, const scaled *v, scaled share, int n)
{
    for (int i = 0; i < n; i++) {
        const scaled w = scaled_minus(v[i], scaled_times(share, k[i]));
        for (int j = i; j < n; j++) {
            const scaled part = scaled_plus(scaled_times(w, k[j]), scaled_times(k[i], v[j]));
            D[i * n + j] = scaled_minus(D[i * n + j], part);
        }
    }
    mirror_triangle(D, n);
}

/* What a scalar measurement, normalised, says; then D and d as they are after it. */
static void study(adaptation *a, const scalar *one, scaled over_sigma, lesson *l)
{
    scaled v[KQ_SIZE_MAX];
    const int n = a->states;
    scaled *D = covariance_slope(a), *d = mean_slope(a);
    for (int i = 0; i < n; i++) v[i] = scaled_times(inner(one->h, D + i * n, n), over_sigma);
    const scaled most = scaled_of_count(MOST), unit = within(*one->unit, most);
    const scaled slope = scaled_times(inner(one->h, d, n), over_sigma);
    scaled share = scaled_times(inner(one->h, v, n), over_sigma);
    if (scaled_is_negative(share)) share = (scaled){0}; /* but for rounding it is in 0 .. 1 */
    if (scaled_is_less(scaled_one, share)) share = scaled_one;
    add_scores(l, unit, share, within(slope, most));
    const scaled back = scaled_plus(slope, scaled_times(share, unit));
    for (int i = 0; i < n; i++) {
        const scaled part = scaled_minus(scaled_times(v[i], unit), scaled_times(one->k[i], back));
        d[i] = scaled_plus(d[i], part);
    }
    correct_covariance(D, one->k, v, share, n);
}

static void study_scalars(adaptation *a, const filter *f, const reading *z, lesson *l)
{
    scaled buffer[KQ_SIZE_MAX];
    for (int c = 0; c < a->components; c++) {
        if (!(z->present >> c & 1)) continue;
        scalar one = {.h = scalar_row(z, c, buffer),
                      .r = scalar_noise(z, c),
                      .k = scalar_gains(a) + l->count * a->states,
                      .unit = scalar_units(a) + l->count};
        *one.unit = scalar_innovation(f, z, c);
        begin_scalar(&one, f);
        follow(&one, a, l->count);
        const scaled over_sigma = normalise(&one, a->states);
        if (!scaled_is_zero(over_sigma)) study(a, &one, over_sigma, l);
    }
}

/* Correlated, with components missing: as in filter/step.h */
KQ_NOINLINE static void study_present(adaptation *a, const filter *f, const reading *z, lesson *l)
{
    scaled noise[KQ_TRIANGLE(KQ_SIZE_MAX)];
    noise_of_present(noise, z->sensor, z->present);
    const reading some = {z->sensor, noise, z->z, z->present};
    study_scalars(a, f, &some, l);
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
