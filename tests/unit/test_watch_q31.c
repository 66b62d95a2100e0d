/* KQ_EVENT_PRECISION of many updates, each of which rounds P a little, in fixed point. */
#include "q31.h"
#include "losses_q31.h"

static process_model still;
static sensor_model first, second, zero, pair;
static prior_model prior, known;
KQ_FILTER_Q31(track, 4);

/* Two sensors see two directions of four. */
static const double range[] = {2000, 2000, 2000, 2000}, measured_range[] = {8000};
static const double identity[] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, none[16], x0[4];
static const double H[] = {0, 0, 1, 1}, other[] = {-0.3206956928538921, 0.40631647601519538, -0.048418252501881809,
                                                   0.024306689547007099};
static const double P0[] = {847, 0, 0, 0, 0, 847, 0, 0, 0, 0, 847, 0, 0, 0, 0, 847}, r[] = {0.000152};
static const int32_t z[2];

static void set_up(void)
{
    put_process(&still, 4, 0, range, NULL, identity, NULL, none);
    put_sensor(&first, 4, 1, range, measured_range, H, r);
    put_sensor(&second, 4, 1, range, measured_range, other, r);
    put_sensor(&zero, 4, 1, range, measured_range, none, r);
    put_prior(&prior, 4, range, x0, P0);
    put_prior(&known, 4, range, x0, none);
    ASSERT_OK(kq_filter_init_q31(&track, &prior.table, NULL));
}

static void measure(const sensor_model *a, const sensor_model *b, long updates)
{
    for (long t = 0; t < updates; t++) {
        ASSERT_OK(kq_predict_q31(&track, &still.process, NULL));
        ASSERT_OK(kq_update_q31(&track, t % 2 ? &b->sensor : &a->sensor, z));
    }
}

/* A sigma is 6 % too small after 10^4 updates. */
TEST(what_is_not_seen_is_told_after_long)
{
    measure(&first, &second, 1000);
    TEST_ASSERT_EQUAL_UINT(0, kq_events_q31(&track));
    measure(&first, &second, 9000);
    TEST_ASSERT_EQUAL_UINT(KQ_EVENT_PRECISION, kq_events_q31(&track));
}

/* The same two directions as components of one sensor, both of them or one by turns */
TEST(components_of_one_sensor_are_looked_at_by_turns)
{
    const double ranges[] = {8000, 8000}, R[] = {r[0], 0, 0, r[0]};
    double rows[8];
    memcpy(rows, H, sizeof H);
    memcpy(rows + 4, other, sizeof other);
    put_sensor(&pair, 4, 2, range, ranges, rows, R);
    for (int whole = 0; whole <= 1; whole++) {
        ASSERT_OK(kq_filter_init_q31(&track, &prior.table, NULL));
        for (uint32_t t = 0; t < 10000; t++) {
            ASSERT_OK(kq_predict_q31(&track, &still.process, NULL));
            ASSERT_OK(kq_update_subset_q31(&track, &pair.sensor, z, whole ? 3 : 1u << t % 2));
        }
        TEST_ASSERT_EQUAL_UINT(KQ_EVENT_PRECISION, kq_events_q31(&track));
    }
}

TEST(a_row_of_zeros_changes_nothing)
{
    measure(&zero, &zero, 2000);
    TEST_ASSERT_EQUAL_UINT(0, kq_events_q31(&track));
}

TEST(what_is_known_exactly_may_be_measured)
{
    ASSERT_OK(kq_filter_init_q31(&track, &known.table, NULL));
    measure(&first, &second, 2000);
    TEST_ASSERT_EQUAL_UINT(0, kq_events_q31(&track));
}

TEST(with_nothing_present_every_bit_stays)
{
    int32_t before[COUNT(track_memory)];
    measure(&first, &second, 50);
    memcpy(before, track_memory, sizeof before);
    ASSERT_OK(jump_q31(&track, &first.sensor, z, 0, (kq_scaled_q31){9 << 27, -27}));
    TEST_ASSERT_EQUAL_MEMORY(before, track_memory, sizeof before);
}

SUITE(watch_q31, set_up)
#include "watch_q31.tests"
