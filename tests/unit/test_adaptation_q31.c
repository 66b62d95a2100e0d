/* The scales of the noises learnt in q31: what double learns, and what is refused. */
#include "q31.h"
#include "reading.h"
#include "unchanged.h"

#define ALL UINT32_MAX
#define STEPS 200

KQ_ADAPTATION_Q31(tuner, 2, 2);
KQ_ADAPTATION_Q31(blank, 2, 2);
KQ_FILTER_Q31(track, 2);
KQ_FILTER_Q31(twin, 2);
KQ_FILTER_Q31(blank_filter, 2);
KQ_HISTORY_Q31(tape, 2, 2, 4, 0);
static process_model motion, motion3, finer, another;
static sensor_model radar, coupled, single;
static prior_model start, start3;
static kq_process_q31 blank_process;
static kq_sensor_q31 blank_sensor;
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
    ASSERT_OK(kq_filter_init_q31(&twin, &start.table, NULL));
    rule = (kq_adaptation_rule_q31){KQ_ADAPT_BOTH, 50,        power(-3), power(-4),
                                    power(4),      power(-3), power(3)};
    ASSERT_OK(kq_adaptation_assign_q31(&tuner, 2, 2, tuner_memory, COUNT(tuner_memory), tuner_root));
    ASSERT_OK(kq_adaptation_init_q31(&tuner, &motion.process, &radar.sensor, &rule));
    ASSERT_OK(kq_attach_q31(&track, &tuner.attached));
    watch_nothing();
    WATCH(motion), WATCH(radar), WATCH(track), WATCH(track_memory), WATCH(tuner);
    WATCH(tuner_memory), WATCH(tuner_root), WATCH(blank), WATCH(rule);
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

static const int32_t *drive(void)
{
    static int32_t word[1];
    ASSERT_OK(kq_vector_prepare_q31(word, (const double[]){2}, 1, motion.control_format, NULL));
    return word;
}

/* ------------------------------------------------------------------------------ what is learnt */

static void scales_that_may_not_move_leave_the_bits(void)
{
    uint32_t seed = 1;
    const kq_sensor_q31 *sensors[] = {&radar.sensor, &coupled.sensor};
    rule.process_least = rule.process_most = rule.sensor_least = rule.sensor_most = one;
    for (int k = 0; k < 2; k++) {
        ASSERT_OK(kq_adaptation_init_q31(&tuner, &motion.process, sensors[k], &rule));
        for (int t = 0; t < STEPS; t++) {
            const int32_t *z = drawn(&seed, 2);
            ASSERT_OK(kq_update_subset_q31(&track, sensors[k], z, present_at(t)));
            ASSERT_OK(kq_update_subset_q31(&twin, sensors[k], z, present_at(t)));
            ASSERT_SAME_Q31(&twin, &track);
            ASSERT_OK(kq_predict_q31(&track, &motion.process, t % 2 ? drive() : NULL));
            ASSERT_OK(kq_predict_q31(&twin, &motion.process, t % 2 ? drive() : NULL));
            ASSERT_SAME_Q31(&twin, &track);
        }
    }
}

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

static void scales_are_those_of_double(void)
{
    for (int scales = KQ_ADAPT_BOTH; scales <= KQ_ADAPT_SENSOR; scales++) {
        follow_double(&radar.sensor, diagonal, (kq_adapted)scales);
        follow_double(&coupled.sensor, R, (kq_adapted)scales);
    }
}

/* ------------------------------------------------------------------------------ bounds */

/* Measurements out of all proportion, then none that differ from what is expected */
static void steps_and_limits_are_kept(void)
{
    for (int t = 0; t < 1000; t++) {
        const double q = process_scale(), r = sensor_scale(), most = 1.125 * (1 + 1e-8);
        int32_t z[2];
        if (t < 200) {
            z[0] = t % 2 ? INT32_C(900) << 20 : -(INT32_C(900) << 20);
            z[1] = -z[0];
        } else {
            ASSERT_OK(kq_measurement_q31(&track, &radar.sensor, z, NULL));
        }
        ASSERT_OK(kq_update_subset_q31(&track, &radar.sensor, z, ALL));
        TEST_ASSERT_TRUE(process_scale() <= q * most && process_scale() >= q / most);
        TEST_ASSERT_TRUE(sensor_scale() <= r * most && sensor_scale() >= r / most);
        TEST_ASSERT_TRUE(process_scale() >= 0.0625 && process_scale() <= 16);
        TEST_ASSERT_TRUE(sensor_scale() >= 0.125 && sensor_scale() <= 8);
        if (t == 199) ASSERT_WITHIN(0, 8, sensor_scale());
        ASSERT_OK(kq_predict_q31(&track, &motion.process, NULL));
    }
    ASSERT_WITHIN(0, 0.125, sensor_scale());
}

/* States that nothing measures and nothing moves, for as long as it takes their slopes to vanish;
   noise-free components; a noise as large as a table may say */
static void ends_of_the_numbers_are_safe(void)
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

/* ------------------------------------------------------------------------------ objects */

static void learn_something(void)
{
    uint32_t seed = 4;
    ASSERT_OK(kq_adaptation_init_q31(&tuner, &motion.process, &coupled.sensor, &rule));
    ASSERT_OK(kq_attach_q31(&track, &tuner.attached));
    for (int t = 0; t < STEPS; t++) {
        ASSERT_OK(kq_update_subset_q31(&track, &coupled.sensor, drawn(&seed, 3), present_at(t)));
        ASSERT_OK(kq_predict_q31(&track, &motion.process, NULL));
    }
    TEST_ASSERT_TRUE(fabs(log(process_scale())) > 0.1 && fabs(log(sensor_scale())) > 0.1);
}

static void the_scaled_models_are_those_of_the_scales(void)
{
    static kq_process_q31 expected;
    static int32_t root[KQ_ROOT_LEN_Q31(2)];
    uint32_t seed = 8;
    learn_something();
    const kq_process_q31 *p = kq_adaptation_process_q31(&tuner);
    const kq_sensor_q31 *s = kq_adaptation_sensor_q31(&tuner);
    kq_scaled_q31 q = none;
    ASSERT_OK(kq_adaptation_scales_q31(&tuner, &q, NULL));
    ASSERT_OK(kq_process_scale_noise_q31(&expected, &motion.process, root, q));
    TEST_ASSERT_EQUAL_MEMORY(root, p->noise_root, sizeof root);
    ASSERT_WITHIN(1e-9, sensor_scale(), of_number(s->noise[0]) / of_number(coupled.noise[0]));
    ASSERT_WITHIN(0, of_number(coupled.noise[1]), of_number(s->noise[1])); /* of U */
    ASSERT_OK(kq_forecast_q31(&track, p, NULL, 1, &twin));
    ASSERT_OK(kq_predict_q31(&track, &motion.process, NULL));
    TEST_ASSERT_EQUAL_MEMORY(twin_memory, track_memory, sizeof twin_memory);
    const int32_t *z = drawn(&seed, 2);
    ASSERT_OK(kq_update_q31(&twin, s, z));
    ASSERT_OK(kq_update_subset_q31(&track, &coupled.sensor, z, ALL));
    TEST_ASSERT_EQUAL_MEMORY(twin_memory, track_memory, sizeof twin_memory);
}

static void an_attach_keeps_what_was_learnt(void)
{
    uint32_t seed = 8;
    learn_something();
    const kq_adaptation_q31 before = tuner;
    ASSERT_OK(kq_filter_init_q31(&track, &start.table, NULL));
    ASSERT_OK(kq_attach_q31(&track, &tuner.attached));
    ASSERT_OK(kq_update_subset_q31(&track, &coupled.sensor, drawn(&seed, 20), ALL)); /* waits for two */
    TEST_ASSERT_EQUAL_MEMORY(&before.information, &tuner.information, sizeof tuner.information);
    ASSERT_WITHIN(0, of_number(before.process_scale), process_scale());
    ASSERT_OK(kq_update_subset_q31(&track, &coupled.sensor, drawn(&seed, 20), ALL));
    TEST_ASSERT_TRUE(memcmp(&before.information, &tuner.information, sizeof before.information));
}

/* (The objects have padding, and MemorySanitizer knows that.) */
static void assert_has_learnt_nothing(const kq_adaptation_q31 *before)
{
    TEST_ASSERT_EQUAL_INT(before->waiting, tuner.waiting);
    TEST_ASSERT_EQUAL_MEMORY(&before->process_scale, &tuner.process_scale, sizeof tuner.process_scale);
    TEST_ASSERT_EQUAL_MEMORY(&before->sensor_scale, &tuner.sensor_scale, sizeof tuner.sensor_scale);
    TEST_ASSERT_EQUAL_MEMORY(before->information, tuner.information, sizeof tuner.information);
}

/* Steps by which nothing may be learnt, beside a filter that has none to learn by */
static void other_models_are_taken_as_they_are(void)
{
    uint32_t seed = 6;
    learn_something();
    ASSERT_OK(kq_filter_copy_q31(&twin, &track));
    const kq_adaptation_q31 before = tuner;
    for (int t = 0; t < STEPS; t++) {
        const int32_t *z = drawn(&seed, 2);
        ASSERT_OK(kq_predict_q31(&track, &another.process, NULL));
        ASSERT_OK(kq_predict_q31(&twin, &another.process, NULL));
        ASSERT_OK(kq_update_subset_q31(&track, &radar.sensor, z, present_at(t)));
        ASSERT_OK(kq_update_subset_q31(&twin, &radar.sensor, z, present_at(t)));
        ASSERT_OK(kq_step_q31(&track, &another.process, NULL, &single.sensor, z));
        ASSERT_OK(kq_step_q31(&twin, &another.process, NULL, &single.sensor, z));
        ASSERT_SAME_Q31(&twin, &track);
    }
    assert_has_learnt_nothing(&before);
}

static void a_step_is_a_predict_and_an_update(void)
{
    KQ_ADAPTATION_Q31(other, 2, 2);
    const kq_sensor_q31 *sensors[] = {&radar.sensor, &coupled.sensor};
    for (int k = 0; k < 2; k++) {
        uint32_t seed = 6;
        ASSERT_OK(kq_filter_init_q31(&track, &start.table, NULL));
        ASSERT_OK(kq_filter_init_q31(&twin, &start.table, NULL));
        ASSERT_OK(kq_adaptation_init_q31(&tuner, &motion.process, sensors[k], &rule));
        ASSERT_OK(kq_adaptation_init_q31(&other, &motion.process, sensors[k], &rule));
        ASSERT_OK(kq_attach_q31(&track, &tuner.attached));
        ASSERT_OK(kq_attach_q31(&twin, &other.attached));
        for (int t = 0; t < STEPS; t++) {
            const kq_process_q31 *p = t % 5 == 4 ? &another.process : &motion.process;
            const kq_sensor_q31 *s = t % 7 == 5 ? &single.sensor : sensors[k];
            const int32_t *z = drawn(&seed, 2);
            ASSERT_OK(kq_predict_q31(&track, p, NULL));
            ASSERT_OK(kq_update_q31(&track, s, z));
            ASSERT_OK(kq_step_q31(&twin, p, NULL, s, z));
            ASSERT_SAME_Q31(&track, &twin);
        }
        TEST_ASSERT_EQUAL_MEMORY(tuner.information, other.information, sizeof tuner.information);
        TEST_ASSERT_TRUE(process_scale() != 1 && sensor_scale() != 1);
    }
}

static void assert_goes_on_alone(kq_filter_q31 *f)
{
    KQ_FILTER_Q31(alone, 2);
    uint32_t seed = 6;
    const kq_adaptation_q31 before = tuner;
    memcpy(alone_memory, f->memory, sizeof alone_memory);
    alone = *f;
    alone.memory = alone_memory;
    alone.attached = NULL;
    for (int t = 0; t < 3; t++) {
        const int32_t *z = drawn(&seed, 2);
        ASSERT_OK(kq_update_q31(f, &coupled.sensor, z));
        ASSERT_OK(kq_update_q31(&alone, &coupled.sensor, z));
        ASSERT_OK(kq_predict_q31(f, &motion.process, NULL));
        ASSERT_OK(kq_predict_q31(&alone, &motion.process, NULL));
        ASSERT_OK(kq_step_q31(f, &motion.process, NULL, &coupled.sensor, z));
        ASSERT_OK(kq_step_q31(&alone, &motion.process, NULL, &coupled.sensor, z));
        ASSERT_SAME_Q31(&alone, f);
    }
    assert_has_learnt_nothing(&before);
}

static void what_is_detached_or_copied_goes_on_by_itself(void)
{
    learn_something();
    ASSERT_OK(kq_filter_copy_q31(&twin, &track));
    assert_goes_on_alone(&twin);
    twin = track;
    twin.memory = twin_memory;
    assert_goes_on_alone(&twin);
    ASSERT_OK(kq_detach_q31(&tuner.attached));
    assert_goes_on_alone(&track);
    ASSERT_OK(kq_attach_q31(&twin, &tuner.attached));
    ASSERT_OK(kq_forecast_q31(&twin, kq_adaptation_process_q31(&tuner), NULL, 1, &track));
    ASSERT_OK(kq_predict_q31(&twin, &motion.process, NULL));
    TEST_ASSERT_EQUAL_MEMORY(track_memory, twin_memory, sizeof twin_memory);
}

/* ------------------------------------------------------------------------------ refusals */

static void refusals_of_assign(void)
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

static void refusals_of_init(void)
{
    kq_adaptation_q31 nothing = {.states = 0};
    WATCH(nothing);
    ASSERT_REFUSED(KQ_ERR_NULL, try_models(NULL, &radar.sensor));
    ASSERT_REFUSED(KQ_ERR_NULL, try_models(&motion.process, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL,
                   kq_adaptation_init_q31(&tuner, &motion.process, &radar.sensor, NULL));
    ASSERT_REFUSED_SIZE_OR_MEMORY(
        kq_adaptation_init_q31(&nothing, &motion.process, &radar.sensor, &rule));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, try_models(&blank_process, &radar.sensor));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, try_models(&motion.process, &blank_sensor));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, try_models(&motion3.process, &radar.sensor));
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

static void refusals_of_a_rule(void)
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

/* It has a filter until it is detached; f may have been initialised meanwhile. */
static void an_adaptation_has_one_filter(void)
{
    WATCH(twin);
    ASSERT_REFUSED(KQ_ERR_RECORDING, kq_attach_q31(&twin, &tuner.attached));
    ASSERT_OK(kq_attach_q31(&track, &tuner.attached)); /* to its own once more */
    ASSERT_OK(kq_filter_init_q31(&track, &start.table, NULL));
    ASSERT_REFUSED(KQ_ERR_RECORDING, kq_attach_q31(&twin, &tuner.attached));
    ASSERT_OK(kq_attach_q31(&track, &tuner.attached));
    ASSERT_OK(kq_detach_q31(&tuner.attached));
    ASSERT_OK(kq_attach_q31(&twin, &tuner.attached));
}

static void refusals_of_attach(void)
{
    KQ_FILTER_Q31(track3, 3);
    KQ_ADAPTATION_Q31(other, 2, 2);
    ASSERT_OK(kq_filter_init_q31(&track3, &start3.table, NULL));
    ASSERT_OK(kq_adaptation_init_q31(&other, &motion.process, &radar.sensor, &rule));
    WATCH(track3), WATCH(other), WATCH(other_memory), WATCH(tape);
    ASSERT_REFUSED(KQ_ERR_NULL, kq_attach_q31(&track, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_attach_q31(NULL, &tuner.attached));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_attach_q31(&track, &blank.attached));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_attach_q31(&blank_filter, &tuner.attached));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, kq_attach_q31(&track3, &tuner.attached));
    ASSERT_REFUSED(KQ_ERR_RECORDING, kq_attach_q31(&track, &other.attached));
    ASSERT_REFUSED(KQ_ERR_RECORDING, kq_attach_q31(&track, &tape.attached));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_detach_q31(NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_detach_q31(&blank.attached));
    ASSERT_OK(kq_detach_q31(&tuner.attached));
    ASSERT_OK(kq_attach_q31(&track, &tape.attached));
    ASSERT_REFUSED(KQ_ERR_RECORDING, kq_attach_q31(&track, &tuner.attached));
}

static void refusals_of_steps(void)
{
    KQ_FILTER_Q31(track3, 3);
    int32_t z[] = {INT32_MAX, 0}, u[] = {INT32_MAX};
    const kq_sensor_q31 *s = &radar.sensor;
    ASSERT_OK(kq_filter_init_q31(&track3, &start3.table, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_predict_q31(NULL, &motion.process, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_predict_q31(&track, NULL, NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_predict_q31(&track, &blank_process, NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_predict_q31(&blank_filter, &motion.process, NULL));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, kq_predict_q31(&track3, &motion.process, NULL));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, kq_predict_q31(&track, &motion3.process, NULL));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, kq_predict_q31(&track, &finer.process, NULL)); /* formats */
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_predict_q31(&track, &motion.process, u));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_update_subset_q31(&track, s, NULL, ALL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_update_subset_q31(&track, &blank_sensor, z, ALL));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, kq_update_subset_q31(&track3, s, z, 2));
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_update_subset_q31(&track, s, z, ALL));
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_update_q31(&track, s, z));
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_step_q31(&track, &motion.process, NULL, s, z));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, kq_step_q31(&track, &motion3.process, NULL, s, z));
    ASSERT_OK(kq_update_subset_q31(&track, s, z, 2));
    z[0] = 0;
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_step_q31(&track, &motion.process, u, s, z));
    ASSERT_OK(kq_step_q31(&track, &motion.process, NULL, s, z));
}

static void readings_of_nothing(void)
{
    static kq_scaled_q31 scales[2] = {{5, 6}, {7, 8}};
    WATCH(scales);
    ASSERT_REFUSED(KQ_ERR_NULL, kq_adaptation_scales_q31(NULL, &scales[0], &scales[1]));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_adaptation_scales_q31(&blank, &scales[0], &scales[1]));
    ASSERT_OK(kq_adaptation_scales_q31(&tuner, NULL, NULL));
    TEST_ASSERT_NULL(kq_adaptation_process_q31(&blank));
    TEST_ASSERT_NULL(kq_adaptation_sensor_q31(NULL));
}

SUITE(adaptation, set_up)
{
    RUN_TEST(scales_that_may_not_move_leave_the_bits);
    RUN_TEST(scales_are_those_of_double);
    RUN_TEST(steps_and_limits_are_kept);
    RUN_TEST(ends_of_the_numbers_are_safe);
    RUN_TEST(the_scaled_models_are_those_of_the_scales);
    RUN_TEST(an_attach_keeps_what_was_learnt);
    RUN_TEST(other_models_are_taken_as_they_are);
    RUN_TEST(a_step_is_a_predict_and_an_update);
    RUN_TEST(what_is_detached_or_copied_goes_on_by_itself);
    RUN_TEST(refusals_of_assign);
    RUN_TEST(refusals_of_init);
    RUN_TEST(refusals_of_a_rule);
    RUN_TEST(an_adaptation_has_one_filter);
    RUN_TEST(refusals_of_attach);
    RUN_TEST(refusals_of_steps);
    RUN_TEST(readings_of_nothing);
}
