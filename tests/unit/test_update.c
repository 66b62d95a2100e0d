/* Measurements at their limits: low noise and none, redundant ones, likelihoods of any size, events (test_steps.c: all
   others). */
#include "reading.h"
#include "sizes.h"
#include "textbook.h"
#include "unchanged.h"

PROCESS(motion, 2, 1);
SENSOR(radar, 2, 2);
FILTER(track, 2);
FILTER(twin, 2);

static const num A[] = {1, 0.5, 0, 1}, B[] = {0.125, 0.5}, Q[] = {0.25, 0.125, 0.125, 0.5};
static const num H[] = {1, 0, 0.5, 1}, R[] = {0.5, 0.25, 0.25, 1};
static const num x0[] = {1, -2}, P0[] = {2, 0.5, 0.5, 1};
static const num independent3[] = {0.5, 0, 0, 0, 1, 0, 0, 0, 2};

static num z[3], u[1];

static void set_up(void)
{
    static const num measured[] = {3, 1, -1};
    memcpy(z, measured, sizeof z);
    u[0] = 4;
    ASSERT_OK(K(process_init)(&motion, A, B, Q));
    ASSERT_OK(K(sensor_init)(&radar, H, R));
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    ASSERT_OK(K(filter_init)(&twin, x0, P0));
    watch_nothing();
    WATCH(motion), WATCH(motion_memory), WATCH(radar), WATCH(radar_memory);
    WATCH(track), WATCH(track_memory);
    WATCH(u), WATCH(z);
}

/* A sensor of m components for the two states, in memory that is used again each time. */
static const K(sensor) * sensor_of(const num *h, const num *C, int m)
{
    static num memory[KQ_SENSOR_LEN(3)];
    static K(sensor) s;
    ASSERT_OK(K(sensor_assign)(&s, 2, m, memory, COUNT(memory)));
    ASSERT_OK(K(sensor_init)(&s, h, C));
    return &s;
}

/* ------------------------------------------------------------------------------ update */

TEST(a_noise_free_measurement_is_believed)
{
    static const num h[] = {1, 0.5}, none[] = {0};
    textbook t;
    textbook_init(&t, 2, x0, P0);
    textbook_update(&t, h, none, z, 1);
    ASSERT_OK(K(update)(&track, sensor_of(h, none, 1), z));
    ASSERT_TEXTBOOK(&t, &track);
    ASSERT_CLOSE(3, whole_mean(&track, 0) + 0.5 * whole_mean(&track, 1), 3);
    TEST_ASSERT_EQUAL_INT(1, K(taken)(&track));
}

/* However sharp: the covariance of what was not measured is as accurate as ever. */
TEST(a_measurement_of_any_sharpness_leaves_the_rest_accurate)
{
    static const double sharpness[] = {0, 1e-30, 1e-20, 1e-12, 1e-8, 1e-4};
    SENSOR(narrow, 3, 1);
    FILTER(three, 3);
    uint32_t seed = 3;
    for (int k = 0; k < 120; k++) {
        const num r[] = {N(sharpness[k % COUNT(sharpness)])}, x[] = {0, 0, 0};
        num L[9], P[9], h[3];
        textbook t;
        for (int c = 0; c < 9; c++) L[c] = noise(&seed);
        for (int c = 0; c < 9; c++) {
            const num *a = L + 3 * (c / 3), *b = L + 3 * (c % 3);
            P[c] = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + (c % 4 == 0 ? N(0.25) : 0);
        }
        for (int i = 0; i < 3; i++) h[i] = noise(&seed);
        ASSERT_OK(K(sensor_init)(&narrow, h, r));
        ASSERT_OK(K(filter_init)(&three, x, P));
        ASSERT_OK(K(update)(&three, &narrow, z));
        textbook_init(&t, 3, x, P);
        textbook_update(&t, h, r, z, 1);
        ASSERT_TEXTBOOK(&t, &three);
    }
}

/* State 0 is seen next to not at all, but goes with state 2: what rounding lacks of state 1 is none of its. */
TEST(a_sharp_measurement_makes_no_state_less_certain)
{
    SENSOR(sum, 3, 1);
    FILTER(three, 3);
    static const num h[] = {N(1e-30), 0.125, 0.125}, r[] = {3}, none[] = {0, 0, 0};
    static const num S[] = {N(1e11), N(-0.0043), N(0.0072), N(1e18), 0, N(1e18)}; /* columns of the triangle */
    ASSERT_OK(K(sensor_init)(&sum, h, r));
    ASSERT_OK(K(filter_init_root)(&three, none, S));
    ASSERT_OK(K(update)(&three, &sum, z));
    TEST_ASSERT_TRUE(K(sigma)(&three, 0) <= N(1.01e11));
    TEST_ASSERT_TRUE(K(sigma)(&three, 1) <= N(0.00721));
    TEST_ASSERT_TRUE(K(sigma)(&three, 2) <= N(14));
}

/* To a part of its own sigma of 1e-5, though that is far below the last bit of the mean. */
TEST(a_sharp_measurement_is_believed)
{
    SENSOR(gauge, 1, 1);
    FILTER(level, 1);
    static const num one[] = {1}, sharp[] = {N(1e-10)};
    for (int k = 0; k < 20; k++) {
        const num value[] = {N(1234.567 + 0.789 * k)}, x[] = {N(-0.1 * k)}, P[] = {N(1e6 + 7 * k)};
        ASSERT_OK(K(sensor_init)(&gauge, one, sharp));
        ASSERT_OK(K(filter_init)(&level, x, P));
        ASSERT_OK(K(update)(&level, &gauge, value));
        ASSERT_WITHIN(1e-6, value[0], whole_mean(&level, 0));
        ASSERT_WITHIN(1e-8, 1e-5, K(sigma)(&level, 0));
        ASSERT_OK(K(update)(&level, &gauge, value));
        ASSERT_WITHIN(1e-6, value[0], whole_mean(&level, 0));
        ASSERT_WITHIN(1e-8, 1e-5 / sqrt(2), K(sigma)(&level, 0));
    }
}

/* Each moves the mean by less than 1e-7, far below the last bit of a float near 64. */
TEST(increments_below_the_last_bit_of_the_mean_add_up)
{
    if (DBL_MANT_DIG <= FLT_MANT_DIG) return; /* the expectation must be finer than a float */
    SENSOR(gauge, 1, 1);
    FILTER(level, 1);
    static const num one[] = {1}, far[] = {0}, wide[] = {4096}, weak[] = {0x1p20};
    static const num value[] = {64, 64.0625};
    double x = 64 * (4096 / 4097.0), P = 4096 / 4097.0;
    ASSERT_OK(K(sensor_init)(&gauge, one, one));
    ASSERT_OK(K(filter_init)(&level, far, wide));
    ASSERT_OK(K(update)(&level, &gauge, &value[0]));
    ASSERT_OK(K(sensor_init)(&gauge, one, weak));
    const double before = whole_mean(&level, 0), expected_before = x;
    for (int k = 0; k < 2000; k++) {
        ASSERT_OK(K(update)(&level, &gauge, &value[1]));
        const double gain = P / (P + 0x1p20);
        x += gain * (64.0625 - x);
        P *= 1 - gain;
    }
    ASSERT_WITHIN(1e-6, x - expected_before, whole_mean(&level, 0) - before);
}

/* ---------------------------------------------------------------------- log-likelihood */

/* 16 components of variance 2^e each: det S = 2^(16 e) is far outside of the number range. */
static void assert_determinant(int e)
{
    FILTER(many, 16);
    SENSOR_DIAGONAL(wide, 16, 16);
    static num h[256], values[16], variances[16], zero[256];
    put_identity(h, 16, 1);
    for (int c = 0; c < 16; c++) {
        variances[c] = N(ldexp(1, e));
        values[c] = N(ldexp(c % 2 ? 1 : -1, e / 2));
    }
    ASSERT_OK(K(sensor_init_diagonal)(&wide, h, variances));
    ASSERT_OK(K(filter_init)(&many, zero, zero));
    ASSERT_OK(K(update)(&many, &wide, values));
    const double expected = -0.5 * 16 * (1.8378770664093454836 + e * log(2) + 1);
    TEST_ASSERT_EQUAL_INT(16, K(taken)(&many));
    ASSERT_CLOSE(16, K(nis)(&many), 16);
    ASSERT_CLOSE(expected, K(log_likelihood_last)(&many), 16 + fabs(expected));
    for (int k = 0; k < 9; k++) ASSERT_OK(K(update)(&many, &wide, values));
    ASSERT_CLOSE(10 * expected, K(log_likelihood)(&many), 10 * (16 + fabs(expected)));
}

TEST(the_determinant_may_be_of_any_size)
{
    const int wide = sizeof(num) == sizeof(float) ? 90 : 300;
    assert_determinant(wide);
    assert_determinant(-wide);
    assert_determinant(0);
}

/* One term of 500000, then 4000 of 1/200: added one by one to a float, these would be lost. */
TEST(small_terms_of_the_likelihood_are_not_lost)
{
    SENSOR(gauge, 1, 1);
    FILTER(level, 1);
    static const num one[] = {1}, zero[] = {0}, large[] = {1000}, small[] = {N(0.1)};
    ASSERT_OK(K(sensor_init)(&gauge, one, one));
    ASSERT_OK(K(filter_init)(&level, zero, zero));
    ASSERT_OK(K(update)(&level, &gauge, large));
    for (int k = 0; k < 4000; k++) ASSERT_OK(K(update)(&level, &gauge, small));
    const double nis = 1e6 + 4000 * (double)small[0] * (double)small[0];
    const double expected = -0.5 * (4001 * 1.8378770664093454836 + nis);
    ASSERT_WITHIN(4 * EPS * fabs(expected), expected, K(log_likelihood)(&level));
}

/* Long runs: a state that is known, so that s = r and e = z. */
SENSOR(gauge, 1, 1);
FILTER(level, 1);

static void begin_long_run(num r)
{
    static const num one[] = {1}, zero[] = {0};
    ASSERT_OK(K(sensor_init)(&gauge, one, &r));
    ASSERT_OK(K(filter_init)(&level, zero, zero));
}

/* log 2 pi + log s + NIS */
static double expected_term(double r, double nis)
{
    return 1.8378770664093454836 + log(r) + nis;
}

TEST(a_long_run_is_the_sum_of_its_updates)
{
    if (DBL_MANT_DIG <= FLT_MANT_DIG) return; /* the expectation must be finer than a float */
    const long updates = KQ_TEST_IS_SLOW ? 1000 : 6000000;
    const num values[] = {N(1.2), N(-0.3), N(0.9)};
    begin_long_run(N(0.75));
    double expected = 0;
    for (long t = 0; t < updates; t++) {
        const double value = (double)values[t % 3];
        ASSERT_OK(K(update)(&level, &gauge, &values[t % 3]));
        expected -= expected_term(0.75, value * value / 0.75) / 2;
    }
    ASSERT_WITHIN(1e-6 * fabs(expected), expected, K(log_likelihood)(&level));
}

/* The exponent of det S, as far as an int32_t reaches, and on */
TEST(the_exponent_of_a_run_does_not_wrap)
{
    if (DBL_MANT_DIG <= FLT_MANT_DIG) return; /* the expectation must be finer than a float */
    const int updates = 200;
    const num value = 0;
    for (int e = -80; e <= 80; e += 160) {
        begin_long_run(N(ldexp(1, e)));
        level.run.count = 32767;
        level.run.exponent = e < 0 ? INT32_MIN + 1000 : INT32_MAX - 1000;
        const double before = 32767 * 1.8378770664093454836 + (double)level.run.exponent * log(2);
        const double expected = -(before + updates * expected_term(ldexp(1, e), 0)) / 2;
        for (int t = 0; t < updates; t++) ASSERT_OK(K(update)(&level, &gauge, &value));
        ASSERT_WITHIN(2e-7 * fabs(expected), expected, K(log_likelihood)(&level));
    }
}

static double run_sum(void)
{
    return (double)level.run.sum.sum + (double)level.run.sum.low +
           (double)level.run.count * 1.8378770664093454836 + (double)level.run.exponent * log(2) +
           log((double)level.run.determinant);
}

/* A NIS of 0.3 after 100 years of 16 measurements at 10 kHz, and before and after the count begins
   anew: added to a sum of 2^49, it is not rounded to a multiple of anything that shows. */
TEST(small_terms_are_not_lost_after_a_hundred_years)
{
    if (DBL_MANT_DIG <= FLT_MANT_DIG) return; /* the expectation must be finer than a float */
    const double years = ldexp(1, 49);
    const num value = N(0.5477);
    const double nis = (double)value * (double)value;
    begin_long_run(1);
    level.run.sum.high = N(years);
    for (int part = 0; part < 3; part++) {
        level.run.count = 32768 - 500;
        const double before = run_sum() + ((double)level.run.sum.high - years);
        for (int t = 0; t < 1000; t++) ASSERT_OK(K(update)(&level, &gauge, &value));
        const double grown = run_sum() + ((double)level.run.sum.high - years) - before;
        const double expected = 1000 * expected_term(1, nis);
        ASSERT_WITHIN(1e-6 * expected, expected, grown);
    }
    const double whole = (double)level.run.sum.high + run_sum();
    ASSERT_WITHIN(2 * EPS * whole, -whole / 2, K(log_likelihood)(&level));
}

/* ------------------------------------------------------------------------------ events */

static const num twice[] = {1, 0.5, 1, 0.5}, free_of_noise[] = {0, 0, 0, 0};

/* Three numbers of a few bits, whose sums are exact */
static void put_direction(num *h, uint32_t *seed)
{
    for (int i = 0; i < 3; i++) h[i] = N(floor(256 * (double)noise(seed)) / 256);
}

/* Whatever the numbers: after two rows without noise, or with a noise far below rounding, each
   of them again and their sum say nothing new, though rounding leaves them a variance. */
static void assert_redundancy(double r)
{
    SENSOR_DIAGONAL(five, 3, 5);
    SENSOR_DIAGONAL(plain, 3, 2);
    FILTER(three, 3);
    FILTER(other, 3);
    static const num x[3] = {0};
    const num sharp[] = {N(r), N(r), N(r), N(r), N(r)};
    const unsigned rounded = r > 0 ? KQ_EVENT_PRECISION : 0; /* in f32 and f64: H x has fewer digits than R asks for */
    uint32_t seed = 11;
    for (int k = 0; k < 50; k++) {
        num h[15], P[9], values[5];
        for (int row = 0; row < 2; row++) put_direction(h + 3 * row, &seed);
        for (int i = 0; i < 3; i++) {
            h[6 + i] = h[i], h[9 + i] = h[3 + i], h[12 + i] = h[i] + h[3 + i];
            values[i] = noise(&seed);
        }
        values[2] = values[0], values[3] = values[1], values[4] = values[0] + values[1];
        for (int c = 0; c < 9; c++) P[c] = c % 4 == 0 ? N(1 + 0.1 * k) : N(0.3);
        ASSERT_OK(K(sensor_init_diagonal)(&five, h, sharp));
        ASSERT_OK(K(sensor_init_diagonal)(&plain, h, sharp));
        ASSERT_OK(K(filter_init)(&three, x, P));
        ASSERT_OK(K(filter_init)(&other, x, P));
        ASSERT_OK(K(update)(&three, &five, values));
        ASSERT_OK(K(update)(&other, &plain, values));
        TEST_ASSERT_EQUAL_INT(2, K(taken)(&three));
        TEST_ASSERT_EQUAL_HEX(KQ_EVENT_REDUNDANT, K(events)(&three) & ~rounded);
        TEST_ASSERT_EQUAL_HEX(0, K(events)(&other) & ~rounded);
        ASSERT_SAME_STATE(&other, &three, 3);
    }
}

TEST(redundancy_is_seen_through_the_rounding)
{
    assert_redundancy(0);
    assert_redundancy(EPS * EPS * EPS);
}

/* Components that see multiples of one thing, their noises being the same multiples of one noise: the
   last of them says it all, and decorrelated the others are sums whose terms cancel to rounding. */
TEST(multiples_of_one_noisy_component_are_left_out)
{
    SENSOR(three, 2, 3);
    uint32_t seed = 5;
    for (int k = 0; k < 200; k++) {
        num rows[6], covariance[9], values[3], variance;
        const double h[] = {1.25, -0.5}, y = floor(64 * (double)noise(&seed)) / 64;
        double factor[3];
        for (int c = 0; c < 3; c++) factor[c] = 3 + floor(30 * fabs((double)noise(&seed)));
        for (int c = 0; c < 3; c++) {
            for (int i = 0; i < 2; i++) rows[2 * c + i] = N(factor[c] * h[i]);
            for (int j = 0; j < 3; j++) covariance[3 * c + j] = N(factor[c] * factor[j]);
            values[c] = N(factor[c] * y);
        }
        variance = covariance[8];
        ASSERT_OK(K(sensor_init)(&three, rows, covariance));
        ASSERT_OK(K(filter_init)(&track, x0, P0));
        ASSERT_OK(K(filter_init)(&twin, x0, P0));
        ASSERT_OK(K(update)(&track, &three, values));
        ASSERT_OK(K(update)(&twin, sensor_of(rows + 4, &variance, 1), values + 2));
        TEST_ASSERT_EQUAL_INT(1, K(taken)(&track));
        TEST_ASSERT_EQUAL_HEX(KQ_EVENT_REDUNDANT, K(events)(&track));
        ASSERT_SAME_STATE(&twin, &track, 2);
        ASSERT_CLOSE(K(log_likelihood)(&twin), K(log_likelihood)(&track), 1);
    }
}

/* -most .. most */
static num whole_number(uint32_t *seed, int most)
{
    *seed = *seed * 1664525u + 1013904223u;
    return (num)((int)((*seed >> 16) % (uint32_t)(2 * most + 1)) - most);
}

/* Two exact rows and a vague one, then a sum of the exact ones in another call: what it leaves of a sigma */
static int is_taken_for_knowledge(uint32_t *seed)
{
    SENSOR_DIAGONAL(rows, 4, 3);
    SENSOR_DIAGONAL(again, 4, 1);
    FILTER(four, 4);
    static const num noises[] = {0, 0, 1. / 1024}, none[] = {0};
    num h[12], root[16], P[16] = {0}, x[4], sum[4], values[3] = {0}, value = 0, sigma[4];
    for (int i = 0; i < 12; i++) h[i] = whole_number(seed, 2);
    for (int i = 0; i < 16; i++) root[i] = whole_number(seed, 3);
    for (int i = 0; i < 4; i++) x[i] = whole_number(seed, 5);
    for (int c = 0; c < 16; c++) {
        for (int k = 0; k < 4; k++) P[c] += root[4 * (c / 4) + k] * root[4 * (c % 4) + k];
    }
    const num a = whole_number(seed, 2), b = whole_number(seed, 2);
    for (int i = 0; i < 4; i++) {
        num truth = x[i];
        for (int k = 0; k < 4; k++) truth += root[4 * i + k] * (num)(k - 1);
        sum[i] = a * h[i] + b * h[4 + i];
        for (int c = 0; c < 3; c++) values[c] += h[4 * c + i] * truth;
        value += sum[i] * truth;
    }
    ASSERT_OK(K(sensor_init_diagonal)(&rows, h, noises));
    ASSERT_OK(K(sensor_init_diagonal)(&again, sum, none));
    ASSERT_OK(K(filter_init)(&four, x, P));
    ASSERT_OK(K(update)(&four, &rows, values));
    for (int i = 0; i < 4; i++) sigma[i] = K(sigma)(&four, i);
    ASSERT_OK(K(update)(&four, &again, &value));
    int is_worse = 0;
    for (int i = 0; i < 4; i++) is_worse |= sigma[i] > N(1e-3) && K(sigma)(&four, i) < sigma[i] / 2;
    return is_worse;
}

/* filter.h: 1 of 300.  Before rounding was dropped it was 1 of 90. */
TEST(rounding_is_seldom_taken_for_knowledge)
{
    enum { MODELS = sizeof(void *) > 4 ? 5000 : 30 };
    uint32_t seed = 1;
    int wrong = 0;
    for (int k = 0; k < MODELS; k++) wrong += is_taken_for_knowledge(&seed);
    TEST_ASSERT_LESS_OR_EQUAL_INT(MODELS / 180 + 2, wrong);
}

/* x0 follows from two components of one sensor; another sensor has it again. */
TEST(a_noise_free_state_may_come_again)
{
    SENSOR_DIAGONAL(both, 3, 3);
    SENSOR_DIAGONAL(first, 3, 1);
    FILTER(three, 3);
    FILTER(copy, 3);
    static const num rows[] = {-2, -1, 2, 0, -1, 2, 2, -1, -1}, noises[] = {0, 0, 1. / 1024};
    static const num row[] = {1, 0, 0}, none[] = {0}, values[] = {-12, -8, 23}, again[] = {2};
    static const num x[] = {3, -5, -4}, P[] = {9, 5, 0, 5, 17, -8, 0, -8, 17};
    ASSERT_OK(K(sensor_init_diagonal)(&both, rows, noises));
    ASSERT_OK(K(sensor_init_diagonal)(&first, row, none));
    ASSERT_OK(K(filter_init)(&three, x, P));
    ASSERT_OK(K(update)(&three, &both, values));
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&three));
    ASSERT_OK(K(filter_copy)(&copy, &three));
    ASSERT_OK(K(update)(&three, &first, again));
    TEST_ASSERT_EQUAL_INT(0, K(taken)(&three));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_REDUNDANT, K(events)(&three));
    ASSERT_SAME_STATE(&copy, &three, 3);
}

/* Two rows that differ by sqrt(eps): what the second adds is small, but not rounding. */
TEST(nearly_parallel_rows_are_both_taken)
{
    const num small = N(sqrt(EPS)), h[] = {1, 0.5, 1, N(0.5) + small};
    const num values[] = {0.5, N(0.5) + 2 * small};
    ASSERT_OK(K(update)(&track, sensor_of(h, free_of_noise, 2), values));
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&track));
    TEST_ASSERT_EQUAL_INT(2, K(taken)(&track));
    ASSERT_WITHIN(0.01, -0.5, whole_mean(&track, 0));
    ASSERT_WITHIN(0.01, 2, whole_mean(&track, 1));
}

TEST(a_noise_free_measurement_of_a_known_state_is_not_taken)
{
    static const num exact[4] = {0};
    ASSERT_OK(K(filter_init)(&track, x0, exact));
    ASSERT_OK(K(filter_init)(&twin, x0, exact));
    ASSERT_OK(K(update)(&track, sensor_of(H, free_of_noise, 2), z));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_REDUNDANT, K(events)(&track));
    TEST_ASSERT_EQUAL_INT(0, K(taken)(&track));
    ASSERT_SAME_STATE(&twin, &track, 2);
    ASSERT_CLOSE(0, K(log_likelihood)(&track), 0);
}

static unsigned events_at(double P0, const num *measured)
{
    static const num one[] = {1}, zero[] = {0};
    const num P[] = {N(P0)};
    ASSERT_OK(K(sensor_init)(&gauge, one, zero));
    ASSERT_OK(K(filter_init)(&level, zero, P));
    ASSERT_OK(K(update)(&level, &gauge, measured));
    ASSERT_CLOSE(*measured, whole_mean(&level, 0), 1);
    return K(events)(&level);
}

/* What earlier noise-free measurements have left of a variance may be rounding. */
TEST(a_noise_free_measurement_that_contradicts_is_an_event)
{
    static const num one[] = {1};
    TEST_ASSERT_EQUAL_HEX(0, events_at(1, one));
    TEST_ASSERT_EQUAL_HEX(0, events_at(4 * EPS, one));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_CONTRADICTION, events_at(EPS / 16, one));
    /* a double has no more digits than this sigma, two floats have */
    const unsigned rounded = EPS > 1e-10 ? 0 : KQ_EVENT_PRECISION;
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_CONTRADICTION | rounded, events_at(EPS * EPS, one));
}

TEST(events_stay_until_they_are_cleared)
{
    ASSERT_OK(K(update)(&track, sensor_of(twice, free_of_noise, 2), z));
    ASSERT_OK(K(predict)(&track, &motion, u));
    ASSERT_OK(K(update)(&track, &radar, z));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_REDUNDANT, K(events)(&track));
    reading before, after;
    read_filter(&before, &track, 2);
    K(events_clear)(&track);
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&track));
    read_filter(&after, &track, 2);
    before.events = 0;
    ASSERT_SAME_BITS(before, after);
    ASSERT_OK(K(predict)(&track, &motion, u));
    ASSERT_OK(K(update)(&track, &radar, z));
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&track));
}

FILTER(two, 2);
PROCESS(still, 2, 0);
SENSOR(fine, 2, 1);

/* A low-noise measurement, and a predict that mixes what it told with what it did not */
static unsigned events_of_sharpness(double share)
{
    static const num zero[] = {0, 0}, P[] = {1, 0, 0, 1}, A[] = {1, 1, 0, 1}, none[] = {0, 0, 0, 0};
    static const num row[] = {1, N(0.5)};
    const num noise[] = {N(share)};
    ASSERT_OK(K(process_init)(&still, A, NULL, none));
    ASSERT_OK(K(sensor_init)(&fine, row, noise));
    ASSERT_OK(K(filter_init)(&two, zero, P));
    ASSERT_OK(K(update)(&two, &fine, zero));
    ASSERT_OK(K(predict)(&two, &still, NULL));
    return K(events)(&two);
}

TEST(what_a_sharp_measurement_told_and_a_predict_lost_is_an_event)
{
    TEST_ASSERT_EQUAL_HEX(0, events_of_sharpness(1));
    TEST_ASSERT_EQUAL_HEX(0, events_of_sharpness(1e3 * EPS * EPS));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_PRECISION, events_of_sharpness(EPS * EPS / 4));
}

/* Of a constant, after 2^13 measurements that each say `share` of R: are sigma and mean right, and no event? */
static void assert_taken(const K(sensor) *s, double share)
{
    static const num zero[] = {0}, one[] = {1}, P[] = {1};
    const int many = 1 << 13;
    ASSERT_OK(K(filter_init)(&level, zero, P));
    for (int k = 0; k < many; k++) ASSERT_OK(K(update)(&level, s, one));
    const double P_left = 1 / (1 + many * share);
    ASSERT_WITHIN(fmin(1e-3 * P_left, 0.05 * (1 - P_left) + 8 * EPS), P_left, K(sigma)(&level, 0) * K(sigma)(&level, 0));
    ASSERT_WITHIN(1e-3 * (1 - P_left), 1 - P_left, K(mean)(&level, 0));
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&level));
}

/* Each takes less than the root has bits for, the last two less than its last bit. */
TEST(measurements_that_say_little_are_taken)
{
    static const double shares[] = {0x1p-12, 0x1p-13, 0x1p-14, 0x1p-17, 0x1p-20, 0x1p-25, 0x1p-30};
    static const num one[] = {1};
    for (int k = 0; k < COUNT(shares); k++) {
        const num r[] = {N(1 / shares[k])};
        ASSERT_OK(K(sensor_init)(&gauge, one, r));
        assert_taken(&gauge, shares[k]);
        ASSERT_OK(K(sensor_init_lean)(&gauge, one, r));
        assert_taken(&gauge, shares[k]);
    }
}

/* Two sensors that leave a direction of three constants unseen, 2000 times.  With P0 / R = 1e8 in f32 rounding has become
   information by then; with P0 / R = 1e2 it has not.  In f64, as far beyond, sigmas of this model are off by 0.1 %. */
TEST(the_rounding_of_many_updates_is_an_event)
{
    static const num rows[] = {N(0.7), N(-0.4), N(0.9), N(0.3), N(0.8), N(-0.5)}, none[] = {0, 0, 0};
    const double most = EPS > 1e-10 ? 1e8 : 0x1p58 * 1e8, r = 1e-6;
    const num variances[] = {N(r), N(r)};
    SENSOR(pair, 3, 2);
    FILTER(constants, 3);
    for (int k = 0; k < 2; k++) {
        num P[9] = {0};
        for (int i = 0; i < 3; i++) P[4 * i] = N((k ? most : 100) * r);
        ASSERT_OK(K(sensor_init_diagonal)(&pair, rows, variances));
        ASSERT_OK(K(filter_init)(&constants, none, P));
        for (int t = 0; t < 2000; t++) ASSERT_OK(K(update)(&constants, &pair, none));
        TEST_ASSERT_EQUAL_HEX(k && EPS > 1e-10 ? KQ_EVENT_PRECISION : 0, K(events)(&constants));
    }
}

/* A state that turns and drifts, one combination of it without noise: the sigma of what is past falls by 3 at each step
   back, below the rounding of the mean.  A lag tells, too. */
enum { LONG = 64 };
static unsigned events_of_the_turn(int is_exact, struct K(attached) *a)
{
    static const num x[] = {-2, 0}, P[] = {0, 0, 0, 1024}, h[] = {-2, 1}, q[] = {0, 0, 0, N(0.000244140625)};
    static const num turns[] = {-1, -1, 0, -1}, none[] = {0}, r[] = {1};
    PROCESS(turn, 2, 0);
    SENSOR(gauge_of_both, 2, 1);
    num truth[] = {N(-2.3), N(31.7)};
    ASSERT_OK(K(process_init)(&turn, turns, NULL, q));
    ASSERT_OK(K(sensor_init)(&gauge_of_both, h, is_exact ? none : r));
    ASSERT_OK(K(filter_init)(&two, x, P));
    ASSERT_OK(K(attach)(&two, a));
    for (int t = 1; t < LONG; t++) {
        truth[0] = -truth[0] - truth[1];
        truth[1] = N(0.015625) * (num)(t % 5 - 2) - truth[1];
        const num z = truth[1] - 2 * truth[0];
        ASSERT_OK(K(predict)(&two, &turn, NULL));
        ASSERT_OK(K(update)(&two, &gauge_of_both, &z));
    }
    return K(events)(&two) & (is_exact ? ~(unsigned)KQ_EVENT_PRECISION : ~0u); /* the mean may be as large */
}

TEST(sigmas_below_rounding_are_an_event)
{
    HISTORY(past, 2, 1, LONG, 0);
    LAG(lag, 2, 1, LONG);
    K(filter) view;
    for (int is_exact = 0; is_exact < 2; is_exact++) {
        const unsigned told = is_exact ? KQ_EVENT_PRECISION : 0;
        TEST_ASSERT_EQUAL_HEX(0, events_of_the_turn(is_exact, &past.attached));
        ASSERT_OK(K(smooth)(&past));
        TEST_ASSERT_EQUAL_HEX(told, K(events)(SMOOTHED(&past, 0)));
        TEST_ASSERT_EQUAL_HEX(0, events_of_the_turn(is_exact, &lag.attached));
        unsigned events = 0;
        for (size_t k = 0; k < LONG; k++) {
            ASSERT_OK(K(lagged)(&lag, k, &view));
            events |= K(events)(&view);
        }
        TEST_ASSERT_EQUAL_HEX(told, events);
    }
}

/* A state that fades; each predict rounds it by about `share` of its sigma.  In f64 it is one number, and all of A x counts. */
static unsigned events_of_fading(double share)
{
    HISTORY(past, 1, 1, LONG, 0);
    static const num fades[] = {N(0.9)}, none[] = {0}, P[] = {1}, h[] = {1}, x[] = {1000};
    const double sigma = EPS * (EPS > 1e-10 ? 100 : 900) / share;
    const num R[] = {N(sigma * sigma / 0.19)};
    num truth = x[0];
    unsigned events = 0;
    PROCESS(fading, 1, 0);
    ASSERT_OK(K(process_init)(&fading, fades, NULL, none));
    ASSERT_OK(K(sensor_init)(&gauge, h, R));
    ASSERT_OK(K(filter_init)(&level, x, P));
    ASSERT_OK(K(attach)(&level, &past.attached));
    for (int t = 1; t < LONG; t++) {
        ASSERT_OK(K(update)(&level, &gauge, &truth));
        ASSERT_OK(K(predict)(&level, &fading, NULL));
        truth *= fades[0];
    }
    ASSERT_OK(K(smooth)(&past));
    for (size_t k = 0; k < LONG; k++) events |= K(events)(SMOOTHED(&past, k));
    return events;
}

TEST(a_smoothed_sigma_of_a_few_roundings_is_an_event)
{
    TEST_ASSERT_EQUAL_HEX(0, events_of_fading(0x1p-10) & KQ_EVENT_PRECISION);
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_PRECISION, events_of_fading(0.5) & KQ_EVENT_PRECISION);
}

TEST(a_smoothed_mean_is_rounded_once)
{
    HISTORY(tape, 2, 2, 6, 0);
    ASSERT_OK(K(attach)(&track, &tape.attached));
    for (int t = 0; t < 5; t++) ASSERT_OK(K(step)(&track, &motion, u, &radar, z));
    ASSERT_OK(K(smooth)(&tape));
    for (size_t t = 0; t < 6; t++) {
        for (int i = 0; i < 2; i++) {
            const double mean = (double)K(mean)(SMOOTHED(&tape, t), i), low = (double)K(mean_low)(SMOOTHED(&tape, t), i);
            TEST_ASSERT_TRUE(fabs(low) <= 0.5 * EPS * fabs(mean));
        }
    }
}

/* Against the mean and its low part: in f32 a double is exact beside it.  Products by powers of 2 are exact. */
TEST(the_innovation_of_a_predicted_measurement_is_what_its_rounding_left)
{
    static const num rows[] = {-2, 0, 0, N(0.25)};
    const K(sensor) *s = sensor_of(rows, independent3, 2);
    int was_rounded = 0;
    for (int t = 0; t < 40; t++) {
        const num seen[] = {N(1e4 + 0.1 * t), N(3e3 - 0.7 * t)};
        num predicted[2], left[2];
        ASSERT_OK(K(step)(&track, &motion, u, &radar, seen));
        ASSERT_OK(K(measurement)(&track, s, predicted, NULL));
        ASSERT_OK(K(innovation)(&track, s, predicted, left));
        for (int c = 0; c < 2; c++) {
            const double x = (double)K(mean)(&track, c) + (double)K(mean_low)(&track, c);
            const double exact = (double)rows[3 * c] * x;
            const double bound = 16 * EPS * EPS + 4 * DBL_EPSILON;
            ASSERT_WITHIN(bound * fabs(exact), exact, (double)predicted[c] - (double)left[c]);
            was_rounded |= left[c] != 0;
        }
    }
    TEST_ASSERT_EQUAL_INT(sizeof(num) == sizeof(float), was_rounded);
}

/* Of 2^300 sigmas in f64: one move of the mean leaves its own rounding of that. */
TEST(a_mean_far_beyond_what_is_measured_is_where_it_belongs)
{
    static const num seen[] = {N(0.75)}, r[] = {1}, h[] = {1, 0};
    for (int k = 0; k < 100; k++) {
        const double sigma = pow(MOST_SIGMA, 0.009 * (k + 1)) * (1 + 0.013 * k);
        const num far[] = {N(-sigma / (7 + 31 * k)), N(0.3)}, wide[] = {N(1.7 * sigma * sigma), N(0.3 * sigma), N(0.3 * sigma), 1};
        ASSERT_OK(K(filter_init)(&track, far, wide));
        ASSERT_OK(K(update)(&track, sensor_of(h, r, 1), seen));
        ASSERT_WITHIN(4, seen[0], K(mean)(&track, 0));
        ASSERT_WITHIN(8 * EPS, sqrt(1.7 / (1.7 + 1 / (sigma * sigma))), K(sigma)(&track, 0));
    }
}

/* The first component is the second one's noise.  What it makes of the mean is a number, what the second says of that is
   none: the mean moves once. */
TEST(a_residual_of_others_beyond_the_number_range_moves_nothing)
{
    const num q = N(sqrt(sqrt(MOST_SIGMA))), large = q * q * q, far = 4 * large * large;
    const num h[] = {0, 0, large, large}, C[] = {1 / large / large, 1 / large, 1 / large, 1};
    const num wide[] = {q * q * q * q, 0, 0, q * q * q * q}, origin[] = {0, 0}, seen[] = {far, 0};
    ASSERT_OK(K(filter_init)(&track, origin, wide));
    ASSERT_OK(K(update)(&track, sensor_of(h, C, 2), seen));
    for (int i = 0; i < 2; i++) ASSERT_WITHIN(TOLERANCE, -0.5, (double)K(mean)(&track, i) / (double)far);
    TEST_ASSERT_EQUAL_INT(1, K(taken)(&track));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_PRECISION | KQ_EVENT_CONTRADICTION | KQ_EVENT_REDUNDANT, K(events)(&track));
    ASSERT_OK(K(filter_check)(&track));
}

/* The same where terms of one row cancel: the sigma of what is measured is rounding of theirs. */
TEST(a_residual_of_terms_beyond_the_number_range_moves_nothing)
{
    const double sigma = MOST_SIGMA / 2, factor = EPS > 1e-10 ? 0x1p9 : 0x1p25, left = factor * sigma * EPS;
    const num root[] = {1, N(sigma * (1 + EPS)), N(sigma)}, h[] = {N(factor), -N(factor)};
    const num C[] = {1}, origin[] = {0, 0}, seen[] = {N(2 * left * MOST_SIGMA)};
    ASSERT_OK(K(filter_init_root)(&track, origin, root));
    ASSERT_OK(K(update)(&track, sensor_of(h, C, 1), seen));
    for (int i = 0; i < 2; i++) ASSERT_WITHIN(0x1p-20, 1, (double)K(mean)(&track, i) / MOST_SIGMA / MOST_SIGMA);
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_PRECISION | KQ_EVENT_CONTRADICTION, K(events)(&track));
    ASSERT_OK(K(filter_check)(&track));
}

TEST(an_innovation_beyond_the_number_range_is_not_taken)
{
    static const num C[] = {1, 0, 0, 1};
    const double most = MOST_SIGMA * MOST_SIGMA;
    const num h[] = {N(0.75 * (double)NUM_MAX / most), 0, 0, 1}, far[] = {-N(most), -2};
    ASSERT_OK(K(filter_init)(&track, far, P0));
    ASSERT_OK(K(filter_init)(&twin, far, P0));
    z[0] = N(0.75 * (double)NUM_MAX);
    ASSERT_OK(K(update)(&track, sensor_of(h, C, 2), z));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_OVERFLOW, K(events)(&track));
    TEST_ASSERT_EQUAL_INT(1, K(taken)(&track));
    ASSERT_OK(K(update_subset)(&twin, sensor_of(h, C, 2), z, 2));
    ASSERT_SAME_STATE(&twin, &track, 2);
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&twin));
}

TEST(an_innovation_variance_beyond_the_number_range_is_not_taken)
{
    const num h[] = {N(0x1p-20 * (double)NUM_MAX), 0};
    static const num C[] = {1};
    z[0] = 1;
    ASSERT_OK(K(update)(&track, sensor_of(h, C, 1), z));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_OVERFLOW, K(events)(&track));
    TEST_ASSERT_EQUAL_INT(0, K(taken)(&track));
    ASSERT_SAME_STATE(&twin, &track, 2);
}

/* Sixteen components whose NIS is a number each have one together; one beyond that is not taken. */
TEST(the_nis_of_many_components_is_a_number)
{
    static num many_h[16], many_r[16], far[16];
    static const num zero = 0;
    const double large = sqrt((double)NUM_MAX) / 8;
    SENSOR(many, 1, 16);
    FILTER(known, 1);
    for (int c = 0; c < 16; c++) many_h[c] = many_r[c] = 1, far[c] = N(large);
    ASSERT_OK(K(sensor_init_diagonal)(&many, many_h, many_r));
    ASSERT_OK(K(filter_init)(&known, &zero, &zero));
    ASSERT_OK(K(update)(&known, &many, far));
    TEST_ASSERT_EQUAL_INT(16, K(taken)(&known));
    ASSERT_CLOSE(1, (double)K(nis)(&known) / large / large / 16, 1);
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&known));
    for (int c = 0; c < 16; c++) far[c] *= 4;
    ASSERT_OK(K(update)(&known, &many, far));
    TEST_ASSERT_EQUAL_INT(0, K(taken)(&known));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_OVERFLOW, K(events)(&known));
    TEST_ASSERT_TRUE(isfinite(K(log_likelihood)(&known)));
}

SUITE(update, set_up)
#include "update.tests"
