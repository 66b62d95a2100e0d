/* Numbers that must come out: published examples and closed forms, all digits of them, in all arithmetics. */
#include "models.h"

/* What is allowed: so much in q31; so many roundings of numbers of a size; printed digits in f64, six of them in f32 */
#ifdef KQ_TEST_Q31
#define ALLOWED(fixed, size) ((void)(size), (double)(fixed))
#define PRINTED(digits) 1.5e-8
#else
#define ALLOWED(fixed, size) ((void)(fixed), TOLERANCE * (double)(size))
#define PRINTED(digits) (sizeof(num) == sizeof(float) ? 1e-6 : 0.5 * (digits))
#endif

static process_model motion, rest;
static sensor_model radar, gauge;
static prior_model prior;
S_FILTER(track, 2);
S_FILTER(level, 1);
S_HISTORY(tape, 1, 1, 25, 0);

static const num identity[] = {1, 0, 0, 1}, one[] = {1}, zero[] = {0, 0}, range[] = {10, 10}, level_range[] = {100};
static const num half[] = {0.5, 0, 0, 0.5}, drifting[] = {N(0.5), N(0.4), N(0.6), N(0.3)};

static void set_up(void)
{
    put_process(&rest, 1, 0, level_range, level_range, one, NULL, zero);
    put_sensor(&gauge, 1, 1, level_range, level_range, one, one);
}

static void begin_track(const num *far, const num *A, const num *Q, const num *R, const num *x0, const num *P0)
{
    put_process(&motion, 2, 0, far, far, A, NULL, Q);
    put_sensor(&radar, 2, 2, far, far, identity, R);
    put_prior(&prior, 2, far, x0, P0);
    ASSERT_OK(init_filter(&track, &prior));
}

static void begin_level(const num *x0, const num *P0)
{
    put_prior(&prior, 1, level_range, x0, P0);
    ASSERT_OK(init_filter(&level, &prior));
}

static void assert_state(const double *x, const double *P)
{
    reading now;
    read_now(&now, &track, 2);
    for (int i = 0; i < 2; i++) ASSERT_WITHIN(ALLOWED(1e-8, 1), x[i], whole(&now, i));
    for (int k = 0; k < 4; k++) ASSERT_WITHIN(ALLOWED(1e-8, 0.1), P[k], now.P[k]);
}

TEST(the_rocket)
{
    static const num A[] = {N(1.2), 0, 0, N(-0.2)}, Q[] = {N(0.12), N(0.09), N(0.09), N(0.135)};
    static const num P0[] = {N(0.4), N(0.3), N(0.3), N(0.45)};
    static const num R[] = {N(0.2), N(0.15), N(0.15), N(0.225)};
    static const num x0[] = {N(0.2), N(-0.2)}, z[] = {N(2.3), N(-1.9)};
    static const double x[] = {1.6, -4.0 / 3}, P[] = {2.0 / 15, 0.1, 0.1, 0.15};
    static const double moved[] = {1.92, 4.0 / 15}, predicted[] = {0.312, 0.066, 0.066, 0.141};
    begin_track(range, A, Q, R, x0, P0);
    ASSERT_OK(S(update)(&track, &radar.sensor, measured(&radar.sensor, z)));
    assert_state(x, P);
    ASSERT_OK(S(predict)(&track, &motion.process, NULL));
    assert_state(moved, predicted);
}

static void assert_steady_state(double q, double p00, double p01, double p11)
{
    const num Q[] = {N(q), 0, 0, N(q)};
    const double printed[] = {p00, p01, p01, p11};
    static const num start[] = {100, 0, 0, 100};
    reading now;
    begin_track(range, drifting, Q, half, zero, start);
    for (int k = 0; k < 100; k++) {
        ASSERT_OK(S(update)(&track, &radar.sensor, measured(&radar.sensor, zero)));
        ASSERT_OK(S(predict)(&track, &motion.process, NULL));
    }
    read_now(&now, &track, 2);
    for (int k = 0; k < 4; k++) ASSERT_WITHIN(PRINTED(1.01e-8), printed[k], now.P[k]);
}

TEST(the_recursion_settles)
{
    assert_steady_state(0.3, 0.40329108, 0.1050718, 0.41061709);
    assert_steady_state(0.5, 0.62286148, 0.12527948, 0.63270989);
    assert_steady_state(0.1, 0.16433113, 0.06508848, 0.16752408);
}

/* --------------------------------------------------------------------- constant states */

/* The mean and the variance of `level`, or of what a smoother shows of it */
static void assert_level(double fixed, double size, double mean, double sigma, const reading *now)
{
    ASSERT_WITHIN(ALLOWED(fixed, size), mean, whole(now, 0));
    ASSERT_WITHIN(ALLOWED(1e-7 * sigma, sigma), sigma, sqrt((double)now->P[0]));
}

static void step_level(num z)
{
    ASSERT_OK(S(step)(&level, &rest.process, NULL, &gauge.sensor, measured(&gauge.sensor, &z)));
}

/* x = a^2 / (a^2 + s^2 / k) mean(z),  P = 1 / (1 / a^2 + k / s^2) */
static void assert_constant(double a2, double s2)
{
    const num P0[] = {N(a2)}, variance[] = {N(s2)};
    uint32_t seed = 1;
    reading now;
    double sum = 0;
    put_sensor(&gauge, 1, 1, level_range, level_range, one, variance);
    begin_level(zero, P0);
    for (int k = 1; k <= 100; k++) {
        const num z = 3 + noise(&seed);
        sum += (double)z;
        step_level(z);
        read_now(&now, &level, 1);
        const double P = 1 / (1 / (double)P0[0] + k / (double)variance[0]);
        assert_level(5e-7, 4, P / (double)variance[0] * sum, sqrt(P), &now);
    }
}

TEST(a_constant_is_the_weighted_mean)
{
    assert_constant(4, 1);
    assert_constant(0.25, 2);
    assert_constant(1e3, 0.1);
}

/* The same constant, smoothed: at every step what is known at the end. */
TEST(a_constant_smoothed_is_the_final_mean)
{
    static const num P0[] = {4};
    uint32_t seed = 5;
    reading now;
    double sum = 0;
    begin_level(zero, P0);
    ASSERT_OK(S(attach)(&level, &tape.attached));
    for (int k = 0; k < 25; k++) {
        const num z = 3 + noise(&seed);
        sum += (double)z;
        if (k > 0) ASSERT_OK(S(predict)(&level, &rest.process, NULL));
        ASSERT_OK(S(update)(&level, &gauge.sensor, measured(&gauge.sensor, &z)));
    }
    ASSERT_OK(S(smooth)(&tape));
    const double P = 1 / (0.25 + 25);
    for (size_t t = 0; t < 25; t++) {
        read_smoothed_at(&now, &tape, t, &prior, 1);
        assert_level(5e-7, 4, P * sum, sqrt(P), &now);
    }
}

/* The probability that the state is not within 10 +- 0.1 */
static double probability_outside(void)
{
    reading now;
    read_now(&now, &level, 1);
    const double sigma = sqrt((double)now.P[0]), mean = whole(&now, 0);
    const double above = (10.1 - mean) / sigma, below = (mean - 9.9) / sigma;
    return 0.5 * (erfc(above / sqrt(2)) + erfc(below / sqrt(2)));
}

/* One run of 600 steps; outside[0 .. 3] += the probability after 1, 100, 300, 600 of them. */
static void concentrate(uint32_t seed, double *outside)
{
    static const num x0[] = {8};
    reading now;
    double sum = 8;
    begin_level(x0, one);
    for (int k = 1; k <= 600; k++) {
        const num z = 10 + noise(&seed);
        sum += (double)z;
        step_level(z);
        if (k == 1) outside[0] += probability_outside();
        if (k == 100) outside[1] += probability_outside();
        if (k == 300) outside[2] += probability_outside();
    }
    outside[3] += probability_outside();
    read_now(&now, &level, 1);
    assert_level(1e-6, 20, sum / 601, 1 / sqrt(601), &now);
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

/* Three sums of squares over all runs: of the filter's prediction error, of that of a predictor
   that sees the true state before, and what the filter's P says of the first. */
typedef struct {
    double filter, oracle, stated;
} squares;

static void one_step(double *x, uint32_t *seed, squares *sum)
{
    const double E[] = {0.5 * x[0] + 0.4 * x[1], 0.6 * x[0] + 0.3 * x[1]};
    reading now;
    num z[2];
    for (int i = 0; i < 2; i++) z[i] = N(x[i] + sqrt(0.5) * (double)noise(seed));
    ASSERT_OK(S(update)(&track, &radar.sensor, measured(&radar.sensor, z)));
    ASSERT_OK(S(predict)(&track, &motion.process, NULL));
    read_now(&now, &track, 2);
    for (int i = 0; i < 2; i++) {
        x[i] = E[i] + sqrt(0.3) * (double)noise(seed);
        const double e = x[i] - whole(&now, i);
        sum->filter += e * e;
        sum->oracle += (x[i] - E[i]) * (x[i] - E[i]);
        sum->stated += (double)now.P[3 * i];
    }
}

/* The filter's error is as large as it says: P- settles at trace 0.81391; the predictor that
   sees the state has trace Q = 0.6.  4000 squares: 2.2 % standard error, 4 of them allowed. */
TEST(prediction_errors_are_as_large_as_stated)
{
    static const num Q[] = {N(0.3), 0, 0, N(0.3)}, far[] = {50, 50};
    static const num x0[] = {8, 8}, P0[] = {N(0.9), N(0.3), N(0.3), N(0.9)};
    squares sum = {0, 0, 0};
    uint32_t seed = 7;
    for (int k = 0; k < RUNS; k++) {
        /* P0 = [.9 .3; .3 .9] = L L',  L = [.948683 0; .316228 .894427] */
        const double a = (double)noise(&seed), b = (double)noise(&seed);
        double x[] = {8 + sqrt(0.9) * a, 8 + sqrt(0.1) * a + sqrt(0.8) * b};
        begin_track(far, drifting, Q, half, x0, P0);
        for (int t = 0; t < LENGTH; t++) one_step(x, &seed, &sum);
    }
    const double count = RUNS * LENGTH;
    ASSERT_WITHIN(0.01, 0.81391, sum.stated / count);
    ASSERT_WITHIN(0.09 * 0.6, 0.6, sum.oracle / count);
    ASSERT_WITHIN(0.09 * 0.81391, sum.stated / count, sum.filter / count);
    ASSERT_WITHIN(0.12, 0.81391 / 0.6, sum.filter / sum.oracle);
    TEST_ASSERT_TRUE(sum.filter > sum.oracle);
}

SUITE(numbers, set_up)
#include "numbers.tests"
