#include "floats.h"

enum { STEPS = 12, AHEAD = 5 };

/* ------------------------------------------------------------------ a run */

static K(filter) ahead;
static K(history) history;
static num ahead_memory[LEN(FILTER)(MOST_STATES)];
static num history_memory[LEN(HISTORY)(MOST_STATES, MOST_COMPONENTS, STEPS, 0)];
static num out[3][MOST_STATES * MOST_STATES];

static void prepare(const model_case *c)
{
    make(c);
    put_status(K(process_init)(&process, M.A, M.l ? M.B : NULL, M.Q));
    put_status(K(sensor_init)(&sensor, M.H, M.R));
    put_status(K(filter_assign)(&ahead, M.n, ahead_memory, LENGTH(ahead_memory)));
    put_status(K(history_assign)(&history, M.n, history_memory, LENGTH(history_memory)));
}

static void begin(void)
{
    put_status(K(filter_init)(&filter, M.x0, M.P0));
    put_status(K(attach)(&filter, &history.attached));
}

static void put_state(const K(filter) * f)
{
    put_readings(f, M.n);
    put_covariance(f, M.n, out[0]);
    put_word(K(events)(f));
}

static void put_score(const K(filter) * f)
{
    put_word((uint32_t)K(taken)(f));
    put(K(nis)(f));
    put(K(log_likelihood_last)(f));
    put(K(log_likelihood)(f));
}

static void put_look(const num *z)
{
    put_status(K(measurement)(&filter, &sensor, out[0], out[1]));
    put_all(out[0], M.m);
    put_all(out[1], M.m * M.m);
    put_status(K(innovation)(&filter, &sensor, z, out[0]));
    put_all(out[0], M.m);
    put_status(K(gain)(&filter, &sensor, out[2]));
    put_all(out[2], M.n * M.m);
}

/* Every third step lacks a component. */
static void step(const model_case *c, int t)
{
    num z[MOST_COMPONENTS], u[1] = {model_draw()};
    const uint32_t present = UINT32_MAX << (t / 3 % 2);
    for (int k = 0; k < M.m; k++) z[k] = 4 * c->scale * model_draw();
    if (t > 0) put_status(K(predict)(&filter, &process, M.l ? u : NULL));
    if (t % 4 == 1) {
        put_look(z);
        check("look", t);
    }
    if (t % 3 == 2) put_status(K(update_subset)(&filter, &sensor, z, present));
    else put_status(K(update)(&filter, &sensor, z));
    put_state(&filter);
    check("state", t);
    put_score(&filter);
    check("score", t);
}

static void forecast(void)
{
    num u[AHEAD];
    for (int k = 0; k < AHEAD; k++) u[k] = model_draw();
    put_status(K(forecast)(&filter, &process, M.l ? u : NULL, AHEAD, &ahead));
    put_state(&ahead);
    check("forecast", AHEAD);
}

static void put_smoothed(size_t t)
{
    const K(filter) view = smoothed_view(&history, t);
    put_readings(&view, M.n);
    put_covariance(&view, M.n, out[0]);
}

static void put_noises(void)
{
    num mean, variance;
    for (int k = 0; K(smoothed_measurement_noise)(&history, k, &mean, &variance) == KQ_OK; k++) {
        put(mean);
        put(variance);
    }
}

static void smooth(void)
{
    static num noise_mean[MOST_STATES];
    const K(smooth_extras) extras = {out[1], noise_mean, out[2]};
    for (int t = STEPS; t-- > 0;) {
        put_status(K(smooth_step)(&history, NULL, &extras));
        put_smoothed((size_t)t);
        put_noises();
        if (t + 1 < STEPS) {
            put_all(out[1], M.n * M.n);
            put_all(noise_mean, M.n);
            put_all(out[2], M.n * M.n);
        }
        check("smoothed", t);
    }
}

/* The means alone, of the same run without its draws */
static void smooth_means(void)
{
    num z[MOST_COMPONENTS] = {0};
    begin();
    for (int t = 0; t < STEPS; t++) {
        if (t > 0) put_status(K(predict)(&filter, &process, NULL));
        put_status(K(update)(&filter, &sensor, z));
    }
    put_status(K(smooth_states)(&history));
    for (size_t t = 0; t < STEPS; t++) {
        const K(filter) view = smoothed_view(&history, t);
        for (int i = 0; i < M.n; i++) put(K(mean)(&view, i));
    }
    check("means", STEPS);
}

void run_filter(const model_case *c)
{
    prepare(c);
    begin();
    check("begin", 0);
    for (int t = 0; t < STEPS; t++) step(c, t);
    forecast();
    smooth();
    smooth_means();
}
