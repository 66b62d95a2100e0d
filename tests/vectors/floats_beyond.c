#include <math.h>

#include "floats.h"

enum {
    N = BEYOND_STATES,
    C = BEYOND_COMPONENTS,
    STEPS = 8,
    LAG = 4,
    GAINS = 12,
    EARLY = 3,
    EM_STEPS = 4
};

static K(process) target;
static num target_memory[KQ_PROCESS_LEN(N)];
static num pool[LEN(EM)(N, C, EM_STEPS)]; /* the longest of what is in use at a time */
static num early_memory[LEN(DIFFUSE)(N, EARLY)];
static num out[4][N * N];

_Static_assert(LENGTH(pool) >= LEN(INSTANT)(N, C), "instant");
_Static_assert(LENGTH(pool) >= LEN(HISTORY)(N, C, STEPS, STEPS), "history");
_Static_assert(LENGTH(pool) >= LEN(STEADY_SOLVE)(N, C), "solution");
_Static_assert(LENGTH(pool) >= LEN(CONSISTENCY)(C, STEPS), "consistency");
_Static_assert(LENGTH(pool) >= LEN(ADAPTATION)(N, C), "adaptation");
_Static_assert(LENGTH(pool) >= KQ_CORRELATED_LEN(N, 1, C), "correlated");
_Static_assert(LENGTH(pool) >= LEN(LAG)(N, C, LAG), "lag");

static void prepare(const model_case *c)
{
    make(c);
    put_status(K(process_init)(&process, M.A, M.l ? M.B : NULL, M.Q));
    put_status(K(process_assign)(&target, M.n, M.l, target_memory, LENGTH(target_memory)));
    put_status(K(sensor_init)(&sensor, M.H, M.R));
}

/* What answers it is not in the digests, unless it fails. */
static void need(kq_status status)
{
    if (status) put_status(status);
}

static void begin(void) { put_status(K(filter_init)(&filter, M.x0, M.P0)); }

static const num *draw_control(void)
{
    static num u;
    u = model_draw();
    return M.l ? &u : NULL;
}

/* Every fourth step is an outlier. */
static void draw_measurement(num *z, int t)
{
    for (int k = 0; k < M.m; k++) z[k] = 4 * scale * model_draw();
    if (t % 4 == 3) z[0] *= 64;
}

/* All components, or at some steps all but the first */
static uint32_t present_at(int t) { return UINT32_MAX << (t / 3 % 2); }

/* ------------------------------------------------------------------ smoothers on line */

static void put_lag(K(lag) * lag, size_t k, int states_only)
{
    K(filter) view;
    put_status(states_only ? K(lagged_states)(lag, k, &view) : K(lagged)(lag, k, &view));
    for (int i = 0; i < M.n; i++) {
        put(K(mean)(&view, i));
        put(K(mean_low)(&view, i));
        if (!states_only) put(K(sigma)(&view, i));
    }
    const kq_status status = K(covariance)(&view, out[0]);
    put_status(status);
    if (!status) put_all(out[0], M.n * M.n);
}

/* All lags, at some steps their means alone; or, where each second measurement comes one to LAG steps late, the longest one. */
static void lag(int is_late)
{
    K(lag) past;
    num z[C];
    begin();
    put_status((is_late ? K(delay_assign) : K(lag_assign))(&past, M.n, M.m, LAG, pool, LENGTH(pool)));
    put_status(K(attach)(&filter, &past.attached));
    for (int t = 0; t < STEPS; t++) {
        draw_measurement(z, t);
        if (is_late && t % 2) put_status(K(update_delayed)(&past, (size_t)(1 + t / 2 % LAG), &sensor, z, present_at(t)));
        else put_status(K(update_subset)(&filter, &sensor, z, present_at(t)));
        const size_t steps = K(lag_steps)(&past);
        for (size_t k = 0; k <= (is_late ? 0 : steps); k += 2) put_lag(&past, steps - k, !is_late && t % 3 == 1);
        put_status(K(predict)(&filter, &process, draw_control()));
        check(is_late ? "delay" : "lag", t);
    }
    put_filter(&filter, M.n, out[0]);
    check(is_late ? "filter of the delay" : "filter of the lag", STEPS);
}

/* The model's A as rates, of steps that are short, and long enough to be halved */
static void flow(void)
{
    static num root[KQ_PROCESS_LEN(N)], Qc[N * N];
    K(process) p;
    for (int k = 0; k < M.n * M.n; k++) Qc[k] = k % (M.n + 1) ? 0 : (num)0.5;
    put_status(K(process_assign)(&p, M.n, 0, root, LENGTH(root)));
    for (int t = 0; t < 3; t++) {
        const num dt = t ? (num)t * 2 : (num)0.0625;
        put_status(K(process_init_continuous)(&p, process.transition, NULL, Qc, dt, pool, LENGTH(pool)));
        put_all(pool, M.n * M.n);
        put_all(root, (int)KQ_PROCESS_LEN(M.n));
        check("flow", t);
    }
}

/* A share of the first component's noise is that of the first state; then that component is missing. */
static void drift(void)
{
    static num R[C * C], S[N * C];
    K(process) p;
    for (int k = 0; k < M.m * M.m; k++) R[k] = M.R[k];
    for (int k = 0; k < M.n * M.m; k++) S[k] = k % M.m ? 0 : M.Q[k / M.m * M.n] / 2;
    R[0] += M.Q[0] / 4;
    put_status(K(sensor_init)(&sensor, M.H, R));
    put_status(K(process_assign)(&p, M.n, M.l + M.m, pool, LENGTH(pool)));
    for (uint32_t missing = 0; missing < 2; missing++) {
        put_status(K(process_init_correlated)(&p, M.A, M.l ? M.B : NULL, M.Q, &sensor, S, UINT32_MAX - missing));
        put_all(pool, KQ_TRIANGLE(M.n) + M.n * (M.n + M.l + M.m));
        check("drift", (int)missing);
    }
}

static void put_instant(K(instant) * of)
{
    K(filter) view;
    put_status(K(instant_smooth)(of, &view));
    put_readings(&view, M.n);
    put_covariance(&view, M.n, out[0]);
}

static void point(void)
{
    K(instant) instant;
    num z[C];
    begin();
    put_status(K(instant_assign)(&instant, M.n, M.m, pool, LENGTH(pool)));
    put_status(K(attach)(&filter, &instant.attached));
    for (int t = 0; t < STEPS; t++) {
        draw_measurement(z, t);
        put_status(K(update_subset)(&filter, &sensor, z, present_at(t)));
        put_instant(&instant);
        put_status(K(predict)(&filter, &process, draw_control()));
        check("point", t);
    }
}

/* ------------------------------------------------------------------ steady states */

static num gains[GAINS * N * C];

static void solve(void)
{
    const K(steady_solution) solution = {out[0], out[1], out[2], out[3]};
    const kq_status status = K(steady_solve)(&process, &sensor, pool, LENGTH(pool), &solution);
    put_status(status);
    if (!status) {
        put_all(out[0], M.n * M.n);
        put_all(out[1], M.n * M.n);
        put_all(out[2], M.n * M.m);
        put_all(out[3], M.n * M.n);
    }
    check("steady state", 0);
}

/* The gains of the first updates behind the prior */
static void make_gains(void)
{
    static const num z[C];
    begin();
    for (int t = 0; t < GAINS; t++) {
        put_status(K(gain)(&filter, &sensor, gains + t * M.n * M.m));
        put_status(K(update)(&filter, &sensor, z));
        put_status(K(predict)(&filter, &process, NULL));
    }
    put_all(gains, GAINS * M.n * M.m);
    check("gains", 0);
}

static void put_steady(const K(steady) * steady)
{
    for (int i = 0; i < M.n; i++) put(K(steady_mean)(steady, i));
}

static void steady_filter(void)
{
    K(steady) steady;
    num z[C], e[C], mean[N];
    make_gains();
    put_status(K(steady_assign)(&steady, M.n, M.m, mean, N));
    put_status(K(steady_init)(&steady, &process, &sensor, M.x0, gains, GAINS));
    for (int t = 0; t < STEPS; t++) {
        draw_measurement(z, t);
        put_status(K(steady_innovation)(&steady, z, e));
        put_all(e, M.m);
        if (t == 0) put_status(K(steady_update)(&steady, z));
        else if (t == 5) put_status(K(steady_predict)(&steady, draw_control()));
        else put_status(K(steady_step)(&steady, draw_control(), z));
        put_steady(&steady);
    }
    check("steady-state filter", STEPS);
}

static void steady(void)
{
    solve();
    steady_filter();
}

/* Settles within the steps, mostly; then lacks a measurement. */
static void lazy(void)
{
    K(freeze) lazy;
    num z[C], memory[KQ_TRIANGLE(N)];
    begin();
    put_status(K(freeze_assign)(&lazy, M.n, M.m, memory, LENGTH(memory), gains));
    put_status(K(freeze_init)(&lazy, 4));
    need(K(attach)(&filter, &lazy.attached));
    for (int t = 0; t < 2 * STEPS; t++) {
        draw_measurement(z, 0);
        if (t == STEPS + 4) put_status(K(freeze_release)(&lazy));
        const num *u = draw_control();
        put_status(t == STEPS + 1 ? K(predict)(&filter, &process, u)
                                  : K(step)(&filter, &process, u, &sensor, z));
        put_word((uint32_t)K(freeze_is_active)(&lazy));
        put_filter(&filter, M.n, out[0]);
        if (t % 4 == 3) check("switch", t);
    }
}

/* ------------------------------------------------------------------ outliers and jumps */

static void predict(void) { put_status(K(predict)(&filter, &process, draw_control())); }

/* A run of updates by a loss: a gate says how many it has rejected, others what the components have weighed. */
static void robust_run(const char *name, K(loss) loss)
{
    num z[C], weights[C] = {0};
    const int is_gate = loss.kind == &K(loss_gate), is_weighted = !is_gate && loss.kind != &K(loss_jump);
    if (is_gate) put(loss.limit);
    if (is_weighted) loss.weights = weights;
    begin();
    for (int t = 0; t < STEPS; t++) {
        draw_measurement(z, t);
        put_status(K(update_robust)(&filter, &sensor, z, present_at(t), &loss));
        if (is_gate) put_word(loss.rejected);
        if (is_weighted) put_all(weights, M.m);
        put_filter(&filter, M.n, out[0]);
        predict();
    }
    check(name, STEPS);
}

static void put_smoothed(const K(history) * h)
{
    for (size_t t = 0; t < K(history_steps)(h); t++) {
        const K(filter) view = smoothed_view(h, t);
        put_readings(&view, M.n);
    }
}

static void reweighted(void)
{
    K(history) tape;
    num z[C], q[STEPS];
    begin();
    put_status(K(history_assign)(&tape, M.n, pool, LENGTH(pool)));
    put_status(K(attach)(&filter, &tape.attached));
    for (int t = 0; t < STEPS; t++) {
        q[t] = 1 + 5 * (num)(t % 4);
        draw_measurement(z, t);
        put_status(K(update)(&filter, &sensor, z));
        if (t == STEPS - 1) break;
        put_status(K(process_scale_noise)(&target, &process, q[t]));
        put_status(K(predict)(&filter, &target, draw_control()));
    }
    put_status(K(smooth_reweighted)(&tape, &target, &process, 2, q));
    put_all(q, STEPS);
    put_smoothed(&tape);
    check("reweighted", STEPS);
}

/* As many draws as a case had that is gone: so the digests of those after it stay */
static void skip_draws(void)
{
    num z[C];
    for (int t = 0; t < STEPS; t++) draw_measurement(z, t), draw_control();
}

static void robust(void)
{
    const num limit = K(chi_square_limit)(M.m, KQ_LEVEL_99);
    robust_run("gated", (K(loss)){.kind = &K(loss_gate), .limit = limit, .run = 2});
    robust_run("Huber", (K(loss)){.kind = &K(loss_huber), .parameter = (num)1.5});
    robust_run("Student-t", (K(loss)){.kind = &K(loss_student), .parameter = 4});
    robust_run("jumps", (K(loss)){.kind = &K(loss_jump), .parameter = 9});
    skip_draws();
    reweighted();
}

/* ------------------------------------------------------------------ statistics */

static void fit(num lambda)
{
    K(least_squares) squares;
    num z[C], r[C] = {scale * scale, scale * scale / 4, 0};
    begin();
    put_status(K(forget)(&filter, lambda));
    put_status(K(least_squares_init)(&squares, &filter, lambda));
    for (int t = 0; t < STEPS; t++) {
        draw_measurement(z, t);
        put_status(K(least_squares_add)(&squares, M.H, z, r, t % 2 ? 1 : (size_t)M.m));
        put(K(least_squares_residual)(&squares));
        put(K(least_squares_weight)(&squares));
        put_filter(&filter, M.n, out[0]);
    }
    check("least squares", STEPS);
}

static void put_window(const K(consistency) * window)
{
    num a = 0, b = 0, c = 0, d = 0;
    put_status(K(consistency_nis)(window, 2, &a, &b, &c));
    put_all((num[]){a, b, c}, 3);
    for (int k = 0; k < M.m; k++) {
        put_status(K(consistency_innovation)(window, k, 2, &a, &b, &c, &d));
        put_all((num[]){a, b, c, d}, 4);
    }
}

static void consistency(void)
{
    K(consistency) window;
    num z[C];
    begin();
    put_status(K(consistency_assign)(&window, M.m, STEPS / 2, pool, LENGTH(pool)));
    for (int t = 0; t < STEPS; t++) {
        draw_measurement(z, t);
        put_status(K(consistency_watch)(&window, &filter, &sensor, z, present_at(t)));
        put_status(K(update_subset)(&filter, &sensor, z, present_at(t)));
        put_status(K(consistency_record)(&window, &filter));
        put_word((uint32_t)K(consistency_count)(&window));
        put_window(&window);
        put_status(K(forget)(&filter, (num)0.875));
        predict();
    }
    check("consistency", STEPS);
}

/* ------------------------------------------------------------------ the unknown start */

static void put_start(const K(diffuse) * s)
{
    put_word((uint32_t)K(diffuse_count)(s));
    for (int i = 0; i < M.n; i++) {
        const int is_determined = !isnan(K(mean)(&filter, i));
        put_word((uint32_t)is_determined);
        if (!is_determined) continue;
        put(K(mean)(&filter, i));
        put(K(mean_low)(&filter, i));
        put(K(sigma)(&filter, i));
    }
    put(K(log_likelihood_last)(&filter));
    put(K(log_likelihood)(&filter));
    put_word(K(events)(&filter));
}

static void put_start_smoothed(K(diffuse) * s)
{
    put_status(K(diffuse_smooth)(s));
    size_t first;
    (void)K(diffuse_steps)(s, &first);
    for (size_t t = first; t < STEPS; t++) {
        K(filter) view;
        const kq_status shown = K(diffuse_smoothed)(s, t, &view); /* refused: it reads NaN */
        (void)shown;
        const kq_status status = K(covariance)(&view, out[0]);
        put_status(status);
        if (status) continue;
        put_all(out[0], M.n * M.n);
        put_readings(&view, M.n);
    }
    check("smoothed start", STEPS);
}

/* All components unknown, or all but the last */
static void start(uint32_t unknown)
{
    K(diffuse) s;
    K(history) tape;
    num z[C];
    put_status(K(diffuse_assign)(&s, M.n, EARLY, early_memory, LENGTH(early_memory)));
    put_status(K(diffuse_init)(&s, &filter, M.x0, M.P0, unknown));
    put_status(K(history_assign)(&tape, M.n, pool, LENGTH(pool)));
    put_status(K(attach)(&filter, &tape.attached));
    for (int t = 0; t < STEPS; t++) {
        draw_measurement(z, t);
        put_status(t == 1 ? K(update_subset)(&filter, &sensor, z, UINT32_C(1))
                          : K(update)(&filter, &sensor, z));
        put_start(&s);
        check("start", t);
        if (t < STEPS - 1) put_status(K(predict)(&filter, &process, draw_control()));
    }
    put_start_smoothed(&s);
}

/* ------------------------------------------------------------------ adaptation */

static void adaptation(kq_adapted scales)
{
    static const K(adaptation_rule)
        of = {KQ_ADAPT_BOTH, 10, (num)0.25, (num)0.125, 8, (num)0.125, 8};
    K(adaptation_rule) rule = of;
    K(adaptation) a;
    num z[C];
    rule.scales = scales;
    begin();
    put_status(K(adaptation_assign)(&a, M.n, M.m, pool, LENGTH(pool)));
    put_status(K(adaptation_init)(&a, &process, &sensor, &rule));
    need(K(attach)(&filter, &a.attached));
    for (int t = 0; t < 2 * STEPS; t++) {
        draw_measurement(z, t);
        put_status(K(update_subset)(&filter, &sensor, z, present_at(t)));
        num q, r;
        need(K(adaptation_scales)(&a, &q, &r));
        put(q);
        put(r);
        put_all(a.information, 3);
        put_filter(&filter, M.n, out[0]);
        put_status(K(predict)(&filter, &process, draw_control()));
    }
    check("adaptation", 2 * STEPS);
}

/* ------------------------------------------------------------------ EM */

static void put_learnt(const K(em) * em)
{
    put(K(em_log_likelihood)(em));
    put(K(em_change)(em));
    put_all(M.A, M.n * M.n);
    put_all(M.Q, M.n * M.n);
    put_all(M.R, M.m * M.m);
    put_all(M.x0, M.n);
}

/* Few parameters, for there are few measurements: two recordings.  Writes the model. */
static void learn(void)
{
    static num z[2 * EM_STEPS * C], u[EM_STEPS];
    static uint16_t present[EM_STEPS];
    static uint8_t held[N * N];
    const K(parameters) p = {M.l, 0, M.A, M.B, NULL, M.Q, M.H, M.R, M.x0, M.P0};
    const kq_em_choice choice = {KQ_EM_A | KQ_EM_Q | KQ_EM_R | KQ_EM_X0, KQ_EM_MULTIPLE,
                                 KQ_EM_MULTIPLE, held, NULL};
    const K(recording)
        recordings[] = {{EM_STEPS, z, present, u}, {EM_STEPS, z + EM_STEPS * M.m, NULL, u}};
    K(em) em;
    for (int t = 0; t < 2 * EM_STEPS; t++) draw_measurement(z + t * M.m, t);
    for (int t = 0; t < EM_STEPS; t++) {
        present[t] = (uint16_t)present_at(t);
        u[t] = model_draw();
    }
    for (int k = 1; k < M.n * M.n; k++) held[k] = 1; /* all of A but one entry */
    put_status(K(em_assign)(&em, M.n, M.m, pool, LENGTH(pool)));
    kq_status status = K(em_init)(&em, &p, &choice, recordings, 2);
    put_status(status);
    for (int k = 0; k < 2 && !status; k++) {
        status = K(em_iterate)(&em);
        put_status(status);
        if (!status) put_learnt(&em);
    }
    check("EM", 2 * EM_STEPS);
}

void run_beyond(const model_case *c)
{
    prepare(c);
    lag(0);
    point();
    steady();
    lazy();
    robust();
    fit(1);
    fit((num)0.9375);
    consistency();
    start(UINT32_MAX);
    start((UINT32_C(1) << (c->n - 1)) - 1);
    adaptation(KQ_ADAPT_BOTH);
    adaptation(KQ_ADAPT_PROCESS);
    adaptation(KQ_ADAPT_SENSOR);
    learn();
    lag(1);
    flow();
    drift();
}
