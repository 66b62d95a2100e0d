/* The scales of the noises learnt on line: beside the formulas in double, bounds, refusals. */
#include "adaptation_textbook.h"
#include "reading.h"
#include "sizes.h"
#include "unchanged.h"

#define ALL UINT32_MAX
#define STEPS 60

PROCESS(motion, 2, 1);
PROCESS(another, 2, 1);
SENSOR(radar, 2, 2);
SENSOR(coupled, 2, 2);
FILTER(track, 2);
FILTER(twin, 2);
FILTER(third, 2);
ADAPTATION(tuner, 2, 2);
HISTORY(tape, 2, 2, 8, 0);

/* never initialised, and of other sizes */
FILTER(blank, 2);
FILTER(track3, 3);
PROCESS(blank_process, 2, 1);
PROCESS(motion3, 3, 0);
SENSOR(blank_sensor, 2, 2);
SENSOR(radar3, 3, 2);
SENSOR(single, 2, 1);
ADAPTATION(blank_tuner, 2, 2);

static const num A[] = {1, 0.5, -0.125, 0.75}, B[] = {0.125, 0.5};
static const num Q[] = {0.25, 0.125, 0.125, 0.5};
static const num H[] = {1, 0, 0.5, 1}, R[] = {0.5, 0.25, 0.25, 1}, r[] = {0.5, 1};
static const num x0[] = {1, -2}, P0[] = {2, 0.5, 0.5, 1};
static const num identity3[] = {1, 0, 0, 0, 1, 0, 0, 0, 1};

static num z[2], u[1];
static K(adaptation_rule) rule;

static void set_up(void)
{
    z[0] = 1.5, z[1] = -0.5, u[0] = 2;
    rule = (K(adaptation_rule)){KQ_ADAPT_BOTH, 50, 0.125, 0.0625, 16, 0.125, 8};
    ASSERT_OK(K(process_init)(&motion, A, B, Q));
    ASSERT_OK(K(process_init)(&another, A, B, P0));
    ASSERT_OK(K(process_init)(&motion3, identity3, NULL, identity3));
    ASSERT_OK(K(sensor_init_diagonal)(&radar, H, r));
    ASSERT_OK(K(sensor_init)(&coupled, H, R));
    ASSERT_OK(K(sensor_init_diagonal)(&radar3, identity3, r));
    ASSERT_OK(K(sensor_init_diagonal)(&single, H, r));
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    ASSERT_OK(K(filter_init)(&twin, x0, P0));
    ASSERT_OK(K(filter_init)(&track3, identity3, identity3));
    ASSERT_OK(K(adaptation_assign)(&tuner, 2, 2, tuner_memory, COUNT(tuner_memory)));
    ASSERT_OK(K(adaptation_init)(&tuner, &motion, &radar, &rule));
    ASSERT_OK(K(attach)(&track, &tuner.attached));
    watch_nothing();
    WATCH(motion), WATCH(motion_memory), WATCH(radar), WATCH(radar_memory), WATCH(track);
    WATCH(track_memory), WATCH(tuner), WATCH(tuner_memory), WATCH(blank_tuner), WATCH(rule);
    WATCH(z), WATCH(u);
}

static num process_scale_of(const K(adaptation) * a)
{
    num q = (num)NAN;
    ASSERT_OK(K(adaptation_scales)(a, &q, NULL));
    return q;
}

static num sensor_scale_of(const K(adaptation) * a)
{
    num r = (num)NAN;
    ASSERT_OK(K(adaptation_scales)(a, NULL, &r));
    return r;
}

static double process_scale(void) { return (double)process_scale_of(&tuner); }
static double sensor_scale(void) { return (double)sensor_scale_of(&tuner); }

/* Both, by turns one or the other, none */
static uint32_t present_at(int t)
{
    static const uint32_t masks[] = {3, 3, 1, 3, 2, 3, 0};
    return masks[t % COUNT(masks)];
}

static void draw(uint32_t *seed)
{
    for (int c = 0; c < 2; c++) z[c] = 2 * noise(seed);
}

/* ------------------------------------------------------------------------------ what is learnt */

static void scales_that_may_not_move_leave_the_bits(void)
{
    uint32_t seed = 1;
    const K(sensor) * sensors[] = {&radar, &coupled};
    rule.process_least = rule.process_most = rule.sensor_least = rule.sensor_most = 1;
    for (int k = 0; k < 2; k++) {
        ASSERT_OK(K(adaptation_init)(&tuner, &motion, sensors[k], &rule));
        for (int t = 0; t < STEPS; t++) {
            draw(&seed);
            ASSERT_OK(K(update_subset)(&track, sensors[k], z, present_at(t)));
            ASSERT_OK(K(update_subset)(&twin, sensors[k], z, present_at(t)));
            ASSERT_SAME_FILTER(&twin, &track, 2);
            ASSERT_OK(K(predict)(&track, &motion, t % 2 ? u : NULL));
            ASSERT_OK(K(predict)(&twin, &motion, t % 2 ? u : NULL));
            ASSERT_SAME_FILTER(&twin, &track, 2);
        }
    }
}

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

static void textbook_takes(scale_textbook *t, uint32_t present)
{
    const double wide[] = {(double)z[0], (double)z[1]};
    textbook_update(t, wide, present, (int)rule.scales, 50, 0.125);
}

static void follow_the_textbook(const K(sensor) * s, const num *noise_covariance, kq_adapted scales)
{
    scale_textbook book;
    uint32_t seed = 7;
    rule.scales = scales;
    put_textbook(&book, noise_covariance);
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    ASSERT_OK(K(adaptation_init)(&tuner, &motion, s, &rule));
    ASSERT_OK(K(attach)(&track, &tuner.attached));
    for (int t = 0; t < STEPS; t++) {
        draw(&seed);
        if (t == 20) z[0] = 30; /* an outlier */
        ASSERT_OK(K(update_subset)(&track, s, z, present_at(t)));
        textbook_takes(&book, present_at(t));
        ASSERT_WITHIN(2048 * EPS * book.q, book.q, process_scale());
        ASSERT_WITHIN(2048 * EPS * book.r, book.r, sensor_scale());
        ASSERT_WITHIN(2048 * EPS * 8, book.x[0], K(mean)(&track, 0));
        ASSERT_OK(K(predict)(&track, &motion, NULL));
        textbook_predict(&book);
    }
    const double learnt = fabs(log(process_scale())) + fabs(log(sensor_scale()));
    TEST_ASSERT_TRUE(learnt > 0.2);
}

static void scales_follow_the_formulas(void)
{
    static const num diagonal[] = {0.5, 0, 0, 1};
    for (int scales = KQ_ADAPT_BOTH; scales <= KQ_ADAPT_SENSOR; scales++) {
        follow_the_textbook(&radar, diagonal, (kq_adapted)scales);
        follow_the_textbook(&coupled, R, (kq_adapted)scales);
    }
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
        draw(&seed);
        const double seen[] = {(double)z[0] / 4, 0};
        const double S = book.P[0] + book.R[0], e = seen[0] - book.x[0];
        *log_likelihood = -(log(S) + e * e / S) / 2;
        (void)textbook_measure(&book, seen, 1, J);
        textbook_predict(&book);
    }
    return book.g[0];
}

/* A double of 32 bits (AVR) is too short for differences. */
static void the_formulas_are_those_of_likelihood(void)
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
static void the_scales_of_a_plant_are_found(void)
{
    static const num one[] = {1}, none[] = {0};
    PROCESS(walk, 1, 0);
    SENSOR(gauge, 1, 1);
    FILTER(level, 1);
    ADAPTATION(finder, 1, 1);
    uint32_t seed = 5;
    num x = 0;
    rule.memory = 400;
    ASSERT_OK(K(process_init)(&walk, one, NULL, one));
    ASSERT_OK(K(sensor_init)(&gauge, one, one));
    ASSERT_OK(K(filter_init)(&level, none, one));
    ASSERT_OK(K(adaptation_init)(&finder, &walk, &gauge, &rule));
    ASSERT_OK(K(attach)(&level, &finder.attached));
    for (int t = 0; t < 1500; t++) {
        num seen[] = {x + noise(&seed) * 2};
        ASSERT_OK(K(update_subset)(&level, &gauge, seen, ALL));
        ASSERT_OK(K(predict)(&level, &walk, NULL));
        x += noise(&seed) / 2;
    }
    ASSERT_WITHIN(0.4, log(0.25), log((double)process_scale_of(&finder)));
    ASSERT_WITHIN(0.25, log(4), log((double)sensor_scale_of(&finder)));
}

static void learning_begins_after_n_measurements(void)
{
    for (int k = 0; k < 2; k++) {
        ASSERT_OK(K(update_subset)(&track, &radar, z, 1));
        ASSERT_WITHIN(0, 1, process_scale());
        ASSERT_WITHIN(0, 1, sensor_scale());
        ASSERT_OK(K(predict)(&track, &motion, u));
    }
    z[0] = 20;
    ASSERT_OK(K(update_subset)(&track, &radar, z, 1));
    TEST_ASSERT_TRUE(process_scale() > 1 && sensor_scale() > 1);
}

static void without_a_measurement_nothing_is_learnt(void)
{
    uint32_t seed = 2;
    for (int t = 0; t < 10; t++) {
        draw(&seed);
        ASSERT_OK(K(update_subset)(&track, &radar, z, ALL));
        ASSERT_OK(K(predict)(&track, &motion, u));
    }
    const K(adaptation) before = tuner;
    z[0] = z[1] = (num)NAN; /* not read */
    for (int t = 0; t < 5; t++) {
        ASSERT_OK(K(update_subset)(&track, &radar, z, 0));
        ASSERT_OK(K(predict)(&track, &motion, u));
    }
    ASSERT_WITHIN(0, before.process_scale, process_scale());
    ASSERT_WITHIN(0, before.sensor_scale, sensor_scale());
    ASSERT_SAME_BITS(before.information, tuner.information);
}

/* ------------------------------------------------------------------------------ bounds */

/* 5 sigma or all the sigmas there are: the scales do not know */
static void an_outlier_counts_as_four_sigma(void)
{
    num found[3][2];
    for (int k = 0; k < 3; k++) {
        uint32_t seed = 2;
        ASSERT_OK(K(filter_init)(&track, x0, P0));
        ASSERT_OK(K(adaptation_init)(&tuner, &motion, &radar, &rule));
        ASSERT_OK(K(attach)(&track, &tuner.attached));
        for (int t = 0; t < 10; t++) {
            draw(&seed);
            ASSERT_OK(K(update_subset)(&track, &radar, z, 1));
            ASSERT_OK(K(predict)(&track, &motion, u));
        }
        z[0] = k == 0 ? 30 : k == 1 ? 1000 : NUM_MAX / 4;
        ASSERT_OK(K(update_subset)(&track, &radar, z, 1));
        ASSERT_OK(K(adaptation_scales)(&tuner, &found[k][0], &found[k][1]));
    }
    ASSERT_SAME_BITS(found[0], found[1]);
    ASSERT_SAME_BITS(found[0], found[2]);
}

static void assert_step(double before, double now)
{
    const double most = 1.125 * (1 + 4 * EPS);
    TEST_ASSERT_TRUE(now <= before * most && now >= before / most);
}

/* Measurements out of all proportion, then none that differ from what is expected */
static void steps_and_limits_are_kept(void)
{
    int moved = 0;
    for (int t = 0; t < 1000; t++) {
        const double q = process_scale(), s = sensor_scale();
        z[0] = t < 200 ? N(t % 2 ? 1e4 : -1e4) : K(mean)(&track, 0);
        z[1] = t < 200 ? -z[0] : K(mean)(&track, 0) / 2 + K(mean)(&track, 1);
        ASSERT_OK(K(update_subset)(&track, &radar, z, ALL));
        assert_step(q, process_scale());
        assert_step(s, sensor_scale());
        moved += process_scale() != q;
        TEST_ASSERT_TRUE(process_scale() >= 0.0625 && process_scale() <= 16);
        TEST_ASSERT_TRUE(sensor_scale() >= 0.125 && sensor_scale() <= 8);
        if (t == 199) ASSERT_WITHIN(0, 8, sensor_scale());
        ASSERT_OK(K(predict)(&track, &motion, NULL));
    }
    ASSERT_WITHIN(0, 0.125, sensor_scale());
    TEST_ASSERT_TRUE(moved > 10);
}

/* A state that grows and is not seen, until P has left the numbers */
static void what_leaves_the_numbers_is_forgotten(void)
{
    static const num growing[] = {1, 0, 0, 1024}, seen[] = {1, 0};
    ADAPTATION(other, 2, 1);
    ASSERT_OK(K(detach)(&tuner.attached));
    ASSERT_OK(K(process_init)(&motion, growing, B, Q));
    ASSERT_OK(K(sensor_init_diagonal)(&single, seen, r));
    ASSERT_OK(K(adaptation_init)(&other, &motion, &single, &rule));
    ASSERT_OK(K(attach)(&track, &other.attached));
    for (int t = 0; t < 200; t++) {
        ASSERT_OK(K(update_subset)(&track, &single, z, 1));
        ASSERT_OK(K(predict)(&track, &motion, u));
    }
    const num q = process_scale_of(&other), s = sensor_scale_of(&other);
    TEST_ASSERT_TRUE(q > 0 && q <= 16 && s > 0 && s <= 8);
}

static void no_noise_stays_none(void)
{
    static const num zero[] = {0, 0, 0, 0}, sharp[] = {0, 1};
    uint32_t seed = 9;
    ASSERT_OK(K(process_init)(&motion, A, B, zero));
    ASSERT_OK(K(sensor_init_diagonal)(&radar, H, sharp));
    ASSERT_OK(K(adaptation_init)(&tuner, &motion, &radar, &rule));
    for (int t = 0; t < STEPS; t++) {
        draw(&seed);
        ASSERT_OK(K(update_subset)(&track, &radar, z, ALL));
        ASSERT_OK(K(predict)(&track, &motion, u));
    }
    TEST_ASSERT_TRUE(sensor_scale() != 1);
    const K(process) *p = K(adaptation_process)(&tuner);
    TEST_ASSERT_EQUAL_MEMORY(motion_memory, p->noise_root, sizeof motion_memory);
    TEST_ASSERT_TRUE(K(adaptation_sensor)(&tuner)->noise[0] == radar.noise[0]);
    TEST_ASSERT_TRUE(K(adaptation_sensor)(&tuner)->noise[1] == sensor_scale_of(&tuner));
}

/* ------------------------------------------------------------------------------ objects */

static void learn_something(void)
{
    uint32_t seed = 4;
    ASSERT_OK(K(adaptation_init)(&tuner, &motion, &coupled, &rule));
    ASSERT_OK(K(attach)(&track, &tuner.attached));
    for (int t = 0; t < STEPS; t++) {
        draw(&seed);
        ASSERT_OK(K(update_subset)(&track, &coupled, z, present_at(t)));
        ASSERT_OK(K(predict)(&track, &motion, u));
    }
    TEST_ASSERT_TRUE(fabs(log(process_scale())) > 0.1 && fabs(log(sensor_scale())) > 0.1);
}

static void the_scaled_models_are_those_of_the_scales(void)
{
    PROCESS(expected, 2, 1);
    num S[4], S0[4];
    learn_something();
    const K(process) *p = K(adaptation_process)(&tuner);
    ASSERT_OK(K(process_scale_noise)(&expected, &motion, process_scale_of(&tuner)));
    TEST_ASSERT_EQUAL_MEMORY(expected_memory, p->noise_root, sizeof expected_memory);
    ASSERT_OK(K(forecast)(&track, p, u, 1, &twin));
    ASSERT_OK(K(measurement)(&track, &coupled, NULL, S0));
    ASSERT_OK(K(measurement)(&track, K(adaptation_sensor)(&tuner), NULL, S));
    for (int k = 0; k < 4; k++) {
        ASSERT_CLOSE((sensor_scale() - 1) * (double)R[k], S[k] - S0[k], 8);
    }
    ASSERT_OK(K(predict)(&track, &motion, u));
    ASSERT_SAME_STATE(&twin, &track, 2);
    ASSERT_OK(K(update)(&twin, K(adaptation_sensor)(&tuner), z));
    ASSERT_OK(K(update_subset)(&track, &coupled, z, ALL));
    ASSERT_SAME_STATE(&twin, &track, 2);
}

static void another_model_is_that_of_the_next_step(void)
{
    static const num A2[] = {0.5, 0.25, 0, 1}, H2[] = {0, 1, 1, 1};
    PROCESS(expected, 2, 1);
    learn_something();
    ASSERT_OK(K(process_change_transition)(&motion, A2));
    ASSERT_OK(K(process_scale_noise)(&expected, &motion, process_scale_of(&tuner)));
    ASSERT_OK(K(forecast)(&track, &expected, u, 1, &twin));
    ASSERT_OK(K(predict)(&track, &motion, u));
    ASSERT_SAME_STATE(&twin, &track, 2);
    ASSERT_OK(K(sensor_change_measurement)(&coupled, H2));
    ASSERT_OK(K(update)(&twin, K(adaptation_sensor)(&tuner), z));
    ASSERT_OK(K(update_subset)(&track, &coupled, z, ALL));
    ASSERT_SAME_STATE(&twin, &track, 2);
}

static void an_attach_keeps_what_was_learnt(void)
{
    learn_something();
    const K(adaptation) before = tuner;
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    ASSERT_OK(K(attach)(&track, &tuner.attached));
    z[0] = 20;
    ASSERT_OK(K(update_subset)(&track, &coupled, z, ALL)); /* waits for two */
    ASSERT_WITHIN(0, before.process_scale, process_scale());
    ASSERT_WITHIN(0, before.sensor_scale, sensor_scale());
    ASSERT_SAME_BITS(before.information, tuner.information);
    ASSERT_OK(K(adaptation_init)(&tuner, &motion, &coupled, &rule));
    ASSERT_WITHIN(0, 1, process_scale());
    ASSERT_WITHIN(0, 1, sensor_scale());
}

/* Steps by which nothing may be learnt, beside a filter that has none to learn by */
static void other_models_are_taken_as_they_are(void)
{
    uint32_t seed = 6;
    learn_something();
    ASSERT_OK(K(filter_copy)(&twin, &track));
    const K(adaptation) before = tuner;
    num memory[ADAPTATION_LEN(2, 2)];
    memcpy(memory, tuner_memory, sizeof memory);
    for (int t = 0; t < STEPS; t++) {
        draw(&seed);
        const uint32_t present = present_at(t);
        ASSERT_OK(K(predict)(&track, &another, u));
        ASSERT_OK(K(predict)(&twin, &another, u));
        ASSERT_OK(K(update_subset)(&track, &radar, z, present));
        ASSERT_OK(K(update_subset)(&twin, &radar, z, present));
        ASSERT_OK(K(update)(&track, &single, z));
        ASSERT_OK(K(update)(&twin, &single, z));
        ASSERT_OK(K(step)(&track, &another, u, &radar, z));
        ASSERT_OK(K(step)(&twin, &another, u, &radar, z));
        ASSERT_SAME_FILTER(&twin, &track, 2);
    }
    TEST_ASSERT_EQUAL_MEMORY(&before, &tuner, sizeof before);
    TEST_ASSERT_EQUAL_MEMORY(memory, tuner_memory, sizeof memory);
    /* one of the two may be another */
    ASSERT_OK(K(step)(&track, &another, u, &coupled, z));
    TEST_ASSERT_TRUE(memcmp(&before, &tuner, sizeof before) != 0);
}

static void a_step_is_a_predict_and_an_update(void)
{
    ADAPTATION(other, 2, 2);
    const K(sensor) * sensors[] = {&radar, &coupled, &single};
    for (int k = 0; k < 2; k++) {
        uint32_t seed = 6;
        ASSERT_OK(K(filter_init)(&track, x0, P0));
        ASSERT_OK(K(filter_init)(&twin, x0, P0));
        ASSERT_OK(K(adaptation_init)(&tuner, &motion, sensors[k], &rule));
        ASSERT_OK(K(adaptation_init)(&other, &motion, sensors[k], &rule));
        ASSERT_OK(K(attach)(&track, &tuner.attached));
        ASSERT_OK(K(attach)(&twin, &other.attached));
        for (int t = 0; t < STEPS; t++) {
            const K(process) *p = t % 5 == 4 ? &another : &motion;
            const K(sensor) *s = t % 7 == 5 ? &single : sensors[k];
            draw(&seed);
            ASSERT_OK(K(predict)(&track, p, u));
            ASSERT_OK(K(update)(&track, s, z));
            ASSERT_OK(K(step)(&twin, p, u, s, z));
            ASSERT_SAME_FILTER(&track, &twin, 2);
            TEST_ASSERT_TRUE(process_scale_of(&other) == (num)process_scale());
            TEST_ASSERT_TRUE(sensor_scale_of(&other) == (num)sensor_scale());
        }
        TEST_ASSERT_TRUE(sensor_scale() != 1 && process_scale() != 1);
    }
}

static void a_detached_filter_goes_on_by_itself(void)
{
    learn_something();
    ASSERT_OK(K(filter_copy)(&twin, &track));
    ASSERT_OK(K(detach)(&tuner.attached));
    const K(adaptation) before = tuner;
    for (int t = 0; t < 3; t++) {
        ASSERT_OK(K(step)(&track, &motion, u, &coupled, z));
        ASSERT_OK(K(step)(&twin, &motion, u, &coupled, z));
        ASSERT_SAME_FILTER(&twin, &track, 2);
    }
    TEST_ASSERT_EQUAL_MEMORY(&before, &tuner, sizeof before);
    ASSERT_OK_UNCHANGED(K(detach)(&tuner.attached)); /* it is */
    /* attached again, or to another filter, it is what it had learnt that counts */
    ASSERT_OK(K(attach)(&twin, &tuner.attached));
    ASSERT_OK(K(forecast)(&twin, K(adaptation_process)(&tuner), u, 1, &track));
    ASSERT_OK(K(predict)(&twin, &motion, u));
    ASSERT_SAME_STATE(&track, &twin, 2);
    TEST_ASSERT_TRUE(fabs(log(process_scale())) > 0.1);
    /* and a history may take its place */
    ASSERT_OK(K(detach)(&tuner.attached));
    ASSERT_OK(K(attach)(&twin, &tape.attached));
}

/* By kq_filter_copy or by assignment: what the copy measures teaches nothing. */
static void a_copied_filter_goes_on_by_itself(void)
{
    for (int assigned = 0; assigned < 2; assigned++) {
        learn_something();
        ASSERT_OK(K(filter_copy)(&twin, &track));
        ASSERT_OK(K(filter_copy)(&third, &track));
        if (assigned) {
            twin = track;
            twin.memory = twin_memory;
        }
        const K(adaptation) before = tuner;
        for (int t = 0; t < 3; t++) {
            ASSERT_OK(K(update)(&twin, &coupled, z));
            ASSERT_OK(K(update)(&third, &coupled, z));
            ASSERT_OK(K(predict)(&twin, &motion, u));
            ASSERT_OK(K(predict)(&third, &motion, u));
            ASSERT_OK(K(step)(&twin, &motion, u, &coupled, z));
            ASSERT_OK(K(step)(&third, &motion, u, &coupled, z));
            ASSERT_SAME_FILTER(&third, &twin, 2);
        }
        TEST_ASSERT_EQUAL_MEMORY(&before, &tuner, sizeof before);
        ASSERT_OK(K(update)(&track, &coupled, z)); /* the filter itself has lost nothing */
        TEST_ASSERT_TRUE(memcmp(&before, &tuner, sizeof before) != 0);
    }
}

/* It may then be gone, or assigned anew: the filter does not go to it any more. */
static void what_is_assigned_anew_is_not_attached(void)
{
    ASSERT_OK(K(adaptation_assign)(&tuner, 2, 2, tuner_memory, COUNT(tuner_memory)));
    for (int t = 0; t < 3; t++) {
        ASSERT_OK(K(update)(&track, &radar, z));
        ASSERT_OK(K(update)(&twin, &radar, z));
        ASSERT_OK(K(predict)(&track, &motion, u));
        ASSERT_OK(K(predict)(&twin, &motion, u));
        ASSERT_OK(K(step)(&track, &motion, u, &radar, z));
        ASSERT_OK(K(step)(&twin, &motion, u, &radar, z));
    }
    ASSERT_SAME_FILTER(&twin, &track, 2);
    ASSERT_OK(K(adaptation_init)(&tuner, &motion, &radar, &rule));
    ASSERT_OK(K(attach)(&track, &tuner.attached));
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    const K(adaptation) kept = tuner;
    memset(&tuner, 0xa5, sizeof tuner);
    ASSERT_OK(K(update)(&track, &radar, z));
    tuner = kept;
}

static void an_adaptation_works_at_every_size(void)
{
    enum { MOST_WORDS = GUARDED(ADAPTATION_LEN(16, 16)) };
    static num room[MOST_WORDS], words[FILTER_LEN(16)], roots[KQ_PROCESS_LEN(16)];
    static num noises[KQ_SENSOR_LEN(16)], I[256], full[256], x[16], seen[16];
    K(filter) f;
    K(process) p;
    K(sensor) s;
    K(adaptation) a;
    for (int k = 0; k < 256; k++) full[k] = k % 17 ? N(0.0625) : 1;
    for (int n = 1; n <= 16; n++) {
        const int m = 17 - n;
        const size_t length = (size_t)ADAPTATION_LEN(n, m);
        num R_m[256], H_m[256];
        put_identity(I, n, 1);
        for (int k = 0; k < m * m; k++) R_m[k] = k % (m + 1) ? N(0.0625) : 1;
        for (int k = 0; k < m * n; k++) H_m[k] = full[k];
        ASSERT_OK(K(filter_assign)(&f, n, words, COUNT(words)));
        ASSERT_OK(K(process_assign)(&p, n, 0, roots, COUNT(roots)));
        ASSERT_OK(K(sensor_assign)(&s, n, m, noises, COUNT(noises)));
        ASSERT_OK(K(adaptation_assign)(&a, n, m, guard(room, COUNT(room)), length));
        ASSERT_OK(K(filter_init)(&f, x, I));
        ASSERT_OK(K(process_init)(&p, I, NULL, I));
        ASSERT_OK(K(sensor_init)(&s, H_m, R_m));
        ASSERT_OK(K(adaptation_init)(&a, &p, &s, &rule));
        ASSERT_OK(K(attach)(&f, &a.attached));
        for (int t = 0; t < 20; t++) {
            for (int c = 0; c < m; c++) seen[c] = N(t % 3 - 1 + 0.25 * c);
            ASSERT_OK(K(update_subset)(&f, &s, seen, t % 4 ? ALL : 0x5555));
            ASSERT_OK(K(predict)(&f, &p, NULL));
        }
        TEST_ASSERT_TRUE(sensor_scale_of(&a) != 1);
        TEST_ASSERT_TRUE(process_scale_of(&a) != 1);
        assert_guards(room, length, COUNT(room));
    }
}

/* ------------------------------------------------------------------------------ refusals */

static void refusals_of_assign(void)
{
    static num words[ADAPTATION_LEN(2, 2)];
    K(adaptation) a = {.states = 0};
    WATCH(a);
    ASSERT_REFUSED(KQ_ERR_NULL, K(adaptation_assign)(NULL, 2, 2, words, COUNT(words)));
    ASSERT_REFUSED(KQ_ERR_NULL, K(adaptation_assign)(&a, 2, 2, NULL, COUNT(words)));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(adaptation_assign)(&a, 0, 2, words, COUNT(words)));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(adaptation_assign)(&a, 17, 2, words, COUNT(words)));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(adaptation_assign)(&a, 2, 0, words, COUNT(words)));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(adaptation_assign)(&a, 2, 17, words, COUNT(words)));
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(adaptation_assign)(&a, 2, 2, words, COUNT(words) - 1));
    ASSERT_OK(K(adaptation_assign)(&a, 2, 2, words, COUNT(words)));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(attach)(&track, &a.attached));
}

static kq_status try_init(void) { return K(adaptation_init)(&tuner, &motion, &radar, &rule); }

static void refusals_of_init(void)
{
    K(adaptation) none = {.states = 0}, short_one = tuner;
    short_one.length--;
    WATCH(none), WATCH(short_one);
    ASSERT_REFUSED(KQ_ERR_NULL, K(adaptation_init)(NULL, &motion, &radar, &rule));
    ASSERT_REFUSED(KQ_ERR_NULL, K(adaptation_init)(&tuner, NULL, &radar, &rule));
    ASSERT_REFUSED(KQ_ERR_NULL, K(adaptation_init)(&tuner, &motion, NULL, &rule));
    ASSERT_REFUSED(KQ_ERR_NULL, K(adaptation_init)(&tuner, &motion, &radar, NULL));
    ASSERT_REFUSED_SIZE_OR_MEMORY(K(adaptation_init)(&none, &motion, &radar, &rule));
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(adaptation_init)(&short_one, &motion, &radar, &rule));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(adaptation_init)(&tuner, &blank_process, &radar, &rule));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(adaptation_init)(&tuner, &motion, &blank_sensor, &rule));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(adaptation_init)(&tuner, &motion3, &radar, &rule));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(adaptation_init)(&tuner, &motion, &radar3, &rule));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(adaptation_init)(&tuner, &motion, &single, &rule));
}

static void assert_bad_number(num *number, num bad, kq_status status)
{
    const num good = *number;
    *number = bad;
    ASSERT_REFUSED(status, try_init());
    *number = good;
}

static void refusals_of_a_rule(void)
{
    num *numbers[] = {&rule.step, &rule.process_least, &rule.process_most, &rule.sensor_least,
                      &rule.sensor_most};
    for (int k = 0; k < COUNT(numbers); k++) {
        assert_bad_number(numbers[k], (num)NAN, KQ_ERR_NOT_FINITE);
        assert_bad_number(numbers[k], (num)INFINITY, KQ_ERR_NOT_FINITE);
        assert_bad_number(numbers[k], 0, KQ_ERR_RANGE);
        assert_bad_number(numbers[k], -1, KQ_ERR_RANGE);
    }
    assert_bad_number(&rule.step, N(1.5), KQ_ERR_RANGE);
    assert_bad_number(&rule.process_least, N(1.5), KQ_ERR_RANGE);
    assert_bad_number(&rule.sensor_least, N(1.5), KQ_ERR_RANGE);
    assert_bad_number(&rule.process_most, N(0.5), KQ_ERR_RANGE);
    assert_bad_number(&rule.sensor_most, N(0.5), KQ_ERR_RANGE);
    static const int32_t lengths[] = {INT32_MIN, 0, 9, 100001, INT32_MAX};
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

/* A noise that a scale would lead beyond what can be represented */
static void refusals_of_what_cannot_be_scaled(void)
{
    const num large = NUM_MAX / 64;
    const num huge[] = {large, large / 2, large / 2, large};
    ASSERT_OK(K(sensor_init)(&coupled, H, huge));
    ASSERT_OK(K(adaptation_init)(&tuner, &motion, &coupled, &rule));
    ASSERT_OK(K(sensor_init_diagonal)(&radar, H, huge));
    ASSERT_OK(try_init());
    rule.sensor_most = 128;
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(adaptation_init)(&tuner, &motion, &coupled, &rule));
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, try_init());
}

/* It has a filter until it is detached or assigned anew; f may have been initialised meanwhile. */
static void an_adaptation_has_one_filter(void)
{
    WATCH(twin);
    learn_something();
    const double learnt = process_scale();
    ASSERT_REFUSED(KQ_ERR_RECORDING, K(attach)(&twin, &tuner.attached));
    ASSERT_OK(K(attach)(&track, &tuner.attached)); /* to its own once more */
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    ASSERT_REFUSED(KQ_ERR_RECORDING, K(attach)(&twin, &tuner.attached));
    ASSERT_OK(K(attach)(&track, &tuner.attached));
    ASSERT_OK(K(detach)(&tuner.attached));
    ASSERT_OK(K(attach)(&twin, &tuner.attached));
    TEST_ASSERT_TRUE(learnt != 1 && process_scale() == learnt);
    ASSERT_OK(K(adaptation_assign)(&tuner, 2, 2, tuner_memory, COUNT(tuner_memory)));
    ASSERT_OK(K(adaptation_init)(&tuner, &motion, &radar, &rule));
    ASSERT_OK(K(attach)(&track, &tuner.attached));
}

/* status.h: a history, a lag and a point take each other's place, whose recording has ended then. */
static void what_records_takes_the_place_of_what_records(void)
{
    LAG(lag, 2, 2, 2);
    INSTANT(point, 2, 2);
    HISTORY(later, 2, 2, 4, 0);
    K(filter) view;
    ASSERT_OK(K(attach)(&twin, &tape.attached));
    ASSERT_OK(K(attach)(&twin, &lag.attached));
    ASSERT_OK(K(predict)(&twin, &motion, u));
    TEST_ASSERT_EQUAL_UINT(1, K(history_steps)(&tape));
    TEST_ASSERT_EQUAL_UINT(1, K(lag_steps)(&lag));
    ASSERT_OK(K(attach)(&twin, &point.attached));
    TEST_ASSERT_EQUAL_UINT(0, K(lag_steps)(&lag));
    ASSERT_OK(K(attach)(&twin, &later.attached));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_HISTORY_EMPTY, K(instant_smooth)(&point, &view));
    ASSERT_OK(K(attach)(&twin, &tape.attached));
    ASSERT_OK(K(predict)(&twin, &motion, u));
    TEST_ASSERT_EQUAL_UINT(1, K(history_steps)(&later));
    TEST_ASSERT_EQUAL_UINT(2, K(history_steps)(&tape));
    ASSERT_OK(K(detach)(&tape.attached));
}

static void refusals_of_attach(void)
{
    LAG(lag, 2, 2, 2);
    INSTANT(point, 2, 2);
    START(start, 2, 0);
    ADAPTATION(other, 2, 2);
    ASSERT_OK(K(adaptation_init)(&other, &motion, &radar, &rule));
    WATCH(other), WATCH(other_memory), WATCH(track3), WATCH(blank), WATCH(tape), WATCH(twin);
    ASSERT_REFUSED(KQ_ERR_NULL, K(attach)(&track, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, K(attach)(NULL, &tuner.attached));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(attach)(&track, &blank_tuner.attached));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(attach)(&blank, &tuner.attached));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(attach)(&track3, &tuner.attached));
    ASSERT_REFUSED(KQ_ERR_RECORDING, K(attach)(&track, &other.attached));
    ASSERT_REFUSED(KQ_ERR_RECORDING, K(attach)(&track, &tape.attached));
    ASSERT_REFUSED(KQ_ERR_RECORDING, K(attach)(&track, &lag.attached));
    ASSERT_REFUSED(KQ_ERR_RECORDING, K(attach)(&track, &point.attached));
    ASSERT_OK(K(attach)(&twin, &tape.attached));
    ASSERT_REFUSED(KQ_ERR_RECORDING, K(attach)(&twin, &other.attached));
    ASSERT_OK(K(detach)(&tape.attached));
    ASSERT_OK(K(attach)(&twin, &lag.attached));
    ASSERT_REFUSED(KQ_ERR_RECORDING, K(attach)(&twin, &other.attached));
    ASSERT_OK(K(detach)(&lag.attached));
    ASSERT_OK(K(attach)(&twin, &point.attached));
    ASSERT_REFUSED(KQ_ERR_RECORDING, K(attach)(&twin, &other.attached));
    ASSERT_OK(K(diffuse_init)(&start, &twin, x0, P0, 1));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(attach)(&twin, &other.attached));
    ASSERT_OK(K(diffuse_init)(&start, &twin, x0, P0, 0));
    ASSERT_OK(K(attach)(&twin, &other.attached)); /* nothing was unknown */
    ASSERT_REFUSED(KQ_ERR_NULL, K(detach)(NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(detach)(&blank_tuner.attached));
}

/* Beside the processes and sensors that are learnt from, others, which are refused alike */
static void refusals_of_predict(void)
{
    const K(process) * processes[] = {&motion, &another};
    for (int k = 0; k < COUNT(processes); k++) {
        ASSERT_REFUSED(KQ_ERR_NULL, K(predict)(NULL, processes[k], u));
        ASSERT_REFUSED(KQ_ERR_NOT_READY, K(predict)(&blank, processes[k], u));
        ASSERT_REFUSED(KQ_ERR_MISMATCH, K(predict)(&track3, processes[k], u));
        u[0] = (num)NAN;
        ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(predict)(&track, processes[k], u));
        u[0] = 1;
    }
    ASSERT_REFUSED(KQ_ERR_NULL, K(predict)(&track, NULL, u));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(predict)(&track, &blank_process, u));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(predict)(&track, &motion3, u));
}

static void refusals_of_update(void)
{
    const K(sensor) * sensors[] = {&radar, &coupled};
    for (int k = 0; k < COUNT(sensors); k++) {
        ASSERT_REFUSED(KQ_ERR_NULL, K(update_subset)(NULL, sensors[k], z, ALL));
        ASSERT_REFUSED(KQ_ERR_NULL, K(update_subset)(&track, sensors[k], NULL, ALL));
        ASSERT_REFUSED(KQ_ERR_NULL, K(update)(&track, sensors[k], NULL));
        ASSERT_REFUSED(KQ_ERR_NOT_READY, K(update_subset)(&blank, sensors[k], z, ALL));
        ASSERT_REFUSED(KQ_ERR_MISMATCH, K(update_subset)(&track3, sensors[k], z, ALL));
        z[1] = (num)INFINITY;
        ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(update_subset)(&track, sensors[k], z, ALL));
        ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(update)(&track, sensors[k], z));
        ASSERT_OK(K(update_subset)(&track, sensors[k], z, 1));
        z[1] = 1;
    }
    ASSERT_REFUSED(KQ_ERR_NULL, K(update_subset)(&track, NULL, z, ALL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(update_subset)(&track, &blank_sensor, z, ALL));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(update_subset)(&track, &radar3, z, ALL));
}

/* A step that is refused has not predicted, either. */
static void refusals_of_step(void)
{
    ASSERT_REFUSED(KQ_ERR_NULL, K(step)(NULL, &motion, u, &radar, z));
    ASSERT_REFUSED(KQ_ERR_NULL, K(step)(&track, NULL, u, &radar, z));
    ASSERT_REFUSED(KQ_ERR_NULL, K(step)(&track, &motion, u, NULL, z));
    ASSERT_REFUSED(KQ_ERR_NULL, K(step)(&track, &motion, u, &radar, NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(step)(&track, &blank_process, u, &radar, z));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(step)(&track, &motion, u, &blank_sensor, z));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(step)(&track, &motion3, u, &radar, z));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(step)(&track, &motion, u, &radar3, z));
    z[1] = (num)INFINITY;
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(step)(&track, &motion, u, &radar, z));
    z[1] = 1;
    u[0] = (num)NAN;
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(step)(&track, &motion, u, &radar, z));
    u[0] = 1;
    const K(sensor) kept = radar;
    radar = single;
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(step)(&track, &motion, u, &radar, z));
    radar = kept;
    ASSERT_OK(K(step)(&track, &motion, u, &radar, z));
}

/* The models that it refers to have become others */
static void refusals_of_models_that_changed(void)
{
    const K(process) kept = motion;
    const K(sensor) kept_sensor = radar;
    motion = motion3;
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(predict)(&track, &motion, u));
    TEST_ASSERT_NULL(K(adaptation_process)(&tuner));
    motion = blank_process;
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(predict)(&track, &motion, u));
    motion = kept;
    radar = single;
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(update_subset)(&track, &radar, z, ALL));
    TEST_ASSERT_NULL(K(adaptation_sensor)(&tuner));
    radar = kept_sensor;
    ASSERT_OK(K(update_subset)(&track, &radar, z, ALL));
}

static void readings_of_nothing(void)
{
    static num scales[2] = {5, 6};
    WATCH(scales);
    ASSERT_REFUSED(KQ_ERR_NULL, K(adaptation_scales)(NULL, &scales[0], &scales[1]));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(adaptation_scales)(&blank_tuner, &scales[0], &scales[1]));
    ASSERT_OK(K(adaptation_scales)(&tuner, NULL, NULL));
    TEST_ASSERT_NULL(K(adaptation_process)(NULL));
    TEST_ASSERT_NULL(K(adaptation_sensor)(&blank_tuner));
}

SUITE(adaptation, set_up)
{
    RUN_TEST(scales_that_may_not_move_leave_the_bits);
    RUN_TEST(scales_follow_the_formulas);
    RUN_TEST(the_formulas_are_those_of_likelihood);
    RUN_TEST(the_scales_of_a_plant_are_found);
    RUN_TEST(learning_begins_after_n_measurements);
    RUN_TEST(without_a_measurement_nothing_is_learnt);
    RUN_TEST(an_outlier_counts_as_four_sigma);
    RUN_TEST(steps_and_limits_are_kept);
    RUN_TEST(what_leaves_the_numbers_is_forgotten);
    RUN_TEST(no_noise_stays_none);
    RUN_TEST(the_scaled_models_are_those_of_the_scales);
    RUN_TEST(another_model_is_that_of_the_next_step);
    RUN_TEST(an_attach_keeps_what_was_learnt);
    RUN_TEST(other_models_are_taken_as_they_are);
    RUN_TEST(a_step_is_a_predict_and_an_update);
    RUN_TEST(a_detached_filter_goes_on_by_itself);
    RUN_TEST(a_copied_filter_goes_on_by_itself);
    RUN_TEST(what_is_assigned_anew_is_not_attached);
    RUN_TEST(an_adaptation_works_at_every_size);
    RUN_TEST(refusals_of_assign);
    RUN_TEST(refusals_of_init);
    RUN_TEST(refusals_of_a_rule);
    RUN_TEST(refusals_of_what_cannot_be_scaled);
    RUN_TEST(an_adaptation_has_one_filter);
    RUN_TEST(what_records_takes_the_place_of_what_records);
    RUN_TEST(refusals_of_attach);
    RUN_TEST(refusals_of_predict);
    RUN_TEST(refusals_of_update);
    RUN_TEST(refusals_of_step);
    RUN_TEST(refusals_of_models_that_changed);
    RUN_TEST(readings_of_nothing);
}
