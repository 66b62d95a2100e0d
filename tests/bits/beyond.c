#include "beyond.h"
#include "digest.h"

enum {
    N = BEYOND_STATES,
    C = BEYOND_COMPONENTS,
    STEPS = 8,
    LAG = 4,
    GAINS = 12,
    EARLY = 3,
    EM_STEPS = 4
};

static model M;
static num scale; /* of its measurements */
static K(process) process, target;
static K(sensor) sensor;
static K(filter) filter;
static num process_memory[KQ_PROCESS_LEN(N)], target_memory[KQ_PROCESS_LEN(N)];
static num sensor_memory[KQ_SENSOR_LEN(C)];
static num filter_memory[FILTER_LEN(N)];
static num pool[EM_LEN(N, C, EM_STEPS)]; /* the longest of what is in use at a time */
static num early_memory[START_LEN(N, EARLY)];
static num out[4][N * N];

#define LENGTH(memory) (sizeof memory / sizeof memory[0])

_Static_assert(LENGTH(pool) >= INSTANT_LEN(N, C), "instant");
_Static_assert(LENGTH(pool) >= HISTORY_LEN(N, C, STEPS, STEPS), "history");
_Static_assert(LENGTH(pool) >= STEADY_SOLVE_LEN(N, C), "solution");
_Static_assert(LENGTH(pool) >= STEADY_WORK_LEN(N, C), "schedule");
_Static_assert(LENGTH(pool) >= CONSISTENCY_LEN(C, STEPS), "consistency");
_Static_assert(LENGTH(pool) >= ADAPTATION_LEN(N, C), "adaptation");
_Static_assert(LENGTH(pool) >= LAG_LEN(N, C, LAG), "lag");

static void prepare(const model_case *c)
{
    model_make(&M, c);
    M.A[0] = digest_falsify(M.A[0]);
    scale = c->scale;
    put_status(K(process_assign)(&process, M.n, M.l, process_memory, LENGTH(process_memory)));
    put_status(K(process_init)(&process, M.A, M.l ? M.B : NULL, M.Q));
    put_status(K(process_assign)(&target, M.n, M.l, target_memory, LENGTH(target_memory)));
    put_status(K(sensor_assign)(&sensor, M.n, M.m, sensor_memory, LENGTH(sensor_memory)));
    put_status(K(sensor_init)(&sensor, M.H, M.R));
    put_status(K(filter_assign)(&filter, M.n, filter_memory, LENGTH(filter_memory)));
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

static void put_filter(void)
{
    for (int i = 0; i < M.n; i++) {
        put(K(mean)(&filter, i));
        put(K(mean_low)(&filter, i));
        put(K(sigma)(&filter, i));
    }
    put_status(K(covariance)(&filter, out[0]));
    put_all(out[0], M.n * M.n);
    put_word(K(events)(&filter));
    put_word((uint32_t)K(taken)(&filter));
    put(K(nis)(&filter));
    put(K(log_likelihood)(&filter));
}

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

static void lag(void)
{
    K(lag) past;
    num z[C];
    begin();
    put_status(K(lag_assign)(&past, M.n, M.m, LAG, pool, LENGTH(pool)));
    put_status(K(lag_attach)(&past, &filter));
    for (int t = 0; t < STEPS; t++) {
        draw_measurement(z, t);
        put_status(K(update_subset)(&filter, &sensor, z, present_at(t)));
        const size_t steps = K(lag_steps)(&past);
        for (size_t k = 0; k <= steps; k += 2) put_lag(&past, steps - k, t % 3 == 1);
        put_status(K(predict)(&filter, &process, draw_control()));
        check("lag", t);
    }
    put_filter();
    check("filter of the lag", STEPS);
}

static void put_instant(K(instant) * of)
{
    K(filter) view;
    put_status(K(instant_smooth)(of, &view));
    put_readings(&view, M.n);
    put_status(K(covariance)(&view, out[0]));
    put_all(out[0], M.n * M.n);
}

static void point(void)
{
    K(instant) instant;
    num z[C];
    begin();
    put_status(K(instant_assign)(&instant, M.n, M.m, pool, LENGTH(pool)));
    put_status(K(instant_attach)(&instant, &filter));
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

/* Answers how many gains there are; where there is no schedule, the filter's own as the only one.
 */
static size_t schedule(void)
{
    size_t used = 0;
    begin();
    const kq_status status =
        K(steady_schedule)(&filter, &process, &sensor, pool, LENGTH(pool), 4, gains, GAINS, &used);
    put_status(status);
    if (status) {
        put_status(K(gain)(&filter, &sensor, gains));
        used = 1;
    }
    put_word((uint32_t)used);
    put_all(gains, (int)used * M.n * M.m);
    check("gains", 0);
    return used;
}

static void put_steady(const K(steady) * steady, num *x)
{
    for (int i = 0; i < M.n; i++) x[i] = K(steady_mean)(steady, i);
    put_all(x, M.n);
}

static void steady_filter(num *x, num *e)
{
    K(steady) steady;
    num z[C], mean[N];
    const size_t used = schedule();
    put_status(K(steady_assign)(&steady, M.n, M.m, mean, N));
    put_status(K(steady_init)(&steady, &process, &sensor, M.x0, gains, used));
    for (int t = 0; t < STEPS; t++) {
        draw_measurement(z, t);
        put_status(K(steady_innovation)(&steady, z, e + t * M.m));
        put_all(e + t * M.m, M.m);
        if (t == 0) put_status(K(steady_update)(&steady, z));
        else if (t == 5) put_status(K(steady_predict)(&steady, draw_control()));
        else put_status(K(steady_step)(&steady, draw_control(), z));
        put_steady(&steady, x + t * M.n);
    }
    check("steady-state filter", STEPS);
}

static void steady_smoother(num *x, const num *e)
{
    num root[KQ_TRIANGLE(N)];
    const K(steady_smoother) constants = {M.n, M.m, root, out[0], out[1]};
    put_status(K(steady_smoother_make)(&filter, &process, &sensor, pool, LENGTH(pool), root, out[0],
                                       out[1]));
    put_all(root, KQ_TRIANGLE(M.n));
    put_all(out[0], M.n * M.n);
    put_all(out[1], M.n * M.m);
    put_status(K(steady_smooth)(&constants, x, e, STEPS));
    put_all(x, STEPS * M.n);
    check("steady-state smoother", STEPS);
}

static void steady(void)
{
    static num x[STEPS * N], e[STEPS * C];
    solve();
    steady_filter(x, e);
    steady_smoother(x, e);
}

/* Settles within the steps, mostly; then lacks a measurement. */
static void lazy(void)
{
    K(settling) lazy;
    num z[C], memory[KQ_TRIANGLE(N)];
    begin();
    put_status(K(settling_assign)(&lazy, M.n, M.m, memory, LENGTH(memory), gains));
    put_status(K(settling_init)(&lazy, 4));
    need(K(settling_attach)(&lazy, &filter));
    for (int t = 0; t < 2 * STEPS; t++) {
        draw_measurement(z, 0);
        if (t == STEPS + 4) put_status(K(settling_release)(&lazy));
        const num *u = draw_control();
        put_status(t == STEPS + 1 ? K(predict)(&filter, &process, u)
                                  : K(step)(&filter, &process, u, &sensor, z));
        put_word((uint32_t)K(settling_is_settled)(&lazy));
        put_filter();
        if (t % 4 == 3) check("switch", t);
    }
}

/* ------------------------------------------------------------------ outliers and jumps */

static void predict(void) { put_status(K(predict)(&filter, &process, draw_control())); }

static void gated(void)
{
    K(gate) gate = {K(chi_square_limit)(M.m, KQ_LEVEL_99), 2, 0};
    num z[C];
    put(gate.limit);
    begin();
    for (int t = 0; t < STEPS; t++) {
        draw_measurement(z, t);
        put_status(K(update_gated)(&filter, &gate, &sensor, z, present_at(t)));
        put_word(gate.rejected);
        put_filter();
        predict();
    }
    check("gated", STEPS);
}

static void weighted(int is_student)
{
    num z[C], weights[C] = {0};
    begin();
    for (int t = 0; t < STEPS; t++) {
        draw_measurement(z, t);
        put_status(is_student
                       ? K(update_student)(&filter, &sensor, z, present_at(t), 4, weights)
                       : K(update_huber)(&filter, &sensor, z, present_at(t), (num)1.5, weights));
        put_all(weights, M.m);
        put_filter();
        predict();
    }
    check(is_student ? "Student-t" : "Huber", STEPS);
}

static void jumps(void)
{
    num z[C];
    begin();
    for (int t = 0; t < STEPS; t++) {
        draw_measurement(z, t);
        put_status(K(update_jump)(&filter, &sensor, z, present_at(t), 9));
        put_filter();
        predict();
    }
    check("jumps", STEPS);
}

static void student_steps(void)
{
    num z[C], q = 0;
    begin();
    for (int t = 0; t < STEPS; t++) {
        draw_measurement(z, t);
        put_status(K(step_student)(&filter, &process, draw_control(), &sensor, z, present_at(t), 2,
                                   &target, &q));
        put(q);
        put_filter();
        check("Student-t step", t);
    }
}

static void put_smoothed(const K(history) * h)
{
    for (size_t t = 0; t < K(history_steps)(h); t++) {
        K(filter) view;
        (void)K(smoothed)(h, t, &view);
        put_readings(&view, M.n);
    }
}

static void reweighted(void)
{
    K(history) tape;
    num z[C], q[STEPS];
    begin();
    put_status(K(history_assign)(&tape, M.n, pool, LENGTH(pool)));
    put_status(K(history_attach)(&tape, &filter));
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

static void robust(void)
{
    gated();
    weighted(0);
    weighted(1);
    jumps();
    student_steps();
    reweighted();
}

/* ------------------------------------------------------------------ statistics */

static void fit(num lambda)
{
    K(least_squares) squares;
    num z[C], r[C] = {scale * scale, scale * scale / 4, 0};
    begin();
    put_status(K(fade)(&filter, lambda));
    put_status(K(least_squares_init)(&squares, &filter, lambda));
    for (int t = 0; t < STEPS; t++) {
        draw_measurement(z, t);
        if (t % 2) put_status(K(least_squares_add)(&squares, M.H, z[0], r[0]));
        else put_status(K(least_squares_add_all)(&squares, M.H, z, r, (size_t)M.m));
        put(K(least_squares_residual)(&squares));
        put(K(least_squares_weight)(&squares));
        put_filter();
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
        put_status(K(fade)(&filter, (num)0.875));
        predict();
    }
    check("consistency", STEPS);
}

/* ------------------------------------------------------------------ the unknown start */

static void put_start(const K(start) * s)
{
    put_word((uint32_t)K(start_count)(s));
    for (int i = 0; i < M.n; i++) {
        put_word((uint32_t)K(start_is_determined)(s, i));
        if (!K(start_is_determined)(s, i)) continue;
        put(K(mean)(&filter, i));
        put(K(mean_low)(&filter, i));
        put(K(sigma)(&filter, i));
    }
    put(K(log_likelihood_last)(&filter));
    put(K(log_likelihood)(&filter));
    put_word(K(events)(&filter));
}

static void put_start_smoothed(K(start) * s)
{
    put_status(K(start_smooth)(s));
    for (size_t t = K(start_first)(s); t < STEPS; t++) {
        K(filter) view;
        (void)K(start_smoothed)(s, t, &view);
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
    K(start) s;
    K(history) tape;
    num z[C];
    put_status(K(start_assign)(&s, M.n, EARLY, early_memory, LENGTH(early_memory)));
    put_status(K(start_init)(&s, &filter, M.x0, M.P0, unknown));
    put_status(K(history_assign)(&tape, M.n, pool, LENGTH(pool)));
    put_status(K(history_attach)(&tape, &filter));
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
    need(K(adaptation_attach)(&a, &filter));
    for (int t = 0; t < 2 * STEPS; t++) {
        draw_measurement(z, t);
        put_status(K(update_subset)(&filter, &sensor, z, present_at(t)));
        put(K(adaptation_process_scale)(&a));
        put(K(adaptation_sensor_scale)(&a));
        put_all(a.information, 3);
        put_filter();
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
    digest_begin(c->name);
    prepare(c);
    lag();
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
    digest_end();
}

/* ------------------------------------------------------------------ model builders */

static num model_memory[KQ_MODEL_LEN(N, N, C)];
static K(model) built;

static void build(int n, int r, int m)
{
    put_status(K(model_assign)(&built, n, r, m, model_memory, LENGTH(model_memory)));
}

static void put_model(const char *name, kq_status status)
{
    const int n = built.states, r = built.noises, m = built.components;
    put_status(status);
    put_all(built.A, n * n);
    put_all(built.F, n * r);
    put_all(built.H, m * n);
    put_all(built.R, m);
    put_all(built.x0, n);
    put_all(built.P0, n * n);
    check(name, n);
}

static void time_series(void)
{
    const num phi[4] = {digest_falsify((num)0.625), (num)0.25, (num)-0.375, (num)0.125};
    const num theta[3] = {(num)0.75, (num)-0.5, (num)0.3125};
    build(KQ_AR_STATES(4), 1, 1);
    put_model("ar", K(model_ar)(&built, phi, 4, 3, (num)0.5));
    build(KQ_MA_STATES(3), 1, 1);
    put_model("ma", K(model_ma)(&built, theta, 3, 3, 0));
    build(KQ_ARMA_STATES(2, 3), 1, 1);
    put_model("arma", K(model_arma)(&built, phi, 2, theta, 3, 3, (num)0.25));
    build(KQ_ARMA_STATES(4, 1), 1, 1);
    put_model("arma", K(model_arma)(&built, phi, 4, theta, 1, 7, 0));
}

static void structural(const num *any, const num *variance)
{
    build(3, 3, 1);
    put_model("regression", K(model_regression)(&built, any, 3, variance, 2, any, variance));
    build(1, 1, 1);
    put_model("level", K(model_level)(&built, variance[0], 3, any[0], variance[1]));
    build(2, 2, 1);
    put_model("trend", K(model_trend)(&built, variance, 3, any, variance));
    build(KQ_SEASON_STATES(7), 1, 1);
    put_model("season", K(model_season)(&built, 7, variance[2], 3, any, variance));
    build(KQ_TREND_SEASON_STATES(4), 3, 1);
    put_model("trend and season", K(model_trend_season)(&built, 4, variance, 3, NULL, variance));
}

static void motion(const num *any, const num *variance)
{
    const num dt = (num)0.3125;
    build(KQ_VELOCITY_STATES(3), KQ_VELOCITY_NOISES(3), 3);
    put_model("velocity", K(model_velocity)(&built, 3, dt, variance, variance, any, variance));
    build(KQ_ACCELERATION_STATES(3), KQ_ACCELERATION_NOISES(3), 3);
    put_model("acceleration",
              K(model_acceleration)(&built, 3, dt, variance, variance, any, variance));
}

/* A of row sums below 1 */
static void stationary(const num *any, const num *variance)
{
    enum { FACTORS = 4 };
    num A[FACTORS * FACTORS], F[FACTORS * 2];
    for (int k = 0; k < FACTORS * FACTORS; k++) A[k] = model_draw() / FACTORS;
    for (int k = 0; k < FACTORS * 2; k++) F[k] = model_draw();
    A[0] += (num)0.125;
    build(FACTORS, FACTORS, 2);
    put_model("factor", K(model_factor)(&built, FACTORS, 2, any, A, variance, variance));
    put_status(K(stationary_covariance)(out[0], A, F, FACTORS, 2));
    put_all(out[0], FACTORS * FACTORS);
    check("stationary covariance", FACTORS);
}

void run_models(void)
{
    num any[N], variance[N];
    digest_begin("models");
    for (int k = 0; k < N; k++) {
        any[k] = model_draw();
        variance[k] = model_draw();
        variance[k] *= 16 * variance[k];
    }
    time_series();
    structural(any, variance);
    motion(any, variance);
    stationary(any, variance);
    digest_end();
}
