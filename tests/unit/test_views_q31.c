/* Views in q31 know their formats: what can be called of a filter can be called of each, also when the filter that
   was smoothed is gone. */
#include "q31.h"

static process_model motion;
static sensor_model radar;
static prior_model beginning;
static kq_filter_q31 view;
KQ_FILTER_Q31(track, 2);
KQ_FILTER_Q31(copy, 2);
KQ_FILTER_Q31(ahead, 2);
KQ_HISTORY_Q31(tape, 2, 1, 10, 0);
KQ_LAG_Q31(past, 2, 1, 3);
KQ_INSTANT_Q31(launch, 2, 1);
KQ_DIFFUSE_Q31(unknown, 2, 4);

static const double range[] = {100, 10}, measured_range[] = {100};
static const double A[] = {1, 0.5, 0, 1}, Q[] = {0.25, 0.125, 0.125, 0.5}, H[] = {1, 0}, R[] = {0.5};
static const double x0[] = {1, -2}, P0[] = {2, 0.5, 0.5, 1};
static const int32_t z[] = {1 << 22};

static void set_up(void)
{
    put_process(&motion, 2, 0, range, NULL, A, NULL, Q);
    put_sensor(&radar, 2, 1, range, measured_range, H, R);
    put_prior(&beginning, 2, range, x0, P0);
    ASSERT_OK(kq_filter_init_q31(&track, &beginning.table, NULL));
}

static void run(int steps)
{
    ASSERT_OK(kq_update_q31(&track, &radar.sensor, z));
    for (int t = 0; t < steps; t++) ASSERT_OK(kq_step_q31(&track, &motion.process, NULL, &radar.sensor, z));
}

/* What moves no filter is possible of the view, and all is of a copy, with the same raw values. */
static void assert_usable(void)
{
    int32_t of_view[1], of_copy[1];
    kq_scaled_q31 S[1], K[2];
    ASSERT_OK(kq_forecast_q31(&view, &motion.process, NULL, 3, &ahead));
    ASSERT_OK(kq_measurement_q31(&view, &radar.sensor, of_view, S));
    ASSERT_OK(kq_gain_q31(&view, &radar.sensor, K));
    ASSERT_OK(kq_filter_copy_q31(&copy, &view));
    ASSERT_OK(kq_measurement_q31(&copy, &radar.sensor, of_copy, NULL));
    TEST_ASSERT_EQUAL_INT32(of_copy[0], of_view[0]);
    ASSERT_OK(kq_innovation_q31(&view, &radar.sensor, z, of_view));
    ASSERT_OK(kq_innovation_q31(&copy, &radar.sensor, z, of_copy));
    TEST_ASSERT_EQUAL_INT32(of_copy[0], of_view[0]);
    for (int t = 0; t < 3; t++) ASSERT_OK(kq_predict_q31(&copy, &motion.process, NULL));
    for (int i = 0; i < 2; i++) {
        TEST_ASSERT_EQUAL_INT32(kq_mean_q31(&copy, i), kq_mean_q31(&ahead, i));
        TEST_ASSERT_EQUAL_INT32(kq_sigma_q31(&copy, i), kq_sigma_q31(&ahead, i));
    }
    ASSERT_OK(kq_update_q31(&copy, &radar.sensor, z));
}

static void a_smoothed_step(void)
{
    ASSERT_OK(kq_attach_q31(&track, &tape.attached));
    run(5);
    ASSERT_OK(kq_smooth_q31(&tape));
    ASSERT_OK(kq_detach_q31(&tape.attached));
    ASSERT_OK(kq_filter_assign_q31(&track, 2, track_memory, KQ_FILTER_LEN_Q31(2))); /* as good as gone */
    for (size_t t = 0; t < kq_history_steps_q31(&tape); t++) {
        ASSERT_OK(kq_smoothed_q31(&tape, t, &view));
        assert_usable();
    }
}

static void a_lagged_step(void)
{
    ASSERT_OK(kq_attach_q31(&track, &past.attached));
    run(5);
    for (size_t k = 0; k <= 3; k++) {
        ASSERT_OK(kq_lagged_q31(&past, k, &view));
        assert_usable();
    }
}

static void an_instant(void)
{
    ASSERT_OK(kq_attach_q31(&track, &launch.attached));
    run(5);
    ASSERT_OK(kq_instant_smooth_q31(&launch, &view));
    assert_usable();
}

static void a_step_before_and_after_the_start_was_determined(void)
{
    ASSERT_OK(kq_diffuse_init_q31(&unknown, &track, &beginning.table, 3, NULL));
    ASSERT_OK(kq_attach_q31(&track, &tape.attached));
    for (int t = 0; t < 5; t++) {
        ASSERT_OK(kq_update_q31(&track, &radar.sensor, z));
        ASSERT_OK(kq_predict_q31(&track, &motion.process, NULL));
    }
    ASSERT_OK(kq_diffuse_smooth_q31(&unknown));
    for (size_t t = 0; t < 5; t++) {
        ASSERT_OK(kq_diffuse_smoothed_q31(&unknown, t, &view));
        assert_usable();
    }
}

static void the_filter_of_a_start_is_no_view(void)
{
    ASSERT_OK(kq_diffuse_init_q31(&unknown, &track, &beginning.table, 0, NULL));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_MISMATCH, kq_diffuse_smoothed_q31(&unknown, 0, &track));
    run(1);
}

static void a_steady_filter_takes_no_innovations(void)
{
    static kq_sensor_q31 innovations;
    KQ_STEADY_Q31(steady, 2, 1);
    const kq_scaled_q31 gain[2] = {{1 << 30, -30}, {1 << 30, -30}};
    const int32_t at[] = {0, 0};
    ASSERT_OK(kq_sensor_init_extended_q31(&innovations, &radar.table, NULL));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_MISMATCH,
                          kq_steady_init_q31(&steady, &motion.process, &innovations, at, gain, 1));
    ASSERT_OK(kq_steady_init_q31(&steady, &motion.process, &radar.sensor, at, gain, 1));
}

SUITE(views, set_up)
{
    RUN_TEST(a_smoothed_step);
    RUN_TEST(a_lagged_step);
    RUN_TEST(an_instant);
    RUN_TEST(a_step_before_and_after_the_start_was_determined);
    RUN_TEST(the_filter_of_a_start_is_no_view);
    RUN_TEST(a_steady_filter_takes_no_innovations);
}
