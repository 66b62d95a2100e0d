/* What decides each condition of the functions for compile-time sizes: what they leave to the library, to say what is wrong */
#include "fixed.h"

FIXED_SIZE(2, 2, 0, plain)
FIXED_SIZE(2, 2, KQ_FIXED_BARE, bare)

static process_model motion;
static sensor_model radar;
static prior_model prior;
S_FILTER(track, 2);
static const num range[] = {100, 100}, drive_range[] = {5}, measured_range[] = {100, 100};
static const num A[] = {1, 0.5, 0, 1}, B[] = {0.125, 0.5}, Q[] = {0.25, 0.125, 0.125, 0.5};
static const num H[] = {1, 0, 0.5, 1}, r[] = {0.5, 1}, x0[] = {1, -2}, P0[] = {2, 0.5, 0.5, 1}, z_value[] = {3, 1};
static word z[2];

static void set_up(void)
{
    put_process(&motion, 2, 1, range, drive_range, A, B, Q);
    put_independent(&radar, 2, 2, range, measured_range, H, r);
    put_prior(&prior, 2, range, x0, P0);
    ASSERT_OK(init_filter(&track, &prior));
    memcpy(z, measured(&radar.sensor, z_value), sizeof z);
}

static void assert_nulls(kq_status (*update)(S(filter) *, const S(sensor) *, const word *),
                         kq_status (*step)(S(filter) *, const S(process) *, const word *, const S(sensor) *, const word *))
{
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, update(NULL, &radar.sensor, z));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, update(&track, NULL, z));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, update(&track, &radar.sensor, NULL));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, step(NULL, &motion.process, NULL, &radar.sensor, z));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, step(&track, NULL, NULL, &radar.sensor, z));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, step(&track, &motion.process, NULL, NULL, z));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, step(&track, &motion.process, NULL, &radar.sensor, NULL));
    ASSERT_OK(step(&track, &motion.process, NULL, &radar.sensor, z));
}

TEST(what_is_not_there)
{
    assert_nulls(update_2_2_plain, step_2_2_plain);
    assert_nulls(update_2_2_bare, step_2_2_bare);
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, predict_2_2_plain(NULL, &motion.process, NULL));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, predict_2_2_bare(&track, NULL, NULL));
}

#ifdef KQ_TEST_Q31
/* Formats that are not the same table may be equal, or not: the library says it. */
TEST_Q31(formats_of_another_table)
{
    process_model same = motion;
    sensor_model seen = radar;
    same.process.state_format = same.state_format;
    seen.sensor.state_format = seen.state_format;
    ASSERT_OK(step_2_2_plain(&track, &same.process, NULL, &radar.sensor, z));
    ASSERT_OK(update_2_2_plain(&track, &seen.sensor, z));
    ASSERT_OK(step_2_2_plain(&track, &motion.process, NULL, &seen.sensor, z));
    ASSERT_OK(predict_2_2_plain(&track, &same.process, NULL));
}
#endif

SUITE(conditions_fixed, set_up)
#include "conditions_fixed.tests"
