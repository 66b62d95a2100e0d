/*
 * The smoothers on line, fixed lag and fixed point: beside the same run on a tape, one text for both and for all
 * arithmetics.  The lag is asked for its oldest step, the instant for its own; both are attached at step 0.
 */
#include "drive.h"
#include "unchanged.h"

enum { LONGEST = STEPS + 2 };
enum { LAGGED, POINTED, KINDS };

S_FILTER(copied, 2);
S_FILTER(ahead, 2);
S_LAG(past, 2, MOST, LONGEST);
S_LAG(unused_lag, 2, 1, 2);
S_INSTANT(instant, 2, MOST);
S_INSTANT(unused_instant, 2, 1);
static S(filter) shown, not_shown;

static const num identity[] = {1, 0, 0, 1}, zero[4];

/* ------------------------------------------------------------------------ lag or instant */

static int kind, longest;

static struct S(attached) *object(void) { return kind == LAGGED ? &past.attached : &instant.attached; }

static void attach_as(int what, int most)
{
    kind = what, longest = most;
    ASSERT_OK(init_filter(&track, &prior));
    ASSERT_OK(S(lag_assign)(&past, 2, MOST, (size_t)most, past_memory, COUNT(past_memory)));
    ASSERT_OK(S(instant_assign)(&instant, 2, MOST, instant_memory, COUNT(instant_memory)));
    ASSERT_OK(S(attach)(&track, object()));
}

/* The oldest step of the lag, or the instant */
static kq_status show(S(filter) *view)
{
    if (kind == POINTED) return S(instant_smooth)(&instant, view);
    return S(lagged)(&past, S(lag_steps)(&past), view);
}

static void read(reading *r)
{
    ASSERT_OK(show(&shown));
    read_shown(r, &shown, &prior, 2);
}

static void set_up(void)
{
    begin_drive();
    attach_as(LAGGED, 5);
    watch_nothing();
    WATCH(track), WATCH(track_memory), WATCH(past), WATCH(instant), WATCH(motion.process);
    WATCH(unused_lag), WATCH(unused_instant);
}

/* A test of both, the lag of at most `most` steps */
#define TEST_BOTH(name, most)                                                                       \
    static void name##_of_each(void);                                                              \
    TEST(name)                                                                                     \
    {                                                                                              \
        for (int what = 0; what < KINDS; what++) {                                                 \
            set_up();                                                                              \
            attach_as(what, most);                                                                 \
            name##_of_each();                                                                      \
        }                                                                                          \
    }                                                                                              \
    static void name##_of_each(void)

/* --------------------------------------------------------------------------------- a run */

static const word *z_of(int step)
{
    static num z[2];
    z[0] = N(0.75 * (step % 5) - 1), z[1] = N(2 - 0.5 * (step % 7));
    return measured(&radar.sensor, z);
}

static void drive_to(int end)
{
    for (int step = 0; step < end; step++) drive(&track, step);
}

/* What is known of each step given all measurements up to `last`, that one's included: on the tape */
static void smooth_to(int last)
{
    ASSERT_OK(init_filter(&twin, &prior));
    ASSERT_OK(S(history_assign)(&tape, 2, tape_memory, COUNT(tape_memory)));
    ASSERT_OK(S(attach)(&twin, &tape.attached));
    for (int step = 0; step <= last; step++) drive(&twin, step);
    ASSERT_OK(S(smooth)(&tape));
}

static void assert_read(const reading *expected, const reading *actual)
{
    for (int i = 0; i < 2; i++) {
        ASSERT_ALIKE(whole(expected, i), whole(actual, i), 8);
        ASSERT_WITHIN(ROUNDING * 2 + sigma_step(range[i]), expected->sigma[i], actual->sigma[i]);
    }
    for (int k = 0; k < 4; k++) ASSERT_ALIKE(expected->P[k], actual->P[k], 2);
    TEST_ASSERT_EQUAL_MEMORY(&actual->P[1], &actual->P[2], sizeof(num));
}

/* ---------------------------------------------------------------------------- what it is */

TEST(every_lag_is_that_of_the_tape)
{
    static const int lags[] = {0, 1, 2, 3, 4, 5, 6, 9, 10, STEPS - 1, LONGEST};
    static reading known[STEPS][STEPS]; /* of each step given the data up to each later one */
    reading now;
    for (int last = 0; last < STEPS; last++) {
        smooth_to(last);
        for (int t = 0; t <= last; t++) read_smoothed_at(&known[last][t], &tape, (size_t)t, &prior, 2);
    }
    for (int l = 0; l < COUNT(lags); l++) {
        attach_as(LAGGED, lags[l]);
        for (int last = 0; last < STEPS; last++) {
            drive(&track, last);
            TEST_ASSERT_EQUAL_INT(last < longest ? last : longest, S(lag_steps)(&past));
            for (size_t k = 0; k <= S(lag_steps)(&past); k++) {
                ASSERT_OK(S(lagged)(&past, k, &shown));
                read_shown(&now, &shown, &prior, 2);
                assert_read(&known[last][(size_t)last - k], &now);
            }
        }
        TEST_ASSERT_EQUAL_HEX(0, S(events)(&track));
    }
}

TEST(no_lag_is_the_filter_bit_for_bit)
{
    reading filtered, now;
    for (int most = 0; most <= 4; most += 4) {
        attach_as(LAGGED, most);
        for (int step = 0; step < STEPS; step++) {
            drive(&track, step);
            ASSERT_OK(S(lagged)(&past, 0, &shown));
            read_shown(&now, &shown, &prior, 2);
            read_now(&filtered, &track, 2);
            TEST_ASSERT_EQUAL_MEMORY(&filtered, &now, offsetof(reading, nis));
        }
    }
}

TEST(states_only_gives_the_means)
{
    entry P[4];
    reading now;
    memset(P, 7, sizeof P);
    WATCH(P);
    for (int step = 0; step < STEPS; step++) {
        drive(&track, step);
        for (size_t k = 0; k <= S(lag_steps)(&past); k++) {
            ASSERT_OK(S(lagged)(&past, k, &shown));
            read_shown(&now, &shown, &prior, 2);
            ASSERT_OK(S(lagged_states)(&past, k, &shown));
            for (int i = 0; i < 2; i++) {
                ASSERT_WITHIN(0, whole(&now, i), shown_mean(&shown, &prior, i));
                ASSERT_NOTHING(S(sigma)(&shown, i));
            }
            ASSERT_REFUSED(KQ_ERR_NOT_READY, S(covariance)(&shown, P));
        }
    }
}

/* Attached before or after the measurements of the step s: it is the tape's step s. */
TEST(an_instant_is_that_of_the_tape)
{
    reading expected, now;
    for (int s = 0; s < STEPS; s += 5) {
        for (int after = 0; after < 2; after++) {
            attach_as(POINTED, 0);
            for (int step = 0; step < STEPS; step++) {
                if (step) ASSERT_OK(S(predict)(&track, process_of(step), control_of(step)));
                if (step == s && !after) ASSERT_OK(S(attach)(&track, &instant.attached));
                measure(&track, step);
                if (step == s && after) ASSERT_OK(S(attach)(&track, &instant.attached));
                if (step < s) continue;
                smooth_to(step);
                read_smoothed_at(&expected, &tape, (size_t)s, &prior, 2);
                read(&now);
                assert_read(&expected, &now);
            }
        }
    }
    TEST_ASSERT_EQUAL_HEX(0, S(events)(&track));
}

/* What is measured at the instant itself is in it, however sharp it is: no map has to undo it. */
TEST(an_instant_takes_sharp_measurements_of_its_own_time)
{
    static const num rows[] = {1, N(0.25)}, wide[] = {64, 0, 0, 64}, ranges[] = {100, 100};
    const num noise_now[] = {N(64 * EPS)};
    static sensor_model sharp;
    static prior_model unknown;
    reading expected, now;
    put_independent(&sharp, 2, 1, ranges, ranges, rows, noise_now);
    put_prior(&unknown, 2, ranges, zero, wide);
    for (int is_instant = 0; is_instant < 2; is_instant++) {
        ASSERT_OK(init_filter(&track, &unknown));
        ASSERT_OK(S(history_assign)(&tape, 2, tape_memory, COUNT(tape_memory)));
        ASSERT_OK(S(attach)(&track, is_instant ? &instant.attached : &tape.attached));
        for (int t = 0; t < 8; t++) {
            const num value[] = {N(3 + 0.001 * t)};
            ASSERT_OK(S(update)(&track, &sharp.sensor, measured(&sharp.sensor, value)));
            ASSERT_OK(S(predict)(&track, &motion.process, NULL));
        }
        if (is_instant) ASSERT_OK(S(instant_smooth)(&instant, &shown));
        if (is_instant) read_shown(&now, &shown, &unknown, 2);
        if (is_instant) TEST_ASSERT_EQUAL_HEX(0, S(events)(&shown));
        else ASSERT_OK(S(smooth)(&tape));
        if (!is_instant) read_smoothed_at(&expected, &tape, 0, &unknown, 2);
    }
    for (int i = 0; i < 2; i++) {
        ASSERT_WITHIN(1e-3 * (double)expected.sigma[i], expected.mean[i], now.mean[i]);
        ASSERT_WITHIN(1e-3 * (double)expected.sigma[i], expected.sigma[i], now.sigma[i]);
    }
}

/* Nor does a later one have an event of what they were rounded by. */
TEST(rounding_at_the_instant_is_none_of_the_tape)
{
    static const num row[] = {1, N(0.25)}, wide[] = {64, 0, 0, 64}, ranges[] = {100, 100};
    static const num value[] = {3};
    const num noise_now[] = {N(64 * EPS)}, later[] = {N(1e5 * EPS * EPS)};
    static sensor_model sharp, second;
    static prior_model unknown;
    put_process(&motion, 2, 0, ranges, NULL, identity, NULL, zero);
    put_independent(&sharp, 2, 1, ranges, ranges, row, noise_now);
    put_independent(&second, 2, 1, ranges, ranges, identity, later);
    put_prior(&unknown, 2, ranges, zero, wide);
    ASSERT_OK(init_filter(&track, &unknown));
    ASSERT_OK(S(attach)(&track, &instant.attached));
    for (int k = 0; k < MOST; k++) ASSERT_OK(S(update)(&track, &sharp.sensor, measured(&sharp.sensor, value)));
    ASSERT_OK(S(predict)(&track, &motion.process, NULL));
    ASSERT_OK(S(update)(&track, &second.sensor, measured(&second.sensor, value)));
    ASSERT_OK(S(instant_smooth)(&instant, &shown));
    TEST_ASSERT_EQUAL_HEX(0, S(events)(&shown));
}

/* Long after, measurements say nothing more of the instant, and rounding does not add up. */
TEST(a_long_run_changes_nothing_any_more)
{
    reading early, late;
    attach_as(POINTED, 0);
    drive_to(100);
    read(&early);
    for (int step = 100; step < 3000; step++) drive(&track, step);
    read(&late);
    assert_read(&early, &late);
}

/* Known a million times better than at first, and better still with each measurement, by less than the last bit
   of a word of q31's map: the instant is what the mean of all measurements is. */
TEST(a_constant_is_refined_for_long)
{
    static const num wide[] = {N(1e6), 0, 0, N(1e6)}, wide_range[] = {10000, 10000};
    static const num sharp[] = {N(1e-4), 0, 0, N(1e-4)}, z[] = {3, -1};
    const double known = 0.01 / sqrt(3000);
    reading then;
    put_process(&motion, 2, 0, wide_range, drive_range, identity, NULL, zero);
    put_sensor(&radar, 2, 2, wide_range, wide_range, identity, sharp);
    put_prior(&prior, 2, wide_range, x0, wide);
    attach_as(POINTED, 0);
    for (int step = 0; step < 3000; step++) {
        if (step) ASSERT_OK(S(predict)(&track, &motion.process, NULL));
        ASSERT_OK(S(update)(&track, &radar.sensor, measured(&radar.sensor, z)));
    }
    read(&then);
    for (int i = 0; i < 2; i++) {
        const double of_prior = known * known / (known * known + (double)wide[0]);
        ASSERT_WITHIN(1e-3 * known, known, sqrt((double)then.P[3 * i]));
        ASSERT_WITHIN(2 * sigma_step(wide_range[i]) + 8 * TOLERANCE, (double)z[i] + of_prior * (double)(x0[i] - z[i]), then.mean[i]);
    }
}

TEST_BOTH(the_filter_is_the_same, 5)
{
    for (int step = 0; step < STEPS; step++) {
        drive(&track, step);
        drive(&twin, step);
        ASSERT_OK(show(&shown));
        ASSERT_SAME(&twin, &track, 2);
        TEST_ASSERT_EQUAL_MEMORY(twin_memory, track_memory, sizeof track_memory);
    }
}

TEST_BOTH(a_step_is_predict_and_update, 5)
{
    reading stepped[STEPS], now;
    for (int step = 0; step < STEPS; step++) {
        ASSERT_OK(S(step)(&track, process_of(step), control_of(step), &radar.sensor, z_of(step)));
        ASSERT_OK(S(predict)(&twin, process_of(step), control_of(step)));
        ASSERT_OK(S(update)(&twin, &radar.sensor, z_of(step)));
        ASSERT_SAME(&twin, &track, 2);
        TEST_ASSERT_EQUAL_MEMORY(twin_memory, track_memory, sizeof track_memory);
        read(&stepped[step]);
    }
    TEST_ASSERT_EQUAL_HEX(0, S(events)(&track));
    attach_as(kind, longest);
    for (int step = 0; step < STEPS; step++) {
        ASSERT_OK(S(predict)(&track, process_of(step), control_of(step)));
        ASSERT_OK(S(update)(&track, &radar.sensor, z_of(step)));
        read(&now);
        ASSERT_SAME_BITS(stepped[step], now);
    }
}

/* Whether, when and how often it was asked before makes no difference. */
TEST_BOTH(asking_changes_nothing, 5)
{
    reading all[STEPS], now;
    for (int step = 0; step < STEPS; step++) {
        drive(&track, step);
        read(&all[step]);
    }
    attach_as(kind, longest);
    for (int step = 0; step < STEPS; step++) {
        drive(&track, step);
        if (step % 4 != 3) continue;
        for (size_t k = S(lag_steps)(&past) + 1; kind == LAGGED && k-- > 0;) ASSERT_OK(S(lagged)(&past, k, &shown));
        if (kind == LAGGED) ASSERT_OK(S(lagged_states)(&past, 1, &shown));
        ASSERT_OK(show(&shown));
        read(&now);
        ASSERT_SAME_BITS(all[step], now);
    }
}

TEST_BOTH(an_answer_stays_until_the_next_one, 3)
{
    reading now, later;
    drive_to(4);
    read(&now);
    for (int step = 4; step < 12; step++) drive(&track, step);
    read_shown(&later, &shown, &prior, 2);
    ASSERT_SAME_BITS(now, later);
}

/* An update more after the answer is in the next answer. */
TEST_BOTH(updates_may_come_after_an_answer, 4)
{
    reading expected, now;
    drive_to(8);
    ASSERT_OK(show(&shown));
    ASSERT_OK(S(update_subset)(&track, &radar.sensor, z_of(1), 1));
    read(&now);
    attach_as(kind, longest);
    drive_to(8);
    ASSERT_OK(S(update_subset)(&track, &radar.sensor, z_of(1), 1));
    read(&expected);
    ASSERT_SAME_BITS(expected, now);
}

TEST_BOTH(it_may_be_attached_again, 5)
{
    reading first, again;
    drive_to(9);
    read(&first);
    ASSERT_OK(init_filter(&track, &prior));
    TEST_ASSERT_EQUAL_INT(0, S(lag_steps)(&past));
    ASSERT_OK(S(attach)(&track, object()));
    TEST_ASSERT_EQUAL_INT(0, S(lag_steps)(&past));
    drive_to(9);
    read(&again);
    ASSERT_SAME_BITS(first, again);
}

/* The same constant, through no process noise: known as now, at every step back */
TEST_BOTH(a_constant_is_known_as_now, 10)
{
    static const num z[] = {3, -1};
    reading now, then;
    put_process(&motion, 2, 1, range, drive_range, identity, B, zero);
    for (int step = 0; step < STEPS; step++) {
        if (step) ASSERT_OK(S(predict)(&track, &motion.process, NULL));
        ASSERT_OK(S(update)(&track, &radar.sensor, measured(&radar.sensor, z)));
        read_now(&now, &track, 2);
        for (size_t k = 0; k <= (kind == LAGGED ? S(lag_steps)(&past) : 0); k++) {
            if (kind == LAGGED) ASSERT_OK(S(lagged)(&past, k, &shown));
            else ASSERT_OK(show(&shown));
            read_shown(&then, &shown, &prior, 2);
            for (int i = 0; i < 2; i++) {
                ASSERT_ALIKE(whole(&now, i), whole(&then, i), 8);
                ASSERT_WITHIN(ROUNDING + sigma_step(range[i]), now.sigma[i], then.sigma[i]);
            }
        }
    }
}

/* A noise-free sensor in full: nothing more can be learned of its step, and S is singular. */
TEST_BOTH(what_is_known_exactly_stays, 5)
{
    static const num z[] = {3, 4};
    reading now;
    put_independent(&radar, 2, 2, range, measured_range, identity, zero);
    for (int step = 0; step < 8; step++) {
        if (step) ASSERT_OK(S(predict)(&track, &motion.process, NULL));
        ASSERT_OK(S(update)(&track, &radar.sensor, measured(&radar.sensor, z)));
        read(&now);
        for (int i = 0; i < 2; i++) {
            ASSERT_ALIKE(z[i], whole(&now, i), 8);
            ASSERT_WITHIN(ROUNDING, 0, now.sigma[i]);
        }
    }
}

/* A measurement at the rounding floor is not taken, and is nothing to the smoother either. */
TEST_BOTH(a_measurement_that_was_not_taken_is_nothing, 3)
{
    static const num h[] = {1, 0.5, 1, 0.5}, z[] = {3, 3};
    reading answer[2];
    put_independent(&radar, 2, 2, range, measured_range, h, zero);
    for (int both = 0; both < 2; both++) {
        attach_as(kind, longest);
        for (int step = 0; step < 6; step++) {
            if (step) ASSERT_OK(S(predict)(&track, &motion.process, NULL));
            ASSERT_OK(S(update_subset)(&track, &radar.sensor, measured(&radar.sensor, z), both ? 3 : 1));
        }
        read(&answer[both]);
        TEST_ASSERT_EQUAL_HEX(both ? KQ_EVENT_REDUNDANT : 0, S(events)(&track));
    }
    ASSERT_SAME_BITS(answer[0], answer[1]);
}

/* ---------------------------------------------------------------------------- refusals */

TEST(what_is_assigned_shows_nothing)
{
    ASSERT_OK(S(lag_assign)(&past, 2, 1, 3, past_memory, S_LAG_LEN(2, 1, 3)));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, S(lagged)(&past, 0, &not_shown));
    ASSERT_OK(S(instant_assign)(&instant, 2, 1, past_memory, S_INSTANT_LEN(2, 1)));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, S(instant_smooth)(&instant, &not_shown));
    TEST_ASSERT_EQUAL_INT(0, S(lag_steps)(NULL));
    TEST_ASSERT_EQUAL_INT(0, S(lag_steps)(&unused_lag));
}

static void assert_too_long(int64_t m, int64_t L)
{
    const size_t words = COUNT(past_memory);
    if (m > INT_MAX || L > (int64_t)KQ_COUNT_MAX) return;
    if (L >= 0) ASSERT_REFUSED(KQ_ERR_MEMORY, S(lag_assign)(&past, 2, (int)m, (size_t)L, past_memory, words));
    else ASSERT_REFUSED(KQ_ERR_MEMORY, S(instant_assign)(&instant, 2, (int)m, past_memory, words));
}

/* Sizes whose length is a little more than a multiple of 2^16 or 2^32: as a size_t of so many bits,
   and so many are the words that there are, it is short. */
TEST(a_length_that_would_wrap_is_refused)
{
    const int64_t step = S_LAG_LEN(2, MOST, 1) - S_LAG_LEN(2, MOST, 0), rest = S_LAG_LEN(2, MOST, 0);
    const int64_t each = S_LAG_LEN(2, 2, 5) - S_LAG_LEN(2, 1, 5), others = S_LAG_LEN(2, 0, 5);
    const int64_t one = S_INSTANT_LEN(2, 2) - S_INSTANT_LEN(2, 1), all = S_INSTANT_LEN(2, 0);
    for (int bits = 16; bits <= 32; bits += 16) {
        for (int64_t k = 1; k <= 8; k++) {
            assert_too_long(MOST, ((k << bits) - rest + step - 1) / step);
            assert_too_long(((k << bits) - others + each - 1) / each, 5);
            assert_too_long(((k << bits) - all + one - 1) / one, -1);
        }
    }
    assert_too_long(MOST, INT_MAX), assert_too_long(INT_MAX, INT_MAX), assert_too_long(INT_MAX, -1);
}

TEST_BOTH(smooth_refuses, 5)
{
    static const size_t bad[] = {3, SIZE_MAX, KQ_COUNT_MAX, SIZE_MAX / 2 + 1};
    drive_to(3);
    watch_nothing();
    WATCH(track), WATCH(track_memory), WATCH(past), WATCH(instant), WATCH(instant_memory);
    watch(past_memory, (size_t)S_LAG_LEN(2, MOST, 5) * sizeof(word));
    ASSERT_REFUSED(KQ_ERR_NULL, S(lagged)(NULL, 0, &not_shown));
    ASSERT_REFUSED(KQ_ERR_NULL, S(lagged_states)(NULL, 0, &not_shown));
    ASSERT_REFUSED(KQ_ERR_NULL, S(instant_smooth)(NULL, &not_shown));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, S(lagged)(&unused_lag, 0, &not_shown));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, S(lagged_states)(&unused_lag, 0, &not_shown));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, S(instant_smooth)(&unused_instant, &not_shown));
    for (int k = 0; kind == LAGGED && k < COUNT(bad); k++) {
        ASSERT_REFUSED(KQ_ERR_SIZE, S(lagged)(&past, bad[k], &not_shown));
        ASSERT_REFUSED(KQ_ERR_SIZE, S(lagged_states)(&past, bad[k], &not_shown));
    }
    ASSERT_OK(show(&shown));
}

/* The chain is broken, and the filter goes on: by the bits of the twin, which has the same state and
   nothing attached. */
TEST_BOTH(after_too_many_measurements_the_filter_goes_on, 5)
{
    drive_to(2);
    measure(&track, 3);
    TEST_ASSERT_EQUAL_HEX(0, S(events)(&track));
    measure(&track, 3);
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_HISTORY_FULL, S(events)(&track));
    TEST_ASSERT_EQUAL_INT(0, S(lag_steps)(&past));
    ASSERT_REFUSED(KQ_ERR_HISTORY_FULL, show(&not_shown));
    ASSERT_OK(S(filter_copy)(&twin, &track));
    for (int step = 1; step < 6; step++) {
        drive(&twin, step), drive(&track, step);
        ASSERT_OK(S(step)(&twin, process_of(step), control_of(step), &radar.sensor, z_of(step)));
        ASSERT_OK(S(step)(&track, process_of(step), control_of(step), &radar.sensor, z_of(step)));
        TEST_ASSERT_EQUAL_MEMORY(twin_memory, track_memory, sizeof track_memory);
    }
    ASSERT_REFUSED(KQ_ERR_HISTORY_FULL, show(&not_shown));
    ASSERT_OK(S(attach)(&track, object()));
    drive(&track, 1);
    ASSERT_OK(show(&shown));
}

/* What moves no filter is possible of a view, and all is of a copy, with the same bits. */
static void assert_usable(const S(filter) *view)
{
    word of_view[2], of_copy[2];
    entry cov[4], gain[4];
    ASSERT_OK(S(forecast)(view, &motion.process, NULL, 3, &ahead));
    ASSERT_OK(S(measurement)(view, &radar.sensor, of_view, cov));
    ASSERT_OK(S(gain)(view, &radar.sensor, gain));
    ASSERT_OK(S(filter_copy)(&copied, view));
    ASSERT_OK(S(measurement)(&copied, &radar.sensor, of_copy, NULL));
    ASSERT_SAME_BITS(of_copy, of_view);
    ASSERT_OK(S(innovation)(view, &radar.sensor, z_of(1), of_view));
    ASSERT_OK(S(innovation)(&copied, &radar.sensor, z_of(1), of_copy));
    ASSERT_SAME_BITS(of_copy, of_view);
    for (int t = 0; t < 3; t++) ASSERT_OK(S(predict)(&copied, &motion.process, NULL));
    ASSERT_SAME_BITS(copied_memory, ahead_memory);
    ASSERT_OK(S(update)(&copied, &radar.sensor, z_of(1)));
}

TEST_BOTH(what_is_shown_can_be_used, 3)
{
    drive_to(6);
    ASSERT_OK(show(&shown));
    assert_usable(&shown);
    for (size_t k = 0; kind == LAGGED && k < 3; k++) {
        ASSERT_OK(S(lagged)(&past, k, &shown));
        assert_usable(&shown);
    }
}

TEST(a_smoothed_step_can_be_used)
{
    smooth_to(5);
    ASSERT_OK(S(detach)(&tape.attached));
    ASSERT_OK(S(filter_assign)(&twin, 2, twin_memory, COUNT(twin_memory))); /* as good as gone */
    for (size_t t = 0; t < S(history_steps)(&tape); t++) {
        ASSERT_OK(S(smoothed)(&tape, t, &shown));
        assert_usable(&shown);
    }
}

/* Before and after the start was determined */
TEST(a_smoothed_step_of_a_start_can_be_used)
{
    S_DIFFUSE(unknown, 2, 4);
    static const num z = 1;
    ASSERT_OK(init_start(&unknown, &twin, &prior, 3));
    ASSERT_OK(S(attach)(&twin, &tape.attached));
    for (int t = 0; t < 5; t++) {
        ASSERT_OK(S(update)(&twin, &compass.sensor, measured(&compass.sensor, &z)));
        ASSERT_OK(S(predict)(&twin, &motion.process, NULL));
    }
    ASSERT_OK(S(diffuse_smooth)(&unknown));
    for (size_t t = 0; t < 5; t++) {
        ASSERT_OK(S(diffuse_smoothed)(&unknown, t, &shown));
        assert_usable(&shown);
    }
}

TEST_BOTH(it_may_be_detached, 1)
{
    drive_to(2);
    ASSERT_OK(show(&shown));
    const word mean = S(mean)(&shown, 0);
    ASSERT_OK(S(detach)(object()));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, show(&not_shown));
    TEST_ASSERT_TRUE(mean == S(mean)(&shown, 0));
    ASSERT_OK(S(attach)(&twin, object()));
    ASSERT_OK(init_filter(&twin, &prior));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, show(&not_shown));
}

TEST_BOTH(another_history_takes_its_place, 1)
{
    drive_to(2);
    ASSERT_OK(show(&shown));
    ASSERT_OK(S(attach)(&track, &tape.attached));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, show(&not_shown));
    if (kind == LAGGED) ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, S(lagged)(&past, 1, &not_shown));
    TEST_ASSERT_FALSE(is_nothing(S(mean)(&shown, 0)));
    ASSERT_OK(S(predict)(&track, &motion.process, NULL));
    measure(&track, 3);
    ASSERT_OK(S(smooth)(&tape));
    TEST_ASSERT_EQUAL_UINT(2, S(history_steps)(&tape));
    ASSERT_OK(S(attach)(&track, &tape.attached));
    ASSERT_OK(S(attach)(&track, object()));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, S(smooth)(&tape));
}

TEST_BOTH(what_is_not_shown_is_no_number, 1)
{
    static const int bad[] = {-1, 2, INT_MAX, INT_MIN};
    entry P[9];
    memset(P, 7, sizeof P);
    WATCH(P);
    drive(&track, 0);
    ASSERT_OK(show(&shown));
    for (int k = 0; k < COUNT(bad); k++) assert_nothing_shown(&shown, bad[k]);
    ASSERT_REFUSED(KQ_ERR_NULL, S(covariance)(&shown, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, show(NULL));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, show(&track));
    if (kind == LAGGED) ASSERT_REFUSED(KQ_ERR_SIZE, S(lagged)(&past, 1, &shown));
    else ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, S(instant_smooth)(&unused_instant, &shown));
    assert_nothing_shown(&shown, 0);
    ASSERT_REFUSED(KQ_ERR_NOT_READY, S(covariance)(&shown, P));
}

SUITE(on_line, set_up)
#include "on_line.tests"
