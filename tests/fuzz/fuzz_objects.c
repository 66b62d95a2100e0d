/*
 * Calls of the library made of bytes: every object of f32, f64 (KQ_FUZZ_F64) or q31 (KQ_FUZZ_Q31), 1 to 16 states, attached,
 * used and detached in any order, with numbers from ordinary to absurd, q31's tables corrupted, too; or a law of a tame
 * model (laws.h).  For libFuzzer, and for replay.c, which runs the recorded inputs every day, under the sanitizers.
 *
 * What must hold after every call: a refused one has changed nothing; the filter is intact; a mean or sigma that is not
 * finite has its event; P is positive semi-definite; smoothed it is not above the filtered one; a step is predict and
 * update.  Memory has exactly the lengths that the headers say.
 */
#include "laws.h"

enum { STEPS = 12, LAG = 3, WINDOW = 4, OBJECTS = 8, PROCESSES = 3, CHANGES = 2, TOLD = KQ_EVENT_OVERFLOW | KQ_EVENT_SATURATED /* what is shown is a limit */ };

static struct {
    int n, l, m[SENSORS], rare; /* rare: calls that cost much were asked for */
    num A[PROCESSES][SQUARE], B[SQUARE], Q[SQUARE], H[SENSORS][SQUARE], R[SENSORS][SQUARE], P0[SQUARE];
    word x0[MOST];
    entry gain[SQUARE], weights[MOST];
    K(process) process[PROCESSES], scaled;
    K(sensor) sensor[SENSORS];
    K(filter) filter, twin, ahead;
    K(history) history;
    K(jacobians) jacobians;
    K(lag) lag, delay;
    K(instant) instant;
    K(adaptation) adaptation;
    K(freeze) freeze;
    K(diffuse) diffuse;
    K(consistency) consistency;
    K(loss) gate;
    entry filtered[STEPS][SQUARE]; /* of the steps of the history, 0 where they were not looked at */
    size_t noted;
} own;

/* ------------------------------------------------------------------ what must hold */

static K(filter) before;
static word memory_before[LENGTH(FILTER)(MOST)];

static void note(void)
{
    const size_t t = K(history_steps)(&own.history) - 1;
    before = own.filter;
    memcpy(memory_before, own.filter.memory, sizeof(word) * (size_t)LENGTH(FILTER)(own.n));
    if (own.filter.attached != &own.history.attached || t >= STEPS) return;
    if (t + 1 < own.noted) own.noted = 0;
    while (own.noted <= t) memset(own.filtered[own.noted++], 0, sizeof *own.filtered);
    (void)!K(covariance)(&own.filter, own.filtered[t]);
}

/* A refused call has changed nothing */
static kq_status judged(kq_status status)
{
    DEMAND(strcmp(kq_status_text(status), "unknown status") != 0 && status != KQ_ERR_ARITHMETIC);
    if (status < 0) {
        DEMAND(memcmp(&before, &own.filter, sizeof before) == 0);
        DEMAND(memcmp(memory_before, own.filter.memory, sizeof(word) * (size_t)LENGTH(FILTER)(own.n)) == 0);
    }
    return status;
}

static void look_at(const K(filter) *f)
{
    entry P[SQUARE];
    (void)!sane(f, P);
}

/* ------------------------------------------------------------------ objects */

static void make_models(void)
{
    const int n = own.n = states = size_drawn(), l = own.l = (int)below(3);
    choose_formats(0);
    numbers(own.B, n * l);
    covariance(own.Q, n);
    for (int k = 0; k < PROCESSES; k++) {
        numbers(own.A[k], n * n);
        for (int i = 0; byte() < 200 && i < n; i++) own.A[k][i * n + i] = 1;
        (void)!put_process(&own.process[k], n, l, own.A[k], own.B, own.Q);
    }
    for (unsigned k = 0; k < SENSORS; k++) {
        const int m = own.m[k] = k ? (int)below(4) + 1 : size_drawn();
        numbers(own.H[k], m * n);
        covariance(own.R[k], m);
        (void)!put_sensor(&own.sensor[k], k < 3 ? k : 3 + below(3), n, m, own.H[k], own.R[k]);
    }
}

static void make_filters(void)
{
    K(filter) *const all[] = {&own.filter, &own.twin, &own.ahead};
    const size_t length = (size_t)LENGTH(FILTER)(own.n);
    for (int k = 0; k < 3; k++) DEMAND(K(filter_assign)(all[k], own.n, words(length), length) == KQ_OK);
    state_words(own.x0, own.n);
    covariance(own.P0, own.n);
    note();
    (void)!judged(put_prior(&own.filter, own.n, own.x0, own.P0));
}

static void make_objects(void)
{
    const int n = own.n, m = own.m[0];
    size_t length = LENGTH(HISTORY)(n, m, below(STEPS) + 1, below(3));
    DEMAND(K(history_assign)(&own.history, n, words(length), length) == KQ_OK);
    length = (size_t)LENGTH(JACOBIANS)(n, CHANGES, below(CHANGES) + 1);
    DEMAND(K(jacobians_assign)(&own.jacobians, &own.history, n, KEEP(K(process), CHANGES), CHANGES, words(length), length) == KQ_OK);
    length = LENGTH(LAG)(n, m, LAG);
    DEMAND(K(lag_assign)(&own.lag, n, m, LAG, words(length), length) == KQ_OK);
    DEMAND(K(delay_assign)(&own.delay, n, m, LAG, words(length), length) == KQ_OK);
    length = LENGTH(INSTANT)(n, m);
    DEMAND(K(instant_assign)(&own.instant, n, m, words(length), length) == KQ_OK);
    assign_adaptation(&own.adaptation, n, own.m[1]);
    const entry tenth = entry_of((num)0.1), least = entry_of((num)0.001), most = entry_of(1000);
    const K(adaptation_rule) rule = {(kq_adapted)below(3), 100, tenth, least, most, least, most};
    (void)!K(adaptation_init)(&own.adaptation, &own.process[0], &own.sensor[1], &rule);
    length = (size_t)LENGTH(FREEZE)(n);
    DEMAND(K(freeze_assign)(&own.freeze, n, m, words(length), length, own.gain) == KQ_OK);
    (void)!K(freeze_init)(&own.freeze, (int)below(19));
    length = LENGTH(DIFFUSE)(n, 3);
    DEMAND(K(diffuse_assign)(&own.diffuse, n, 3, words(length), length) == KQ_OK);
    length = (size_t)LENGTH(CONSISTENCY)(m, WINDOW);
    DEMAND(K(consistency_assign)(&own.consistency, m, WINDOW, words(length), length) == KQ_OK);
}

static struct K(attached) *object(void)
{
    struct K(attached) *of[OBJECTS] = {&own.history.attached, &own.lag.attached, &own.delay.attached, &own.instant.attached,
        &own.adaptation.attached, &own.freeze.attached, &own.diffuse.attached, &own.jacobians.attached};
    return of[below(OBJECTS)];
}

/* ------------------------------------------------------------------ calls */

/* A step is predict and update, bit for bit */
static void step_of(const K(process) *p, const word *u, const K(sensor) *s, const word *z)
{
    const int is_alone = !own.filter.attached && K(filter_copy)(&own.twin, &own.filter) == KQ_OK;
    const kq_status status = judged(K(step)(&own.filter, p, u, s, z));
    if (!is_alone || status < 0) return;
    DEMAND(K(predict)(&own.twin, p, u) >= 0 && K(update)(&own.twin, s, z) >= 0);
    DEMAND(memcmp(own.twin.memory, own.filter.memory, sizeof(word) * (size_t)LENGTH(FILTER)(own.n)) == 0);
    DEMAND(K(events)(&own.twin) == K(events)(&own.filter));
}

/* What a gate rejects changes no state; beside innovations the two words of a mean may be rounded anew. */
static void update_by_loss(const K(sensor) *s, const word *z, uint32_t present)
{
    const unsigned rejected = own.gate.rejected;
    (void)!judged(K(update_robust)(&own.filter, s, z, present, &own.gate));
    if (own.gate.rejected > rejected && s != &own.sensor[SENSORS - 1]) DEMAND(memcmp(memory_before, own.filter.memory, sizeof(word) * (size_t)LENGTH(FILTER)(own.n)) == 0);
}

/* An update whose consistency is watched: a mean NIS is not negative, its bounds are in order, a correlation is within 1. */
static void watch(const K(sensor) *s, const word *z, uint32_t present)
{
    score nis, low, high, correlation;
    const int is_watched = K(consistency_watch)(&own.consistency, &own.filter, s, z, present) == KQ_OK;
    (void)!judged(K(update_subset)(&own.filter, s, z, present));
    if (is_watched) (void)!K(consistency_record)(&own.consistency, &own.filter);
    if (K(consistency_nis)(&own.consistency, limit_of(2), &nis, &low, &high) == KQ_OK) DEMAND(nis >= 0 && low >= 0 && low <= high);
    if (K(consistency_innovation)(&own.consistency, (int)below(4), limit_of(2), &nis, &low, &correlation, &high) == KQ_OK)
        DEMAND(fabs((double)correlation) <= (double)limit_of(1) * (1 + ROUNDING));
}

static void update(unsigned how)
{
    const K(sensor) *s = &own.sensor[below(SENSORS)];
    const K(process) *p = &own.process[below(8) == 7];
    word z[MOST] = {0}, room[MOST] = {0}, *u = below(4) ? room : NULL;
    const uint32_t present = byte() < 200 ? UINT32_MAX : byte();
    sensor_words(z, s), control_words(room, p);
    if (below(2)) (void)!K(measurement)(&own.filter, s, z, NULL); /* as it is expected */
    switch (how) {
    case 0: (void)!judged(K(update)(&own.filter, s, z)); break;
    case 1: (void)!judged(K(update_subset)(&own.filter, s, z, present)); break;
    case 2: update_by_loss(s, z, present); break;
    case 3: (void)!judged(K(predict)(&own.filter, p, u)); break;
    case 4: watch(s, z, present); break;
    case 5: (void)!K(update_delayed)(&own.delay, below(LAG + 1), s, z, present); break;
    default: step_of(p, u, s, z);
    }
}

#ifndef KQ_FUZZ_Q31
/* A step by sigma points, in one call */
static void step_by_sigma_points(const K(process) *p, const K(sensor) *s)
{
    const int is_predict = (int)below(2), m = s->components;
    num *work = words(KQ_SIGMA_POINTS_LEN((size_t)own.n, (size_t)m));
    const kq_sigma_points rule = a_rule();
    function g;
    make_function(&g, &own.filter, is_predict ? own.n : m);
    check_function(&g, judged(is_predict ? K(predict_sigma_points)(&own.filter, p, call_function, &g, rule, work)
                                         : K(update_sigma_points)(&own.filter, s, call_function, &g, rule, work)));
}

/* The same by its parts, linearised at the filter or at a view */
static void predict_by_parts_of(const K(filter) *where, const K(process) *p)
{
    const size_t length = KQ_PROCESS_LEN((size_t)own.n);
    K(process) found;
    linearised g;
    if (linearise(where, own.n, &g) != KQ_OK) return;
    DEMAND(K(process_assign)(&found, own.n, 0, words(length), length) == KQ_OK);
    for (int i = 0; i < own.n; i++) g.J[i * (own.n + 1)] += 1;
    if (K(process_linearise)(&found, p, g.J, g.E) == KQ_OK) (void)!judged(K(predict_extended)(&own.filter, &found, g.y));
}

static void update_by_parts_of(const K(filter) *where, const K(sensor) *s)
{
    const int m = s->components;
    const size_t length = (size_t)KQ_SENSOR_LEN(m);
    K(sensor) found;
    linearised g;
    if (linearise(where, m, &g) != KQ_OK) return;
    DEMAND(K(sensor_assign)(&found, own.n, m, words(length), length) == KQ_OK);
    if (K(sensor_linearise)(&found, s, g.J, g.E, KEEP(num, m * m)) == KQ_OK) (void)!judged(K(update)(&own.filter, &found, g.y));
}
#endif

static void step_nonlinear(void)
{
    const K(process) *p = &own.process[below(PROCESSES)];
    word d[MOST];
#ifndef KQ_FUZZ_Q31
    const K(sensor) *s = &own.sensor[below(SENSORS)];
    const K(filter) *where = &own.filter;
    K(filter) view;
    if (below(4) == 0 && K(smoothed)(&own.history, below(STEPS), &view) == KQ_OK) where = &view;
    switch (below(4)) {
    case 0:
    case 1: step_by_sigma_points(p, s); return;
    case 2: predict_by_parts_of(where, p); return;
    default: if (below(2)) { update_by_parts_of(where, s); return; }
    }
#endif
    state_words(d, own.n);
    (void)!judged(K(predict_extended)(&own.filter, p, d));
}

static void change(void)
{
    static const struct K(loss_kind) *const kinds[] = {&K(loss_huber), &K(loss_student), &K(loss_jump), &K(loss_gate)};
    word d[MOST];
    switch (below(8)) {
    case 0: (void)!change_transition(&own.process[1], own.n); break;
    case 1: (void)!change_measurement(&own.sensor[below(SENSORS)], own.n); break;
    case 2: own.gate = (K(loss)){.kind = kinds[below(sizeof kinds / sizeof *kinds)], .parameter = entry_of(number()), .weights = own.weights, .limit = below(2) ? K(chi_square_limit)(1, KQ_LEVEL_95) : limit_of(number()), .run = (uint16_t)below(4)}; break;
    case 3: (void)!scale_noise(&own.scaled, &own.process[0], own.n, entry_of(number())); break;
    case 4: state_words(d, own.n), (void)!judged(K(move)(&own.filter, d)); break;
    case 5: (void)!change_jacobian(&own.process[2], own.n); break;
    case 6: (void)!judged(K(forget)(&own.filter, entry_of(number()))); break;
    default: state_words(own.x0, own.n), (void)!judged(put_prior(&own.filter, own.n, own.x0, own.P0));
    }
}

/* A step with all that it can write */
static kq_status smooth_with_extras(void)
{
    static entry lag_one[SQUARE], mean[MOST], noise[SQUARE];
    const K(smooth_extras) extras = {lag_one, mean, noise};
    const int is_first = own.history.step == own.history.steps, n = own.n;
    const kq_status status = K(smooth_step)(&own.history, NULL, &extras);
    K(filter) view;
    entry one, variance;
    if (status != KQ_OK || is_first || own.history.step + 1 >= own.history.steps) return status;
    if (K(smoothed)(&own.history, own.history.step, &view) == KQ_OK && !(K(events)(&view) & TOLD)) {
        check_entries(lag_one, n * n), check_entries(mean, n), check_entries(noise, n * n);
        check_covariance(noise, n);
    }
    for (int k = 0; K(smoothed_measurement_noise)(&own.history, k, &one, &variance) == KQ_OK; k++) DEMAND(!is_negative(variance));
    return status;
}

static void smooth(void)
{
    K(filter) view;
    entry q[STEPS], P[SQUARE];
    const unsigned how = below(4);
    for (int t = 0; t < STEPS; t++) q[t] = entry_of(1);
    const kq_status status = how == 0 ? K(smooth)(&own.history) : how == 1 ? K(smooth_states)(&own.history)
        : how == 2 && K(history_steps)(&own.history) <= STEPS ? smooth_reweighted(&own.history, &own.scaled, &own.process[0], entry_of(4), q)
                                                           : smooth_with_extras();
    for (size_t t = 0; status >= 0 && t < K(history_steps)(&own.history); t++) {
        if (K(smoothed)(&own.history, t, &view) != KQ_OK || !sane(&view, P)) continue;
        if (how != 2 && t < STEPS && !(K(events)(&view) & TOLD)) check_not_above(P, own.filtered[t], own.n);
    }
}

static void measure(const K(sensor) *s)
{
    entry S[SQUARE];
    word e[MOST];
    if (K(measurement)(&own.filter, s, e, S) == KQ_OK && !(K(events)(&own.filter) & TOLD))
        for (int c = 0; c < s->components; c++) DEMAND(!is_negative(S[c * (s->components + 1)]));
    (void)!K(gain)(&own.filter, s, S);
}

static void look(void)
{
    K(filter) view;
    word e[MOST], z[MOST] = {0}, u[4 * MOST] = {0};
    const K(sensor) *s = &own.sensor[below(SENSORS)];
    switch (below(7)) {
    case 0: smooth(); break;
    case 1: if (K(lagged)(&own.lag, below(LAG + 2), &view) == KQ_OK) look_at(&view); break;
    case 2: if (K(instant_smooth)(&own.instant, &view) == KQ_OK) look_at(&view); break;
    case 3: control_words(u, &own.process[0]); if (K(forecast)(&own.filter, &own.process[0], below(3) ? u : NULL, below(5), &own.ahead) >= 0) look_at(&own.ahead); break;
    case 4: measure(s); break;
    case 5: sensor_words(z, s), (void)!K(innovation)(&own.filter, s, z, e), K(events_clear)(&own.filter); break;
    default:
        (void)!K(consistency_record)(&own.consistency, &own.filter);
        if (K(diffuse_smooth)(&own.diffuse) < 0) break;
        for (size_t t = 0; t < 3; t++)
            if (K(diffuse_smoothed)(&own.diffuse, t, &view) == KQ_OK && !(K(events)(&own.filter) & TOLD)) look_at(&view);
    }
}

#ifndef KQ_FUZZ_Q31
static void learn_all(void)
{
    static learning e;
    const num *const from[PARAMETERS] = {own.A[1], own.H[1], own.Q, own.R[1], own.x0, own.P0};
    const int r = below(2) ? (int)below((unsigned)own.n) + 1 : 0;
    num F[SQUARE];
    if (r) numbers(F, own.n * r);
    e.n = own.n, e.m = own.m[1];
    learn_from(&e, own.l, own.l ? keep_numbers(own.B, own.n * own.l) : NULL, r, r ? keep_numbers(F, own.n * r) : NULL, from);
    if (r) covariance(e.now[2], r), memcpy(e.first[2], e.now[2], sizeof(num) * (size_t)(r * r));
    mirror_covariances(&e), choose_free(&e), record(&e, own.l);
    go_on_learning(&e);
}

static void solve(void)
{
    const size_t length = LENGTH(STEADY_SOLVE)(own.n, own.m[1]);
    num P[2][SQUARE], gains[2][SQUARE];
    const K(steady_solution) out = {P[0], P[1], gains[0], gains[1]};
    (void)!K(steady_solve)(&own.process[0], &own.sensor[1], words(length), length, &out);
}
#endif

/* Scales that are learnt stay within their limits. */
static void check_scales(void)
{
    entry q, r;
    if (K(adaptation_scales)(&own.adaptation, &q, &r) != KQ_OK) return;
    DEMAND(value_of(q) > 0.000999 && value_of(q) < 1000.001 && value_of(r) > 0.000999 && value_of(r) < 1000.001);
}

/* One process or one sensor alone for long: what grows is held, what shrinks stays a covariance. */
static void go_on_for_long(void)
{
    word z[MOST] = {0};
    const K(sensor) *s = &own.sensor[below(SENSORS)];
    const int is_predict = (int)below(2);
    sensor_words(z, s);
    for (int k = 0; k < 1200 / (own.n + 3); k++) {
        const kq_status status = is_predict ? K(predict)(&own.filter, &own.process[0], NULL) : K(update)(&own.filter, s, z);
        if (status < 0) return;
    }
}

/* What is dear, or needs memory of its own */
static void rare(unsigned op)
{
    if (own.rare++ % 4 || count_kept > 270) return;
    if (below(8) == 7) go_on_for_long();
#ifdef KQ_FUZZ_Q31
    (void)op;
#else
    if (op) learn_all();
    else solve();
#endif
}

static void call(void)
{
    if (count_kept > 280) return;
    note();
    const unsigned op = below(36);
    if (op < 4) update(3);
    else if (op < 14) update(op % 7);
    else if (op < 17) change();
    else if (op < 20) (void)!judged(K(attach)(&own.filter, object())) /* what was attached goes */;
    else if (op < 22) (void)!K(detach)(object());
    else if (op < 29) look();
    else if (op < 30) (void)!judged(begin_start(&own.diffuse, &own.filter, own.n, own.x0, own.P0, byte() | byte() << 8));
    else if (op < 32) rare(op & 1);
    else step_nonlinear();
    if (own.filter.ready) DEMAND(K(filter_check)(&own.filter) == KQ_OK);
    check_scales();
    look_at(&own.filter);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    at = data, end = data + size;
    if (byte() < 64) {
        check_a_law();
    } else {
        memset(&own, 0, sizeof own);
        own.gate = (K(loss)){.kind = &K(loss_gate), .limit = K(chi_square_limit)(1, KQ_LEVEL_95)};
        make_models(), make_filters(), make_objects();
        for (int k = 0; k < 60 && at < end; k++) call();
    }
    while (count_kept) free(kept[--count_kept]);
    return 0;
}
