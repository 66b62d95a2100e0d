/* The steady state in fixed point: the filter and the freeze filter. */
#include "q31.h"
#include "unchanged.h"

enum { N = 2, M = 2, GAINS = 30, RUN = 200 };

static const double A[] = {1, 0.1, 0, 1}, B[] = {0.005, 0.1}, H[] = {1, 0, 0.5, 1};
static const double Q[] = {0.02, 0.005, 0.005, 0.04}, R[] = {0.5, 0.1, 0.1, 0.25};
static const double P0[] = {4, 0, 0, 2}, x0[] = {3, -1};
static const double range[] = {1000, 100}, drive_range[] = {10}, measured_range[] = {2000, 500};

static process_model motion, twin;
static sensor_model radar;
static prior_model prior;

PROCESS(exact_motion, N, 1); /* the same in double */
SENSOR(exact_radar, N, M);
FILTER(exact, N);

KQ_FILTER_Q31(track, N);
KQ_FILTER_Q31(other, N);
KQ_FILTER_Q31(blank, N);

KQ_HISTORY_Q31(tape, N, M, RUN, 0);
KQ_STEADY_Q31(steady, N, M);
KQ_STEADY_Q31(blank_steady, N, M);
KQ_FREEZE_Q31(lazy, N, M);
KQ_FREEZE_Q31(blank_lazy, N, M);
static kq_process_q31 blank_process;
static kq_sensor_q31 blank_sensor;

static kq_scaled_q31 gains[GAINS * N * M], solved[N * M];
static int32_t u[1], z[M];
static double exact_u[1], exact_z[M];
static uint32_t seed;

/* -1 .. 1 */
static double draw(void)
{
    seed = seed * 1664525 + 1013904223;
    return ((int)(seed >> 20) - 2048) / 2048.0;
}

static void draw_step(void)
{
    exact_u[0] = draw();
    memcpy(u, words_of(exact_u, 1, motion.control_format), sizeof u);
    for (int c = 0; c < M; c++) exact_z[c] = 3 * draw();
    memcpy(z, words_of(exact_z, M, radar.measurement_format), sizeof z);
}

/* The gains of the first updates behind the prior */
static void make_gains(void)
{
    ASSERT_OK(kq_filter_init_q31(&other, &prior.table, NULL));
    for (int t = 0; t < GAINS; t++) {
        ASSERT_OK(kq_gain_q31(&other, &radar.sensor, gains + t * N * M));
        ASSERT_OK(kq_update_q31(&other, &radar.sensor, words_of(x0, M, radar.measurement_format)));
        ASSERT_OK(kq_predict_q31(&other, &motion.process, NULL));
    }
}

static void set_up(void)
{
    seed = 1;
    put_process(&motion, N, 1, range, drive_range, A, B, Q);
    put_process(&twin, N, 1, range, drive_range, A, B, Q);
    put_sensor(&radar, N, M, range, measured_range, H, R);
    put_prior(&prior, N, range, x0, P0);
    ASSERT_OK(K(process_init)(&exact_motion, A, B, Q));
    ASSERT_OK(K(sensor_init)(&exact_radar, H, R));
    ASSERT_OK(K(filter_init)(&exact, x0, P0));
    ASSERT_OK(kq_filter_init_q31(&track, &prior.table, NULL));
    make_gains();
    ASSERT_OK(kq_filter_init_q31(&other, &prior.table, NULL));
    ASSERT_OK(kq_steady_assign_q31(&steady, N, M, steady_memory, COUNT(steady_memory)));
    ASSERT_OK(kq_steady_init_q31(&steady, &motion.process, &radar.sensor, prior.mean, gains, GAINS));
    ASSERT_OK(kq_freeze_assign_q31(&lazy, N, M, lazy_memory, COUNT(lazy_memory), lazy_gain));
    ASSERT_OK(kq_freeze_init_q31(&lazy, 14));
    ASSERT_OK(kq_attach_q31(&track, &lazy.attached));
    watch_nothing();
}

/* K and P of the equation, in double, and K as a table */
static void solve(double *predicted, double *filtered)
{
    static double memory[KQ_STEADY_SOLVE_LEN_F64(N, M)];
    double K[N * M];
    const kq_steady_solution_f64 out = {predicted, filtered, K, NULL};
    ASSERT_OK(kq_steady_solve_f64(&exact_motion, &exact_radar, memory, COUNT(memory), &out));
    ASSERT_OK(
        kq_matrix_prepare_q31(solved, K, N, M, motion.state_format, radar.measurement_format));
}

static double steady_value(int i)
{
    const double words =
        kq_steady_mean_q31(&steady, i) + ldexp(kq_steady_mean_low_q31(&steady, i), -24);
    return ldexp(words, -motion.state_format[i].fraction);
}

/* ------------------------------------------------------------------ the filter's gains */

static void the_gains_lead_to_the_steady_one(void)
{
    solve(NULL, NULL);
    for (int k = 0; k < N * M; k++) {
        const double expected = value_of(solved[k], 0);
        ASSERT_WITHIN(4 * 0x1p-14, expected, value_of(gains[(GAINS - 1) * N * M + k], 0));
    }
}

/* ------------------------------------------------------------------ the filter */

/* As the full filter: within what the gain has left to 2^-14, and rounding */
static void the_scheduled_filter_is_the_full_one(void)
{
    for (int t = 0; t < RUN; t++) {
        draw_step();
        if (t > 0) {
            ASSERT_OK(kq_predict_q31(&track, &motion.process, u));
            ASSERT_OK(kq_steady_predict_q31(&steady, u));
        }
        ASSERT_OK(kq_update_q31(&track, &radar.sensor, z));
        ASSERT_OK(kq_steady_update_q31(&steady, z));
        const double gain_left = t < GAINS ? 0 : 0x1p-14 / (1 - 0.8);
        for (int i = 0; i < N; i++) {
            ASSERT_WITHIN(8 * gain_left + 2e-6, mean_value(&track, i), steady_value(i));
        }
    }
    TEST_ASSERT_EQUAL_HEX(0, kq_steady_events_q31(&steady));
}

/* The steady gain from the equation in double: the textbook in double with the same gain */
static void a_gain_of_doubles_is_run(void)
{
    double x[] = {3, -1};
    solve(NULL, NULL);
    ASSERT_OK(kq_steady_init_q31(&steady, &motion.process, &radar.sensor, prior.mean, solved, 1));
    for (int t = 0; t < RUN; t++) {
        double e[M], K[N * M];
        draw_step();
        for (int k = 0; k < N * M; k++) {
            K[k] = value_of(solved[k], motion.state_format[k / M].fraction -
                                           radar.measurement_format[k % M].fraction);
        }
        const double a = A[0] * x[0] + A[1] * x[1] + B[0] * exact_u[0];
        const double b = A[2] * x[0] + A[3] * x[1] + B[1] * exact_u[0];
        for (int c = 0; c < M; c++) e[c] = exact_z[c] - H[c * N] * a - H[c * N + 1] * b;
        x[0] = a + K[0] * e[0] + K[1] * e[1];
        x[1] = b + K[2] * e[0] + K[3] * e[1];
        ASSERT_OK(kq_steady_step_q31(&steady, u, z));
        /* half a word of z and of u, and coefficients of 31 bits */
        for (int i = 0; i < N; i++) ASSERT_WITHIN(2e-6, x[i], steady_value(i));
    }
}

static void a_step_is_a_predict_and_an_update(void)
{
    static int32_t memory[KQ_STEADY_LEN_Q31(N)];
    static kq_steady_q31 second;
    ASSERT_OK(kq_steady_assign_q31(&second, N, M, memory, COUNT(memory)));
    ASSERT_OK(kq_steady_init_q31(&second, &motion.process, &radar.sensor, prior.mean, gains, GAINS));
    for (int t = 0; t < RUN; t++) {
        draw_step();
        ASSERT_OK(kq_steady_step_q31(&steady, t % 2 ? u : NULL, z));
        ASSERT_OK(kq_steady_predict_q31(&second, t % 2 ? u : NULL));
        ASSERT_OK(kq_steady_update_q31(&second, z));
        ASSERT_SAME_BITS(steady_memory, memory);
    }
}

static void the_innovation_is_that_of_the_mean(void)
{
    int32_t e[M], same[M];
    draw_step();
    WATCH(steady), WATCH(steady_memory), WATCH(z);
    ASSERT_OK_UNCHANGED(kq_steady_innovation_q31(&steady, z, e));
    for (int c = 0; c < M; c++) {
        const double expected = exact_z[c] - H[c * N] * x0[0] - H[c * N + 1] * x0[1];
        ASSERT_WITHIN(4e-6, expected, ldexp(e[c], -radar.measurement_format[c].fraction));
    }
    memcpy(same, z, sizeof z);
    ASSERT_OK(kq_steady_innovation_q31(&steady, same, same));
    ASSERT_SAME_BITS(e, same);
}

/* The mean is held at the ends of its word, and comes back. */
static void a_mean_that_leaves_its_word_is_held(void)
{
    static const double most[] = {10};
    memcpy(u, words_of(most, 1, motion.control_format), sizeof u);
    for (int t = 0; t < 3000; t++) ASSERT_OK(kq_steady_predict_q31(&steady, u));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_SATURATED, kq_steady_events_q31(&steady));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, kq_steady_mean_q31(&steady, 0));
    kq_steady_events_clear_q31(&steady);
    TEST_ASSERT_EQUAL_HEX(0, kq_steady_events_q31(&steady));
    for (int t = 0; t < 300; t++) {
        draw_step();
        ASSERT_OK(kq_steady_step_q31(&steady, NULL, z));
    }
    TEST_ASSERT_TRUE(fabs(steady_value(0)) < 5);
    kq_steady_events_clear_q31(NULL);
    TEST_ASSERT_EQUAL_HEX(0, kq_steady_events_q31(NULL));
}

/* Gains of any size: nothing overflows. */
static void gains_of_any_size_are_taken(void)
{
    static const int32_t exponents[] = {-1000, -80, -31, -10, 0, 30, 60, 1000};
    for (int k = 0; k < COUNT(exponents); k++) {
        for (int i = 0; i < N * M; i++) solved[i] = (kq_scaled_q31){-INT32_MAX, exponents[k]};
        ASSERT_OK(
            kq_steady_init_q31(&steady, &motion.process, &radar.sensor, prior.mean, solved, 1));
        for (int t = 0; t < 20; t++) {
            draw_step();
            z[0] = t % 2 ? radar.measurement_format[0].range : -radar.measurement_format[0].range;
            ASSERT_OK(kq_steady_step_q31(&steady, u, z));
        }
    }
}

static void what_is_read_of_nothing_is_no_word(void)
{
    TEST_ASSERT_EQUAL_INT32(KQ_NOT_A_VALUE_Q31, kq_steady_mean_q31(NULL, 0));
    TEST_ASSERT_EQUAL_INT32(KQ_NOT_A_VALUE_Q31, kq_steady_mean_q31(&blank_steady, 0));
    TEST_ASSERT_EQUAL_INT32(KQ_NOT_A_VALUE_Q31, kq_steady_mean_q31(&steady, N));
    TEST_ASSERT_EQUAL_INT32(KQ_NOT_A_VALUE_Q31, kq_steady_mean_low_q31(&steady, -1));
}

static kq_status begin(const kq_scaled_q31 *K)
{
    return kq_steady_init_q31(&steady, &motion.process, &radar.sensor, prior.mean, K, 1);
}

static void the_filter_refuses_what_is_wrong(void)
{
    int32_t e[M] = {0};
    kq_scaled_q31 bad[N * M] = {{0, 0}, {0, 0}, {0, 0}, {0, 0}};
    draw_step();
    WATCH(steady), WATCH(steady_memory), WATCH(e);
    ASSERT_REFUSED(KQ_ERR_NULL, kq_steady_step_q31(&steady, u, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_steady_step_q31(NULL, u, z));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_steady_step_q31(&blank_steady, u, z));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_steady_predict_q31(&blank_steady, u));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_steady_update_q31(&blank_steady, z));
    z[1] = radar.measurement_format[1].range + 1;
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_steady_step_q31(&steady, u, z));
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_steady_update_q31(&steady, z));
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_steady_innovation_q31(&steady, z, e));
    u[0] = -motion.control_format[0].range - 1;
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_steady_predict_q31(&steady, u));
    bad[3] = (kq_scaled_q31){1, 0};
    ASSERT_REFUSED(KQ_ERR_COEFFICIENT, begin(bad));
    bad[3] = (kq_scaled_q31){INT32_MAX, 1001};
    ASSERT_REFUSED(KQ_ERR_COEFFICIENT, begin(bad));
    prior.mean[0] = prior.state_format[0].range + 1;
    ASSERT_REFUSED(KQ_ERR_RANGE, begin(gains));
    prior.mean[0] = 0;
    radar.state_format[0].fraction--;
    ASSERT_REFUSED(KQ_ERR_MISMATCH, begin(gains));
    radar.state_format[0].fraction++;
    static const size_t counts[] = {0, KQ_COUNT_MAX + 1, SIZE_MAX};
    for (int k = 0; k < COUNT(counts); k++) {
        ASSERT_REFUSED(KQ_ERR_SIZE, kq_steady_init_q31(&steady, &motion.process, &radar.sensor,
                                                       prior.mean, gains, counts[k]));
    }
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_steady_init_q31(&steady, &blank_process, &radar.sensor,
                                                        prior.mean, gains, 1));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_steady_init_q31(&steady, &motion.process, &blank_sensor,
                                                        prior.mean, gains, 1));
    ASSERT_REFUSED(KQ_ERR_MEMORY, kq_steady_assign_q31(&steady, N, M, steady_memory, 2 * N - 1));
    ASSERT_OK(begin(gains));
}

/* ------------------------------------------------------------------ settling */

static void freeze_steps(int count)
{
    for (int t = 0; t < count; t++) {
        draw_step();
        ASSERT_OK(kq_step_q31(&track, &motion.process, u, &radar.sensor, z));
        ASSERT_OK(kq_step_q31(&other, &motion.process, u, &radar.sensor, z));
    }
}

static void assert_near(int line)
{
    for (int i = 0; i < N; i++) {
        assert_within(8 * 0x1p-14 / (1 - 0.8), mean_value(&other, i), mean_value(&track, i),
                      (unsigned)line);
    }
}

static void it_settles_and_stays_near_the_full_filter(void)
{
    int began = 0;
    for (int t = 0; t < RUN; t++) {
        freeze_steps(1);
        if (!kq_freeze_is_active_q31(&lazy)) ASSERT_SAME_Q31(&other, &track);
        else if (!began) began = t;
        assert_near(__LINE__);
    }
    TEST_ASSERT_TRUE(began > 2 && began < 60);
}

static void what_is_different_unsettles_it(void)
{
    freeze_steps(60);
    TEST_ASSERT_EQUAL_INT(1, kq_freeze_is_active_q31(&lazy));
    draw_step();
    ASSERT_OK(kq_predict_q31(&track, &motion.process, u));
    ASSERT_OK(kq_predict_q31(&other, &motion.process, u));
    TEST_ASSERT_EQUAL_INT(0, kq_freeze_is_active_q31(&lazy));
    assert_near(__LINE__);
    freeze_steps(60);
    TEST_ASSERT_EQUAL_INT(1, kq_freeze_is_active_q31(&lazy));
    ASSERT_OK(kq_step_q31(&track, &twin.process, u, &radar.sensor, z));
    TEST_ASSERT_EQUAL_INT(0, kq_freeze_is_active_q31(&lazy));
    ASSERT_OK(kq_step_q31(&other, &twin.process, u, &radar.sensor, z));
    freeze_steps(60);
    TEST_ASSERT_EQUAL_INT(1, kq_freeze_is_active_q31(&lazy));
    ASSERT_OK(kq_detach_q31(&lazy.attached));
    ASSERT_OK(kq_attach_q31(&track, &tape.attached));
    freeze_steps(3);
    TEST_ASSERT_EQUAL_UINT(4, kq_history_steps_q31(&tape));
    ASSERT_OK(kq_smooth_q31(&tape));
    ASSERT_OK(kq_detach_q31(&tape.attached));
    ASSERT_OK(kq_attach_q31(&track, &lazy.attached));
    TEST_ASSERT_EQUAL_INT(0, kq_freeze_is_active_q31(&lazy));
    freeze_steps(60);
    TEST_ASSERT_EQUAL_INT(1, kq_freeze_is_active_q31(&lazy));
    ASSERT_OK(kq_freeze_release_q31(&lazy));
    freeze_steps(1);
    TEST_ASSERT_EQUAL_INT(0, kq_freeze_is_active_q31(&lazy));
    assert_near(__LINE__);
}

/* Another table in the same object; another A in the same array */
static void new_numbers_of_the_process_unsettle_it(void)
{
    static const double noisy[] = {2, 0, 0, 2}, shorter[] = {1, 0.05, 0, 1};
    freeze_steps(60);
    TEST_ASSERT_EQUAL_INT(1, kq_freeze_is_active_q31(&lazy));
    put_process(&motion, N, 1, range, drive_range, A, B, noisy);
    freeze_steps(1);
    TEST_ASSERT_EQUAL_INT(0, kq_freeze_is_active_q31(&lazy));
    freeze_steps(60);
    TEST_ASSERT_EQUAL_INT(1, kq_freeze_is_active_q31(&lazy));
    ASSERT_OK(kq_matrix_prepare_q31(motion.transition, shorter, N, N, motion.state_format,
                                    motion.state_format));
    ASSERT_OK(kq_process_change_transition_q31(&motion.process, motion.transition, NULL));
    freeze_steps(1);
    TEST_ASSERT_EQUAL_INT(0, kq_freeze_is_active_q31(&lazy));
    assert_near(__LINE__);
}

/* By kq_filter_copy or by assignment: the full filter, while its original stays settled. */
static void a_copied_filter_goes_on_by_itself(void)
{
    KQ_FILTER_Q31(copy, N);
    for (int assigned = 0; assigned < 2; assigned++) {
        freeze_steps(60);
        ASSERT_OK(kq_filter_copy_q31(&other, &track));
        ASSERT_OK(kq_filter_copy_q31(&copy, &track));
        if (assigned) {
            copy = track;
            copy.memory = copy_memory;
        }
        const kq_freeze_q31 before = lazy;
        for (int t = 0; t < 5; t++) {
            draw_step();
            ASSERT_OK(kq_predict_q31(&copy, &motion.process, u));
            ASSERT_OK(kq_update_q31(&copy, &radar.sensor, z));
            ASSERT_OK(kq_step_q31(&other, &motion.process, u, &radar.sensor, z));
            ASSERT_SAME_Q31(&other, &copy);
        }
        TEST_ASSERT_EQUAL_INT(before.phase, lazy.phase);
        TEST_ASSERT_EQUAL_PTR(before.process, lazy.process);
        TEST_ASSERT_EQUAL_HEX32(before.fingerprint, lazy.fingerprint);
        TEST_ASSERT_EQUAL_PTR(before.filter, lazy.filter);
        freeze_steps(1);
        TEST_ASSERT_EQUAL_INT(1, kq_freeze_is_active_q31(&lazy));
    }
}

/* It has a filter until it is detached; f may have been initialised meanwhile. */
static void a_settling_has_one_filter(void)
{
    WATCH(lazy), WATCH(lazy_memory), WATCH(other);
    freeze_steps(60);
    ASSERT_REFUSED(KQ_ERR_RECORDING, kq_attach_q31(&other, &lazy.attached));
    TEST_ASSERT_EQUAL_INT(1, kq_freeze_is_active_q31(&lazy));
    ASSERT_OK(kq_attach_q31(&track, &lazy.attached)); /* to its own once more: it begins again */
    TEST_ASSERT_EQUAL_INT(0, kq_freeze_is_active_q31(&lazy));
    ASSERT_OK(kq_filter_init_q31(&track, &prior.table, NULL));
    ASSERT_REFUSED(KQ_ERR_RECORDING, kq_attach_q31(&other, &lazy.attached));
    ASSERT_OK(kq_attach_q31(&track, &lazy.attached));
    ASSERT_OK(kq_detach_q31(&lazy.attached));
    ASSERT_OK(kq_attach_q31(&other, &lazy.attached));
}

static void assert_steps_are_refused(void)
{
    const kq_process_q31 *p = &motion.process;
    const int32_t kept = z[0];
    ASSERT_REFUSED(KQ_ERR_NULL, kq_step_q31(NULL, p, u, &radar.sensor, z));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_step_q31(&track, NULL, u, &radar.sensor, z));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_step_q31(&track, p, u, NULL, z));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_step_q31(&track, p, u, &radar.sensor, NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_step_q31(&track, &blank_process, u, &radar.sensor, z));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_step_q31(&track, p, u, &blank_sensor, z));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_step_q31(&blank, p, u, &radar.sensor, z));
    z[0] = -radar.measurement_format[0].range - 1;
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_step_q31(&track, p, u, &radar.sensor, z));
    z[0] = kept;
}

static void the_settling_refuses_what_is_wrong(void)
{
    KQ_FREEZE_Q31(wide, 3, M);
    KQ_FREEZE_Q31(tall, N, M + 1);
    kq_scaled_q31 gain[N * M];
    draw_step();
    ASSERT_OK(kq_freeze_init_q31(&wide, 14));
    ASSERT_OK(kq_freeze_init_q31(&tall, 14));
    WATCH(lazy), WATCH(lazy_memory), WATCH(lazy_gain), WATCH(track), WATCH(track_memory);
    WATCH(wide), WATCH(tall), WATCH(blank_lazy), WATCH(blank), WATCH(tape);
    ASSERT_REFUSED(KQ_ERR_NULL, kq_attach_q31(&track, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_attach_q31(NULL, &lazy.attached));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_attach_q31(&track, &blank_lazy.attached));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_attach_q31(&blank, &lazy.attached));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, kq_attach_q31(&track, &wide.attached));
    ASSERT_REFUSED(KQ_ERR_RECORDING, kq_attach_q31(&track, &tall.attached));
    ASSERT_REFUSED(KQ_ERR_RECORDING, kq_attach_q31(&track, &tape.attached));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_detach_q31(NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_detach_q31(&blank_lazy.attached));
    assert_steps_are_refused();
    freeze_steps(60);
    assert_steps_are_refused();
    freeze_steps(1);
    TEST_ASSERT_EQUAL_INT(1, kq_freeze_is_active_q31(&lazy));
    ASSERT_REFUSED(KQ_ERR_SIZE, kq_freeze_init_q31(&lazy, KQ_FREEZE_BITS_MAX_Q31 + 1));
    ASSERT_REFUSED(KQ_ERR_MEMORY, kq_freeze_assign_q31(&lazy, N, M, lazy_memory,
                                                         COUNT(lazy_memory) - 1, gain));
    ASSERT_OK(kq_detach_q31(&lazy.attached));
    ASSERT_OK(kq_attach_q31(&track, &tall.attached));
    ASSERT_REFUSED(KQ_ERR_MISMATCH,
                   kq_step_q31(&track, &motion.process, u, &radar.sensor, z)); /* components */
    ASSERT_OK(kq_detach_q31(&tall.attached));
    ASSERT_OK(kq_freeze_assign_q31(&lazy, N, M, lazy_memory, COUNT(lazy_memory), lazy_gain));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_freeze_release_q31(&lazy));
}

SUITE(steady, set_up)
{
    RUN_TEST(the_gains_lead_to_the_steady_one);
    RUN_TEST(the_scheduled_filter_is_the_full_one);
    RUN_TEST(a_gain_of_doubles_is_run);
    RUN_TEST(a_step_is_a_predict_and_an_update);
    RUN_TEST(the_innovation_is_that_of_the_mean);
    RUN_TEST(a_mean_that_leaves_its_word_is_held);
    RUN_TEST(gains_of_any_size_are_taken);
    RUN_TEST(what_is_read_of_nothing_is_no_word);
    RUN_TEST(the_filter_refuses_what_is_wrong);
    RUN_TEST(it_settles_and_stays_near_the_full_filter);
    RUN_TEST(what_is_different_unsettles_it);
    RUN_TEST(new_numbers_of_the_process_unsettle_it);
    RUN_TEST(a_copied_filter_goes_on_by_itself);
    RUN_TEST(a_settling_has_one_filter);
    RUN_TEST(the_settling_refuses_what_is_wrong);
}
