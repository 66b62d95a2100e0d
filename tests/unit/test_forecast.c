/* The state some steps ahead, on a filter of its own. */
#include "reading.h"
#include "textbook.h"
#include "unchanged.h"

PROCESS(motion, 2, 1);
SENSOR(radar, 2, 1);
FILTER(track, 2);
FILTER(ahead, 2);
FILTER(walker, 2); /* moved step by step, to compare with */
HISTORY(tape, 2, 1, 4, 0);

/* never initialised, and of another size */

static const num A[] = {1, 0.5, -0.25, 1}, B[] = {0.125, 0.5}, Q[] = {0.25, 0.125, 0.125, 0.5};
static const num H[] = {1, 0.5}, R[] = {0.5};
static const num x0[] = {1, -2}, P0[] = {2, 0.5, 0.5, 1}, z[] = {3};

static num u[5];

static void set_up(void)
{
    for (int k = 0; k < 5; k++) u[k] = N(0.5 * k - 1);
    ASSERT_OK(K(process_init)(&motion, A, B, Q));
    ASSERT_OK(K(sensor_init)(&radar, H, R));
    ASSERT_OK(K(filter_assign)(&ahead, 2, ahead_memory, COUNT(ahead_memory)));
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    ASSERT_OK(K(update)(&track, &radar, z));
    ASSERT_OK(K(detach)(&tape.attached));
    ASSERT_OK(K(filter_init)(&walker, x0, P0));
    ASSERT_OK(K(update)(&walker, &radar, z));
    watch_nothing();
    WATCH(track), WATCH(track_memory), WATCH(motion), WATCH(motion_memory);
    WATCH(ahead), WATCH(ahead_memory);
    WATCH(u);
}

/* Only the filter that looks ahead may have changed. */
static void watch_the_source(void)
{
    watch_nothing();
    WATCH(track), WATCH(track_memory), WATCH(motion), WATCH(motion_memory), WATCH(u);
}

TEST(a_forecast_is_so_many_predicts)
{
    watch_the_source();
    for (int steps = 0; steps <= 5; steps++) {
        ASSERT_OK_UNCHANGED(K(forecast)(&track, &motion, NULL, (size_t)steps, &ahead));
        ASSERT_SAME_STATE(&walker, &ahead, 2);
        ASSERT_OK(K(predict)(&walker, &motion, NULL));
    }
}

TEST(a_forecast_takes_the_controls_in_turn)
{
    watch_the_source();
    for (int steps = 0; steps <= 5; steps++) {
        ASSERT_OK_UNCHANGED(K(forecast)(&track, &motion, u, (size_t)steps, &ahead));
        ASSERT_SAME_STATE(&walker, &ahead, 2);
        if (steps < 5) ASSERT_OK(K(predict)(&walker, &motion, u + steps));
    }
}

TEST(a_forecast_is_that_of_the_textbook)
{
    textbook t;
    textbook_init(&t, 2, x0, P0);
    textbook_update(&t, H, R, z, 1);
    for (int k = 0; k < 5; k++) textbook_predict(&t, A, B, u + k, 1, Q);
    ASSERT_OK(K(forecast)(&track, &motion, u, 5, &ahead));
    ASSERT_TEXTBOOK(&t, &ahead);
}

/* The measurement to come: H x and H P H' + R. */
TEST(a_forecast_tells_the_measurement_to_come)
{
    textbook t;
    num forecast[2];
    textbook_init(&t, 2, x0, P0);
    textbook_update(&t, H, R, z, 1);
    for (int k = 0; k < 3; k++) textbook_predict(&t, A, NULL, NULL, 0, Q);
    ASSERT_OK(K(forecast)(&track, &motion, NULL, 3, &ahead));
    ASSERT_OK(K(measurement)(&ahead, &radar, &forecast[0], &forecast[1]));
    ASSERT_CLOSE(t.x[0] + 0.5 * t.x[1], forecast[0], 8);
    textbook_update(&t, H, R, z, 1);
    ASSERT_CLOSE(t.S[0], forecast[1], 8);
}

TEST(what_looks_ahead_is_a_filter_like_any_other)
{
    ASSERT_OK(K(forecast)(&track, &motion, NULL, 2, &ahead));
    for (int k = 0; k < 2; k++) ASSERT_OK(K(predict)(&walker, &motion, NULL));
    ASSERT_OK(K(update)(&ahead, &radar, z));
    ASSERT_OK(K(update)(&walker, &radar, z));
    ASSERT_OK(K(step)(&ahead, &motion, u, &radar, z));
    ASSERT_OK(K(step)(&walker, &motion, u, &radar, z));
    ASSERT_SAME_STATE(&walker, &ahead, 2);
}

TEST(a_forecast_may_be_made_again_and_again)
{
    ASSERT_OK(K(forecast)(&track, &motion, u, 5, &ahead));
    ASSERT_OK(K(forecast)(&track, &motion, NULL, 1, &ahead));
    ASSERT_OK(K(predict)(&walker, &motion, NULL));
    ASSERT_SAME_STATE(&walker, &ahead, 2);
}

TEST(a_forecast_is_not_recorded)
{
    ASSERT_OK(K(attach)(&track, &tape.attached));
    ASSERT_OK(K(predict)(&track, &motion, NULL));
    watch_the_source();
    WATCH(tape), WATCH(tape_memory);
    ASSERT_OK_UNCHANGED(K(forecast)(&track, &motion, NULL, 9, &ahead));
    ASSERT_OK_UNCHANGED(K(predict)(&ahead, &motion, NULL));
    ASSERT_OK_UNCHANGED(K(update)(&ahead, &radar, z));
    TEST_ASSERT_EQUAL_UINT(2, K(history_steps)(&tape));
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&track));
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&ahead));
}

/* The filter that looks ahead has no history, also if it had one. */
TEST(a_history_of_the_filter_ahead_is_detached)
{
    ASSERT_OK(K(filter_init)(&ahead, x0, P0));
    ASSERT_OK(K(attach)(&ahead, &tape.attached));
    ASSERT_OK(K(forecast)(&track, &motion, NULL, 1, &ahead));
    const size_t steps = K(history_steps)(&tape);
    ASSERT_OK(K(predict)(&ahead, &motion, NULL));
    TEST_ASSERT_EQUAL_UINT(steps, K(history_steps)(&tape));
}

/* ------------------------------------------------------------------------------ copies */

TEST(a_copy_is_the_filter)
{
    track.events = KQ_EVENT_REDUNDANT;
    watch_the_source();
    ASSERT_OK_UNCHANGED(K(filter_copy)(&ahead, &track));
    ASSERT_SAME_BITS(track_memory, ahead_memory);
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_REDUNDANT, K(events)(&ahead));
    TEST_ASSERT_TRUE(K(log_likelihood)(&track) == K(log_likelihood)(&ahead));
    TEST_ASSERT_TRUE(K(nis)(&track) == K(nis)(&ahead));
    TEST_ASSERT_EQUAL_INT(1, K(taken)(&ahead));
    ASSERT_OK(K(step)(&track, &motion, u, &radar, z));
    ASSERT_OK(K(step)(&ahead, &motion, u, &radar, z));
    ASSERT_SAME_BITS(track_memory, ahead_memory);
    TEST_ASSERT_TRUE(K(log_likelihood)(&track) == K(log_likelihood)(&ahead));
}

/* What moves the copy leaves the original alone, and its history. */
TEST(a_copy_has_its_own_memory)
{
    ASSERT_OK(K(attach)(&track, &tape.attached));
    watch_the_source();
    WATCH(tape), WATCH(tape_memory);
    ASSERT_OK_UNCHANGED(K(filter_copy)(&ahead, &track));
    ASSERT_OK_UNCHANGED(K(step)(&ahead, &motion, u, &radar, z));
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&ahead));
    ASSERT_OK(K(predict)(&track, &motion, NULL));
    TEST_ASSERT_EQUAL_UINT(2, K(history_steps)(&tape));
}

TEST(a_filter_is_not_copied_onto_itself)
{
    K(filter) bare = {.states = 2}, shared = track;
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(filter_copy)(&bare, &track));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(filter_copy)(&shared, &track));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(forecast)(&track, &motion, u, 0, &track));
}

static kq_status forecast(void) { return K(forecast)(&track, &motion, u, 4, &ahead); }

TEST(forecast_refuses_controls_that_are_not_finite)
{
    assert_entries_must_be_finite(u, 4, forecast);
}

TEST(forecast_reads_no_control_beyond_its_steps)
{
    u[4] = (num)NAN;
    ASSERT_OK(forecast());
    u[0] = (num)NAN;
    ASSERT_OK(K(forecast)(&track, &motion, u, 0, &ahead));
    ASSERT_SAME_STATE(&track, &ahead, 2);
}

TEST(forecast_reads_no_control_that_the_process_has_not)
{
    PROCESS(idle, 2, 0);
    ASSERT_OK(K(process_init)(&idle, A, NULL, Q));
    u[0] = u[1] = (num)NAN;
    ASSERT_OK(K(forecast)(&track, &idle, u, 2, &ahead));
    for (int k = 0; k < 2; k++) ASSERT_OK(K(predict)(&walker, &idle, NULL));
    ASSERT_SAME_STATE(&walker, &ahead, 2);
}

SUITE(forecast, set_up)
#include "forecast.tests"
