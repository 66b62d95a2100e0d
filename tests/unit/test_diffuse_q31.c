/* The unknown start in q31: against that in double, and what it refuses. */
#include "q31.h"
#include "unchanged.h"

#define STEPS 12
#define EARLY 4
#define LIKE 0x1p-22

static process_model motion, still;
static sensor_model radar, ranger;
static prior_model prior;
KQ_FILTER_Q31(track, 2);
KQ_HISTORY_Q31(tape, 2, 2, STEPS, STEPS);
KQ_DIFFUSE_Q31(start, 2, EARLY);

/* the same in double */
PROCESS(motion_f64, 2, 1);
SENSOR(radar_f64, 2, 2);
SENSOR(ranger_f64, 2, 1);
FILTER(track_f64, 2);
HISTORY(tape_f64, 2, 2, STEPS, STEPS);
DIFFUSE(start_f64, 2, EARLY);

/* so wide that what is measured tells more than they do */
static const double range[] = {400, 80, 10}, drive_range[] = {5}, measured_range[] = {100, 100};
static const double A[] = {1, 0.5, -0.25, 0.75}, B[] = {0.125, 0.5}, I[] = {1, 0, 0, 1};
static const double Q[] = {0.25, 0.125, 0.125, 0.5}, zero[4];
static const double H[] = {1, 0, 0.5, 1}, R[] = {0.5, 0.25, 0.25, 1};
static const double sum[] = {0.75, 0.5}, r[] = {0.5};
static const double x0[] = {1, -2, 0}, P0[] = {2, 0.5, 0.5, 1};

static kq_scaled_q31 P_words[4];
static int was_known; /* before the step that is looked at */

static void begin(uint32_t unknown)
{
    was_known = 0;
    ASSERT_OK(kq_diffuse_init_q31(&start, &track, &prior.table, unknown, NULL));
    ASSERT_OK(kq_attach_q31(&track, &tape.attached));
    ASSERT_OK(K(diffuse_init)(&start_f64, &track_f64, x0, P0, unknown));
    ASSERT_OK(K(attach)(&track_f64, &tape_f64.attached));
}

static void set_up(void)
{
    put_process(&motion, 2, 1, range, drive_range, A, B, Q);
    put_process(&still, 2, 0, range, NULL, I, NULL, zero);
    put_sensor(&radar, 2, 2, range, measured_range, H, R);
    put_sensor(&ranger, 2, 1, range, measured_range, sum, r);
    put_prior(&prior, 2, range, x0, P0);
    ASSERT_OK(K(process_init)(&motion_f64, A, B, Q));
    ASSERT_OK(K(sensor_init)(&radar_f64, H, R));
    ASSERT_OK(K(sensor_init)(&ranger_f64, sum, r));
    ASSERT_OK(kq_history_assign_q31(&tape, 2, tape_memory, COUNT(tape_memory)));
    ASSERT_OK(kq_diffuse_assign_q31(&start, 2, EARLY, start_memory, COUNT(start_memory)));
    begin(3);
    watch_nothing();
    WATCH(start), WATCH(start_memory), WATCH(track), WATCH(track_memory), WATCH(tape);
    WATCH(P_words);
}

/* ------------------------------------------------------------------ beside double */

static void update(sensor_model *s, const K(sensor) * by, const double *z, uint32_t present)
{
    const int32_t *words = words_of(z, s->table.components, s->measurement_format);
    ASSERT_OK(kq_update_subset_q31(&track, &s->sensor, words, present));
    ASSERT_OK(K(update_subset)(&track_f64, by, z, present));
}

static void predict(const double *u)
{
    ASSERT_OK(kq_predict_q31(&track, &motion.process,
                                   u ? words_of(u, 1, motion.control_format) : NULL));
    ASSERT_OK(K(predict)(&track_f64, &motion_f64, u));
}

static double word_value(int32_t word, int32_t low, int i)
{
    return ldexp(word + ldexp(low, -24), -prior.state_format[i].fraction);
}

static size_t first_early(void)
{
    size_t first;
    (void)kq_diffuse_steps_q31(&start, &first);
    return first;
}

static void assert_like_double(UNITY_LINE_TYPE line)
{
    UNITY_TEST_ASSERT_EQUAL_INT(K(diffuse_count)(&start_f64), kq_diffuse_count_q31(&start), line,
                                "count");
    for (int i = 0; i < 2; i++) {
        const int is = !isnan(K(mean)(&track_f64, i));
        const int32_t mean = kq_mean_q31(&track, i), low = kq_mean_low_q31(&track, i);
        UNITY_TEST_ASSERT((mean == KQ_NOT_A_VALUE_Q31) == !is, line, "mean");
        UNITY_TEST_ASSERT((kq_sigma_q31(&track, i) == KQ_NOT_A_VALUE_Q31) == !is, line,
                          "sigma");
        if (!is) continue;
        const double sigma = K(sigma)(&track_f64, i);
        assert_within(LIKE * (sigma + 10), K(mean)(&track_f64, i), word_value(mean, low, i),
                      line);
        assert_within(LIKE * (sigma + 10), sigma, word_value(kq_sigma_q31(&track, i), 0, i),
                      line);
    }
    if (kq_diffuse_count_q31(&start) > 0) return; /* counted in ranges so far */
    assert_within(1e-5, K(log_likelihood)(&track_f64),
                  score_value(kq_log_likelihood_q31(&track)), line);
    if (was_known) {
        assert_within(1e-5, K(log_likelihood_last)(&track_f64),
                      score_value(kq_log_likelihood_last_q31(&track)), line);
    }
    was_known = 1;
}

#define ASSERT_LIKE_DOUBLE() assert_like_double(__LINE__)

static void assert_smoothed(size_t steps, UNITY_LINE_TYPE line)
{
    num P[4];
    ASSERT_OK(kq_diffuse_smooth_q31(&start));
    ASSERT_OK(K(diffuse_smooth)(&start_f64));
    for (size_t t = 0; t < steps; t++) {
        for (int i = 0; i < 2; i++) {
            const double mean = K(mean)(START_SMOOTHED(&start_f64, t), i);
            const int32_t word = kq_mean_q31(START_SMOOTHED_Q31(&start, t), i);
            UNITY_TEST_ASSERT((word == KQ_NOT_A_VALUE_Q31) == !!isnan(mean), line, "smoothed");
            if (isnan(mean)) continue;
            assert_within(LIKE * 16, mean,
                          word_value(word, kq_mean_low_q31(START_SMOOTHED_Q31(&start, t), i), i), line);
            assert_within(LIKE * 16, K(sigma)(START_SMOOTHED(&start_f64, t), i),
                          word_value(kq_sigma_q31(START_SMOOTHED_Q31(&start, t), i), 0, i), line);
        }
        const kq_status status = K(covariance)(START_SMOOTHED(&start_f64, t), P);
        UNITY_TEST_ASSERT_EQUAL_INT(status, kq_covariance_q31(START_SMOOTHED_Q31(&start, t), P_words),
                                    line, "covariance");
        for (int k = 0; status == KQ_OK && k < 4; k++) {
            const int fraction =
                prior.state_format[k / 2].fraction + prior.state_format[k % 2].fraction;
            assert_within(LIKE * 16, P[k], value_of(P_words[k], fraction), line);
        }
    }
}

static void run_beside_double(uint32_t unknown, UNITY_LINE_TYPE line)
{
    static const double z[STEPS][2] = {{3, 1},    {2, -1}, {0.5, 0.25}, {-1, 2}, {4, 0}, {1, 1},
                                       {2.5, -2}, {0, 0},  {1, -1},     {2, 1},  {3, 3}, {1, 2}};
    static const double u[] = {1.5};
    begin(unknown);
    for (int t = 0; t < STEPS; t++) {
        if (t > 0) predict(t % 3 ? u : NULL);
        if (t > 1) update(&ranger, &ranger_f64, z[t] + 1, 1);
        assert_like_double(line);
        if (t > 0) update(&radar, &radar_f64, z[t], (uint32_t)t % 4);
        assert_like_double(line);
    }
    TEST_ASSERT_EQUAL_INT(0, kq_events_q31(&track));
    TEST_ASSERT_EQUAL_UINT(K(diffuse_steps)(&start_f64, NULL), kq_diffuse_steps_q31(&start, NULL));
    assert_smoothed(STEPS, line);
}

TEST(all_unknown) { run_beside_double(3, __LINE__); }

TEST(the_first_unknown) { run_beside_double(1, __LINE__); }

TEST(the_second_unknown) { run_beside_double(2, __LINE__); }

TEST(nothing_unknown) { run_beside_double(0, __LINE__); }

TEST(nothing_but_gaps)
{
    begin(3);
    for (int t = 0; t < 6; t++) predict(NULL);
    ASSERT_LIKE_DOUBLE();
    TEST_ASSERT_EQUAL_UINT(2, first_early());
    static const double z[] = {3, 1};
    update(&radar, &radar_f64, z, 3);
    ASSERT_LIKE_DOUBLE();
    assert_smoothed(7, __LINE__);
}

/* Of what is hardly seen the ranges say more: x0 and a third of the range. */
TEST(what_says_less_than_the_ranges_takes_their_prior)
{
    static const double z[] = {100};
    static const kq_scaled_q31 small[] = {{INT32_C(1) << 30, -60}, {0, 0}};
    ASSERT_OK(kq_sensor_change_measurement_q31(&ranger.sensor, small, NULL));
    ASSERT_OK(
        kq_update_q31(&track, &ranger.sensor, words_of(z, 1, ranger.measurement_format)));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_PRECISION, kq_events_q31(&track));
    TEST_ASSERT_EQUAL_INT(1, kq_diffuse_count_q31(&start));
    ASSERT_WITHIN(1e-3, 1, mean_value(&track, 0));
    ASSERT_WITHIN(1e-3, range[0] / 3, word_value(kq_sigma_q31(&track, 0), 0, 0));
}

/* Where the ranges' prior moves a mean or a sigma by 5 % of sigma the event says so, and nowhere else. */
TEST(a_prior_that_counts_is_told)
{
    static const double z[2][2] = {{3, 1}, {2, -1}};
    int told = 0;
    for (int k = 0; k < 60; k++) {
        const double part = ldexp(1, -k / 4), wide[] = {400 * part + 40, 80 * part + 15};
        put_process(&motion, 2, 1, wide, drive_range, A, B, Q);
        put_sensor(&ranger, 2, 1, wide, measured_range, sum, r);
        put_prior(&prior, 2, wide, x0, P0);
        const double noise[] = {(k % 4 + 1) * (k % 4 + 1) * 0.125};
        put_sensor(&ranger, 2, 1, wide, measured_range, sum, noise);
        ASSERT_OK(K(sensor_init)(&ranger_f64, sum, noise));
        begin(3);
        for (int t = 0; t < 2; t++) {
            if (t) predict(NULL);
            update(&ranger, &ranger_f64, z[t], 1);
        }
        double off = 0;
        for (int i = 0; i < 2; i++) {
            const double sigma = K(sigma)(&track_f64, i);
            off = fmax(off, fabs(word_value(kq_sigma_q31(&track, i), 0, i) / sigma - 1));
            off = fmax(off, fabs(word_value(kq_mean_q31(&track, i), 0, i) - K(mean)(&track_f64, i)) / sigma);
        }
        TEST_ASSERT_EQUAL_HEX(off > 0.05 ? KQ_EVENT_PRECISION : 0, kq_events_q31(&track));
        told += off > 0.05;
    }
    TEST_ASSERT_INT_WITHIN(20, 30, told);
}

/* A state that is larger than declared */
TEST(the_smoother_says_that_a_state_was_held)
{
    static const double z[] = {95}, h[] = {0.0625, 0};
    put_sensor(&ranger, 2, 1, range, measured_range, h, r);
    for (int t = 0; t < 4; t++) {
        ASSERT_OK(kq_update_q31(&track, &ranger.sensor, words_of(z, 1, ranger.measurement_format)));
        ASSERT_OK(kq_predict_q31(&track, &motion.process, NULL));
    }
    TEST_ASSERT_EQUAL_INT(0, kq_diffuse_count_q31(&start));
    TEST_ASSERT_TRUE((kq_events_q31(&track) & KQ_EVENT_SATURATED) != 0);
    TEST_ASSERT_EQUAL_INT(KQ_SATURATED, kq_diffuse_smooth_q31(&start));
}

TEST(it_decays_without_end)
{
    static kq_scaled_q31 half[4];
    half[0] = half[3] = (kq_scaled_q31){INT32_C(1) << 30, -31};
    ASSERT_OK(kq_process_change_transition_q31(&still.process, half, NULL));
    for (int t = 0; t < 5000; t++) {
        ASSERT_OK(kq_predict_q31(&track, &still.process, NULL));
    }
    TEST_ASSERT_EQUAL_INT(2, kq_diffuse_count_q31(&start));
    for (int t = 0; t < 5000; t++) {
        ASSERT_OK(kq_predict_q31(&track, &still.process, NULL));
    }
    TEST_ASSERT_EQUAL_INT(0, kq_diffuse_count_q31(&start));
    half[0] = half[3] = (kq_scaled_q31){INT32_C(1) << 30, -26};
    ASSERT_OK(kq_process_change_transition_q31(&still.process, half, NULL));
    begin(3);
    for (int t = 0; t < 3000; t++) {
        ASSERT_OK(kq_predict_q31(&track, &still.process, NULL));
    }
    TEST_ASSERT_EQUAL_INT(2, kq_diffuse_count_q31(&start));
}

/* ------------------------------------------------------------------ errors */

TEST(init_refuses)
{
    kq_range_error_q31 range_error;
    kq_prior_table_q31 bad = prior.table;
    bad.root = NULL;
    ASSERT_REFUSED(KQ_ERR_NULL, kq_diffuse_init_q31(&start, &track, &bad, 1, NULL));
    bad = prior.table;
    bad.mean = NULL;
    ASSERT_REFUSED(KQ_ERR_NULL, kq_diffuse_init_q31(&start, &track, &bad, 1, NULL));
    prior.mean[1] = INT32_MAX;
    prior.state_format[1].range = 1000;
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_diffuse_init_q31(&start, &track, &prior.table, 1, &range_error));
    TEST_ASSERT_EQUAL_INT(1, range_error.component);
    prior.mean[1] = 0;
    prior.root[2] = -1;
    ASSERT_REFUSED(KQ_ERR_TABLE, kq_diffuse_init_q31(&start, &track, &prior.table, 1, NULL));
    ASSERT_OK(kq_diffuse_init_q31(&start, &track, &prior.table, 2, NULL)); /* not looked at */
}

TEST(steps_refuse)
{
    static const int32_t z[] = {1, 1}, beyond[] = {INT32_MIN, 0};
    ASSERT_OK(kq_update_subset_q31(&track, &radar.sensor, beyond, 2));
    kq_format_q31 format[2] = {prior.state_format[0], prior.state_format[1]};
    kq_sensor_table_q31 table = radar.table;
    kq_sensor_q31 other;
    format[0].fraction--;
    table.state_format = format;
    ASSERT_OK(kq_sensor_init_q31(&other, &table, NULL));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, kq_update_q31(&track, &other, z));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, kq_step_q31(&track, &motion.process, NULL, &other, z));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_covariance_q31(&track, P_words));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_gain_q31(&track, &radar.sensor, P_words));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, kq_smooth_q31(&tape));
}

SUITE(diffuse_q31, set_up)
#include "diffuse_q31.tests"
