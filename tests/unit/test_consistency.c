/* Statistics over a window: against sums made from what the filter tells, and what is refused, in all arithmetics. */
#define MAX 16

#include "models.h"
#include "unchanged.h"

#ifdef KQ_TEST_Q31
#define ALLOWED(size) (0x1p-19 * (1 + (size))) /* an innovation is good to some units of 2^-24 */
#define FAR 900
#else
#define ALLOWED(size) (TOLERANCE * (size))
#define FAR 1e12
#endif

#define WINDOW 5
#define STEPS 40
#define ALL UINT32_MAX

S_CONSISTENCY(recent, 2, WINDOW);
S_CONSISTENCY(blank, 2, WINDOW); /* without memory, where it matters */
static process_model motion;
static sensor_model radar, compass;
static prior_model prior;
S_FILTER(track, 2);

static const num range[] = {1000, 1000};
static const num A[] = {1, 0.5, 0, 1}, Q[] = {0.25, 0.125, 0.125, 0.5};
static const num H[] = {1, 0, 0.5, 1}, R[] = {0.5, 0.25, 0.25, 1};
static const num direction[] = {-1, 0.25}, variance[] = {0.125};
static const num x0[] = {1, -2}, P0[] = {2, 0.5, 0.5, 1};

static word z[2];
static score out[4];

static void set_z(double a, double b)
{
    const num values[] = {N(a), N(b)};
    memcpy(z, measured(&radar.sensor, values), sizeof z);
}

static void set_up(void)
{
    put_process(&motion, 2, 0, range, NULL, A, NULL, Q);
    put_sensor(&radar, 2, 2, range, range, H, R);
    put_sensor(&compass, 2, 1, range, range, direction, variance);
    put_prior(&prior, 2, range, x0, P0);
    ASSERT_OK(init_filter(&track, &prior));
    ASSERT_OK(S(consistency_assign)(&recent, 2, WINDOW, recent_memory, COUNT(recent_memory)));
    memset(recent_memory, 0, sizeof recent_memory);
    memset(&blank, 0, sizeof blank);
    set_z(2, -1);
    watch_nothing();
    WATCH(recent), WATCH(recent_memory), WATCH(track), WATCH(track_memory), WATCH(radar.sensor);
    WATCH(blank), WATCH(out);
}

static kq_status watch_all(void) { return S(consistency_watch)(&recent, &track, &radar.sensor, z, ALL); }

/* The statistics at 2 sigma, as numbers */
static kq_status read_nis(double *value)
{
    score now[3];
    const kq_status status = S(consistency_nis)(&recent, score_of(2), &now[0], &now[1], &now[2]);
    for (int k = 0; k < 3 && !status; k++) value[k] = score_number(now[k]);
    return status;
}

static kq_status read_innovations(int c, double *value)
{
    score now[4];
    const kq_status status =
        S(consistency_innovation)(&recent, c, score_of(2), &now[0], &now[1], &now[2], &now[3]);
    for (int k = 0; k < 4 && !status; k++) value[k] = score_number(now[k]);
    return status;
}

/* ------------------------------------------------------------ what is watched */

static double nis[STEPS], unit[2][STEPS];
static int taken[STEPS];
static int is_there[2][STEPS];

/* One update of the two components present; what it should enter with */
static void step(int k, uint32_t present)
{
    num e[2], expected[2], cov[4];
    ASSERT_OK(read_innovation(&track, &radar.sensor, z, e));
    ASSERT_OK(read_measurement(&track, &radar.sensor, expected, cov));
    ASSERT_OK(S(consistency_watch)(&recent, &track, &radar.sensor, z, present));
    ASSERT_OK(S(update_subset)(&track, &radar.sensor, z, present));
    ASSERT_OK(S(consistency_record)(&recent, &track));
    for (int c = 0; c < 2; c++) {
        unit[c][k] = (double)e[c] / sqrt((double)cov[3 * c]);
        is_there[c][k] = present >> c & 1;
    }
    nis[k] = score_number(S(nis)(&track));
    taken[k] = S(taken)(&track);
    ASSERT_OK(S(predict)(&track, &motion.process, NULL));
}

static void run(uint32_t seed, int steps, uint32_t (*present)(int))
{
    for (int k = 0; k < steps; k++) {
        const double a = 3 * (double)noise(&seed), b = 3 * (double)noise(&seed);
        set_z(a, b);
        step(k, present(k));
    }
}

static uint32_t always(int k)
{
    (void)k;
    return ALL;
}

static uint32_t now_and_then(int k) { return (uint32_t)(k % 4 == 0 ? 1 : k % 3 == 0 ? 2 : 3); }

/* Over steps first .. last-1 */
static void assert_window(int first, int last)
{
    double a[4], sum = 0;
    int degrees = 0;
    for (int k = first; k < last; k++) sum += nis[k], degrees += taken[k];
    TEST_ASSERT_EQUAL_INT(last - first, S(consistency_count)(&recent));
    ASSERT_OK_UNCHANGED(read_nis(a));
    ASSERT_WITHIN(ALLOWED(sum), sum / degrees, a[0]);
    const double share = 2.0 / 9 / degrees;
    const double base = 1 - share - 2 * sqrt(share);
    ASSERT_WITHIN(ALLOWED(1), base > 0 ? base * base * base : 0, a[1]);
    ASSERT_WITHIN(ALLOWED(a[2]), pow(1 - share + 2 * sqrt(share), 3), a[2]);
    for (int c = 0; c < 2; c++) {
        double mean = 0, square = 0, along = 0;
        int count = 0, pairs = 0;
        for (int k = first; k < last; k++) {
            if (!is_there[c][k]) continue;
            count++;
            mean += unit[c][k];
            square += unit[c][k] * unit[c][k];
            if (k == first || !is_there[c][k - 1]) continue;
            pairs++;
            along += unit[c][k] * unit[c][k - 1];
        }
        ASSERT_OK_UNCHANGED(read_innovations(c, a));
        ASSERT_WITHIN(ALLOWED(8), mean / count, a[0]);
        ASSERT_WITHIN(ALLOWED(2), 2 / sqrt(count), a[1]);
        ASSERT_WITHIN(ALLOWED(8), along / square, a[2]);
        ASSERT_WITHIN(ALLOWED(2), 2 * sqrt(pairs) / count, a[3]);
    }
}

/* Filling up, full, and after the ring has turned twice */
TEST(the_window_is_that_of_the_last_updates)
{
    for (int steps = 1; steps <= STEPS; steps++) {
        set_up();
        run(3, steps, always);
        assert_window(steps < WINDOW ? 0 : steps - WINDOW, steps);
    }
}

TEST(components_may_be_missing)
{
    for (int steps = 5; steps <= STEPS; steps++) {
        set_up();
        run(5, steps, now_and_then);
        assert_window(steps - WINDOW, steps);
    }
}

/* What has left the window has left nothing behind. */
TEST(nothing_drifts)
{
    double with_outlier[3], without[3];
    set_z(FAR, -1);
    step(0, ALL);
    ASSERT_OK(init_filter(&track, &prior));
    run(9, WINDOW, always);
    ASSERT_OK(read_nis(with_outlier));
    ASSERT_OK(S(consistency_clear)(&recent));
    ASSERT_OK(init_filter(&track, &prior));
    run(9, WINDOW, always);
    ASSERT_OK(read_nis(without));
    ASSERT_SAME_BITS(with_outlier, without);
}

TEST(an_update_that_takes_nothing_does_not_enter)
{
    run(3, 3, always);
    ASSERT_OK(S(consistency_watch)(&recent, &track, &radar.sensor, z, 0));
    ASSERT_OK(S(update_subset)(&track, &radar.sensor, z, 0));
    ASSERT_OK(S(consistency_record)(&recent, &track));
    assert_window(0, 3);
    ASSERT_REFUSED(KQ_ERR_NOT_READY, S(consistency_record)(&recent, &track));
}

static kq_status watched_step(void)
{
    ASSERT_OK(watch_all());
    ASSERT_OK(S(step)(&track, &motion.process, NULL, &radar.sensor, z));
    return S(consistency_record)(&recent, &track);
}

/* A settled step judges no measurement: kq_nis is that of a step long ago. */
TEST(a_settled_step_does_not_enter)
{
    S_FREEZE(lazy, 2, 2);
    S_FILTER(copy, 2);
    ASSERT_OK(S(freeze_init)(&lazy, 10));
    ASSERT_OK(S(attach)(&track, &lazy.attached));
    for (int t = 0; t < 60 && !S(freeze_is_active)(&lazy); t++) {
        ASSERT_OK(S(step)(&track, &motion.process, NULL, &radar.sensor, z));
    }
    TEST_ASSERT_EQUAL_INT(1, S(freeze_is_active)(&lazy));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NOT_READY, watched_step());
    ASSERT_REFUSED(KQ_ERR_NOT_READY, S(consistency_record)(&recent, &track));
    TEST_ASSERT_EQUAL_INT(0, S(consistency_count)(&recent));
    step(0, ALL); /* an update by itself, and after the predict by itself another one */
    step(1, ALL);
    assert_window(0, 2);
    ASSERT_OK(watched_step()); /* of the full filter */
    copy = track;
    copy.memory = copy_memory;
    memcpy(copy_memory, track_memory, sizeof copy_memory);
    for (int t = 0; t < 60; t++) ASSERT_OK(S(step)(&track, &motion.process, NULL, &radar.sensor, z));
    TEST_ASSERT_EQUAL_INT(1, S(freeze_is_active)(&lazy));
    ASSERT_OK(S(consistency_watch)(&recent, &copy, &radar.sensor, z, ALL)); /* it is not settled */
    ASSERT_OK(S(update)(&copy, &radar.sensor, z));
    ASSERT_OK(S(consistency_record)(&recent, &copy));
    TEST_ASSERT_EQUAL_INT(4, S(consistency_count)(&recent));
}

/* Watched, and not taken after all: the next measurement takes its place. */
TEST(what_is_watched_may_be_dropped)
{
    run(3, 2, always);
    set_z(100, -1);
    ASSERT_OK(watch_all());
    set_z(1, -1);
    step(2, ALL);
    assert_window(0, 3);
}

TEST(watching_leaves_the_filter)
{
    watch_nothing();
    WATCH(track), WATCH(track_memory), WATCH(radar.sensor), WATCH(z);
    ASSERT_OK_UNCHANGED(watch_all());
}

/* A noise-free component that is known already: e / sqrt(0) */
TEST(a_variance_of_0_counts_as_missing)
{
    static const num nothing[] = {0, 0, 0, 0}, none[] = {0, 1};
    double a[4];
    put_prior(&prior, 2, range, x0, nothing);
    ASSERT_OK(init_filter(&track, &prior));
    put_independent(&radar, 2, 2, range, range, H, none);
    ASSERT_OK(watch_all());
    ASSERT_OK(S(update)(&track, &radar.sensor, z));
    ASSERT_OK(S(consistency_record)(&recent, &track));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, read_innovations(0, a));
    ASSERT_OK(read_innovations(1, a));
}

TEST(innovations_of_0_have_no_correlation)
{
    double a[4];
    ASSERT_OK(S(measurement)(&track, &radar.sensor, z, NULL));
    for (int k = 0; k < 3; k++) {
        ASSERT_OK(watch_all());
        ASSERT_OK(S(update)(&track, &radar.sensor, z));
        ASSERT_OK(S(consistency_record)(&recent, &track));
    }
    ASSERT_OK(read_innovations(0, a));
    ASSERT_WITHIN(ALLOWED(1), 0, a[0]);
    TEST_ASSERT_TRUE(a[2] >= -1 && a[2] <= 1);
}

/* Of both signs by turns; in q31 their squares are some units, or none */
TEST(innovations_next_to_nothing_are_correlated_within_1)
{
    static const num within[] = {1, 1}, none[] = {0, 0, 0, 0}, identity[] = {1, 0, 0, 1}, ones[] = {1, 1};
    double a[4];
    put_independent(&radar, 2, 2, within, within, identity, ones);
    put_prior(&prior, 2, within, none, none);
    ASSERT_OK(init_filter(&track, &prior));
    for (int e = 8; e < 16; e++) {
        for (int k = 0; k < WINDOW; k++) {
            const double next = ldexp(k % 2 ? 1 : -0.6, -e);
            set_z(next, -next);
            ASSERT_OK(watch_all());
            ASSERT_OK(S(update)(&track, &radar.sensor, z));
            ASSERT_OK(S(consistency_record)(&recent, &track));
        }
        ASSERT_OK(read_innovations(1, a));
        TEST_ASSERT_TRUE(a[2] >= -1 && a[2] <= 0);
    }
}

TEST(clearing_forgets)
{
    double a[3];
    run(3, 7, always);
    ASSERT_OK(watch_all());
    ASSERT_OK(S(consistency_clear)(&recent));
    TEST_ASSERT_EQUAL_INT(0, S(consistency_count)(&recent));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, S(consistency_record)(&recent, &track));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, read_nis(a));
    run(3, 3, always);
    assert_window(0, 3);
}

/* SciPy: chi2.ppf(p / 2, d) / d and chi2.isf(p / 2, d) / d, p = 2 norm.sf(q), and the errors that
   the manual states */
TEST(the_bounds_are_those_of_chi_square)
{
    static const struct {
        double q, low, high, error;
        int degrees;
    } quantiles[] = {
        {1.96, 0.324690, 2.048343, 8e-3, 10},   {1.96, 0.479532, 1.708497, 2e-3, 20},
        {1.96, 0.647142, 1.428413, 3e-4, 50},   {1.96, 0.742215, 1.295618, 8e-5, 100},
        {1.96, 0.914256, 1.089533, 3e-6, 1000}, {2.576, 0.215560, 2.518957, 3e-2, 10},
        {2.576, 0.371665, 1.999927, 7e-3, 20},  {2.576, 0.559792, 1.589846, 2e-3, 50},
        {2.576, 0.673257, 1.401725, 4e-4, 100}, {2.576, 0.888556, 1.118956, 1e-5, 1000},
    };
    static word memory[S_CONSISTENCY_LEN(2, 500)];
    S(consistency) longer;
    score a, low, high;
    for (int k = 0; k < COUNT(quantiles); k++) {
        const int updates = quantiles[k].degrees / 2;
        ASSERT_OK(S(consistency_assign)(&longer, 2, (size_t)updates, memory, COUNT(memory)));
        for (int t = 0; t < updates; t++) {
            ASSERT_OK(S(consistency_watch)(&longer, &track, &radar.sensor, z, ALL));
            ASSERT_OK(S(update)(&track, &radar.sensor, z));
            ASSERT_OK(S(consistency_record)(&longer, &track));
        }
        ASSERT_OK(S(consistency_nis)(&longer, score_of(quantiles[k].q), &a, &low, &high));
        const double error = quantiles[k].error + ALLOWED(4. / 64);
        ASSERT_WITHIN(error * quantiles[k].low, quantiles[k].low, score_number(low));
        ASSERT_WITHIN(error * quantiles[k].high, quantiles[k].high, score_number(high));
    }
}

/* ------------------------------------------------------------ what is refused */

TEST(watch_refuses_another_number_of_components)
{
    ASSERT_REFUSED(KQ_ERR_MISMATCH, S(consistency_watch)(&recent, &track, &compass.sensor, z, ALL));
    set_z(2, -1);
    z[1] = bad_word(&radar.sensor, 0);
    ASSERT_OK(S(consistency_watch)(&recent, &track, &radar.sensor, z, 1)); /* it is not read */
}

TEST(readings_refuse)
{
    score *a = &out[0], *b = &out[1], *c = &out[2], *d = &out[3];
    const score two = score_of(2);
    ASSERT_REFUSED(KQ_ERR_NOT_READY, S(consistency_nis)(&recent, two, a, b, c));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, S(consistency_innovation)(&recent, 0, two, a, b, c, d));
    run(3, 3, always);
#ifndef KQ_TEST_Q31
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, S(consistency_nis)(&recent, (num)NAN, a, b, c));
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, S(consistency_nis)(&recent, (num)INFINITY, a, b, c));
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, S(consistency_innovation)(&recent, 0, (num)NAN, a, b, c, d));
#endif
    TEST_ASSERT_EQUAL_INT(0, S(consistency_count)(NULL));
    TEST_ASSERT_EQUAL_INT(0, S(consistency_count)(&blank));
}

#ifdef KQ_TEST_Q31
static void step_far(void)
{
    set_z(900, -900);
    step(0, ALL);
}

/* Held at 128 sigma */
TEST_Q31(an_innovation_is_held)
{
    double a[4];
    step_far();
    ASSERT_OK(read_innovations(0, a));
    ASSERT_WITHIN(1e-6, 128, a[0]);
    ASSERT_WITHIN(1e-6, 2, a[1]);
    ASSERT_WITHIN(0, 0, a[2]);
    ASSERT_WITHIN(0, 0, a[3]); /* not one pair */
    ASSERT_OK(read_nis(a));
    TEST_ASSERT_TRUE(a[0] > 128 * 128);
}

/* A quantile of any size */
TEST_Q31(bounds_of_any_quantile_are_within_the_numbers)
{
    step(0, ALL);
    ASSERT_OK(kq_consistency_nis_q31(&recent, INT64_MAX, &out[0], &out[1], &out[2]));
    TEST_ASSERT_TRUE(out[1] == 0 && out[2] == INT64_C(1) << 61);
    ASSERT_OK(kq_consistency_nis_q31(&recent, 0, &out[0], &out[1], &out[2]));
    TEST_ASSERT_TRUE(out[1] == out[2]);
}
#else
/* Squares of both would overflow, and the correlation would be NaN. */
TEST_FLOAT(an_innovation_too_far_counts_as_missing)
{
    double a[4];
    set_z(1, -1);
    step(0, ALL);
    for (int k = 1; k < 3; k++) {
        z[0] = N(EPS > 1e-10 ? 1e25 : 1e200) * N(k == 1 ? 1 : -1);
        step(k, ALL); /* the other one is taken */
    }
    ASSERT_OK(read_innovations(0, a));
    TEST_ASSERT_TRUE(a[2] == 0); /* not one pair */
    ASSERT_WITHIN(1e-6, 2, a[1]);
}
#endif

SUITE(consistency, set_up)
#include "consistency.tests"
