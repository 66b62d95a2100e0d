/* Fading memory and least squares: against the normal equations, what is refused, wind-up. */
#include "reading.h"
#include "sizes.h"
#include "unchanged.h"

#define ROWS 12

static K(least_squares) fit, other;
FILTER(line, 2);
FILTER(twin, 2);
FILTER(blank, 2);
PROCESS(motion, 2, 0);
HISTORY(tape, 2, 1, 4, 0);

static const num A[] = {1, 0.5, 0, 1}, Q[] = {0.25, 0.125, 0.125, 0.5};
static const num x0[] = {1, -2}, P0[] = {2, 0.5, 0.5, 1};
static num H[2 * ROWS], z[ROWS], r[ROWS];

static const num unit[] = {1};
static const num endless = (num)INFINITY;

static void set_up(void)
{
    uint32_t seed = 1;
    for (int k = 0; k < ROWS; k++) {
        H[2 * k] = 1;
        H[2 * k + 1] = N(0.25 * k - 1);
        r[k] = N(k % 3 == 0 ? 0.5 : 2);
        z[k] = N(0.5) + 2 * H[2 * k + 1] + noise(&seed);
    }
    ASSERT_OK(K(process_init)(&motion, A, NULL, Q));
    ASSERT_OK(K(filter_init)(&line, x0, P0));
    ASSERT_OK(K(filter_init)(&twin, x0, P0));
    memset(&other, 0, sizeof other);
    ASSERT_OK(K(least_squares_init)(&fit, &line, 1));
    watch_nothing();
    WATCH(fit), WATCH(other), WATCH(line), WATCH(line_memory), WATCH(blank), WATCH(blank_memory);
}

/* ------------------------------------------------------------ fading */

static void fading_divides_the_covariance(void)
{
    num before[4], after[4];
    ASSERT_OK(K(covariance)(&line, before));
    ASSERT_OK(K(forget)(&line, N(0.75)));
    ASSERT_OK(K(covariance)(&line, after));
    for (int k = 0; k < 4; k++) ASSERT_CLOSE((double)before[k] / 0.75, after[k], 4);
    for (int i = 0; i < 2; i++) ASSERT_WITHIN(0, x0[i], K(mean)(&line, i));
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&line));
}

static void fading_by_1_changes_nothing(void)
{
    ASSERT_OK_UNCHANGED(K(forget)(&line, 1));
    ASSERT_OK(K(attach)(&line, &tape.attached));
    ASSERT_OK_UNCHANGED(K(forget)(&line, 1));
}

/* P- = A P A' / lambda + Q, here of P = I */
static void fade_and_predict_is_a_fading_predict(void)
{
    static const num identity[] = {1, 0, 0, 1};
    num P[4];
    ASSERT_OK(K(filter_init)(&line, x0, identity));
    ASSERT_OK(K(forget)(&line, N(0.5)));
    ASSERT_OK(K(predict)(&line, &motion, NULL));
    ASSERT_OK(K(covariance)(&line, P));
    ASSERT_CLOSE(2 * 1.25 + 0.25, P[0], 4);
    ASSERT_CLOSE(2 * 0.5 + 0.125, P[1], 4);
    ASSERT_CLOSE(2 + 0.5, P[3], 4);
}

/* Rounded to nearest, each of 4096 times; a factor rounded once would be off by 4096 eps. */
static void many_small_fades_do_not_drift(void)
{
    const double lambda = 1 - 0x1p-10;
    const double expected = exp(-2048 * log(lambda)) * sqrt(2);
    for (int k = 0; k < 4096; k++) ASSERT_OK(K(forget)(&line, N(1 - 0x1p-10)));
    ASSERT_WITHIN(256 * EPS * expected, expected, K(sigma)(&line, 0));
}

static void fading_stops_before_the_numbers_end(void)
{
    for (int k = 0; k < 3000; k++) ASSERT_OK(K(forget)(&line, N(0.5)));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_OVERFLOW, K(events)(&line));
    const double sigma = (double)K(sigma)(&line, 0);
    TEST_ASSERT_TRUE(sigma > LARGE_SIGMA / 2 && sigma <= LARGE_SIGMA);
    ASSERT_OK(K(forget)(&line, FLT_MIN)); /* the smallest lambda */
    ASSERT_WITHIN(0, sigma, K(sigma)(&line, 0));
    ASSERT_OK(K(least_squares_add)(&fit, H, z, r, 1));
    TEST_ASSERT_TRUE(isfinite(K(mean)(&line, 0)));
    TEST_ASSERT_TRUE(isfinite(K(nis)(&line)));
}

static void fade_refuses(void)
{
    static const num bad[] = {0, -0.5, -1, 1 + (num)EPS, 2};
    ASSERT_REFUSED(KQ_ERR_NULL, K(forget)(NULL, 1));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(forget)(&blank, 1));
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(forget)(&line, (num)NAN));
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(forget)(&line, endless));
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(forget)(&line, -endless));
    for (int k = 0; k < COUNT(bad); k++) ASSERT_REFUSED(KQ_ERR_RANGE, K(forget)(&line, bad[k]));
    ASSERT_OK(K(attach)(&line, &tape.attached));
    WATCH(tape), WATCH(tape_memory);
    ASSERT_REFUSED(KQ_ERR_RECORDING, K(forget)(&line, N(0.5)));
}

/* ------------------------------------------------------------ the solution */

/* The normal equations in double: sum w h'h / r + w0 P0^-1, and J at the solution */
typedef struct {
    double x[2], P[4], J, weight;
    double condition; /* what the determinant loses */
} batch;

static void batch_of(batch *b, const num *start, const num *start_P, int rows, double lambda)
{
    const double det = (double)(start_P[0] * start_P[3] - start_P[1] * start_P[2]);
    const double W0[] = {(double)start_P[3] / det, -(double)start_P[1] / det,
                         (double)start_P[0] / det};
    const double all = exp(rows * log(lambda));
    double a = all * W0[0], c = all * W0[1], d = all * W0[2];
    double u = a * (double)start[0] + c * (double)start[1];
    double v = c * (double)start[0] + d * (double)start[1];
    b->weight = 0;
    for (int k = 0; k < rows; k++) {
        const double g = (double)H[2 * k], h = (double)H[2 * k + 1];
        const double w = exp((rows - 1 - k) * log(lambda)) / (double)r[k];
        a += w * g * g, c += w * g * h, d += w * h * h;
        u += w * g * (double)z[k], v += w * h * (double)z[k];
        b->weight += w * (double)r[k];
    }
    const double D = a * d - c * c;
    b->condition = a * d / D;
    b->P[0] = d / D, b->P[1] = b->P[2] = -c / D, b->P[3] = a / D;
    b->x[0] = b->P[0] * u + b->P[1] * v;
    b->x[1] = b->P[2] * u + b->P[3] * v;
    const double e = b->x[0] - (double)start[0], f = b->x[1] - (double)start[1];
    b->J = all * (W0[0] * e * e + 2 * W0[1] * e * f + W0[2] * f * f);
    for (int k = 0; k < rows; k++) {
        const double miss =
            (double)z[k] - (double)H[2 * k] * b->x[0] - (double)H[2 * k + 1] * b->x[1];
        b->J += exp((rows - 1 - k) * log(lambda)) * miss * miss / (double)r[k];
    }
}

static void assert_batch(const batch *b)
{
    num P[4];
    ASSERT_OK(K(covariance)(&line, P));
    const double size = b->condition * (b->P[0] + b->P[3]);
    for (int i = 0; i < 2; i++) ASSERT_CLOSE(b->x[i], whole_mean(&line, i), 4 * b->condition);
    for (int k = 0; k < 4; k++) ASSERT_CLOSE(b->P[k], P[k], size);
    ASSERT_CLOSE(b->J, K(least_squares_residual)(&fit), b->J + 4);
    ASSERT_CLOSE(b->weight, K(least_squares_weight)(&fit), ROWS);
}

static void the_recursion_is_the_batch(void)
{
    batch b;
    for (int k = 0; k < ROWS; k++) {
        ASSERT_OK(K(least_squares_add)(&fit, H + 2 * k, z + k, r + k, 1));
        batch_of(&b, x0, P0, k + 1, 1);
        assert_batch(&b);
    }
    ASSERT_WITHIN(0, ROWS, K(least_squares_weight)(&fit));
}

static void forgetting_is_the_exponentially_weighted_batch(void)
{
    static const double lambdas[] = {0.5, 0.875, 0.984375};
    batch b;
    for (int l = 0; l < COUNT(lambdas); l++) {
        ASSERT_OK(K(filter_init)(&line, x0, P0));
        ASSERT_OK(K(least_squares_init)(&fit, &line, N(lambdas[l])));
        for (int k = 0; k < ROWS; k++) {
            ASSERT_OK(K(least_squares_add)(&fit, H + 2 * k, z + k, r + k, 1));
            batch_of(&b, x0, P0, k + 1, lambdas[l]);
            assert_batch(&b);
        }
    }
}

static void all_at_once_are_one_after_the_other(void)
{
    ASSERT_OK(K(least_squares_init)(&fit, &line, N(0.75)));
    ASSERT_OK(K(least_squares_init)(&other, &twin, N(0.75)));
    ASSERT_OK(K(least_squares_add)(&fit, H, z, r, ROWS));
    for (int k = 0; k < ROWS; k++) {
        num h[2] = {H[2 * k], H[2 * k + 1]};
        ASSERT_OK(K(least_squares_add)(&other, h, z + k, r + k, 1));
        h[0] = h[1] = (num)NAN; /* it is not kept */
    }
    ASSERT_SAME_FILTER(&twin, &line, 2);
    TEST_ASSERT_EQUAL_MEMORY(&fit.residual, &other.residual, sizeof fit.residual);
    ASSERT_OK_UNCHANGED(K(least_squares_add)(&fit, H, z, r, 0));
}

/* A measurement that says nothing does not count. */
static void what_is_not_taken_does_not_weigh(void)
{
    static const num nothing[] = {0, 0};
    ASSERT_OK(K(least_squares_add)(&fit, nothing, unit, (const num[]){0}, 1));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_REDUNDANT, K(events)(&line));
    ASSERT_WITHIN(0, 0, K(least_squares_weight)(&fit));
    ASSERT_WITHIN(0, 0, K(least_squares_residual)(&fit));
}

static void without_forgetting_it_is_recorded(void)
{
    ASSERT_OK(K(attach)(&line, &tape.attached));
    ASSERT_OK(K(least_squares_add)(&fit, H, z, r, 1));
    ASSERT_OK(K(smooth)(&tape));
    ASSERT_CLOSE(whole_mean(&line, 0), whole_smoothed_mean(&tape, 0, 0), 4);
}

/* Of 16 unknowns, measured one by one with the variance of the prior: half way */
static void there_may_be_1_to_16_unknowns(void)
{
    static num memory[FILTER_LEN(16)], mean[16], P[256], h[16];
    K(filter) many;
    for (int n = 1; n <= 16; n++) {
        put_identity(P, n, 4);
        ASSERT_OK(K(filter_assign)(&many, n, memory, COUNT(memory)));
        ASSERT_OK(K(filter_init)(&many, mean, P));
        ASSERT_OK(K(least_squares_init)(&fit, &many, 1));
        for (int i = 0; i < n; i++) {
            for (int k = 0; k < n; k++) h[k] = k == i;
            ASSERT_OK(K(least_squares_add)(&fit, h, (const num[]){N(2 * i)}, (const num[]){4}, 1));
        }
        for (int i = 0; i < n; i++) {
            ASSERT_CLOSE(i, K(mean)(&many, i), 16);
            ASSERT_CLOSE(sqrt(2), K(sigma)(&many, i), 1);
        }
        ASSERT_WITHIN(0, n, K(least_squares_weight)(&fit));
    }
}

/* ------------------------------------------------------------ what is refused */

static void init_refuses(void)
{
    ASSERT_REFUSED(KQ_ERR_NULL, K(least_squares_init)(NULL, &line, 1));
    ASSERT_REFUSED(KQ_ERR_NULL, K(least_squares_init)(&fit, NULL, 1));
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(least_squares_init)(&fit, &line, (num)NAN));
    ASSERT_REFUSED(KQ_ERR_RANGE, K(least_squares_init)(&fit, &line, 0));
    ASSERT_REFUSED(KQ_ERR_RANGE, K(least_squares_init)(&fit, &line, N(1.5)));
}

static num row[2], value, variance;

static kq_status add(void) { return K(least_squares_add)(&fit, row, &value, &variance, 1); }

static void add_refuses(void)
{
    row[0] = 1, row[1] = 2, value = 3, variance = 1;
    assert_entries_must_be_finite(row, 2, add);
    assert_entries_must_be_finite(&value, 1, add);
    assert_entries_must_be_finite(&variance, 1, add);
    ASSERT_REFUSED(KQ_ERR_NULL, K(least_squares_add)(NULL, row, unit, unit, 1));
    ASSERT_REFUSED(KQ_ERR_NULL, K(least_squares_add)(&fit, NULL, unit, unit, 1));
    ASSERT_REFUSED(KQ_ERR_NOT_SEMIDEFINITE, K(least_squares_add)(&fit, row, unit, (const num[]){N(-0.5)}, 1));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(least_squares_add)(&other, row, unit, unit, 1));
    ASSERT_OK(K(least_squares_init)(&other, &blank, 1));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(least_squares_add)(&other, row, unit, unit, 1));
    ASSERT_OK(K(least_squares_init)(&fit, &line, N(0.5)));
    ASSERT_OK(K(attach)(&line, &tape.attached));
    ASSERT_REFUSED(KQ_ERR_RECORDING, K(least_squares_add)(&fit, row, unit, unit, 1));
}

/* The last row's fault leaves them all out. */
static void a_batch_is_refused_as_a_whole(void)
{
    ASSERT_REFUSED(KQ_ERR_NULL, K(least_squares_add)(NULL, H, z, r, ROWS));
    ASSERT_REFUSED(KQ_ERR_NULL, K(least_squares_add)(&fit, NULL, z, r, ROWS));
    ASSERT_REFUSED(KQ_ERR_NULL, K(least_squares_add)(&fit, H, NULL, r, ROWS));
    ASSERT_REFUSED(KQ_ERR_NULL, K(least_squares_add)(&fit, H, z, NULL, ROWS));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(least_squares_add)(&fit, H, z, r, KQ_COUNT_MAX + 1));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(least_squares_add)(&fit, H, z, r, SIZE_MAX));
    z[ROWS - 1] = endless;
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(least_squares_add)(&fit, H, z, r, ROWS));
    z[ROWS - 1] = 1;
    r[ROWS - 1] = -1;
    ASSERT_REFUSED(KQ_ERR_NOT_SEMIDEFINITE, K(least_squares_add)(&fit, H, z, r, ROWS));
    r[ROWS - 1] = 1;
    H[2 * ROWS - 1] = (num)NAN;
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(least_squares_add)(&fit, H, z, r, ROWS));
}

static void readings_of_nothing_are_none(void)
{
    ASSERT_NAN(K(least_squares_residual)(NULL));
    ASSERT_NAN(K(least_squares_weight)(NULL));
    ASSERT_NAN(K(least_squares_residual)(&other));
    ASSERT_NAN(K(least_squares_weight)(&other));
    ASSERT_WITHIN(0, 0, K(least_squares_residual)(&fit));
}

/* Where a sum of 24 bits and another one of 24 below it are both full */
static void a_long_sum_goes_on_growing(void)
{
    const num h[] = {1, 0};
    double expected = 0;
    fit.weight.sum = N(0x1p25);
    fit.weight.low = N(0x1p24);
    fit.residual.sum = N(0x1p40);
    for (int t = 0; t < 1000; t++) {
        ASSERT_OK(K(least_squares_add)(&fit, h, (const num[]){N(t % 2)}, unit, 1));
        expected += (double)K(nis)(&line);
    }
    ASSERT_WITHIN(4, 0x1p25 + 0x1p24 + 1000, K(least_squares_weight)(&fit));
    const double high = (double)fit.residual.high - 0x1p40;
    const double grown = high + (double)fit.residual.sum + (double)fit.residual.low;
    ASSERT_WITHIN(1e-6 * expected, expected, grown);
}

/* The weight of a long memory is a product of many lambdas with a sum in between. */
static void a_long_memory_does_not_drift(void)
{
    const long rows = KQ_TEST_IS_SLOW ? 1000 : 200000;
    const num h[] = {1, 0}, lambda = N(1 - 1e-4);
    double weight = 0, residual = 0;
    ASSERT_OK(K(least_squares_init)(&fit, &line, lambda));
    for (long t = 0; t < rows; t++) {
        ASSERT_OK(K(least_squares_add)(&fit, h, (const num[]){N(t % 7 - 3)}, unit, 1));
        weight = weight * (double)lambda + 1;
        residual = residual * (double)lambda + (double)K(nis)(&line);
    }
    ASSERT_WITHIN(1e-6 * weight, weight, K(least_squares_weight)(&fit));
    ASSERT_WITHIN(1e-6 * residual, residual, K(least_squares_residual)(&fit));
}

SUITE(least_squares, set_up)
{
    RUN_TEST(fading_divides_the_covariance);
    RUN_TEST(fading_by_1_changes_nothing);
    RUN_TEST(fade_and_predict_is_a_fading_predict);
    RUN_TEST(many_small_fades_do_not_drift);
    RUN_TEST(fading_stops_before_the_numbers_end);
    RUN_TEST(fade_refuses);
    RUN_TEST(the_recursion_is_the_batch);
    RUN_TEST(forgetting_is_the_exponentially_weighted_batch);
    RUN_TEST(all_at_once_are_one_after_the_other);
    RUN_TEST(what_is_not_taken_does_not_weigh);
    RUN_TEST(without_forgetting_it_is_recorded);
    if (DBL_MANT_DIG > FLT_MANT_DIG) { /* the expectations must be finer than a float */
        RUN_TEST(a_long_sum_goes_on_growing);
        RUN_TEST(a_long_memory_does_not_drift);
    }
    RUN_TEST(there_may_be_1_to_16_unknowns);
    RUN_TEST(init_refuses);
    RUN_TEST(add_refuses);
    RUN_TEST(a_batch_is_refused_as_a_whole);
    RUN_TEST(readings_of_nothing_are_none);
}
