/* The scales of the noises learnt on line, in all arithmetics: the formulas, bounds, the scaled models. */
#include "adaptation_textbook.h"
#include "models.h"
#include "unchanged.h"

#define ALL UINT32_MAX
#define STEPS 60

#ifdef KQ_TEST_Q31
#define FAR 900
#define FARTHEST 999
#define EPS_OF_SCALES 0x1p-29
#define ROUNDING_OF_NOISE 0x1p-29
#define FOLLOWED 200
#else
#define FAR 1e4
#define FARTHEST ((double)NUM_MAX / 4)
#define EPS_OF_SCALES EPS
#define ROUNDING_OF_NOISE 0
#define FOLLOWED 200
#endif

static process_model motion, another, three, unmade;
static sensor_model radar, coupled, single;
static prior_model prior;
S_FILTER(track, 2);
S_FILTER(twin, 2);
S_ADAPTATION(tuner, 2, 2);
S_ADAPTATION(blank_tuner, 2, 2);

static const num range[] = {1000, 1000, 1000}, measured_range[] = {1000, 1000}, drive_range[] = {100};
static const num A[] = {1, 0.5, -0.125, 0.75}, B[] = {0.125, 0.5}, Q[] = {0.25, 0.125, 0.125, 0.5};
static const num H[] = {1, 0, 0.5, 1}, R[] = {0.5, 0.25, 0.25, 1}, r[] = {0.5, 1};
static const num x0[] = {1, -2}, P0[] = {2, 0.5, 0.5, 1}, identity3[] = {1, 0, 0, 0, 1, 0, 0, 0, 1};

static num z_value[2];
static word z[2], u[1];
static S(adaptation_rule) rule;

static void set_z(double a, double b)
{
    z_value[0] = N(a), z_value[1] = N(b);
    memcpy(z, measured(&radar.sensor, z_value), sizeof z);
}

static void draw(uint32_t *seed, double size)
{
    const double a = size * (double)noise(seed), b = size * (double)noise(seed);
    set_z(a, b);
}

static void set_up(void)
{
    const num push = 2;
    rule = usual_rule();
    put_process(&motion, 2, 1, range, drive_range, A, B, Q);
    put_process(&another, 2, 1, range, drive_range, A, B, P0);
    put_process(&three, 3, 0, range, NULL, identity3, NULL, identity3);
    put_independent(&radar, 2, 2, range, measured_range, H, r);
    put_sensor(&coupled, 2, 2, range, measured_range, H, R);
    put_independent(&single, 2, 1, range, measured_range, H, r);
    put_prior(&prior, 2, range, x0, P0);
    set_z(1.5, -0.5);
    memcpy(u, driven(&motion.process, &push, 1), sizeof u);
    ASSERT_OK(init_filter(&track, &prior));
    ASSERT_OK(init_filter(&twin, &prior));
    ASSERT_OK(ASSIGN_ADAPTATION(tuner, 2, 2));
    ASSERT_OK(S(adaptation_init)(&tuner, &motion.process, &radar.sensor, &rule));
    ASSERT_OK(S(attach)(&track, &tuner.attached));
    watch_nothing();
    WATCH(motion.process), WATCH(radar.sensor), WATCH(track), WATCH(track_memory), WATCH(tuner), WATCH(tuner_memory);
    WATCH(blank_tuner), WATCH(rule), WATCH(z), WATCH(u);
}

/* The scale of the process or of the sensor, or of none */
static entry scale_of(const S(adaptation) *a, int is_process)
{
    entry scale = number(0);
    ASSERT_OK(S(adaptation_scales)(a, is_process ? &scale : NULL, is_process ? NULL : &scale));
    return scale;
}

static double process_scale(void) { return number_of(scale_of(&tuner, 1)); }
static double sensor_scale(void) { return number_of(scale_of(&tuner, 0)); }

/* (The objects have padding, and MemorySanitizer knows that.) */
static void assert_learnt_nothing(const S(adaptation) *before)
{
    TEST_ASSERT_EQUAL_INT(before->waiting, tuner.waiting);
    ASSERT_SAME_BITS(before->process_scale, tuner.process_scale);
    ASSERT_SAME_BITS(before->sensor_scale, tuner.sensor_scale);
    TEST_ASSERT_EQUAL_MEMORY(before->information, tuner.information, sizeof tuner.information);
}

/* Both, by turns one or the other, none */
static uint32_t present_at(int t)
{
    static const uint32_t masks[] = {3, 3, 1, 3, 2, 3, 0};
    return masks[t % COUNT(masks)];
}

TEST(scales_that_may_not_move_leave_the_bits)
{
    uint32_t seed = 1;
    const S(sensor) * sensors[] = {&radar.sensor, &coupled.sensor};
    rule.process_least = rule.process_most = rule.sensor_least = rule.sensor_most = number(1);
    for (int k = 0; k < 2; k++) {
        ASSERT_OK(S(adaptation_init)(&tuner, &motion.process, sensors[k], &rule));
        for (int t = 0; t < STEPS; t++) {
            draw(&seed, 2);
            ASSERT_OK(S(update_subset)(&track, sensors[k], z, present_at(t)));
            ASSERT_OK(S(update_subset)(&twin, sensors[k], z, present_at(t)));
            ASSERT_SAME(&twin, &track, 2);
            ASSERT_OK(S(predict)(&track, &motion.process, t % 2 ? u : NULL));
            ASSERT_OK(S(predict)(&twin, &motion.process, t % 2 ? u : NULL));
            ASSERT_SAME(&twin, &track, 2);
        }
    }
}

TEST(learning_begins_after_n_measurements)
{
    for (int k = 0; k < 2; k++) {
        ASSERT_OK(S(update_subset)(&track, &radar.sensor, z, 1));
        ASSERT_WITHIN(0, 1, process_scale());
        ASSERT_WITHIN(0, 1, sensor_scale());
        ASSERT_OK(S(predict)(&track, &motion.process, u));
    }
    set_z(20, (double)z_value[1]);
    ASSERT_OK(S(update_subset)(&track, &radar.sensor, z, 1));
    TEST_ASSERT_TRUE(process_scale() > 1 && sensor_scale() > 1);
}

TEST(without_a_measurement_nothing_is_learnt)
{
    uint32_t seed = 2;
    for (int t = 0; t < 10; t++) {
        draw(&seed, 2);
        ASSERT_OK(S(update_subset)(&track, &radar.sensor, z, ALL));
        ASSERT_OK(S(predict)(&track, &motion.process, u));
    }
    const S(adaptation) before = tuner;
    z[0] = z[1] = bad_word(&radar.sensor, 0); /* not read */
    for (int t = 0; t < 5; t++) {
        ASSERT_OK(S(update_subset)(&track, &radar.sensor, z, 0));
        ASSERT_OK(S(predict)(&track, &motion.process, u));
    }
    assert_learnt_nothing(&before);
}

static void assert_step(double before, double now)
{
    const double most = 1.125 * (1 + 4 * EPS_OF_SCALES);
    TEST_ASSERT_TRUE(now <= before * most && now >= before / most);
}

/* Measurements out of all proportion, then none that differ from what is expected */
TEST(steps_and_limits_are_kept)
{
    int moved = 0;
    for (int t = 0; t < 1000; t++) {
        const double q = process_scale(), s = sensor_scale();
        if (t < 200) set_z(t % 2 ? FAR : -FAR, t % 2 ? -FAR : FAR);
        else ASSERT_OK(S(measurement)(&track, &radar.sensor, z, NULL));
        ASSERT_OK(S(update_subset)(&track, &radar.sensor, z, ALL));
        assert_step(q, process_scale());
        assert_step(s, sensor_scale());
        moved += process_scale() != q;
        TEST_ASSERT_TRUE(process_scale() >= 0.0625 && process_scale() <= 16);
        TEST_ASSERT_TRUE(sensor_scale() >= 0.125 && sensor_scale() <= 8);
        if (t == 199) ASSERT_WITHIN(0, 8, sensor_scale());
        ASSERT_OK(S(predict)(&track, &motion.process, NULL));
    }
    ASSERT_WITHIN(0, 0.125, sensor_scale());
    TEST_ASSERT_TRUE(moved > 10);
}

/* 5 sigma or all the sigmas there are: the scales do not know. */
TEST(an_outlier_counts_as_four_sigma)
{
    const double outliers[] = {30, FAR < 1000 ? FAR : 1000, FARTHEST};
    entry found[COUNT(outliers)][2];
    for (int k = 0; k < COUNT(outliers); k++) {
        uint32_t seed = 2;
        ASSERT_OK(init_filter(&track, &prior));
        ASSERT_OK(S(adaptation_init)(&tuner, &motion.process, &radar.sensor, &rule));
        ASSERT_OK(S(attach)(&track, &tuner.attached));
        for (int t = 0; t < 10; t++) {
            draw(&seed, 2);
            ASSERT_OK(S(update_subset)(&track, &radar.sensor, z, 1));
            ASSERT_OK(S(predict)(&track, &motion.process, u));
        }
        set_z(outliers[k], 0);
        ASSERT_OK(S(update_subset)(&track, &radar.sensor, z, 1));
        ASSERT_OK(S(adaptation_scales)(&tuner, &found[k][0], &found[k][1]));
    }
    ASSERT_SAME_BITS(found[0], found[1]);
    ASSERT_SAME_BITS(found[0], found[2]);
}

TEST(no_noise_stays_none)
{
    static const num zero[] = {0, 0, 0, 0}, sharp[] = {0, 1};
    uint32_t seed = 9;
    put_process(&motion, 2, 1, range, drive_range, A, B, zero);
    put_independent(&radar, 2, 2, range, measured_range, H, sharp);
    ASSERT_OK(S(adaptation_init)(&tuner, &motion.process, &radar.sensor, &rule));
    for (int t = 0; t < STEPS; t++) {
        draw(&seed, 2);
        ASSERT_OK(S(update_subset)(&track, &radar.sensor, z, ALL));
        ASSERT_OK(S(predict)(&track, &motion.process, u));
    }
    TEST_ASSERT_TRUE(sensor_scale() != 1);
    const entry *scaled = S(adaptation_sensor)(&tuner)->noise, *given = radar.sensor.noise;
    TEST_ASSERT_EQUAL_MEMORY(motion.process.noise_root, S(adaptation_process)(&tuner)->noise_root, S_ROOT_LEN(2) * sizeof(word));
    TEST_ASSERT_TRUE(number_of(scaled[0]) == number_of(given[0]));
    ASSERT_WITHIN(ROUNDING_OF_NOISE * sensor_scale(), sensor_scale(), number_of(scaled[1]) / number_of(given[1]));
}

static void learn_something(void)
{
    uint32_t seed = 4;
    ASSERT_OK(S(adaptation_init)(&tuner, &motion.process, &coupled.sensor, &rule));
    ASSERT_OK(S(attach)(&track, &tuner.attached));
    for (int t = 0; t < STEPS; t++) {
        draw(&seed, 2);
        ASSERT_OK(S(update_subset)(&track, &coupled.sensor, z, present_at(t)));
        ASSERT_OK(S(predict)(&track, &motion.process, u));
    }
    TEST_ASSERT_TRUE(fabs(log(process_scale())) > 0.1 && fabs(log(sensor_scale())) > 0.1);
}

/* The process that scaling by hand makes of `motion`, and its noise root */
static const S(process) *scaled_by_hand(void)
{
    static process_model expected;
    put_process(&expected, 2, 1, range, drive_range, A, B, Q);
    ASSERT_OK(scale_noise(&expected, &motion, scale_of(&tuner, 1)));
    return &expected.process;
}

static void assert_next_steps(const S(process) *p)
{
    ASSERT_OK(S(forecast)(&track, p, u, 1, &twin));
    ASSERT_OK(S(predict)(&track, &motion.process, u));
    ASSERT_SAME_BITS(twin_memory, track_memory);
    ASSERT_OK(S(update)(&twin, S(adaptation_sensor)(&tuner), z));
    ASSERT_OK(S(update_subset)(&track, &coupled.sensor, z, ALL));
    ASSERT_SAME_BITS(twin_memory, track_memory);
}

TEST(the_scaled_models_are_those_of_the_scales)
{
    num cov[4], cov0[4], mean[2];
    learn_something();
    const S(process) *p = S(adaptation_process)(&tuner);
    TEST_ASSERT_EQUAL_MEMORY(scaled_by_hand()->noise_root, p->noise_root, S_ROOT_LEN(2) * sizeof(word));
    ASSERT_OK(read_measurement(&track, &coupled.sensor, mean, cov0));
    ASSERT_OK(read_measurement(&track, S(adaptation_sensor)(&tuner), mean, cov));
    for (int k = 0; k < 4; k++) {
        ASSERT_WITHIN(ROUNDING * 8, (sensor_scale() - 1) * (double)R[k], (double)cov[k] - (double)cov0[k]);
    }
    assert_next_steps(p);
}

TEST(another_model_is_that_of_the_next_step)
{
    static const num A2[] = {0.5, 0.25, 0, 1}, H2[] = {0, 1, 1, 1};
    learn_something();
    ASSERT_OK(change_transition(&motion, 2, A2));
    ASSERT_OK(change_measurement(&coupled, 2, 2, H2));
    assert_next_steps(scaled_by_hand());
}

TEST(an_attach_keeps_what_was_learnt)
{
    learn_something();
    const S(adaptation) before = tuner;
    ASSERT_OK(init_filter(&track, &prior));
    ASSERT_OK(S(attach)(&track, &tuner.attached));
    set_z(20, (double)z_value[1]);
    ASSERT_OK(S(update_subset)(&track, &coupled.sensor, z, ALL)); /* waits for two */
    assert_learnt_nothing(&before);
    ASSERT_OK(S(detach)(&tuner.attached));
    ASSERT_OK(S(attach)(&twin, &tuner.attached)); /* of another filter it scales the process, too */
    ASSERT_OK(S(forecast)(&twin, S(adaptation_process)(&tuner), u, 1, &track));
    ASSERT_OK(S(predict)(&twin, &motion.process, u));
    ASSERT_SAME_BITS(track_memory, twin_memory);
    TEST_ASSERT_TRUE(fabs(log(process_scale())) > 0.1);
    ASSERT_OK(S(adaptation_init)(&tuner, &motion.process, &coupled.sensor, &rule));
    ASSERT_WITHIN(0, 1, process_scale());
    ASSERT_WITHIN(0, 1, sensor_scale());
}

/* Steps by which nothing may be learnt, beside a filter that has none to learn by */
TEST(other_models_are_taken_as_they_are)
{
    uint32_t seed = 6;
    learn_something();
    ASSERT_OK(S(filter_copy)(&twin, &track));
    const S(adaptation) before = tuner;
    entry memory[COUNT(tuner_memory)];
    memcpy(memory, tuner_memory, sizeof memory);
    for (int t = 0; t < STEPS; t++) {
        draw(&seed, 2);
        const uint32_t present = present_at(t);
        ASSERT_OK(S(predict)(&track, &another.process, u));
        ASSERT_OK(S(predict)(&twin, &another.process, u));
        ASSERT_OK(S(update_subset)(&track, &radar.sensor, z, present));
        ASSERT_OK(S(update_subset)(&twin, &radar.sensor, z, present));
        ASSERT_OK(S(update)(&track, &single.sensor, z));
        ASSERT_OK(S(update)(&twin, &single.sensor, z));
        ASSERT_OK(S(step)(&track, &another.process, u, &radar.sensor, z));
        ASSERT_OK(S(step)(&twin, &another.process, u, &radar.sensor, z));
        ASSERT_SAME(&twin, &track, 2);
    }
    assert_learnt_nothing(&before);
    TEST_ASSERT_EQUAL_MEMORY(memory, tuner_memory, sizeof memory);
    /* one of the two may be another */
    ASSERT_OK(S(step)(&track, &another.process, u, &coupled.sensor, z));
    TEST_ASSERT_TRUE(memcmp(before.information, tuner.information, sizeof before.information) != 0);
}

TEST(a_step_is_a_predict_and_an_update)
{
    S_ADAPTATION(other, 2, 2);
    const S(sensor) * sensors[] = {&radar.sensor, &coupled.sensor, &single.sensor};
    for (int k = 0; k < 2; k++) {
        uint32_t seed = 6;
        ASSERT_OK(init_filter(&track, &prior));
        ASSERT_OK(init_filter(&twin, &prior));
        ASSERT_OK(S(adaptation_init)(&tuner, &motion.process, sensors[k], &rule));
        ASSERT_OK(S(adaptation_init)(&other, &motion.process, sensors[k], &rule));
        ASSERT_OK(S(attach)(&track, &tuner.attached));
        ASSERT_OK(S(attach)(&twin, &other.attached));
        for (int t = 0; t < STEPS; t++) {
            const S(process) *p = t % 5 == 4 ? &another.process : &motion.process;
            const S(sensor) *s = t % 7 == 5 ? &single.sensor : sensors[k];
            draw(&seed, 2);
            ASSERT_OK(S(predict)(&track, p, u));
            ASSERT_OK(S(update)(&track, s, z));
            ASSERT_OK(S(step)(&twin, p, u, s, z));
            ASSERT_SAME(&track, &twin, 2);
            TEST_ASSERT_TRUE(number_of(scale_of(&other, 1)) == process_scale());
            TEST_ASSERT_TRUE(number_of(scale_of(&other, 0)) == sensor_scale());
        }
        TEST_ASSERT_TRUE(sensor_scale() != 1 && process_scale() != 1);
    }
}

/* The models that it refers to have become others */
TEST(refusals_of_models_that_changed)
{
    const S(process) kept = motion.process;
    const S(sensor) kept_sensor = radar.sensor;
    motion.process = three.process;
    ASSERT_REFUSED(KQ_ERR_MISMATCH, S(predict)(&track, &motion.process, u));
    TEST_ASSERT_NULL(S(adaptation_process)(&tuner));
    motion.process = unmade.process;
    ASSERT_REFUSED(KQ_ERR_NOT_READY, S(predict)(&track, &motion.process, u));
    motion.process = kept;
    radar.sensor = single.sensor;
    ASSERT_REFUSED(KQ_ERR_MISMATCH, S(update_subset)(&track, &radar.sensor, z, ALL));
    TEST_ASSERT_NULL(S(adaptation_sensor)(&tuner));
    radar.sensor = kept_sensor;
    ASSERT_OK(S(update_subset)(&track, &radar.sensor, z, ALL));
}

TEST(readings_of_nothing)
{
    entry scales[2] = {number(5), number(6)};
    WATCH(scales);
    ASSERT_REFUSED(KQ_ERR_NULL, S(adaptation_scales)(NULL, &scales[0], &scales[1]));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, S(adaptation_scales)(&blank_tuner, &scales[0], &scales[1]));
    ASSERT_OK(S(adaptation_scales)(&tuner, NULL, NULL));
    TEST_ASSERT_NULL(S(adaptation_process)(NULL));
    TEST_ASSERT_NULL(S(adaptation_sensor)(&blank_tuner));
    TEST_ASSERT_NULL(S(adaptation_process)(&blank_tuner));
    TEST_ASSERT_NULL(S(adaptation_sensor)(NULL));
}

/* ------------------------------------------------------------------------------ the formulas */

#ifdef KQ_TEST_Q31
#define ROUNDING_OF_SCALES 1e-6
#else
#define ROUNDING_OF_SCALES (2048 * EPS)
#endif

static void put_textbook(scale_textbook *t, const num *noise_covariance)
{
    memset(t, 0, sizeof *t);
    for (int k = 0; k < 4; k++) {
        t->A[k] = (double)A[k], t->Q[k] = (double)Q[k], t->H[k] = (double)H[k];
        t->R[k] = (double)noise_covariance[k], t->P[k] = (double)P0[k];
    }
    t->x[0] = (double)x0[0], t->x[1] = (double)x0[1];
    t->q = t->r = 1;
    t->waiting = 2;
}

/* With q e^h from the beginning on: the textbook's score of its last measurement, of one component,
   and *log_likelihood of it but for a constant */
static double score_at(double h, int last, double *log_likelihood)
{
    scale_textbook book;
    uint32_t seed = 3;
    put_textbook(&book, R);
    book.q = exp(h);
    for (int t = 0; t <= last; t++) {
        double J[3] = {0, 0, 0};
        draw(&seed, 2);
        const double seen[] = {(double)z_value[0] / 4, 0};
        const double S = book.P[0] + book.R[0], e = seen[0] - book.x[0];
        *log_likelihood = -(log(S) + e * e / S) / 2;
        (void)textbook_measure(&book, seen, 1, J);
        textbook_predict(&book);
    }
    return book.g[0];
}

/* A double of 32 bits (AVR) is too short for differences. */
TEST(the_formulas_are_those_of_likelihood)
{
    const double h = DBL_MANT_DIG > 24 ? 1e-4 : 0.0625;
    const double tolerance = DBL_MANT_DIG > 24 ? 1e-7 : 1e-2;
    for (int last = 0; last < 20; last++) {
        double here, above, below;
        const double score = score_at(0, last, &here);
        (void)score_at(h, last, &above);
        (void)score_at(-h, last, &below);
        ASSERT_WITHIN(tolerance, (above - below) / (2 * h), score);
    }
}

/* A plant with Q and R 4 times and a quarter of what is said */
TEST(the_scales_of_a_plant_are_found)
{
    static const num one[] = {1}, none[] = {0};
    static process_model walk;
    static sensor_model gauge;
    static prior_model start;
    S_FILTER(level, 1);
    S_ADAPTATION(finder, 1, 1);
    uint32_t seed = 5;
    num x = 0;
    entry q, s;
    rule.memory = 400;
    put_process(&walk, 1, 0, range, NULL, one, NULL, one);
    put_sensor(&gauge, 1, 1, range, range, one, one);
    put_prior(&start, 1, range, none, one);
    ASSERT_OK(init_filter(&level, &start));
    ASSERT_OK(S(adaptation_init)(&finder, &walk.process, &gauge.sensor, &rule));
    ASSERT_OK(S(attach)(&level, &finder.attached));
    for (int t = 0; t < 1500; t++) {
        const num seen = x + noise(&seed) * 2;
        ASSERT_OK(S(update_subset)(&level, &gauge.sensor, measured(&gauge.sensor, &seen), ALL));
        ASSERT_OK(S(predict)(&level, &walk.process, NULL));
        x += noise(&seed) / 2;
    }
    ASSERT_OK(S(adaptation_scales)(&finder, &q, &s));
    ASSERT_WITHIN(0.4, log(0.25), log(number_of(q)));
    ASSERT_WITHIN(0.25, log(4), log(number_of(s)));
}

static void follow_the_textbook(const S(sensor) *s, const num *noise_covariance, kq_adapted scales)
{
    scale_textbook book;
    reading now;
    uint32_t seed = 7;
    rule.scales = scales;
    put_textbook(&book, noise_covariance);
    ASSERT_OK(init_filter(&track, &prior));
    ASSERT_OK(S(adaptation_init)(&tuner, &motion.process, s, &rule));
    ASSERT_OK(S(attach)(&track, &tuner.attached));
    for (int t = 0; t < FOLLOWED; t++) {
        draw(&seed, t % 80 == 20 ? 40 : 2); /* an outlier now and then */
        const double seen[] = {measured_value(s, z[0], 0), measured_value(s, z[1], 1)};
        ASSERT_OK(S(update_subset)(&track, s, z, present_at(t)));
        textbook_update(&book, seen, present_at(t), (int)scales, 50, 0.125);
        book.q = fmax(0.0625, fmin(16, book.q)), book.r = fmax(0.125, fmin(8, book.r)); /* the rule's limits */
        ASSERT_WITHIN(ROUNDING_OF_SCALES * book.q, book.q, process_scale());
        ASSERT_WITHIN(ROUNDING_OF_SCALES * book.r, book.r, sensor_scale());
        read_now(&now, &track, 2);
        for (int i = 0; i < 2; i++) {
            ASSERT_WITHIN(ROUNDING_OF_SCALES * (8 + fabs(book.x[i])), book.x[i], whole(&now, i));
            ASSERT_WITHIN(ROUNDING_OF_SCALES * 8 * book.P[3 * i], book.P[3 * i], now.P[3 * i]);
        }
        ASSERT_OK(S(predict)(&track, &motion.process, NULL));
        textbook_predict(&book);
    }
    TEST_ASSERT_TRUE(fabs(log(process_scale())) + fabs(log(sensor_scale())) > 0.2);
}

TEST(scales_follow_the_formulas)
{
    static const num diagonal[] = {N(0.5), 0, 0, 1};
    for (int scales = KQ_ADAPT_BOTH; scales <= KQ_ADAPT_SENSOR; scales++) {
        follow_the_textbook(&radar.sensor, diagonal, (kq_adapted)scales);
        follow_the_textbook(&coupled.sensor, R, (kq_adapted)scales);
    }
}

static kq_status try_init(void)
{
    return S(adaptation_init)(&tuner, &motion.process, &radar.sensor, &rule);
}

static void assert_bad_number(entry *number_of_rule, entry bad, kq_status status)
{
    const entry good = *number_of_rule;
    *number_of_rule = bad;
    ASSERT_REFUSED(status, try_init());
    *number_of_rule = good;
}

TEST(refusals_of_a_rule)
{
    entry *numbers[] = {&rule.step, &rule.process_least, &rule.process_most, &rule.sensor_least, &rule.sensor_most};
    for (int k = 0; k < COUNT(numbers); k++) {
        assert_bad_number(numbers[k], bad_entry(0), NOT_AN_ENTRY);
        assert_bad_number(numbers[k], bad_entry(1), NOT_AN_ENTRY);
        assert_bad_number(numbers[k], number(0), KQ_ERR_RANGE);
        assert_bad_number(numbers[k], number(-1), KQ_ERR_RANGE);
    }
    assert_bad_number(&rule.step, number(1.5), KQ_ERR_RANGE);
    assert_bad_number(&rule.process_least, number(1.5), KQ_ERR_RANGE);
    assert_bad_number(&rule.sensor_least, number(1.5), KQ_ERR_RANGE);
    assert_bad_number(&rule.process_most, number(0.5), KQ_ERR_RANGE);
    assert_bad_number(&rule.sensor_most, number(0.5), KQ_ERR_RANGE);
    static const int32_t lengths[] = {INT32_MIN, 0, KQ_ADAPTATION_MEMORY_MIN - 1, KQ_ADAPTATION_MEMORY_MAX + 1, INT32_MAX};
    for (int k = 0; k < COUNT(lengths); k++) {
        rule.memory = lengths[k];
        ASSERT_REFUSED(KQ_ERR_SIZE, try_init());
    }
    rule.memory = KQ_ADAPTATION_MEMORY_MAX;
    rule.scales = (kq_adapted)3;
    ASSERT_REFUSED(KQ_ERR_RANGE, try_init());
    rule.scales = KQ_ADAPT_SENSOR;
    ASSERT_OK(try_init());
}

TEST(an_adaptation_has_the_sizes_of_its_models)
{
    S(adaptation) none = {.states = 0}, short_one = tuner;
    short_one.length--;
    WATCH(none), WATCH(short_one);
    ASSERT_REFUSED_SIZE_OR_MEMORY(S(adaptation_init)(&none, &motion.process, &radar.sensor, &rule));
    ASSERT_REFUSED(KQ_ERR_MEMORY, S(adaptation_init)(&short_one, &motion.process, &radar.sensor, &rule));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, S(adaptation_init)(&tuner, &motion.process, &single.sensor, &rule));
}

#ifdef KQ_TEST_Q31
static kq_scaled_q31 power(int k) { return (kq_scaled_q31){INT32_C(1) << 30, k - 30}; }

TEST_Q31(refusals_of_what_cannot_be_scaled)
{
    assert_bad_number(&rule.step, power(1031), KQ_ERR_COEFFICIENT);
    assert_bad_number(&rule.sensor_most, power(1025), KQ_ERR_COEFFICIENT); /* times R */
    rule.sensor_least = power(-960);
    ASSERT_OK(try_init());
    radar.noise[1] = power(-50); /* times that */
    ASSERT_REFUSED(KQ_ERR_COEFFICIENT, try_init());
}

TEST_Q31(an_adaptation_has_the_formats_of_its_models)
{
    static const double fine_range[] = {1000, 1}, I[] = {1, 0, 0, 1};
    put_process(&another, 2, 0, fine_range, NULL, I, NULL, Q);
    ASSERT_REFUSED(KQ_ERR_MISMATCH, kq_adaptation_init_q31(&tuner, &another.process, &radar.sensor, &rule));
}

/* States that nothing measures and nothing moves, for as long as it takes their slopes to vanish;
   noise-free components; a noise as large as a table may say */
TEST_Q31(ends_of_the_numbers_are_safe)
{
    static const double fading[] = {0.5, 0, 0, 0.25}, still[] = {0, 0, 0, 0};
    const kq_scaled_q31 odd_noise[][2] = {{{0, 0}, {0, 0}}, {power(900), power(-900)}};
    rule.sensor_least = power(-40), rule.sensor_most = power(40);
    for (int k = 0; k < 4; k++) {
        uint32_t seed = 3;
        put_process(&motion, 2, 1, range, drive_range, fading, B, k % 2 ? still : Q);
        radar.noise[0] = odd_noise[k / 2][0], radar.noise[1] = odd_noise[k / 2][1];
        ASSERT_OK(kq_sensor_init_q31(&radar.sensor, &radar.table, NULL));
        ASSERT_OK(kq_filter_init_q31(&track, &prior.table, NULL));
        ASSERT_OK(kq_adaptation_init_q31(&tuner, &motion.process, &radar.sensor, &rule));
        ASSERT_OK(kq_attach_q31(&track, &tuner.attached));
        for (int t = 0; t < 2000; t++) {
            draw(&seed, 2);
            ASSERT_OK(kq_update_subset_q31(&track, &radar.sensor, z, t < 1000 ? 3 : 0));
            ASSERT_OK(kq_predict_q31(&track, &motion.process, NULL));
        }
        TEST_ASSERT_TRUE(process_scale() >= 0.0625 && process_scale() <= 16);
        TEST_ASSERT_TRUE(sensor_scale() >= 0x1p-40 && sensor_scale() <= 0x1p40);
    }
}
#else
/* A noise that a scale would lead out of the numbers */
TEST_FLOAT(refusals_of_what_cannot_be_scaled)
{
    static const num huge[] = {NUM_MAX / 64, NUM_MAX / 128, NUM_MAX / 128, NUM_MAX / 64};
    static const num variances[] = {NUM_MAX / 64, NUM_MAX / 128};
    put_sensor(&coupled, 2, 2, range, measured_range, H, huge);
    put_independent(&radar, 2, 2, range, measured_range, H, variances);
    ASSERT_OK(S(adaptation_init)(&tuner, &motion.process, &coupled.sensor, &rule));
    ASSERT_OK(try_init());
    rule.sensor_most = 128;
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, S(adaptation_init)(&tuner, &motion.process, &coupled.sensor, &rule));
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, try_init());
}

/* A state that grows and is not seen, until P has left the numbers */
TEST_FLOAT(what_leaves_the_numbers_is_forgotten)
{
    static const num growing[] = {1, 0, 0, 1024}, seen[] = {1, 0};
    S_ADAPTATION(other, 2, 1);
    entry q, s;
    ASSERT_OK(S(detach)(&tuner.attached));
    put_process(&motion, 2, 1, range, drive_range, growing, B, Q);
    put_independent(&single, 2, 1, range, measured_range, seen, r);
    ASSERT_OK(S(adaptation_init)(&other, &motion.process, &single.sensor, &rule));
    ASSERT_OK(S(attach)(&track, &other.attached));
    for (int t = 0; t < 200; t++) {
        ASSERT_OK(S(update_subset)(&track, &single.sensor, z, 1));
        ASSERT_OK(S(predict)(&track, &motion.process, u));
    }
    ASSERT_OK(S(adaptation_scales)(&other, &q, &s));
    TEST_ASSERT_TRUE(q > 0 && q <= 16 && s > 0 && s <= 8);
}
#endif

SUITE(learning, set_up)
#include "learning.tests"
