/* The filter in q31: what it refuses, how it saturates. */
#include "q31.h"
#include "reading.h"
#include "unchanged.h"

static process_model motion;
static sensor_model radar;
static prior_model start;
KQ_FILTER_Q31(track, 2);
KQ_FILTER_Q31(twin, 2);

static const double range[] = {100, 10}, drive_range[] = {5}, measured_range[] = {100, 100, 100};
static const double A[] = {1, 0.5, 0, 1}, B[] = {0.125, 0.5}, Q[] = {0.25, 0.125, 0.125, 0.5};
static const double H[] = {1, 0, 0.5, 1, -1, 0.25};
static const double R[] = {0.5, 0.25, -0.125, 0.25, 1, 0.5, -0.125, 0.5, 2};
static const double x0[] = {1, -2}, P0[] = {2, 0.5, 0.5, 1}, z[] = {3, 1, -1}, u[] = {4};

static int32_t measured[3], drive[1], out[3], errors[3];
static kq_scaled_q31 more[9];

static void set_up(void)
{
    put_process(&motion, 2, 1, range, drive_range, A, B, Q);
    put_sensor(&radar, 2, 3, range, measured_range, H, R);
    put_prior(&start, 2, range, x0, P0);
    ASSERT_OK(kq_vector_prepare_q31(measured, z, 3, radar.measurement_format, NULL));
    ASSERT_OK(kq_vector_prepare_q31(drive, u, 1, motion.control_format, NULL));
    ASSERT_OK(kq_filter_assign_q31(&track, 2, track_memory, COUNT(track_memory)));
    ASSERT_OK(kq_filter_init_q31(&track, &start.table, NULL));
    ASSERT_OK(kq_filter_init_q31(&twin, &start.table, NULL));
    watch_nothing();
    WATCH(motion), WATCH(radar), WATCH(start), WATCH(track), WATCH(track_memory), WATCH(twin);
    WATCH(twin_memory), WATCH(measured), WATCH(drive), WATCH(out), WATCH(errors), WATCH(more);
}

/* ------------------------------------------------------- components without noise */

/* Two components take most of what is unknown: what rounding has left of them is that of rows that
   were long, and no information in their sum. */
TEST(a_sum_is_not_taken_when_its_terms_were)
{
    static const double large[] = {100000, 100000, 100000}, none[9], zero[3];
    KQ_FILTER_Q31(sharp, 3);
    prior_model prior;
    uint32_t seed = 3;
    for (int k = 0; k < 300; k++) {
        double rows[9], wide[9], F[6];
        for (int i = 0; i < 6; i++) rows[i] = floor(64 * noise(&seed)) / 64, F[i] = noise(&seed);
        for (int i = 0; i < 3; i++) rows[6 + i] = rows[i] + rows[3 + i];
        for (int i = 0; i < 9; i++) {
            const double *a = F + 2 * (i / 3), *b = F + 2 * (i % 3);
            wide[i] = 1e4 * (a[0] * b[0] + a[1] * b[1]) + (i % 4 == 0 ? 1e-4 : 0);
        }
        put_sensor(&radar, 3, 3, large, large, rows, none);
        put_prior(&prior, 3, large, zero, wide);
        ASSERT_OK(kq_filter_init_q31(&sharp, &prior.table, NULL));
        const double z[] = {3.25, -1.5, 1.75};
        const int32_t *words = words_of(z, 3, radar.measurement_format);
        ASSERT_OK(kq_update_q31(&sharp, &radar.sensor, words));
        TEST_ASSERT_EQUAL_INT(2, kq_taken_q31(&sharp));
        TEST_ASSERT_EQUAL_HEX(KQ_EVENT_REDUNDANT, kq_events_q31(&sharp));
    }
}

/* ---------------------------------------------------------------------------- refusals */

/* A filter of the same size in other formats */
static kq_filter_q31 *other_filter(const double *other_range)
{
    static int32_t memory[KQ_FILTER_LEN_Q31(2)];
    static kq_filter_q31 f;
    static prior_model p;
    put_prior(&p, 2, other_range, x0, P0);
    ASSERT_OK(kq_filter_assign_q31(&f, 2, memory, COUNT(memory)));
    ASSERT_OK(kq_filter_init_q31(&f, &p.table, NULL));
    return &f;
}

static void assert_mismatch(kq_filter_q31 *f)
{
    const kq_process_q31 *p = &motion.process;
    const kq_sensor_q31 *s = &radar.sensor;
    ASSERT_REFUSED(KQ_ERR_MISMATCH, kq_predict_q31(f, p, drive));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, kq_update_q31(f, s, measured));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, kq_update_subset_q31(f, s, measured, 1));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, kq_step_q31(f, p, drive, s, measured));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, kq_forecast_q31(f, p, NULL, 1, &twin));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, kq_gain_q31(f, s, more));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, kq_measurement_q31(f, s, out, more));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, kq_innovation_q31(f, s, measured, errors));
}

TEST(other_formats_are_refused)
{
    static const double wider[] = {100, 100};
    assert_mismatch(other_filter(wider));
}

TEST(the_same_formats_in_another_array_are_not)
{
    kq_filter_q31 *f = other_filter(range);
    ASSERT_OK(kq_step_q31(f, &motion.process, drive, &radar.sensor, measured));
}

TEST(a_word_at_the_end_of_its_range_is_taken)
{
    const int32_t end = motion.control_format[0].range, second[] = {0, end + 1};
    TEST_ASSERT_EQUAL_INT32(100 << 24, radar.measurement_format[0].range);
    measured[0] = 100 << 24, measured[1] = -measured[0];
    ASSERT_OK(kq_update_q31(&track, &radar.sensor, measured));
    drive[0] = -end;
    ASSERT_OK(kq_predict_q31(&track, &motion.process, drive));
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_forecast_q31(&track, &motion.process, second, 2, &twin));
    ASSERT_OK(kq_forecast_q31(&track, &motion.process, second, 1, &twin));
}

/* -------------------------------------------------------------------------- saturation */

/* One state that doubles at every step, in Q31.0; a gauge of it */
static process_model growth;
static sensor_model gauge;
static prior_model seed;
KQ_FILTER_Q31(level, 1);

static void begin_growth(double x)
{
    static const double whole[] = {INT32_MAX}, two[] = {2}, one[] = {1}, q[] = {1}, r[] = {1e6};
    const double start_at[] = {x};
    put_process(&growth, 1, 0, whole, whole, two, NULL, q);
    put_sensor(&gauge, 1, 1, whole, whole, one, r);
    put_prior(&seed, 1, whole, start_at, one);
    ASSERT_OK(kq_filter_init_q31(&level, &seed.table, NULL));
}

static int32_t end_of_word(int sign) { return sign < 0 ? -INT32_MAX : INT32_MAX; }

static void assert_held(int sign)
{
    begin_growth(sign * 1e9);
    ASSERT_OK(kq_predict_q31(&level, &growth.process, NULL));
    TEST_ASSERT_EQUAL_INT32(sign < 0 ? -2000000000 : 2000000000, kq_mean_q31(&level, 0));
    TEST_ASSERT_EQUAL_HEX(0, kq_events_q31(&level));
    for (int k = 0; k < 40; k++) {
        ASSERT_OK(kq_predict_q31(&level, &growth.process, NULL));
        TEST_ASSERT_EQUAL_INT32(end_of_word(sign), kq_mean_q31(&level, 0));
        TEST_ASSERT_EQUAL_HEX(KQ_EVENT_SATURATED, kq_events_q31(&level));
    }
}

TEST(a_state_is_held_at_the_end_of_its_word)
{
    assert_held(1);
    assert_held(-1);
}

TEST(saturation_is_remembered_until_cleared)
{
    const int32_t home[] = {0};
    assert_held(-1);
    ASSERT_OK(kq_update_q31(&level, &gauge.sensor, home));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_SATURATED, kq_events_q31(&level));
    kq_events_clear_q31(&level);
    ASSERT_OK(kq_update_q31(&level, &gauge.sensor, home));
    TEST_ASSERT_EQUAL_HEX(0, kq_events_q31(&level));
}

TEST(measurements_bring_a_saturated_state_back)
{
    const int32_t home[] = {12345};
    for (int sign = -1; sign <= 1; sign += 2) {
        assert_held(sign);
        for (int k = 0; k < 4; k++) ASSERT_OK(kq_update_q31(&level, &gauge.sensor, home));
        ASSERT_WITHIN(2000, 12345, kq_mean_q31(&level, 0));
    }
}

/* An update that would overshoot the word: H small, the measurement at its end */
TEST(an_update_is_held_too)
{
    static const double whole[] = {INT32_MAX}, small[] = {0.01}, sharp[] = {1e-6}, wide[] = {1e30};
    static const double zero[] = {0};
    for (int sign = -1; sign <= 1; sign += 2) {
        const int32_t end[] = {end_of_word(sign)};
        put_sensor(&gauge, 1, 1, whole, whole, small, sharp);
        put_prior(&seed, 1, whole, zero, wide);
        ASSERT_OK(kq_filter_init_q31(&level, &seed.table, NULL));
        ASSERT_OK(kq_update_q31(&level, &gauge.sensor, end));
        TEST_ASSERT_EQUAL_INT32(end_of_word(sign), kq_mean_q31(&level, 0));
        TEST_ASSERT_BITS(KQ_EVENT_SATURATED, KQ_EVENT_SATURATED, kq_events_q31(&level));
    }
}

/* A variance that grows without end is held near 2^16384 words squared, and that is told. */
TEST(a_variance_that_grows_without_end_is_told)
{
    begin_growth(0);
    for (int k = 0; k < 8000; k++) ASSERT_OK(kq_predict_q31(&level, &growth.process, NULL));
    TEST_ASSERT_EQUAL_HEX(0, kq_events_q31(&level));
    for (int k = 0; k < 8000; k++) ASSERT_OK(kq_predict_q31(&level, &growth.process, NULL));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_OVERFLOW, kq_events_q31(&level));
}

/* Two correlated states, after so many steps without a measurement */
static void grow(const double *transition, const double *row, int steps)
{
    static const double thousand[] = {1000, 1000}, none[4] = {0}, at[2] = {0}, prior[] = {1, 0.9, 0.9, 1}, r[] = {0.01};
    put_process(&growth, 2, 0, thousand, thousand, transition, NULL, none);
    put_sensor(&gauge, 2, 1, thousand, thousand, row, r);
    put_prior(&seed, 2, thousand, at, prior);
    ASSERT_OK(kq_filter_init_q31(&track, &seed.table, NULL));
    for (int k = 0; k < steps; k++) ASSERT_OK(kq_predict_q31(&track, &growth.process, NULL));
}

/* However long state 0 has grown, a measurement of it leaves state 1 what is known of it. */
TEST(a_state_that_grew_for_long_spoils_no_other)
{
    static const double growing[] = {2, 0, 0, 1}, first[] = {1, 0};
    const int32_t seen[] = {5 << 20};
    for (int steps = 30; steps < 2000; steps += steps < 300 ? 7 : 500) {
        grow(growing, first, steps);
        for (int turn = 0; turn < 3; turn++) ASSERT_OK(kq_update_q31(&track, &gauge.sensor, seen));
        TEST_ASSERT_EQUAL_HEX(0, kq_events_q31(&track));
        const double word = 1 << 21, sigma = sqrt(1 - 0.81);
        ASSERT_WITHIN(0.01 * sigma * word, sigma * word, kq_sigma_q31(&track, 1));
        ASSERT_WITHIN(0.01 * sigma * word, 0, kq_mean_q31(&track, 1));
    }
}

/* State 1 has grown, and is measured together with state 0: what is known of that is part of what it is then. */
TEST(a_state_that_grew_for_long_is_measured_with_others)
{
    static const double growing[] = {1, 0, 0, 2}, row[] = {-0.37, 0.91};
    static const int32_t seen[] = {5 << 20};
    const double left = 1 - 0.81, word = 1 << 21;
    for (int steps = 20; steps < 2000; steps += steps < 300 ? 7 : 500) {
        grow(growing, row, steps);
        ASSERT_OK(kq_update_q31(&track, &gauge.sensor, seen));
        TEST_ASSERT_EQUAL_HEX(0, kq_events_q31(&track));
        ASSERT_WITHIN(1e-4 * word, sqrt(left) * word, kq_sigma_q31(&track, 0));
        ASSERT_WITHIN(1e-4 * word, sqrt(0.37 * 0.37 * left + 0.01) / 0.91 * word, kq_sigma_q31(&track, 1));
        ASSERT_WITHIN(1e-3 * word, 2.5 / 0.91 * word, kq_mean_q31(&track, 1));
    }
}

TEST(a_sigma_beyond_the_word_is_held)
{
    static const double whole[] = {INT32_MAX}, wide[] = {1e30}, zero[] = {0};
    put_prior(&seed, 1, whole, zero, wide);
    ASSERT_OK(kq_filter_init_q31(&level, &seed.table, NULL));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, kq_sigma_q31(&level, 0));
}

/* e = 2^30 - 1/2: the largest mantissa there is, rounded to a word */
TEST(an_innovation_is_rounded_to_a_word)
{
    static const double whole[] = {INT32_MAX}, one[] = {1}, zero[] = {0};
    const int32_t z1[] = {1}, far[] = {1 << 30}, back[] = {-(1 << 30)};
    int32_t e[1];
    put_sensor(&gauge, 1, 1, whole, whole, one, one);
    put_prior(&seed, 1, whole, zero, one);
    ASSERT_OK(kq_filter_init_q31(&level, &seed.table, NULL));
    ASSERT_OK(kq_update_q31(&level, &gauge.sensor, z1));
    ASSERT_WITHIN(1e-6, 0.5, mean_value(&level, 0));
    level.memory[0] = 0; /* one half, exactly */
    level.memory[1] = 1 << 23;
    ASSERT_OK(kq_innovation_q31(&level, &gauge.sensor, far, e));
    TEST_ASSERT_EQUAL_INT32(1 << 30, e[0]);
    ASSERT_OK(kq_innovation_q31(&level, &gauge.sensor, back, e));
    TEST_ASSERT_INT32_WITHIN(1, -(1 << 30), e[0]);
}

/* Words of 2^-60 and a noise of one word: det S is 2^-120 a measurement. */
static void begin_long_run(void)
{
    static kq_format_q31 fine = {1000000, 60};
    static kq_scaled_q31 unit[] = {{INT32_C(1) << 30, -30}};
    static const int32_t known[KQ_ROOT_LEN_Q31(1)] = {0}, home[] = {0};
    const kq_sensor_table_q31 sensor = {1, 1, 0, &fine, &fine, unit, unit};
    const kq_prior_table_q31 prior = {1, &fine, home, known};
    ASSERT_OK(kq_sensor_init_q31(&gauge.sensor, &sensor, NULL));
    ASSERT_OK(kq_filter_init_q31(&level, &prior, NULL));
}

/* The determinant's exponent where it is large, and over some parts of the count */
TEST(the_determinant_of_a_run_is_counted_all_the_time)
{
    const int32_t home[] = {0};
    begin_long_run();
    ASSERT_OK(kq_update_q31(&level, &gauge.sensor, home));
    const double once = score_value(kq_log_likelihood_q31(&level));
    for (int large = -1; large <= 1; large += 2) {
        level.run.determinant.exponent = large * ((INT32_C(1) << 30) - 100);
        level.run.count = 32760;
        const double before = score_value(kq_log_likelihood_q31(&level));
        for (int t = 0; t < 100; t++) ASSERT_OK(kq_update_q31(&level, &gauge.sensor, home));
        const double after = score_value(kq_log_likelihood_q31(&level));
        ASSERT_WITHIN(1e-6 * 100 * once, 100 * once, after - before);
    }
}

/* Bits 29 to 31 of the exponent turned, at counts at which it has been large: the check finds them, and takes what
   parts of the count leave. */
TEST(a_turned_exponent_of_a_run_is_found)
{
    const int32_t home[] = {0};
    begin_long_run();
    for (int t = 1; t <= 70000; t++) {
        ASSERT_OK(kq_update_q31(&level, &gauge.sensor, home));
        if (t % 499 && level.run.count > 1) continue;
        ASSERT_OK(kq_filter_check_q31(&level));
        if (level.run.count > 28000) continue; /* 2^29 may be what so many measurements leave */
        for (int bit = 29; bit < 32; bit++) {
            const int32_t exponent = level.run.determinant.exponent;
            level.run.determinant.exponent = (int32_t)((uint32_t)exponent ^ UINT32_C(1) << bit);
            TEST_ASSERT_EQUAL_INT(KQ_ERR_TABLE, kq_filter_check_q31(&level));
            level.run.determinant.exponent = exponent;
        }
    }
}

/* 2^37 of NIS is carried: the score, half of it, goes on to 2^37 = 1.4e11, and is saturated there. */
TEST(a_run_is_counted_up_to_the_end_of_its_score)
{
    const int32_t far[] = {20};
    begin_long_run();
    ASSERT_OK(kq_update_q31(&level, &gauge.sensor, far));
    const double once = score_value(kq_log_likelihood_q31(&level));
    level.run.sum = (INT64_C(1) << 61) - 1000;
    const double before = score_value(kq_log_likelihood_q31(&level));
    for (int t = 0; t < 1000; t++) ASSERT_OK(kq_update_q31(&level, &gauge.sensor, far));
    ASSERT_WITHIN(0x1p-29 * fabs(before), before + 1000 * once, score_value(kq_log_likelihood_q31(&level)));
    TEST_ASSERT_EQUAL_INT(1, level.run.carried);
    level.run.carried = 2;
    TEST_ASSERT_TRUE(kq_log_likelihood_q31(&level) == -(INT64_C(1) << 61));
    level.run.carried = INT32_C(1) << 12; /* 5.6e14: 100 years of 16 measurements at 10 kHz */
    TEST_ASSERT_TRUE(kq_log_likelihood_q31(&level) == -(INT64_C(1) << 61));
}

/* The noise is one word squared, the variance of a constant 2^-16 to 2^-24 of it: after 2^13 measurements. */
TEST(measurements_that_say_little_are_taken)
{
    const int32_t home[] = {0};
    for (int down = 8; down <= 12; down++) {
        begin_long_run();
        level.memory[2] = INT32_C(1) << 29;
        level.memory[3] = -29 - down;
        for (int t = 0; t < 1 << 13; t++) ASSERT_OK(kq_update_q31(&level, &gauge.sensor, home));
        const double left = ldexp(level.memory[2], level.memory[3] + down);
        const double right = 1 / (1 + ldexp(1, 13 - 2 * down));
        ASSERT_WITHIN(1e-3 * (1 - right), right, left * left);
        TEST_ASSERT_EQUAL_HEX(0, kq_events_q31(&level));
    }
}

/* An innovation of 2^31 sigma: NIS is held, and stays a score however often. */
TEST(a_score_is_held)
{
    static const double whole[] = {INT32_MAX}, one[] = {1}, zero[] = {0}, tiny[] = {1e-12};
    const int32_t far[] = {INT32_MAX};
    put_sensor(&gauge, 1, 1, whole, whole, one, tiny);
    put_prior(&seed, 1, whole, zero, zero);
    ASSERT_OK(kq_filter_init_q31(&level, &seed.table, NULL));
    for (int k = 0; k < 5; k++) {
        ASSERT_OK(kq_update_q31(&level, &gauge.sensor, far));
        TEST_ASSERT_TRUE(kq_nis_q31(&level) > INT64_C(1) << 60);
        TEST_ASSERT_TRUE(kq_nis_q31(&level) <= INT64_C(1) << 61);
        TEST_ASSERT_TRUE(kq_log_likelihood_q31(&level) != KQ_NOT_A_SCORE_Q31);
        TEST_ASSERT_TRUE(kq_log_likelihood_q31(&level) < -(INT64_C(1) << 59));
    }
}

/* Variance and noise both far below the mean's last bit, the noise much more: not more than s */
TEST(a_sharp_measurement_of_a_known_state_leaves_a_variance)
{
    static const double whole[] = {INT32_MAX}, one[] = {1}, zero[] = {0};
    static const double known[] = {0x1p-60}, sharp[] = {0x1p-100};
    const int32_t home[] = {0};
    kq_scaled_q31 P;
    put_sensor(&gauge, 1, 1, whole, whole, one, sharp);
    put_prior(&seed, 1, whole, zero, known);
    ASSERT_OK(kq_filter_init_q31(&level, &seed.table, NULL));
    ASSERT_OK(kq_update_q31(&level, &gauge.sensor, home));
    ASSERT_OK(kq_covariance_q31(&level, &P));
    TEST_ASSERT_TRUE(value_of(P, 0) > 0 && value_of(P, 0) <= 0x1p-60);
}

/* A row whose norm is 2^30 but for its last bits: rounding takes it beyond that, and it has the room. */
TEST(a_row_at_the_end_of_its_norm_is_rotated)
{
    static const double wide_range[] = {0x1p31 - 1, 0x1p31 - 1}, zero[2], unit[] = {1, 0, 0, 1}, r[] = {1};
    const int32_t root[] = {64602, 1073741822, 546182390, 0, 0}, home[] = {0};
    put_sensor(&radar, 2, 1, wide_range, wide_range, (const double[]){1, -2}, r);
    radar.measurement[1] = (kq_scaled_q31){-2110872719, -30};
    radar.noise[0] = (kq_scaled_q31){1859340249, -4};
    ASSERT_OK(kq_sensor_init_q31(&radar.sensor, &radar.table, NULL));
    put_prior(&start, 2, wide_range, zero, unit);
    ASSERT_OK(kq_filter_init_q31(&track, &start.table, NULL));
    for (int k = 0; k < COUNT(root); k++) track_memory[4 + k] = root[k];
    ASSERT_OK(kq_update_q31(&track, &radar.sensor, home));
    TEST_ASSERT_EQUAL_INT32((1 << 29) + 1, track_memory[5]); /* 2^30 + 1, halved and rounded */
    TEST_ASSERT_EQUAL_INT32(1, track_memory[7]);
}

SUITE(filter_q31, set_up)
#include "filter_q31.tests"
