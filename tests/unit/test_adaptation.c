/* The scales of the noises learnt on line, in floating point: the formulas, ends of the numbers
   (test_learning.c has what holds in q31 as well). */
#include "adaptation_textbook.h"
#include "reading.h"
#include "unchanged.h"

#define ALL UINT32_MAX
#define STEPS 60

PROCESS(motion, 2, 1);
SENSOR(radar, 2, 2);
SENSOR(coupled, 2, 2);
FILTER(track, 2);
ADAPTATION(tuner, 2, 2);

/* never initialised, and of other sizes */
SENSOR(single, 2, 1);

static const num A[] = {1, 0.5, -0.125, 0.75}, B[] = {0.125, 0.5};
static const num Q[] = {0.25, 0.125, 0.125, 0.5};
static const num H[] = {1, 0, 0.5, 1}, R[] = {0.5, 0.25, 0.25, 1}, r[] = {0.5, 1};
static const num x0[] = {1, -2}, P0[] = {2, 0.5, 0.5, 1};

static num z[2], u[1];
static K(adaptation_rule) rule;

static void set_up(void)
{
    z[0] = 1.5, z[1] = -0.5, u[0] = 2;
    rule = (K(adaptation_rule)){KQ_ADAPT_BOTH, 50, 0.125, 0.0625, 16, 0.125, 8};
    ASSERT_OK(K(process_init)(&motion, A, B, Q));
    ASSERT_OK(K(sensor_init_diagonal)(&radar, H, r));
    ASSERT_OK(K(sensor_init)(&coupled, H, R));
    ASSERT_OK(K(sensor_init_diagonal)(&single, H, r));
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    ASSERT_OK(K(adaptation_assign)(&tuner, 2, 2, tuner_memory, COUNT(tuner_memory)));
    ASSERT_OK(K(adaptation_init)(&tuner, &motion, &radar, &rule));
    ASSERT_OK(K(attach)(&track, &tuner.attached));
    watch_nothing();
    WATCH(motion), WATCH(motion_memory), WATCH(radar), WATCH(radar_memory), WATCH(track);
    WATCH(track_memory), WATCH(tuner), WATCH(tuner_memory), WATCH(rule);
    WATCH(z), WATCH(u);
}

static num process_scale_of(const K(adaptation) *a)
{
    num q = (num)NAN;
    ASSERT_OK(K(adaptation_scales)(a, &q, NULL));
    return q;
}

static num sensor_scale_of(const K(adaptation) *a)
{
    num r = (num)NAN;
    ASSERT_OK(K(adaptation_scales)(a, NULL, &r));
    return r;
}

static double sensor_scale(void) { return (double)sensor_scale_of(&tuner); }

static void draw(uint32_t *seed)
{
    for (int c = 0; c < 2; c++) z[c] = 2 * noise(seed);
}

/* ------------------------------------------------------------------------------ what is learnt */

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

/* ------------------------------------------------------------------------------ bounds */

/* 5 sigma or all the sigmas there are: the scales do not know */
TEST(an_outlier_counts_as_four_sigma)
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
        found[k][0] = process_scale_of(&tuner);
        found[k][1] = sensor_scale_of(&tuner);
    }
    ASSERT_SAME_BITS(found[0], found[1]);
    ASSERT_SAME_BITS(found[0], found[2]);
}

/* A state that grows and is not seen, until P has left the numbers */
TEST(what_leaves_the_numbers_is_forgotten)
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

TEST(no_noise_stays_none)
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

/* ------------------------------------------------------------------------------ refusals */

static kq_status try_init(void) { return K(adaptation_init)(&tuner, &motion, &radar, &rule); }

TEST(refusals_of_init)
{
    K(adaptation) none = {.states = 0}, short_one = tuner;
    short_one.length--;
    WATCH(none), WATCH(short_one);
    ASSERT_REFUSED_SIZE_OR_MEMORY(K(adaptation_init)(&none, &motion, &radar, &rule));
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(adaptation_init)(&short_one, &motion, &radar, &rule));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(adaptation_init)(&tuner, &motion, &single, &rule));
}

/* A noise that a scale would lead out of the numbers */
TEST(refusals_of_what_cannot_be_scaled)
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

SUITE(adaptation, set_up)
#include "adaptation.tests"
