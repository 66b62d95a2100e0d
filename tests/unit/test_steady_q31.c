/* The steady state in fixed point: the gain schedule, the filter, the smoother and the settling filter. */
#include "q31.h"
#include "unchanged.h"

enum { N = 2, M = 2, STEPS = 60, RUN = 200 };

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
KQ_SETTLING_Q31(lazy, N, M);
KQ_SETTLING_Q31(blank_lazy, N, M);
static kq_process_q31 blank_process;
static kq_sensor_q31 blank_sensor;

static int32_t work[KQ_STEADY_WORK_LEN_Q31(N, M)], root[KQ_ROOT_LEN_Q31(N)];
static kq_scaled_q31 gains[STEPS * N * M], back[N * N], drive[N * M], solved[N * M];
static int32_t u[1], z[M], mean[RUN * N], innovation[RUN * M];
static double exact_u[1], exact_z[M];
static size_t used;
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

static void set_up(void)
{
    seed = 1;
    used = 77;
    put_process(&motion, N, 1, range, drive_range, A, B, Q);
    put_process(&twin, N, 1, range, drive_range, A, B, Q);
    put_sensor(&radar, N, M, range, measured_range, H, R);
    put_prior(&prior, N, range, x0, P0);
    ASSERT_OK(K(process_init)(&exact_motion, A, B, Q));
    ASSERT_OK(K(sensor_init)(&exact_radar, H, R));
    ASSERT_OK(K(filter_init)(&exact, x0, P0));
    ASSERT_OK(kq_filter_init_q31(&track, &prior.table, NULL));
    ASSERT_OK(kq_filter_init_q31(&other, &prior.table, NULL));
    ASSERT_OK(kq_steady_schedule_q31(&track, &motion.process, &radar.sensor, work, COUNT(work), 14,
                                     gains, STEPS, &used));
    ASSERT_OK(kq_steady_assign_q31(&steady, N, M, steady_memory, COUNT(steady_memory)));
    ASSERT_OK(kq_steady_init_q31(&steady, &motion.process, &radar.sensor, prior.mean, gains, used));
    ASSERT_OK(kq_settling_assign_q31(&lazy, N, M, lazy_memory, COUNT(lazy_memory), lazy_gain));
    ASSERT_OK(kq_settling_init_q31(&lazy, 14));
    ASSERT_OK(kq_settling_attach_q31(&lazy, &track));
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

/* ------------------------------------------------------------------ the schedule */

static void the_schedule_leads_from_the_filters_gains_to_the_steady_one(void)
{
    kq_scaled_q31 gain[N * M];
    TEST_ASSERT_TRUE(used > 3 && used < STEPS);
    for (size_t t = 0; t < used; t++) {
        ASSERT_OK(kq_gain_q31(&track, &radar.sensor, gain));
        for (int k = 0; k < N * M; k++) {
            const double expected = value_of(gain[k], 0);
            ASSERT_WITHIN(1e-7, expected, value_of(gains[t * N * M + (size_t)k], 0));
        }
        draw_step();
        ASSERT_OK(kq_update_q31(&track, &radar.sensor, z));
        ASSERT_OK(kq_predict_q31(&track, &motion.process, NULL));
    }
    solve(NULL, NULL);
    for (int k = 0; k < N * M; k++) {
        const double expected = value_of(solved[k], 0);
        ASSERT_WITHIN(4 * 0x1p-14, expected, value_of(gains[(used - 1) * N * M + (size_t)k], 0));
    }
}

static kq_status schedule(size_t length, int bits, size_t steps)
{
    return kq_steady_schedule_q31(&track, &motion.process, &radar.sensor, work, length, bits, gains,
                                  steps, &used);
}

static void the_schedule_refuses_what_is_wrong(void)
{
    const size_t least = COUNT(work);
    WATCH(gains), WATCH(used), WATCH(track), WATCH(track_memory);
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_steady_schedule_q31(&blank, &motion.process, &radar.sensor,
                                                            work, least, 12, gains, STEPS, &used));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_steady_schedule_q31(&track, &motion.process, &radar.sensor, work,
                                                       least, 12, NULL, STEPS, &used));
    ASSERT_REFUSED(KQ_ERR_MEMORY, schedule(least - 1, 12, STEPS));
    ASSERT_REFUSED(KQ_ERR_SIZE, schedule(least, 0, STEPS));
    ASSERT_REFUSED(KQ_ERR_SIZE, schedule(least, KQ_SETTLED_BITS_MAX_Q31 + 1, STEPS));
    ASSERT_REFUSED(KQ_ERR_SIZE, schedule(least, 12, 0));
    ASSERT_REFUSED(KQ_ERR_SIZE, schedule(least, 12, KQ_COUNT_MAX + 1));
    ASSERT_REFUSED(KQ_ERR_SIZE, schedule(least, 12, SIZE_MAX));
    ASSERT_REFUSED(KQ_ERR_NO_CONVERGENCE, schedule(least, 14, used - 1));
    motion.state_format[1].fraction++; /* formats that are not the filter's */
    ASSERT_REFUSED(KQ_ERR_MISMATCH, schedule(least, 12, STEPS));
    motion.state_format[1].fraction--;
    ASSERT_OK(schedule(least, KQ_SETTLED_BITS_MAX_Q31 - 2, STEPS));
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
        const double gain_left = t < (int)used ? 0 : 0x1p-14 / (1 - 0.8);
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
    ASSERT_OK(kq_steady_init_q31(&second, &motion.process, &radar.sensor, prior.mean, gains, used));
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
    TEST_ASSERT_EQUAL_INT32(KQ_NOT_A_WORD_Q31, kq_steady_mean_q31(NULL, 0));
    TEST_ASSERT_EQUAL_INT32(KQ_NOT_A_WORD_Q31, kq_steady_mean_q31(&blank_steady, 0));
    TEST_ASSERT_EQUAL_INT32(KQ_NOT_A_WORD_Q31, kq_steady_mean_q31(&steady, N));
    TEST_ASSERT_EQUAL_INT32(KQ_NOT_A_WORD_Q31, kq_steady_mean_low_q31(&steady, -1));
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

/* ------------------------------------------------------------------ the smoother */

/* A run that begins with the steady covariance, smoothed with covariances and without */
static void the_smoother_is_the_one_with_covariances(void)
{
    double predicted[N * N], filtered[N * N];
    const kq_steady_smoother_q31 constants = {N, M, root, back, drive};
    solve(predicted, filtered);
    put_prior(&prior, N, range, x0, filtered);
    ASSERT_OK(kq_filter_init_q31(&track, &prior.table, NULL));
    ASSERT_OK(kq_steady_smoother_make_q31(&track, &motion.process, &radar.sensor, work, COUNT(work),
                                          root, back, drive));
    put_prior(&prior, N, range, x0, predicted);
    ASSERT_OK(kq_filter_init_q31(&track, &prior.table, NULL));
    ASSERT_OK(kq_history_attach_q31(&tape, &track));
    ASSERT_OK(begin(solved));
    for (int t = 0; t < RUN; t++) {
        draw_step();
        if (t > 0) {
            ASSERT_OK(kq_predict_q31(&track, &motion.process, u));
            ASSERT_OK(kq_steady_predict_q31(&steady, u));
        }
        ASSERT_OK(kq_steady_innovation_q31(&steady, z, innovation + t * M));
        ASSERT_OK(kq_update_q31(&track, &radar.sensor, z));
        ASSERT_OK(kq_steady_update_q31(&steady, z));
        for (int i = 0; i < N; i++) mean[t * N + i] = kq_steady_mean_q31(&steady, i);
    }
    ASSERT_OK(kq_smooth_states_q31(&tape));
    ASSERT_OK(kq_steady_smooth_q31(&constants, mean, innovation, RUN));
    for (int t = 0; t < RUN; t++) { /* words of 5e-7 and 5e-8 */
        for (int i = 0; i < N; i++) {
            const double expected = kq_mean_q31(SMOOTHED_Q31(&tape, (size_t)t), i);
            ASSERT_WITHIN(2e-6, ldexp(expected, -motion.state_format[i].fraction),
                          ldexp(mean[t * N + i], -motion.state_format[i].fraction));
        }
    }
}

/* The constants that the library makes in double, as tables */
static void the_smoothers_constants_are_those_of_doubles(void)
{
    double filtered[N * N], S[KQ_TRIANGLE(N)], J[N * N], j[N * M];
    static double memory[KQ_STEADY_WORK_LEN_F64(N, M)];
    solve(NULL, filtered);
    put_prior(&prior, N, range, x0, filtered);
    ASSERT_OK(kq_filter_init_q31(&track, &prior.table, NULL));
    ASSERT_OK(kq_steady_smoother_make_q31(&track, &motion.process, &radar.sensor, work, COUNT(work),
                                          root, back, drive));
    ASSERT_OK(K(filter_init)(&exact, x0, filtered));
    ASSERT_OK(K(steady_smoother_make)(&exact, &exact_motion, &exact_radar, memory, COUNT(memory), S,
                                      J, j));
    for (int k = 0; k < N * N; k++) ASSERT_WITHIN(1e-7, J[k], value_of(back[k], 0));
    for (int k = 0; k < N * M; k++) {
        const double value = value_of(drive[k], -radar.measurement_format[k % M].fraction);
        ASSERT_WITHIN(1e-7, j[k], value);
    }
}

static kq_status smooth(const kq_steady_smoother_q31 *c)
{
    return kq_steady_smooth_q31(c, mean, innovation, 2);
}

static void the_smoother_refuses_what_is_wrong(void)
{
    const size_t least = COUNT(work);
    const kq_steady_smoother_q31 good = {N, M, root, back, drive};
    kq_steady_smoother_q31 bad = good;
    ASSERT_OK(kq_steady_smoother_make_q31(&track, &motion.process, &radar.sensor, work, least, root,
                                          back, drive));
    watch(mean, sizeof mean), WATCH(root), WATCH(back), WATCH(drive);
    ASSERT_REFUSED(KQ_ERR_NULL, smooth(NULL));
    bad.drive = NULL;
    ASSERT_REFUSED(KQ_ERR_NULL, smooth(&bad));
    bad = good, bad.states = 17;
    ASSERT_REFUSED(KQ_ERR_SIZE, smooth(&bad));
    ASSERT_REFUSED(KQ_ERR_SIZE, kq_steady_smooth_q31(&good, mean, innovation, 0));
    ASSERT_REFUSED(KQ_ERR_SIZE, kq_steady_smooth_q31(&good, mean, innovation, KQ_COUNT_MAX + 1));
    ASSERT_REFUSED(KQ_ERR_SIZE, kq_steady_smooth_q31(&good, mean, innovation, SIZE_MAX));
    ASSERT_REFUSED(KQ_ERR_MEMORY,
                   kq_steady_smoother_make_q31(&track, &motion.process, &radar.sensor, work,
                                               least - 1, root, back, drive));
    ASSERT_REFUSED(KQ_ERR_NOT_READY,
                   kq_steady_smoother_make_q31(&blank, &motion.process, &radar.sensor, work, least,
                                               root, back, drive));
    mean[1] = KQ_NOT_A_WORD_Q31;
    ASSERT_REFUSED(KQ_ERR_RANGE, smooth(&good));
    mean[1] = 0;
    back[0].exponent = -29;
    back[0].mantissa = INT32_MAX;
    ASSERT_REFUSED(KQ_ERR_COEFFICIENT, smooth(&good));
    back[0].exponent = -31;
    root[0] = -1;
    ASSERT_REFUSED(KQ_ERR_TABLE, smooth(&good));
    root[0] = 1;
    ASSERT_OK(smooth(&good));
}

/* Constants and innovations as large as they may be: nothing overflows,
   and what was held is told. */
static void the_smoother_holds_what_is_too_large(void)
{
    const kq_steady_smoother_q31 c = {N, M, root, back, drive};
    for (int k = 0; k < N * N; k++) back[k] = (kq_scaled_q31){INT32_MAX, -30};
    for (int k = 0; k < N * M; k++) drive[k] = (kq_scaled_q31){INT32_MAX, 0};
    for (int k = 0; k < 3; k++) root[k] = INT32_C(1) << 29;
    root[3] = root[4] = 30;
    for (int k = 0; k < RUN * N; k++) mean[k] = INT32_MAX;
    for (int k = 0; k < RUN * M; k++) innovation[k] = INT32_MAX;
    TEST_ASSERT_EQUAL_INT(KQ_SATURATED, kq_steady_smooth_q31(&c, mean, innovation, RUN));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, mean[0]);
}

/* ------------------------------------------------------------------ settling */

static void settling_steps(int count)
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
        settling_steps(1);
        if (!kq_settling_is_settled_q31(&lazy)) ASSERT_SAME_Q31(&other, &track);
        else if (!began) began = t;
        assert_near(__LINE__);
    }
    TEST_ASSERT_TRUE(began > 2 && began < 60);
}

static void what_is_different_unsettles_it(void)
{
    settling_steps(60);
    TEST_ASSERT_EQUAL_INT(1, kq_settling_is_settled_q31(&lazy));
    draw_step();
    ASSERT_OK(kq_predict_q31(&track, &motion.process, u));
    ASSERT_OK(kq_predict_q31(&other, &motion.process, u));
    TEST_ASSERT_EQUAL_INT(0, kq_settling_is_settled_q31(&lazy));
    assert_near(__LINE__);
    settling_steps(60);
    TEST_ASSERT_EQUAL_INT(1, kq_settling_is_settled_q31(&lazy));
    ASSERT_OK(kq_step_q31(&track, &twin.process, u, &radar.sensor, z));
    TEST_ASSERT_EQUAL_INT(0, kq_settling_is_settled_q31(&lazy));
    ASSERT_OK(kq_step_q31(&other, &twin.process, u, &radar.sensor, z));
    settling_steps(60);
    TEST_ASSERT_EQUAL_INT(1, kq_settling_is_settled_q31(&lazy));
    ASSERT_OK(kq_settling_detach_q31(&lazy));
    ASSERT_OK(kq_history_attach_q31(&tape, &track));
    settling_steps(3);
    TEST_ASSERT_EQUAL_UINT(4, kq_history_steps_q31(&tape));
    ASSERT_OK(kq_smooth_q31(&tape));
    ASSERT_OK(kq_history_detach_q31(&tape));
    ASSERT_OK(kq_settling_attach_q31(&lazy, &track));
    TEST_ASSERT_EQUAL_INT(0, kq_settling_is_settled_q31(&lazy));
    settling_steps(60);
    TEST_ASSERT_EQUAL_INT(1, kq_settling_is_settled_q31(&lazy));
    ASSERT_OK(kq_settling_release_q31(&lazy));
    settling_steps(1);
    TEST_ASSERT_EQUAL_INT(0, kq_settling_is_settled_q31(&lazy));
    assert_near(__LINE__);
}

/* Another table in the same object; another A in the same array */
static void new_numbers_of_the_process_unsettle_it(void)
{
    static const double noisy[] = {2, 0, 0, 2}, shorter[] = {1, 0.05, 0, 1};
    settling_steps(60);
    TEST_ASSERT_EQUAL_INT(1, kq_settling_is_settled_q31(&lazy));
    put_process(&motion, N, 1, range, drive_range, A, B, noisy);
    settling_steps(1);
    TEST_ASSERT_EQUAL_INT(0, kq_settling_is_settled_q31(&lazy));
    settling_steps(60);
    TEST_ASSERT_EQUAL_INT(1, kq_settling_is_settled_q31(&lazy));
    ASSERT_OK(kq_matrix_prepare_q31(motion.transition, shorter, N, N, motion.state_format,
                                    motion.state_format));
    ASSERT_OK(kq_process_change_transition_q31(&motion.process, motion.transition));
    settling_steps(1);
    TEST_ASSERT_EQUAL_INT(0, kq_settling_is_settled_q31(&lazy));
    assert_near(__LINE__);
}

/* By kq_filter_copy or by assignment: the full filter, while its original stays settled. */
static void a_copied_filter_goes_on_by_itself(void)
{
    KQ_FILTER_Q31(copy, N);
    for (int assigned = 0; assigned < 2; assigned++) {
        settling_steps(60);
        ASSERT_OK(kq_filter_copy_q31(&other, &track));
        ASSERT_OK(kq_filter_copy_q31(&copy, &track));
        if (assigned) {
            copy = track;
            copy.memory = copy_memory;
        }
        const kq_settling_q31 before = lazy;
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
        settling_steps(1);
        TEST_ASSERT_EQUAL_INT(1, kq_settling_is_settled_q31(&lazy));
    }
}

/* It has a filter until it is detached; f may have been initialised meanwhile. */
static void a_settling_has_one_filter(void)
{
    WATCH(lazy), WATCH(lazy_memory), WATCH(other);
    settling_steps(60);
    ASSERT_REFUSED(KQ_ERR_RECORDING, kq_settling_attach_q31(&lazy, &other));
    TEST_ASSERT_EQUAL_INT(1, kq_settling_is_settled_q31(&lazy));
    ASSERT_OK(kq_settling_attach_q31(&lazy, &track)); /* to its own once more: it begins again */
    TEST_ASSERT_EQUAL_INT(0, kq_settling_is_settled_q31(&lazy));
    ASSERT_OK(kq_filter_init_q31(&track, &prior.table, NULL));
    ASSERT_REFUSED(KQ_ERR_RECORDING, kq_settling_attach_q31(&lazy, &other));
    ASSERT_OK(kq_settling_attach_q31(&lazy, &track));
    ASSERT_OK(kq_settling_detach_q31(&lazy));
    ASSERT_OK(kq_settling_attach_q31(&lazy, &other));
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
    KQ_SETTLING_Q31(wide, 3, M);
    KQ_SETTLING_Q31(tall, N, M + 1);
    kq_scaled_q31 gain[N * M];
    draw_step();
    ASSERT_OK(kq_settling_init_q31(&wide, 14));
    ASSERT_OK(kq_settling_init_q31(&tall, 14));
    WATCH(lazy), WATCH(lazy_memory), WATCH(lazy_gain), WATCH(track), WATCH(track_memory);
    WATCH(wide), WATCH(tall), WATCH(blank_lazy), WATCH(blank), WATCH(tape);
    ASSERT_REFUSED(KQ_ERR_NULL, kq_settling_attach_q31(NULL, &track));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_settling_attach_q31(&lazy, NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_settling_attach_q31(&blank_lazy, &track));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_settling_attach_q31(&lazy, &blank));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, kq_settling_attach_q31(&wide, &track));
    ASSERT_REFUSED(KQ_ERR_RECORDING, kq_settling_attach_q31(&tall, &track));
    ASSERT_REFUSED(KQ_ERR_RECORDING, kq_history_attach_q31(&tape, &track));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_settling_detach_q31(NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_settling_detach_q31(&blank_lazy));
    assert_steps_are_refused();
    settling_steps(60);
    assert_steps_are_refused();
    settling_steps(1);
    TEST_ASSERT_EQUAL_INT(1, kq_settling_is_settled_q31(&lazy));
    ASSERT_REFUSED(KQ_ERR_SIZE, kq_settling_init_q31(&lazy, KQ_SETTLED_BITS_MAX_Q31 + 1));
    ASSERT_REFUSED(KQ_ERR_MEMORY, kq_settling_assign_q31(&lazy, N, M, lazy_memory,
                                                         COUNT(lazy_memory) - 1, gain));
    ASSERT_OK(kq_settling_detach_q31(&lazy));
    ASSERT_OK(kq_settling_attach_q31(&tall, &track));
    ASSERT_REFUSED(KQ_ERR_MISMATCH,
                   kq_step_q31(&track, &motion.process, u, &radar.sensor, z)); /* components */
    ASSERT_OK(kq_settling_detach_q31(&tall));
    ASSERT_OK(kq_settling_assign_q31(&lazy, N, M, lazy_memory, COUNT(lazy_memory), lazy_gain));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_settling_release_q31(&lazy));
}

SUITE(steady, set_up)
{
    RUN_TEST(the_schedule_leads_from_the_filters_gains_to_the_steady_one);
    RUN_TEST(the_schedule_refuses_what_is_wrong);
    RUN_TEST(the_scheduled_filter_is_the_full_one);
    RUN_TEST(a_gain_of_doubles_is_run);
    RUN_TEST(a_step_is_a_predict_and_an_update);
    RUN_TEST(the_innovation_is_that_of_the_mean);
    RUN_TEST(a_mean_that_leaves_its_word_is_held);
    RUN_TEST(gains_of_any_size_are_taken);
    RUN_TEST(what_is_read_of_nothing_is_no_word);
    RUN_TEST(the_filter_refuses_what_is_wrong);
    RUN_TEST(the_smoother_is_the_one_with_covariances);
    RUN_TEST(the_smoothers_constants_are_those_of_doubles);
    RUN_TEST(the_smoother_refuses_what_is_wrong);
    RUN_TEST(the_smoother_holds_what_is_too_large);
    RUN_TEST(it_settles_and_stays_near_the_full_filter);
    RUN_TEST(what_is_different_unsettles_it);
    RUN_TEST(new_numbers_of_the_process_unsettle_it);
    RUN_TEST(a_copied_filter_goes_on_by_itself);
    RUN_TEST(a_settling_has_one_filter);
    RUN_TEST(the_settling_refuses_what_is_wrong);
}
