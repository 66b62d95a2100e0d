/* Steps of nonlinear models in q31: Jacobians that no mean could go through, and what is refused (test_linearised.c). */
#include "q31.h"
#include "unchanged.h"

#define STEPS 20

static process_model motion;
static sensor_model radar;
static kq_sensor_q31 differs; /* the radar, which takes innovations */
static prior_model start;
static kq_process_q31 blank_process;
KQ_FILTER_Q31(track, 2);
KQ_HISTORY_Q31(tape, 2, 2, STEPS, STEPS);
KQ_JACOBIANS_Q31(jacobians, tape, 2, STEPS, 1);
KQ_LAG_Q31(past, 2, 2, STEPS);

PROCESS(motion_f64, 2, 0);
SENSOR(radar_f64, 2, 2);
FILTER(track_f64, 2);
HISTORY(tape_f64, 2, 2, STEPS, STEPS);
JACOBIANS(jacobians_f64, tape_f64, 2, STEPS, 1);

static const double range[] = {100, 20}, innovation_range[] = {100, 400};
static const double A[] = {1, 0.125, 0, 1}, Q[] = {0.01, 0, 0, 0.04}, H[] = {1, 0, 0, 1};
static const double R[] = {0.25, 0.0625, 0.0625, 0.5}, x0[] = {8, -3}, P0[] = {2, 0.5, 0.5, 1};
static kq_scaled_q31 A_words[4], H_words[4];
static double H_now[4];

#define LIKE 0x1p-20

static void set_up(void)
{
    put_process(&motion, 2, 0, range, NULL, A, NULL, Q);
    put_sensor(&radar, 2, 2, range, innovation_range, H, R);
    ASSERT_OK(kq_sensor_init_extended_q31(&differs, &radar.table, NULL));
    put_prior(&start, 2, range, x0, P0);
    ASSERT_OK(kq_filter_init_q31(&track, &start.table, NULL));
    ASSERT_OK(K(process_init)(&motion_f64, A, NULL, Q));
    ASSERT_OK(K(sensor_init_extended)(&radar_f64, H, R));
    ASSERT_OK(K(filter_init)(&track_f64, x0, P0));
    watch_nothing();
    WATCH(track), WATCH(track_memory), WATCH(motion.process), WATCH(differs), WATCH(tape), WATCH(tape_memory);
    WATCH(jacobians), WATCH(jacobians_memory);
}

/* h(x) = (x, x v / 4) */
static void update_both(int step)
{
    const double x = K(mean)(&track_f64, 0), v = K(mean)(&track_f64, 1);
    const double e[] = {8 - 0.3 * step + 0.25 * (step * 7 % 5 - 2) - x, 0.5 * (step * 11 % 7 - 3)};
    H_now[0] = 1, H_now[1] = 0, H_now[2] = v / 4, H_now[3] = x / 4;
    ASSERT_OK(K(sensor_change_measurement)(&radar_f64, H_now));
    ASSERT_OK(K(update)(&track_f64, &radar_f64, e));
    ASSERT_OK(kq_matrix_prepare_q31(H_words, H_now, 2, 2, radar.measurement_format, radar.state_format));
    ASSERT_OK(kq_sensor_change_measurement_q31(&differs, H_words, NULL));
    ASSERT_OK(kq_update_q31(&track, &differs, words_of(e, 2, radar.measurement_format)));
}

static double mean_of(int32_t word, int i) { return ldexp(word, -start.state_format[i].fraction); }

/* ------------------------------------------------------------------ an A that no mean could go through */

static const double steep[] = {25.5, 0.5, -40, 3};

static void prepare_steep(void)
{
    ASSERT_OK(kq_matrix_prepare_q31(A_words, steep, 2, 2, motion.state_format, motion.state_format));
}

TEST(a_steep_jacobian_moves_the_root_alone)
{
    const double d[] = {-20, 4};
    kq_range_error_q31 range_error = {KQ_STATE, 7, 7};
    prepare_steep();
    ASSERT_REFUSED(KQ_ERR_COEFFICIENT, kq_process_change_transition_q31(&motion.process, A_words, NULL));
    ASSERT_OK(kq_process_change_jacobian_q31(&motion.process, A_words, &range_error));
    TEST_ASSERT_EQUAL_INT(KQ_NO_RANGE_ERROR, range_error.quantity);
    ASSERT_OK(kq_attach_q31(&track, &jacobians.attached));
    ASSERT_OK(K(attach)(&track_f64, &jacobians_f64.attached));
    ASSERT_OK(kq_predict_extended_q31(&track, &motion.process, words_of(d, 2, motion.state_format)));
    ASSERT_OK(K(process_change_transition)(&motion_f64, steep));
    ASSERT_OK(K(predict_extended)(&track_f64, &motion_f64, d));
    ASSERT_LIKE(&track_f64, &track, LIKE);
    update_both(3);
    ASSERT_OK(kq_smooth_q31(&tape));
    ASSERT_OK(K(smooth)(&tape_f64));
    ASSERT_WITHIN(LIKE * 16, K(mean)(SMOOTHED(&tape_f64, 0), 0), mean_of(kq_mean_q31(SMOOTHED_Q31(&tape, 0), 0), 0));
}

/* ... and nothing else takes its process, until it is initialised again. */
TEST(a_process_of_a_jacobian_is_for_linearised_predicts_alone)
{
    static const int32_t d[2];
    kq_scaled_q31 ordinary[4];
    memcpy(ordinary, motion.transition, sizeof ordinary);
    prepare_steep();
    ASSERT_OK(kq_process_change_jacobian_q31(&motion.process, A_words, NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_predict_q31(&track, &motion.process, NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_process_change_transition_q31(&motion.process, ordinary, NULL));
    ASSERT_OK(kq_attach_q31(&track, &past.attached));
    ASSERT_REFUSED(KQ_ERR_COEFFICIENT, kq_predict_extended_q31(&track, &motion.process, d));
    ASSERT_OK(kq_process_change_jacobian_q31(&motion.process, ordinary, NULL));
    ASSERT_OK(kq_predict_extended_q31(&track, &motion.process, d));
    ASSERT_OK(kq_detach_q31(&past.attached));
    ASSERT_OK(kq_process_init_q31(&motion.process, &motion.table, NULL));
    ASSERT_OK(kq_predict_q31(&track, &motion.process, NULL));
}

/* A tape that refers to it has lost its process, be its A the same. */
TEST(a_process_of_a_jacobian_is_not_what_a_tape_has_recorded)
{
    const kq_scaled_q31 *same = motion.transition;
    for (int keeps = 0; keeps < 2; keeps++) {
        set_up();
        if (keeps) ASSERT_OK(kq_attach_q31(&track, &jacobians.attached));
        else ASSERT_OK(kq_attach_q31(&track, &tape.attached));
        ASSERT_OK(kq_predict_q31(&track, &motion.process, NULL));
        ASSERT_OK(kq_process_change_jacobian_q31(&motion.process, same, NULL));
        if (keeps) ASSERT_OK(kq_predict_extended_q31(&track, &motion.process, (const int32_t[]){0, 0}));
        TEST_ASSERT_EQUAL_INT(KQ_ERR_CHANGED, kq_smooth_q31(&tape));
        ASSERT_OK(kq_process_init_q31(&motion.process, &motion.table, NULL));
        ASSERT_OK(kq_smooth_q31(&tape));
    }
}

/* ------------------------------------------------------------------ refusals */

TEST(a_range_error_names_the_row)
{
    static const double large[] = {1, 0, 90, 20};
    kq_range_error_q31 range_error = {KQ_NO_RANGE_ERROR, 0, 0};
    ASSERT_OK(kq_matrix_prepare_q31(H_words, large, 2, 2, radar.measurement_format, radar.state_format));
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_sensor_change_measurement_q31(&radar.sensor, H_words, &range_error));
    TEST_ASSERT_EQUAL_INT(KQ_MEASUREMENT, range_error.quantity);
    TEST_ASSERT_EQUAL_INT(1, range_error.component);
    TEST_ASSERT_TRUE(range_error.bits > 0);
    H_words[3].mantissa = 1;
    ASSERT_REFUSED(KQ_ERR_COEFFICIENT, kq_sensor_change_measurement_q31(&radar.sensor, H_words, &range_error));
    TEST_ASSERT_EQUAL_INT(1, range_error.component);
    TEST_ASSERT_EQUAL_INT(0, range_error.bits);
    prepare_steep();
    A_words[2].mantissa = 1;
    ASSERT_REFUSED(KQ_ERR_COEFFICIENT, kq_process_change_jacobian_q31(&motion.process, A_words, &range_error));
    TEST_ASSERT_EQUAL_INT(KQ_STATE, range_error.quantity);
    TEST_ASSERT_EQUAL_INT(1, range_error.component);
    ASSERT_REFUSED(KQ_ERR_COEFFICIENT, kq_process_change_jacobian_q31(&motion.process, A_words, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_process_change_jacobian_q31(NULL, A_words, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_process_change_jacobian_q31(&motion.process, NULL, NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_process_change_jacobian_q31(&blank_process, A_words, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_sensor_change_measurement_q31(NULL, H_words, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_sensor_change_measurement_q31(&radar.sensor, NULL, NULL));
}

TEST(an_innovation_beyond_its_range_is_refused)
{
    kq_loss_q31 huber = {.kind = &kq_loss_huber_q31, .parameter = {1 << 30, -30}};
    int32_t d[] = {1, 2}, e[] = {0, radar.measurement_format[1].range};
    ASSERT_OK(kq_update_q31(&track, &differs, e));
    ASSERT_OK(kq_filter_init_q31(&track, &start.table, NULL));
    e[1]++;
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_update_q31(&track, &differs, e));
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_update_robust_q31(&track, &differs, e, 3, &huber));
    ASSERT_OK(kq_update_subset_q31(&track, &differs, e, 1));
    ASSERT_OK(kq_attach_q31(&track, &tape.attached));
    ASSERT_REFUSED(KQ_ERR_RECORDING, kq_predict_extended_q31(&track, &motion.process, d));
}

TEST(a_mean_is_held_at_its_word)
{
    static const int32_t far[] = {INT32_MAX, -INT32_MAX};
    ASSERT_OK(kq_move_q31(&track, far));
    TEST_ASSERT_EQUAL_UINT(KQ_EVENT_SATURATED, kq_events_q31(&track));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, kq_mean_q31(&track, 0));
    TEST_ASSERT_EQUAL_INT32(-INT32_MAX, kq_mean_q31(&track, 1));
}

SUITE(extended_q31, set_up)
#include "extended_q31.tests"
