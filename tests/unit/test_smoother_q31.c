/* The history and the smoother in q31 (the textbook: test_smoother.c): words beyond all ranges, components without
   noise beside double, processes that have changed. */
#include "q31.h"
#include "reading.h"
#include "unchanged.h"

#define STEPS 12

static process_model three;
static sensor_model radar;
KQ_FILTER_Q31(track, 2);
KQ_HISTORY_Q31(tape, 2, 2, STEPS, STEPS);

static const double drive_range[] = {5};

static void set_up(void) { ASSERT_OK(kq_history_assign_q31(&tape, 2, tape_memory, COUNT(tape_memory))); }

/* A prior that stands for infinity, 2^400 words, is no growth: nothing of its recording ends. */
TEST(a_prior_that_stands_for_infinity_is_recorded)
{
    static const double large[] = {100, 100}, moving[] = {1, 0.5, 0, 1}, noise_of[] = {0.01, 0, 0, 0.01};
    static const double zero[2], unit[] = {1, 0, 0, 1}, none[4];
    static process_model process;
    static prior_model prior;
    put_process(&process, 2, 0, large, drive_range, moving, NULL, noise_of);
    put_sensor(&radar, 2, 2, large, large, unit, none);
    put_prior(&prior, 2, large, zero, unit);
    for (int i = 0; i < 2; i++) prior.root[KQ_TRIANGLE(2) + i] += 400;
    ASSERT_OK(kq_filter_init_q31(&track, &prior.table, NULL));
    ASSERT_OK(kq_attach_q31(&track, &tape.attached));
    const int32_t z[] = {1 << 20, 1 << 21};
    for (int t = 0; t < 5; t++) {
        ASSERT_OK(kq_predict_q31(&track, &process.process, NULL));
        ASSERT_OK(kq_update_q31(&track, &radar.sensor, z));
    }
    TEST_ASSERT_EQUAL_HEX(0, kq_events_q31(&track) & (KQ_EVENT_OVERFLOW | KQ_EVENT_HISTORY_FULL));
    ASSERT_OK(kq_smooth_q31(&tape));
}

/* ------------------------------------------------------- components without noise */

KQ_FILTER_Q31(sharp, 3);
KQ_HISTORY_Q31(sharp_tape, 3, 2, STEPS, STEPS);
PROCESS(sharp_process_f64, 3, 0);
SENSOR(sharp_sensor_f64, 3, 2);
FILTER(sharp_f64, 3);
HISTORY(sharp_tape_f64, 3, 2, STEPS, STEPS);

static void begin_sharp(uint32_t *seed)
{
    static const double large[] = {100, 100, 100}, none[4], zero[3];
    static const double wide[] = {9, 3, 0, 3, 16, 1, 0, 1, 25};
    static process_model process;
    static prior_model prior;
    static double transition[9], noise_of[9], measurement[6];
    for (int k = 0; k < 9; k++) transition[k] = noise(seed) / 2;
    for (int k = 0; k < 9; k++) noise_of[k] = k % 4 == 0 ? 0x1p-8 : 0;
    for (int k = 0; k < 6; k++) measurement[k] = floor(64 * noise(seed)) / 64;
    put_process(&process, 3, 0, large, drive_range, transition, NULL, noise_of);
    three = process;
    put_sensor(&radar, 3, 2, large, large, measurement, none);
    put_prior(&prior, 3, large, zero, wide);
    ASSERT_OK(kq_filter_init_q31(&sharp, &prior.table, NULL));
    ASSERT_OK(kq_attach_q31(&sharp, &sharp_tape.attached));
    ASSERT_OK(K(process_init)(&sharp_process_f64, transition, NULL, noise_of));
    ASSERT_OK(K(sensor_init)(&sharp_sensor_f64, measurement, none));
    ASSERT_OK(K(filter_init)(&sharp_f64, zero, wide));
    ASSERT_OK(K(attach)(&sharp_f64, &sharp_tape_f64.attached));
}

static void run_sharp(uint32_t *seed)
{
    for (int t = 0; t < STEPS; t++) {
        const double z[] = {floor(256 * noise(seed)) / 64, floor(256 * noise(seed)) / 64};
        if (t) {
            ASSERT_OK(kq_predict_q31(&sharp, &three.process, NULL));
            ASSERT_OK(K(predict)(&sharp_f64, &sharp_process_f64, NULL));
        }
        const int32_t *words = words_of(z, 2, radar.measurement_format);
        ASSERT_OK(kq_update_q31(&sharp, &radar.sensor, words));
        ASSERT_OK(K(update)(&sharp_f64, &sharp_sensor_f64, z));
    }
    ASSERT_OK(kq_smooth_q31(&sharp_tape));
    ASSERT_OK(K(smooth)(&sharp_tape_f64));
}

/* Rounding leaves something of the first where the second is taken: it turns nothing. */
TEST(two_components_without_noise_are_smoothed_as_in_double)
{
    uint32_t seed = 7;
    for (int k = 0; k < 100; k++) {
        double P[9];
        kq_scaled_q31 words[9];
        begin_sharp(&seed);
        run_sharp(&seed);
        for (size_t t = 0; t < STEPS; t++) {
            ASSERT_OK(K(covariance)(SMOOTHED(&sharp_tape_f64, t), P));
            ASSERT_OK(kq_covariance_q31(SMOOTHED_Q31(&sharp_tape, t), words));
            for (int i = 0; i < 3; i++) {
                const double x = kq_mean_q31(SMOOTHED_Q31(&sharp_tape, t), i);
                const double word = ldexp(1, -three.state_format[i].fraction);
                ASSERT_WITHIN(1e-5, K(mean)(SMOOTHED(&sharp_tape_f64, t), i), x * word);
                ASSERT_WITHIN(1e-6, P[4 * i],
                              value_of(words[4 * i], 2 * three.state_format[i].fraction));
            }
        }
    }
}

SUITE(smoother_q31, set_up)
#include "smoother_q31.tests"
