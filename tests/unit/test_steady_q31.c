/* The steady filter in fixed point: gains of the equation in double, and ranges; test_settling.c runs the filters. */
#include "q31.h"
#include "unchanged.h"

enum { N = 2, M = 2, GAINS = 30, RUN = 200 };

static const double A[] = {1, 0.1, 0, 1}, B[] = {0.005, 0.1}, H[] = {1, 0, 0.5, 1};
static const double Q[] = {0.02, 0.005, 0.005, 0.04}, R[] = {0.5, 0.1, 0.1, 0.25};
static const double P0[] = {4, 0, 0, 2}, x0[] = {3, -1};
static const double range[] = {1000, 100}, drive_range[] = {10}, measured_range[] = {2000, 500};

static process_model motion;
static sensor_model radar;
static prior_model prior;

PROCESS(exact_motion, N, 1); /* the same in double */
SENSOR(exact_radar, N, M);

KQ_FILTER_Q31(other, N);

KQ_STEADY_Q31(steady, N, M);

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
    put_sensor(&radar, N, M, range, measured_range, H, R);
    put_prior(&prior, N, range, x0, P0);
    ASSERT_OK(K(process_init)(&exact_motion, A, B, Q));
    ASSERT_OK(K(sensor_init)(&exact_radar, H, R));
    make_gains();
    ASSERT_OK(kq_steady_assign_q31(&steady, N, M, steady_memory, COUNT(steady_memory)));
    ASSERT_OK(kq_steady_init_q31(&steady, &motion.process, &radar.sensor, prior.mean, gains, GAINS));
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

TEST(the_gains_lead_to_the_steady_one)
{
    solve(NULL, NULL);
    for (int k = 0; k < N * M; k++) {
        const double expected = value_of(solved[k], 0);
        ASSERT_WITHIN(4 * 0x1p-14, expected, value_of(gains[(GAINS - 1) * N * M + k], 0));
    }
}

/* ------------------------------------------------------------------ the filter */

/* The steady gain from the equation in double: the textbook in double with the same gain */
TEST(a_gain_of_doubles_is_run)
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

/* The mean is held at the ends of its word, and comes back. */
TEST(a_mean_that_leaves_its_word_is_held)
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
TEST(gains_of_any_size_are_taken)
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

static kq_status begin(const kq_scaled_q31 *K)
{
    return kq_steady_init_q31(&steady, &motion.process, &radar.sensor, prior.mean, K, 1);
}

TEST(the_filter_refuses_what_is_wrong)
{
    kq_scaled_q31 bad[N * M] = {{0, 0}, {0, 0}, {0, 0}, {0, 0}};
    WATCH(steady), WATCH(steady_memory);
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
    ASSERT_OK(begin(gains));
}

SUITE(steady_q31, set_up)
#include "steady_q31.tests"
