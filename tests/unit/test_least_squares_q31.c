/* Fading memory and least squares in q31: against those in double, what is refused, wind-up. */
#include "q31.h"
#include "reading.h"
#include "unchanged.h"

#define STEPS 200

static const double range[] = {1000, 1000}, measured_range[] = {200};
static const double x0[] = {1, -2}, P0[] = {2, 0.5, 0.5, 1};

static prior_model start;
static kq_format_q31 measured_format[1];
static kq_least_squares_q31 fit, other;
KQ_FILTER_Q31(line, 2);
KQ_FILTER_Q31(blank, 2);
KQ_HISTORY_Q31(tape, 2, 1, 4, 0);

/* the same in double */
static K(least_squares) fit_f64;
FILTER(line_f64, 2);

static const kq_scaled_q31 one = {INT32_C(1) << 30, -30}, half = {INT32_C(1) << 30, -31};
static kq_scaled_q31 h[2], r;
static int32_t z;

static kq_scaled_q31 number(double a)
{
    static const kq_format_q31 whole = {1, 0};
    kq_scaled_q31 made;
    ASSERT_OK(kq_matrix_prepare_q31(&made, &a, 1, 1, &whole, &whole));
    return made;
}

static void begin(double lambda)
{
    ASSERT_OK(kq_filter_init_q31(&line, &start.table, NULL));
    ASSERT_OK(K(filter_init)(&line_f64, x0, P0));
    ASSERT_OK(kq_least_squares_init_q31(&fit, &line, number(lambda), measured_format));
    ASSERT_OK(K(least_squares_init)(&fit_f64, &line_f64, lambda));
}

static void put_row(const double *row, double value, double variance)
{
    ASSERT_OK(kq_matrix_prepare_q31(h, row, 1, 2, measured_format, start.state_format));
    ASSERT_OK(kq_noise_prepare_diagonal_q31(&r, &variance, 1, measured_format));
    ASSERT_OK(kq_vector_prepare_q31(&z, &value, 1, measured_format, NULL));
}

static void set_up(void)
{
    static const double row[] = {1, 0.5};
    put_prior(&start, 2, range, x0, P0);
    put_formats(measured_format, measured_range, 1);
    put_row(row, 3, 0.5);
    memset(&other, 0, sizeof other);
    ASSERT_OK(kq_filter_assign_q31(&line, 2, line_memory, COUNT(line_memory)));
    begin(1);
    watch_nothing();
    WATCH(fit), WATCH(other), WATCH(line), WATCH(line_memory), WATCH(blank), WATCH(blank_memory);
}

/* a step is good to some units of 2^-30, and forgetting remembers some hundred of them */
#define LIKE 0x1p-22

static void a_run_is_that_in_double(void)
{
    static const double lambdas[] = {1, 0.875, 0.98, 0.9990234375};
    for (int l = 0; l < COUNT(lambdas); l++) {
        uint32_t seed = 7;
        begin(lambdas[l]);
        for (int k = 0; k < STEPS; k++) {
            const double row[] = {1, sin(0.7 * k)}, variance = k % 2 ? 0.5 : 2;
            put_row(row, 10 - 2 * row[1] + noise(&seed), variance);
            const double value = ldexp(z, -measured_format->fraction);
            ASSERT_OK(kq_least_squares_add_q31(&fit, h, &z, &r, 1));
            ASSERT_OK(K(least_squares_add)(&fit_f64, row, &value, &variance, 1));
            ASSERT_LIKE(&line_f64, &line, LIKE);
            const double weight = K(least_squares_weight)(&fit_f64);
            const double residual = K(least_squares_residual)(&fit_f64);
            ASSERT_WITHIN(0x1p-22 * weight, weight, score_value(kq_least_squares_weight_q31(&fit)));
            ASSERT_WITHIN(0x1p-20 * (1 + residual), residual,
                          score_value(kq_least_squares_residual_q31(&fit)));
        }
        TEST_ASSERT_EQUAL_HEX(0, kq_events_q31(&line));
    }
}

static void fading_divides_the_covariance(void)
{
    static const double lambdas[] = {0.5, 0.4, 0.01, 0.75, 0x1p-40, 1 - 0x1p-20};
    for (int l = 0; l < COUNT(lambdas); l++) {
        begin(1);
        ASSERT_OK(kq_forget_q31(&line, number(lambdas[l])));
        ASSERT_OK(K(forget)(&line_f64, lambdas[l]));
        ASSERT_LIKE(&line_f64, &line, 0x1p-27);
    }
}

static void fading_by_1_changes_nothing(void)
{
    ASSERT_OK_UNCHANGED(kq_forget_q31(&line, one));
    ASSERT_OK(kq_attach_q31(&line, &tape.attached));
    ASSERT_OK_UNCHANGED(kq_forget_q31(&line, one));
}

/* Rounded to nearest, each of 4096 times; a factor rounded once would be off by 4096 units. */
static void many_small_fades_do_not_drift(void)
{
    const double lambda = 1 - 0x1p-10;
    const double expected = exp(-4096 * log(lambda)) * 2;
    double P[4];
    for (int k = 0; k < 4096; k++) ASSERT_OK(kq_forget_q31(&line, number(lambda)));
    covariance_values(&line, start.state_format, P);
    ASSERT_WITHIN(256 * 0x1p-29 * expected, expected, P[0]);
}

static void fading_stops_before_the_numbers_end(void)
{
    kq_scaled_q31 P[4], later[4];
    for (int k = 0; k < 400; k++) ASSERT_OK(kq_forget_q31(&line, half));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_OVERFLOW, kq_events_q31(&line));
    ASSERT_OK(kq_covariance_q31(&line, P));
    TEST_ASSERT_INT_WITHIN(1, 200 - 31, P[0].exponent);
    ASSERT_OK(kq_forget_q31(&line, (kq_scaled_q31){INT32_C(1) << 30, -1000}));
    ASSERT_OK(kq_covariance_q31(&line, later));
    TEST_ASSERT_EQUAL_MEMORY(P, later, sizeof P);
    ASSERT_OK(kq_least_squares_add_q31(&fit, h, &z, &r, 1));
    TEST_ASSERT_EQUAL_INT(1, kq_taken_q31(&line));
}

static void all_at_once_are_one_after_the_other(void)
{
    KQ_FILTER_Q31(twin, 2);
    kq_scaled_q31 rows[4], noises[2];
    memcpy(rows, h, sizeof h), memcpy(rows + 2, h, sizeof h);
    noises[0] = noises[1] = r;
    const int32_t values[] = {z, z / 2};
    ASSERT_OK(kq_filter_init_q31(&twin, &start.table, NULL));
    ASSERT_OK(kq_least_squares_init_q31(&other, &twin, half, measured_format));
    ASSERT_OK(kq_least_squares_init_q31(&fit, &line, half, measured_format));
    ASSERT_OK(kq_least_squares_add_q31(&fit, rows, values, noises, 2));
    ASSERT_OK(kq_least_squares_add_q31(&other, h, &values[0], &r, 1));
    ASSERT_OK(kq_least_squares_add_q31(&other, h, &values[1], &r, 1));
    ASSERT_SAME_Q31(&twin, &line);
    ASSERT_OK_UNCHANGED(kq_least_squares_add_q31(&fit, rows, values, noises, 0));
    ASSERT_REFUSED(KQ_ERR_SIZE, kq_least_squares_add_q31(&fit, rows, values, noises, KQ_COUNT_MAX + 1));
    ASSERT_REFUSED(KQ_ERR_SIZE, kq_least_squares_add_q31(&fit, rows, values, noises, SIZE_MAX));
    noises[1].mantissa = -r.mantissa;
    ASSERT_REFUSED(KQ_ERR_TABLE, kq_least_squares_add_q31(&fit, rows, values, noises, 2));
    noises[1] = r;
    rows[3].mantissa = 1;
    ASSERT_REFUSED(KQ_ERR_COEFFICIENT, kq_least_squares_add_q31(&fit, rows, values, noises, 2));
}

/* ------------------------------------------------------------ what is refused */

static void lambda_is_checked(void)
{
    static const kq_scaled_q31 unfit[] = {{1, 0}, {(1 << 30) - 1, -30}, {0, 1}, {INT32_MIN, -31}};
    static const kq_scaled_q31 out[] = {
        {0, 0}, {-(1 << 30), -30}, {(1 << 30) + 1, -30}, {1 << 30, -29}, {1 << 30, 900}};
    for (int k = 0; k < COUNT(unfit); k++) {
        ASSERT_REFUSED(KQ_ERR_COEFFICIENT, kq_forget_q31(&line, unfit[k]));
        ASSERT_REFUSED(KQ_ERR_COEFFICIENT,
                       kq_least_squares_init_q31(&fit, &line, unfit[k], measured_format));
    }
    for (int k = 0; k < COUNT(out); k++) {
        ASSERT_REFUSED(KQ_ERR_RANGE, kq_forget_q31(&line, out[k]));
        ASSERT_REFUSED(KQ_ERR_RANGE,
                       kq_least_squares_init_q31(&fit, &line, out[k], measured_format));
    }
}

static void fade_refuses(void)
{
    ASSERT_REFUSED(KQ_ERR_NULL, kq_forget_q31(NULL, half));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_forget_q31(&blank, half));
    ASSERT_OK(kq_attach_q31(&line, &tape.attached));
    WATCH(tape), WATCH(tape_memory);
    ASSERT_REFUSED(KQ_ERR_RECORDING, kq_forget_q31(&line, half));
}

static void init_refuses(void)
{
    static const kq_format_q31 unfit[] = {{0, 0}, {1, 95}, {1, -65}};
    ASSERT_REFUSED(KQ_ERR_NULL, kq_least_squares_init_q31(NULL, &line, one, measured_format));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_least_squares_init_q31(&fit, NULL, one, measured_format));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_least_squares_init_q31(&fit, &line, one, NULL));
    for (int k = 0; k < COUNT(unfit); k++) {
        ASSERT_REFUSED(KQ_ERR_TABLE, kq_least_squares_init_q31(&fit, &line, one, &unfit[k]));
    }
}

static void add_refuses(void)
{
    ASSERT_REFUSED(KQ_ERR_NULL, kq_least_squares_add_q31(NULL, h, &z, &r, 1));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_least_squares_add_q31(&fit, NULL, &z, &r, 1));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_least_squares_add_q31(&other, h, &z, &r, 1));
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_least_squares_add_q31(&fit, h, (const int32_t[]){measured_format->range + 1}, &r, 1));
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_least_squares_add_q31(&fit, h, (const int32_t[]){INT32_MIN}, &r, 1));
    const kq_scaled_q31 large[] = {{1 << 30, 0}, {0, 0}}, negative = {-r.mantissa, r.exponent};
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_least_squares_add_q31(&fit, large, &z, &r, 1));
    ASSERT_REFUSED(KQ_ERR_TABLE, kq_least_squares_add_q31(&fit, h, &z, &negative, 1));
    ASSERT_REFUSED(KQ_ERR_COEFFICIENT, kq_least_squares_add_q31(&fit, h, &z, &(kq_scaled_q31){1, 0}, 1));
    ASSERT_OK(kq_least_squares_init_q31(&other, &blank, one, measured_format));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_least_squares_add_q31(&other, h, &z, &r, 1));
    ASSERT_OK(kq_least_squares_init_q31(&fit, &line, half, measured_format));
    ASSERT_OK(kq_attach_q31(&line, &tape.attached));
    ASSERT_REFUSED(KQ_ERR_RECORDING, kq_least_squares_add_q31(&fit, h, &z, &r, 1));
}

static void readings_of_nothing_are_none(void)
{
    TEST_ASSERT_TRUE(kq_least_squares_residual_q31(NULL) == KQ_NOT_A_SCORE_Q31);
    TEST_ASSERT_TRUE(kq_least_squares_weight_q31(NULL) == KQ_NOT_A_SCORE_Q31);
    TEST_ASSERT_TRUE(kq_least_squares_residual_q31(&other) == KQ_NOT_A_SCORE_Q31);
    TEST_ASSERT_TRUE(kq_least_squares_weight_q31(&other) == KQ_NOT_A_SCORE_Q31);
    TEST_ASSERT_TRUE(kq_least_squares_residual_q31(&fit) == 0);
}

/* Outliers as large as a word: the sum is held, and fades. */
static void the_residual_is_held(void)
{
    static const double row[] = {1, 0};
    begin(0.5);
    put_row(row, -200, 0x1p-40);
    for (int k = 0; k < 40; k++) ASSERT_OK(kq_least_squares_add_q31(&fit, h, (const int32_t[]){k % 2 ? z : -z}, &r, 1));
    const int64_t held = kq_least_squares_residual_q31(&fit);
    TEST_ASSERT_TRUE(held > 0 && held <= INT64_C(1) << 61);
}

SUITE(least_squares, set_up)
{
    RUN_TEST(a_run_is_that_in_double);
    RUN_TEST(fading_divides_the_covariance);
    RUN_TEST(fading_by_1_changes_nothing);
    RUN_TEST(many_small_fades_do_not_drift);
    RUN_TEST(fading_stops_before_the_numbers_end);
    RUN_TEST(all_at_once_are_one_after_the_other);
    RUN_TEST(lambda_is_checked);
    RUN_TEST(fade_refuses);
    RUN_TEST(init_refuses);
    RUN_TEST(add_refuses);
    RUN_TEST(readings_of_nothing_are_none);
    RUN_TEST(the_residual_is_held);
}
