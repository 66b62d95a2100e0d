/* What decides conditions of the q31 arithmetic alone: tables at the ends of their exponents, means beyond their words. */
#include "q31.h"
#include "reading.h"
#include "unchanged.h"

static kq_format_q31 whole[3], fine[3]; /* words of 1, and of 2^-8 */
static kq_scaled_q31 table[9], transition[9], measurement[9], variances[9];
static int32_t root[KQ_ROOT_LEN_Q31(3)], noise_root[KQ_ROOT_LEN_Q31(3)], words[3];
static kq_range_error_q31 range_error;
static kq_process_q31 motion;
static kq_sensor_q31 gauge;
KQ_FILTER_Q31(track, 2);
KQ_HISTORY_Q31(tape, 2, 2, 4, 4);

static const int32_t home[3];
static const kq_scaled_q31 one = {1 << 30, -30}, nothing = {0, 0};

static void set_up(void)
{
    for (int i = 0; i < 3; i++) whole[i] = (kq_format_q31){1 << 30, 0}, fine[i] = (kq_format_q31){1 << 30, 8};
    for (int k = 0; k < 9; k++) transition[k] = measurement[k] = k % 3 ? nothing : one; /* of two states: the identity */
    for (int k = 0; k < 9; k++) variances[k] = one;
    memset(noise_root, 0, sizeof noise_root);
    memset(root, 0, sizeof root);
    watch_nothing();
}

static kq_status init_process(int n, const kq_format_q31 *format)
{
    const kq_process_table_q31 given = {.states = n, .state_format = format, .transition = transition, .noise_root = noise_root};
    return kq_process_init_q31(&motion, &given, &range_error);
}

static kq_status init_sensor(int n, int m)
{
    const kq_sensor_table_q31 given = {.states = n, .components = m, .state_format = whole, .measurement_format = whole,
                                       .measurement = measurement, .noise = variances};
    return kq_sensor_init_diagonal_q31(&gauge, &given, &range_error);
}

/* Of two states: the root [a, b; 0, c] in words */
static void begin(int32_t a, int32_t b, int32_t c)
{
    const kq_prior_table_q31 prior = {2, whole, home, root};
    root[0] = a, root[1] = b, root[2] = c, root[3] = root[4] = 0;
    ASSERT_OK(kq_filter_init_q31(&track, &prior, NULL));
}

/* ------------------------------------------------------------------- tables of doubles */

TEST(a_vector_needs_formats)
{
    const double x[] = {1};
    kq_format_q31 none = {1, KQ_FRACTION_MAX_Q31 + 1};
    TEST_ASSERT_EQUAL_INT(KQ_ERR_SIZE, kq_vector_prepare_q31(words, x, 1, &none, NULL));
    none.fraction = KQ_FRACTION_MIN_Q31 - 1;
    TEST_ASSERT_EQUAL_INT(KQ_ERR_SIZE, kq_vector_prepare_q31(words, x, 1, &none, NULL));
}

/* A sigma just below 2 is rounded to 2: one bit more than the row has room for */
TEST(a_root_that_is_rounded_up)
{
    const double P[] = {4 - 0x1p-49};
    ASSERT_OK(kq_root_prepare_q31(root, P, 1, whole));
    ASSERT_WITHIN(0, 2, ldexp(root[0], root[1]));
    TEST_ASSERT_TRUE(root[0] <= 1 << 30);
}

/* A second component that repeats the first, but for rounding, has no noise of its own. */
TEST(a_noise_that_is_anothers)
{
    const double equal[] = {1, 1, 1, 1}, indefinite[] = {1, 2, 2, 1};
    for (int k = 1; k < 256; k++) {
        const double share = 1 - k * 0x1p-53, repeated[] = {1, share, share, 1};
        ASSERT_OK(kq_noise_prepare_q31(table, repeated, 2, whole));
        if (k <= 4) TEST_ASSERT_EQUAL_INT32(0, table[0].mantissa);
        if (k > 128) TEST_ASSERT_GREATER_THAN_INT32(0, table[0].mantissa);
    }
    ASSERT_OK(kq_noise_prepare_q31(table, equal, 2, whole));
    TEST_ASSERT_EQUAL_INT32(0, table[0].mantissa);
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NOT_SEMIDEFINITE, kq_noise_prepare_q31(table, indefinite, 2, whole));
}

/* Sums of coefficients are counted up to 2^60 of 2^-20, however large they are. */
TEST(coefficients_that_are_far_too_large)
{
    for (int32_t exponent = -30; exponent < 100; exponent++) {
        for (int k = 0; k < 3; k++) transition[k] = (kq_scaled_q31){1 << 30, exponent};
        const kq_status status = init_process(3, whole);
        if (exponent > -26) TEST_ASSERT_EQUAL_INT(KQ_ERR_COEFFICIENT, status);
        else TEST_ASSERT_TRUE(status == KQ_OK || status == KQ_ERR_RANGE);
    }
    transition[0] = one;
    TEST_ASSERT_EQUAL_INT(KQ_ERR_RANGE, init_process(3, whole));
    TEST_ASSERT_GREATER_THAN_INT32(30, range_error.bits);
}

/* ------------------------------------------------------------------------ formats */

TEST(a_process_in_other_formats_smooths_nothing)
{
    begin(1 << 20, 0, 1 << 20);
    ASSERT_OK(init_sensor(2, 2));
    ASSERT_OK(kq_attach_q31(&track, &tape.attached));
    ASSERT_OK(init_process(2, whole));
    ASSERT_OK(kq_update_q31(&track, &gauge, home));
    ASSERT_OK(kq_predict_q31(&track, &motion, NULL));
    ASSERT_OK(kq_update_q31(&track, &gauge, home));
    ASSERT_OK(kq_smooth_step_q31(&tape, NULL, NULL));
    const kq_process_q31 recorded = motion;
    ASSERT_OK(init_process(2, fine));
    const kq_process_q31 finer = motion;
    motion = recorded;
    TEST_ASSERT_EQUAL_INT(KQ_ERR_MISMATCH, kq_smooth_step_q31(&tape, &finer, NULL));
    ASSERT_OK(kq_smooth_step_q31(&tape, &motion, NULL));
}

/* Before its first predict a tape has no process that another one could differ from. */
TEST(a_tape_without_a_predict_fits_each_process)
{
    begin(1 << 20, 0, 1 << 20);
    ASSERT_OK(init_sensor(2, 2));
    ASSERT_OK(init_process(2, fine));
    ASSERT_OK(kq_attach_q31(&track, &tape.attached));
    ASSERT_OK(kq_update_q31(&track, &gauge, home));
    ASSERT_OK(kq_smooth_step_q31(&tape, &motion, NULL));
}

/* ------------------------------------------------------------------- likelihoods */

/* A sum that is full is carried; at its end it stays there, in both directions. */
TEST(a_run_at_the_ends_of_its_sum)
{
    const int64_t end = INT64_C(1) << 61;
    begin(1 << 20, 0, 1 << 20);
    ASSERT_OK(init_sensor(2, 2));
    ASSERT_OK(kq_update_q31(&track, &gauge, home));
    track.run.sum = end - 1;
    track.run.carried = INT32_MAX;
    words[0] = words[1] = 1 << 29;
    for (int t = 0; t < 100; t++) ASSERT_OK(kq_update_q31(&track, &gauge, words));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, track.run.carried);
    TEST_ASSERT_TRUE(score_value(kq_log_likelihood_q31(&track)) < -1e11);
    track.run.sum = -end + 1;
    track.run.carried = -2;
    TEST_ASSERT_TRUE(score_value(kq_log_likelihood_q31(&track)) > 1e11);
    track.run.carried = -3;
    TEST_ASSERT_TRUE(score_value(kq_log_likelihood_q31(&track)) > 1e11);
    track.run.sum = -end - 1;
    track.run.carried = 0;
    TEST_ASSERT_TRUE(score_value(kq_log_likelihood_q31(&track)) > 6e10);
}

/* ------------------------------------------------------------------- measurements */

/* Rows that cancel: what is left of h'S is rounding of terms that are as large as its noise. */
TEST(rows_that_cancel_say_nothing)
{
    measurement[0] = one, measurement[1] = (kq_scaled_q31){-(1 << 30), -30};
    variances[0] = (kq_scaled_q31){1 << 30, -22};
    ASSERT_OK(init_sensor(2, 1));
    unsigned events = 0;
    for (int bits = 20; bits <= 29; bits++) {
        begin(1, 1 << bits, 1 << bits);
        for (int t = 0; t < 40; t++) ASSERT_OK(kq_update_q31(&track, &gauge, home));
        events = kq_events_q31(&track);
    }
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_PRECISION, events & KQ_EVENT_PRECISION);
}

/* A mean that is beyond its word between two components of an update, seen by coefficients of any size */
TEST(a_mean_beyond_its_word_within_an_update)
{
    static const int32_t exponents[] = {-26, -28, -40, -57, -60, -62, -100};
    for (int sign = -1; sign <= 1; sign += 2) {
        for (int k = 0; k < COUNT(exponents); k++) {
            measurement[0] = (kq_scaled_q31){1 << 30, -34}, measurement[1] = nothing; /* x_0 = 16 z */
            measurement[2] = (kq_scaled_q31){1 << 30, exponents[k]}, measurement[3] = nothing;
            ASSERT_OK(init_sensor(2, 2));
            begin(1 << 30, 0, 1 << 30);
            words[0] = sign * (1 << 30), words[1] = 0;
            for (int t = 0; t < 4; t++) ASSERT_OK(kq_update_q31(&track, &gauge, words));
            TEST_ASSERT_TRUE(kq_mean_q31(&track, 0) >= -INT32_MAX);
        }
    }
}

/* A lean sensor of hardly any noise, of what is known exactly: it says nothing, and changes nothing. */
TEST(a_lean_sensor_of_what_is_known)
{
    const kq_sensor_table_q31 given = {.states = 2, .components = 1, .state_format = whole, .measurement_format = whole,
                                       .measurement = measurement, .noise = variances};
    variances[0] = (kq_scaled_q31){1 << 30, -900};
    ASSERT_OK(kq_sensor_init_lean_q31(&gauge, &given, NULL));
    begin(0, 0, 0);
    ASSERT_OK(kq_update_q31(&track, &gauge, home));
    TEST_ASSERT_EQUAL_INT32(0, kq_mean_q31(&track, 0));
    TEST_ASSERT_EQUAL_INT32(0, kq_sigma_q31(&track, 0));
}

/* Of a state that is known exactly, or as good as that by a measurement, an instant keeps nothing but the mean. */
TEST(an_instant_of_what_is_known)
{
    KQ_INSTANT_Q31(instant, 2, 2);
    for (int is_sharp = 0; is_sharp < 2; is_sharp++) {
        ASSERT_OK(kq_instant_assign_q31(&instant, 2, 2, instant_memory, COUNT(instant_memory)));
        ASSERT_OK(init_process(2, whole));
        if (is_sharp) variances[0] = variances[1] = (kq_scaled_q31){1 << 30, -100};
        ASSERT_OK(init_sensor(2, 2));
        begin(is_sharp ? 1 << 29 : 0, 0, is_sharp ? 1 << 29 : 0);
        ASSERT_OK(kq_attach_q31(&track, &instant.attached));
        for (int t = 0; t < 40; t++) ASSERT_OK(kq_step_q31(&track, &motion, NULL, &gauge, home));
        TEST_ASSERT_EQUAL_INT32(0, kq_sigma_q31(&track, 0));
        ASSERT_OK(kq_detach_q31(&instant.attached));
    }
}

/* A variance that falls for ever comes to an end that is no number of any size. */
TEST(a_sigma_that_falls_for_ever)
{
    transition[0] = transition[1] = transition[3] = (kq_scaled_q31){3 << 29, -900};
    ASSERT_OK(init_process(2, whole));
    begin(1 << 29, 1 << 20, 1 << 29);
    for (int t = 0; t < 40; t++) {
        ASSERT_OK(kq_predict_q31(&track, &motion, NULL));
        for (int k = 0; k < 20; k++) ASSERT_OK(kq_forget_q31(&track, (kq_scaled_q31){7 << 28, -31}));
    }
    TEST_ASSERT_EQUAL_INT32(0, kq_sigma_q31(&track, 0));
    ASSERT_OK(kq_filter_check_q31(&track));
}

/* A sum that is measured far below what is known of its terms: the digits of S tell it from rounding, or do not. */
TEST(a_sharp_measurement_that_leaves_few_digits)
{
    unsigned events = 0;
    ASSERT_OK(init_process(2, whole));
    measurement[1] = one;
    for (int32_t exponent = -40; exponent < 10; exponent++) {
        variances[0] = (kq_scaled_q31){1 << 30, exponent};
        ASSERT_OK(init_sensor(2, 1));
        begin(1 << 29, 0, 1 << 29);
        ASSERT_OK(kq_update_q31(&track, &gauge, home));
        TEST_ASSERT_EQUAL_HEX(0, kq_events_q31(&track) & KQ_EVENT_CONTRADICTION);
        ASSERT_OK(kq_predict_q31(&track, &motion, NULL));
        events |= kq_events_q31(&track);
    }
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_PRECISION, events & KQ_EVENT_PRECISION);
}

SUITE(conditions_q31, set_up)
#include "conditions_q31.tests"
