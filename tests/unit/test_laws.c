/*
 * Laws: what must hold between runs, whatever the numbers.  Some hold bit for bit, some up to
 * rounding.  (That step is predict and update, that a forecast is so many predicts, and that
 * an innovation may overwrite its measurement, is tested with those functions.)
 */
#include "reading.h"
#include "textbook.h"

#define STEPS 8

/* ------------------------------------------------- a model, its objects, a run, its results */

typedef struct {
    num A[4], B[2], Q[4];
    num H[4], R[4]; /* two correlated components */
    num h[2], r[1]; /* and one of its own */
    num x0[2], P0[4];
    num z[STEPS][3], u[STEPS];
} numbers;

typedef struct {
    num process_words[KQ_PROCESS_LEN(2)], pair_words[KQ_SENSOR_LEN(2)], single_words[1];
    K(process) process;
    K(sensor) pair, single;
} model;

typedef struct {
    num filter_words[FILTER_LEN(2)], tape_words[HISTORY_LEN(2, 3, STEPS, 0)];
    K(filter) filter;
    K(history) tape;
} instance;

typedef struct {
    reading filtered[STEPS], smoothed[STEPS];
    num lag_one[STEPS][4], noise_mean[STEPS][2], noise_covariance[STEPS][4];
    num noise[STEPS][2]; /* of the first measurement: mean, variance */
    num gain[4], measurement[2], S[4], innovation[2], forecast[2];
} results;

static numbers plain, other;
static model motion, motion2;
static instance one, two;
static results first, second;

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
    };
    *s = constant;
    for (int t = 0; t < STEPS; t++) {
        for (int c = 0; c < 3; c++) s->z[t][c] = noise(&seed);
        s->u[t] = noise(&seed);
    }
}

/* What a test of garbage does before each call; nothing, mostly. */
static void do_nothing(void) {}
static void (*volatile before_call)(void) = do_nothing;

#define CALL(call)                                                                                 \
    do {                                                                                           \
        before_call();                                                                             \
        ASSERT_OK(call);                                                                           \
    } while (0)

static void model_init(model *m, const numbers *s)
{
    K(process) *p = &m->process;
    ASSERT_OK(K(process_assign)(p, 2, 1, m->process_words, COUNT(m->process_words)));
    ASSERT_OK(K(sensor_assign)(&m->pair, 2, 2, m->pair_words, COUNT(m->pair_words)));
    ASSERT_OK(K(sensor_assign)(&m->single, 2, 1, m->single_words, 1));
    CALL(K(process_init)(p, s->A, s->B, s->Q));
    CALL(K(sensor_init)(&m->pair, s->H, s->R));
    CALL(K(sensor_init_diagonal)(&m->single, s->h, s->r));
}

static void begin(instance *i, const numbers *s)
{
    K(filter) *f = &i->filter;
    ASSERT_OK(K(filter_assign)(f, 2, i->filter_words, COUNT(i->filter_words)));
    ASSERT_OK(K(history_assign)(&i->tape, 2, i->tape_words, COUNT(i->tape_words)));
    CALL(K(filter_init)(f, s->x0, s->P0));
    CALL(K(history_attach)(&i->tape, f));
}

/* Step 0: pair, single.  1: nothing.  2: pair.  3: the pair's second, single.  4: nothing.
   5: pair, single.  6: single.  7: pair. */
static void go_on(instance *i, const model *m, const numbers *s, int t)
{
    static const uint32_t pair[STEPS] = {3, 0, 3, 2, 0, 3, 0, 3};
    static const int single[STEPS] = {1, 0, 0, 1, 0, 1, 1, 0};
    K(filter) *f = &i->filter;
    if (t > 0) CALL(K(predict)(f, &m->process, s->u + t));
    if (pair[t] == 3) CALL(K(update)(f, &m->pair, s->z[t]));
    if (pair[t] == 2) CALL(K(update_subset)(f, &m->pair, s->z[t], 2));
    if (single[t]) CALL(K(update)(f, &m->single, s->z[t] + 2));
}

static void smooth_and_read(instance *i, results *out)
{
    for (int t = STEPS - 1; t >= 0; t--) {
        const K(smooth_extras)
            extras = {out->lag_one[t], out->noise_mean[t], out->noise_covariance[t]};
        num *v = out->noise[t];
        CALL(K(smooth_step)(&i->tape, NULL, &extras));
        if (t != 1 && t != 4) CALL(K(smoothed_measurement_noise)(&i->tape, 0, v, v + 1));
        read_smoothed(&out->smoothed[t], &i->tape, (size_t)t, 2);
    }
}

/* What the filter at its end tells of the measurement to come, and of the state ahead */
static void read_ahead(instance *i, const model *m, const numbers *s, results *out)
{
    static num words[FILTER_LEN(2)];
    K(filter) ahead;
    CALL(K(gain)(&i->filter, &m->pair, out->gain));
    CALL(K(measurement)(&i->filter, &m->pair, out->measurement, out->S));
    CALL(K(innovation)(&i->filter, &m->pair, s->z[1], out->innovation));
    ASSERT_OK(K(filter_assign)(&ahead, 2, words, COUNT(words)));
    CALL(K(forecast)(&i->filter, &m->process, s->u, 3, &ahead));
    out->forecast[0] = K(mean)(&ahead, 0);
    out->forecast[1] = K(sigma)(&ahead, 1);
}

static void run(instance *i, model *m, const numbers *s, results *out)
{
    model_init(m, s);
    begin(i, s);
    for (int t = 0; t < STEPS; t++) {
        go_on(i, m, s, t);
        read_filter(&out->filtered[t], &i->filter, 2);
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

static void a_run_made_again_gives_the_same_bits(void)
{
    run(&one, &motion, &plain, &first);
    run(&two, &motion2, &plain, &second);
    ASSERT_SAME_BITS(first, second);
    run(&one, &motion, &other, &second);
    TEST_ASSERT_TRUE(memcmp(&first, &second, sizeof first) != 0);
}

/* Two runs, step by step in turns, by the same process and the same sensors. */
static void interleaved_runs_do_not_disturb_each_other(void)
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
        read_filter(&first.filtered[t], &one.filter, 2);
        read_filter(&second.filtered[t], &two.filter, 2);
    }
    TEST_ASSERT_EQUAL_MEMORY(apart[0].filtered, first.filtered, sizeof first.filtered);
    TEST_ASSERT_EQUAL_MEMORY(apart[1].filtered, second.filtered, sizeof second.filtered);
    for (size_t t = STEPS; t-- > 0;) {
        ASSERT_OK(K(smooth_step)(&one.tape, NULL, NULL));
        ASSERT_OK(K(smooth_step)(&two.tape, NULL, NULL));
        read_smoothed(&first.smoothed[t], &one.tape, t, 2);
        read_smoothed(&second.smoothed[t], &two.tape, t, 2);
    }
    TEST_ASSERT_EQUAL_MEMORY(apart[0].smoothed, first.smoothed, sizeof first.smoothed);
    TEST_ASSERT_EQUAL_MEMORY(apart[1].smoothed, second.smoothed, sizeof second.smoothed);
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

static void garbage_in_memory_and_on_the_stack_changes_nothing(void)
{
    run_in_garbage(0x00, &first);
    run_in_garbage(0xFF, &second);
    ASSERT_SAME_BITS(first, second);
    run_in_garbage(0x55, &second);
    ASSERT_SAME_BITS(first, second);
}

/* The covariance of a linear model does not depend on the data. */
static void what_was_measured_does_not_change_the_covariance(void)
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

static void units_that_are_powers_of_two_leave_every_bit(void)
{
    static const int up[] = {10, 10, 10}, down[] = {-9, -9, -9}, odd[] = {1, 1, 1};
    assert_units_do_not_matter(up, up);
    assert_units_do_not_matter(down, down);
    assert_units_do_not_matter(odd, odd);
}

static void each_state_and_component_may_have_units_of_its_own(void)
{
    static const int x[] = {12, -7}, z[] = {3, -9, 5};
    assert_units_do_not_matter(x, z);
}

static void multiply(num *a, int count, num factor)
{
    for (int k = 0; k < count; k++) a[k] *= factor;
}

/* P0, Q and R times 4^k: the same gains and means, all covariances times 4^k. */
static void only_the_ratio_of_the_covariances_matters_to_the_mean(void)
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
        multiply(f->P, 4, N(1.0 / 64)), multiply(f->sigma, 2, 0.125), multiply(&f->nis, 1, 64);
        multiply(s->P, 4, N(1.0 / 64)), multiply(s->sigma, 2, 0.125);
        f->last = first.filtered[t].last, f->run = first.filtered[t].run;
    }
    ASSERT_SAME_BITS(first.filtered, second.filtered);
    ASSERT_SAME_BITS(first.smoothed, second.smoothed);
    ASSERT_SAME_BITS(first.gain, second.gain);
}

/* --------------------------------------------------------- many ways to take a measurement */

static void assert_close_filters(const K(filter) * a, const K(filter) * b)
{
    num P[4], other_P[4];
    for (int i = 0; i < 2; i++) ASSERT_CLOSE(whole_mean(a, i), whole_mean(b, i), 4);
    ASSERT_OK(K(covariance)(a, P));
    ASSERT_OK(K(covariance)(b, other_P));
    for (int k = 0; k < 4; k++) ASSERT_CLOSE(P[k], other_P[k], 2);
}

static void begin_both(void)
{
    model_init(&motion, &plain);
    begin(&one, &plain);
    begin(&two, &plain);
}

/* Sensor of one component for two states, in memory that is used again. */
static const K(sensor) * scalar_sensor(const num *h, num r)
{
    static num words[1], row[2], variance[1];
    static K(sensor) s;
    memcpy(row, h, sizeof row);
    variance[0] = r;
    ASSERT_OK(K(sensor_assign)(&s, 2, 1, words, 1));
    ASSERT_OK(K(sensor_init_diagonal)(&s, row, variance));
    return &s;
}

static void independent_components_may_be_taken_one_by_one(void)
{
    static const num r[] = {0.5, 2};
    begin_both();
    ASSERT_OK(K(sensor_init_diagonal)(&motion.pair, plain.H, r));
    ASSERT_OK(K(update)(&one.filter, &motion.pair, plain.z[0]));
    double sum = 0, nis = 0;
    for (int c = 0; c < 2; c++) {
        ASSERT_OK(K(update)(&two.filter, scalar_sensor(plain.H + 2 * c, r[c]), plain.z[0] + c));
        sum += (double)K(log_likelihood_last)(&two.filter);
        nis += (double)K(nis)(&two.filter);
    }
    /* the mean is brought in order once an update */
    for (int i = 0; i < 2; i++) {
        const num sigma_one = K(sigma)(&one.filter, i), sigma_two = K(sigma)(&two.filter, i);
        ASSERT_SAME_BITS(sigma_one, sigma_two);
        ASSERT_CLOSE(K(mean)(&one.filter, i), K(mean)(&two.filter, i), 1);
    }
    ASSERT_CLOSE(nis, K(nis)(&one.filter), 1 + nis);
    ASSERT_CLOSE(sum, K(log_likelihood_last)(&one.filter), 4 + fabs(sum));
}

/* R = U D U': z_0 - u z_1 and z_1 are independent, with variances R_00 - u R_01 and R_11. */
static void correlated_components_may_be_decorrelated_and_taken_one_by_one(void)
{
    const num *H = plain.H, *R = plain.R, *z = plain.z[0];
    const num u = R[1] / R[3], row[] = {H[0] - u * H[2], H[1] - u * H[3]}, z0 = z[0] - u * z[1];
    textbook t;
    begin_both();
    ASSERT_OK(K(update)(&one.filter, &motion.pair, z));
    ASSERT_OK(K(update)(&two.filter, scalar_sensor(row, R[0] - u * R[1]), &z0));
    ASSERT_OK(K(update)(&two.filter, scalar_sensor(H + 2, R[3]), z + 1));
    assert_close_filters(&one.filter, &two.filter);
    textbook_init(&t, 2, plain.x0, plain.P0);
    textbook_update(&t, H, R, z, 2);
    ASSERT_TEXTBOOK(&t, &one.filter);
    ASSERT_TEXTBOOK(&t, &two.filter);
}

/* Of three independent components those present, or a sensor that has only those. */
static void a_subset_is_a_sensor_of_those_rows(void)
{
    static const num H[] = {1, 0, 0.5, 1, -1, 0.25}, r[] = {0.5, 1, 2};
    SENSOR_DIAGONAL(three, 2, 3);
    SENSOR_DIAGONAL(outer, 2, 2);
    static const num rows[] = {1, 0, -1, 0.25}, variances[] = {0.5, 2};
    const num z[] = {plain.z[0][0], plain.z[0][2]};
    begin_both();
    ASSERT_OK(K(sensor_init_diagonal)(&three, H, r));
    ASSERT_OK(K(sensor_init_diagonal)(&outer, rows, variances));
    ASSERT_OK(K(update_subset)(&one.filter, &three, plain.z[0], 5));
    ASSERT_OK(K(update)(&two.filter, &outer, z));
    ASSERT_SAME_FILTER(&one.filter, &two.filter, 2);
}

/* The same of correlated components: what is missing has no say in it. */
static void a_subset_of_correlated_components_is_a_sensor_of_those_rows(void)
{
    static const num H[] = {1, 0, 0.5, 1, -1, 0.25};
    static const num R[] = {0.5, 0.25, -0.125, 0.25, 1, 0.5, -0.125, 0.5, 2};
    static const num rows[] = {1, 0, -1, 0.25}, noise_of_rows[] = {0.5, -0.125, -0.125, 2};
    SENSOR(three, 2, 3);
    SENSOR(outer, 2, 2);
    const num z[] = {plain.z[0][0], plain.z[0][2]};
    begin_both();
    ASSERT_OK(K(sensor_init)(&three, H, R));
    ASSERT_OK(K(sensor_init)(&outer, rows, noise_of_rows));
    ASSERT_OK(K(update_subset)(&one.filter, &three, plain.z[0], 5));
    ASSERT_OK(K(update)(&two.filter, &outer, z));
    assert_close_filters(&one.filter, &two.filter);
    ASSERT_CLOSE(K(nis)(&one.filter), K(nis)(&two.filter), 4);
    ASSERT_CLOSE(K(log_likelihood)(&one.filter), K(log_likelihood)(&two.filter), 8);
}

static void the_order_of_independent_sensors_does_not_matter(void)
{
    begin_both();
    for (int t = 0; t < STEPS; t++) {
        ASSERT_OK(K(update)(&one.filter, &motion.pair, plain.z[t]));
        ASSERT_OK(K(update)(&one.filter, &motion.single, plain.z[t] + 2));
        ASSERT_OK(K(update)(&two.filter, &motion.single, plain.z[t] + 2));
        ASSERT_OK(K(update)(&two.filter, &motion.pair, plain.z[t]));
        assert_close_filters(&one.filter, &two.filter);
        ASSERT_OK(K(predict)(&one.filter, &motion.process, plain.u + t));
        ASSERT_OK(K(predict)(&two.filter, &motion.process, plain.u + t));
    }
    ASSERT_CLOSE(K(log_likelihood)(&one.filter), K(log_likelihood)(&two.filter), 64);
}

/* Measured twice with twice the variance, or once. */
static void two_measurements_of_half_the_weight_are_one(void)
{
    begin_both();
    ASSERT_OK(K(update)(&one.filter, &motion.single, plain.z[0] + 2));
    for (int k = 0; k < 2; k++) {
        ASSERT_OK(K(update)(&two.filter, scalar_sensor(plain.h, 2 * plain.r[0]), plain.z[0] + 2));
    }
    assert_close_filters(&one.filter, &two.filter);
}

/* P^-1 = P0^-1 + sum H' R^-1 H: another P0 adds the same difference of information at the end. */
static void information_adds_up(void)
{
    double information[4];
    for (int c = 1; c <= 64; c *= 8) {
        num P0[4], P[4];
        for (int k = 0; k < 4; k++) P0[k] = N(c) * plain.P0[k];
        model_init(&motion, &plain);
        begin(&one, &plain);
        ASSERT_OK(K(filter_init)(&one.filter, plain.x0, P0));
        for (int t = 0; t < STEPS; t++) {
            ASSERT_OK(K(update)(&one.filter, &motion.pair, plain.z[t]));
        }
        ASSERT_OK(K(covariance)(&one.filter, P));
        textbook_widen(information, P, 4);
        (void)textbook_invert(information, 2);
        /* P0^-1 = [1 -.5; -.5 2] / 1.75 / c,  H'R^-1 H with R^-1 = [1 -.25; -.25 .5] / .4375 */
        const double prior[] = {1 / 1.75 / c, -0.5 / 1.75 / c, -0.5 / 1.75 / c, 2 / 1.75 / c};
        const double each[] = {0.875 / 0.4375, 0, 0, 0.5 / 0.4375};
        for (int k = 0; k < 4; k++) {
            ASSERT_CLOSE(prior[k] + STEPS * each[k], information[k], 32);
        }
    }
}

static void the_log_likelihood_is_the_sum_of_its_terms(void)
{
    double sum = 0;
    model_init(&motion, &plain);
    begin(&one, &plain);
    for (int t = 0; t < STEPS; t++) {
        ASSERT_OK(K(update)(&one.filter, &motion.pair, plain.z[t]));
        sum += (double)K(log_likelihood_last)(&one.filter);
        ASSERT_OK(K(update)(&one.filter, &motion.single, plain.z[t] + 2));
        sum += (double)K(log_likelihood_last)(&one.filter);
        ASSERT_CLOSE(sum, K(log_likelihood)(&one.filter), 1 + fabs(sum));
        ASSERT_OK(K(predict)(&one.filter, &motion.process, NULL));
    }
}

/* ------------------------------------------------------------------ the same in other words */

/* Two predicts are one by A A, with the noise A Q A' + Q. */
static void two_predicts_are_one_of_twice_the_length(void)
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
    for (int k = 0; k < 2; k++) ASSERT_OK(K(predict)(&one.filter, &motion.process, NULL));
    ASSERT_OK(K(process_init)(&motion.process, AA, plain.B, QQ));
    ASSERT_OK(K(predict)(&two.filter, &motion.process, NULL));
    assert_close_filters(&one.filter, &two.filter);
}

/* The mean is linear in x0, z and u. */
static void results_of_summed_data_are_the_sum_of_results(void)
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
            const reading *a = &first.filtered[t], *b = &second.filtered[t];
            ASSERT_CLOSE(a->mean[i] + b->mean[i], sum.filtered[t].mean[i], 8);
            a = &first.smoothed[t], b = &second.smoothed[t];
            ASSERT_CLOSE(a->mean[i] + b->mean[i], sum.smoothed[t].mean[i], 8);
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
    num A[9], Q[9], H[6], R[4], x0[3], P0[9];
} numbers3;

PROCESS(process3, 3, 0);
SENSOR(sensor3, 3, 2);
FILTER(filter3, 3);
HISTORY(tape3, 3, 2, STEPS, 0);

static void run3(const numbers3 *s, reading *filtered, reading *smoothed)
{
    ASSERT_OK(K(process_init)(&process3, s->A, NULL, s->Q));
    ASSERT_OK(K(sensor_init)(&sensor3, s->H, s->R));
    ASSERT_OK(K(filter_init)(&filter3, s->x0, s->P0));
    ASSERT_OK(K(history_attach)(&tape3, &filter3));
    for (int t = 0; t < STEPS; t++) {
        if (t > 0) ASSERT_OK(K(predict)(&filter3, &process3, NULL));
        ASSERT_OK(K(update)(&filter3, &sensor3, plain.z[t]));
        read_filter(&filtered[t], &filter3, 3);
    }
    ASSERT_OK(K(smooth)(&tape3));
    for (size_t t = 0; t < STEPS; t++) read_smoothed(&smoothed[t], &tape3, t, 3);
}

static void assert_permuted(const reading *straight, const reading *permuted)
{
    num mean[3], P[9];
    permute(mean, straight->mean, 3, 1, 1, 0);
    permute(P, straight->P, 3, 3, 1, 1);
    for (int i = 0; i < 3; i++) ASSERT_CLOSE(mean[i], permuted->mean[i], 4);
    for (int k = 0; k < 9; k++) ASSERT_CLOSE(P[k], permuted->P[k], 4);
}

static void the_order_of_the_states_does_not_matter(void)
{
    static const numbers3 straight = {
        {1, 0.5, 0.125, 0, 1, 0.5, -0.25, 0, 0.5},
        {0.25, 0.125, 0, 0.125, 0.5, 0.25, 0, 0.25, 1},
        {1, 0, 0, 0.5, 1, -1},
        {0.5, 0.25, 0.25, 1},
        {1, -2, 0.5},
        {2, 0.5, 0, 0.5, 1, 0.25, 0, 0.25, 1},
    };
    static numbers3 turned;
    turned = straight;
    permute(turned.A, straight.A, 3, 3, 1, 1);
    permute(turned.Q, straight.Q, 3, 3, 1, 1);
    permute(turned.P0, straight.P0, 3, 3, 1, 1);
    permute(turned.H, straight.H, 2, 3, 0, 1);
    permute(turned.x0, straight.x0, 3, 1, 1, 0);
    run3(&straight, first.filtered, first.smoothed);
    run3(&turned, second.filtered, second.smoothed);
    for (int t = 0; t < STEPS; t++) {
        assert_permuted(&first.filtered[t], &second.filtered[t]);
        assert_permuted(&first.smoothed[t], &second.smoothed[t]);
        ASSERT_CLOSE(first.filtered[t].run, second.filtered[t].run, 64);
    }
}

/* ------------------------------------------------------------------------- the smoother */

static void the_last_smoothed_step_is_the_filtered_one(void)
{
    run(&one, &motion, &plain, &first);
    const reading *end = &first.filtered[STEPS - 1], *last = &first.smoothed[STEPS - 1];
    TEST_ASSERT_EQUAL_MEMORY(end, last, offsetof(reading, nis));
}

static void a_smoothed_sigma_is_never_above_the_filtered_one(void)
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

static void smoothing_at_once_is_smoothing_step_by_step(void)
{
    run(&one, &motion, &plain, &first);
    begin(&two, &plain);
    for (int t = 0; t < STEPS; t++) go_on(&two, &motion, &plain, t);
    ASSERT_OK(K(smooth)(&two.tape));
    for (size_t t = 0; t < STEPS; t++) read_smoothed(&second.smoothed[t], &two.tape, t, 2);
    ASSERT_SAME_BITS(first.smoothed, second.smoothed);
}

static void states_only_are_the_same_states(void)
{
    run(&one, &motion, &plain, &first);
    begin(&two, &plain);
    for (int t = 0; t < STEPS; t++) go_on(&two, &motion, &plain, t);
    ASSERT_OK(K(smooth_states)(&two.tape));
    for (size_t t = 0; t < STEPS; t++) {
        for (int i = 0; i < 2; i++) {
            const reading *r = &first.smoothed[t];
            const double whole = (double)r->mean[i] + (double)r->low[i];
            ASSERT_CLOSE(whole, whole_smoothed_mean(&two.tape, t, i), 2);
        }
    }
}

/* Smoothed after every step, and recorded anew from there: the filter does not notice. */
static void smoothing_does_not_change_the_filter(void)
{
    begin_both();
    for (int t = 0; t < STEPS; t++) {
        go_on(&one, &motion, &plain, t);
        go_on(&two, &motion, &plain, t);
        ASSERT_OK(K(smooth)(&one.tape));
        ASSERT_OK(K(history_attach)(&one.tape, &one.filter));
        ASSERT_SAME_FILTER(&two.filter, &one.filter, 2);
    }
}

/* ------------------------------------------------------------------------------------- */

static void run_bitwise_laws(void)
{
    RUN_TEST(a_run_made_again_gives_the_same_bits);
    RUN_TEST(interleaved_runs_do_not_disturb_each_other);
    RUN_TEST(garbage_in_memory_and_on_the_stack_changes_nothing);
    RUN_TEST(what_was_measured_does_not_change_the_covariance);
    RUN_TEST(units_that_are_powers_of_two_leave_every_bit);
    RUN_TEST(each_state_and_component_may_have_units_of_its_own);
    RUN_TEST(only_the_ratio_of_the_covariances_matters_to_the_mean);
}

static void run_measurement_laws(void)
{
    RUN_TEST(independent_components_may_be_taken_one_by_one);
    RUN_TEST(correlated_components_may_be_decorrelated_and_taken_one_by_one);
    RUN_TEST(a_subset_is_a_sensor_of_those_rows);
    RUN_TEST(a_subset_of_correlated_components_is_a_sensor_of_those_rows);
    RUN_TEST(the_order_of_independent_sensors_does_not_matter);
    RUN_TEST(two_measurements_of_half_the_weight_are_one);
    RUN_TEST(information_adds_up);
    RUN_TEST(the_log_likelihood_is_the_sum_of_its_terms);
}

SUITE(laws, set_up)
{
    run_bitwise_laws();
    run_measurement_laws();
    RUN_TEST(two_predicts_are_one_of_twice_the_length);
    RUN_TEST(results_of_summed_data_are_the_sum_of_results);
    RUN_TEST(the_order_of_the_states_does_not_matter);
    RUN_TEST(the_last_smoothed_step_is_the_filtered_one);
    RUN_TEST(a_smoothed_sigma_is_never_above_the_filtered_one);
    RUN_TEST(smoothing_at_once_is_smoothing_step_by_step);
    RUN_TEST(states_only_are_the_same_states);
    RUN_TEST(smoothing_does_not_change_the_filter);
}
