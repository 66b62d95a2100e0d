/* A sensor without the careful path: what it takes as any other, and what it refuses. */
#include "reading.h"
#include "unchanged.h"

#define STEPS 12

PROCESS(motion, 2, 0);
SENSOR_DIAGONAL(full, 2, 3);
SENSOR_DIAGONAL(lean, 2, 3);
SENSOR_DIAGONAL(sharp, 2, 1);
SENSOR_DIAGONAL(blank, 2, 1);
FILTER(track, 2);
FILTER(twin, 2);
HISTORY(tape, 2, 6, STEPS + 1, 0);
HISTORY(other, 2, 6, STEPS + 1, 0);

static const num A[] = {1, 0.5, 0, 1}, Q[] = {0.25, 0.125, 0.125, 0.5};
static const num H[] = {1, 0, 0.5, 1, -1, 0.25};
static const num x0[] = {1, -2}, P0[] = {2, 0.5, 0.5, 1};
static num r[3], z[3];

/* Of a component: the noise that is sharp to both, whatever H and P0 are here */
#define SHARP (EPS * EPS)

static void set_up(void)
{
    static const num noises[] = {0.5, 1, 2}, measured[] = {3, 1, -1};
    memcpy(r, noises, sizeof r);
    memcpy(z, measured, sizeof z);
    ASSERT_OK(K(process_init)(&motion, A, NULL, Q));
    ASSERT_OK(K(sensor_init_diagonal)(&full, H, r));
    ASSERT_OK(K(sensor_init_lean)(&lean, H, r));
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    ASSERT_OK(K(filter_init)(&twin, x0, P0));
    ASSERT_OK(K(history_assign)(&tape, 2, tape_memory, COUNT(tape_memory)));
    ASSERT_OK(K(history_assign)(&other, 2, other_memory, COUNT(other_memory)));
    watch_nothing();
    WATCH(lean), WATCH(lean_memory), WATCH(track), WATCH(track_memory), WATCH(z);
}

/* Component c without noise, or as good as without */
static void sharpen(int c, num noise_now)
{
    r[c] = noise_now;
    ASSERT_OK(K(sensor_init_diagonal)(&full, H, r));
    ASSERT_OK(K(sensor_init_lean)(&lean, H, r));
}

static void what_is_not_sharp_is_taken_as_ever(void)
{
    for (uint32_t seed = 1; seed <= 20; seed++) {
        uint32_t state = seed;
        set_up();
        ASSERT_OK(K(history_attach)(&tape, &track));
        ASSERT_OK(K(history_attach)(&other, &twin));
        for (int t = 0; t < STEPS; t++) {
            for (int c = 0; c < 3; c++) z[c] = noise(&state);
            const uint32_t present = 1 + seed % 7;
            ASSERT_OK(K(step)(&track, &motion, NULL, &full, z));
            ASSERT_OK(K(step)(&twin, &motion, NULL, &lean, z));
            ASSERT_SAME_STATE(&track, &twin, 2);
            TEST_ASSERT_TRUE(K(nis)(&track) == K(nis)(&twin));
            TEST_ASSERT_EQUAL_INT(3, K(taken)(&twin));
            TEST_ASSERT_TRUE(K(log_likelihood_last)(&track) == K(log_likelihood_last)(&twin));
            ASSERT_OK(K(update_subset)(&track, &full, z, present));
            ASSERT_OK(K(update_subset)(&twin, &lean, z, present));
            ASSERT_SAME_STATE(&track, &twin, 2);
        }
        TEST_ASSERT_EQUAL_UINT(0, K(events)(&twin));
        TEST_ASSERT_TRUE(K(log_likelihood)(&twin) == 0);
        ASSERT_OK(K(smooth)(&tape));
        ASSERT_OK(K(smooth)(&other));
        for (size_t t = 0; t < K(history_steps)(&tape); t++) {
            TEST_ASSERT_TRUE(K(smoothed_mean)(&tape, t, 1) == K(smoothed_mean)(&other, t, 1));
        }
    }
}

/* The one that is sharp is left out, as if it were missing; the others are taken. */
static void what_is_sharp_is_refused(void)
{
    static const num noises[] = {0, SHARP};
    for (int c = 0; c < 3; c++) {
        for (int k = 0; k < COUNT(noises); k++) {
            set_up();
            sharpen(c, noises[k]);
            TEST_ASSERT_EQUAL_INT(KQ_SHARP, K(update)(&twin, &lean, z));
            ASSERT_OK(K(update_subset)(&track, &full, z, 7 & ~(UINT32_C(1) << c)));
            ASSERT_SAME_STATE(&track, &twin, 2);
            TEST_ASSERT_EQUAL_INT(2, K(taken)(&twin));
            TEST_ASSERT_EQUAL_UINT(KQ_EVENT_SHARP, K(events)(&twin));
            K(events_clear)(&twin);
            TEST_ASSERT_EQUAL_UINT(0, K(events)(&twin));
        }
    }
}

/* 2^-16 of S in f32, 2^-48 in f64: taken above it, not below */
static void where_sharp_begins(void)
{
    const num share = EPS > 1e-10 ? N(0x1p-16) : N(0x1p-48);
    const num s = 2; /* h'P h of the first component */
    sharpen(0, s * share * N(1.01));
    ASSERT_OK(K(update_subset)(&track, &lean, z, 1));
    ASSERT_OK(K(update_subset)(&twin, &full, z, 1));
    ASSERT_SAME_STATE(&track, &twin, 2);
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    sharpen(0, s * share * N(0.99));
    TEST_ASSERT_EQUAL_INT(KQ_SHARP, K(update_subset)(&track, &lean, z, 1));
}

static void a_step_is_predicted_all_the_same(void)
{
    sharpen(0, 0);
    TEST_ASSERT_EQUAL_INT(KQ_SHARP, K(step)(&twin, &motion, NULL, &lean, z));
    ASSERT_OK(K(predict)(&track, &motion, NULL));
    ASSERT_OK(K(update_subset)(&track, &full, z, 6));
    ASSERT_SAME_STATE(&track, &twin, 2);
}

/* After a sharp one at the same instant rounding may be all that is left. */
static void after_a_sharp_one(void)
{
    static const num h[] = {1, 0}, none[] = {0}, one[] = {1};
    ASSERT_OK(K(sensor_init_diagonal)(&sharp, h, none));
    ASSERT_OK(K(update)(&track, &sharp, one));
    TEST_ASSERT_EQUAL_INT(KQ_SHARP, K(update)(&track, &lean, z));
    TEST_ASSERT_EQUAL_INT(0, K(taken)(&track));
    ASSERT_OK(K(predict)(&track, &motion, NULL));
    ASSERT_OK(K(update)(&track, &lean, z));
    TEST_ASSERT_EQUAL_INT(3, K(taken)(&track));
}

static void beyond_the_numbers(void)
{
    z[1] = NUM_MAX;
    TEST_ASSERT_EQUAL_INT(KQ_SHARP, K(update)(&twin, &lean, z));
    z[1] = 0;
    ASSERT_OK(K(update_subset)(&track, &full, z, 5));
    ASSERT_SAME_STATE(&track, &twin, 2);
}

static void a_refused_one_is_recorded_as_nothing(void)
{
    ASSERT_OK(K(history_attach)(&tape, &track));
    ASSERT_OK(K(history_attach)(&other, &twin));
    for (int t = 0; t < STEPS; t++) {
        sharpen(1, t % 3 == 1 ? SHARP : 1);
        const int is_sharp = t % 3 == 1;
        ASSERT_OK(K(predict)(&track, &motion, NULL));
        ASSERT_OK(K(predict)(&twin, &motion, NULL));
        ASSERT_OK(K(update_subset)(&track, &full, z, is_sharp ? 5 : 7));
        TEST_ASSERT_EQUAL_INT(is_sharp ? KQ_SHARP : KQ_OK, K(update)(&twin, &lean, z));
    }
    ASSERT_OK(K(smooth)(&tape));
    ASSERT_OK(K(smooth)(&other));
    for (size_t t = 0; t < K(history_steps)(&tape); t++) {
        reading a, b;
        read_smoothed(&a, &tape, t, 2);
        read_smoothed(&b, &other, t, 2);
        TEST_ASSERT_EQUAL_MEMORY(&a, &b, sizeof a);
    }
}

/* The robust updates bring the careful path along. */
static void robust_updates_take_it(void)
{
    K(gate) g = {1000, 0, 0};
    sharpen(0, 0);
    ASSERT_OK(K(update_gated)(&twin, &g, &lean, z, 7));
    ASSERT_OK(K(update)(&track, &full, z));
    ASSERT_SAME_FILTER(&track, &twin, 2);
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    ASSERT_OK(K(filter_init)(&twin, x0, P0));
    ASSERT_OK(K(update_huber)(&track, &full, z, 7, 2, NULL));
    ASSERT_OK(K(update_huber)(&twin, &lean, z, 7, 2, NULL));
    ASSERT_SAME_FILTER(&track, &twin, 2);
}

/* Far more bits from the prediction than a number has */
static void what_is_far_off_is_found_again(void)
{
    static const num one_state[] = {1, 0}, noise_now[] = {0.0625};
    static const num correlated_P0[] = {1, 0.5, 0.5, 1};
    for (int power = 20; power < 100; power += 8) {
        num wide_P0[4], start[2];
        for (int k = 0; k < 4; k++) wide_P0[k] = correlated_P0[k] * N(ldexp(1, power));
        for (int k = 0; k < 2; k++) start[k] = N(ldexp(1.2345678, power / 2));
        const num near_by[] = {7};
        ASSERT_OK(K(sensor_init_diagonal)(&sharp, one_state, noise_now));
        ASSERT_OK(K(filter_init)(&track, start, wide_P0));
        ASSERT_OK(K(update)(&track, &sharp, near_by));
        ASSERT_WITHIN(0.01, 7, K(mean)(&track, 0));
        TEST_ASSERT_EQUAL_UINT(0, K(events)(&track));
        /* 2^13 sigma off */
        for (int k = 0; k < 2; k++) start[k] *= 8192;
        ASSERT_OK(K(filter_init)(&track, start, wide_P0));
        const double rest = (double)start[0] * 0.0625 / ((double)wide_P0[0] + 0.0625);
        ASSERT_OK(K(update)(&track, &sharp, near_by));
        ASSERT_WITHIN(0.01, 7 + rest, K(mean)(&track, 0));
    }
}

static void what_contradicts_is_told(void)
{
    static const num one_state[] = {1, 0}, noise_now[] = {SHARP};
    const num away[] = {EPS > 1e-10 ? N(1e5) : N(1e9)};
    ASSERT_OK(K(sensor_init_diagonal)(&sharp, one_state, noise_now));
    ASSERT_OK(K(update)(&track, &sharp, away));
    TEST_ASSERT_EQUAL_UINT(KQ_EVENT_CONTRADICTION, K(events)(&track));
}

ADAPTATION(taught, 2, 3);
ADAPTATION(taught_lean, 2, 3);

/* What is learnt from is taken: by a lean sensor, too. */
static void an_adaptation_takes_it(void)
{
    static const K(adaptation_rule) rule = {KQ_ADAPT_BOTH, 50, 0.125, 0.0625, 16, 0.125, 8};
    uint32_t seed = 1;
    sharpen(1, SHARP);
    ASSERT_OK(K(adaptation_init)(&taught, &motion, &full, &rule));
    ASSERT_OK(K(adaptation_attach)(&taught, &track));
    ASSERT_OK(K(adaptation_init)(&taught_lean, &motion, &lean, &rule));
    ASSERT_OK(K(adaptation_attach)(&taught_lean, &twin));
    for (int t = 0; t < STEPS; t++) {
        for (int c = 0; c < 3; c++) z[c] = noise(&seed);
        ASSERT_OK(K(predict)(&track, &motion, NULL));
        ASSERT_OK(K(predict)(&twin, &motion, NULL));
        ASSERT_OK(K(update_subset)(&track, &full, z, 7));
        ASSERT_OK(K(update_subset)(&twin, &lean, z, 7));
        ASSERT_SAME_FILTER(&track, &twin, 2);
    }
}

/* The same as constants: the root of Q by columns; A and H are taken for dense */
static const num table_A[] = {1, 0.5, 0, 1}, table_G[] = {0.5, 0.25, 0.5};
static const num table_Q[] = {0.3125, 0.125, 0.125, 0.25}, table_r[] = {0.5, 1, 2};
static const K(process) table = KQ_PROCESS_TABLE(2, 0, table_A, NULL, table_G);
static const K(sensor) lean_table = SENSOR_LEAN_TABLE(2, 3, H, table_r);

static void a_const_table_is_a_lean_sensor(void)
{
    uint32_t seed = 1;
    ASSERT_OK(K(process_init)(&motion, table_A, NULL, table_Q));
    for (int t = 0; t < STEPS; t++) {
        reading expected, now;
        for (int c = 0; c < 3; c++) z[c] = noise(&seed);
        ASSERT_OK(K(step)(&track, &motion, NULL, &full, z));
        ASSERT_OK(K(step)(&twin, &table, NULL, &lean_table, z));
        read_filter(&expected, &track, 2);
        read_filter(&now, &twin, 2);
        for (int i = 0; i < 2; i++) {
            ASSERT_CLOSE(expected.mean[i], now.mean[i], 4);
            ASSERT_CLOSE(expected.sigma[i], now.sigma[i], 2);
        }
    }
    TEST_ASSERT_EQUAL_UINT(0, K(events)(&twin));
}

static void bad_inputs(void)
{
    const num negative[] = {1, -1, 1}, nan[] = {1, (num)NAN, 1};
    ASSERT_REFUSED(KQ_ERR_NULL, K(sensor_init_lean)(NULL, H, r));
    ASSERT_REFUSED(KQ_ERR_NULL, K(sensor_init_lean)(&lean, NULL, r));
    ASSERT_REFUSED(KQ_ERR_NULL, K(sensor_init_lean)(&lean, H, NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_SEMIDEFINITE, K(sensor_init_lean)(&lean, H, negative));
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(sensor_init_lean)(&lean, H, nan));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(update)(&track, &blank, z));
    z[2] = (num)NAN;
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(update)(&track, &lean, z));
    ASSERT_REFUSED(KQ_ERR_NULL, K(update)(&track, &lean, NULL));
}

SUITE(lean, set_up)
{
    RUN_TEST(what_is_not_sharp_is_taken_as_ever);
    RUN_TEST(what_is_sharp_is_refused);
    RUN_TEST(where_sharp_begins);
    RUN_TEST(a_step_is_predicted_all_the_same);
    RUN_TEST(after_a_sharp_one);
    RUN_TEST(beyond_the_numbers);
    RUN_TEST(a_refused_one_is_recorded_as_nothing);
    RUN_TEST(robust_updates_take_it);
    RUN_TEST(a_const_table_is_a_lean_sensor);
    RUN_TEST(what_is_far_off_is_found_again);
    RUN_TEST(what_contradicts_is_told);
    RUN_TEST(an_adaptation_takes_it);
    RUN_TEST(bad_inputs);
}
