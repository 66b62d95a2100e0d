/* KQ_EVENT_PRECISION of many updates, each of which rounds P a little, and of a jump that is too large for it. */
#include "reading.h"
#include "sizes.h"
#include "losses.h"

PROCESS(still, 3, 0);
PROCESS(moving, 3, 0);
SENSOR_DIAGONAL(first, 3, 1);
SENSOR_DIAGONAL(second, 3, 1);
SENSOR_DIAGONAL(zero, 3, 1);
SENSOR_DIAGONAL(coarse, 3, 1);
SENSOR_DIAGONAL(pair, 3, 2);
FILTER(track, 3);

/* Two sensors see two directions of three. */
static const num H[] = {(num)0.18921958, (num)-0.48004758, (num)-0.19787899};
static const num other[] = {(num)-0.23775239, (num)-0.011051957, (num)-0.33505979};
static const num identity[] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, none[9], z[1];
static const num x0[] = {0, 0, 0}, P0[] = {600, 0, 0, 0, 600, 0, 0, 0, 600}, one[] = {1};
static const num Q[] = {1, 0, 0, 0, 0, 0, 0, 0, 0};

/* P0 / r that float resolves no better in f32 than double in f64 */
static const double finer = EPS / (double)FLT_EPSILON;

static void set_up(void)
{
    const num r[] = {(num)(0.015 * finer * finer)};
    ASSERT_OK(K(process_init)(&still, identity, NULL, none));
    ASSERT_OK(K(process_init)(&moving, identity, NULL, Q));
    ASSERT_OK(K(sensor_init_diagonal)(&first, H, r));
    ASSERT_OK(K(sensor_init_diagonal)(&second, other, r));
    ASSERT_OK(K(sensor_init_diagonal)(&zero, none, one));
    ASSERT_OK(K(sensor_init_diagonal)(&coarse, H, one));
    ASSERT_OK(K(filter_init)(&track, x0, P0));
}

/* Updates by a and b in turn */
static void measure(const K(process) *p, const K(sensor) *a, const K(sensor) *b, long updates)
{
    for (long t = 0; t < updates; t++) {
        ASSERT_OK(K(predict)(&track, p, NULL));
        ASSERT_OK(K(update)(&track, t % 2 ? b : a, z));
    }
}

/* In f32 sigma becomes 10 % too small after 10^5 updates.  In f64 the rounding of these rows does no harm. */
TEST(what_is_not_seen_is_told_after_long)
{
    measure(&still, &first, &second, 2000);
    TEST_ASSERT_EQUAL_UINT(0, K(events)(&track));
    measure(&still, &first, &second, 98000);
    TEST_ASSERT_EQUAL_UINT(EPS > 1e-10 ? KQ_EVENT_PRECISION : 0, K(events)(&track));
    ASSERT_WITHIN(EPS > 1e-10 ? 2 : 0.01, 12.6213, K(sigma)(&track, 2));
}

/* The same two directions as components of one sensor, one of which is looked at each time */
TEST(components_of_one_sensor_are_looked_at_by_turns)
{
    const num r = (num)(0.015 * finer * finer), noise[] = {r, r}, both[] = {0, 0};
    num rows[6];
    memcpy(rows, H, sizeof H);
    memcpy(rows + 3, other, sizeof other);
    ASSERT_OK(K(sensor_init_diagonal)(&pair, rows, noise));
    for (long t = 0; t < 50000; t++) {
        ASSERT_OK(K(predict)(&track, &still, NULL));
        ASSERT_OK(K(update)(&track, &pair, both));
    }
    TEST_ASSERT_EQUAL_UINT(EPS > 1e-10 ? KQ_EVENT_PRECISION : 0, K(events)(&track));
}

TEST(a_row_of_zeros_changes_nothing)
{
    measure(&still, &zero, &zero, 2000);
    measure(&still, &zero, &coarse, 2000);
    TEST_ASSERT_EQUAL_UINT(0, K(events)(&track));
}

TEST(a_state_that_moves_beside_one_that_is_not_seen)
{
    measure(&moving, &coarse, &coarse, 5000);
    TEST_ASSERT_EQUAL_UINT(0, K(events)(&track));
}

static void jump_by(double sigmas)
{
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    measure(&moving, &coarse, &coarse, 20);
    ASSERT_OK(update_jump(&track, &coarse, &(num){(num)(2 * sigmas)}, UINT32_MAX, 9));
}

TEST(a_jump_that_leaves_no_digits_is_told)
{
    jump_by(1e4);
    TEST_ASSERT_EQUAL_UINT(KQ_EVENT_JUMP, K(events)(&track));
    jump_by(1e6 / finer);
    TEST_ASSERT_EQUAL_UINT(KQ_EVENT_JUMP | KQ_EVENT_PRECISION, K(events)(&track));
}

/* The parts of a mean are apart as predict has left them. */
TEST(with_nothing_present_every_bit_stays)
{
    num before[COUNT(track_memory)];
    K(loss) losses[] = {{.kind = &K(loss_huber), .parameter = 3},
                        {.kind = &K(loss_student), .parameter = 10},
                        {.kind = &K(loss_jump), .parameter = 9},
                        {.kind = &K(loss_gate), .limit = 10}};
    for (int t = 0; t < 50; t++) {
        ASSERT_OK(K(update)(&track, &coarse, &(num){(num)(t % 7)}));
        ASSERT_OK(K(predict)(&track, &moving, NULL));
        track_memory[3] = (num)0.25; /* lo of a pair, in f32 */
        memcpy(before, track_memory, sizeof before);
        for (int k = 0; k < COUNT(losses); k++) {
            ASSERT_OK(K(update_robust)(&track, &coarse, z, 0, &losses[k]));
            TEST_ASSERT_EQUAL_MEMORY(before, track_memory, sizeof before);
            TEST_ASSERT_EQUAL_INT(0, K(taken)(&track));
        }
    }
}

SUITE(watch, set_up)
#include "watch.tests"
