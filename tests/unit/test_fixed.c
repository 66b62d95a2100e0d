/*
 * The steps for sizes that the compiler knows: the same bits as those for run-time sizes, and the
 * same errors.
 */
#include "fixed.h"

FIXED_SIZES(0, dense)
FIXED_SIZES(KQ_FIXED_UPPER, upper)
FIXED_SIZES(KQ_FIXED_BARE, bare)
FIXED_STEADY(1, 1, 0, dense)
FIXED_STEADY(1, 1, KQ_FIXED_UPPER, upper)
FIXED_STEADY(4, 2, 0, dense)
FIXED_STEADY(4, 2, KQ_FIXED_UPPER, upper)

static kq_status predict_of_no_control(S(filter) * f, const S(process) * p, const word *u)
{
    return S(fixed_predict)(f, p, u, 2, 0, 0);
}

enum { STATES = 4, COMPONENTS = 2, STEPS = 30 };

typedef struct {
    int n, m;
    kq_status (*predict)(S(filter) *, const S(process) *, const word *);
    kq_status (*update)(S(filter) *, const S(sensor) *, const word *);
    kq_status (*step)(S(filter) *, const S(process) *, const word *, const S(sensor) *, const word *);
} fixed_size;

static const fixed_size dense[] = {FIXED_ROWS(dense)}, upper[] = {FIXED_ROWS(upper)},
                        bare[] = {FIXED_ROWS(bare)};

typedef struct {
    S(filter) filter;
    word memory[S_FILTER_LEN(STATES)];
} own_filter;

static own_filter ours, theirs; /* of known sizes, and of run-time sizes */
static own_filter *const filters[] = {&ours, &theirs};
static process_model process_of;
static sensor_model sensor_of;
static prior_model prior;
static const num range[] = {64, 128, 256, 512};
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
            A[i * n + j] = (num)(i == j) + (upper_only && j <= i ? 0 : draw() / 8);
            Q[i * n + j] = i == j ? (num)0.25 : (num)0.03125;
            P0[i * n + j] = i == j ? (num)(4 + i) : 0;
        }
        B[i] = draw() / 4;
        x0[i] = draw();
    }
    for (int k = 0; k < m * n; k++) H[k] = draw();
    for (int j = 0; j < n; j++) H[j] = j == n - 1; /* one row that selects a state */
    for (int c = 0; c < m * m; c++) R[c] = c % (m + 1) == 0 ? (num)0.5 : 0;
}

static void begin_filter(own_filter *f, int n)
{
    ASSERT_OK(S(filter_assign)(&f->filter, n, f->memory, COUNT(f->memory)));
    ASSERT_OK(init_filter(&f->filter, &prior));
}

/* Steps of compile-time sizes are for objects that share a table of formats; others go to the library. */
#ifdef KQ_TEST_Q31
static kq_format_q31 shared[STATES];

static void share_of_process(void)
{
    put_formats(shared, range, STATES);
    process_of.table.state_format = shared;
    ASSERT_OK(kq_process_init_q31(&process_of.process, &process_of.table, NULL));
}

static void share_of_sensor(int is_diagonal)
{
    put_formats(shared, range, STATES);
    sensor_of.table.state_format = shared;
    if (is_diagonal) ASSERT_OK(kq_sensor_init_diagonal_q31(&sensor_of.sensor, &sensor_of.table, NULL));
    else ASSERT_OK(kq_sensor_init_q31(&sensor_of.sensor, &sensor_of.table, NULL));
}

static void share_of_prior(void) { prior.table.state_format = shared; }

#define R_IS_DIAGONAL(m) (r_is_diagonal || (m) == 1 || R[1] == 0)
#else
static void share_of_process(void) {}
static void share_of_sensor(int is_diagonal) { (void)is_diagonal; }
static void share_of_prior(void) {}

#define R_IS_DIAGONAL(m) r_is_diagonal
#endif

static void make_process(int n)
{
    put_process(&process_of, n, 1, range, range, A, B, Q);
    share_of_process();
}

/* The numbers as they are now */
static void begin_filters(int n)
{
    put_prior(&prior, n, range, x0, P0);
    share_of_prior();
    begin_filter(&ours, n);
    begin_filter(&theirs, n);
}

static int r_is_diagonal; /* R is given as its diagonal */

static void make_sensor(int n, int m)
{
    const num r[] = {R[0], R[m * m - 1]};
    const int is_diagonal = R_IS_DIAGONAL(m);
    if (is_diagonal) put_independent(&sensor_of, n, m, range, range, H, r);
    else put_sensor(&sensor_of, n, m, range, range, H, R);
    share_of_sensor(is_diagonal);
}

static void begin(int n, int m, int upper_only)
{
    draw_model(n, m, upper_only);
    make_process(n);
    make_sensor(n, m);
    begin_filters(n);
}

/* Controls and measurements as the calls take them, until the next ones */
static const word *words_for_control(num a)
{
    static num u;
    u = a;
    return driven(&process_of.process, &u, 1);
}

static const word *draw_control(void) { return words_for_control(draw()); }

static const word *words_for(num a, num b)
{
    static num z[COMPONENTS];
    z[0] = a, z[1] = b;
    return measured(&sensor_of.sensor, z);
}

static const word *draw_measurement(num size)
{
    const num a = 4 * draw(), b = 4 * draw();
    return words_for(a * size, b);
}

static void assert_same(int line)
{
    const size_t bytes = sizeof(word) * (size_t)S_FILTER_LEN(ours.filter.states);
    if (memcmp(ours.memory, theirs.memory, bytes) == 0 &&
        S(events)(&ours.filter) == S(events)(&theirs.filter)) {
        return;
    }
    UNITY_TEST_FAIL(line, "the two filters differ");
}

#define ASSERT_SAME_FILTERS() assert_same(__LINE__)

static void assert_same_likelihood(void)
{
    const score nis = S(nis)(&ours.filter), other_nis = S(nis)(&theirs.filter);
    const score run = S(log_likelihood)(&ours.filter), other = S(log_likelihood)(&theirs.filter);
    ASSERT_SAME_BITS(nis, other_nis);
    ASSERT_SAME_BITS(run, other);
    TEST_ASSERT_EQUAL_INT(S(taken)(&theirs.filter), S(taken)(&ours.filter));
}

static void step_both(const fixed_size *size, const word *u, const word *z)
{
    ASSERT_OK(size->step(&ours.filter, &process_of.process, u, &sensor_of.sensor, z));
    ASSERT_OK(S(step)(&theirs.filter, &process_of.process, u, &sensor_of.sensor, z));
    ASSERT_SAME_FILTERS();
}

static void predict_both(const fixed_size *size, const word *u)
{
    ASSERT_OK(size->predict(&ours.filter, &process_of.process, u));
    ASSERT_OK(S(predict)(&theirs.filter, &process_of.process, u));
    ASSERT_SAME_FILTERS();
}

static void update_both(const fixed_size *size, const word *z)
{
    ASSERT_OK(size->update(&ours.filter, &sensor_of.sensor, z));
    ASSERT_OK(S(update)(&theirs.filter, &sensor_of.sensor, z));
}

static void step_many(const fixed_size *size, int steps, num scale)
{
    for (int t = 0; t < steps; t++) step_both(size, NULL, draw_measurement(scale));
}

/* predict, update and step in turns */
static void compare(const fixed_size *size, int upper_only, int with_likelihood)
{
    begin(size->n, size->m, upper_only);
    for (int t = 0; t < STEPS; t++) {
        const word *z = draw_measurement(1), *u = draw_control(), *drive = t % 3 ? u : NULL;
        if (t % 2) {
            ASSERT_OK(size->step(&ours.filter, &process_of.process, drive, &sensor_of.sensor, z));
        } else {
            ASSERT_OK(size->predict(&ours.filter, &process_of.process, drive));
            ASSERT_OK(size->update(&ours.filter, &sensor_of.sensor, z));
        }
        ASSERT_OK(S(step)(&theirs.filter, &process_of.process, drive, &sensor_of.sensor, z));
        ASSERT_SAME_FILTERS();
        if (with_likelihood) assert_same_likelihood();
    }
}

TEST(the_bits_are_those_of_run_time_sizes)
{
    for (int k = 0; k < 2 * COUNT(dense); k++) {
        const int size = k / 2;
        r_is_diagonal = k % 2;
        compare(&dense[size], 0, 1);
        compare(&dense[size], 1, 1);
        compare(&upper[size], 1, 1);
        compare(&bare[size], 0, 0);
        if (size) compare(&upper[size], 0, 1); /* an A that is not upper triangular is taken as it is */
    }
}

/* Of an ordinary measurement, and of one without noise */
TEST(bare_leaves_the_likelihood_as_it_was)
{
    for (int is_sharp = 0; is_sharp < 2; is_sharp++) {
        begin(4, 2, 0);
        ASSERT_OK(dense[3].update(&ours.filter, &sensor_of.sensor, words_for(1, 2)));
        const score nis = S(nis)(&ours.filter), run = S(log_likelihood)(&ours.filter);
        if (is_sharp) memset(R, 0, sizeof R);
        make_sensor(4, 2);
        ASSERT_OK(bare[3].step(&ours.filter, &process_of.process, NULL, &sensor_of.sensor, words_for(1, 2)));
        const score nis_after = S(nis)(&ours.filter), run_after = S(log_likelihood)(&ours.filter);
        ASSERT_SAME_BITS(nis, nis_after);
        ASSERT_SAME_BITS(run, run_after);
        TEST_ASSERT_EQUAL_INT(2, S(taken)(&ours.filter));
    }
    ASSERT_WITHIN(1e-3, 1, word_value(&prior, S(mean)(&ours.filter, 3), 3)); /* and the measurement was taken */
}

/* A position and its rate, all constant, seen with an offset of each of two components (test_watch.c), of noise r and r2 */
static void begin_position_and_rate(num r, num r2)
{
    static const num sums[] = {1, 0, 1, 0, 1, 0, 0, 1};
    begin(4, 2, 1);
    memset(Q, 0, sizeof Q), memset(P0, 0, sizeof P0), memset(A, 0, sizeof A);
    memcpy(H, sums, sizeof H);
    for (int i = 0; i < 4; i++) A[5 * i] = P0[5 * i] = 1;
    A[1] = N(0x1p-10);
    R[0] = r, R[3] = r2, R[1] = R[2] = 0;
    make_process(4), make_sensor(4, 2), begin_filters(4);
}

#ifdef KQ_TEST_Q31
static const num that_hides = 0x1p-26;
#else
static const num that_hides = N(0x1p-14 * (EPS / (double)FLT_EPSILON) * (EPS / (double)FLT_EPSILON));
#endif

TEST(what_rounding_hides_of_a_rate_is_told)
{
    begin_position_and_rate(that_hides, that_hides);
    const word *z = words_for(0, 0);
    for (int t = 0; t < 10000; t++) ASSERT_OK(upper[3].step(&ours.filter, &process_of.process, NULL, &sensor_of.sensor, z));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_PRECISION, S(events)(&ours.filter) & KQ_EVENT_PRECISION);
}

/* Looks at rounding come at other times than the library's, and move no bit of what says next to nothing. */
TEST(what_says_little_has_the_librarys_bits)
{
    begin_position_and_rate(that_hides, (num)0x1p22);
    const word *z = words_for(0, 0);
    for (int t = 0; t < 4000; t++) {
        ASSERT_OK(upper[3].step(&ours.filter, &process_of.process, NULL, &sensor_of.sensor, z));
        ASSERT_OK(S(step)(&theirs.filter, &process_of.process, NULL, &sensor_of.sensor, z));
        TEST_ASSERT_EQUAL_MEMORY(theirs.memory, ours.memory, sizeof ours.memory);
    }
}

TEST(a_history_records)
{
    static word tape[2][S_HISTORY_LEN(3, 2, 10, 0)];
    S(history) h[2];
    S(filter) view[2];
    begin(3, 2, 0);
    for (int i = 0; i < 2; i++) {
        ASSERT_OK(S(history_assign)(&h[i], 3, tape[i], COUNT(tape[i])));
        ASSERT_OK(S(attach)(&filters[i]->filter, &h[i].attached));
    }
    for (int t = 0; t < 5; t++) step_both(&dense[2], NULL, words_for(N(t), 1));
    TEST_ASSERT_EQUAL_INT(6, (int)S(history_steps)(&h[0]));
    for (int i = 0; i < 2; i++) {
        ASSERT_OK(S(smooth)(&h[i]));
        ASSERT_OK(S(smoothed)(&h[i], 1, &view[i]));
    }
    for (int i = 0; i < 3; i++) TEST_ASSERT_TRUE(S(mean)(&view[0], i) == S(mean)(&view[1], i));
}

/* Both filters by the same steps; one in four is a predict and an update. */
static void run_both(void)
{
    for (int t = 0; t < 60; t++) {
        const word *z = words_for(N(t % 3), 1);
        if (t % 4 == 1 && t < 8) {
            predict_both(&dense[2], NULL);
            update_both(&dense[2], z);
            ASSERT_SAME_FILTERS();
        } else {
            step_both(&dense[2], NULL, z);
        }
    }
    TEST_ASSERT_EQUAL_HEX(0, S(events)(&ours.filter));
}

/* What is attached follows the steps of known sizes as it does the library's. */
TEST(a_lag_and_an_instant_follow)
{
    S_LAG(lag, 3, 2, 4);
    S_LAG(other_lag, 3, 2, 4);
    S_INSTANT(point, 3, 2);
    S_INSTANT(other_point, 3, 2);
    S(filter) view[4];
    begin(3, 2, 0);
    ASSERT_OK(S(attach)(&ours.filter, &lag.attached));
    ASSERT_OK(S(attach)(&theirs.filter, &other_lag.attached));
    run_both();
    TEST_ASSERT_EQUAL_INT(4, S(lag_steps)(&lag));
    ASSERT_OK(S(lagged)(&lag, 4, &view[0]));
    ASSERT_OK(S(lagged)(&other_lag, 4, &view[1]));
    ASSERT_OK(S(attach)(&ours.filter, &point.attached));
    ASSERT_OK(S(attach)(&theirs.filter, &other_point.attached));
    run_both();
    ASSERT_OK(S(instant_smooth)(&point, &view[2]));
    ASSERT_OK(S(instant_smooth)(&other_point, &view[3]));
    for (int i = 0; i < 3; i++) {
        TEST_ASSERT_TRUE(S(mean)(&view[0], i) == S(mean)(&view[1], i));
        TEST_ASSERT_TRUE(S(mean)(&view[2], i) == S(mean)(&view[3], i));
    }
}

/* Noise-free and repeated: the library's own function takes what is unusual. */
TEST(an_unusual_measurement_is_taken_with_care)
{
    begin(4, 2, 0);
    memset(R, 0, sizeof R);
    make_sensor(4, 2);
    for (int t = 0; t < 2; t++) { /* the second time it says nothing new */
        update_both(&dense[3], words_for(1, 2));
        TEST_ASSERT_EQUAL_INT(S(taken)(&theirs.filter), S(taken)(&ours.filter));
        TEST_ASSERT_EQUAL_UINT(S(events)(&theirs.filter), S(events)(&ours.filter));
        for (int i = 0; i < 4; i++) {
            ASSERT_ALIKE(word_value(&prior, S(mean)(&theirs.filter, i), i), word_value(&prior, S(mean)(&ours.filter, i), i), 8);
            ASSERT_ALIKE(word_value(&prior, S(sigma)(&theirs.filter, i), i), word_value(&prior, S(sigma)(&ours.filter, i), i), 2);
        }
    }
    const double run = number_of_score(S(log_likelihood)(&theirs.filter));
    ASSERT_ALIKE(run, number_of_score(S(log_likelihood)(&ours.filter)), 64 + fabs(run));
}

TEST(a_correlated_R_is_decorrelated)
{
    static const num correlated[] = {1, 0.5, 0.5, 2};
    begin(4, 2, 0);
    memcpy(R, correlated, sizeof R);
    make_sensor(4, 2);
    step_both(&dense[3], NULL, words_for(1, 2));
}

/* ------------------------------------------------------------------ the steady state */

typedef kq_status steady_function(S(steady) *, const word *, const word *);

enum { GAINS = 3 };

S_STEADY(steady_ours, STATES, COMPONENTS);
S_STEADY(steady_theirs, STATES, COMPONENTS);
static entry gains[GAINS * STATES * COMPONENTS];

static void begin_steady(int n, int m, int upper_only)
{
    begin(n, m, upper_only);
    for (int k = 0; k < COUNT(gains); k++) gains[k] = number((double)draw() / 8);
    ASSERT_OK(S(steady_assign)(&steady_ours, n, m, steady_ours_memory, COUNT(steady_ours_memory)));
    ASSERT_OK(S(steady_assign)(&steady_theirs, n, m, steady_theirs_memory, COUNT(steady_theirs_memory)));
    ASSERT_OK(S(steady_init)(&steady_ours, &process_of.process, &sensor_of.sensor, prior.mean, gains, GAINS));
    ASSERT_OK(S(steady_init)(&steady_theirs, &process_of.process, &sensor_of.sensor, prior.mean, gains, GAINS));
}

static void steady_both(steady_function *step, const word *u, const word *z)
{
    ASSERT_OK(step(&steady_ours, u, z));
    ASSERT_OK(S(steady_step)(&steady_theirs, u, z));
    ASSERT_SAME_BITS(steady_ours_memory, steady_theirs_memory);
}

/* Three gains, the last one for good, with and without a control */
static void compare_steady(steady_function *step, int n, int m, int upper_only)
{
    begin_steady(n, m, upper_only);
    for (int t = 0; t < STEPS; t++) {
        const word *z = draw_measurement(1), *u = draw_control();
        steady_both(step, t % 3 ? u : NULL, z);
    }
}

TEST(the_steady_states_bits_are_those_of_run_time_sizes)
{
    compare_steady(steady_1_1_dense, 1, 1, 0);
    compare_steady(steady_1_1_upper, 1, 1, 1);
    compare_steady(steady_4_2_dense, 4, 2, 0);
    compare_steady(steady_4_2_dense, 4, 2, 1);
    compare_steady(steady_4_2_upper, 4, 2, 1);
    compare_steady(steady_4_2_upper, 4, 2, 0); /* is not upper triangular: taken as it is */
    compare_steady(steady_4_2_dense, 3, 2, 0); /* of another size, the same */
}

static const word *bad_words(int c)
{
    static word z[2];
    z[0] = z[1] = 0;
    z[c] = bad_word(&sensor_of.sensor, 2); /* beyond every range */
    return z;
}

TEST(the_steady_states_errors_are_those_of_the_library)
{
    begin_steady(4, 2, 0);
    for (int t = 0; t < GAINS; t++) {
        TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, steady_4_2_dense(NULL, NULL, words_for(1, 2)));
        TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, steady_4_2_dense(&steady_ours, NULL, NULL));
        for (int c = 0; c < 2; c++) TEST_ASSERT_EQUAL_INT(NOT_A_NUMBER, steady_4_2_dense(&steady_ours, NULL, bad_words(c)));
        TEST_ASSERT_EQUAL_INT(NOT_A_NUMBER, steady_4_2_dense(&steady_ours, bad_words(0), words_for(1, 2)));
        ASSERT_SAME_BITS(steady_ours_memory, steady_theirs_memory);
#ifdef KQ_TEST_Q31
        steady_both(steady_4_2_dense, NULL, words_for(1, 2));
#else
        const num most[] = {NUM_MAX, NUM_MAX}, both[] = {(num)INFINITY, -(num)INFINITY}; /* finite, though their sum is not */
        TEST_ASSERT_EQUAL_INT(NOT_A_NUMBER, steady_4_2_dense(&steady_ours, NULL, both));
        steady_both(steady_4_2_dense, NULL, t == 2 ? most : words_for(1, 2));
#endif
    }
    ASSERT_OK(S(steady_assign)(&steady_ours, 4, 2, steady_ours_memory, COUNT(steady_ours_memory)));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NOT_READY, steady_4_2_upper(&steady_ours, NULL, words_for(1, 2)));
}

/* ------------------------------------------------------------------ errors */

/* What is wrong is said as ever, and nothing has changed. */
TEST(errors_are_those_of_the_library)
{
    const fixed_size *size = &dense[3];
    S(filter) *f = &ours.filter;
    begin(4, 2, 0);
    const S(process) *p = &process_of.process;
    const S(sensor) *s = &sensor_of.sensor;
    const word *z = words_for(1, 2);
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, size->predict(NULL, p, NULL));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, size->predict(f, NULL, NULL));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, size->update(f, NULL, z));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, size->update(f, s, NULL));
    TEST_ASSERT_EQUAL_INT(NOT_A_NUMBER, size->update(f, s, bad_words(1)));
    TEST_ASSERT_EQUAL_INT(NOT_A_NUMBER, size->predict(f, p, bad_words(0)));
    TEST_ASSERT_EQUAL_INT(NOT_A_NUMBER, size->step(f, p, NULL, s, bad_words(1)));
    TEST_ASSERT_EQUAL_INT(NOT_A_NUMBER, size->step(f, p, bad_words(0), s, z));
    ASSERT_SAME_FILTERS();
#ifdef KQ_TEST_Q31
    ASSERT_OK(kq_process_change_jacobian_q31(&process_of.process, process_of.transition, NULL));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NOT_READY, size->predict(f, p, NULL));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NOT_READY, size->step(f, p, NULL, s, z));
    ASSERT_SAME_FILTERS();
#endif
    ASSERT_OK(S(filter_assign)(f, 4, ours.memory, COUNT(ours.memory)));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NOT_READY, size->step(f, p, NULL, s, z));
}

/* Objects of other sizes than were said are taken by the sizes they have. */
TEST(other_sizes_are_taken_as_they_are)
{
    for (int n = 3; n <= 4; n++) {
        begin(n, 2, 0);
        step_both(&dense[n == 3 ? 3 : 2], NULL, words_for(1, 2));
    }
}

/* A diagonal below 1/2, whose distance from 1 is rounded */
TEST(a_rounded_A_is_taken_as_it_is)
{
    for (int k = 0; k < 2 * COUNT(dense); k++) {
        const fixed_size *size = k % 2 ? &upper[k / 2] : &dense[k / 2];
        begin(size->n, size->m, k % 2);
        for (int i = 0; i < size->n; i++) A[i * (size->n + 1)] = N(0.3);
        make_process(size->n);
        step_many(size, STEPS, 1);
    }
}

/* Controls that are not as many as was said are taken as many as they are; of none that were said, too. */
TEST(other_numbers_of_controls_are_taken_as_they_are)
{
    static process_model two_controls;
    static num two[2 * STATES];
    begin(2, 1, 0);
    for (int i = 0; i < COUNT(two); i++) two[i] = draw() / 4;
    const word u[] = {*words_for_control(1), *words_for_control(2)};
    put_process(&two_controls, 2, 2, range, range, A, two, Q);
    ASSERT_OK(dense[1].predict(&ours.filter, &two_controls.process, u));
    ASSERT_OK(S(predict)(&theirs.filter, &two_controls.process, u));
    ASSERT_SAME_FILTERS();
    ASSERT_OK(predict_of_no_control(&ours.filter, &process_of.process, u));
    ASSERT_OK(S(predict)(&theirs.filter, &process_of.process, u));
    ASSERT_SAME_FILTERS();
}

/* ------------------------------------------------------------------ what is attached */

/* Steps that predict and update apart by turns, of a filter that something is attached to */
static void compare_attached(const fixed_size *size)
{
    for (int t = 0; t < STEPS; t++) {
        const word *z = draw_measurement(1), *u = draw_control();
        if (t % 6 == 4) {
            predict_both(size, u);
            update_both(size, z);
            ASSERT_SAME_FILTERS();
        } else {
            step_both(size, u, z);
        }
        assert_same_likelihood();
    }
}

S_ADAPTATION(learns_ours, STATES, COMPONENTS);
S_ADAPTATION(learns_theirs, STATES, COMPONENTS);

TEST(an_adaptation_learns)
{
    const S(adaptation_rule) rule = usual_rule();
    S(adaptation) *const a[] = {&learns_ours, &learns_theirs};
    for (int k = 0; k < COUNT(dense); k++) {
        begin(dense[k].n, dense[k].m, 0);
        ASSERT_OK(ASSIGN_ADAPTATION(learns_ours, dense[k].n, dense[k].m));
        ASSERT_OK(ASSIGN_ADAPTATION(learns_theirs, dense[k].n, dense[k].m));
        for (int i = 0; i < 2; i++) {
            ASSERT_OK(S(adaptation_init)(a[i], &process_of.process, &sensor_of.sensor, &rule));
            ASSERT_OK(S(attach)(&filters[i]->filter, &a[i]->attached));
        }
        compare_attached(&dense[k]);
        entry q[2], r[2];
        for (int i = 0; i < 2; i++) ASSERT_OK(S(adaptation_scales)(a[i], &q[i], &r[i]));
        TEST_ASSERT_TRUE(number_of(r[0]) != 1);
        ASSERT_SAME_BITS(r[0], r[1]);
        ASSERT_SAME_BITS(q[0], q[1]);
        TEST_ASSERT_EQUAL_MEMORY(a[0]->information, a[1]->information, sizeof a[0]->information);
    }
}

TEST(a_settling_settles)
{
    static word memory[2][S_ROOT_LEN(STATES)];
    static entry gain[2][STATES * COMPONENTS];
    S(freeze) w[2];
    for (int k = 0; k < COUNT(dense); k++) {
        const fixed_size *size = &dense[k];
        begin(size->n, size->m, 0);
        for (int i = 0; i < size->n * size->n; i++) A[i] /= 2;
        make_process(size->n);
        for (int i = 0; i < 2; i++) {
            ASSERT_OK(S(freeze_assign)(&w[i], size->n, size->m, memory[i], COUNT(memory[i]), gain[i]));
            ASSERT_OK(S(freeze_init)(&w[i], 4));
            ASSERT_OK(S(attach)(&filters[i]->filter, &w[i].attached));
        }
        compare_attached(size);
        step_many(size, STEPS, 1);
        for (int i = 0; i < 2; i++) TEST_ASSERT_EQUAL_INT(1, S(freeze_is_active)(&w[i]));
    }
}

TEST(an_unknown_start_becomes_known)
{
    static word memory[2][S_DIFFUSE_LEN(STATES, 0)];
    S(diffuse) s[2];
    for (int k = 0; k < COUNT(dense); k++) {
        begin(dense[k].n, dense[k].m, 0);
        for (int i = 0; i < 2; i++) {
            ASSERT_OK(S(diffuse_assign)(&s[i], dense[k].n, 0, memory[i], COUNT(memory[i])));
            ASSERT_OK(init_start(&s[i], &filters[i]->filter, &prior, UINT32_MAX));
        }
        compare_attached(&dense[k]);
        for (int i = 0; i < 2; i++) TEST_ASSERT_EQUAL_INT(0, S(diffuse_count)(&s[i]));
    }
}

/* ------------------------------------------------------------------ at the ends of the numbers */

#ifdef KQ_TEST_Q31
TEST_Q31(a_sharp_measurement_is_taken_with_care)
{
    begin(4, 2, 0);
    R[0] = R[3] = 1e-9;
    r_is_diagonal = 1;
    make_sensor(4, 2);
    for (int t = 0; t < 3; t++) {
        step_both(&dense[3], NULL, draw_measurement(1));
        assert_same_likelihood();
    }
}

/* States within +-128, (5, 20, 0, 0) measured: the first component alone leaves state 0 at 550.  Sharp, and not. */
static void beyond_between_components(const fixed_size *size, double variance, int with_likelihood)
{
    static const double rows[] = {0.0625, 1.875, 0, 0, 0.0625, 0, 0, 0}, z[] = {37.8125, 0.3125};
    static const double wide[] = {1e4, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    begin(4, 2, 0);
    memcpy(H, rows, sizeof rows), memcpy(P0, wide, sizeof wide), memset(x0, 0, sizeof x0);
    R[0] = R[3] = variance;
    make_sensor(4, 2);
    begin_filters(4);
    update_both(size, words_for(z[0], z[1]));
    ASSERT_SAME_FILTERS();
    if (with_likelihood) assert_same_likelihood();
    TEST_ASSERT_EQUAL_HEX(0, kq_events_q31(&ours.filter));
}

TEST_Q31(a_mean_may_leave_its_word_between_components)
{
    beyond_between_components(&dense[3], 1e-4, 1);
    beyond_between_components(&bare[3], 1e-4, 0);
    beyond_between_components(&dense[3], 0.5, 1);
    beyond_between_components(&bare[3], 0.5, 0);
}
#else
/* The library takes its measurements, and says what it took in part. */
TEST_FLOAT(a_lean_sensor_is_left_to_the_library)
{
    static const num noises[][2] = {{1, 1}, {1, 0}};
    const num z[2] = {1, 2};
    for (int k = 0; k < COUNT(dense); k++) {
        if (dense[k].m != 2) continue;
        for (int sharp = 0; sharp < 2; sharp++) {
            begin(dense[k].n, 2, 0);
            ASSERT_OK(init_lean(&sensor_of, noises[sharp]));
            step_both(&dense[k], NULL, z);
            TEST_ASSERT_EQUAL_UINT(sharp ? KQ_EVENT_LOW_NOISE : 0, S(events)(&ours.filter));
        }
    }
}

/* Up to n = 3 the library takes the step from its beginning: its very bits. */
TEST_FLOAT(what_is_unusual_at_small_sizes_has_the_librarys_bits)
{
    static const num huge[] = {1, (num)1e6, (num)1e30};
    for (int k = 0; k < 3; k++) {
        for (int j = 0; j < COUNT(huge); j++) {
            begin(dense[k].n, dense[k].m, 0);
            step_many(&dense[k], 4, huge[j]); /* outliers, and what overflows */
            for (int is_weak = 0; is_weak < 2; is_weak++) {
                const num r = is_weak ? (num)1e8 : j == 0 ? 0 : (num)1e-9;
                for (int c = 0; c < dense[k].m; c++) R[c * (dense[k].m + 1)] = r;
                make_sensor(dense[k].n, dense[k].m);
                step_many(&dense[k], 4, 1); /* noise-free, and sharp; then what says next to nothing */
                assert_same_likelihood();
            }
        }
    }
}

TEST_FLOAT(a_state_that_grows_is_held_as_by_the_library)
{
    for (int k = 0; k < COUNT(dense); k++) {
        begin(dense[k].n, dense[k].m, 0);
        for (int i = 0; i < dense[k].n; i++) A[i * (dense[k].n + 1)] = (num)1e6;
        make_process(dense[k].n);
        for (int t = 0; t < 60; t++) {
            predict_both(&dense[k], NULL);
        }
        TEST_ASSERT_TRUE(S(events)(&ours.filter) & KQ_EVENT_OVERFLOW);
    }
}

/* Predicts of both until there is an event, and some more; what brings the state back is taken by both. */
static void compare_until_held(const fixed_size *size, const num *drive)
{
    const num z[COMPONENTS] = {1, 2};
    for (int left = -1, t = 0; left && t < 3000; t++, left -= left > 0) {
        predict_both(size, drive);
        if (left < 0 && S(events)(&ours.filter)) left = 3;
    }
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_OVERFLOW, S(events)(&ours.filter));
    for (int t = 0; t < 3; t++) {
        ASSERT_OK(size->step(&ours.filter, &process_of.process, NULL, &sensor_of.sensor, z));
        ASSERT_OK(S(step)(&theirs.filter, &process_of.process, NULL, &sensor_of.sensor, z));
        TEST_ASSERT_EQUAL_HEX(S(events)(&theirs.filter), S(events)(&ours.filter));
        if (size->n < STATES) ASSERT_SAME_FILTERS(); /* of the largest, what is unusual is taken from there on */
    }
}

/* State 0 through the last one alone, and by its mean alone */
TEST_FLOAT(what_leaves_the_numbers_otherwise_is_held_as_by_the_library)
{
    const num u[1] = {2};
    for (int k = 0; k < COUNT(dense); k++) {
        const fixed_size *sizes[] = {&dense[k], &upper[k], &bare[k]};
        const int n = dense[k].n;
        for (int way = 0; way < 3; way++) {
            begin(n, dense[k].m, way == 1);
            B[n / 2] = NUM_MAX;
            make_process(n);
            compare_until_held(sizes[way], u);
            if (n == 1) continue;
            memset(A, 0, sizeof A), memset(P0, 0, sizeof P0), memset(Q, 0, sizeof Q);
            for (int i = 0; i < n; i++) A[i * (n + 1)] = 1;
            A[0] = 2, A[n - 1] = 1, P0[n * n - 1] = 1;
            make_process(n);
            for (int i = 0; i < n; i++) x0[i] = 0;
            begin_filters(n);
            compare_until_held(sizes[way], NULL);
        }
    }
}
#endif

static void set_up(void)
{
    seed = 1;
    r_is_diagonal = sizeof(entry) != sizeof(num);
}

SUITE(fixed, set_up)
#include "fixed.tests"
