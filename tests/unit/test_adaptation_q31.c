/* The scales of the noises learnt in q31 (test_learning.c): what double learns, and what is refused. */
#include "q31.h"
#include "reading.h"
#include "unchanged.h"

#define ALL UINT32_MAX
#define STEPS 200

KQ_ADAPTATION_Q31(tuner, 2, 2);
KQ_FILTER_Q31(track, 2);
static process_model motion, motion3, finer, another;
static sensor_model radar, coupled, single;
static prior_model start, start3;
static kq_adaptation_rule_q31 rule;

/* the same in double */
ADAPTATION(wide_tuner, 2, 2);
PROCESS(wide_motion, 2, 1);
SENSOR(wide_radar, 2, 2);
FILTER(wide_track, 2);

static const double range[] = {1000, 1000, 1000}, measured_range[] = {1000, 1000};
static const double drive_range[] = {100}, fine_range[] = {1000, 1};
static const double A[] = {1, 0.5, -0.125, 0.75}, B[] = {0.125, 0.5};
static const double Q[] = {0.25, 0.125, 0.125, 0.5};
static const double H[] = {1, 0, 0.5, 1}, R[] = {0.5, 0.25, 0.25, 1}, diagonal[] = {0.5, 0, 0, 1};
static const double x0[] = {1, -2, 0}, P0[] = {2, 0.5, 0.5, 1};
static const double identity3[] = {1, 0, 0, 0, 1, 0, 0, 0, 1};

static const kq_scaled_q31 one = {INT32_C(1) << 30, -30}, none = {0, 0};

static kq_scaled_q31 power(int k) { return (kq_scaled_q31){INT32_C(1) << 30, k - 30}; }

static double of_number(kq_scaled_q31 a) { return ldexp(a.mantissa, a.exponent); }
static double process_scale(void)
{
    kq_scaled_q31 q = none;
    ASSERT_OK(kq_adaptation_scales_q31(&tuner, &q, NULL));
    return of_number(q);
}

static double sensor_scale(void)
{
    kq_scaled_q31 r = none;
    ASSERT_OK(kq_adaptation_scales_q31(&tuner, NULL, &r));
    return of_number(r);
}

static void set_up(void)
{
    put_process(&motion, 2, 1, range, drive_range, A, B, Q);
    put_process(&another, 2, 1, range, drive_range, A, B, P0);
    put_process(&motion3, 3, 0, range, NULL, identity3, NULL, identity3);
    put_process(&finer, 2, 0, fine_range, NULL, (const double[]){1, 0, 0, 1}, NULL, Q);
    put_sensor(&coupled, 2, 2, range, measured_range, H, R);
    put_sensor(&single, 2, 1, range, measured_range, H, R);
    put_sensor(&radar, 2, 2, range, measured_range, H, diagonal);
    /* independent components have variances alone */
    ASSERT_OK(kq_noise_prepare_diagonal_q31(radar.noise, (const double[]){0.5, 1}, 2,
                                            radar.measurement_format));
    radar.table.correlated = 0;
    ASSERT_OK(kq_sensor_init_q31(&radar.sensor, &radar.table, NULL));
    put_prior(&start, 2, range, x0, P0);
    put_prior(&start3, 3, range, x0, identity3);
    ASSERT_OK(kq_filter_init_q31(&track, &start.table, NULL));
    rule = (kq_adaptation_rule_q31){KQ_ADAPT_BOTH, 50,        power(-3), power(-4),
                                    power(4),      power(-3), power(3)};
    ASSERT_OK(kq_adaptation_assign_q31(&tuner, 2, 2, tuner_memory, COUNT(tuner_memory), tuner_root));
    ASSERT_OK(kq_adaptation_init_q31(&tuner, &motion.process, &radar.sensor, &rule));
    ASSERT_OK(kq_attach_q31(&track, &tuner.attached));
    watch_nothing();
    WATCH(motion), WATCH(radar), WATCH(track), WATCH(track_memory), WATCH(tuner);
    WATCH(tuner_memory), WATCH(tuner_root), WATCH(rule);
}

static uint32_t present_at(int t)
{
    static const uint32_t masks[] = {3, 3, 1, 3, 2, 3, 0};
    return masks[t % COUNT(masks)];
}

static const int32_t *drawn(uint32_t *seed, double scale)
{
    const double z[] = {scale * noise(seed), scale * noise(seed)};
    return words_of(z, 2, radar.measurement_format);
}

/* ------------------------------------------------------------------------------ what is learnt */

/* The goal is far above what is measured: 1e-7 */
static void follow_double(const kq_sensor_q31 *s, const double *R_wide, kq_adapted scales)
{
    uint32_t seed = 7;
    const K(adaptation_rule) wide = {scales, 50, 0.125, 0.0625, 16, 0.125, 8};
    rule.scales = scales;
    ASSERT_OK(kq_filter_init_q31(&track, &start.table, NULL));
    ASSERT_OK(kq_adaptation_init_q31(&tuner, &motion.process, s, &rule));
    ASSERT_OK(kq_attach_q31(&track, &tuner.attached));
    ASSERT_OK(K(process_init)(&wide_motion, A, B, Q));
    ASSERT_OK(K(sensor_init)(&wide_radar, H, R_wide));
    ASSERT_OK(K(filter_init)(&wide_track, x0, P0));
    ASSERT_OK(K(adaptation_init)(&wide_tuner, &wide_motion, &wide_radar, &wide));
    ASSERT_OK(K(attach)(&wide_track, &wide_tuner.attached));
    for (int t = 0; t < STEPS; t++) {
        double seen[2];
        const int32_t *z = drawn(&seed, t == 100 ? 40 : 2);
        for (int c = 0; c < 2; c++) seen[c] = ldexp(z[c], -s->measurement_format[c].fraction);
        ASSERT_OK(kq_update_subset_q31(&track, s, z, present_at(t)));
        ASSERT_OK(K(update_subset)(&wide_track, &wide_radar, seen, present_at(t)));
        double q, r;
        ASSERT_OK(K(adaptation_scales)(&wide_tuner, &q, &r));
        ASSERT_WITHIN(1e-6 * q, q, process_scale());
        ASSERT_WITHIN(1e-6 * r, r, sensor_scale());
        ASSERT_LIKE(&wide_track, &track, 1e-6);
        ASSERT_OK(kq_predict_q31(&track, &motion.process, NULL));
        ASSERT_OK(K(predict)(&wide_track, &wide_motion, NULL));
        ASSERT_LIKE(&wide_track, &track, 1e-6);
    }
    TEST_ASSERT_TRUE(fabs(log(process_scale())) + fabs(log(sensor_scale())) > 0.2);
}

TEST(scales_are_those_of_double)
{
    for (int scales = KQ_ADAPT_BOTH; scales <= KQ_ADAPT_SENSOR; scales++) {
        follow_double(&radar.sensor, diagonal, (kq_adapted)scales);
        follow_double(&coupled.sensor, R, (kq_adapted)scales);
    }
}

/* ------------------------------------------------------------------------------ bounds */

/* States that nothing measures and nothing moves, for as long as it takes their slopes to vanish;
   noise-free components; a noise as large as a table may say */
TEST(ends_of_the_numbers_are_safe)
{
    static const double fading[] = {0.5, 0, 0, 0.25}, still[] = {0, 0, 0, 0};
    const kq_scaled_q31 odd_noise[][2] = {{{0, 0}, {0, 0}}, {power(900), power(-900)}};
    rule.sensor_least = power(-40), rule.sensor_most = power(40);
    for (int k = 0; k < 4; k++) {
        uint32_t seed = 3;
        put_process(&motion, 2, 1, range, drive_range, fading, B, k % 2 ? still : Q);
        radar.noise[0] = odd_noise[k / 2][0], radar.noise[1] = odd_noise[k / 2][1];
        ASSERT_OK(kq_sensor_init_q31(&radar.sensor, &radar.table, NULL));
        ASSERT_OK(kq_filter_init_q31(&track, &start.table, NULL));
        ASSERT_OK(kq_adaptation_init_q31(&tuner, &motion.process, &radar.sensor, &rule));
        ASSERT_OK(kq_attach_q31(&track, &tuner.attached));
        for (int t = 0; t < 2000; t++) {
            const int32_t *z = drawn(&seed, 2);
            ASSERT_OK(kq_update_subset_q31(&track, &radar.sensor, z, t < 1000 ? 3 : 0));
            ASSERT_OK(kq_predict_q31(&track, &motion.process, NULL));
        }
        TEST_ASSERT_TRUE(process_scale() >= 0.0625 && process_scale() <= 16);
        TEST_ASSERT_TRUE(sensor_scale() >= 0x1p-40 && sensor_scale() <= 0x1p40);
    }
}

/* ------------------------------------------------------------------------------ refusals */

TEST(refusals_of_assign)
{
    static kq_scaled_q31 words[KQ_ADAPTATION_LEN_Q31(2, 2)];
    static int32_t root[KQ_ROOT_LEN_Q31(2)];
    kq_adaptation_q31 a = {.states = 0};
    const size_t length = COUNT(words);
    WATCH(a);
    ASSERT_REFUSED(KQ_ERR_NULL, kq_adaptation_assign_q31(NULL, 2, 2, words, length, root));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_adaptation_assign_q31(&a, 2, 2, NULL, length, root));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_adaptation_assign_q31(&a, 2, 2, words, length, NULL));
    ASSERT_REFUSED(KQ_ERR_SIZE, kq_adaptation_assign_q31(&a, 17, 2, words, length, root));
    ASSERT_REFUSED(KQ_ERR_SIZE, kq_adaptation_assign_q31(&a, 2, 0, words, length, root));
    ASSERT_REFUSED(KQ_ERR_MEMORY, kq_adaptation_assign_q31(&a, 2, 2, words, length - 1, root));
    ASSERT_OK(kq_adaptation_assign_q31(&a, 2, 2, words, length, root));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_attach_q31(&track, &a.attached));
    ASSERT_OK(kq_adaptation_init_q31(&a, &motion.process, &radar.sensor, &rule));
}

static kq_status try_init(void)
{
    return kq_adaptation_init_q31(&tuner, &motion.process, &radar.sensor, &rule);
}

static kq_status try_models(const kq_process_q31 *p, const kq_sensor_q31 *s)
{
    return kq_adaptation_init_q31(&tuner, p, s, &rule);
}

TEST(refusals_of_init)
{
    kq_adaptation_q31 nothing = {.states = 0};
    WATCH(nothing);
    ASSERT_REFUSED_SIZE_OR_MEMORY(
        kq_adaptation_init_q31(&nothing, &motion.process, &radar.sensor, &rule));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, try_models(&motion.process, &single.sensor));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, try_models(&finer.process, &radar.sensor)); /* formats */
    ASSERT_OK(try_init());
}

static void assert_bad_number(kq_scaled_q31 *number, kq_scaled_q31 bad, kq_status status)
{
    const kq_scaled_q31 good = *number;
    *number = bad;
    ASSERT_REFUSED(status, try_init());
    *number = good;
}

TEST(refusals_of_a_rule)
{
    kq_scaled_q31 *numbers[] = {&rule.step, &rule.process_least, &rule.process_most,
                                &rule.sensor_least, &rule.sensor_most};
    for (int k = 0; k < COUNT(numbers); k++) {
        assert_bad_number(numbers[k], (kq_scaled_q31){1, 0}, KQ_ERR_COEFFICIENT);
        assert_bad_number(numbers[k], power(1031), KQ_ERR_COEFFICIENT);
        assert_bad_number(numbers[k], none, KQ_ERR_RANGE);
        assert_bad_number(numbers[k], (kq_scaled_q31){-(INT32_C(1) << 30), -30}, KQ_ERR_RANGE);
    }
    assert_bad_number(&rule.step, power(1), KQ_ERR_RANGE);
    assert_bad_number(&rule.process_least, power(1), KQ_ERR_RANGE);
    assert_bad_number(&rule.sensor_most, power(-1), KQ_ERR_RANGE);
    assert_bad_number(&rule.sensor_most, power(1025), KQ_ERR_COEFFICIENT); /* times R */
    rule.sensor_least = power(-960);
    ASSERT_OK(try_init());
    radar.noise[1] = power(-50); /* times that */
    ASSERT_REFUSED(KQ_ERR_COEFFICIENT, try_init());
    radar.noise[1] = one;
    rule.memory = KQ_ADAPTATION_MEMORY_MIN - 1;
    ASSERT_REFUSED(KQ_ERR_SIZE, try_init());
    rule.memory = KQ_ADAPTATION_MEMORY_MAX + 1;
    ASSERT_REFUSED(KQ_ERR_SIZE, try_init());
    rule.memory = KQ_ADAPTATION_MEMORY_MAX;
    rule.scales = (kq_adapted)3;
    ASSERT_REFUSED(KQ_ERR_RANGE, try_init());
}

SUITE(adaptation_q31, set_up)
#include "adaptation_q31.tests"
