/* Statistics over a window in q31: against those in double, and what is refused. */
#include "q31.h"
#include "reading.h"
#include "unchanged.h"

#define WINDOW 20
#define ALL UINT32_MAX
#define TWO (INT64_C(2) << 24)

KQ_CONSISTENCY_Q31(recent, 2, WINDOW);
KQ_CONSISTENCY_Q31(blank, 2, WINDOW);
KQ_FILTER_Q31(track, 2);
KQ_FILTER_Q31(blank_filter, 2);
static process_model motion;
static sensor_model radar, compass;
static prior_model start;

/* the same in double */
KQ_CONSISTENCY_F64(recent_f64, 2, WINDOW);
PROCESS(motion_f64, 2, 0);
SENSOR(radar_f64, 2, 2);
FILTER(track_f64, 2);

static const double range[] = {1000, 1000}, measured_range[] = {1000, 1000};
static const double A[] = {1, 0.5, 0, 1}, Q[] = {0.25, 0.125, 0.125, 0.5};
static const double H[] = {1, 0, 0.5, 1}, R[] = {0.5, 0.25, 0.25, 1};
static const double direction[] = {-1, 0.25}, variance[] = {0.125};
static const double x0[] = {1, -2}, P0[] = {2, 0.5, 0.5, 1};

static int32_t z[2];
static int64_t out[4];

static void set_up(void)
{
    put_process(&motion, 2, 0, range, NULL, A, NULL, Q);
    put_sensor(&radar, 2, 2, range, measured_range, H, R);
    put_sensor(&compass, 2, 1, range, measured_range, direction, variance);
    put_prior(&start, 2, range, x0, P0);
    ASSERT_OK(kq_filter_init_q31(&track, &start.table, NULL));
    ASSERT_OK(K(process_init)(&motion_f64, A, NULL, Q));
    ASSERT_OK(K(sensor_init)(&radar_f64, H, R));
    ASSERT_OK(K(filter_init)(&track_f64, x0, P0));
    ASSERT_OK(kq_consistency_assign_q31(&recent, 2, WINDOW, recent_memory, COUNT(recent_memory)));
    ASSERT_OK(K(consistency_clear)(&recent_f64));
    memset(recent_memory, 0, sizeof recent_memory);
    memset(&blank, 0, sizeof blank);
    z[0] = z[1] = 1 << 20;
    watch_nothing();
    WATCH(recent), WATCH(recent_memory), WATCH(track), WATCH(track_memory), WATCH(radar);
    WATCH(blank), WATCH(out);
}

static void step(const double *values, uint32_t present)
{
    const int32_t *words = words_of(values, 2, radar.measurement_format);
    ASSERT_OK(kq_consistency_watch_q31(&recent, &track, &radar.sensor, words, present));
    ASSERT_OK(kq_update_subset_q31(&track, &radar.sensor, words, present));
    ASSERT_OK(kq_consistency_record_q31(&recent, &track));
    ASSERT_OK(kq_predict_q31(&track, &motion.process, NULL));
    ASSERT_OK(K(consistency_watch)(&recent_f64, &track_f64, &radar_f64, values, present));
    ASSERT_OK(K(update_subset)(&track_f64, &radar_f64, values, present));
    ASSERT_OK(K(consistency_record)(&recent_f64, &track_f64));
    ASSERT_OK(K(predict)(&track_f64, &motion_f64, NULL));
}

/* An innovation is good to some units of 2^-24. */
#define LIKE 0x1p-19

static void assert_like_double(void)
{
    double expected[4];
    int64_t a[4];
    TEST_ASSERT_EQUAL_INT(K(consistency_count)(&recent_f64), kq_consistency_count_q31(&recent));
    ASSERT_OK(K(consistency_nis)(&recent_f64, 2, &expected[0], &expected[1], &expected[2]));
    ASSERT_OK_UNCHANGED(kq_consistency_nis_q31(&recent, TWO, &a[0], &a[1], &a[2]));
    for (int k = 0; k < 3; k++) {
        ASSERT_WITHIN(LIKE * (1 + expected[k]), expected[k], score_value(a[k]));
    }
    for (int c = 0; c < 2; c++) {
        ASSERT_OK(K(consistency_innovation)(&recent_f64, c, 2, &expected[0], &expected[1],
                                            &expected[2], &expected[3]));
        ASSERT_OK_UNCHANGED(
            kq_consistency_innovation_q31(&recent, c, TWO, &a[0], &a[1], &a[2], &a[3]));
        for (int k = 0; k < 4; k++) ASSERT_WITHIN(LIKE * 8, expected[k], score_value(a[k]));
    }
}

static void the_statistics_are_those_in_double(void)
{
    uint32_t seed = 11;
    for (int k = 0; k < 3 * WINDOW; k++) {
        const double values[] = {3 * noise(&seed), 3 * noise(&seed)};
        step(values, (uint32_t)(k == 0 ? 3 : k % 7 == 0 ? 1 : k % 5 == 0 ? 2 : 3));
        assert_like_double();
    }
}

/* What has left the window has left nothing behind: sums are exact. */
static void an_outlier_leaves_with_its_update(void)
{
    static const double far[] = {900, -900}, near[] = {1, 0};
    step(far, ALL);
    for (int k = 0; k < 2 * WINDOW; k++) step(near, ALL);
    assert_like_double();
}

/* Held at 128 sigma */
static void an_innovation_is_held(void)
{
    static const double far[] = {900, -900};
    int64_t mean, correlation, bound, spread;
    step(far, ALL);
    ASSERT_OK(kq_consistency_innovation_q31(&recent, 0, TWO, &mean, &bound, &correlation, &spread));
    ASSERT_WITHIN(1e-6, 128, score_value(mean));
    ASSERT_WITHIN(0, 0, score_value(correlation));
    ASSERT_WITHIN(1e-6, 2, score_value(bound));
    ASSERT_WITHIN(0, 0, score_value(spread)); /* not one pair */
    ASSERT_OK(kq_consistency_nis_q31(&recent, TWO, &mean, &correlation, &bound));
    TEST_ASSERT_TRUE(score_value(mean) > 128 * 128);
}

static void an_update_that_takes_nothing_does_not_enter(void)
{
    ASSERT_OK(kq_consistency_watch_q31(&recent, &track, &radar.sensor, z, 0));
    ASSERT_OK(kq_update_subset_q31(&track, &radar.sensor, z, 0));
    ASSERT_OK(kq_consistency_record_q31(&recent, &track));
    TEST_ASSERT_EQUAL_INT(0, kq_consistency_count_q31(&recent));
}

/* A settled step judges no measurement: kq_nis_q31 is that of a step long ago. */
static void a_settled_step_does_not_enter(void)
{
    static const double values[] = {1, 0.5};
    const int32_t *words = words_of(values, 2, radar.measurement_format);
    KQ_FREEZE_Q31(lazy, 2, 2);
    memcpy(z, words, sizeof z);
    ASSERT_OK(kq_freeze_init_q31(&lazy, 10));
    ASSERT_OK(kq_attach_q31(&track, &lazy.attached));
    for (int t = 0; t < 60 && !kq_freeze_is_active_q31(&lazy); t++) {
        ASSERT_OK(kq_step_q31(&track, &motion.process, NULL, &radar.sensor, z));
    }
    TEST_ASSERT_EQUAL_INT(1, kq_freeze_is_active_q31(&lazy));
    ASSERT_OK(kq_consistency_watch_q31(&recent, &track, &radar.sensor, z, ALL));
    ASSERT_OK(kq_step_q31(&track, &motion.process, NULL, &radar.sensor, z));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_consistency_record_q31(&recent, &track));
    step(values, ALL); /* an update by itself, and after the predict by itself another one */
    step(values, ALL);
    TEST_ASSERT_EQUAL_INT(2, kq_consistency_count_q31(&recent));
}

static void clearing_forgets(void)
{
    static const double near[] = {1, 0};
    step(near, ALL);
    ASSERT_OK(kq_consistency_clear_q31(&recent));
    TEST_ASSERT_EQUAL_INT(0, kq_consistency_count_q31(&recent));
}

static void what_is_wrong_is_refused(void)
{
    static int32_t memory[KQ_CONSISTENCY_LEN_Q31(2, WINDOW)];
    const size_t length = COUNT(memory);
    int64_t *a = &out[0], *b = &out[1], *c = &out[2], *d = &out[4];
    ASSERT_REFUSED(KQ_ERR_NULL, kq_consistency_assign_q31(NULL, 2, WINDOW, memory, length));
    ASSERT_REFUSED(KQ_ERR_SIZE, kq_consistency_assign_q31(&recent, 0, WINDOW, memory, length));
    ASSERT_REFUSED(KQ_ERR_SIZE, kq_consistency_assign_q31(&recent, 2, 0, memory, length));
    ASSERT_REFUSED(KQ_ERR_SIZE, kq_consistency_assign_q31(&recent, 2, KQ_WINDOW_MAX + 1, memory, SIZE_MAX));
    ASSERT_REFUSED(KQ_ERR_SIZE, kq_consistency_assign_q31(&recent, 2, SIZE_MAX, memory, SIZE_MAX));
    ASSERT_REFUSED(KQ_ERR_MEMORY,
                   kq_consistency_assign_q31(&recent, 2, WINDOW, memory, length - 1));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_consistency_clear_q31(&blank));
    ASSERT_REFUSED(KQ_ERR_NULL,
                   kq_consistency_watch_q31(&recent, &track, &radar.sensor, NULL, ALL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY,
                   kq_consistency_watch_q31(&recent, &blank_filter, &radar.sensor, z, ALL));
    ASSERT_REFUSED(KQ_ERR_MISMATCH,
                   kq_consistency_watch_q31(&recent, &track, &compass.sensor, z, ALL));
    z[1] = INT32_MIN;
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_consistency_watch_q31(&recent, &track, &radar.sensor, z, ALL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_consistency_record_q31(&recent, &track));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_consistency_nis_q31(&recent, TWO, a, b, c));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_consistency_innovation_q31(&recent, 0, TWO, a, b, c, d));
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_consistency_nis_q31(&recent, -1, a, b, c));
    ASSERT_REFUSED(KQ_ERR_SIZE, kq_consistency_innovation_q31(&recent, 2, TWO, a, b, c, d));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_consistency_nis_q31(&recent, TWO, NULL, b, c));
    TEST_ASSERT_EQUAL_INT(0, kq_consistency_count_q31(NULL));
}

/* A quantile of any size */
static void bounds_of_any_quantile_are_within_the_numbers(void)
{
    static const double near[] = {1, 0};
    step(near, ALL);
    ASSERT_OK(kq_consistency_nis_q31(&recent, INT64_MAX, &out[0], &out[1], &out[2]));
    TEST_ASSERT_TRUE(out[1] == 0 && out[2] == INT64_C(1) << 61);
    ASSERT_OK(kq_consistency_nis_q31(&recent, 0, &out[0], &out[1], &out[2]));
    TEST_ASSERT_TRUE(out[1] == out[2]);
}

SUITE(consistency, set_up)
{
    RUN_TEST(the_statistics_are_those_in_double);
    RUN_TEST(an_outlier_leaves_with_its_update);
    RUN_TEST(an_innovation_is_held);
    RUN_TEST(an_update_that_takes_nothing_does_not_enter);
    RUN_TEST(a_settled_step_does_not_enter);
    RUN_TEST(clearing_forgets);
    RUN_TEST(what_is_wrong_is_refused);
    RUN_TEST(bounds_of_any_quantile_are_within_the_numbers);
}
