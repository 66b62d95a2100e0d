/* The filter: init, predict, and all that can be read from it.  The update has its own file. */
#include "reading.h"
#include "textbook.h"
#include "turned.h"
#include "unchanged.h"

PROCESS(motion, 2, 1);
SENSOR(radar, 2, 2);
FILTER(track, 2);
FILTER(blank, 2); /* never initialised */

/* a model of three states, to mismatch */
PROCESS(motion3, 3, 0);

static const num A[] = {1, 0.5, 0, 1}, B[] = {0.125, 0.5}, Q[] = {0.25, 0.125, 0.125, 0.5};
static const num H[] = {1, 0, 0.5, 1}, R[] = {0.5, 0.25, 0.25, 1};
static const num A3[] = {1, 0.5, 0.25, -0.5, 1, 0, 0.25, 2, 0.5};
static const num Q3[] = {1, 0.25, 0, 0.25, 1, 0.5, 0, 0.5, 1};

static num x0[2], P0[4], u[1], z[2], out[4], more[4];

static void set_up(void)
{
    static const num x[] = {1, -2}, P[] = {2, 0.5, 0.5, 1}, measured[] = {3, 1};
    memcpy(x0, x, sizeof x0);
    memcpy(P0, P, sizeof P0);
    memcpy(z, measured, sizeof z);
    u[0] = 4;
    for (int k = 0; k < 4; k++) out[k] = more[k] = 77;
    ASSERT_OK(K(process_init)(&motion, A, B, Q));
    ASSERT_OK(K(process_init)(&motion3, A3, NULL, Q3));
    ASSERT_OK(K(sensor_init)(&radar, H, R));
    ASSERT_OK(K(filter_assign)(&track, 2, track_memory, COUNT(track_memory)));
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    watch_nothing();
    WATCH(motion), WATCH(motion_memory), WATCH(radar), WATCH(radar_memory);
    WATCH(track), WATCH(track_memory), WATCH(blank), WATCH(blank_memory);
    WATCH(x0), WATCH(P0), WATCH(u), WATCH(z), WATCH(out), WATCH(more);
}

/* ------------------------------------------------------------------------------ assign */

TEST(assign_takes_more_memory_than_it_needs)
{
    K(filter) f;
    ASSERT_OK(K(filter_assign)(&f, 2, blank_memory, SIZE_MAX));
    ASSERT_OK(K(filter_init)(&f, x0, P0));
    ASSERT_SAME_FILTER(&track, &f, 2);
}

/* -------------------------------------------------------------------------------- init */

TEST(init_sets_the_state)
{
    for (int i = 0; i < 2; i++) {
        ASSERT_CLOSE(x0[i], K(mean)(&track, i), 0);
        ASSERT_CLOSE(0, K(mean_low)(&track, i), 0);
        ASSERT_CLOSE(sqrt((double)P0[3 * i]), K(sigma)(&track, i), 2);
    }
    ASSERT_OK(K(covariance)(&track, out));
    for (int k = 0; k < 4; k++) ASSERT_CLOSE(P0[k], out[k], 2);
    ASSERT_CLOSE(0, K(nis)(&track), 0);
    TEST_ASSERT_EQUAL_INT(0, K(taken)(&track));
    ASSERT_CLOSE(0, K(log_likelihood)(&track), 0);
    ASSERT_CLOSE(0, K(log_likelihood_last)(&track), 0);
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&track));
}

TEST(init_keeps_neither_array)
{
    static const num x[] = {1, -2}, P[] = {2, 0.5, 0.5, 1};
    textbook t;
    memset(x0, 0xFF, sizeof x0);
    memset(P0, 0xFF, sizeof P0);
    textbook_init(&t, 2, x, P);
    ASSERT_TEXTBOOK(&t, &track);
    textbook_predict(&t, A, NULL, NULL, 0, Q);
    ASSERT_OK(K(predict)(&track, &motion, NULL));
    ASSERT_TEXTBOOK(&t, &track);
}

static kq_status init(void) { return K(filter_init)(&track, x0, P0); }

TEST(init_refuses_numbers_that_are_not_finite)
{
    assert_entries_must_be_finite(x0, 2, init);
    assert_entries_must_be_finite(P0, 4, init);
}

TEST(init_checks_that_P0_is_a_covariance) { assert_covariance_is_checked(P0, init); }

TEST(init_takes_a_singular_P0)
{
    static const double singular[][3] = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {4, 2, 1}, {1, -1, 1}};
    for (int k = 0; k < COUNT(singular); k++) {
        textbook t;
        put_covariance(P0, singular[k][0], singular[k][1], singular[k][1], singular[k][2]);
        ASSERT_OK(init());
        textbook_init(&t, 2, x0, P0);
        ASSERT_TEXTBOOK(&t, &track);
        textbook_predict(&t, A, NULL, NULL, 0, Q);
        ASSERT_OK(K(predict)(&track, &motion, NULL));
        ASSERT_TEXTBOOK(&t, &track);
    }
}

/* Beyond the limit of predict there is no use for a variance: the root's squares leave the numbers. */
TEST(init_refuses_a_variance_beyond_the_limit)
{
    const double most = MOST_SIGMA * MOST_SIGMA;
    put_covariance(P0, most, 0, 0, 1);
    ASSERT_OK(init());
    put_covariance(P0, most, 0, 0, most * (1 + EPS));
    ASSERT_REFUSED(KQ_ERR_RANGE, init());
    put_covariance(P0, (double)NUM_MAX, 0, 0, 1);
    ASSERT_REFUSED(KQ_ERR_RANGE, init());
}

TEST(init_refuses_a_mean_beyond_the_limit)
{
    const num most[] = {N(MOST_SIGMA * MOST_SIGMA), 0}, beyond[] = {0, N(-NUM_MAX)};
    ASSERT_OK(K(filter_init)(&track, most, P0));
    ASSERT_REFUSED(KQ_ERR_RANGE, K(filter_init)(&track, beyond, P0));
}

TEST(a_root_is_the_prior_that_it_is_the_root_of)
{
    static const num root[] = {0.5, 0.25, 0.75};
    textbook t;
    put_covariance(P0, 0.3125, 0.1875, 0.1875, 0.5625);
    textbook_init(&t, 2, x0, P0);
    ASSERT_OK(K(filter_init_root)(&track, x0, root));
    ASSERT_TEXTBOOK(&t, &track);
}

TEST(init_root_refuses_what_is_no_root)
{
    static const num root[] = {0.5, 0.25, 0.75};
    const num negative[] = {N(-0.5), 0.25, 0.75}, infinite[] = {0.5, (num)INFINITY, 0.75};
    const num large[] = {0.5, 0, N(1.01 * MOST_SIGMA)};
    ASSERT_REFUSED(KQ_ERR_NULL, K(filter_init_root)(&track, x0, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, K(filter_init_root)(&track, NULL, root));
    ASSERT_REFUSED(KQ_ERR_NULL, K(filter_init_root)(NULL, x0, root));
    ASSERT_REFUSED(KQ_ERR_NOT_SEMIDEFINITE, K(filter_init_root)(&track, x0, negative));
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(filter_init_root)(&track, x0, infinite));
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(filter_init_root)(&track, infinite, root));
    ASSERT_REFUSED(KQ_ERR_RANGE, K(filter_init_root)(&track, x0, large));
}

/* The lower triangle is compared, within rounding, and not used. */
TEST(init_uses_the_upper_triangle)
{
    FILTER(twin, 2);
    ASSERT_OK(K(filter_init)(&twin, x0, P0));
    P0[2] = N(0.5 * (1 + EPS));
    ASSERT_OK(init());
    ASSERT_SAME_FILTER(&twin, &track, 2);
}

TEST(a_covariance_may_be_8_roundings_from_symmetric)
{
    P0[0] = P0[3] = 1;
    P0[2] = N(0.5 + 7.5 * EPS);
    ASSERT_OK(init());
    P0[2] = N(0.5 + 8.5 * EPS);
    ASSERT_REFUSED(KQ_ERR_NOT_SYMMETRIC, init());
}

TEST(init_begins_a_new_run)
{
    reading fresh, again;
    read_filter(&fresh, &track, 2);
    ASSERT_OK(K(update)(&track, &radar, z));
    z[0] = NUM_MAX, z[1] = -NUM_MAX;
    ASSERT_OK(K(update)(&track, &radar, z));
    TEST_ASSERT_BITS(KQ_EVENT_OVERFLOW, KQ_EVENT_OVERFLOW, K(events)(&track));
    ASSERT_OK(init());
    read_filter(&again, &track, 2);
    ASSERT_SAME_BITS(fresh, again);
}

TEST(a_refused_init_leaves_the_old_run_going)
{
    FILTER(undisturbed, 2);
    ASSERT_OK(K(filter_init)(&undisturbed, x0, P0));
    P0[1] = 9;
    ASSERT_REFUSED(KQ_ERR_NOT_SYMMETRIC, init());
    ASSERT_OK(K(predict)(&track, &motion, u));
    ASSERT_OK(K(predict)(&undisturbed, &motion, u));
    ASSERT_SAME_FILTER(&undisturbed, &track, 2);
}

/* ----------------------------------------------------------------------------- predict */

TEST(predict_takes_a_dense_transition)
{
    FILTER(three, 3);
    static const num x[] = {1, -2, 0.5}, P[] = {1, 0.5, 0, 0.5, 2, 0.25, 0, 0.25, 0.5};
    textbook t;
    textbook_init(&t, 3, x, P);
    ASSERT_OK(K(filter_init)(&three, x, P));
    for (int step = 0; step < 3; step++) {
        textbook_predict(&t, A3, NULL, NULL, 0, Q3);
        ASSERT_OK(K(predict)(&three, &motion3, NULL));
        ASSERT_TEXTBOOK(&t, &three);
    }
}

TEST(predict_does_not_read_a_control_that_the_process_has_not)
{
    PROCESS(idle, 2, 0);
    FILTER(twin, 2);
    ASSERT_OK(K(process_init)(&idle, A, NULL, Q));
    ASSERT_OK(K(filter_init)(&twin, x0, P0));
    u[0] = (num)NAN;
    ASSERT_OK(K(predict)(&track, &idle, u));
    ASSERT_OK(K(predict)(&twin, &idle, NULL));
    ASSERT_SAME_FILTER(&twin, &track, 2);
}

/* The mean is rounded at its increment, not at its own size. */
TEST(predict_keeps_increments_below_the_last_bit_of_the_mean)
{
    PROCESS(drift, 1, 1);
    FILTER(level, 1);
    static const num one[] = {1}, zero[] = {0}, rate[] = {0x1p-30};
    ASSERT_OK(K(process_init)(&drift, one, one, zero));
    ASSERT_OK(K(filter_init)(&level, one, zero));
    for (int k = 0; k < 100; k++) ASSERT_OK(K(predict)(&level, &drift, rate));
    ASSERT_WITHIN(100 * 0x1p-30 * EPS + DBL_EPSILON, 1 + 100 * 0x1p-30, whole_mean(&level, 0));
}

/* ------------------------------------------------------- mean, sigma, covariance, events */

TEST(covariance_is_exactly_symmetric)
{
    ASSERT_OK(K(predict)(&track, &motion, NULL));
    ASSERT_OK_UNCHANGED(K(covariance)(&track, (num[4]){0}));
    ASSERT_OK(K(covariance)(&track, out));
    TEST_ASSERT_EQUAL_MEMORY(&out[1], &out[2], sizeof(num));
}

/* ------------------------------------------------------------------------- measurement */

TEST(measurement_gives_each_part_alone)
{
    num both[2], S[4];
    ASSERT_OK_UNCHANGED(K(measurement)(&track, &radar, both, S));
    ASSERT_OK_UNCHANGED(K(measurement)(&track, &radar, NULL, NULL));
    ASSERT_OK(K(measurement)(&track, &radar, out, NULL));
    TEST_ASSERT_EQUAL_MEMORY(both, out, sizeof both);
    ASSERT_OK(K(measurement)(&track, &radar, NULL, out));
    TEST_ASSERT_EQUAL_MEMORY(S, out, sizeof S);
}

/* -------------------------------------------------------------------------- innovation */

/* x = 1 + 2^-24 in f32 as in f64: a quarter of the way from 1 to 1 + 2^-22 */
TEST(innovation_sees_the_whole_mean)
{
    SENSOR(gauge, 1, 1);
    FILTER(level, 1);
    static const num one[] = {1}, prior[] = {1}, variance[] = {3}, value[] = {1 + 0x1p-22};
    num e;
    ASSERT_OK(K(sensor_init)(&gauge, one, variance));
    ASSERT_OK(K(filter_init)(&level, one, prior));
    ASSERT_OK(K(update)(&level, &gauge, value));
    ASSERT_WITHIN(0x1p-24 * 8 * EPS + DBL_EPSILON, 1 + 0x1p-24, whole_mean(&level, 0));
    ASSERT_OK(K(innovation)(&level, &gauge, one, &e));
    ASSERT_WITHIN(0x1p-24 * 8 * EPS + DBL_EPSILON, -0x1p-24, e);
}

TEST(innovation_refuses_what_is_beyond_the_numbers)
{
    static const num far[] = {4, 0}, steep[] = {NUM_MAX, 0, 0, 1};
    ASSERT_OK(K(move)(&track, far));
    ASSERT_OK(K(sensor_init)(&radar, steep, R));
    WATCH(out), WATCH(track);
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(innovation)(&track, &radar, z, out));
    watch_nothing();
    track_memory[0] = (num)NAN;
    WATCH(out), WATCH(track);
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(innovation)(&track, &radar, z, out));
}

/* -------------------------------------------------------------------------------- gain */

/* Two noise-free sensors of the same thing: K e moves the state to what both say. */
TEST(gain_is_a_pseudo_inverse_for_redundant_noise_free_sensors)
{
    static const num h[] = {1, 0.5, 1, 0.5}, free_of_noise[] = {0, 0};
    ASSERT_OK(K(sensor_init_diagonal)(&radar, h, free_of_noise));
    ASSERT_OK_UNCHANGED(K(gain)(&track, &radar, (num[4]){0}));
    ASSERT_OK(K(gain)(&track, &radar, out));
    ASSERT_CLOSE((2 + 0.25) / 2.75, out[0] + out[1], 2);
    ASSERT_CLOSE((0.5 + 0.5) / 2.75, out[2] + out[3], 2);
}

/* --------------------------------------------------------------- the end of the numbers */

/* Whatever it was, what is read is a number, and there is an event. */
static void assert_held(void)
{
    ASSERT_OK(K(covariance)(&track, out));
    for (int k = 0; k < 4; k++) TEST_ASSERT_TRUE(isfinite(out[k]));
    for (int i = 0; i < 2; i++) {
        TEST_ASSERT_TRUE(isfinite(K(mean)(&track, i)));
        TEST_ASSERT_TRUE(isfinite(K(mean_low)(&track, i)));
        TEST_ASSERT_TRUE((double)K(sigma)(&track, i) <= MOST_SIGMA * (1 + 8 * EPS));
    }
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_OVERFLOW, K(events)(&track));
}

/* A state that doubles 3000 times beside one that does not, with and without a correlation */
TEST(predict_holds_a_state_that_grows_without_end)
{
    static const num doubling[] = {2, 0, 0, 1}, coupled[] = {2, 1, 0, 1}, exact[2] = {1, 4};
    static const num *const transition[] = {doubling, coupled};
    for (int k = 0; k < 2; k++) {
        ASSERT_OK(K(process_init)(&motion, transition[k], B, Q));
        put_covariance(P0, 1, 0.5, 0.5, 1);
        ASSERT_OK(K(filter_init)(&track, exact, P0));
        for (int step = 0; step < 3000; step++) ASSERT_OK(K(predict)(&track, &motion, NULL));
        assert_held();
        ASSERT_CLOSE(4, K(mean)(&track, 1), 4); /* the other is what it was */
        ASSERT_CLOSE(1501, out[3], 1501 * 30.0);
        for (int step = 0; step < 20; step++) ASSERT_OK(K(update)(&track, &radar, z));
        ASSERT_OK(K(covariance)(&track, out));
        TEST_ASSERT_TRUE(out[0] < 1 && out[3] < 1);
        ASSERT_OK(K(filter_init)(&track, exact, P0));
    }
}

/* A transition may leave the numbers at once, in the mean and in the root. */
TEST(predict_holds_a_state_that_leaves_the_numbers_at_once)
{
    static const num entries[] = {NUM_MAX, -NUM_MAX, NUM_MAX / 4};
    for (int k = 0; k < 81; k++) {
        static num wild[4];
        for (int e = 0, code = k; e < 4; e++, code /= 3) wild[e] = entries[code % 3];
        ASSERT_OK(K(process_init)(&motion, wild, B, Q));
        ASSERT_OK(init());
        ASSERT_OK(K(predict)(&track, &motion, NULL));
        assert_held();
        ASSERT_OK(K(process_init)(&motion, A, B, Q));
        ASSERT_OK(K(predict)(&track, &motion, NULL));
        ASSERT_OK(K(update)(&track, &radar, z));
        assert_held();
    }
}

/* A control drives a mean out of the numbers: that call says so, the state that is not driven keeps its mean
   though 0 times it stands in every row, and measurements bring the other back. */
TEST(a_mean_that_leaves_the_numbers_is_brought_back)
{
    static const num strong[] = {0, NUM_MAX}, still[] = {1, 0, 0, 1}, pushed[] = {2}, exact[] = {3, 4};
    ASSERT_OK(K(process_init)(&motion, still, strong, Q));
    ASSERT_OK(K(filter_init)(&track, exact, P0));
    ASSERT_OK(K(predict)(&track, &motion, pushed));
    assert_held();
    ASSERT_CLOSE(3, K(mean)(&track, 0), 4);
    TEST_ASSERT_TRUE(K(mean)(&track, 1) == 0);
    TEST_ASSERT_TRUE(out[1] == 0 && out[2] == 0 && (double)K(sigma)(&track, 1) >= MOST_SIGMA * 0x1p-16);
    TEST_ASSERT_TRUE(K(sigma)(&track, 0) < 4);
    ASSERT_OK(K(process_init)(&motion, A, B, Q));
    for (int step = 0; step < 4; step++) {
        ASSERT_OK(K(predict)(&track, &motion, NULL));
        ASSERT_OK(K(update)(&track, &radar, z));
    }
    TEST_ASSERT_EQUAL_INT(2, K(taken)(&track));
    for (int i = 0; i < 2; i++) TEST_ASSERT_TRUE(K(sigma)(&track, i) < 4);
    ASSERT_WITHIN(4, 3, K(mean)(&track, 0));
}

/* An outage of two states that grow, one through the other, until both are held, and then measurements of one of them by
   rows so large that h'P h overflows, too: both are brought back, by a lean sensor in some steps more. */
TEST(states_that_were_held_are_brought_back_by_any_row)
{
    static const num growing[] = {N(1.25), N(0.125), 0, N(1.25)}, r[] = {1};
    static const double rows[] = {1, 100, 1e6, 1e8};
    SENSOR(sight, 2, 1);
    SENSOR(rough, 2, 1);
    static const num unit[] = {1, 0, 0, 1}, zero[] = {0, 0};
    ASSERT_OK(K(process_init)(&motion, growing, B, unit));
    for (int k = 0; k < 2 * COUNT(rows); k++) {
        const num h[] = {N(rows[k / 2]), 0}, seen[] = {N(5 * rows[k / 2])};
        describe("", "row", k / 2, "lean", k % 2);
        ASSERT_OK(K(sensor_init)(&sight, h, r));
        ASSERT_OK(K(sensor_init_lean)(&rough, h, r));
        ASSERT_OK(K(filter_init)(&track, zero, unit));
        for (int step = 0; step < (sizeof(num) < 8 ? 1000 : 6000); step++) ASSERT_OK(K(predict)(&track, &motion, NULL));
        assert_held();
        for (int step = 0; step < (k % 2 ? 60 : 6); step++) {
            ASSERT_OK(K(update)(&track, k % 2 ? &rough : &sight, seen));
            TEST_ASSERT_EQUAL_INT_MESSAGE(1, K(taken)(&track), description());
            ASSERT_OK(K(predict)(&track, &motion, NULL));
        }
        for (int i = 0; i < 2; i++) TEST_ASSERT_TRUE_MESSAGE(K(sigma)(&track, i) < 64, description());
        ASSERT_WITHIN(4, 5, K(mean)(&track, 0));
        ASSERT_OK(K(filter_check)(&track));
    }
}

/* A diverges, P does not grow with it: the mean is lost at the step that takes it beyond its limit. */
TEST(a_mean_that_diverges_alone_is_lost_with_an_event)
{
    static const num growing[] = {N(1.5), 0, 0, 1}, start[] = {1, 4}, none[4] = {0};
    ASSERT_OK(K(process_init)(&motion, growing, B, none));
    put_covariance(P0, 0, 0, 0, 1);
    ASSERT_OK(K(filter_init)(&track, start, P0));
    for (int step = 0; step < 10000 && !K(events)(&track); step++) {
        ASSERT_OK(K(predict)(&track, &motion, NULL));
        TEST_ASSERT_TRUE(isfinite(K(mean)(&track, 0)));
    }
    assert_held();
    ASSERT_CLOSE(4, K(mean)(&track, 1), 4);
    ASSERT_CLOSE(1, out[3], 4);
}

/* State 0 grows through state 1 alone: nothing of it is on the diagonal of the root. */
TEST(the_norm_of_a_row_is_held)
{
    static const num through[] = {2, 1, 0, 1}, start[] = {0, 0}, none[4] = {0};
    ASSERT_OK(K(process_init)(&motion, through, B, none));
    put_covariance(P0, 0, 0, 0, 1);
    ASSERT_OK(K(filter_init)(&track, start, P0));
    int events = 0;
    for (int step = 0; step < 3000; step++) {
        const double grown = 2 * (double)K(sigma)(&track, 0) + 1;
        ASSERT_OK(K(predict)(&track, &motion, NULL));
        if (!events) TEST_ASSERT_EQUAL_HEX(grown > MOST_SIGMA ? KQ_EVENT_OVERFLOW : 0, K(events)(&track));
        events = (int)K(events)(&track);
        TEST_ASSERT_TRUE((double)K(sigma)(&track, 0) <= MOST_SIGMA * (1 + 8 * EPS));
    }
    assert_held();
    ASSERT_CLOSE(1, out[3], 4);
    for (int step = 0; step < 3; step++) ASSERT_OK(K(update)(&track, &radar, z));
    TEST_ASSERT_EQUAL_INT(2, K(taken)(&track));
    TEST_ASSERT_TRUE(K(sigma)(&track, 0) < 4);
}

/* State 1 is lost: a measurement of it says nothing of state 0, which keeps its sigma, and its correlation
   with state 2. */
TEST(a_lost_state_has_no_correlations)
{
    PROCESS(growing, 3, 0);
    FILTER(wide, 3);
    SENSOR(sight, 3, 1);
    static const num transition[] = {1, 0, 0, 0, N(1.5), 0, 0, 0, 1}, none[9] = {0}, start[] = {0, N(64 * MOST_SIGMA), 0};
    static const num prior[] = {1, N(0.9), N(0.5), N(0.9), 1, N(0.25), N(0.5), N(0.25), 1};
    static const num H1[] = {0, 1, 0}, variance[] = {1}, seen[] = {5};
    num P[9];
    ASSERT_OK(K(process_init)(&growing, transition, NULL, none));
    ASSERT_OK(K(sensor_init)(&sight, H1, variance));
    ASSERT_OK(K(filter_init)(&wide, start, prior));
    for (int step = 0; step < 10000 && !K(events)(&wide); step++) ASSERT_OK(K(predict)(&wide, &growing, NULL));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_OVERFLOW, K(events)(&wide));
    for (int turn = 0; turn < 2; turn++) {
        ASSERT_OK(K(covariance)(&wide, P));
        ASSERT_CLOSE(1, P[0], 16);
        ASSERT_CLOSE(1, P[8], 16);
        ASSERT_CLOSE(0.5, P[2], 16);
        TEST_ASSERT_TRUE(P[1] == 0 && P[5] == 0 && K(mean)(&wide, 0) == 0 && K(mean)(&wide, 2) == 0);
        ASSERT_OK(K(update)(&wide, &sight, seen));
    }
    ASSERT_CLOSE(5, K(mean)(&wide, 1), 16);
}

/* The transition of a state that decays is not rounded: 200 steps of it leave no more than their own
   rounding. */
TEST(a_decay_is_not_biased)
{
    static const double decay[] = {0.273, -1.53, 0.1, -0.7, 1e-9};
    PROCESS(one_motion, 1, 1);
    FILTER(one, 1);
    const num zero = 0, start = N(1e6), push[] = {1}, drive = N(1e6);
    for (int k = 0; k < COUNT(decay); k++) {
        const num a = N(decay[k]);
        double exact = (double)start, size = 0;
        ASSERT_OK(K(process_init)(&one_motion, &a, &drive, &zero));
        ASSERT_OK(K(filter_init)(&one, &start, &zero));
        for (int step = 0; step < 40; step++) {
            ASSERT_OK(K(predict)(&one, &one_motion, push));
            exact = (double)a * exact + (double)drive;
            size = size * fabs((double)a) + fabs(exact);
        }
        ASSERT_WITHIN(0.6 * EPS * size, exact, whole_mean(&one, 0));
    }
}

/* State 0 has grown through state 1, which stays known to 1 +- 1: held, it says nothing of it any more. */
TEST(a_held_state_says_nothing_of_the_others)
{
    static const num through[] = {2, 1, 0, 1}, start[] = {0, 0}, none[4] = {0}, first[] = {1, 0}, one[] = {1};
    SENSOR(gauge, 2, 1);
    ASSERT_OK(K(process_init)(&motion, through, B, none));
    ASSERT_OK(K(sensor_init)(&gauge, first, one));
    put_covariance(P0, 0, 0, 0, 1);
    ASSERT_OK(K(filter_init)(&track, start, P0));
    int held = 0;
    for (int step = 0; step < 3000 && held < 5; step++) {
        ASSERT_OK(K(predict)(&track, &motion, NULL));
        held += K(events)(&track) != 0;
        K(events_clear)(&track);
    }
    const num far[] = {N(MOST_SIGMA * 0.5)};
    ASSERT_OK(K(update)(&track, &gauge, far));
    ASSERT_CLOSE(1, K(sigma)(&track, 1), 4);
    ASSERT_WITHIN(1e-3, 0, K(mean)(&track, 1));
    ASSERT_WITHIN(1e-3 * MOST_SIGMA, far[0], K(mean)(&track, 0));
}

/* What was held is not what was recorded. */
TEST(a_history_ends_where_predict_holds)
{
    static const num wild[] = {NUM_MAX, 0, 0, 1};
    HISTORY(tape, 2, 2, 4, 0);
    ASSERT_OK(K(process_init)(&motion, wild, B, Q));
    ASSERT_OK(K(attach)(&track, &tape.attached));
    ASSERT_OK(K(predict)(&track, &motion, NULL));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_OVERFLOW | KQ_EVENT_HISTORY_FULL, K(events)(&track));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_HISTORY_FULL, K(smooth)(&tape));
}

/* ------------------------------------------------------------------- check */

static kq_status check_track(void) { return K(filter_check)(&track); }

TEST(check_takes_what_steps_leave)
{
    for (int t = 0; t < 200; t++) {
        const num far[] = {t % 50 ? 3 : N(1e6), 1};
        ASSERT_OK(K(predict)(&track, &motion, u));
        ASSERT_OK(K(filter_check)(&track));
        ASSERT_OK(K(update_subset)(&track, &radar, far, (uint32_t)(t % 4)));
        ASSERT_OK_UNCHANGED(K(filter_check)(&track));
    }
}

/* All but `weak`, `losses`, and the events and likelihoods that may be */
TEST(check_finds_what_contradicts_itself)
{
    ASSERT_OK(K(predict)(&track, &motion, u));
    ASSERT_OK(K(update)(&track, &radar, z));
    ASSERT_ALL_FOUND(track.states, check_track);
    ASSERT_ALL_FOUND(track.ready, check_track);
    ASSERT_ALL_FOUND(track.known, check_track);
    ASSERT_ALL_FOUND(track.memory, check_track);
    ASSERT_ALL_FOUND(track.attached, check_track);
    ASSERT_ALL_FOUND(track.seal, check_track);
    TEST_ASSERT_EQUAL_INT(7, BITS_FOUND(track.plain, check_track)); /* 0 is slower, and right */
    TEST_ASSERT_EQUAL_INT(6, BITS_FOUND(track.events, check_track));
    TEST_ASSERT_GREATER_THAN_INT(1, BITS_FOUND(track_memory, check_track)); /* high bits of exponents */
}

/* An address that is not the filter's is not followed; a mean that is no number is no turned bit. */
TEST(check_follows_no_other_address)
{
    K(filter) copy = track;
    copy.memory = NULL;
    TEST_ASSERT_EQUAL_INT(KQ_ERR_TABLE, K(filter_check)(&copy));
    copy = track;
    copy.states = 200;
    TEST_ASSERT_EQUAL_INT(KQ_ERR_TABLE, K(filter_check)(&copy));
    track_memory[0] = N(NAN);
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NOT_FINITE, K(filter_check)(&track));
}

SUITE(filter, set_up)
#include "filter.tests"
