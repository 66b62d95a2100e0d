/* Numbers that must come out of q31: published examples and closed forms. */
#include "q31.h"

static process_model motion, rest;
static sensor_model radar, gauge;
static prior_model start;
KQ_FILTER_Q31(track, 2);
KQ_FILTER_Q31(level, 1);
KQ_HISTORY_Q31(tape, 1, 1, 25, 0);

static const double identity[] = {1, 0, 0, 1}, one[] = {1}, zero[] = {0, 0};
static const double range[] = {10, 10}, level_range[] = {100};

static void set_up(void)
{
    put_process(&rest, 1, 0, level_range, level_range, one, NULL, zero);
    put_sensor(&gauge, 1, 1, level_range, level_range, one, one);
}

static void assert_state(double tolerance, const double *x, const double *P)
{
    double actual[4];
    covariance_values(&track, start.state_format, actual);
    for (int i = 0; i < 2; i++) ASSERT_WITHIN(tolerance, x[i], mean_value(&track, i));
    for (int k = 0; k < 4; k++) ASSERT_WITHIN(tolerance, P[k], actual[k]);
}

/* -------------------------------------------------------------------------- the rocket */

TEST(the_rocket)
{
    static const double A[] = {1.2, 0, 0, -0.2}, Q[] = {0.12, 0.09, 0.09, 0.135};
    static const double P0[] = {0.4, 0.3, 0.3, 0.45}, R[] = {0.2, 0.15, 0.15, 0.225};
    static const double x0[] = {0.2, -0.2}, z[] = {2.3, -1.9};
    static const double x[] = {1.6, -4.0 / 3}, P[] = {2.0 / 15, 0.1, 0.1, 0.15};
    static const double moved[] = {1.92, 4.0 / 15}, predicted[] = {0.312, 0.066, 0.066, 0.141};
    put_process(&motion, 2, 0, range, range, A, NULL, Q);
    put_sensor(&radar, 2, 2, range, range, identity, R);
    put_prior(&start, 2, range, x0, P0);
    ASSERT_OK(kq_filter_init_q31(&track, &start.table, NULL));
    ASSERT_OK(kq_update_q31(&track, &radar.sensor, words_of(z, 2, radar.measurement_format)));
    assert_state(1e-8, x, P);
    ASSERT_OK(kq_predict_q31(&track, &motion.process, NULL));
    assert_state(1e-8, moved, predicted);
}

/* ------------------------------------------------------------------------ steady state */

static const double drifting[] = {0.5, 0.4, 0.6, 0.3}, half[] = {0.5, 0, 0, 0.5};

static void assert_steady_state(double q, double p00, double p01, double p11)
{
    const double Q[] = {q, 0, 0, q}, P[] = {p00, p01, p01, p11};
    static const double far[] = {100, 0, 0, 100};
    const int32_t nothing[] = {0, 0};
    put_process(&motion, 2, 0, range, range, drifting, NULL, Q);
    put_sensor(&radar, 2, 2, range, range, identity, half);
    put_prior(&start, 2, range, zero, far);
    ASSERT_OK(kq_filter_init_q31(&track, &start.table, NULL));
    for (int k = 0; k < 100; k++) {
        ASSERT_OK(kq_step_q31(&track, &motion.process, NULL, &radar.sensor, nothing));
    }
    ASSERT_OK(kq_predict_q31(&track, &motion.process, NULL));
    assert_state(1.5e-8, zero, P);
}

TEST(the_recursion_settles)
{
    assert_steady_state(0.3, 0.40329108, 0.1050718, 0.41061709);
    assert_steady_state(0.5, 0.62286148, 0.12527948, 0.63270989);
    assert_steady_state(0.1, 0.16433113, 0.06508848, 0.16752408);
}

/* --------------------------------------------------------------------- constant states */

/* About N(0, 1): 12 uniform numbers of 24 bits, seeded, the same on every machine. */
static double noise(uint32_t *seed)
{
    double sum = -6;
    for (int k = 0; k < 12; k++) {
        *seed = *seed * UINT32_C(1664525) + UINT32_C(1013904223);
        sum += (*seed >> 8) / 0x1p24;
    }
    return sum;
}

static double level_sigma(void)
{
    double P[1];
    covariance_values(&level, start.state_format, P);
    return sqrt(P[0]);
}

static void begin_level(double mean, double variance)
{
    const double x[] = {mean}, P[] = {variance};
    put_prior(&start, 1, level_range, x, P);
    ASSERT_OK(kq_filter_init_q31(&level, &start.table, NULL));
}

/* x = a^2 / (a^2 + s^2 / k) mean(z),  P = 1 / (1 / a^2 + k / s^2) */
static void assert_constant(double a2, double s2)
{
    const double variance[] = {s2};
    uint32_t seed = 1;
    double sum = 0;
    put_sensor(&gauge, 1, 1, level_range, level_range, one, variance);
    begin_level(0, a2);
    for (int k = 1; k <= 100; k++) {
        const double z[] = {3 + noise(&seed)};
        const int32_t *words = words_of(z, 1, gauge.measurement_format);
        sum += z[0];
        ASSERT_OK(kq_step_q31(&level, &rest.process, NULL, &gauge.sensor, words));
        const double P = 1 / (1 / a2 + k / s2);
        ASSERT_WITHIN(5e-7, P / s2 * sum, mean_value(&level, 0));
        ASSERT_WITHIN(1e-7 * sqrt(P), sqrt(P), level_sigma());
    }
}

TEST(a_constant_is_the_weighted_mean)
{
    assert_constant(4, 1);
    assert_constant(0.25, 2);
    assert_constant(1e3, 0.1);
}

TEST(a_constant_smoothed_is_the_final_mean)
{
    uint32_t seed = 5;
    double sum = 0;
    begin_level(0, 4);
    ASSERT_OK(kq_attach_q31(&level, &tape.attached));
    for (int k = 0; k < 25; k++) {
        const double z[] = {3 + noise(&seed)};
        sum += z[0];
        if (k > 0) ASSERT_OK(kq_predict_q31(&level, &rest.process, NULL));
        ASSERT_OK(kq_update_q31(&level, &gauge.sensor, words_of(z, 1, gauge.measurement_format)));
    }
    ASSERT_OK(kq_smooth_q31(&tape));
    const double P = 1 / (0.25 + 25);
    const int fraction = start.state_format[0].fraction;
    for (size_t t = 0; t < 25; t++) {
        const double words =
            kq_mean_q31(SMOOTHED_Q31(&tape, t), 0) + ldexp(kq_mean_low_q31(SMOOTHED_Q31(&tape, t), 0), -24);
        kq_scaled_q31 variance;
        ASSERT_WITHIN(5e-7, P * sum, ldexp(words, -fraction));
        ASSERT_OK(kq_covariance_q31(SMOOTHED_Q31(&tape, t), &variance));
        ASSERT_WITHIN(1e-7 * P, P, value_of(variance, 2 * fraction));
    }
}

/* Constant 10, prior N(8, 1), unit noise: the probability outside 10 +- 0.1 */
static double probability_outside(void)
{
    const double sigma = level_sigma(), mean = mean_value(&level, 0);
    return 0.5 * (erfc((10.1 - mean) / sigma / sqrt(2)) + erfc((mean - 9.9) / sigma / sqrt(2)));
}

static void concentrate(uint32_t seed, double *outside)
{
    double sum = 8;
    begin_level(8, 1);
    for (int k = 1; k <= 600; k++) {
        const double z[] = {10 + noise(&seed)};
        const int32_t *words = words_of(z, 1, gauge.measurement_format);
        sum += z[0];
        ASSERT_OK(kq_step_q31(&level, &rest.process, NULL, &gauge.sensor, words));
        if (k == 1) outside[0] += probability_outside();
        if (k == 100) outside[1] += probability_outside();
        if (k == 300) outside[2] += probability_outside();
    }
    outside[3] += probability_outside();
    ASSERT_WITHIN(1e-6, sum / 601, mean_value(&level, 0));
    ASSERT_WITHIN(1e-6 / sqrt(601), 1 / sqrt(601), level_sigma());
}

TEST(the_posterior_concentrates_on_the_state)
{
    double outside[4] = {0, 0, 0, 0};
    for (uint32_t seed = 1; seed <= 10; seed++) concentrate(seed, outside);
    TEST_ASSERT_TRUE(outside[0] > 9);
    TEST_ASSERT_TRUE(outside[1] < 0.7 * outside[0]);
    TEST_ASSERT_TRUE(outside[2] < 0.7 * outside[1]);
    TEST_ASSERT_TRUE(outside[3] < 0.7 * outside[2]);
    TEST_ASSERT_TRUE(outside[3] < 1);
}

/* ------------------------------------------------------------------- prediction errors */

#define RUNS 40
#define LENGTH 50

/* Sums of squares: the filter's prediction error, that of a predictor which sees the state, and
   what the filter's P says of the first */
typedef struct {
    double filter, oracle, stated;
} squares;

static void one_step(double *x, uint32_t *seed, squares *sum)
{
    const double z[] = {x[0] + sqrt(0.5) * noise(seed), x[1] + sqrt(0.5) * noise(seed)};
    const double E[] = {0.5 * x[0] + 0.4 * x[1], 0.6 * x[0] + 0.3 * x[1]};
    double P[4];
    ASSERT_OK(kq_update_q31(&track, &radar.sensor, words_of(z, 2, radar.measurement_format)));
    ASSERT_OK(kq_predict_q31(&track, &motion.process, NULL));
    covariance_values(&track, start.state_format, P);
    for (int i = 0; i < 2; i++) {
        x[i] = E[i] + sqrt(0.3) * noise(seed);
        const double e = x[i] - mean_value(&track, i);
        sum->filter += e * e;
        sum->oracle += (x[i] - E[i]) * (x[i] - E[i]);
        sum->stated += P[3 * i];
    }
}

TEST(prediction_errors_are_as_large_as_stated)
{
    static const double Q[] = {0.3, 0, 0, 0.3}, P0[] = {0.9, 0.3, 0.3, 0.9}, x0[] = {8, 8};
    static const double far[] = {50, 50};
    squares sum = {0, 0, 0};
    uint32_t seed = 7;
    put_process(&motion, 2, 0, far, far, drifting, NULL, Q);
    put_sensor(&radar, 2, 2, far, far, identity, half);
    put_prior(&start, 2, far, x0, P0);
    for (int k = 0; k < RUNS; k++) {
        const double a = noise(&seed), b = noise(&seed);
        double x[] = {8 + sqrt(0.9) * a, 8 + sqrt(0.1) * a + sqrt(0.8) * b};
        ASSERT_OK(kq_filter_init_q31(&track, &start.table, NULL));
        for (int t = 0; t < LENGTH; t++) one_step(x, &seed, &sum);
    }
    const double count = RUNS * LENGTH;
    ASSERT_WITHIN(0.01, 0.81391, sum.stated / count);
    ASSERT_WITHIN(0.09 * 0.6, 0.6, sum.oracle / count);
    ASSERT_WITHIN(0.09 * 0.81391, sum.stated / count, sum.filter / count);
    TEST_ASSERT_TRUE(sum.filter > sum.oracle);
}

SUITE(numbers_q31, set_up)
#include "numbers_q31.tests"
