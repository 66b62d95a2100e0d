/* Outliers and jumps in fixed point: the laws of test_robust.c in integers, and beside double. */
#include "q31.h"
#include "losses.h"
#include "losses_q31.h"
#include "reading.h"
#include "unchanged.h"

#define ALL UINT32_MAX
#define GOAL 1e-6 /* sigma */

static const double range[] = {100000, 1000}, measured_range[] = {100000, 100000};
static const double drive_range[] = {100};
static const double A[] = {1, 0.5, 0, 1}, B[] = {0.125, 0.5}, Q[] = {0.25, 0.125, 0.125, 0.5};
static const double H[] = {1, 0, 0.5, 1}, R[] = {0.5, 0.25, 0.25, 1}, diagonal[] = {0.5, 0, 0, 1};
static const double x0[] = {1, -2}, P0[] = {2, 0.5, 0.5, 1};

static process_model motion;
static sensor_model coupled, radar;
static prior_model prior;
static kq_process_q31 scaled;
static int32_t root[KQ_ROOT_LEN_Q31(2)];
static kq_loss_q31 gate;
KQ_FILTER_Q31(track, 2);
KQ_FILTER_Q31(twin, 2);
KQ_HISTORY_Q31(tape, 2, 2, 40, 0);
KQ_HISTORY_Q31(twin_tape, 2, 2, 40, 0);

KQ_FILTER_Q31(blank, 2);
static kq_sensor_q31 blank_sensor;
static kq_process_q31 blank_process;
static kq_scaled_q31 weights[2], q[40];

/* the same in double */
PROCESS(wide_motion, 2, 1);
PROCESS(wide_scaled, 2, 1);
SENSOR(wide_coupled, 2, 2);
SENSOR(wide_radar, 2, 2);
FILTER(wide_track, 2);
HISTORY(wide_tape, 2, 2, 40, 0);
static double wide_weights[2], wide_q[40];

static kq_scaled_q31 number(double a)
{
    int exponent = 0;
    const double m = frexp(a, &exponent);
    const kq_scaled_q31 zero = {0, 0};
    return a == 0 ? zero : (kq_scaled_q31){(int32_t)(m * 0x1p30) * 2, exponent - 31};
}

static double of_number(kq_scaled_q31 a) { return ldexp(a.mantissa, a.exponent); }

static void start(void)
{
    ASSERT_OK(kq_filter_init_q31(&track, &prior.table, NULL));
    ASSERT_OK(kq_filter_init_q31(&twin, &prior.table, NULL));
    ASSERT_OK(K(filter_init)(&wide_track, x0, P0));
}

static void set_up(void)
{
    put_process(&motion, 2, 1, range, drive_range, A, B, Q);
    put_sensor(&coupled, 2, 2, range, measured_range, H, R);
    put_sensor(&radar, 2, 2, range, measured_range, H, diagonal);
    /* independent components have variances alone */
    ASSERT_OK(kq_noise_prepare_diagonal_q31(radar.noise, (const double[]){0.5, 1}, 2,
                                            radar.measurement_format));
    radar.table.correlated = 0;
    ASSERT_OK(kq_sensor_init_q31(&radar.sensor, &radar.table, NULL));
    put_prior(&prior, 2, range, x0, P0);
    ASSERT_OK(K(process_init)(&wide_motion, A, B, Q));
    ASSERT_OK(K(sensor_init)(&wide_coupled, H, R));
    ASSERT_OK(K(sensor_init)(&wide_radar, H, diagonal));
    gate = (kq_loss_q31){.kind = &kq_loss_gate_q31, .limit = kq_chi_square_limit_q31(2, KQ_LEVEL_99), .run = 3};
    for (int t = 0; t < COUNT(q); t++) q[t] = number(1), wide_q[t] = 1;
    start();
    watch_nothing();
    WATCH(track), WATCH(track_memory), WATCH(gate), WATCH(weights), WATCH(q), WATCH(scaled);
    WATCH(root), WATCH(motion), WATCH(tape);
}

static const int32_t *seen(double a, double b)
{
    return words_of((const double[]){a, b}, 2, radar.measurement_format);
}

static const int32_t *drive(void)
{
    static int32_t word[1];
    ASSERT_OK(kq_vector_prepare_q31(word, (const double[]){4}, 1, motion.control_format, NULL));
    return word;
}

/* A measurement as q31 has it, for the twin in double */
static const double *rounded(const int32_t *words)
{
    static double z[2];
    for (int c = 0; c < 2; c++) z[c] = ldexp(words[c], -radar.measurement_format[c].fraction);
    return z;
}

/* ------------------------------------------------------------------------------ the gate */

TEST(a_gate_takes_or_leaves)
{
    ASSERT_OK(kq_attach_q31(&track, &tape.attached));
    ASSERT_OK(kq_attach_q31(&twin, &twin_tape.attached));
    gate.limit = INT64_C(100) << 24;
    for (int t = 0; t < 20; t++) {
        const kq_sensor_q31 *s = t % 2 ? &radar.sensor : &coupled.sensor;
        const int32_t *near = seen(1 + 0.5 * t, 0);
        kq_events_clear_q31(&track);
        ASSERT_OK(kq_update_robust_q31(&track, s, near, t % 3 ? ALL : 1, &gate));
        ASSERT_OK(kq_update_subset_q31(&twin, s, near, t % 3 ? ALL : 1));
        ASSERT_SAME_Q31(&twin, &track);
        TEST_ASSERT_EQUAL_INT(t % 3 ? 2 : 1, kq_taken_q31(&track));
        const kq_likelihood_run_q31 run = track.run;
        ASSERT_OK(kq_update_robust_q31(&track, s, seen(900, 20), ALL, &gate));
        TEST_ASSERT_EQUAL_HEX(KQ_EVENT_GATED, kq_events_q31(&track));
        TEST_ASSERT_EQUAL_MEMORY(&run, &track.run, sizeof run);
        TEST_ASSERT_EQUAL_MEMORY(twin_memory, track_memory, sizeof twin_memory);
        TEST_ASSERT_EQUAL_INT(0, kq_taken_q31(&track));
        TEST_ASSERT_TRUE(kq_nis_q31(&track) > gate.limit);
        TEST_ASSERT_EQUAL_INT(1, gate.rejected);
        ASSERT_OK(kq_predict_q31(&track, &motion.process, NULL));
        ASSERT_OK(kq_predict_q31(&twin, &motion.process, NULL));
    }
    ASSERT_OK(kq_smooth_q31(&tape));
    ASSERT_OK(kq_smooth_q31(&twin_tape));
    const size_t words = 21 * (size_t)KQ_FILTER_LEN_Q31(2);
    const size_t from = (size_t)COUNT(tape_memory) - words;
    TEST_ASSERT_EQUAL_MEMORY(twin_tape_memory + from, tape_memory + from, words * 4);
}

TEST(limits_are_scores)
{
    for (int m = 1; m <= 16; m++) {
        for (int k = 0; k < 5; k++) {
            ASSERT_WITHIN(0x1p-24, K(chi_square_limit)(m, (kq_level)k),
                          score_value(kq_chi_square_limit_q31(m, (kq_level)k)));
        }
    }
    TEST_ASSERT_TRUE(kq_chi_square_limit_q31(0, KQ_LEVEL_90) == KQ_NOT_A_SCORE_Q31);
    TEST_ASSERT_TRUE(kq_chi_square_limit_q31(17, KQ_LEVEL_90) == KQ_NOT_A_SCORE_Q31);
    TEST_ASSERT_TRUE(kq_chi_square_limit_q31(1, (kq_level)5) == KQ_NOT_A_SCORE_Q31);
}

TEST(a_run_of_rejections_ends_with_a_jump)
{
    const int32_t *far = seen(900, 20);
    gate.run = 0;
    for (int k = 0; k <= KQ_GATE_RUN; k++) {
        TEST_ASSERT_EQUAL_INT(k, gate.rejected);
        kq_events_clear_q31(&track);
        ASSERT_OK(kq_update_robust_q31(&track, &coupled.sensor, far, ALL, &gate));
    }
    ASSERT_OK(jump_q31(&twin, &coupled.sensor, far, ALL, number(1)));
    TEST_ASSERT_EQUAL_MEMORY(twin_memory, track_memory, sizeof twin_memory);
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_JUMP | KQ_EVENT_REJECTIONS, kq_events_q31(&track));
    TEST_ASSERT_EQUAL_INT(0, gate.rejected);
    TEST_ASSERT_TRUE(kq_nis_q31(&twin) == kq_nis_q31(&track));
}

/* ------------------------------------------------------------------------------ the two weights */

typedef kq_status update_q31(kq_filter_q31 *f, const kq_sensor_q31 *s, const int32_t *z,
                             uint32_t present, kq_scaled_q31 parameter);
typedef kq_status update_f64(K(filter) * f, const K(sensor) * s, const double *z, uint32_t present,
                             double parameter);

static kq_status huber(kq_filter_q31 *f, const kq_sensor_q31 *s, const int32_t *z, uint32_t present,
                       kq_scaled_q31 parameter)
{
    return huber_q31(f, s, z, present, parameter, weights);
}

static kq_status student(kq_filter_q31 *f, const kq_sensor_q31 *s, const int32_t *z,
                         uint32_t present, kq_scaled_q31 parameter)
{
    return student_q31(f, s, z, present, parameter, weights);
}

static kq_status wide_huber(K(filter) * f, const K(sensor) * s, const double *z, uint32_t present,
                            double parameter)
{
    return update_huber(f, s, z, present, parameter, wide_weights);
}

static kq_status wide_student(K(filter) * f, const K(sensor) * s, const double *z, uint32_t present,
                              double parameter)
{
    return update_student(f, s, z, present, parameter, wide_weights);
}

/* An outlier in every fifth measurement */
static const int32_t *with_outliers(int t, uint32_t *seed, double outlier)
{
    const double a = t + noise(seed), b = 0.5 * t + noise(seed);
    return seen(a + (t % 5 == 2 ? outlier : 0), b - (t % 5 == 4 ? outlier : 0));
}

static void assert_as_in_double(update_q31 *update, update_f64 *wide_update, double parameter)
{
    uint32_t seed = 5;
    const kq_scaled_q31 p = number(parameter);
    start();
    for (int t = 0; t < 60; t++) {
        const int odd = t % 2;
        const uint32_t present = t % 7 == 3 ? 2 : ALL;
        const int32_t *z = with_outliers(t, &seed, 40);
        ASSERT_OK(update(&track, odd ? &radar.sensor : &coupled.sensor, z, present, p));
        ASSERT_OK(wide_update(&wide_track, odd ? &wide_radar : &wide_coupled, rounded(z), present,
                              of_number(p)));
        ASSERT_LIKE(&wide_track, &track, GOAL);
        const double nis = K(nis)(&wide_track);
        ASSERT_WITHIN(GOAL * (10 + nis), nis, score_value(kq_nis_q31(&track)));
        ASSERT_OK(kq_predict_q31(&track, &motion.process, drive()));
        ASSERT_OK(K(predict)(&wide_track, &wide_motion, (const double[]){4}));
    }
    const double run = K(log_likelihood)(&wide_track);
    ASSERT_WITHIN(-10 * GOAL * run, run, score_value(kq_log_likelihood_q31(&track)));
    TEST_ASSERT_EQUAL_HEX(0, kq_events_q31(&track));
}

TEST(outliers_are_weighed_as_in_double)
{
    assert_as_in_double(huber, wide_huber, 1.5);
    assert_as_in_double(huber, wide_huber, 3);
    assert_as_in_double(student, wide_student, 4);
    assert_as_in_double(student, wide_student, 1);
    for (int c = 0; c < 2; c++) ASSERT_WITHIN(GOAL, wide_weights[c], of_number(weights[c]));
}

TEST(what_is_not_clipped_is_taken_as_it_is)
{
    for (int t = 0; t < 8; t++) {
        const kq_sensor_q31 *s = t % 2 ? &radar.sensor : &coupled.sensor;
        const int32_t *z = seen(t, 1);
        ASSERT_OK(huber_q31(&track, s, z, t == 5 ? 1 : ALL, number(1e6), weights));
        ASSERT_OK(kq_update_subset_q31(&twin, s, z, t == 5 ? 1 : ALL));
        TEST_ASSERT_EQUAL_MEMORY(twin_memory, track_memory, sizeof twin_memory);
        ASSERT_WITHIN(1e-8, 1, of_number(weights[0]));
        ASSERT_WITHIN(1e-8, t == 5 ? 0 : 1, of_number(weights[1]));
    }
    ASSERT_OK(K(filter_init)(&wide_track, x0, P0));
    ASSERT_OK(kq_filter_init_q31(&track, &prior.table, NULL));
    for (int t = 0; t < 8; t++) {
        const int32_t *z = seen(t, 1);
        ASSERT_OK(student_q31(&track, &radar.sensor, z, ALL, number(1e12), NULL));
        ASSERT_OK(K(update)(&wide_track, &wide_radar, rounded(z)));
        ASSERT_LIKE(&wide_track, &track, GOAL);
    }
}

/* ------------------------------------------------------------------------------ jumps */

static kq_status jump(kq_filter_q31 *f, const kq_sensor_q31 *s, const int32_t *z, uint32_t present,
                      kq_scaled_q31 parameter)
{
    return jump_q31(f, s, z, present, parameter);
}

/* Twins without noise that say different things, or the same: the second is at the floor. */
TEST(what_the_plain_update_does_not_take_no_robust_one_takes)
{
    update_q31 *updates[] = {huber, student, jump};
    static const double same[] = {1, 0, 1, 0}, none[] = {0, 0, 0, 0};
    static const double values[][2] = {{-1, 50000}, {-1, -1}, {0, -50000}};
    sensor_model twins;
    put_sensor(&twins, 2, 2, range, measured_range, same, none);
    for (int k = 0; k < COUNT(values) * COUNT(updates); k++) {
        const double *value = values[k / COUNT(updates)];
        start();
        ASSERT_OK(kq_update_q31(&twin, &twins.sensor, seen(value[0], value[1])));
        ASSERT_OK(updates[k % COUNT(updates)](&track, &twins.sensor, seen(value[0], value[1]), ALL,
                                              number(3)));
        TEST_ASSERT_EQUAL_INT(1, kq_taken_q31(&track));
        TEST_ASSERT_EQUAL_HEX(KQ_EVENT_REDUNDANT, kq_events_q31(&track));
        TEST_ASSERT_EQUAL_MEMORY(twin_memory, track_memory, sizeof twin_memory);
    }
}

/* With fewer degrees of freedom nothing of r would be left in r'. */
TEST(a_student_has_some_freedom)
{
    const int32_t *z = seen(1, 2);
    ASSERT_REFUSED(KQ_ERR_RANGE, student(&track, &radar.sensor, z, ALL, number(0x1.fffffffcp-21)));
    ASSERT_REFUSED(KQ_ERR_RANGE, student(&track, &radar.sensor, z, ALL, number(0x1p-400)));
    ASSERT_OK(student(&track, &radar.sensor, z, ALL, number(0x1p-20)));
}

TEST(a_jump_is_followed_as_in_double)
{
    uint32_t seed = 3;
    for (int t = 0; t < 40; t++) {
        const double far = t > 20 ? 500 : 0;
        const int32_t *z = seen(2 * t + far + noise(&seed), t + noise(&seed));
        ASSERT_OK(jump_q31(&track, &radar.sensor, z, ALL, number(12)));
        ASSERT_OK(update_jump(&wide_track, &wide_radar, rounded(z), ALL, of_number(number(12))));
        TEST_ASSERT_EQUAL_HEX(K(events)(&wide_track), kq_events_q31(&track));
        ASSERT_LIKE(&wide_track, &track, GOAL);
        ASSERT_OK(kq_predict_q31(&track, &motion.process, drive()));
        ASSERT_OK(K(predict)(&wide_track, &wide_motion, (const double[]){4}));
    }
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_JUMP, kq_events_q31(&track));
}

/* ------------------------------------------------------------------------------ scaled noise */

/* It is written as a whole: nothing of it is looked at. */
TEST(a_target_needs_nothing_before)
{
    kq_process_q31 fresh;
    memset(&fresh, 0xa5, sizeof fresh);
    ASSERT_OK(kq_process_scale_noise_q31(&fresh, &motion.process, root, number(1)));
    TEST_ASSERT_EQUAL_UINT8(motion.process.states, fresh.states);
    TEST_ASSERT_TRUE(fresh.noise_root == root && fresh.transition == motion.transition);
}

TEST(powers_of_4_move_the_exponents_alone)
{
    for (int k = -3; k < 8; k++) {
        ASSERT_OK(
            kq_process_scale_noise_q31(&scaled, &motion.process, root, number(ldexp(1, 2 * k))));
        for (int i = 0; i < 3; i++) TEST_ASSERT_EQUAL_INT32(motion.noise_root[i], root[i]);
        for (int i = 3; i < 5; i++) TEST_ASSERT_EQUAL_INT32(motion.noise_root[i] + k, root[i]);
    }
    TEST_ASSERT_TRUE(scaled.noise_root == root);
    TEST_ASSERT_TRUE(scaled.transition == motion.transition);
    ASSERT_OK(kq_process_scale_noise_q31(&scaled, &motion.process, root, number(0)));
    for (int i = 0; i < 3; i++) TEST_ASSERT_EQUAL_INT32(0, root[i]);
    ASSERT_OK(kq_predict_q31(&track, &scaled, drive()));
}

TEST(scaled_noise_is_that_of_double)
{
    for (int k = 0; k < 20; k++) {
        const kq_scaled_q31 factor = number(exp(k - 8));
        start();
        ASSERT_OK(kq_process_scale_noise_q31(&scaled, &motion.process, root, factor));
        ASSERT_OK(K(process_scale_noise)(&wide_scaled, &wide_motion, of_number(factor)));
        ASSERT_OK(kq_predict_q31(&track, &scaled, drive()));
        ASSERT_OK(K(predict)(&wide_track, &wide_scaled, (const double[]){4}));
        ASSERT_LIKE(&wide_track, &track, 1e-8);
    }
}

/* ------------------------------------------------------------------------------ the smoother */

TEST(the_reweighted_smoother_is_that_of_double)
{
    for (int pass = 0; pass < 3; pass++) {
        uint32_t seed = 11;
        start();
        ASSERT_OK(kq_attach_q31(&track, &tape.attached));
        ASSERT_OK(K(attach)(&wide_track, &wide_tape.attached));
        for (int t = 0; t < 30; t++) {
            const int32_t *z = seen(t + (t > 12 ? 60 : 0) + noise(&seed), t + noise(&seed));
            ASSERT_OK(kq_process_scale_noise_q31(&scaled, &motion.process, root, q[t]));
            ASSERT_OK(K(process_scale_noise)(&wide_scaled, &wide_motion, wide_q[t]));
            ASSERT_OK(kq_step_q31(&track, &scaled, drive(), &radar.sensor, z));
            ASSERT_OK(
                K(step)(&wide_track, &wide_scaled, (const double[]){4}, &wide_radar, rounded(z)));
        }
        ASSERT_OK(kq_smooth_reweighted_q31(&tape, &scaled, &motion.process, root, number(2), q));
        ASSERT_OK(K(smooth_reweighted)(&wide_tape, &wide_scaled, &wide_motion, 2, wide_q));
        for (int t = 0; t < 30; t++) {
            ASSERT_WITHIN(4 * GOAL * wide_q[t], wide_q[t], of_number(q[t]));
            const double sigma = K(sigma)(SMOOTHED(&wide_tape, (size_t)t), 0);
            const double words = kq_mean_q31(SMOOTHED_Q31(&tape, (size_t)t), 0) +
                                 ldexp(kq_mean_low_q31(SMOOTHED_Q31(&tape, (size_t)t), 0), -24);
            ASSERT_WITHIN(4 * GOAL * sigma, K(mean)(SMOOTHED(&wide_tape, (size_t)t), 0),
                          ldexp(words, -motion.state_format[0].fraction));
        }
    }
    TEST_ASSERT_TRUE(wide_q[13] > 20);
}

/* Noise of rank 1: what it does not move is not counted. */
TEST(noise_of_less_rank_counts_by_its_rank)
{
    static const double singular[] = {0.5, 1, 1, 2};
    static const double factor[] = {0.70710678118654752, 1.41421356237309505};
    put_process(&motion, 2, 1, range, drive_range, A, B, singular);
    ASSERT_OK(kq_root_prepare_factor_q31(motion.noise_root, factor, 2, 1, motion.state_format));
    ASSERT_OK(K(process_init_factor)(&wide_motion, A, B, factor, 1));
    the_reweighted_smoother_is_that_of_double();
}

/* ------------------------------------------------------------------------------ refusals */

TEST(a_noise_too_small_to_be_held_is_refused)
{
    const int32_t kept = motion.noise_root[3];
    for (int32_t exponent = -1000; exponent < -960; exponent++) {
        motion.noise_root[3] = exponent;
        ASSERT_OK(kq_process_init_q31(&motion.process, &motion.table, NULL));
        const kq_status status =
            kq_process_scale_noise_q31(&scaled, &motion.process, root, number(1));
        TEST_ASSERT_EQUAL_INT(exponent < 32 - 1000 ? KQ_ERR_COEFFICIENT : KQ_OK, status);
    }
    motion.noise_root[3] = kept;
}

TEST(refusals)
{
    const int32_t *z = seen(1, 1);
    const kq_scaled_q31 bad = {1, 0}, two = number(2), zero = {0, 0}, less = number(-2);
    const kq_sensor_q31 *s = &radar.sensor;
    kq_process_q31 *m = &motion.process;
    gate.limit = 0;
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_update_robust_q31(&track, s, z, ALL, &gate));
    gate.limit = 1;
    ASSERT_REFUSED(KQ_ERR_NULL, kq_update_robust_q31(&track, s, z, ALL, NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_update_robust_q31(&blank, s, z, ALL, &gate));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_update_robust_q31(&track, &blank_sensor, z, ALL, &gate));
    const int32_t far[] = {INT32_MAX, INT32_MIN};
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_update_robust_q31(&track, s, far, ALL, &gate));

    update_q31 *updates[] = {huber, student, jump_q31};
    for (int k = 0; k < COUNT(updates); k++) {
        ASSERT_REFUSED(KQ_ERR_NULL, updates[k](NULL, s, z, ALL, two));
        ASSERT_REFUSED(KQ_ERR_NULL, updates[k](&track, s, NULL, ALL, two));
        ASSERT_REFUSED(KQ_ERR_NOT_READY, updates[k](&track, &blank_sensor, z, ALL, two));
        ASSERT_REFUSED(KQ_ERR_COEFFICIENT, updates[k](&track, s, z, ALL, bad));
        ASSERT_REFUSED(KQ_ERR_RANGE, updates[k](&track, s, z, ALL, zero));
        ASSERT_REFUSED(KQ_ERR_RANGE, updates[k](&track, s, z, ALL, less));
        ASSERT_REFUSED(KQ_ERR_RANGE, updates[k](&track, s, far, ALL, two));
    }
    ASSERT_REFUSED(KQ_ERR_RANGE, jump_q31(&track, s, z, ALL, number(0.5)));

    ASSERT_REFUSED(KQ_ERR_NULL, kq_process_scale_noise_q31(NULL, m, root, two));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_process_scale_noise_q31(&scaled, NULL, root, two));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_process_scale_noise_q31(&scaled, m, NULL, two));
    ASSERT_REFUSED(KQ_ERR_NOT_READY,
                   kq_process_scale_noise_q31(&scaled, &blank_process, root, two));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, kq_process_scale_noise_q31(m, m, root, two));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, kq_process_scale_noise_q31(&scaled, m, motion.noise_root, two));
    ASSERT_REFUSED(KQ_ERR_COEFFICIENT, kq_process_scale_noise_q31(&scaled, m, root, bad));
    ASSERT_REFUSED(KQ_ERR_NOT_SEMIDEFINITE, kq_process_scale_noise_q31(&scaled, m, root, less));

    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, kq_smooth_reweighted_q31(&tape, &scaled, m, root, two, q));
    ASSERT_OK(kq_attach_q31(&track, &tape.attached));
    ASSERT_REFUSED(KQ_ERR_RECORDING, jump_q31(&track, s, z, ALL, two));
    ASSERT_OK(kq_predict_q31(&track, m, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_smooth_reweighted_q31(&tape, &scaled, m, NULL, two, q));
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_smooth_reweighted_q31(&tape, &scaled, m, root, zero, q));
    q[0] = bad;
    ASSERT_REFUSED(KQ_ERR_COEFFICIENT, kq_smooth_reweighted_q31(&tape, &scaled, m, root, two, q));
}

/* A factor of the root that would take its exponents beyond those of a table */
TEST(exponents_stay_within_their_limits)
{
    const kq_scaled_q31 large = {INT32_C(1) << 30, 1000}, small = {INT32_C(1) << 30, -1000};
    kq_process_q31 again;
    int32_t other[KQ_ROOT_LEN_Q31(2)];
    ASSERT_OK(kq_process_scale_noise_q31(&scaled, &motion.process, root, large));
    kq_status status = KQ_OK;
    for (int k = 0; k < 4 && !status; k++) {
        status = kq_process_scale_noise_q31(&again, &scaled, other, large);
        if (!status) status = kq_process_scale_noise_q31(&scaled, &again, root, large);
    }
    TEST_ASSERT_EQUAL_INT(KQ_ERR_COEFFICIENT, status);
    ASSERT_OK(kq_predict_q31(&track, &scaled, NULL));
    ASSERT_OK(kq_process_scale_noise_q31(&scaled, &motion.process, root, small));
    status = KQ_OK;
    for (int k = 0; k < 4 && !status; k++) {
        status = kq_process_scale_noise_q31(&again, &scaled, other, small);
        if (!status) status = kq_process_scale_noise_q31(&scaled, &again, root, small);
    }
    TEST_ASSERT_EQUAL_INT(KQ_ERR_COEFFICIENT, status);
}

SUITE(robust_q31, set_up)
#include "robust_q31.tests"
