/* Fading memory and least squares, in all arithmetics: against the normal equations, what is refused, wind-up. */
#define MAX 16

#include "models.h"
#include "sizes.h"
#include "unchanged.h"

enum { ROWS = 60 };

static prior_model prior, unit_prior;
static process_model motion;
static S(least_squares) fit, other;
S_FILTER(line, 2);
S_FILTER(twin, 2);
S_HISTORY(tape, 2, 1, 4, 0);

static const num range[] = {1000, 1000}, A[] = {1, 0.5, 0, 1}, Q[] = {0.25, 0.125, 0.125, 0.5};
static const num x0[] = {1, -2}, P0[] = {2, 0.5, 0.5, 1}, identity[] = {1, 0, 0, 1};
static num H[2 * ROWS], z_value[ROWS], r_value[ROWS];

/* the same as calls take them, and the value that z then has */
static entry h[2 * ROWS], r[ROWS];
static word z[ROWS];

#ifdef KQ_TEST_Q31
static const double measured_range[] = {200};
static kq_format_q31 measured_format[1];

static kq_status init(kq_least_squares_q31 *q, kq_filter_q31 *f, double lambda)
{
    return kq_least_squares_init_q31(q, f, number(lambda), measured_format);
}

static void put_row(int k, const double *row, int n, double value, double variance)
{
    ASSERT_OK(kq_matrix_prepare_q31(h + n * k, row, 1, n, measured_format, fit.filter->state_format));
    ASSERT_OK(kq_noise_prepare_diagonal_q31(r + k, &variance, 1, measured_format));
    ASSERT_OK(kq_vector_prepare_q31(z + k, &value, 1, measured_format, NULL));
    z_value[k] = ldexp(z[k], -measured_format->fraction);
}

static int32_t bad_value(void) { return measured_format->range + 1; }

#define LARGE (ldexp(1, 100 - line.state_format[0].fraction)) /* where fading stops */
#define LEAST 0x1p-970                                        /* a lambda that is hardly one */
#define UNIT 0x1p-30
#define ALLOWED_OF_MEAN(b, sigma, mean) (0x1p-22 * (sigma + fabs(mean))) /* forgetting remembers some hundred steps */
#define ALLOWED_OF_P(b, size) (0x1p-22 * (size))
#define ROUNDING_OF_RESIDUAL 0x1p-22
#define ROUNDING_OF_FADING 0x1p-27
#else
static kq_status init(K(least_squares) *q, K(filter) *f, double lambda)
{
    return K(least_squares_init)(q, f, N(lambda));
}

static void put_row(int k, const num *row, int n, double value, double variance)
{
    memcpy(h + n * k, row, sizeof(num) * (size_t)n);
    r[k] = N(variance), z[k] = z_value[k] = N(value);
}

static num bad_value(void) { return (num)INFINITY; }

#define LARGE LARGE_SIGMA
#define LEAST (double)FLT_MIN
#define UNIT EPS
#define ALLOWED_OF_MEAN(b, sigma, mean) ((void)(sigma), TOLERANCE * 4 * (b)->condition)
#define ALLOWED_OF_P(b, size) ((void)(size), TOLERANCE * (b)->condition * ((b)->P[0] + (b)->P[3]))
#define ROUNDING_OF_RESIDUAL TOLERANCE
#define ROUNDING_OF_FADING (TOLERANCE / 4)
#endif

static kq_status add(int k, int count) { return S(least_squares_add)(&fit, h + 2 * k, z + k, r + k, (size_t)count); }

static void begin(double lambda)
{
    ASSERT_OK(init_filter(&line, &prior));
    ASSERT_OK(init_filter(&twin, &prior));
    ASSERT_OK(init(&fit, &line, lambda));
}

static void set_up(void)
{
    uint32_t seed = 1;
    put_prior(&prior, 2, range, x0, P0);
    put_prior(&unit_prior, 2, range, x0, identity);
    put_process(&motion, 2, 0, range, NULL, A, NULL, Q);
#ifdef KQ_TEST_Q31
    put_formats(measured_format, measured_range, 1);
#endif
    begin(1);
    for (int k = 0; k < ROWS; k++) {
        H[2 * k] = 1, H[2 * k + 1] = N(0.25 * (k % 12) - 1), r_value[k] = N(k % 3 == 0 ? 0.5 : 2);
        put_row(k, H + 2 * k, 2, 0.5 + 2 * (double)H[2 * k + 1] + (double)noise(&seed), (double)r_value[k]);
    }
    memset(&other, 0, sizeof other);
    watch_nothing();
    WATCH(fit), WATCH(other), WATCH(line), WATCH(line_memory);
}

static double weight(void) { return score_number(S(least_squares_weight)(&fit)); }
static double residual(void) { return score_number(S(least_squares_residual)(&fit)); }

/* ------------------------------------------------------------ fading */

TEST(fading_divides_the_covariance)
{
    static const double lambdas[] = {0.75, 0.5, 0.4, 0.01, 0x1p-40, 1 - 0x1p-20};
    reading before, after;
    read_now(&before, &line, 2);
    for (int l = 0; l < COUNT(lambdas); l++) {
        const double lambda = number_of(number(lambdas[l]));
        begin(1);
        ASSERT_OK(S(forget)(&line, number(lambda)));
        read_now(&after, &line, 2);
        for (int k = 0; k < 4; k++) {
            const double size = sqrt((double)before.P[3 * (k / 2)] * (double)before.P[3 * (k % 2)]) / lambda;
            ASSERT_WITHIN(ROUNDING_OF_FADING * size, (double)before.P[k] / lambda, after.P[k]);
        }
        for (int i = 0; i < 2; i++) ASSERT_WITHIN(0, whole(&before, i), whole(&after, i));
        TEST_ASSERT_EQUAL_HEX(0, after.events);
    }
}

TEST(fading_by_1_changes_nothing)
{
    ASSERT_OK_UNCHANGED(S(forget)(&line, number(1)));
    ASSERT_OK(S(attach)(&line, &tape.attached));
    ASSERT_OK_UNCHANGED(S(forget)(&line, number(1)));
    ASSERT_REFUSED(KQ_ERR_RECORDING, S(forget)(&line, number(0.5)));
    WATCH(tape), WATCH(tape_memory);
    ASSERT_OK(init(&fit, &line, 0.5));
    ASSERT_REFUSED(KQ_ERR_RECORDING, add(0, 1));
}

/* P- = A P A' / lambda + Q, here of P = I */
TEST(fade_and_predict_is_a_fading_predict)
{
    reading now;
    ASSERT_OK(init_filter(&line, &unit_prior));
    ASSERT_OK(S(forget)(&line, number(0.5)));
    ASSERT_OK(S(predict)(&line, &motion.process, NULL));
    read_now(&now, &line, 2);
    ASSERT_ALIKE(2 * 1.25 + 0.25, now.P[0], 4);
    ASSERT_ALIKE(2 * 0.5 + 0.125, now.P[1], 4);
    ASSERT_ALIKE(2 + 0.5, now.P[3], 4);
}

/* Rounded to nearest, each of 4096 times; a factor rounded once would be off by 4096 eps. */
TEST(many_small_fades_do_not_drift)
{
    const double lambda = 1 - 0x1p-10, expected = exp(-4096 * log(lambda)) * 2;
    reading now;
    for (int k = 0; k < 4096; k++) ASSERT_OK(S(forget)(&line, number(lambda)));
    read_now(&now, &line, 2);
    ASSERT_WITHIN(512 * UNIT * expected, expected, now.P[0]);
}

TEST(fading_stops_before_the_numbers_end)
{
    reading before, after;
    for (int k = 0; k < 3000; k++) ASSERT_OK(S(forget)(&line, number(0.5)));
    read_now(&before, &line, 2);
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_OVERFLOW, before.events);
    const double sigma = sqrt((double)before.P[0]);
    TEST_ASSERT_TRUE(sigma > LARGE / 2 && sigma <= LARGE * (1 + UNIT));
    ASSERT_OK(S(forget)(&line, number(LEAST)));
    read_now(&after, &line, 2);
    ASSERT_SAME_BITS(before, after);
    ASSERT_OK(add(0, 1));
    read_now(&after, &line, 2);
    TEST_ASSERT_EQUAL_INT(1, after.taken);
    TEST_ASSERT_TRUE(isfinite(after.mean[0]) && isfinite(after.nis));
}

/* ------------------------------------------------------------ the solution */

/* The normal equations in double: sum w h'h / r + w0 P0^-1, and J at the solution */
typedef struct {
    double x[2], P[4], J, weight;
    double condition; /* what the determinant loses */
} batch;

static void batch_of(batch *b, int rows, double lambda)
{
    const double det = (double)(P0[0] * P0[3] - P0[1] * P0[2]);
    const double W0[] = {(double)P0[3] / det, -(double)P0[1] / det, (double)P0[0] / det};
    const double all = exp(rows * log(lambda));
    double a = all * W0[0], c = all * W0[1], d = all * W0[2];
    double u = a * (double)x0[0] + c * (double)x0[1];
    double v = c * (double)x0[0] + d * (double)x0[1];
    b->weight = 0;
    for (int k = 0; k < rows; k++) {
        const double g = (double)H[2 * k], f = (double)H[2 * k + 1];
        const double w = exp((rows - 1 - k) * log(lambda)) / (double)r_value[k];
        a += w * g * g, c += w * g * f, d += w * f * f;
        u += w * g * (double)z_value[k], v += w * f * (double)z_value[k];
        b->weight += w * (double)r_value[k];
    }
    const double D = a * d - c * c;
    b->condition = a * d / D;
    b->P[0] = d / D, b->P[1] = b->P[2] = -c / D, b->P[3] = a / D;
    b->x[0] = b->P[0] * u + b->P[1] * v;
    b->x[1] = b->P[2] * u + b->P[3] * v;
    const double e = b->x[0] - (double)x0[0], f = b->x[1] - (double)x0[1];
    b->J = all * (W0[0] * e * e + 2 * W0[1] * e * f + W0[2] * f * f);
    for (int k = 0; k < rows; k++) {
        const double miss = (double)z_value[k] - (double)H[2 * k] * b->x[0] - (double)H[2 * k + 1] * b->x[1];
        b->J += exp((rows - 1 - k) * log(lambda)) * miss * miss / (double)r_value[k];
    }
}

TEST(the_recursion_is_the_weighted_batch)
{
    static const double lambdas[] = {1, 0.5, 0.875, 0.984375, 0.9990234375};
    batch b;
    reading now;
    for (int l = 0; l < COUNT(lambdas); l++) {
        begin(lambdas[l]);
        for (int k = 0; k < ROWS; k++) {
            ASSERT_OK(add(k, 1));
            batch_of(&b, k + 1, lambdas[l]);
            read_now(&now, &line, 2);
            const double sigma[] = {sqrt(b.P[0]), sqrt(b.P[3])};
            for (int i = 0; i < 2; i++) {
                ASSERT_WITHIN(ALLOWED_OF_MEAN(&b, sigma[i], b.x[i]), b.x[i], whole(&now, i));
                for (int j = 0; j < 2; j++) {
                    ASSERT_WITHIN(ALLOWED_OF_P(&b, sigma[i] * sigma[j]), b.P[2 * i + j], now.P[2 * i + j]);
                }
            }
            ASSERT_WITHIN(ROUNDING_OF_RESIDUAL * (b.J + 4), b.J, residual());
            ASSERT_WITHIN(ROUNDING_OF_RESIDUAL * b.weight, b.weight, weight());
        }
        TEST_ASSERT_EQUAL_HEX(0, now.events);
    }
}

TEST(without_forgetting_rows_are_counted)
{
    for (int k = 0; k < ROWS; k++) ASSERT_OK(add(k, 1));
    ASSERT_WITHIN(0, ROWS, weight());
}

TEST(all_at_once_are_one_after_the_other)
{
    ASSERT_OK(init(&fit, &line, 0.75));
    ASSERT_OK(init(&other, &twin, 0.75));
    ASSERT_OK(add(0, ROWS));
    for (int k = 0; k < ROWS; k++) {
        entry row[2] = {h[2 * k], h[2 * k + 1]};
        ASSERT_OK(S(least_squares_add)(&other, row, z + k, r + k, 1));
        row[0] = row[1] = bad_entry(0); /* it is not kept */
    }
    ASSERT_SAME(&twin, &line, 2);
    TEST_ASSERT_EQUAL_MEMORY(&fit.residual, &other.residual, sizeof fit.residual);
    ASSERT_OK_UNCHANGED(add(0, 0));
}

/* A measurement that says nothing does not count. */
TEST(what_is_not_taken_does_not_weigh)
{
    static const num nothing[] = {0, 0};
    put_row(0, nothing, 2, 1, 0);
    ASSERT_OK(add(0, 1));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_REDUNDANT, S(events)(&line));
    ASSERT_WITHIN(0, 0, weight());
    ASSERT_WITHIN(0, 0, residual());
}

TEST(without_forgetting_it_is_recorded)
{
    reading filtered, smoothed;
    ASSERT_OK(S(attach)(&line, &tape.attached));
    ASSERT_OK(add(0, 1));
    ASSERT_OK(S(smooth)(&tape));
    read_now(&filtered, &line, 2);
    read_smoothed_at(&smoothed, &tape, 0, &prior, 2);
    ASSERT_ALIKE(whole(&filtered, 0), whole(&smoothed, 0), 4);
}

/* Of 16 unknowns, measured one by one with the variance of the prior: half way */
TEST(there_may_be_1_to_16_unknowns)
{
    static word memory[S_FILTER_LEN(MAX)];
    static num zero[MAX], wide[MAX], P[MAX * MAX], row[MAX];
    prior_model some;
    S(filter) many;
    for (int n = 1; n <= MAX; n++) {
        put_identity(P, n, 4);
        for (int i = 0; i < n; i++) wide[i] = 1000;
        put_prior(&some, n, wide, zero, P);
        ASSERT_OK(S(filter_assign)(&many, n, memory, COUNT(memory)));
        ASSERT_OK(init_filter(&many, &some));
        ASSERT_OK(init(&fit, &many, 1));
        for (int i = 0; i < n; i++) {
            for (int k = 0; k < n; k++) row[k] = k == i;
            put_row(0, row, n, 2 * i, 4);
            ASSERT_OK(add(0, 1));
        }
        for (int i = 0; i < n; i++) {
            ASSERT_ALIKE(i, word_value(&some, S(mean)(&many, i), i), 16);
            ASSERT_WITHIN(ROUNDING + sigma_step(1000), sqrt(2), word_value(&some, S(sigma)(&many, i), i));
        }
        ASSERT_WITHIN(0, n, weight());
    }
}

/* ------------------------------------------------------------ what is refused (others: test_refusals.c) */

/* The last row's fault leaves them all out. */
TEST(a_batch_is_refused_as_a_whole)
{
    static const num half[] = {1, 2};
    z[ROWS - 1] = bad_value();
    ASSERT_REFUSED(NOT_A_NUMBER, add(0, ROWS));
    put_row(ROWS - 1, half, 2, 1, 1);
    r[ROWS - 1] = number(-1);
    ASSERT_REFUSED(NO_VARIANCE, add(0, ROWS));
    put_row(ROWS - 1, half, 2, 1, 1);
    h[2 * ROWS - 1] = bad_entry(0);
    ASSERT_REFUSED(NOT_AN_ENTRY, add(0, ROWS));
}

TEST(what_has_not_begun_takes_no_row)
{
    ASSERT_REFUSED(KQ_ERR_NOT_READY, S(least_squares_add)(&other, h, z, r, 1));
    ASSERT_NO_SCORE(S(least_squares_residual)(NULL));
    ASSERT_NO_SCORE(S(least_squares_weight)(NULL));
    ASSERT_NO_SCORE(S(least_squares_residual)(&other));
    ASSERT_NO_SCORE(S(least_squares_weight)(&other));
    ASSERT_WITHIN(0, 0, residual());
}

/* ------------------------------------------------------------ long sums */

/* Where a sum of 24 bits and another one of 24 below it are both full */
TEST(a_long_sum_goes_on_growing)
{
#ifndef KQ_TEST_Q31
    if (DBL_MANT_DIG <= FLT_MANT_DIG) return; /* the expectation must be finer than a float */
    static const num row[] = {1, 0};
    double expected = 0;
    fit.weight.sum = N(0x1p25);
    fit.weight.low = N(0x1p24);
    fit.residual.sum = N(0x1p40);
    for (int t = 0; t < 1000; t++) {
        put_row(0, row, 2, t % 2, 1);
        ASSERT_OK(add(0, 1));
        expected += (double)S(nis)(&line);
    }
    ASSERT_WITHIN(4, 0x1p25 + 0x1p24 + 1000, weight());
    const double high = (double)fit.residual.high - 0x1p40;
    const double grown = high + (double)fit.residual.sum + (double)fit.residual.low;
    ASSERT_WITHIN(1e-6 * expected, expected, grown);
#endif
}

/* The weight of a long memory is a product of many lambdas with a sum in between. */
TEST(a_long_memory_does_not_drift)
{
    if (DBL_MANT_DIG <= FLT_MANT_DIG) return; /* the expectation must be finer than a float */
    static const num row[] = {1, 0};
    const long rows = KQ_TEST_IS_SLOW ? 1000 : 200000;
    const double lambda = number_of(number(1 - 1e-4));
    double weights = 0, residuals = 0;
    ASSERT_OK(init(&fit, &line, lambda));
    for (int k = 0; k < 7; k++) put_row(k, row, 2, k - 3, 1);
    for (long t = 0; t < rows; t++) {
        ASSERT_OK(add((int)(t % 7), 1));
        weights = weights * lambda + 1;
        residuals = residuals * lambda + score_number(S(nis)(&line));
    }
    ASSERT_WITHIN(1e-6 * weights, weights, weight());
    ASSERT_WITHIN(1e-6 * residuals, residuals, residual());
}

/* Outliers as large as a word: q31's sum is held, and fades. */
TEST(the_residual_is_held)
{
#ifdef KQ_TEST_Q31
    static const double row[] = {1, 0};
    begin(0.5);
    for (int k = 0; k < 2; k++) put_row(k, row, 2, k ? 200 : -200, 0x1p-40);
    for (int k = 0; k < 40; k++) ASSERT_OK(add(k % 2, 1));
    const int64_t held = kq_least_squares_residual_q31(&fit);
    TEST_ASSERT_TRUE(held > 0 && held <= INT64_C(1) << 61);
    fit.residual.sum = INT64_C(1) << 61; /* at its end it is no sum any more: it stays */
    put_row(0, row, 2, 0, 1e4);
    ASSERT_OK(add(0, 1));
    TEST_ASSERT_TRUE(kq_least_squares_residual_q31(&fit) == INT64_C(1) << 61);
#endif
}

SUITE(least_squares, set_up)
#include "least_squares.tests"
