/* Statistics over a window: against sums made from what the filter tells, and what is refused. */
#include "reading.h"
#include "sizes.h"
#include "unchanged.h"

#ifdef KQ_TEST_F32
#define CONSISTENCY KQ_CONSISTENCY_F32
#define CONSISTENCY_LEN KQ_CONSISTENCY_LEN_F32
#define SETTLING KQ_FREEZE_F32
#else
#define CONSISTENCY KQ_CONSISTENCY_F64
#define CONSISTENCY_LEN KQ_CONSISTENCY_LEN_F64
#define SETTLING KQ_FREEZE_F64
#endif

#define WINDOW 5
#define STEPS 14
#define ALL UINT32_MAX

CONSISTENCY(recent, 2, WINDOW);
CONSISTENCY(blank, 2, WINDOW); /* without memory, where it matters */
PROCESS(motion, 2, 0);
SENSOR(radar, 2, 2);
SENSOR(compass, 2, 1);
SENSOR(blank_sensor, 2, 2);
FILTER(track, 2);
FILTER(blank_filter, 2);

static const num A[] = {1, 0.5, 0, 1}, Q[] = {0.25, 0.125, 0.125, 0.5};
static const num H[] = {1, 0, 0.5, 1}, R[] = {0.5, 0.25, 0.25, 1};
static const num direction[] = {-1, 0.25}, variance[] = {0.125};
static const num x0[] = {1, -2}, P0[] = {2, 0.5, 0.5, 1};

static num z[2], out[4];

static void set_up(void)
{
    ASSERT_OK(K(process_init)(&motion, A, NULL, Q));
    ASSERT_OK(K(sensor_init)(&radar, H, R));
    ASSERT_OK(K(sensor_init)(&compass, direction, variance));
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    ASSERT_OK(K(consistency_assign)(&recent, 2, WINDOW, recent_memory, COUNT(recent_memory)));
    memset(recent_memory, 0, sizeof recent_memory);
    memset(&blank, 0, sizeof blank);
    z[0] = 2, z[1] = -1;
    watch_nothing();
    WATCH(recent), WATCH(recent_memory), WATCH(track), WATCH(track_memory), WATCH(radar);
    WATCH(blank), WATCH(out);
}

/* ------------------------------------------------------------ what is watched */

static double nis[STEPS], unit[2][STEPS];
static int taken[STEPS];
static int is_there[2][STEPS];

/* One update of the two components present; what it should enter with */
static void step(int k, uint32_t present)
{
    num e[2], S[4];
    ASSERT_OK(K(innovation)(&track, &radar, z, e));
    ASSERT_OK(K(measurement)(&track, &radar, NULL, S));
    ASSERT_OK(K(consistency_watch)(&recent, &track, &radar, z, present));
    ASSERT_OK(K(update_subset)(&track, &radar, z, present));
    ASSERT_OK(K(consistency_record)(&recent, &track));
    for (int c = 0; c < 2; c++) {
        unit[c][k] = (double)e[c] / sqrt((double)S[3 * c]);
        is_there[c][k] = present >> c & 1;
    }
    nis[k] = (double)K(nis)(&track);
    taken[k] = K(taken)(&track);
    ASSERT_OK(K(predict)(&track, &motion, NULL));
}

static void run(uint32_t seed, int steps, uint32_t (*present)(int))
{
    for (int k = 0; k < steps; k++) {
        z[0] = 3 * noise(&seed), z[1] = 3 * noise(&seed);
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
    num a, low, high, correlation, bound, spread;
    double sum = 0;
    int degrees = 0;
    for (int k = first; k < last; k++) sum += nis[k], degrees += taken[k];
    TEST_ASSERT_EQUAL_INT(last - first, K(consistency_count)(&recent));
    ASSERT_OK_UNCHANGED(K(consistency_nis)(&recent, 2, &a, &low, &high));
    ASSERT_CLOSE(sum / degrees, a, sum);
    const double share = 2.0 / 9 / degrees;
    const double base = 1 - share - 2 * sqrt(share);
    ASSERT_CLOSE(base > 0 ? base * base * base : 0, low, 1);
    ASSERT_CLOSE(pow(1 - share + 2 * sqrt(share), 3), high, high);
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
        ASSERT_OK_UNCHANGED(
            K(consistency_innovation)(&recent, c, 2, &a, &bound, &correlation, &spread));
        ASSERT_CLOSE(mean / count, a, 8);
        ASSERT_CLOSE(along / square, correlation, 8);
        ASSERT_CLOSE(2 / sqrt(count), bound, 2);
        ASSERT_CLOSE(2 * sqrt(pairs) / count, spread, 2);
    }
}

/* Filling up, full, and after the ring has turned twice */
static void the_window_is_that_of_the_last_updates(void)
{
    for (int steps = 1; steps <= STEPS; steps++) {
        set_up();
        run(3, steps, always);
        assert_window(steps < WINDOW ? 0 : steps - WINDOW, steps);
    }
}

static void components_may_be_missing(void)
{
    for (int steps = 5; steps <= STEPS; steps++) {
        set_up();
        run(5, steps, now_and_then);
        assert_window(steps - WINDOW, steps);
    }
}

/* What has left the window has left nothing behind. */
static void nothing_drifts(void)
{
    static num after[COUNT(recent_memory)];
    num first[3], second[3];
    K(consistency) later;
    z[0] = N(1e12);
    step(0, ALL);
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    run(9, WINDOW, always);
    ASSERT_OK(K(consistency_nis)(&recent, 2, &first[0], &first[1], &first[2]));
    ASSERT_OK(K(consistency_assign)(&later, 2, WINDOW, after, COUNT(after)));
    recent = later;
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    run(9, WINDOW, always);
    ASSERT_OK(K(consistency_nis)(&recent, 2, &second[0], &second[1], &second[2]));
    ASSERT_SAME_BITS(first, second);
}

static void an_update_that_takes_nothing_does_not_enter(void)
{
    run(3, 3, always);
    ASSERT_OK(K(consistency_watch)(&recent, &track, &radar, z, 0));
    ASSERT_OK(K(update_subset)(&track, &radar, z, 0));
    ASSERT_OK(K(consistency_record)(&recent, &track));
    assert_window(0, 3);
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(consistency_record)(&recent, &track));
}

/* Until the freeze has settled; then step by step as before. */
static kq_status watched_step(void)
{
    ASSERT_OK(K(consistency_watch)(&recent, &track, &radar, z, ALL));
    ASSERT_OK(K(step)(&track, &motion, NULL, &radar, z));
    return K(consistency_record)(&recent, &track);
}

/* A settled step judges no measurement: kq_nis is that of a step long ago. */
static void a_settled_step_does_not_enter(void)
{
    SETTLING(lazy, 2, 2);
    FILTER(copy, 2);
    ASSERT_OK(K(freeze_init)(&lazy, 10));
    ASSERT_OK(K(attach)(&track, &lazy.attached));
    for (int t = 0; t < 60 && !K(freeze_is_active)(&lazy); t++) {
        ASSERT_OK(K(step)(&track, &motion, NULL, &radar, z));
    }
    TEST_ASSERT_EQUAL_INT(1, K(freeze_is_active)(&lazy));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NOT_READY, watched_step());
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(consistency_record)(&recent, &track));
    TEST_ASSERT_EQUAL_INT(0, K(consistency_count)(&recent));
    step(0, ALL); /* an update by itself, and after the predict by itself another one */
    step(1, ALL);
    assert_window(0, 2);
    ASSERT_OK(watched_step()); /* of the full filter */
    copy = track;
    copy.memory = copy_memory;
    memcpy(copy_memory, track_memory, sizeof copy_memory);
    for (int t = 0; t < 60; t++) ASSERT_OK(K(step)(&track, &motion, NULL, &radar, z));
    TEST_ASSERT_EQUAL_INT(1, K(freeze_is_active)(&lazy));
    ASSERT_OK(K(consistency_watch)(&recent, &copy, &radar, z, ALL)); /* it is not settled */
    ASSERT_OK(K(update)(&copy, &radar, z));
    ASSERT_OK(K(consistency_record)(&recent, &copy));
    TEST_ASSERT_EQUAL_INT(4, K(consistency_count)(&recent));
}

/* Watched, and not taken after all: the next measurement takes its place. */
static void what_is_watched_may_be_dropped(void)
{
    run(3, 2, always);
    z[0] = 100;
    ASSERT_OK(K(consistency_watch)(&recent, &track, &radar, z, ALL));
    z[0] = 1;
    step(2, ALL);
    assert_window(0, 3);
}

static void watching_leaves_the_filter(void)
{
    watch_nothing();
    WATCH(track), WATCH(track_memory), WATCH(radar), WATCH(z);
    ASSERT_OK_UNCHANGED(K(consistency_watch)(&recent, &track, &radar, z, ALL));
}

/* A noise-free component that is known already: e / sqrt(0) */
static void a_variance_of_0_counts_as_missing(void)
{
    static const num nothing[] = {0, 0, 0, 0}, none[] = {0, 1};
    num a, b, c, d;
    ASSERT_OK(K(filter_init)(&track, x0, nothing));
    ASSERT_OK(K(sensor_init_diagonal)(&radar, H, none));
    ASSERT_OK(K(consistency_watch)(&recent, &track, &radar, z, ALL));
    ASSERT_OK(K(update)(&track, &radar, z));
    ASSERT_OK(K(consistency_record)(&recent, &track));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(consistency_innovation)(&recent, 0, 2, &a, &b, &c, &d));
    ASSERT_OK(K(consistency_innovation)(&recent, 1, 2, &a, &b, &c, &d));
}

static void innovations_of_0_have_no_correlation(void)
{
    num mean, bound, correlation, spread;
    ASSERT_OK(K(measurement)(&track, &radar, z, NULL));
    for (int k = 0; k < 3; k++) {
        ASSERT_OK(K(consistency_watch)(&recent, &track, &radar, z, ALL));
        ASSERT_OK(K(update)(&track, &radar, z));
        ASSERT_OK(K(consistency_record)(&recent, &track));
    }
    ASSERT_OK(K(consistency_innovation)(&recent, 0, 2, &mean, &bound, &correlation, &spread));
    ASSERT_WITHIN(TOLERANCE, 0, mean);
    TEST_ASSERT_TRUE(correlation >= -1 && correlation <= 1);
}

static void clearing_forgets(void)
{
    num a, b, c;
    run(3, 7, always);
    ASSERT_OK(K(consistency_watch)(&recent, &track, &radar, z, ALL));
    ASSERT_OK(K(consistency_clear)(&recent));
    TEST_ASSERT_EQUAL_INT(0, K(consistency_count)(&recent));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(consistency_record)(&recent, &track));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(consistency_nis)(&recent, 2, &a, &b, &c));
    run(3, 3, always);
    assert_window(0, 3);
}

/* SciPy: chi2.ppf(p / 2, d) / d and chi2.isf(p / 2, d) / d, p = 2 norm.sf(q), and the errors that
   the manual states */
static void the_bounds_are_those_of_chi_square(void)
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
    static num memory[CONSISTENCY_LEN(2, 500)];
    K(consistency) longer;
    num a, low, high;
    for (int k = 0; k < COUNT(quantiles); k++) {
        const int updates = quantiles[k].degrees / 2;
        ASSERT_OK(K(consistency_assign)(&longer, 2, (size_t)updates, memory, COUNT(memory)));
        for (int t = 0; t < updates; t++) {
            ASSERT_OK(K(consistency_watch)(&longer, &track, &radar, z, ALL));
            ASSERT_OK(K(update)(&track, &radar, z));
            ASSERT_OK(K(consistency_record)(&longer, &track));
        }
        ASSERT_OK(K(consistency_nis)(&longer, N(quantiles[k].q), &a, &low, &high));
        const double error = quantiles[k].error + 4 * EPS;
        ASSERT_WITHIN(error * quantiles[k].low, quantiles[k].low, low);
        ASSERT_WITHIN(error * quantiles[k].high, quantiles[k].high, high);
    }
}

/* One component, one update; 16 components; nothing is written outside */
static void sizes_may_be_the_smallest_and_the_largest(void)
{
    static num room[GUARDED(CONSISTENCY_LEN(16, 3))], filter_memory[FILTER_LEN(16)];
    static num sensor_memory[KQ_SENSOR_DIAGONAL_LEN(16)], identity[256], ones[16], zeros[16];
    K(consistency) c;
    K(filter) f;
    K(sensor) s;
    num a, b, d, e;
    for (int m = 1; m <= 16; m += 15) {
        const int window = m == 1 ? 1 : 3;
        num *memory = guard(room, COUNT(room));
        put_identity(identity, m, 1);
        for (int i = 0; i < m; i++) ones[i] = 1;
        ASSERT_OK(K(filter_assign)(&f, m, filter_memory, COUNT(filter_memory)));
        ASSERT_OK(K(filter_init)(&f, zeros, identity));
        ASSERT_OK(K(sensor_assign)(&s, m, m, sensor_memory, COUNT(sensor_memory)));
        ASSERT_OK(K(sensor_init_diagonal)(&s, identity, ones));
        ASSERT_OK(K(consistency_assign)(&c, m, (size_t)window, memory, (size_t)CONSISTENCY_LEN(m, window)));
        for (int t = 0; t < 2 * window + 1; t++) {
            ASSERT_OK(K(consistency_watch)(&c, &f, &s, ones, ALL));
            ASSERT_OK(K(update)(&f, &s, ones));
            ASSERT_OK(K(consistency_record)(&c, &f));
        }
        TEST_ASSERT_EQUAL_INT(window, K(consistency_count)(&c));
        ASSERT_OK(K(consistency_nis)(&c, 2, &a, &b, &d));
        ASSERT_OK(K(consistency_innovation)(&c, m - 1, 2, &a, &b, &d, &e));
        assert_guards(room, (size_t)CONSISTENCY_LEN(m, window), COUNT(room));
    }
}

/* ------------------------------------------------------------ what is refused */

static void assign_refuses(void)
{
    static num memory[CONSISTENCY_LEN(2, WINDOW)];
    const size_t length = COUNT(memory);
    ASSERT_REFUSED(KQ_ERR_NULL, K(consistency_assign)(NULL, 2, WINDOW, memory, length));
    ASSERT_REFUSED(KQ_ERR_NULL, K(consistency_assign)(&recent, 2, WINDOW, NULL, length));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(consistency_assign)(&recent, 0, WINDOW, memory, length));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(consistency_assign)(&recent, 17, WINDOW, memory, length));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(consistency_assign)(&recent, 2, 0, memory, length));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(consistency_assign)(&recent, 2, SIZE_MAX, memory, length));
    ASSERT_REFUSED(KQ_ERR_SIZE,
                   K(consistency_assign)(&recent, 2, KQ_WINDOW_MAX + 1, memory, SIZE_MAX));
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(consistency_assign)(&recent, 2, WINDOW, memory, length - 1));
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(consistency_assign)(&recent, 2, WINDOW + 1, memory, length));
    ASSERT_REFUSED(KQ_ERR_NULL, K(consistency_clear)(NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(consistency_clear)(&blank));
}

static kq_status watch_all(void) { return K(consistency_watch)(&recent, &track, &radar, z, ALL); }

static void watch_refuses(void)
{
    ASSERT_REFUSED(KQ_ERR_NULL, K(consistency_watch)(NULL, &track, &radar, z, ALL));
    ASSERT_REFUSED(KQ_ERR_NULL, K(consistency_watch)(&recent, NULL, &radar, z, ALL));
    ASSERT_REFUSED(KQ_ERR_NULL, K(consistency_watch)(&recent, &track, NULL, z, ALL));
    ASSERT_REFUSED(KQ_ERR_NULL, K(consistency_watch)(&recent, &track, &radar, NULL, ALL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(consistency_watch)(&blank, &track, &radar, z, ALL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(consistency_watch)(&recent, &blank_filter, &radar, z, ALL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(consistency_watch)(&recent, &track, &blank_sensor, z, ALL));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(consistency_watch)(&recent, &track, &compass, z, ALL));
    assert_entries_must_be_finite(z, 2, watch_all);
    z[1] = (num)NAN;
    ASSERT_OK(K(consistency_watch)(&recent, &track, &radar, z, 1)); /* it is not read */
}

static void record_refuses(void)
{
    ASSERT_REFUSED(KQ_ERR_NULL, K(consistency_record)(NULL, &track));
    ASSERT_REFUSED(KQ_ERR_NULL, K(consistency_record)(&recent, NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(consistency_record)(&blank, &track));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(consistency_record)(&recent, &track));
    ASSERT_OK(watch_all());
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(consistency_record)(&recent, &blank_filter));
}

static void readings_refuse(void)
{
    num *a = &out[0], *b = &out[1], *c = &out[2], *d = &out[4];
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(consistency_nis)(&blank, 2, a, b, c));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(consistency_nis)(&recent, 2, a, b, c));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(consistency_innovation)(&blank, 0, 2, a, b, c, d));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(consistency_innovation)(&recent, 0, 2, a, b, c, d));
    run(3, 3, always);
    ASSERT_REFUSED(KQ_ERR_NULL, K(consistency_nis)(NULL, 2, a, b, c));
    ASSERT_REFUSED(KQ_ERR_NULL, K(consistency_nis)(&recent, 2, NULL, b, c));
    ASSERT_REFUSED(KQ_ERR_NULL, K(consistency_nis)(&recent, 2, a, NULL, c));
    ASSERT_REFUSED(KQ_ERR_NULL, K(consistency_nis)(&recent, 2, a, b, NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(consistency_nis)(&recent, (num)NAN, a, b, c));
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(consistency_nis)(&recent, (num)INFINITY, a, b, c));
    ASSERT_REFUSED(KQ_ERR_RANGE, K(consistency_nis)(&recent, -1, a, b, c));
    ASSERT_REFUSED(KQ_ERR_NULL, K(consistency_innovation)(NULL, 0, 2, a, b, c, d));
    ASSERT_REFUSED(KQ_ERR_NULL, K(consistency_innovation)(&recent, 0, 2, NULL, b, c, d));
    ASSERT_REFUSED(KQ_ERR_NULL, K(consistency_innovation)(&recent, 0, 2, a, NULL, c, d));
    ASSERT_REFUSED(KQ_ERR_NULL, K(consistency_innovation)(&recent, 0, 2, a, b, NULL, d));
    ASSERT_REFUSED(KQ_ERR_NULL, K(consistency_innovation)(&recent, 0, 2, a, b, c, NULL));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(consistency_innovation)(&recent, -1, 2, a, b, c, d));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(consistency_innovation)(&recent, 2, 2, a, b, c, d));
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(consistency_innovation)(&recent, 0, (num)NAN, a, b, c, d));
    ASSERT_REFUSED(KQ_ERR_RANGE, K(consistency_innovation)(&recent, 0, -1, a, b, c, d));
    TEST_ASSERT_EQUAL_INT(0, K(consistency_count)(NULL));
    TEST_ASSERT_EQUAL_INT(0, K(consistency_count)(&blank));
}

SUITE(consistency, set_up)
{
    RUN_TEST(the_window_is_that_of_the_last_updates);
    RUN_TEST(components_may_be_missing);
    RUN_TEST(nothing_drifts);
    RUN_TEST(an_update_that_takes_nothing_does_not_enter);
    RUN_TEST(a_settled_step_does_not_enter);
    RUN_TEST(what_is_watched_may_be_dropped);
    RUN_TEST(watching_leaves_the_filter);
    RUN_TEST(a_variance_of_0_counts_as_missing);
    RUN_TEST(innovations_of_0_have_no_correlation);
    RUN_TEST(clearing_forgets);
    RUN_TEST(the_bounds_are_those_of_chi_square);
    RUN_TEST(sizes_may_be_the_smallest_and_the_largest);
    RUN_TEST(assign_refuses);
    RUN_TEST(watch_refuses);
    RUN_TEST(record_refuses);
    RUN_TEST(readings_refuse);
}
