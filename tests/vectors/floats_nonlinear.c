/*
 * Nonlinear runs: the model's A and H with a bend in each row.
 * f and h are made of + - * / alone, in `num`, so that they are the same bits on every machine.
 */
#include "floats.h"

enum { N = BEYOND_STATES, C = BEYOND_COMPONENTS, STEPS = 8, LAG = 3 };

static num z[C];
static K(process) own;
static K(sensor) found;
static K(filter) at;
static K(history) history;
static K(jacobians) jacobians;
static K(process) processes[STEPS];
static num own_memory[KQ_PROCESS_LEN(N)];
static num found_memory[KQ_SENSOR_LEN(C)];
static num at_memory[LEN(FILTER)(N)];
static num pool[LEN(LAG)(N, C, LAG)]; /* of the history or the lag */
static num kept_memory[LEN(JACOBIANS)(N, STEPS, STEPS)];
static num work[KQ_SIGMA_POINTS_LEN(N, C)];
static num A[N * N], H[C * N], d[N], e[C], J[N * N], E[N * N], R[C * C];

_Static_assert(LENGTH(pool) >= LEN(HISTORY)(N, C, STEPS, STEPS), "history");

/* ------------------------------------------------------------------ the model */

/* s q^2 / (4 + 4 q^2), q = x / s: from 0 to s / 4 */
static num bend(num x)
{
    const num q = x / scale;
    return scale * (q * q / (4 + 4 * q * q));
}

static num slope(num x)
{
    const num q = x / scale, below = 1 + q * q;
    return q / (2 * below * below);
}

/* f(x) - x */
static void increment(void *context, const num *x, num *y)
{
    (void)context;
    for (int i = 0; i < M.n; i++) {
        y[i] = bend(x[(i + 1) % M.n]) - x[i];
        for (int k = 0; k < M.n; k++) y[i] += M.A[i * M.n + k] * x[k];
    }
}

/* z - h(x) */
static void innovation(void *context, const num *x, num *y)
{
    (void)context;
    for (int c = 0; c < M.m; c++) {
        y[c] = z[c] - bend(x[c % M.n]);
        for (int k = 0; k < M.n; k++) y[c] -= M.H[c * M.n + k] * x[k];
    }
}

static void read_mean(num *x)
{
    for (int i = 0; i < M.n; i++) x[i] = K(mean)(&filter, i);
}

static void linearise_process(void)
{
    num x[N] = {0}; /* n > 0: of that some compilers are not sure */
    read_mean(x);
    increment(NULL, x, d);
    for (int k = 0; k < M.n * M.n; k++) A[k] = M.A[k];
    for (int i = 0; i < M.n; i++) A[i * M.n + (i + 1) % M.n] += slope(x[(i + 1) % M.n]);
    put_status(K(process_change_transition)(&process, A));
}

static void predict_extended(void)
{
    linearise_process();
    put_status(K(predict_extended)(&filter, &process, d));
}

static void linearise_sensor(void)
{
    num x[N] = {0}; /* n > 0: of that some compilers are not sure */
    read_mean(x);
    innovation(NULL, x, e);
    for (int k = 0; k < M.m * M.n; k++) H[k] = M.H[k];
    for (int c = 0; c < M.m; c++) H[c * M.n + c % M.n] += slope(x[c % M.n]);
    put_status(K(sensor_change_measurement)(&sensor, H));
}

static void draw(int t)
{
    for (int c = 0; c < M.m; c++) z[c] = 4 * scale * model_draw();
    if (t % 4 == 3) z[0] *= 16; /* an outlier */
}

static void prepare(const model_case *c)
{
    make(c);
    put_status(K(process_assign)(&own, M.n, 0, own_memory, LENGTH(own_memory)));
    put_status(K(sensor_assign)(&found, M.n, M.m, found_memory, LENGTH(found_memory)));
    put_status(K(filter_assign)(&at, M.n, at_memory, LENGTH(at_memory)));
}

static void begin(void)
{
    put_status(K(process_init)(&process, M.A, NULL, M.Q));
    put_status(K(sensor_init_extended)(&sensor, M.H, M.R));
    put_status(K(filter_init)(&filter, M.x0, M.P0));
}

static void record(void)
{
    put_status(K(history_assign)(&history, M.n, pool, LENGTH(pool)));
    put_status(K(jacobians_assign)(&jacobians, &history, M.n, processes, STEPS, kept_memory,
                                   LENGTH(kept_memory)));
    put_status(K(attach)(&filter, &jacobians.attached));
}

/* ------------------------------------------------------------------ what is digested */

static void smooth(const char *name)
{
    const kq_status status = K(smooth)(&history);
    put_status(status);
    for (size_t t = 0; !status && t < STEPS; t++) {
        K(filter) view;
        put_status(K(smoothed)(&history, t, &view));
        K(events_clear)(&view);
        const kq_status shown = K(filter_copy)(&at, &view); /* refused: it reads NaN */
        (void)shown;
        put_filter(&at, M.n, J);
    }
    check(name, STEPS);
    put_status(K(detach)(&history.attached));
}

/* ------------------------------------------------------------------ by Jacobians */

static void update_extended(int t)
{
    K(loss) gate = {.kind = &K(loss_gate), .limit = K(chi_square_limit)(M.m, KQ_LEVEL_99)};
    K(loss) huber = {.kind = &K(loss_huber), .parameter = (num)1.5}, student = {.kind = &K(loss_student), .parameter = 4};
    linearise_sensor();
    if (t % 5 == 0) put_status(K(update)(&filter, &sensor, e));
    else if (t % 5 == 1) put_status(K(update_subset)(&filter, &sensor, e, 1));
    else put_status(K(update_robust)(&filter, &sensor, e, UINT32_MAX, t % 5 == 2 ? &gate : t % 5 == 3 ? &huber : &student));
}

static void run_extended(void)
{
    num back[N] = {0};
    begin();
    record();
    for (int t = 0; t < STEPS; t++) {
        draw(t);
        if (t) predict_extended();
        update_extended(t);
        for (int i = 0; t == 4 && i < M.n; i++) back[i] = -K(mean)(&filter, i) / 2;
        if (t == 4) put_status(K(move)(&filter, back));
        put_filter(&filter, M.n, J);
        check("extended", t);
    }
    smooth("extended, smoothed");
}

static void run_lag(void)
{
    static K(lag) lag;
    begin();
    put_status(K(lag_assign)(&lag, M.n, M.m, LAG, pool, LENGTH(pool)));
    put_status(K(attach)(&filter, &lag.attached));
    for (int t = 0; t < STEPS; t++) {
        draw(t);
        if (t) predict_extended();
        linearise_sensor();
        put_status(K(update)(&filter, &sensor, e));
        K(filter) lag_view;
        put_status(K(lagged)(&lag, K(lag_steps)(&lag), &lag_view));
        for (int i = 0; i < M.n; i++) {
            put(K(mean)(&lag_view, i));
            put(K(sigma)(&lag_view, i));
        }
    }
    check("extended, lag", STEPS);
}

/* ------------------------------------------------------------------ by sigma points */

static void run_points(int is_recorded, kq_sigma_points rule)
{
    begin();
    if (is_recorded) record();
    for (int t = 0; t < STEPS; t++) {
        draw(t);
        if (t) put_status(K(predict_sigma_points)(&filter, &process, increment, NULL, rule, work));
        put_status(K(update_sigma_points)(&filter, &sensor, innovation, NULL, rule, work));
        put_filter(&filter, M.n, J);
        check(rule == KQ_SIGMA_POINTS_CUBATURE ? "cubature" : "central differences", t);
    }
    if (is_recorded) smooth("by points, smoothed");
}

/* The parts of the above, and an update linearised where the first one came out */
static void run_parts(void)
{
    begin();
    draw(0);
    put_status(K(filter_copy)(&at, &filter));
    for (int k = 0; k < 2; k++) {
        put_status(K(linearise)(&at, innovation, NULL, M.m, KQ_SIGMA_POINTS_CUBATURE, e, J, E));
        put_all(J, M.m * M.n);
        put_all(E, M.m * M.n);
        for (int i = 0; i < M.m * M.n; i++) H[i] = -J[i];
        for (int c = 0; c < M.m; c++) {
            for (int i = 0; i < M.n; i++) e[c] += J[c * M.n + i] * (K(mean)(&filter, i) - K(mean)(&at, i));
        }
        put_status(K(sensor_linearise)(&found, &sensor, H, E, R));
        put_status(K(filter_copy)(&at, &filter));
        put_status(K(update)(&at, &found, e));
        put_filter(&at, M.n, J);
    }
    put_status(K(linearise)(&at, increment, NULL, M.n, KQ_SIGMA_POINTS_CENTRAL, d, A, E));
    for (int i = 0; i < M.n; i++) A[i * (M.n + 1)] += 1;
    put_status(K(process_linearise)(&own, &process, A, E));
    put_status(K(predict_extended)(&at, &own, d));
    put_filter(&at, M.n, J);
    check("iterated", 2);
}

void run_nonlinear(const model_case *c)
{
    prepare(c);
    run_extended();
    run_lag();
    run_points(0, KQ_SIGMA_POINTS_CENTRAL);
    run_points(1, KQ_SIGMA_POINTS_CUBATURE);
    run_parts();
}
