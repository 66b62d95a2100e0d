/* The history and the smoother in q31: against those in double, and what they refuse. */
#include "q31.h"
#include "reading.h"
#include "unchanged.h"

#define STEPS 12

static process_model motion, other, three;
static sensor_model radar;
static prior_model start, start3;
static kq_process_q31 blank_process;
KQ_FILTER_Q31(track, 2);
KQ_FILTER_Q31(twin, 2);
static kq_filter_q31 view;
KQ_FILTER_Q31(blank, 2);
KQ_FILTER_Q31(track3, 3);
KQ_HISTORY_Q31(tape, 2, 2, STEPS, STEPS);
KQ_HISTORY_Q31(unused, 2, 2, 2, 0);
KQ_HISTORY_Q31(tape3, 3, 2, 2, 0);

/* the same in double */
PROCESS(motion_f64, 2, 1);
PROCESS(other_f64, 2, 1);
SENSOR(radar_f64, 2, 2);
FILTER(track_f64, 2);
HISTORY(tape_f64, 2, 2, STEPS, STEPS);

static const double range[] = {100, 10, 10}, drive_range[] = {5}, measured_range[] = {100, 100};
static const double A[] = {1, 0.5, -0.25, 0.75}, B[] = {0.125, 0.5};
static const double A2[] = {0.5, 0.25, 0, 1}, Q2[] = {1, 0, 0, 0};
static const double Q[] = {0.25, 0.125, 0.125, 0.5};
static const double H[] = {1, 0, 0.5, 1}, R[] = {0.5, 0.25, 0.25, 1};
static const double x0[] = {1, -2, 0}, P0[] = {2, 0.5, 0.5, 1};
static const double identity3[] = {1, 0, 0, 0, 1, 0, 0, 0, 1};

#define LIKE 0x1p-22

static kq_scaled_q31 out[4], more[4], vector[2];

static void set_up(void)
{
    put_process(&motion, 2, 1, range, drive_range, A, B, Q);
    put_process(&other, 2, 1, range, drive_range, A2, B, Q2);
    put_process(&three, 3, 0, range, drive_range, identity3, NULL, identity3);
    put_sensor(&radar, 2, 2, range, measured_range, H, R);
    put_prior(&start, 2, range, x0, P0);
    put_prior(&start3, 3, range, x0, identity3);
    ASSERT_OK(kq_filter_init_q31(&track, &start.table, NULL));
    ASSERT_OK(kq_filter_init_q31(&twin, &start.table, NULL));
    ASSERT_OK(kq_filter_init_q31(&track3, &start3.table, NULL));
    ASSERT_OK(kq_history_assign_q31(&tape, 2, tape_memory, COUNT(tape_memory)));
    ASSERT_OK(kq_attach_q31(&track, &tape.attached));
    ASSERT_OK(K(process_init)(&motion_f64, A, B, Q));
    ASSERT_OK(K(process_init)(&other_f64, A2, B, Q2));
    ASSERT_OK(K(sensor_init)(&radar_f64, H, R));
    ASSERT_OK(K(filter_init)(&track_f64, x0, P0));
    ASSERT_OK(K(attach)(&track_f64, &tape_f64.attached));
    watch_nothing();
    WATCH(track), WATCH(track_memory), WATCH(blank), WATCH(blank_memory), WATCH(tape);
    WATCH(out), WATCH(more), WATCH(vector);
}

/* ------------------------------------------------------------------------------- a run */

static void measure(kq_filter_q31 *f, int step, int in_double)
{
    const double z[] = {3 * sin(step), 0.5 - 0.25 * step};
    const uint32_t present = (uint32_t)step % 4;
    const int32_t *words = words_of(z, 2, radar.measurement_format);
    ASSERT_OK(kq_update_subset_q31(f, &radar.sensor, words, present));
    if (in_double) ASSERT_OK(K(update_subset)(&track_f64, &radar_f64, z, present));
}

/* Both filters through all steps; the processes take turns, or not */
static void run(kq_filter_q31 *f, int in_turn, int in_double)
{
    for (int step = 0; step < STEPS; step++) {
        const double u[] = {cos(step)};
        const int second = in_turn && step % 3 == 0;
        if (step) {
            const int32_t *words = words_of(u, 1, motion.control_format);
            ASSERT_OK(kq_predict_q31(f, second ? &other.process : &motion.process, words));
            if (in_double) {
                ASSERT_OK(K(predict)(&track_f64, second ? &other_f64 : &motion_f64, u));
            }
        }
        measure(f, step + 1, in_double);
    }
}

static double smoothed_value(size_t t, int i)
{
    const double words =
        kq_mean_q31(SMOOTHED_Q31(&tape, t), i) + ldexp(kq_mean_low_q31(SMOOTHED_Q31(&tape, t), i), -24);
    return ldexp(words, -start.state_format[i].fraction);
}

static int both_fractions(int k)
{
    return start.state_format[k / 2].fraction + start.state_format[k % 2].fraction;
}

static void assert_means(size_t t)
{
    for (int i = 0; i < 2; i++) {
        const double expected = K(mean)(SMOOTHED(&tape_f64, t), i);
        ASSERT_WITHIN(LIKE * (1 + fabs(expected)), expected, smoothed_value(t, i));
    }
}

static void assert_covariance(size_t t)
{
    double P[4];
    ASSERT_OK(K(covariance)(SMOOTHED(&tape_f64, t), P));
    ASSERT_OK(kq_covariance_q31(SMOOTHED_Q31(&tape, t), out));
    for (int k = 0; k < 4; k++) {
        ASSERT_WITHIN(2 * LIKE, P[k], value_of(out[k], both_fractions(k)));
    }
    for (int i = 0; i < 2; i++) {
        const double sigma = ldexp(sqrt(P[3 * i]), start.state_format[i].fraction);
        ASSERT_WITHIN(1 + sigma * LIKE, sigma, kq_sigma_q31(SMOOTHED_Q31(&tape, t), i));
    }
}

static void smoothing_is_that_in_double(void)
{
    for (int in_turn = 0; in_turn <= 1; in_turn++) {
        set_up();
        run(&track, in_turn, 1);
        TEST_ASSERT_EQUAL_INT(STEPS, kq_history_steps_q31(&tape));
        ASSERT_OK(kq_smooth_q31(&tape));
        ASSERT_OK(K(smooth)(&tape_f64));
        for (size_t t = 0; t < STEPS; t++) assert_means(t), assert_covariance(t);
        TEST_ASSERT_EQUAL_HEX(0, kq_events_q31(&track));
    }
}

/* A prior that stands for infinity, 2^400 words, is no growth: nothing of its recording ends. */
static void a_prior_that_stands_for_infinity_is_recorded(void)
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
static void two_components_without_noise_are_smoothed_as_in_double(void)
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

static void states_only_gives_the_means(void)
{
    run(&track, 1, 1);
    ASSERT_OK(kq_smooth_states_q31(&tape));
    ASSERT_OK(K(smooth)(&tape_f64));
    for (size_t t = 0; t < STEPS; t++) {
        assert_means(t);
        TEST_ASSERT_EQUAL_INT32(KQ_NOT_A_VALUE_Q31, kq_sigma_q31(SMOOTHED_Q31(&tape, t), 0));
        ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_covariance_q31(SMOOTHED_Q31(&tape, t), out));
    }
}

static void assert_noises(void)
{
    kq_scaled_q31 mean, variance;
    double expected, spread;
    int k = 0;
    for (; K(smoothed_measurement_noise)(&tape_f64, k, &expected, &spread) == KQ_OK; k++) {
        ASSERT_OK(kq_smoothed_measurement_noise_q31(&tape, k, &mean, &variance));
        ASSERT_WITHIN(LIKE * (1 + fabs(expected)), expected, value_of(mean, 0));
        ASSERT_WITHIN(LIKE, spread, value_of(variance, 0));
    }
    ASSERT_REFUSED(KQ_ERR_SIZE, kq_smoothed_measurement_noise_q31(&tape, k, &mean, &variance));
    ASSERT_REFUSED(KQ_ERR_SIZE, kq_smoothed_measurement_noise_q31(&tape, -1, &mean, &variance));
}

static void a_step_gives_extras(void)
{
    double lag[4], mean[2], covariance[4];
    const kq_smooth_extras_q31 extras = {out, vector, more};
    const K(smooth_extras) extras_f64 = {lag, mean, covariance};
    run(&track, 1, 1);
    for (size_t t = STEPS; t-- > 0;) {
        ASSERT_OK(kq_smooth_step_q31(&tape, NULL, &extras));
        ASSERT_OK(K(smooth_step)(&tape_f64, NULL, &extras_f64));
        for (int k = 0; k < 4 && t < STEPS - 1; k++) {
            ASSERT_WITHIN(2 * LIKE, lag[k], value_of(out[k], both_fractions(k)));
            ASSERT_WITHIN(2 * LIKE, covariance[k], value_of(more[k], both_fractions(k)));
        }
        for (int i = 0; i < 2 && t < STEPS - 1; i++) {
            ASSERT_WITHIN(LIKE, mean[i], value_of(vector[i], start.state_format[i].fraction));
        }
        assert_noises();
        assert_means(t), assert_covariance(t);
        if (t) TEST_ASSERT_EQUAL_INT32(KQ_NOT_A_VALUE_Q31, kq_mean_q31(SMOOTHED_Q31(&tape, t - 1), 0));
    }
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, kq_smooth_step_q31(&tape, NULL, NULL));
}

static void the_last_step_is_the_filter_s(void)
{
    run(&track, 0, 0);
    ASSERT_OK(kq_smooth_q31(&tape));
    for (int i = 0; i < 2; i++) {
        TEST_ASSERT_EQUAL_INT32(kq_mean_q31(&track, i), kq_mean_q31(SMOOTHED_Q31(&tape, STEPS - 1), i));
        TEST_ASSERT_EQUAL_INT32(kq_mean_low_q31(&track, i),
                                kq_mean_low_q31(SMOOTHED_Q31(&tape, STEPS - 1), i));
    }
}

/* Recording and smoothing leave the filter as it is without them. */
static void the_filter_is_the_same_with_a_history(void)
{
    run(&track, 1, 0);
    run(&twin, 1, 0);
    ASSERT_SAME_Q31(&twin, &track);
    ASSERT_OK(kq_smooth_q31(&tape));
    ASSERT_SAME_Q31(&twin, &track);
    run(&track, 1, 0);
    run(&twin, 1, 0);
    ASSERT_SAME_Q31(&twin, &track);
}

/* The same constant, seen through no process noise: known as at the end, at every step */
static void a_constant_smoothed_is_the_final_mean(void)
{
    static const double still[] = {1, 0, 0, 1}, none[4];
    put_process(&motion, 2, 0, range, drive_range, still, NULL, none);
    for (int step = 0; step < STEPS; step++) {
        if (step) ASSERT_OK(kq_predict_q31(&track, &motion.process, NULL));
        measure(&track, 3, 0);
    }
    ASSERT_OK(kq_smooth_q31(&tape));
    for (size_t t = 0; t < STEPS; t++) {
        for (int i = 0; i < 2; i++) {
            ASSERT_WITHIN(LIKE, mean_value(&track, i), smoothed_value(t, i));
            ASSERT_WITHIN(2 + ldexp(LIKE, start.state_format[i].fraction), kq_sigma_q31(&track, i),
                          kq_sigma_q31(SMOOTHED_Q31(&tape, t), i));
        }
    }
}

/* ---------------------------------------------------------------------------- refusals */

static void assign_refuses(void)
{
    static const int bad[] = {0, -1, 17, 258, -254, INT_MAX, INT_MIN};
    const size_t least = KQ_HISTORY_LEN_Q31(2, 0, 1, 0);
    ASSERT_REFUSED(KQ_ERR_NULL, kq_history_assign_q31(NULL, 2, tape_memory, 1000));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_history_assign_q31(&tape, 2, NULL, 1000));
    for (int k = 0; k < COUNT(bad); k++) {
        ASSERT_REFUSED(KQ_ERR_SIZE, kq_history_assign_q31(&tape, bad[k], tape_memory, SIZE_MAX));
    }
    ASSERT_REFUSED(KQ_ERR_MEMORY, kq_history_assign_q31(&tape, 2, tape_memory, least - 1));
    ASSERT_OK(kq_history_assign_q31(&tape, 2, tape_memory, least));
}

static void attach_refuses(void)
{
    kq_history_q31 bare;
    memset(&bare, 0, sizeof bare);
    WATCH(bare);
    ASSERT_REFUSED(KQ_ERR_NULL, kq_attach_q31(&track, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_attach_q31(NULL, &tape.attached));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_attach_q31(&blank, &tape.attached));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_attach_q31(&track, &bare.attached));
    bare.attached.hooks = tape.attached.hooks; /* without sizes */
    ASSERT_REFUSED_SIZE_OR_MEMORY(kq_attach_q31(&track, &bare.attached));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, kq_attach_q31(&track, &tape3.attached));
    TEST_ASSERT_EQUAL_INT(0, kq_history_steps_q31(NULL));
    TEST_ASSERT_EQUAL_INT(0, kq_history_steps_q31(&bare));
}

static void smooth_refuses(void)
{
    ASSERT_REFUSED(KQ_ERR_NULL, kq_smooth_q31(NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_smooth_states_q31(NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_smooth_step_q31(NULL, NULL, NULL));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, kq_smooth_q31(&unused));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, kq_smooth_states_q31(&unused));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, kq_smooth_step_q31(&unused, NULL, NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_smooth_step_q31(&tape, &blank_process, NULL));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, kq_smooth_step_q31(&tape, &three.process, NULL));
    ASSERT_OK(kq_smooth_q31(&tape));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, kq_smooth_q31(&tape));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, kq_smooth_states_q31(&tape));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, kq_smooth_step_q31(&tape, NULL, NULL));
}

static void a_full_history_is_an_event_and_refused(void)
{
    run(&track, 0, 0);
    run(&twin, 0, 0);
    for (int k = 0; k < 100 && !kq_events_q31(&track); k++) {
        ASSERT_OK(kq_predict_q31(&track, &motion.process, NULL));
        ASSERT_OK(kq_predict_q31(&twin, &motion.process, NULL));
    }
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_HISTORY_FULL, kq_events_q31(&track));
    TEST_ASSERT_EQUAL_MEMORY(twin_memory, track_memory, sizeof track_memory);
    ASSERT_REFUSED(KQ_ERR_HISTORY_FULL, kq_smooth_q31(&tape));
    ASSERT_REFUSED(KQ_ERR_HISTORY_FULL, kq_smooth_states_q31(&tape));
    ASSERT_REFUSED(KQ_ERR_HISTORY_FULL, kq_smooth_step_q31(&tape, NULL, NULL));
}

/* ------------------------------------------------------------------- filter and history */

static void a_history_belongs_to_one_filter(void)
{
    ASSERT_REFUSED(KQ_ERR_RECORDING, kq_attach_q31(&twin, &tape.attached));
    ASSERT_OK(kq_detach_q31(&tape.attached));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, kq_smooth_q31(&tape));
    ASSERT_OK(kq_predict_q31(&track, &motion.process, NULL));
    TEST_ASSERT_EQUAL_HEX(0, kq_events_q31(&track));
    ASSERT_OK(kq_attach_q31(&twin, &tape.attached));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, kq_detach_q31(NULL));
}

/* It may be gone. */
static void init_does_not_look_at_the_history(void)
{
    watch_nothing();
    WATCH(tape), WATCH(tape_memory);
    ASSERT_OK_UNCHANGED(kq_filter_init_q31(&track, &start.table, NULL));
    ASSERT_OK_UNCHANGED(kq_predict_q31(&track, &motion.process, NULL));
}

/* ------------------------------------------------------------------- changed processes */

static void assert_changed(void)
{
    ASSERT_REFUSED(KQ_ERR_CHANGED, kq_smooth_q31(&tape));
    ASSERT_REFUSED(KQ_ERR_CHANGED, kq_smooth_states_q31(&tape));
}

/* Refused until it is what it was. */
static void a_process_changed_after_the_recording_is_refused(void)
{
    kq_scaled_q31 otherwise[4];
    int32_t root[KQ_ROOT_LEN_Q31(2)];
    static const kq_scaled_q31 four = {INT32_C(1) << 30, -28};
    run(&track, 1, 0);
    for (int k = 0; k < 4; k++) {
        memcpy(otherwise, motion.transition, sizeof otherwise);
        otherwise[k].mantissa = -otherwise[k].mantissa;
        ASSERT_OK(kq_process_change_transition_q31(&motion.process, otherwise, NULL));
        assert_changed();
        memcpy(otherwise, motion.transition, sizeof otherwise);
        otherwise[k].exponent--;
        ASSERT_OK(kq_process_change_transition_q31(&motion.process, otherwise, NULL));
        assert_changed();
    }
    ASSERT_OK(kq_process_init_q31(&motion.process, &other.table, NULL));
    assert_changed();
    ASSERT_OK(kq_process_scale_noise_q31(&motion.process, &other.process, root, four));
    assert_changed();
    ASSERT_OK(kq_process_init_q31(&motion.process, &motion.table, NULL));
    ASSERT_OK(kq_smooth_q31(&tape));
}

/* In place, by a copy of A that is turned a little at every step */
static void a_process_changed_at_every_step_is_smoothed_by_step(void)
{
    static kq_scaled_q31 turned[STEPS][4];
    for (int step = 0; step < STEPS; step++) {
        memcpy(turned[step], motion.transition, sizeof turned[step]);
        turned[step][1].mantissa += 1000000 * step;
        if (step) {
            ASSERT_OK(kq_process_change_transition_q31(&motion.process, turned[step], NULL));
            ASSERT_OK(kq_predict_q31(&track, &motion.process, NULL));
        }
        measure(&track, step, 0);
    }
    assert_changed();
    ASSERT_OK(kq_smooth_step_q31(&tape, NULL, NULL));
    ASSERT_REFUSED(KQ_ERR_CHANGED, kq_smooth_step_q31(&tape, NULL, NULL));
    for (int step = STEPS - 1; step > 0; step--) {
        ASSERT_OK(kq_process_change_transition_q31(&motion.process, turned[step], NULL));
        ASSERT_OK(kq_smooth_step_q31(&tape, &motion.process, NULL));
    }
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, kq_smooth_q31(&tape));
}

static void a_copy_is_a_filter_of_its_own(void)
{
    run(&track, 0, 0);
    watch_nothing();
    WATCH(track), WATCH(track_memory), WATCH(tape), WATCH(tape_memory);
    ASSERT_OK_UNCHANGED(kq_filter_copy_q31(&twin, &track));
    ASSERT_SAME_BITS(track_memory, twin_memory);
    TEST_ASSERT_TRUE(kq_log_likelihood_q31(&track) == kq_log_likelihood_q31(&twin));
    ASSERT_OK_UNCHANGED(kq_predict_q31(&twin, &motion.process, NULL));
    ASSERT_OK(kq_detach_q31(&tape.attached));
    ASSERT_OK(kq_predict_q31(&track, &motion.process, NULL));
    ASSERT_SAME_BITS(track_memory, twin_memory);
    TEST_ASSERT_EQUAL_INT(KQ_ERR_MISMATCH, kq_filter_copy_q31(&track3, &track));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NOT_READY, kq_filter_copy_q31(&track, &blank));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, kq_filter_copy_q31(NULL, &track));
}

static void smoothed_results_refuse(void)
{
    kq_scaled_q31 mean, variance;
    ASSERT_REFUSED(KQ_ERR_NULL, kq_smoothed_q31(NULL, 0, &view));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_smoothed_q31(&tape, 0, NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_covariance_q31(SMOOTHED_Q31(&tape, 0), out));
    ASSERT_REFUSED(KQ_ERR_SIZE, kq_smoothed_q31(&tape, STEPS, &view));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY,
                   kq_smoothed_measurement_noise_q31(&tape, 0, &mean, &variance));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_smoothed_measurement_noise_q31(NULL, 0, &mean, &variance));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_smoothed_measurement_noise_q31(&tape, 0, NULL, &variance));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_smoothed_measurement_noise_q31(&tape, 0, &mean, NULL));
}

static void assert_no_word(const kq_history_q31 *h, size_t t, int i)
{
    TEST_ASSERT_EQUAL_INT32(KQ_NOT_A_VALUE_Q31, kq_mean_q31(SMOOTHED_Q31(h, t), i));
    TEST_ASSERT_EQUAL_INT32(KQ_NOT_A_VALUE_Q31, kq_mean_low_q31(SMOOTHED_Q31(h, t), i));
    TEST_ASSERT_EQUAL_INT32(KQ_NOT_A_VALUE_Q31, kq_sigma_q31(SMOOTHED_Q31(h, t), i));
}

static void what_is_read_of_a_bad_step_or_state_is_no_word(void)
{
    assert_no_word(&tape, 0, 0);
    assert_no_word(&unused, 0, 0);
    assert_no_word(NULL, 0, 0);
    run(&track, 0, 0);
    ASSERT_OK(kq_smooth_q31(&tape));
    assert_no_word(&tape, STEPS, 0);
    assert_no_word(&tape, SIZE_MAX, 0);
    assert_no_word(&tape, 0, -1);
    assert_no_word(&tape, 0, 2);
    assert_no_word(&tape, 0, INT_MIN);
}

SUITE(smoother, set_up)
{
    RUN_TEST(smoothing_is_that_in_double);
    RUN_TEST(a_prior_that_stands_for_infinity_is_recorded);
    RUN_TEST(two_components_without_noise_are_smoothed_as_in_double);
    RUN_TEST(states_only_gives_the_means);
    RUN_TEST(a_step_gives_extras);
    RUN_TEST(the_last_step_is_the_filter_s);
    RUN_TEST(the_filter_is_the_same_with_a_history);
    RUN_TEST(a_constant_smoothed_is_the_final_mean);
    RUN_TEST(assign_refuses);
    RUN_TEST(attach_refuses);
    RUN_TEST(smooth_refuses);
    RUN_TEST(a_full_history_is_an_event_and_refused);
    RUN_TEST(a_history_belongs_to_one_filter);
    RUN_TEST(init_does_not_look_at_the_history);
    RUN_TEST(a_process_changed_after_the_recording_is_refused);
    RUN_TEST(a_process_changed_at_every_step_is_smoothed_by_step);
    RUN_TEST(a_copy_is_a_filter_of_its_own);
    RUN_TEST(smoothed_results_refuse);
    RUN_TEST(what_is_read_of_a_bad_step_or_state_is_no_word);
}
