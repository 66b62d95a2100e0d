/* A start of which something is unknown, in all arithmetics: what it has in common with an ordinary one, and what is read
   until all is known (test_diffuse.c: what is determined when, by hand; test_diffuse_q31.c: beside double). */
#include "models.h"
#include "unchanged.h"

#define STEPS 8
#define EARLY 4
#ifdef KQ_TEST_Q31
#define LIKE 0x1p-22
#else
#define LIKE TOLERANCE
#endif

static process_model trend, still;
static sensor_model level, total;
static prior_model prior;
S_FILTER(track, 2);
S_FILTER(twin, 2);
S_FILTER(blank, 2);
static S(filter) view;
S_HISTORY(tape, 2, 2, STEPS, STEPS);
S_HISTORY(other_tape, 2, 2, STEPS, STEPS);
S_DIFFUSE(start, 2, EARLY);
S_DIFFUSE(other, 2, EARLY);
S_DIFFUSE(blank_start, 2, 1);

static const num A[] = {1, 1, 0, 1}, Q[] = {0.25, 0, 0, 0.5}, identity[] = {1, 0, 0, 1}, zero[4];
static const num H[] = {1, 0}, R[] = {2}, sum[] = {1, 1, 2, 2}, x0[] = {1, -2}, P0[] = {4, 0, 0, 9};
static const num range[] = {1000, 1000}; /* so wide that what is measured says more */

static void set_up(void)
{
    put_process(&trend, 2, 0, range, NULL, A, NULL, Q);
    put_process(&still, 2, 0, range, NULL, identity, NULL, zero);
    put_sensor(&level, 2, 1, range, range, H, R);
    put_sensor(&total, 2, 2, range, range, sum, zero);
    put_prior(&prior, 2, range, x0, P0);
    ASSERT_OK(S(diffuse_assign)(&start, 2, EARLY, start_memory, COUNT(start_memory)));
    ASSERT_OK(S(diffuse_assign)(&other, 2, EARLY, other_memory, COUNT(other_memory)));
    ASSERT_OK(init_start(&start, &track, &prior, 3));
    ASSERT_OK(S(history_assign)(&tape, 2, tape_memory, COUNT(tape_memory)));
    watch_nothing();
    WATCH(start), WATCH(start_memory), WATCH(track), WATCH(track_memory);
}

static void update(S(filter) *f, sensor_model *s, double value)
{
    const num seen[] = {N(value), N(2 * value)};
    ASSERT_OK(S(update)(f, &s->sensor, measured(&s->sensor, seen)));
}

static void predict(S(filter) *f, process_model *p) { ASSERT_OK(S(predict)(f, &p->process, NULL)); }

static double mean_of(int i) { return shown_mean(&track, &prior, i); }

/* What the smoother shows of step t */
static const S(filter) *early(const S(diffuse) *of, size_t t)
{
    const kq_status status = S(diffuse_smoothed)(of, t, &view);
    (void)status;
    return &view;
}

TEST(nothing_unknown_is_an_ordinary_start)
{
    ASSERT_OK(init_start(&start, &track, &prior, 0));
    ASSERT_OK(init_filter(&twin, &prior));
    ASSERT_SAME(&twin, &track, 2);
    ASSERT_REFUSED(KQ_ERR_MISMATCH, S(diffuse_smoothed)(&start, 0, &track)); /* its filter is no view */
    predict(&track, &trend);
}

TEST(noise_free_measurements)
{
    static const num other_rows[] = {1, 0, 0, 1};
    update(&track, &total, 4); /* the second says nothing new */
    TEST_ASSERT_EQUAL_INT(1, S(diffuse_count)(&start));
    TEST_ASSERT_EQUAL_INT(KQ_EVENT_REDUNDANT, S(events)(&track));
    for (int i = 0; i < 2; i++) assert_nothing_shown(&track, i);
    update(&track, &total, 4);
    TEST_ASSERT_EQUAL_INT(1, S(diffuse_count)(&start));
    S(events_clear)(&track);
    const num one[] = {1, 6};
    ASSERT_OK(change_measurement(&total, 2, 2, other_rows));
    ASSERT_OK(S(update_subset)(&track, &total.sensor, measured(&total.sensor, one), 1));
    TEST_ASSERT_EQUAL_INT(0, S(diffuse_count)(&start));
    reading now;
    read_now(&now, &track, 2);
    ASSERT_WITHIN(4 * LIKE, 1, whole(&now, 0));
    ASSERT_WITHIN(4 * LIKE, 3, whole(&now, 1));
    for (int i = 0; i < 2; i++) ASSERT_WITHIN(8 * LIKE, 0, now.sigma[i]);
    for (int k = 0; k < 4; k++) ASSERT_WITHIN(4 * LIKE, 0, now.P[k]);
    TEST_ASSERT_EQUAL_INT(0, S(events)(&track));
}

TEST(what_is_not_seen_stays_unknown)
{
    static const num both[] = {1, 1};
    size_t first;
    ASSERT_OK(S(attach)(&track, &tape.attached));
    ASSERT_OK(change_measurement(&level, 2, 1, both));
    for (int t = 0; t < 200; t++) {
        update(&track, &level, t % 7);
        predict(&track, &still);
    }
    TEST_ASSERT_EQUAL_INT(1, S(diffuse_count)(&start));
    for (int i = 0; i < 2; i++) assert_nothing_shown(&track, i);
    ASSERT_OK(S(diffuse_smooth)(&start));
    assert_nothing_shown(early(&start, 199), 1);
    (void)S(diffuse_steps)(&start, &first);
    TEST_ASSERT_EQUAL_UINT(201 - EARLY, first);
    ASSERT_OK(change_measurement(&level, 2, 1, H));
    update(&track, &level, 1);
    TEST_ASSERT_EQUAL_INT(0, S(diffuse_count)(&start));
}

/* A step from the unknown, and through the instant at which all is known */
TEST(a_step_is_a_predict_and_an_update)
{
    ASSERT_OK(init_start(&other, &twin, &prior, 3));
    ASSERT_OK(S(attach)(&track, &tape.attached));
    ASSERT_OK(S(attach)(&twin, &other_tape.attached));
    for (int t = 0; t < 5; t++) {
        const num seen = N(3 * t - 1);
        predict(&track, &trend);
        update(&track, &level, 3 * t - 1);
        ASSERT_OK(S(step)(&twin, &trend.process, NULL, &level.sensor, measured(&level.sensor, &seen)));
        TEST_ASSERT_EQUAL_MEMORY(track_memory, twin_memory, sizeof twin_memory);
        TEST_ASSERT_EQUAL_INT(S(diffuse_count)(&start), S(diffuse_count)(&other));
        TEST_ASSERT_TRUE(S(log_likelihood)(&track) == S(log_likelihood)(&twin));
    }
    TEST_ASSERT_EQUAL_INT(0, S(diffuse_count)(&start));
    ASSERT_SAME(&track, &twin, 2);
    ASSERT_OK(S(diffuse_smooth)(&start));
    ASSERT_OK(S(diffuse_smooth)(&other));
    for (size_t t = 0; t < 6; t++) {
        const word expected = S(mean)(early(&start, t), 1);
        TEST_ASSERT_TRUE(expected == S(mean)(early(&other, t), 1));
    }
}

static void copy_filter(void)
{
    memcpy(twin_memory, track_memory, sizeof twin_memory);
    twin = track;
    twin.memory = twin_memory;
}

/* The start is that of the filter it was made for: a copy has no half of it. */
TEST(a_copied_filter_has_no_start)
{
    const word *z = measured(&level.sensor, x0);
    update(&track, &level, 10);
    copy_filter();
    WATCH(twin), WATCH(twin_memory);
    ASSERT_REFUSED(KQ_ERR_NOT_READY, S(predict)(&twin, &trend.process, NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, S(update)(&twin, &level.sensor, z));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, S(update_subset)(&twin, &level.sensor, z, 1));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, S(step)(&twin, &trend.process, NULL, &level.sensor, z));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, S(attach)(&twin, &tape.attached));
    TEST_ASSERT_TRUE(S(mean)(&twin, 0) == S(mean)(&track, 0)); /* what is known can be read */
    TEST_ASSERT_TRUE(S(sigma)(&twin, 0) == S(sigma)(&track, 0));
    assert_nothing_shown(&twin, 1);
    ASSERT_WITHIN(10 * LIKE, 10, mean_of(0));
    /* one of which nothing is unknown goes on by itself, and so does its filter */
    ASSERT_OK(init_start(&start, &track, &prior, 0));
    copy_filter();
    for (int t = 0; t < 3; t++) {
        update(&track, &level, t), update(&twin, &level, t);
        predict(&track, &trend), predict(&twin, &trend);
    }
    ASSERT_SAME(&twin, &track, 2);
}

/* Nothing refers to the start any more. */
TEST(a_filter_that_begins_anew_has_no_start)
{
    update(&track, &level, 10);
    ASSERT_OK(init_filter(&track, &prior));
    ASSERT_OK(init_filter(&twin, &prior));
    memset(&start, 0xa5, sizeof start);
    predict(&track, &trend), predict(&twin, &trend);
    ASSERT_SAME(&twin, &track, 2);
}

TEST(readings_of_what_is_bad)
{
    size_t first = 1;
    TEST_ASSERT_EQUAL_INT(-1, S(diffuse_count)(NULL));
    TEST_ASSERT_EQUAL_INT(-1, S(diffuse_count)(&blank_start));
    for (int i = -1; i < 3; i++) assert_nothing_shown(&track, i);
    ASSERT_NO_SCORE(S(log_likelihood_last)(&blank));
    TEST_ASSERT_EQUAL_UINT(0, S(diffuse_steps)(NULL, NULL));
    TEST_ASSERT_EQUAL_UINT(0, S(diffuse_steps)(&blank_start, &first));
    TEST_ASSERT_EQUAL_UINT(0, first);
    ASSERT_REFUSED(KQ_ERR_SIZE, S(diffuse_smoothed)(&start, 0, &view));
    assert_nothing_shown(early(NULL, 0), 0);
    assert_nothing_shown(early(&blank_start, 0), 0);
    assert_nothing_shown(early(&start, 0), 0);
}

SUITE(starts, set_up)
#include "starts.tests"
