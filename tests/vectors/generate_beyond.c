/* Golden vectors of what is built on the filter: each case has a model of n = 2 with a control and
   one of n = 4, m = 2 with correlated noise. */
#include "generate.h"

static model line = {.l = 1,
                     .B = {0.125, 0.5},
                     .C = {0.5},
                     .P0 = {100, 25},
                     .state_range = {4095, 255},
                     .control_range = {1},
                     .measurement_range = {4095}};

static model plane = {.C = {0.2, 0, -0.1, 0.3},
                      .P0 = {100, 25, 100, 25},
                      .state_range = {8191, 255, 8191, 255},
                      .measurement_range = {8191, 8191}};

static void make_models(void)
{
    make_kinematic(&line, 1, 2, 0.5, 1);
    make_kinematic(&plane, 2, 2, 0.25, 2);
}

/* Four words alike: none, then some */
static const double *control_at(const model *M, int t)
{
    static const double u[4] = {0.25, -0.5, 0.75, 0};
    return M->l && t % 5 != 4 ? &u[t % 4] : NULL;
}

/* The truth one step on, without controls, and a measurement that is far off at every `often`-th */
static void measure(truth *now, const model *M, int t, int often, double *z)
{
    truth_advance(now, M, control_at(M, t));
    truth_measure(now, M, z);
    if (often && t % often == often - 1) z[0] += t % 2 ? 40 : -90;
}

static void put_predict(const model *M, int operation, int slot, int t)
{
    script_word(slot);
    script_controls(M, control_at(M, t));
    script_act(operation);
}

/* ------------------------------------------------------------------ lag and point */

static void smooth_lag(int k, int states_only)
{
    script_word(k);
    script_word(states_only);
    script_act(VECTOR_LAG_SMOOTH);
}

/* As far back as there is, and now and then every step in between */
static void put_lag(const model *M, int longest, int steps)
{
    truth now;
    double z[16];
    script_prior(M);
    script_word(M->m);
    script_word(longest);
    script_act(VECTOR_LAG);
    truth_begin(&now, M, 201);
    for (int t = 0; t < steps; t++) {
        const int reach = t < longest ? t : longest;
        measure(&now, M, t, 0, z);
        if (t % 4 != 2) script_update(M, 0, z, t % 4 == 3 ? 1 : ALL_COMPONENTS);
        smooth_lag(reach, t % 3 == 1);
        for (int k = 0; t % 6 == 5 && k < reach; k++) smooth_lag(k, 0);
        put_predict(M, VECTOR_LAG_PREDICT, 0, t);
    }
    smooth_lag(longest + 1, 0);
    script_update(M, 0, z, ALL_COMPONENTS);
    script_update(M, 0, z, ALL_COMPONENTS); /* no room for it */
    smooth_lag(0, 0);
    put_predict(M, VECTOR_LAG_PREDICT, 0, 0);
    script_act(VECTOR_CLEAR);
}

static void put_point(const model *M, int steps)
{
    truth now;
    double z[16];
    script_prior(M);
    truth_begin(&now, M, 202);
    for (int t = 0; t < steps; t++) {
        measure(&now, M, t, 0, z);
        script_update(M, 0, z, t % 4 == 3 ? 1 : ALL_COMPONENTS);
        if (t == 1) {
            script_word(M->m);
            script_act(VECTOR_POINT);
        }
        if (t) script_act(VECTOR_POINT_SMOOTH);
        if (t) put_predict(M, VECTOR_POINT_PREDICT, 0, t);
        else script_predict(M, 0, NULL);
    }
    script_predict(M, 0, NULL); /* the plain predict is the point's */
    script_act(VECTOR_POINT_SMOOTH);
    put_predict(M, VECTOR_POINT_PREDICT, 0, 0);
}

void case_on_line(void)
{
    make_models();
    begin_case("on_line", "smoothing as the data come in, fixed lag and fixed point");
    put_model(&line);
    put_lag(&line, 7, 24);
    put_lag(&line, 0, 2);
    put_point(&line, 10);
    put_model(&plane);
    put_lag(&plane, 4, 9);
    put_point(&plane, 6);
    script_end();
}

/* ------------------------------------------------------------------ outliers and jumps */

static void put_gated(const model *M, truth *now)
{
    double z[16];
    script_word(M->m);
    script_word(2); /* 99 % */
    script_word(2);
    script_act(VECTOR_GATE);
    for (int t = 0; t < 6; t++) {
        measure(now, M, t, 0, z);
        if (t == 2 || t == 3) z[0] += 50;
        script_word(0);
        script_word(t == 4 ? 1 : ALL_COMPONENTS);
        script_reading(M, z);
        script_act(VECTOR_GATED);
        script_predict(M, 0, control_at(M, t));
    }
    script_act(VECTOR_CLEAR);
}

static void put_weighted(const model *M, truth *now, int is_student, double k)
{
    double z[16];
    for (int t = 0; t < 4; t++) {
        measure(now, M, t, 3, z);
        script_word(is_student);
        script_word(0);
        script_word(t == 3 ? 1 : ALL_COMPONENTS);
        script_number(k);
        script_reading(M, z);
        script_act(VECTOR_WEIGHTED);
        script_predict(M, 0, control_at(M, t));
    }
}

static void put_jumps(const model *M, truth *now)
{
    double z[16];
    for (int t = 0; t < 5; t++) {
        measure(now, M, t, 3, z);
        script_word(0);
        script_word(ALL_COMPONENTS);
        script_number(t == 4 ? 0.5 : 9); /* refused: below 1 */
        script_reading(M, z);
        script_act(VECTOR_JUMP);
        script_predict(M, 0, control_at(M, t));
    }
    script_act(VECTOR_CLEAR);
}

static void scale_noise(double q)
{
    script_word(1);
    script_word(0);
    script_number(q);
    script_act(VECTOR_SCALE);
}

/* A recorded run of scaled noise, and a pass of reweighting */
static void put_reweighted(const model *M)
{
    enum { STEPS = 7 };
    truth now;
    double z[16], q[STEPS];
    script_prior(M);
    script_history(1500);
    truth_begin(&now, M, 212);
    for (int t = 0; t < STEPS; t++) {
        measure(&now, M, t, 5, z);
        script_update(M, 0, z, ALL_COMPONENTS);
        if (t + 1 == STEPS) break;
        q[t] = t == 2 ? 0 : 1 + 15.5 * (t % 3);
        scale_noise(q[t]);
        script_predict(M, 1, control_at(M, t));
    }
    script_word(0);
    script_word(ALL_COMPONENTS);
    script_number(9);
    script_reading(M, z);
    script_act(VECTOR_JUMP); /* refused: there is no record for it */
    script_word(1);
    script_word(0);
    script_number(2);
    script_word(STEPS - 1);
    for (int t = 0; t < STEPS - 1; t++) script_number(q[t]);
    script_act(VECTOR_REWEIGHTED);
}

static void put_robust(const model *M)
{
    truth now;
    put_model(M);
    truth_begin(&now, M, 211);
    put_gated(M, &now);
    put_weighted(M, &now, 0, 1.5);
    put_weighted(M, &now, 1, 4);
    put_jumps(M, &now);
    script_read();
    put_reweighted(M);
    scale_noise(-1); /* refused */
}

void case_robust(void)
{
    make_models();
    begin_case("robust", "updates and steps that withstand outliers and jumps");
    put_robust(&line);
    put_robust(&plane);
    script_end();
}

/* ------------------------------------------------------------------ least squares, statistics */

static void put_fade(double lambda)
{
    script_number(lambda);
    script_act(VECTOR_FADE);
}

/* Rows (1, t, t^2, ...) of a polynomial in t / 8 */
static void put_rows(const model *M, int first, int count, double unit)
{
    for (int t = first; t < first + count; t++) {
        double power = unit;
        for (int i = 0; i < M->n; i++) {
            script_number(power);
            power *= 0.125 * t;
        }
    }
}

/* `count` rows with their measurements, all in words */
static void put_fit_rows(const model *M, int first, int count)
{
    script_word(count);
    put_rows(M, first, count, 0x1p-4);
    for (int t = first; t < first + count; t++) script_word(900000 * (t % 3) - 70000 * t);
    for (int t = first; t < first + count; t++) script_number(t == 4 ? 0x1p20 : 0x1p34);
    script_act(VECTOR_FIT_ADD);
}

static void put_fit(const model *M, double lambda)
{
    script_prior(M);
    script_number(lambda);
    script_word(1 << 30);
    script_word(16);
    script_act(VECTOR_FIT);
    for (int t = 0; t < 6; t++) put_fit_rows(M, t, 1);
    put_fit_rows(M, 6, 4);
    script_read();
}

static void put_window(const model *M, int updates)
{
    truth now;
    double z[16];
    script_prior(M);
    script_word(M->m);
    script_word(5);
    script_act(VECTOR_WINDOW);
    truth_begin(&now, M, 221);
    for (int t = 0; t < updates; t++) {
        measure(&now, M, t, 0, z);
        script_word(0);
        script_word(t == 3 ? 0 : t == 6 ? 1 : ALL_COMPONENTS);
        script_reading(M, z);
        script_act(VECTOR_WATCHED);
        if (t % 3 == 2) {
            script_word(t % 2 ? 32883343 : 43218108); /* 1.96, 2.576 */
            script_act(VECTOR_WINDOW_READ);
        }
        if (t % 4 == 3) put_fade(0.875);
        script_predict(M, 0, control_at(M, t));
    }
    script_word(-1); /* refused */
    script_act(VECTOR_WINDOW_READ);
}

static void put_statistics(const model *M, int updates)
{
    put_model(M);
    put_fade(0.99);
    put_fade(1);
    put_fade(0x1p-16);
    put_fade(0); /* refused */
    put_fade(1.5);
    put_fit(M, 1);
    put_fit(M, 0.95);
    put_window(M, updates);
}

void case_statistics(void)
{
    make_models();
    begin_case("statistics", "fading memory, least squares, a window of updates");
    put_statistics(&line, 12);
    put_statistics(&plane, 9);
    script_end();
}

/* ------------------------------------------------------------------ steady states */

static void put_schedule(int bits, int steps)
{
    script_word(0);
    script_word(0);
    script_word(bits);
    script_word(steps);
    script_act(VECTOR_SCHEDULE);
}

static void put_steady(const model *M, int last_alone, int32_t first_mean)
{
    script_word(0);
    script_word(0);
    script_word(last_alone);
    for (int i = 0; i < M->n; i++) script_word(i ? 12345 * i : first_mean);
    script_act(VECTOR_STEADY);
}

static void put_steady_steps(const model *M, int steps)
{
    truth now;
    double z[16];
    truth_begin(&now, M, 231);
    for (int t = 0; t < steps; t++) {
        measure(&now, M, t, 0, z);
        script_word(0);
        script_word(0);
        script_word(t == 0   ? VECTOR_STEADY_UPDATE
                    : t == 5 ? VECTOR_STEADY_PREDICT
                             : VECTOR_STEADY_PREDICT | VECTOR_STEADY_UPDATE);
        script_controls(M, control_at(M, t));
        script_reading(M, z);
        script_act(VECTOR_STEADY_STEP);
    }
}

/* Of the filter as the settling has left it */
static void put_steady_smoother(const model *M)
{
    enum { STEPS = 6 };
    script_word(0);
    script_word(0);
    script_word(STEPS);
    for (int k = 0; k < STEPS * M->n; k++) script_word(1000003 * k - 4000037);
    for (int k = 0; k < STEPS * M->m; k++) script_word(70001 * (k % 4) - 99991);
    script_act(VECTOR_STEADY_SMOOTH);
}

static void step_settling(const model *M, const double *u, const double *z)
{
    script_word(0);
    script_word(0);
    script_controls(M, u);
    script_word(z != NULL);
    if (z) script_reading(M, z);
    script_act(VECTOR_SWITCH_STEP);
}

/* Until it is settled; a measurement that is missing; released; settled again */
static void put_settling(const model *M, int bits, int steps)
{
    truth now;
    double z[16];
    script_prior(M);
    script_word(0);
    script_word(bits);
    script_act(VECTOR_SWITCH);
    truth_begin(&now, M, 232);
    for (int t = 0; t < steps; t++) {
        measure(&now, M, t, 0, z);
        if (t == steps - 4) script_act(VECTOR_SWITCH_RELEASE);
        step_settling(M, control_at(M, t), t == steps / 2 ? NULL : z);
    }
    script_read();
}

static void put_steady_states(const model *M, int bits, int steps)
{
    put_model(M);
    put_schedule(bits, 2); /* not settled by then */
    put_schedule(bits, 40);
    put_steady(M, 0, -54321);
    put_steady_steps(M, 9);
    put_steady(M, 1, 99);
    put_steady_steps(M, 3);
    put_steady(M, 1, INT32_MIN); /* refused */
    put_settling(M, bits, steps);
    put_steady_smoother(M);
}

void case_steady(void)
{
    make_models();
    begin_case("steady", "gain schedule, steady-state filter and smoother, the switch");
    put_steady_states(&line, 10, 30);
    put_steady_states(&plane, 6, 22);
    script_end();
}

/* ------------------------------------------------------------------ the unknown start */

/* `early`: instants kept for the smoother, 0 for a run without it */
static void put_start(const model *M, int32_t unknown, int early, int steps)
{
    truth now;
    double z[16];
    put_model(M);
    script_word(early);
    script_word(unknown);
    script_distribution(M);
    script_act(VECTOR_START);
    if (early) {
        script_word(1500);
        script_act(VECTOR_START_HISTORY);
    }
    truth_begin(&now, M, 241);
    for (int t = 0; t < steps; t++) {
        measure(&now, M, t, 0, z);
        script_word(0);
        script_word(t == 0 ? 0 : t % 3 == 1 ? 1 : ALL_COMPONENTS);
        script_reading(M, z);
        script_act(VECTOR_START_UPDATE);
        if (t + 1 < steps) put_predict(M, VECTOR_START_PREDICT, 0, t);
    }
    script_word(early ? steps : 0);
    script_act(VECTOR_START_SMOOTH);
}

void case_start(void)
{
    make_models();
    begin_case("start", "components of the first state that are unknown");
    put_start(&line, 3, 4, 6);
    put_start(&line, 2, 0, 4);
    put_start(&line, 0, 0, 2);
    put_start(&plane, ALL_COMPONENTS, 3, 5);
    put_start(&plane, 5, 2, 4);
    put_start(&line, 3, 4, 2); /* never determined */
    script_end();
}

/* ------------------------------------------------------------------ adaptation */

static void put_rule(int scales, int memory, double step)
{
    script_word(0);
    script_word(0);
    script_word(scales);
    script_word(memory);
    script_number(step);
    script_number(0.125);
    script_number(16);
    script_number(0.25);
    script_number(8);
    script_act(VECTOR_ADAPTATION);
}

static void put_adaptation(const model *M, int scales, int updates)
{
    truth now;
    double z[16];
    script_prior(M);
    put_rule(scales, 20, 0.125);
    truth_begin(&now, M, 251);
    for (int t = 0; t < updates; t++) {
        measure(&now, M, t, 5, z);
        script_word(0);
        script_word(t == 3 ? 0 : t % 4 == 2 ? 1 : ALL_COMPONENTS);
        script_reading(M, z);
        script_act(VECTOR_ADAPTED_UPDATE);
        put_predict(M, VECTOR_ADAPTED_PREDICT, 0, t);
    }
}

void case_adaptation(void)
{
    make_models();
    begin_case("adaptation", "the scales of the noises, learnt on line");
    put_model(&line);
    put_adaptation(&line, 0, 14);
    put_adaptation(&line, 1, 6);
    put_rule(0, 20, 1.5); /* refused */
    put_rule(0, 9, 0.125);
    put_model(&plane);
    put_adaptation(&plane, 0, 10);
    put_adaptation(&plane, 2, 6);
    script_end();
}
