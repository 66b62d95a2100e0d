/*
 * The steps for sizes that the compiler knows: the same bits as those for run-time sizes, and the
 * same errors.
 */
#include "arithmetic.h"

#ifdef KQ_TEST_F32
#include "fixed_size/kq_fixed_f32.h"
#else
#include "fixed_size/kq_fixed_f64.h"
#endif

#include "fixed.h"

#ifdef KQ_TEST_F32
FIXED_SIZES(f32, float, 0, dense)
FIXED_SIZES(f32, float, KQ_FIXED_UPPER, upper)
FIXED_SIZES(f32, float, KQ_FIXED_BARE, bare)
FIXED_STEADY(f32, float, 1, 1)
FIXED_STEADY(f32, float, 4, 2)
#else
FIXED_SIZES(f64, double, 0, dense)
FIXED_SIZES(f64, double, KQ_FIXED_UPPER, upper)
FIXED_SIZES(f64, double, KQ_FIXED_BARE, bare)
FIXED_STEADY(f64, double, 1, 1)
FIXED_STEADY(f64, double, 4, 2)
#endif

static kq_status predict_of_no_control(K(filter) * f, const K(process) * p, const num *u)
{
#ifdef KQ_TEST_F32
    return kq_fixed_predict_f32(f, p, u, 2, 0, 0);
#else
    return kq_fixed_predict_f64(f, p, u, 2, 0, 0);
#endif
}

enum { STATES = 4, COMPONENTS = 2, STEPS = 30 };

typedef struct {
    int n, m;
    kq_status (*predict)(K(filter) *, const K(process) *, const num *);
    kq_status (*update)(K(filter) *, const K(sensor) *, const num *);
    kq_status (*step)(K(filter) *, const K(process) *, const num *, const K(sensor) *, const num *);
} fixed_size;

static const fixed_size dense[] = {FIXED_ROWS(dense)}, upper[] = {FIXED_ROWS(upper)},
                        bare[] = {FIXED_ROWS(bare)};

typedef struct {
    K(filter) filter;
    num memory[FILTER_LEN(STATES)];
} own_filter;

static own_filter ours, theirs; /* of compile-time sizes, and of run-time sizes */
static K(process) process_of;
static K(sensor) sensor_of;
static num process_memory[KQ_PROCESS_LEN(STATES)], sensor_memory[KQ_SENSOR_LEN(COMPONENTS)];
static num A[STATES * STATES], B[STATES], H[COMPONENTS * STATES], Q[STATES * STATES];
static num R[COMPONENTS * COMPONENTS], P0[STATES * STATES], x0[STATES];
static uint32_t seed;

/* -1 .. 1 in steps that no rounding changes */
static num draw(void)
{
    seed = seed * 1664525 + 1013904223;
    return (num)((int)(seed >> 20) - 2048) / 2048;
}

static void draw_model(int n, int m, int upper_only)
{
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            A[i * n + j] = (num)(i == j) + (upper_only && j <= i ? 0 : draw() / 4);
            Q[i * n + j] = i == j ? (num)0.25 : (num)0.03125;
            P0[i * n + j] = i == j ? (num)(4 + i) : 0;
        }
        B[i] = draw();
        x0[i] = draw();
    }
    for (int k = 0; k < m * n; k++) H[k] = draw();
    for (int j = 0; j < n; j++) H[j] = j == n - 1; /* one row that selects a state */
    for (int c = 0; c < m * m; c++) R[c] = c % (m + 1) == 0 ? (num)0.5 : 0;
}

static void begin_filter(own_filter *f, int n)
{
    ASSERT_OK(K(filter_assign)(&f->filter, n, f->memory, FILTER_LEN(STATES)));
    ASSERT_OK(K(filter_init)(&f->filter, x0, P0));
}

static void begin(int n, int m, int upper_only)
{
    draw_model(n, m, upper_only);
    ASSERT_OK(K(process_assign)(&process_of, n, 1, process_memory, KQ_PROCESS_LEN(STATES)));
    ASSERT_OK(K(process_init)(&process_of, A, B, Q));
    ASSERT_OK(K(sensor_assign)(&sensor_of, n, m, sensor_memory, KQ_SENSOR_LEN(COMPONENTS)));
    ASSERT_OK(K(sensor_init)(&sensor_of, H, R));
    begin_filter(&ours, n);
    begin_filter(&theirs, n);
}

static void draw_measurement(num *z, int m)
{
    for (int c = 0; c < m; c++) z[c] = 4 * draw();
}

static void assert_same(int line)
{
    const size_t bytes = sizeof(num) * (size_t)FILTER_LEN(ours.filter.states);
    if (memcmp(ours.memory, theirs.memory, bytes) == 0 &&
        K(events)(&ours.filter) == K(events)(&theirs.filter)) {
        return;
    }
    UNITY_TEST_FAIL(line, "the two filters differ");
}

#define ASSERT_SAME() assert_same(__LINE__)

static void assert_same_likelihood(void)
{
    const num nis = K(nis)(&ours.filter), other_nis = K(nis)(&theirs.filter);
    const num run = K(log_likelihood)(&ours.filter), other = K(log_likelihood)(&theirs.filter);
    ASSERT_SAME_BITS(nis, other_nis);
    ASSERT_SAME_BITS(run, other);
    TEST_ASSERT_EQUAL_INT(K(taken)(&theirs.filter), K(taken)(&ours.filter));
}

/* predict, update and step in turns */
static void compare(const fixed_size *size, int upper_only, int with_likelihood)
{
    num z[COMPONENTS], u[1];
    begin(size->n, size->m, upper_only);
    for (int t = 0; t < STEPS; t++) {
        draw_measurement(z, size->m);
        u[0] = draw();
        const num *drive = t % 3 ? u : NULL;
        if (t % 2) {
            ASSERT_OK(size->step(&ours.filter, &process_of, drive, &sensor_of, z));
        } else {
            ASSERT_OK(size->predict(&ours.filter, &process_of, drive));
            ASSERT_OK(size->update(&ours.filter, &sensor_of, z));
        }
        ASSERT_OK(K(step)(&theirs.filter, &process_of, drive, &sensor_of, z));
        ASSERT_SAME();
        if (with_likelihood) assert_same_likelihood();
    }
}

static void the_bits_are_those_of_run_time_sizes(void)
{
    for (size_t k = 0; k < sizeof dense / sizeof dense[0]; k++) {
        compare(&dense[k], 0, 1);
        compare(&dense[k], 1, 1);
        compare(&upper[k], 1, 1);
        compare(&bare[k], 0, 0);
    }
}

static void an_A_that_is_not_upper_triangular_is_taken_as_it_is(void)
{
    for (size_t k = 1; k < sizeof upper / sizeof upper[0]; k++) compare(&upper[k], 0, 1);
}

static void bare_leaves_the_likelihood_as_it_was(void)
{
    const num z[2] = {1, 2};
    begin(4, 2, 0);
    ASSERT_OK(dense[3].update(&ours.filter, &sensor_of, z));
    const num nis = K(nis)(&ours.filter), run = K(log_likelihood)(&ours.filter);
    ASSERT_OK(bare[3].step(&ours.filter, &process_of, NULL, &sensor_of, z));
    const num nis_after = K(nis)(&ours.filter), run_after = K(log_likelihood)(&ours.filter);
    ASSERT_SAME_BITS(nis, nis_after);
    ASSERT_SAME_BITS(run, run_after);
}

static void bare_leaves_the_likelihood_after_a_sharp_measurement_too(void)
{
    static const num noise_free[] = {0, 0, 0, 0};
    const num z[2] = {1, 2};
    begin(4, 2, 0);
    ASSERT_OK(dense[3].update(&ours.filter, &sensor_of, z));
    const num nis = K(nis)(&ours.filter), run = K(log_likelihood)(&ours.filter);
    ASSERT_OK(K(sensor_init)(&sensor_of, H, noise_free));
    ASSERT_OK(bare[3].step(&ours.filter, &process_of, NULL, &sensor_of, z));
    const num nis_after = K(nis)(&ours.filter), run_after = K(log_likelihood)(&ours.filter);
    ASSERT_SAME_BITS(nis, nis_after);
    ASSERT_SAME_BITS(run, run_after);
    TEST_ASSERT_EQUAL_INT(2, K(taken)(&ours.filter));
    ASSERT_WITHIN(1e-3, 1, K(mean)(&ours.filter, 3)); /* and the measurement was taken */
}

static void a_history_records(void)
{
    static num tape[HISTORY_LEN(3, 2, 10, 0)], other_tape[HISTORY_LEN(3, 2, 10, 0)];
    K(history) h, g;
    begin(3, 2, 0);
    ASSERT_OK(K(history_assign)(&h, 3, tape, sizeof tape / sizeof tape[0]));
    ASSERT_OK(K(history_assign)(&g, 3, other_tape, sizeof tape / sizeof tape[0]));
    ASSERT_OK(K(attach)(&ours.filter, &h.attached));
    ASSERT_OK(K(attach)(&theirs.filter, &g.attached));
    for (int t = 0; t < 5; t++) {
        const num z[2] = {(num)t, 1};
        ASSERT_OK(dense[2].step(&ours.filter, &process_of, NULL, &sensor_of, z));
        ASSERT_OK(K(step)(&theirs.filter, &process_of, NULL, &sensor_of, z));
    }
    TEST_ASSERT_EQUAL_INT(6, (int)K(history_steps)(&h));
    ASSERT_OK(K(smooth)(&h));
    ASSERT_OK(K(smooth)(&g));
    for (int i = 0; i < 3; i++) {
        const num one = K(mean)(SMOOTHED(&h, 1), i), two = K(mean)(SMOOTHED(&g, 1), i);
        ASSERT_SAME_BITS(one, two);
    }
    ASSERT_SAME();
}

/* Both filters by the same steps; one in four is a predict and an update. */
static void run_both(void)
{
    for (int t = 0; t < 60; t++) {
        const num z[2] = {(num)(t % 3), 1};
        if (t % 4 == 1 && t < 8) {
            ASSERT_OK(dense[2].predict(&ours.filter, &process_of, NULL));
            ASSERT_OK(dense[2].update(&ours.filter, &sensor_of, z));
            ASSERT_OK(K(predict)(&theirs.filter, &process_of, NULL));
            ASSERT_OK(K(update)(&theirs.filter, &sensor_of, z));
        } else {
            ASSERT_OK(dense[2].step(&ours.filter, &process_of, NULL, &sensor_of, z));
            ASSERT_OK(K(step)(&theirs.filter, &process_of, NULL, &sensor_of, z));
        }
        ASSERT_SAME();
    }
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&ours.filter));
}

/* What is attached follows the steps of compile-time sizes as it does the library's. */
static void a_lag_and_an_instant_follow(void)
{
    LAG(lag, 3, 2, 4);
    LAG(other_lag, 3, 2, 4);
    INSTANT(point, 3, 2);
    INSTANT(other_point, 3, 2);
    K(filter) lag_view, other_lag_view, point_view, other_point_view;
    begin(3, 2, 0);
    ASSERT_OK(K(attach)(&ours.filter, &lag.attached));
    ASSERT_OK(K(attach)(&theirs.filter, &other_lag.attached));
    run_both();
    TEST_ASSERT_EQUAL_INT(4, K(lag_steps)(&lag));
    ASSERT_OK(K(lagged)(&lag, 4, &lag_view));
    ASSERT_OK(K(lagged)(&other_lag, 4, &other_lag_view));
    ASSERT_OK(K(attach)(&ours.filter, &point.attached));
    ASSERT_OK(K(attach)(&theirs.filter, &other_point.attached));
    run_both();
    ASSERT_OK(K(instant_smooth)(&point, &point_view));
    ASSERT_OK(K(instant_smooth)(&other_point, &other_point_view));
    for (int i = 0; i < 3; i++) {
        const num one = K(mean)(&lag_view, i), two = K(mean)(&other_lag_view, i);
        const num first = K(mean)(&point_view, i), second = K(mean)(&other_point_view, i);
        ASSERT_SAME_BITS(one, two);
        ASSERT_SAME_BITS(first, second);
    }
}

/* The library takes its measurements, and says where it raised a noise. */
static void a_lean_sensor_is_left_to_the_library(void)
{
    static const num noises[][2] = {{1, 1}, {1, 0}};
    const num z[2] = {1, 2};
    for (size_t k = 0; k < sizeof dense / sizeof dense[0]; k++) {
        if (dense[k].m != 2) continue;
        for (int sharp = 0; sharp < 2; sharp++) {
            begin(dense[k].n, 2, 0);
            ASSERT_OK(K(sensor_init_lean)(&sensor_of, H, noises[sharp]));
            ASSERT_OK(dense[k].step(&ours.filter, &process_of, NULL, &sensor_of, z));
            ASSERT_OK(K(step)(&theirs.filter, &process_of, NULL, &sensor_of, z));
            ASSERT_SAME();
            TEST_ASSERT_EQUAL_UINT(sharp ? KQ_EVENT_LOW_NOISE : 0, K(events)(&ours.filter));
        }
    }
}

/* Sharp, noise-free and repeated: the library's own function takes what is unusual. */
static void an_unusual_measurement_is_taken_with_care(void)
{
    static const num noise_free[] = {0, 0, 0, 0};
    num z[2] = {1, 2};
    begin(4, 2, 0);
    ASSERT_OK(K(sensor_init)(&sensor_of, H, noise_free));
    for (int t = 0; t < 2; t++) { /* the second time it says nothing new */
        ASSERT_OK(dense[3].update(&ours.filter, &sensor_of, z));
        ASSERT_OK(K(update)(&theirs.filter, &sensor_of, z));
        TEST_ASSERT_EQUAL_INT(K(taken)(&theirs.filter), K(taken)(&ours.filter));
        TEST_ASSERT_EQUAL_UINT(K(events)(&theirs.filter), K(events)(&ours.filter));
        for (int i = 0; i < 4; i++) {
            ASSERT_CLOSE(K(mean)(&theirs.filter, i), K(mean)(&ours.filter, i), 8);
            ASSERT_CLOSE(K(sigma)(&theirs.filter, i), K(sigma)(&ours.filter, i), 2);
        }
    }
    ASSERT_CLOSE(K(log_likelihood)(&theirs.filter), K(log_likelihood)(&ours.filter),
                 64 + fabs((double)K(log_likelihood)(&theirs.filter)));
}

static void a_correlated_R_is_decorrelated(void)
{
    static const num correlated[] = {1, 0.5, 0.5, 2};
    const num z[2] = {1, 2};
    begin(4, 2, 0);
    ASSERT_OK(K(sensor_init)(&sensor_of, H, correlated));
    ASSERT_OK(dense[3].step(&ours.filter, &process_of, NULL, &sensor_of, z));
    ASSERT_OK(K(step)(&theirs.filter, &process_of, NULL, &sensor_of, z));
    ASSERT_SAME();
}

typedef kq_status steady_function(K(steady) *, const num *, const num *);

enum { GAINS = 3 };

static num steady_ours[STATES], steady_theirs[STATES], gains[GAINS * STATES * COMPONENTS];

static void begin_steady(K(steady) * one, K(steady) * two, int n, int m, int upper_only)
{
    begin(n, m, upper_only);
    for (int k = 0; k < COUNT(gains); k++) gains[k] = draw() / 8;
    ASSERT_OK(K(steady_assign)(one, n, m, steady_ours, STATES));
    ASSERT_OK(K(steady_assign)(two, n, m, steady_theirs, STATES));
    ASSERT_OK(K(steady_init)(one, &process_of, &sensor_of, x0, gains, GAINS));
    ASSERT_OK(K(steady_init)(two, &process_of, &sensor_of, x0, gains, GAINS));
}

/* Three gains, the last one for good, with and without a control */
static void compare_steady(steady_function *step, int n, int m, int upper_only)
{
    K(steady) one, two;
    begin_steady(&one, &two, n, m, upper_only);
    for (int t = 0; t < STEPS; t++) {
        num z[COMPONENTS], u[1];
        draw_measurement(z, m);
        u[0] = draw();
        ASSERT_OK(step(&one, t % 3 ? u : NULL, z));
        ASSERT_OK(K(steady_step)(&two, t % 3 ? u : NULL, z));
        ASSERT_SAME_BITS(steady_ours, steady_theirs);
    }
}

static void the_steady_states_bits_are_those_of_run_time_sizes(void)
{
    compare_steady(steady_1_1_dense, 1, 1, 0);
    compare_steady(steady_1_1_upper, 1, 1, 1);
    compare_steady(steady_4_2_dense, 4, 2, 0);
    compare_steady(steady_4_2_dense, 4, 2, 1);
    compare_steady(steady_4_2_upper, 4, 2, 1);
    compare_steady(steady_4_2_upper, 4, 2, 0); /* is not upper triangular: taken as it is */
    compare_steady(steady_4_2_dense, 3, 2, 0); /* of another size, the same */
}

static void the_steady_states_errors_are_those_of_the_library(void)
{
    const num z[2] = {1, 2}, bad[2] = {1, NAN}, bad_too[2] = {INFINITY, -INFINITY}, u[1] = {NAN};
    const num most[2] = {NUM_MAX, NUM_MAX}; /* finite, though their sum is not */
    K(steady) one, two;
    begin_steady(&one, &two, 4, 2, 0);
    for (int t = 0; t < GAINS; t++) {
        TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, steady_4_2_dense(NULL, NULL, z));
        TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, steady_4_2_dense(&one, NULL, NULL));
        TEST_ASSERT_EQUAL_INT(KQ_ERR_NOT_FINITE, steady_4_2_dense(&one, NULL, bad));
        TEST_ASSERT_EQUAL_INT(KQ_ERR_NOT_FINITE, steady_4_2_dense(&one, NULL, bad_too));
        TEST_ASSERT_EQUAL_INT(KQ_ERR_NOT_FINITE, steady_4_2_dense(&one, u, z));
        ASSERT_SAME_BITS(steady_ours, steady_theirs);
        ASSERT_OK(steady_4_2_dense(&one, NULL, t == 2 ? most : z));
        ASSERT_OK(K(steady_step)(&two, NULL, t == 2 ? most : z));
        ASSERT_SAME_BITS(steady_ours, steady_theirs);
    }
    ASSERT_OK(K(steady_assign)(&one, 4, 2, steady_ours, STATES));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NOT_READY, steady_4_2_upper(&one, NULL, z));
}

/* What is wrong is said as ever, and nothing has changed. */
static void errors_are_those_of_the_library(void)
{
    const num z[2] = {1, 2}, bad[2] = {1, NAN}, u[1] = {INFINITY};
    const fixed_size *size = &dense[3];
    K(filter) *f = &ours.filter;
    begin(4, 2, 0);
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, size->predict(NULL, &process_of, NULL));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, size->predict(f, NULL, NULL));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, size->update(f, NULL, z));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, size->update(f, &sensor_of, NULL));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NOT_FINITE, size->update(f, &sensor_of, bad));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NOT_FINITE, size->predict(f, &process_of, u));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NOT_FINITE, size->step(f, &process_of, NULL, &sensor_of, bad));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NOT_FINITE, size->step(f, &process_of, u, &sensor_of, z));
    ASSERT_SAME();
    ASSERT_OK(K(filter_assign)(f, 4, ours.memory, FILTER_LEN(STATES)));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NOT_READY, size->step(f, &process_of, NULL, &sensor_of, z));
}

/* Objects of other sizes than were said are taken by the sizes they have. */
static void other_sizes_are_taken_as_they_are(void)
{
    const num z[2] = {1, 2};
    begin(3, 2, 0);
    ASSERT_OK(dense[3].step(&ours.filter, &process_of, NULL, &sensor_of, z));
    ASSERT_OK(K(step)(&theirs.filter, &process_of, NULL, &sensor_of, z));
    ASSERT_SAME();
}

/* Steps of both, z's first component by `scale` */
static void compare_steps(const fixed_size *size, const num *drive, int steps, num scale)
{
    num z[COMPONENTS];
    for (int t = 0; t < steps; t++) {
        draw_measurement(z, size->m);
        z[0] *= scale;
        ASSERT_OK(size->step(&ours.filter, &process_of, drive, &sensor_of, z));
        ASSERT_OK(K(step)(&theirs.filter, &process_of, drive, &sensor_of, z));
        ASSERT_SAME();
    }
}

/* A diagonal below 1/2, whose distance from 1 is rounded */
static void a_rounded_A_is_taken_as_it_is(void)
{
    for (size_t k = 0; k < COUNT(dense); k++) {
        for (int upper_only = 0; upper_only < 2; upper_only++) {
            const fixed_size *size = upper_only ? &upper[k] : &dense[k];
            begin(size->n, size->m, upper_only);
            for (int i = 0; i < size->n; i++) A[i * (size->n + 1)] = (num)0.3;
            ASSERT_OK(K(process_init)(&process_of, A, B, Q));
            compare_steps(size, NULL, STEPS, 1);
        }
    }
}

/* Up to n = 3 the library takes the step from its beginning: its very bits. */
static void what_is_unusual_at_small_sizes_has_the_librarys_bits(void)
{
    static const num huge[] = {1, (num)1e6, (num)1e30};
    for (size_t k = 0; k < 3; k++) {
        for (size_t j = 0; j < COUNT(huge); j++) {
            begin(dense[k].n, dense[k].m, 0);
            compare_steps(&dense[k], NULL, 4, huge[j]); /* outliers, and what overflows */
            for (int c = 0; c < dense[k].m; c++) R[c * (dense[k].m + 1)] = j == 0 ? 0 : (num)1e-9;
            ASSERT_OK(K(sensor_init)(&sensor_of, H, R));
            compare_steps(&dense[k], NULL, 4, 1); /* noise-free, and sharp */
            assert_same_likelihood();
        }
    }
}

static void a_state_that_grows_is_held_as_by_the_library(void)
{
    for (size_t k = 0; k < COUNT(dense); k++) {
        begin(dense[k].n, dense[k].m, 0);
        for (int i = 0; i < dense[k].n; i++) A[i * (dense[k].n + 1)] = (num)1e6;
        ASSERT_OK(K(process_init)(&process_of, A, B, Q));
        for (int t = 0; t < 60; t++) {
            ASSERT_OK(dense[k].predict(&ours.filter, &process_of, NULL));
            ASSERT_OK(K(predict)(&theirs.filter, &process_of, NULL));
            ASSERT_SAME();
        }
        TEST_ASSERT_TRUE(K(events)(&ours.filter) & KQ_EVENT_OVERFLOW);
    }
}

/* Predicts of both until there is an event, and some more; what brings the state back is taken by both. */
static void compare_until_held(const fixed_size *size, const num *drive)
{
    const num z[COMPONENTS] = {1, 2};
    for (int left = -1, t = 0; left && t < 3000; t++, left -= left > 0) {
        ASSERT_OK(size->predict(&ours.filter, &process_of, drive));
        ASSERT_OK(K(predict)(&theirs.filter, &process_of, drive));
        ASSERT_SAME();
        if (left < 0 && K(events)(&ours.filter)) left = 3;
    }
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_OVERFLOW, K(events)(&ours.filter));
    for (int t = 0; t < 3; t++) {
        ASSERT_OK(size->step(&ours.filter, &process_of, NULL, &sensor_of, z));
        ASSERT_OK(K(step)(&theirs.filter, &process_of, NULL, &sensor_of, z));
        TEST_ASSERT_EQUAL_HEX(K(events)(&theirs.filter), K(events)(&ours.filter));
        if (size->n < STATES) ASSERT_SAME(); /* of the largest, what is unusual is taken from there on */
    }
}

/* State 0 through the last one alone, and by its mean alone */
static void what_leaves_the_numbers_otherwise_is_held_as_by_the_library(void)
{
    const num u[1] = {2};
    for (size_t k = 0; k < COUNT(dense); k++) {
        const fixed_size *sizes[] = {&dense[k], &upper[k], &bare[k]};
        const int n = dense[k].n;
        for (int way = 0; way < 3; way++) {
            begin(n, dense[k].m, way == 1);
            B[n / 2] = NUM_MAX;
            ASSERT_OK(K(process_init)(&process_of, A, B, Q));
            compare_until_held(sizes[way], u);
            if (n == 1) continue;
            memset(A, 0, sizeof A), memset(P0, 0, sizeof P0), memset(Q, 0, sizeof Q);
            for (int i = 0; i < n; i++) A[i * (n + 1)] = 1;
            A[0] = 2, A[n - 1] = 1, P0[n * n - 1] = 1;
            ASSERT_OK(K(process_init)(&process_of, A, B, Q));
            for (int i = 0; i < n; i++) x0[i] = 0;
            begin_filter(&ours, n);
            begin_filter(&theirs, n);
            compare_until_held(sizes[way], NULL);
        }
    }
}

/* Controls that are not as many as was said are taken as many as they are; of none that were said, too. */
static void other_numbers_of_controls_are_taken_as_they_are(void)
{
    static num memory[KQ_PROCESS_LEN(STATES)], two[2 * STATES];
    const num u[2] = {1, 2};
    K(process) process_of_two;
    begin(2, 1, 0);
    for (int i = 0; i < COUNT(two); i++) two[i] = draw();
    ASSERT_OK(K(process_assign)(&process_of_two, 2, 2, memory, KQ_PROCESS_LEN(STATES)));
    ASSERT_OK(K(process_init)(&process_of_two, A, two, Q));
    ASSERT_OK(dense[1].predict(&ours.filter, &process_of_two, u));
    ASSERT_OK(K(predict)(&theirs.filter, &process_of_two, u));
    ASSERT_SAME();
    ASSERT_OK(predict_of_no_control(&ours.filter, &process_of, u));
    ASSERT_OK(K(predict)(&theirs.filter, &process_of, u));
    ASSERT_SAME();
}

/* Steps that predict and update apart by turns, of a filter that something is attached to */
static void compare_attached(const fixed_size *size)
{
    num z[COMPONENTS], u[1];
    for (int t = 0; t < STEPS; t++) {
        draw_measurement(z, size->m);
        u[0] = draw();
        if (t % 6 == 4) {
            ASSERT_OK(size->predict(&ours.filter, &process_of, u));
            ASSERT_OK(K(predict)(&theirs.filter, &process_of, u));
            ASSERT_OK(size->update(&ours.filter, &sensor_of, z));
            ASSERT_OK(K(update)(&theirs.filter, &sensor_of, z));
        } else {
            ASSERT_OK(size->step(&ours.filter, &process_of, u, &sensor_of, z));
            ASSERT_OK(K(step)(&theirs.filter, &process_of, u, &sensor_of, z));
        }
        ASSERT_SAME();
        assert_same_likelihood();
    }
}

static void an_adaptation_learns(void)
{
    static const K(adaptation_rule) rule = {KQ_ADAPT_BOTH, 50, 0.125, 0.0625, 16, 0.125, 8};
    static num memory[2][ADAPTATION_LEN(STATES, COMPONENTS)];
    own_filter *filters[] = {&ours, &theirs};
    K(adaptation) a[2];
    for (size_t k = 0; k < COUNT(dense); k++) {
        const fixed_size *size = &dense[k];
        begin(size->n, size->m, 0);
        for (int i = 0; i < 2; i++) {
            ASSERT_OK(
                K(adaptation_assign)(&a[i], size->n, size->m, memory[i], COUNT(memory[i])));
            ASSERT_OK(K(adaptation_init)(&a[i], &process_of, &sensor_of, &rule));
            ASSERT_OK(K(attach)(&filters[i]->filter, &a[i].attached));
        }
        compare_attached(size);
        num q[2], r[2];
        for (int i = 0; i < 2; i++) ASSERT_OK(K(adaptation_scales)(&a[i], &q[i], &r[i]));
        TEST_ASSERT_TRUE(r[0] != 1 && r[0] == r[1] && q[0] == q[1]);
    }
}

static void a_settling_settles(void)
{
    static num memory[2][KQ_TRIANGLE(STATES)], gain[2][STATES * COMPONENTS];
    own_filter *filters[] = {&ours, &theirs};
    K(freeze) w[2];
    for (size_t k = 0; k < COUNT(dense); k++) {
        const fixed_size *size = &dense[k];
        begin(size->n, size->m, 0);
        for (int i = 0; i < size->n * size->n; i++) A[i] /= 2;
        ASSERT_OK(K(process_init)(&process_of, A, B, Q));
        for (int i = 0; i < 2; i++) {
            ASSERT_OK(K(freeze_assign)(&w[i], size->n, size->m, memory[i], COUNT(memory[i]),
                                         gain[i]));
            ASSERT_OK(K(freeze_init)(&w[i], 4));
            ASSERT_OK(K(attach)(&filters[i]->filter, &w[i].attached));
        }
        compare_attached(size);
        compare_steps(size, NULL, STEPS, 1);
        TEST_ASSERT_EQUAL_INT(1, K(freeze_is_active)(&w[0]));
        TEST_ASSERT_EQUAL_INT(1, K(freeze_is_active)(&w[1]));
    }
}

static void an_unknown_start_becomes_known(void)
{
    static num memory[2][START_LEN(STATES, 0)];
    own_filter *filters[] = {&ours, &theirs};
    K(diffuse) s[2];
    for (size_t k = 0; k < COUNT(dense); k++) {
        const fixed_size *size = &dense[k];
        begin(size->n, size->m, 0);
        for (int i = 0; i < 2; i++) {
            ASSERT_OK(K(diffuse_assign)(&s[i], size->n, 0, memory[i], COUNT(memory[i])));
            ASSERT_OK(K(diffuse_init)(&s[i], &filters[i]->filter, x0, NULL, UINT32_MAX));
        }
        compare_attached(size);
        TEST_ASSERT_EQUAL_INT(0, K(diffuse_count)(&s[0]));
        TEST_ASSERT_EQUAL_INT(0, K(diffuse_count)(&s[1]));
    }
}

static void set_up(void) { seed = 1; }

SUITE(fixed, set_up)
{
    RUN_TEST(the_bits_are_those_of_run_time_sizes);
    RUN_TEST(an_A_that_is_not_upper_triangular_is_taken_as_it_is);
    RUN_TEST(bare_leaves_the_likelihood_as_it_was);
    RUN_TEST(bare_leaves_the_likelihood_after_a_sharp_measurement_too);
    RUN_TEST(a_history_records);
    RUN_TEST(an_adaptation_learns);
    RUN_TEST(a_lag_and_an_instant_follow);
    RUN_TEST(a_settling_settles);
    RUN_TEST(an_unknown_start_becomes_known);
    RUN_TEST(a_lean_sensor_is_left_to_the_library);
    RUN_TEST(an_unusual_measurement_is_taken_with_care);
    RUN_TEST(a_correlated_R_is_decorrelated);
    RUN_TEST(errors_are_those_of_the_library);
    RUN_TEST(other_sizes_are_taken_as_they_are);
    RUN_TEST(the_steady_states_bits_are_those_of_run_time_sizes);
    RUN_TEST(the_steady_states_errors_are_those_of_the_library);
    RUN_TEST(a_rounded_A_is_taken_as_it_is);
    RUN_TEST(what_is_unusual_at_small_sizes_has_the_librarys_bits);
    RUN_TEST(a_state_that_grows_is_held_as_by_the_library);
    RUN_TEST(what_leaves_the_numbers_otherwise_is_held_as_by_the_library);
    RUN_TEST(other_numbers_of_controls_are_taken_as_they_are);
}
