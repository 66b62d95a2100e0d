/* Numbers that must come out: published examples and closed forms, all digits of them. */
#include "reading.h"

/* printed digits in f64, six of them in f32 */
#define PRINTED(digits) (sizeof(num) == sizeof(float) ? 1e-6 : 0.5 * (digits))

PROCESS(motion, 2, 0);
SENSOR(radar, 2, 2);
FILTER(track, 2);
SENSOR(gauge, 1, 1);
PROCESS(rest, 1, 0);
FILTER(level, 1);
HISTORY(tape, 1, 1, 25, 0);

static const num identity[] = {1, 0, 0, 1}, one[] = {1}, zero[] = {0};

static void set_up(void)
{
    ASSERT_OK(K(process_init)(&rest, one, NULL, zero));
    ASSERT_OK(K(sensor_init)(&gauge, one, one));
}

/* -------------------------------------------------------------------------- the rocket */

TEST(the_rocket)
{
    static const num A[] = {N(1.2), 0, 0, N(-0.2)}, Q[] = {N(0.12), N(0.09), N(0.09), N(0.135)};
    static const num P0[] = {N(0.4), N(0.3), N(0.3), N(0.45)};
    static const num R[] = {N(0.2), N(0.15), N(0.15), N(0.225)};
    static const num x0[] = {N(0.2), N(-0.2)}, z[] = {N(2.3), N(-1.9)};
    static const double filtered[] = {2.0 / 15, 0.1, 0.1, 0.15};
    static const double predicted[] = {0.312, 0.066, 0.066, 0.141};
    num P[4];
    ASSERT_OK(K(process_init)(&motion, A, NULL, Q));
    ASSERT_OK(K(sensor_init)(&radar, identity, R));
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    ASSERT_OK(K(update)(&track, &radar, z));
    ASSERT_CLOSE(1.6, K(mean)(&track, 0), 1);
    ASSERT_CLOSE(-4.0 / 3, K(mean)(&track, 1), 1);
    ASSERT_OK(K(covariance)(&track, P));
    for (int k = 0; k < 4; k++) ASSERT_CLOSE(filtered[k], P[k], 0.1);
    ASSERT_OK(K(predict)(&track, &motion, NULL));
    ASSERT_CLOSE(1.92, K(mean)(&track, 0), 1);
    ASSERT_CLOSE(4.0 / 15, K(mean)(&track, 1), 1);
    ASSERT_OK(K(covariance)(&track, P));
    for (int k = 0; k < 4; k++) ASSERT_CLOSE(predicted[k], P[k], 0.1);
}

/* ------------------------------------------------------------------------ steady state */

static const num drifting[] = {N(0.5), N(0.4), N(0.6), N(0.3)};
static const num half[] = {0.5, 0, 0, 0.5};

static void assert_steady_state(double q, double p00, double p01, double p11)
{
    const num Q[] = {N(q), 0, 0, N(q)};
    const double printed[] = {p00, p01, p01, p11};
    static const num z[2] = {0}, start[] = {100, 0, 0, 100};
    num P[4];
    ASSERT_OK(K(process_init)(&motion, drifting, NULL, Q));
    ASSERT_OK(K(sensor_init)(&radar, identity, half));
    ASSERT_OK(K(filter_init)(&track, z, start));
    for (int k = 0; k < 100; k++) {
        ASSERT_OK(K(update)(&track, &radar, z));
        ASSERT_OK(K(predict)(&track, &motion, NULL));
    }
    ASSERT_OK(K(covariance)(&track, P));
    for (int k = 0; k < 4; k++) ASSERT_WITHIN(PRINTED(1.01e-8), printed[k], P[k]);
}

TEST(the_recursion_settles)
{
    assert_steady_state(0.3, 0.40329108, 0.1050718, 0.41061709);
    assert_steady_state(0.5, 0.62286148, 0.12527948, 0.63270989);
    assert_steady_state(0.1, 0.16433113, 0.06508848, 0.16752408);
}

/* --------------------------------------------------------------------- constant states */

/* x = a^2 / (a^2 + s^2 / k) mean(z),  P = 1 / (1 / a^2 + k / s^2) */
static void assert_constant(double a2, double s2, int last)
{
    const num prior[] = {N(a2)}, variance[] = {N(s2)};
    uint32_t seed = 1;
    double sum = 0;
    ASSERT_OK(K(sensor_init)(&gauge, one, variance));
    ASSERT_OK(K(filter_init)(&level, zero, prior));
    for (int k = 1; k <= last; k++) {
        const num z = 3 + noise(&seed);
        sum += (double)z;
        ASSERT_OK(K(step)(&level, &rest, NULL, &gauge, &z));
        const double P = 1 / (1 / (double)prior[0] + k / (double)variance[0]);
        ASSERT_CLOSE(P / (double)variance[0] * sum, whole_mean(&level, 0), 4);
        ASSERT_CLOSE(sqrt(P), K(sigma)(&level, 0), sqrt(P));
    }
}

TEST(a_constant_is_the_weighted_mean)
{
    assert_constant(4, 1, 100);
    assert_constant(0.25, 2, 100);
    assert_constant(1e3, 0.1, 100);
}

/* The same constant, smoothed: at every step what is known at the end. */
TEST(a_constant_smoothed_is_the_final_mean)
{
    static const num prior[] = {4};
    uint32_t seed = 5;
    double sum = 0;
    ASSERT_OK(K(filter_init)(&level, zero, prior));
    ASSERT_OK(K(attach)(&level, &tape.attached));
    for (int k = 0; k < 25; k++) {
        const num z = 3 + noise(&seed);
        sum += (double)z;
        if (k > 0) ASSERT_OK(K(predict)(&level, &rest, NULL));
        ASSERT_OK(K(update)(&level, &gauge, &z));
    }
    ASSERT_OK(K(smooth)(&tape));
    const double P = 1 / (0.25 + 25);
    for (size_t t = 0; t < 25; t++) {
        ASSERT_CLOSE(P * sum, whole_smoothed_mean(&tape, t, 0), 4);
        ASSERT_CLOSE(sqrt(P), K(sigma)(SMOOTHED(&tape, t), 0), 1);
    }
}

/* The probability that the state is not within 10 +- 0.1 */
static double probability_outside(void)
{
    const double sigma = (double)K(sigma)(&level, 0), mean = whole_mean(&level, 0);
    const double above = (10.1 - mean) / sigma, below = (mean - 9.9) / sigma;
    return 0.5 * (erfc(above / sqrt(2)) + erfc(below / sqrt(2)));
}

/* One run of 600 steps; outside[0 .. 3] += the probability after 1, 100, 300, 600 of them. */
static void concentrate(uint32_t seed, double *outside)
{
    static const num prior_mean[] = {8};
    double sum = 8;
    ASSERT_OK(K(filter_init)(&level, prior_mean, one));
    for (int k = 1; k <= 600; k++) {
        const num z = 10 + noise(&seed);
        sum += (double)z;
        ASSERT_OK(K(step)(&level, &rest, NULL, &gauge, &z));
        if (k == 1) outside[0] += probability_outside();
        if (k == 100) outside[1] += probability_outside();
        if (k == 300) outside[2] += probability_outside();
    }
    outside[3] += probability_outside();
    ASSERT_CLOSE(sum / 601, whole_mean(&level, 0), 20);
    ASSERT_CLOSE(1 / sqrt(601), K(sigma)(&level, 0), 1 / sqrt(601));
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
} errors;

static void measure(const double *x, uint32_t *seed)
{
    num z[2];
    for (int i = 0; i < 2; i++) z[i] = N(x[i] + sqrt(0.5) * (double)noise(seed));
    ASSERT_OK(K(update)(&track, &radar, z));
}

static void predict(double *x, uint32_t *seed, errors *sum)
{
    const double E[] = {0.5 * x[0] + 0.4 * x[1], 0.6 * x[0] + 0.3 * x[1]};
    num P[4];
    ASSERT_OK(K(predict)(&track, &motion, NULL));
    ASSERT_OK(K(covariance)(&track, P));
    for (int i = 0; i < 2; i++) {
        x[i] = E[i] + sqrt(0.3) * (double)noise(seed);
        const double e = x[i] - (double)K(mean)(&track, i);
        sum->filter += e * e;
        sum->oracle += (x[i] - E[i]) * (x[i] - E[i]);
        sum->stated += (double)P[3 * i];
    }
}

/* P0 = [.9 .3; .3 .9] = L L',  L = [.948683 0; .316228 .894427] */
static void run(uint32_t *seed, errors *sum)
{
    static const num x0[] = {8, 8}, P0[] = {N(0.9), N(0.3), N(0.3), N(0.9)};
    const double a = (double)noise(seed), b = (double)noise(seed);
    double x[] = {8 + sqrt(0.9) * a, 8 + sqrt(0.1) * a + sqrt(0.8) * b};
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    for (int t = 0; t < LENGTH; t++) {
        measure(x, seed);
        predict(x, seed, sum);
    }
}

/* The filter's error is as large as it says: P- settles at trace 0.81391; the predictor that
   sees the state has trace Q = 0.6.  4000 squares: 2.2 % standard error, 4 of them allowed. */
TEST(prediction_errors_are_as_large_as_stated)
{
    static const num Q[] = {N(0.3), 0, 0, N(0.3)};
    errors sum = {0, 0, 0};
    uint32_t seed = 7;
    ASSERT_OK(K(process_init)(&motion, drifting, NULL, Q));
    ASSERT_OK(K(sensor_init)(&radar, identity, half));
    for (int k = 0; k < RUNS; k++) run(&seed, &sum);
    const double count = RUNS * LENGTH;
    ASSERT_WITHIN(0.01, 0.81391, sum.stated / count);
    ASSERT_WITHIN(0.09 * 0.6, 0.6, sum.oracle / count);
    ASSERT_WITHIN(0.09 * 0.81391, sum.stated / count, sum.filter / count);
    ASSERT_WITHIN(0.12, 0.81391 / 0.6, sum.filter / sum.oracle);
    TEST_ASSERT_TRUE(sum.filter > sum.oracle);
}

SUITE(numbers, set_up)
#include "numbers.tests"
