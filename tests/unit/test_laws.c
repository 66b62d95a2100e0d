/*
 * Laws: what must hold between runs, whatever the numbers.  Some hold bit for bit, some up to
 * rounding.  (That step is predict and update, that a forecast is so many predicts, and that
 * an innovation may overwrite its measurement, is tested with those functions.)
 */
#include "models.h"
#include "textbook.h"

#define STEPS 8

typedef struct {
    uint32_t seed;
    num A[4], B[2], Q[4];
    num H[4], R[4]; /* two correlated components */
    num h[2], r[1]; /* and one of its own */
    num x0[2], P0[4];
    num z[STEPS][3], u[STEPS];
    num range[2], measured_range[3]; /* declared, for those arithmetics that ask for it */
} numbers;

static void make_numbers(numbers *s, uint32_t seed)
{
    static const numbers constant = {
        .A = {1, 0.5, -0.25, 0.75},
        .B = {0.125, 0.5},
        .Q = {0.25, 0.125, 0.125, 0.5},
        .H = {1, 0, 0.5, 1},
        .R = {0.5, 0.25, 0.25, 1},
        .h = {-1, 0.25},
        .r = {0.125},
        .x0 = {1, -2},
        .P0 = {2, 0.5, 0.5, 1},
        .range = {30, 30},
        .measured_range = {15, 15, 15},
    };
    *s = constant;
    s->seed = seed;
    for (int t = 0; t < STEPS; t++) {
        for (int c = 0; c < 3; c++) s->z[t][c] = noise(&seed);
        s->u[t] = noise(&seed);
    }
}

#define PAINTED_BYTES 2048

static int paint_byte;

/* through a pointer that the compiler cannot see through, or it would leave it out */
static void *(*volatile fill)(void *, int, size_t) = memset;

static void paint_the_stack(void)
{
    unsigned char below[PAINTED_BYTES];
    fill(below, paint_byte, sizeof below);
}

/* Log-likelihoods of the same rounding of P; terms: how many were rounded to a score */
#define ASSERT_SAME_SCORE(expected, actual, terms)                                                 \
    assert_within(score_rounding((double)(expected), terms), (double)(expected), (double)(actual), \
                  __LINE__)

/* ------------------------------------------------- a model, its objects, a run, its results */

typedef struct {
    process_model process;
    sensor_model pair, single;
} model;

typedef struct {
    reading filtered[STEPS], smoothed[STEPS];
    num lag_one[STEPS][4], noise_mean[STEPS][2], noise_covariance[STEPS][4];
    num noise[STEPS][2]; /* of the first measurement: mean, variance */
    num gain[4], measurement[2], S[4], innovation[2], forecast[2];
} results;

/* A filter and its tape */
typedef struct {
    word filter_words[S_FILTER_LEN(3)], tape_words[S_HISTORY_LEN(3, 3, STEPS, 0)];
    prior_model prior; /* whose formats the filter refers to */
    S(filter) filter;
    S(history) tape;
} instance;

static numbers plain, other;
static model motion, motion2;
static instance one, two;
static results first, second;

static const num drive_range[] = {15};

static void make_filter(instance *i, int n, const num *range, const num *x0, const num *P0)
{
    ASSERT_OK(S(filter_assign)(&i->filter, n, i->filter_words, COUNT(i->filter_words)));
    put_prior(&i->prior, n, range, x0, P0);
    CALL(init_filter(&i->filter, &i->prior));
}

static void model_init(model *m, const numbers *s)
{
    put_process(&m->process, 2, 1, s->range, drive_range, s->A, s->B, s->Q);
    put_sensor(&m->pair, 2, 2, s->range, s->measured_range, s->H, s->R);
    put_independent(&m->single, 2, 1, s->range, s->measured_range + 2, s->h, s->r);
}

static void begin(instance *i, const numbers *s)
{
    make_filter(i, 2, s->range, s->x0, s->P0);
    ASSERT_OK(S(history_assign)(&i->tape, 2, i->tape_words, COUNT(i->tape_words)));
    CALL(S(attach)(&i->filter, &i->tape.attached));
}

/* No check finds anything in what calls leave. */
static void assert_intact(instance *i, process_model *p, sensor_model *s)
{
    ASSERT_OK(S(filter_check)(&i->filter));
    if (p) ASSERT_OK(S(process_check)(&p->process));
    if (s) ASSERT_OK(S(sensor_check)(&s->sensor));
}

/* A failure names the numbers and the step. */
static void describe_step(const numbers *s, int t) { describe("numbers", "seed", (int)s->seed, "step", t); }

static void take(instance *i, sensor_model *s, const num *z)
{
    const word *words = measured(&s->sensor, z);
    CALL(S(update)(&i->filter, &s->sensor, words));
    assert_intact(i, NULL, s);
}

static void take_subset(instance *i, sensor_model *s, const num *z, uint32_t present)
{
    const word *words = measured(&s->sensor, z);
    CALL(S(update_subset)(&i->filter, &s->sensor, words, present));
    assert_intact(i, NULL, s);
}

/* u: NULL or one control */
static void advance(instance *i, process_model *p, const num *u)
{
    const word *words = driven(&p->process, u, 1);
    CALL(S(predict)(&i->filter, &p->process, words));
    assert_intact(i, p, NULL);
}

/* Step 0: pair, single.  1: nothing.  2: pair.  3: the pair's second, single.  4: nothing.
   5: pair, single.  6: single.  7: pair. */
static void go_on(instance *i, model *m, const numbers *s, int t)
{
    static const uint32_t pair[STEPS] = {3, 0, 3, 2, 0, 3, 0, 3};
    static const int single[STEPS] = {1, 0, 0, 1, 0, 1, 1, 0};
    describe_step(s, t);
    if (t > 0) advance(i, &m->process, s->u + t);
    if (pair[t] == 3) take(i, &m->pair, s->z[t]);
    if (pair[t] == 2) take_subset(i, &m->pair, s->z[t], 2);
    if (single[t]) take(i, &m->single, s->z[t] + 2);
}

static void smooth_and_read(instance *i, results *out)
{
    for (int t = STEPS - 1; t >= 0; t--) {
        num *v = out->noise[t];
        CALL(step_back(&i->tape, NULL, &i->prior, out->lag_one[t], out->noise_mean[t],
                       out->noise_covariance[t]));
        if (t != 1 && t != 4) CALL(read_noise(&i->tape, 0, v, v + 1));
        read_smoothed_at(&out->smoothed[t], &i->tape, (size_t)t, &i->prior, 2);
    }
}

/* What the filter at its end tells of the measurement to come, and of the state ahead */
static void read_ahead(instance *i, const model *m, const numbers *s, results *out)
{
    static instance ahead;
    static reading told;
    const word *z = measured(&m->pair.sensor, s->z[1]), *u;
    CALL(read_gain(&i->filter, &m->pair.sensor, out->gain));
    CALL(read_measurement(&i->filter, &m->pair.sensor, out->measurement, out->S));
    CALL(read_innovation(&i->filter, &m->pair.sensor, z, out->innovation));
    ASSERT_OK(S(filter_assign)(&ahead.filter, 2, ahead.filter_words, COUNT(ahead.filter_words)));
    u = driven(&m->process.process, s->u, 3);
    CALL(S(forecast)(&i->filter, &m->process.process, u, 3, &ahead.filter));
    read_now(&told, &ahead.filter, 2);
    out->forecast[0] = told.mean[0];
    out->forecast[1] = told.sigma[1];
}

static void run(instance *i, model *m, const numbers *s, results *out)
{
    model_init(m, s);
    begin(i, s);
    for (int t = 0; t < STEPS; t++) {
        go_on(i, m, s, t);
        read_now(&out->filtered[t], &i->filter, 2);
    }
    read_ahead(i, m, s, out);
    smooth_and_read(i, out);
}

static void set_up(void)
{
    before_call = do_nothing;
    make_numbers(&plain, 1);
    make_numbers(&other, 2);
    memset(&first, 0, sizeof first);
    memset(&second, 0, sizeof second);
}

/* ----------------------------------------------------------------- one and the same result */

TEST(a_run_made_again_gives_the_same_bits)
{
    run(&one, &motion, &plain, &first);
    run(&two, &motion2, &plain, &second);
    ASSERT_SAME_BITS(first, second);
    run(&one, &motion, &other, &second);
    TEST_ASSERT_TRUE(memcmp(&first, &second, sizeof first) != 0);
}

/* Two runs, step by step in turns, by the same process and the same sensors. */
TEST(interleaved_runs_do_not_disturb_each_other)
{
    static results apart[2];
    run(&one, &motion, &plain, &apart[0]);
    run(&one, &motion, &other, &apart[1]);
    memset(&one, 0, sizeof one);
    memset(&two, 0, sizeof two);
    model_init(&motion, &plain);
    begin(&one, &plain);
    begin(&two, &other);
    for (int t = 0; t < STEPS; t++) {
        go_on(&one, &motion, &plain, t);
        go_on(&two, &motion, &other, t);
        read_now(&first.filtered[t], &one.filter, 2);
        read_now(&second.filtered[t], &two.filter, 2);
    }
    TEST_ASSERT_EQUAL_MEMORY(apart[0].filtered, first.filtered, sizeof first.filtered);
    TEST_ASSERT_EQUAL_MEMORY(apart[1].filtered, second.filtered, sizeof second.filtered);
    for (size_t t = STEPS; t-- > 0;) {
        ASSERT_OK(S(smooth_step)(&one.tape, NULL, NULL));
        ASSERT_OK(S(smooth_step)(&two.tape, NULL, NULL));
        read_smoothed_at(&first.smoothed[t], &one.tape, t, &one.prior, 2);
        read_smoothed_at(&second.smoothed[t], &two.tape, t, &two.prior, 2);
    }
    TEST_ASSERT_EQUAL_MEMORY(apart[0].smoothed, first.smoothed, sizeof first.smoothed);
    TEST_ASSERT_EQUAL_MEMORY(apart[1].smoothed, second.smoothed, sizeof second.smoothed);
}

/* Memory and results full of zeros, of NaN (0xFF) and of 0x55; the stack as well, before
   each call. */
static void run_in_garbage(int byte, results *out)
{
    paint_byte = byte;
    memset(&one, byte, sizeof one);
    memset(&motion, byte, sizeof motion);
    memset(out, byte, sizeof *out);
    before_call = paint_the_stack;
    run(&one, &motion, &plain, out);
    before_call = do_nothing;
    /* not written by contract: the extras of the last step, the noise of no measurement */
    memset(out->lag_one[STEPS - 1], 0, sizeof out->lag_one[0]);
    memset(out->noise_mean[STEPS - 1], 0, sizeof out->noise_mean[0]);
    memset(out->noise_covariance[STEPS - 1], 0, sizeof out->noise_covariance[0]);
    memset(out->noise[1], 0, sizeof out->noise[1]);
    memset(out->noise[4], 0, sizeof out->noise[4]);
}

TEST(garbage_in_memory_and_on_the_stack_changes_nothing)
{
    run_in_garbage(0x00, &first);
    run_in_garbage(0xFF, &second);
    ASSERT_SAME_BITS(first, second);
    run_in_garbage(0x55, &second);
    ASSERT_SAME_BITS(first, second);
}

/* The covariance of a linear model does not depend on the data. */
TEST(what_was_measured_does_not_change_the_covariance)
{
    run(&one, &motion, &plain, &first);
    run(&one, &motion, &other, &second);
    for (int t = 0; t < STEPS; t++) {
        ASSERT_SAME_BITS(first.filtered[t].P, second.filtered[t].P);
        ASSERT_SAME_BITS(first.smoothed[t].P, second.smoothed[t].P);
        ASSERT_SAME_BITS(first.lag_one[t], second.lag_one[t]);
        ASSERT_SAME_BITS(first.noise_covariance[t], second.noise_covariance[t]);
    }
    ASSERT_SAME_BITS(first.gain, second.gain);
    ASSERT_SAME_BITS(first.S, second.S);
}

/* ------------------------------------------------------------- units: powers of two */

static num power_of_2(int e)
{
    num p = 1;
    for (; e > 0; e--) p *= 2;
    for (; e < 0; e++) p /= 2;
    return p;
}

/* a (r x c) in units of 2^row[i], 2^column[j] */
static void scale(num *a, const int *row, const int *column, int r, int c)
{
    for (int k = 0; k < r * c; k++) a[k] *= power_of_2(row[k / c] + column[k % c]);
}

/* State i in units of 2^x[i], component c of the measurements in units of 2^z[c] */
static void scale_numbers(numbers *s, const int *x, const int *z)
{
    const int minus[] = {-x[0], -x[1]}, none[] = {0};
    scale(s->A, x, minus, 2, 2);
    scale(s->B, x, none, 2, 1);
    scale(s->Q, x, x, 2, 2);
    scale(s->H, z, minus, 2, 2);
    scale(s->R, z, z, 2, 2);
    scale(s->h, z + 2, minus, 1, 2);
    scale(s->r, z + 2, z + 2, 1, 1);
    scale(s->x0, x, none, 2, 1);
    scale(s->P0, x, x, 2, 2);
    scale(s->range, x, none, 2, 1);
    scale(s->measured_range, z, none, 3, 1);
    for (int t = 0; t < STEPS; t++) scale(s->z[t], z, none, 3, 1);
}

static void unscale_reading(reading *r, const int *minus)
{
    static const int none[] = {0};
    scale(r->mean, minus, none, 2, 1);
    scale(r->low, minus, none, 2, 1);
    scale(r->sigma, minus, none, 2, 1);
    scale(r->P, minus, minus, 2, 2);
}

static void unscale_results(results *out, const int *x, const int *z)
{
    const int minus[] = {-x[0], -x[1]}, minus_z[] = {-z[0], -z[1]}, none[] = {0, 0};
    for (int t = 0; t < STEPS; t++) {
        unscale_reading(&out->filtered[t], minus);
        unscale_reading(&out->smoothed[t], minus);
        scale(out->lag_one[t], minus, minus, 2, 2);
        scale(out->noise_mean[t], minus, none, 2, 1);
        scale(out->noise_covariance[t], minus, minus, 2, 2);
    }
    scale(out->gain, minus, z, 2, 2);
    scale(out->measurement, minus_z, none, 2, 1);
    scale(out->S, minus_z, minus_z, 2, 2);
    scale(out->innovation, minus_z, none, 2, 1);
    out->forecast[0] *= power_of_2(minus[0]);
    out->forecast[1] *= power_of_2(minus[1]);
}

/* log det S moves with the units; all else does not */
static void forget_likelihood(results *out)
{
    for (int t = 0; t < STEPS; t++) out->filtered[t].last = out->filtered[t].run = 0;
}

static void assert_units_do_not_matter(const int *x, const int *z)
{
    numbers scaled = plain;
    scale_numbers(&scaled, x, z);
    run(&one, &motion, &plain, &first);
    run(&two, &motion2, &scaled, &second);
    unscale_results(&second, x, z);
    forget_likelihood(&first);
    forget_likelihood(&second);
    ASSERT_SAME_BITS(first, second);
}

TEST(units_that_are_powers_of_two_leave_every_bit)
{
    static const int up[] = {10, 10, 10}, down[] = {-9, -9, -9}, odd[] = {1, 1, 1};
    assert_units_do_not_matter(up, up);
    assert_units_do_not_matter(down, down);
    assert_units_do_not_matter(odd, odd);
}

TEST(each_state_and_component_may_have_units_of_its_own)
{
    static const int x[] = {12, -7}, z[] = {3, -9, 5};
    assert_units_do_not_matter(x, z);
}

static void multiply(num *a, int count, num factor)
{
    for (int k = 0; k < count; k++) a[k] *= factor;
}

/* Sigmas eight times as large; of q31, rounded to words */
static void unscale_covariance(reading *r, const reading *expected)
{
    for (int i = 0; i < 2; i++) {
        const double rounding = 0.5 * (1 + 1.0 / 8) * sigma_step(plain.range[i]);
        ASSERT_WITHIN(rounding, expected->sigma[i], r->sigma[i] / 8);
        r->sigma[i] = expected->sigma[i];
    }
    multiply(r->P, 4, N(1.0 / 64));
}

/* NIS: the share of each component is rounded */
static void unscale_scores(reading *r, const reading *expected)
{
    const double rounding = 0.5 * (1 + 64) * r->taken * score_step();
    ASSERT_WITHIN(rounding, expected->nis, r->nis * 64);
    r->nis = expected->nis, r->last = expected->last, r->run = expected->run;
}

/* In q31 the smoother counts in parts of a sigma, which are eight times as large, too. */
static void forget_rounding_of_smoother(reading *r, const reading *expected,
                                        const reading *filtered)
{
    for (int i = 0; i < 2; i++) {
        const double rounding = 8 * STEPS * smoother_step() * (double)filtered->sigma[i];
        ASSERT_WITHIN(rounding, whole(expected, i), whole(r, i));
        r->mean[i] = expected->mean[i], r->low[i] = expected->low[i];
    }
}

/* P0, Q and R times 4^k: the same gains and means, all covariances times 4^k. */
TEST(only_the_ratio_of_the_covariances_matters_to_the_mean)
{
    numbers scaled = plain;
    multiply(scaled.P0, 4, 64);
    multiply(scaled.Q, 4, 64);
    multiply(scaled.R, 4, 64);
    multiply(scaled.r, 1, 64);
    run(&one, &motion, &plain, &first);
    run(&two, &motion2, &scaled, &second);
    for (int t = 0; t < STEPS; t++) {
        reading *f = &second.filtered[t], *s = &second.smoothed[t];
        unscale_covariance(f, &first.filtered[t]);
        unscale_scores(f, &first.filtered[t]);
        unscale_covariance(s, &first.smoothed[t]);
        forget_rounding_of_smoother(s, &first.smoothed[t], &first.filtered[t]);
    }
    ASSERT_SAME_BITS(first.filtered, second.filtered);
    ASSERT_SAME_BITS(first.smoothed, second.smoothed);
    ASSERT_SAME_BITS(first.gain, second.gain);
}

/* --------------------------------------------------------- many ways to take a measurement */

static void assert_alike(const instance *a, const instance *b)
{
    reading expected, actual;
    read_now(&expected, &a->filter, 2);
    read_now(&actual, &b->filter, 2);
    for (int i = 0; i < 2; i++) ASSERT_ALIKE(whole(&expected, i), whole(&actual, i), 4);
    for (int k = 0; k < 4; k++) ASSERT_ALIKE(expected.P[k], actual.P[k], 2);
}

static void assert_as_textbook(const textbook *expected, const instance *i)
{
    reading actual;
    read_now(&actual, &i->filter, 2);
    for (int k = 0; k < 2; k++) {
        const double x = expected->x[k], *size = expected->size;
        ASSERT_ALIKE(x, whole(&actual, k), size[k] + fabs(x));
        for (int j = 0; j < 2; j++) {
            ASSERT_ALIKE(expected->P[2 * k + j], actual.P[2 * k + j], size[k] * size[j]);
        }
    }
}

static void begin_both(void)
{
    model_init(&motion, &plain);
    begin(&one, &plain);
    begin(&two, &plain);
}

/* Sensor of one component for two states, in memory that is used again. */
static sensor_model *scalar_sensor(const num *h, num r)
{
    static num row[2], variance[1];
    static sensor_model s;
    memcpy(row, h, sizeof row);
    variance[0] = r;
    put_independent(&s, 2, 1, plain.range, plain.measured_range, row, variance);
    return &s;
}

TEST(independent_components_may_be_taken_one_by_one)
{
    static const num r[] = {0.5, 2};
    reading at_once, in_turn;
    begin_both();
    put_independent(&motion.pair, 2, 2, plain.range, plain.measured_range, plain.H, r);
    take(&one, &motion.pair, plain.z[0]);
    double sum = 0, nis = 0;
    for (int c = 0; c < 2; c++) {
        take(&two, scalar_sensor(plain.H + 2 * c, r[c]), plain.z[0] + c);
        read_now(&in_turn, &two.filter, 2);
        sum += (double)in_turn.last;
        nis += (double)in_turn.nis;
    }
    read_now(&at_once, &one.filter, 2);
    ASSERT_SAME_BITS(at_once.sigma, in_turn.sigma);
    ASSERT_SAME_BITS(at_once.P, in_turn.P);
    /* a pair of floats is brought in order once an update */
    for (int i = 0; i < 2; i++) {
        ASSERT_WITHIN(ROUNDING_IN_TURN, at_once.mean[i], in_turn.mean[i]);
        ASSERT_WITHIN(ROUNDING_IN_TURN, at_once.low[i], in_turn.low[i]);
    }
    ASSERT_WITHIN(ROUNDING_IN_TURN * (1 + nis), nis, at_once.nis);
    ASSERT_SAME_SCORE(sum, at_once.last, 3);
}

/* R = U D U': z_0 - u z_1 and z_1 are independent, with variances R_00 - u R_01 and R_11. */
TEST(correlated_components_may_be_decorrelated_and_taken_one_by_one)
{
    const num *H = plain.H, *R = plain.R, *z = plain.z[0];
    const num u = R[1] / R[3], row[] = {H[0] - u * H[2], H[1] - u * H[3]}, z0 = z[0] - u * z[1];
    textbook t;
    begin_both();
    take(&one, &motion.pair, z);
    take(&two, scalar_sensor(row, R[0] - u * R[1]), &z0);
    take(&two, scalar_sensor(H + 2, R[3]), z + 1);
    assert_alike(&one, &two);
    textbook_init(&t, 2, plain.x0, plain.P0);
    textbook_update(&t, H, R, z, 2);
    assert_as_textbook(&t, &one);
    assert_as_textbook(&t, &two);
}

static sensor_model three, outer;

/* Of three independent components those present, or a sensor that has only those. */
TEST(a_subset_is_a_sensor_of_those_rows)
{
    static const num H[] = {1, 0, 0.5, 1, -1, 0.25}, r[] = {0.5, 1, 2};
    static const num rows[] = {1, 0, -1, 0.25}, variances[] = {0.5, 2};
    const num z[] = {plain.z[0][0], plain.z[0][2]};
    begin_both();
    put_independent(&three, 2, 3, plain.range, plain.measured_range, H, r);
    put_independent(&outer, 2, 2, plain.range, plain.measured_range, rows, variances);
    take_subset(&one, &three, plain.z[0], 5);
    take(&two, &outer, z);
    ASSERT_SAME(&one.filter, &two.filter, 2);
}

/* The same of correlated components: what is missing has no say in it. */
TEST(a_subset_of_correlated_components_is_a_sensor_of_those_rows)
{
    static const num H[] = {1, 0, 0.5, 1, -1, 0.25};
    static const num R[] = {0.5, 0.25, -0.125, 0.25, 1, 0.5, -0.125, 0.5, 2};
    static const num rows[] = {1, 0, -1, 0.25}, noise_of_rows[] = {0.5, -0.125, -0.125, 2};
    const num z[] = {plain.z[0][0], plain.z[0][2]};
    reading of_three, of_two;
    begin_both();
    put_sensor(&three, 2, 3, plain.range, plain.measured_range, H, R);
    put_sensor(&outer, 2, 2, plain.range, plain.measured_range, rows, noise_of_rows);
    take_subset(&one, &three, plain.z[0], 5);
    take(&two, &outer, z);
    assert_alike(&one, &two);
    read_now(&of_three, &one.filter, 2);
    read_now(&of_two, &two.filter, 2);
    ASSERT_ALIKE(of_three.nis, of_two.nis, 4);
    ASSERT_ALIKE(of_three.run, of_two.run, 8);
}

TEST(the_order_of_independent_sensors_does_not_matter)
{
    reading straight, turned;
    begin_both();
    for (int t = 0; t < STEPS; t++) {
        take(&one, &motion.pair, plain.z[t]);
        take(&one, &motion.single, plain.z[t] + 2);
        take(&two, &motion.single, plain.z[t] + 2);
        take(&two, &motion.pair, plain.z[t]);
        assert_alike(&one, &two);
        advance(&one, &motion.process, plain.u + t);
        advance(&two, &motion.process, plain.u + t);
    }
    read_now(&straight, &one.filter, 2);
    read_now(&turned, &two.filter, 2);
    ASSERT_ALIKE(straight.run, turned.run, 64);
}

/* Measured twice with twice the variance, or once. */
TEST(two_measurements_of_half_the_weight_are_one)
{
    begin_both();
    take(&one, &motion.single, plain.z[0] + 2);
    for (int k = 0; k < 2; k++) {
        take(&two, scalar_sensor(plain.h, 2 * plain.r[0]), plain.z[0] + 2);
    }
    assert_alike(&one, &two);
}

/* P^-1 = P0^-1 + sum H' R^-1 H: another P0 adds the same difference of information at the end. */
TEST(information_adds_up)
{
    double information[4];
    reading end;
    for (int c = 1; c <= 64; c *= 8) {
        numbers wider = plain;
        multiply(wider.P0, 4, N(c));
        model_init(&motion, &plain);
        begin(&one, &wider);
        for (int t = 0; t < STEPS; t++) take(&one, &motion.pair, plain.z[t]);
        read_now(&end, &one.filter, 2);
        textbook_widen(information, end.P, 4);
        (void)textbook_invert(information, 2);
        /* P0^-1 = [1 -.5; -.5 2] / 1.75 / c,  H'R^-1 H with R^-1 = [1 -.25; -.25 .5] / .4375 */
        const double prior[] = {1 / 1.75 / c, -0.5 / 1.75 / c, -0.5 / 1.75 / c, 2 / 1.75 / c};
        const double each[] = {0.875 / 0.4375, 0, 0, 0.5 / 0.4375};
        for (int k = 0; k < 4; k++) {
            ASSERT_ALIKE(prior[k] + STEPS * each[k], information[k], 32);
        }
    }
}

TEST(the_log_likelihood_is_the_sum_of_its_terms)
{
    double sum = 0;
    reading told;
    model_init(&motion, &plain);
    begin(&one, &plain);
    for (int t = 0; t < STEPS; t++) {
        take(&one, &motion.pair, plain.z[t]);
        read_now(&told, &one.filter, 2);
        sum += (double)told.last;
        take(&one, &motion.single, plain.z[t] + 2);
        read_now(&told, &one.filter, 2);
        sum += (double)told.last;
        ASSERT_SAME_SCORE(sum, told.run, 2 * t + 3);
        advance(&one, &motion.process, NULL);
    }
}

/* ------------------------------------------------------------------ the same in other words */

/* Two predicts are one by A A, with the noise A Q A' + Q. */
TEST(two_predicts_are_one_of_twice_the_length)
{
    static num AA[4], AQ[4], QQ[4];
    const num *A = plain.A;
    begin_both();
    for (int k = 0; k < 4; k++) {
        const int i = 2 * (k / 2), j = k % 2;
        AA[k] = A[i] * A[j] + A[i + 1] * A[2 + j];
        AQ[k] = A[i] * plain.Q[j] + A[i + 1] * plain.Q[2 + j];
    }
    for (int k = 0; k < 4; k++) {
        const int i = 2 * (k / 2), j = 2 * (k % 2);
        QQ[k] = AQ[i] * A[j] + AQ[i + 1] * A[j + 1] + plain.Q[k];
    }
    for (int k = 0; k < 2; k++) advance(&one, &motion.process, NULL);
    put_process(&motion.process, 2, 1, plain.range, drive_range, AA, plain.B, QQ);
    advance(&two, &motion.process, NULL);
    assert_alike(&one, &two);
}

/* The mean is linear in x0, z and u. */
TEST(results_of_summed_data_are_the_sum_of_results)
{
    static results sum;
    numbers added = plain;
    for (int i = 0; i < 2; i++) added.x0[i] += other.x0[i];
    for (int t = 0; t < STEPS; t++) {
        for (int c = 0; c < 3; c++) added.z[t][c] += other.z[t][c];
        added.u[t] += other.u[t];
    }
    memset(&sum, 0, sizeof sum);
    run(&one, &motion, &plain, &first);
    run(&one, &motion, &other, &second);
    run(&one, &motion, &added, &sum);
    for (int t = 0; t < STEPS; t++) {
        for (int i = 0; i < 2; i++) {
            const reading *a = &first.filtered[t], *b = &second.filtered[t], *c = &sum.filtered[t];
            ASSERT_WITHIN(8 * ROUNDING_OF_MEANS, whole(a, i) + whole(b, i), whole(c, i));
            a = &first.smoothed[t], b = &second.smoothed[t], c = &sum.smoothed[t];
            ASSERT_WITHIN(8 * ROUNDING_OF_MEANS, whole(a, i) + whole(b, i), whole(c, i));
        }
    }
}

/* M <- M with rows, and for `both` columns too, in the order 2, 0, 1 */
static void permute(num *to, const num *from, int rows, int columns, int by_rows, int by_columns)
{
    static const int order[] = {2, 0, 1};
    for (int i = 0; i < rows; i++) {
        for (int j = 0; j < columns; j++) {
            to[i * columns + j] =
                from[(by_rows ? order[i] : i) * columns + (by_columns ? order[j] : j)];
        }
    }
}

typedef struct {
    num A[9], Q[9], H[6], R[4], x0[3], P0[9], range[3];
} numbers3;

static void run3(const numbers3 *s, reading *filtered, reading *smoothed)
{
    static model m;
    put_process(&m.process, 3, 0, s->range, drive_range, s->A, NULL, s->Q);
    put_sensor(&m.pair, 3, 2, s->range, plain.measured_range, s->H, s->R);
    make_filter(&one, 3, s->range, s->x0, s->P0);
    ASSERT_OK(S(history_assign)(&one.tape, 3, one.tape_words, COUNT(one.tape_words)));
    ASSERT_OK(S(attach)(&one.filter, &one.tape.attached));
    for (int t = 0; t < STEPS; t++) {
        if (t > 0) advance(&one, &m.process, NULL);
        take(&one, &m.pair, plain.z[t]);
        read_now(&filtered[t], &one.filter, 3);
    }
    ASSERT_OK(S(smooth)(&one.tape));
    for (size_t t = 0; t < STEPS; t++) read_smoothed_at(&smoothed[t], &one.tape, t, &one.prior, 3);
}

static void assert_permuted(const reading *straight, const reading *permuted)
{
    reading expected;
    permute(expected.mean, straight->mean, 3, 1, 1, 0);
    permute(expected.low, straight->low, 3, 1, 1, 0);
    permute(expected.P, straight->P, 3, 3, 1, 1);
    for (int i = 0; i < 3; i++) ASSERT_ALIKE(whole(&expected, i), whole(permuted, i), 4);
    for (int k = 0; k < 9; k++) ASSERT_ALIKE(expected.P[k], permuted->P[k], 4);
}

TEST(the_order_of_the_states_does_not_matter)
{
    static const numbers3 straight = {
        {1, 0.5, 0.125, 0, 1, 0.5, -0.25, 0, 0.5},
        {0.25, 0.125, 0, 0.125, 0.5, 0.25, 0, 0.25, 1},
        {1, 0, 0, 0.5, 1, -1},
        {0.5, 0.25, 0.25, 1},
        {1, -2, 0.5},
        {2, 0.5, 0, 0.5, 1, 0.25, 0, 0.25, 1},
        {30, 60, 15},
    };
    static numbers3 turned;
    turned = straight;
    permute(turned.A, straight.A, 3, 3, 1, 1);
    permute(turned.Q, straight.Q, 3, 3, 1, 1);
    permute(turned.P0, straight.P0, 3, 3, 1, 1);
    permute(turned.H, straight.H, 2, 3, 0, 1);
    permute(turned.x0, straight.x0, 3, 1, 1, 0);
    permute(turned.range, straight.range, 3, 1, 1, 0);
    run3(&straight, first.filtered, first.smoothed);
    run3(&turned, second.filtered, second.smoothed);
    for (int t = 0; t < STEPS; t++) {
        assert_permuted(&first.filtered[t], &second.filtered[t]);
        assert_permuted(&first.smoothed[t], &second.smoothed[t]);
        ASSERT_ALIKE(first.filtered[t].run, second.filtered[t].run, 64);
    }
}

/* Data that are words in both formats */
static void round_data(numbers *s)
{
    for (int t = 0; t < STEPS; t++) {
        for (int c = 0; c < 3; c++) s->z[t][c] = N(ldexp(floor(ldexp((double)s->z[t][c], 12) + 0.5), -12));
    }
}

/* more: what the mean is rounded by beside 2^-24 of a word at each call */
static void assert_as_in_finer_format(const reading *fine, const reading *coarse,
                                      const num *range, double more)
{
    /* what the coarser state is rounded by moves the other one */
    const double word = fmax(sigma_step(range[0]), sigma_step(range[1]));
    const double rounding = ldexp(2 * STEPS * word, -24);
    ASSERT_SAME_BITS(fine->P, coarse->P);
    for (int i = 0; i < 2; i++) {
        ASSERT_WITHIN(sigma_step(range[i]), fine->sigma[i], coarse->sigma[i]);
        ASSERT_WITHIN(rounding + more * (double)fine->sigma[i], whole(fine, i), whole(coarse, i));
    }
}

/* A word of q31 is what the mean is rounded by, 2^-24 of it at each call: no bit of a covariance or of a
   gain knows the formats. */
TEST(formats_round_the_mean_alone)
{
    static const int x[] = {3, 6}, z[] = {6, 6, 6}, none[] = {0};
    numbers coarse;
    round_data(&plain);
    coarse = plain;
    scale(coarse.range, x, none, 2, 1);
    scale(coarse.measured_range, z, none, 3, 1);
    run(&one, &motion, &plain, &first);
    run(&two, &motion2, &coarse, &second);
    for (int t = 0; t < STEPS; t++) {
        const reading *fine = &first.smoothed[t], *wide = &second.smoothed[t];
        assert_as_in_finer_format(&first.filtered[t], &second.filtered[t], coarse.range, 0);
        assert_as_in_finer_format(fine, wide, coarse.range, STEPS * smoother_step());
        TEST_ASSERT_EQUAL_HEX(0, first.filtered[t].events | second.filtered[t].events);
    }
    ASSERT_SAME_BITS(first.lag_one, second.lag_one);
    ASSERT_SAME_BITS(first.noise_covariance, second.noise_covariance);
    ASSERT_SAME_BITS(first.gain, second.gain);
    ASSERT_SAME_BITS(first.S, second.S);
}

/* ------------------------------------------------------------------------- the smoother */

TEST(the_last_smoothed_step_is_the_filtered_one)
{
    run(&one, &motion, &plain, &first);
    const reading *end = &first.filtered[STEPS - 1], *last = &first.smoothed[STEPS - 1];
    TEST_ASSERT_EQUAL_MEMORY(end, last, offsetof(reading, nis));
}

TEST(a_smoothed_sigma_is_never_above_the_filtered_one)
{
    run(&one, &motion, &plain, &first);
    for (int t = 0; t < STEPS; t++) {
        for (int i = 0; i < 2; i++) {
            const double filtered = (double)first.filtered[t].sigma[i];
            const double smoothed = (double)first.smoothed[t].sigma[i];
            TEST_ASSERT_TRUE(smoothed <= filtered * (1 + 4 * EPS));
            TEST_ASSERT_TRUE(smoothed > 0);
            TEST_ASSERT_TRUE(t > 0 || smoothed < 0.95 * filtered);
        }
    }
}

TEST(smoothing_at_once_is_smoothing_step_by_step)
{
    run(&one, &motion, &plain, &first);
    begin(&two, &plain);
    for (int t = 0; t < STEPS; t++) go_on(&two, &motion, &plain, t);
    ASSERT_OK(S(smooth)(&two.tape));
    for (size_t t = 0; t < STEPS; t++) read_smoothed_at(&second.smoothed[t], &two.tape, t, &two.prior, 2);
    ASSERT_SAME_BITS(first.smoothed, second.smoothed);
}

TEST(states_only_are_the_same_states)
{
    run(&one, &motion, &plain, &first);
    begin(&two, &plain);
    for (int t = 0; t < STEPS; t++) go_on(&two, &motion, &plain, t);
    ASSERT_OK(S(smooth_states)(&two.tape));
    for (size_t t = 0; t < STEPS; t++) {
        for (int i = 0; i < 2; i++) {
            const double expected = whole(&first.smoothed[t], i);
            ASSERT_ALIKE(expected, shown_mean(S_SMOOTHED(&two.tape, t), &two.prior, i), 2);
        }
    }
}

/* Smoothed after every step, and recorded anew from there: the filter does not notice. */
TEST(smoothing_does_not_change_the_filter)
{
    begin_both();
    for (int t = 0; t < STEPS; t++) {
        go_on(&one, &motion, &plain, t);
        go_on(&two, &motion, &plain, t);
        ASSERT_OK(S(smooth)(&one.tape));
        ASSERT_OK(S(attach)(&one.filter, &one.tape.attached));
        ASSERT_SAME(&two.filter, &one.filter, 2);
    }
}

SUITE(laws, set_up)
#include "laws.tests"
