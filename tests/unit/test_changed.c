/*
 * A process that has changed since a history recorded it is not smoothed with.  The recording is of
 * a coordinated turn whose A is made anew at every step, in place: the loop of an extended filter.
 */
#include "models.h"
#include "unchanged.h"

#define STEPS 20
#ifdef KQ_TEST_Q31
#define LAST_BIT 0x1p-30
#else
#define LAST_BIT EPS
#endif

static process_model turn, other, apart[STEPS];
static sensor_model radar;
static prior_model prior;
S_FILTER(track, 2);
S_FILTER(twin, 2);
S_HISTORY(tape, 2, 1, STEPS, STEPS);
S_HISTORY(right, 2, 1, STEPS, STEPS);
S_LAG(past, 2, 1, STEPS);
S_INSTANT(instant, 2, 1);
static S(filter) view;
S_DIFFUSE(start, 2, 4);

static num A[4], apart_A[STEPS][4];
static const num Q[] = {0.25, 0.125, 0.125, 0.5}, Q2[] = {1, 0, 0, 0}, range[] = {100, 100};
static const num H[] = {1, 0.25}, R[] = {0.5}, x0[] = {1, -2}, P0[] = {2, 0.5, 0.5, 1};

/* A rotation, at each step by another angle */
static void put_turn(num *to, int step)
{
    const double angle = 0.3 + 0.1 * step;
    to[0] = to[3] = N(cos(angle));
    to[1] = N(-sin(angle));
    to[2] = -to[1];
}

static void put(process_model *m, const num *transition, const num *noise_of)
{
    put_process(m, 2, 0, range, NULL, transition, NULL, noise_of);
}

static void set_up(void)
{
    put_turn(A, 0);
    put(&turn, A, Q);
    put(&other, A, Q2);
    put_sensor(&radar, 2, 1, range, range, H, R);
    put_prior(&prior, 2, range, x0, P0);
    ASSERT_OK(init_filter(&track, &prior));
    ASSERT_OK(init_filter(&twin, &prior));
    ASSERT_OK(S(history_assign)(&tape, 2, tape_memory, COUNT(tape_memory)));
    ASSERT_OK(S(history_assign)(&right, 2, right_memory, COUNT(right_memory)));
    ASSERT_OK(S(attach)(&track, &tape.attached));
    ASSERT_OK(S(attach)(&twin, &right.attached));
    watch_nothing();
    WATCH(track), WATCH(track_memory), WATCH(tape), WATCH(tape_memory), WATCH(turn), WATCH(other);
}

static void measure(S(filter) * f, int step)
{
    const num z = N(3 * sin(1.7 * step));
    ASSERT_OK(S(update)(f, &radar.sensor, measured(&radar.sensor, &z)));
}

static void change(int step)
{
    put_turn(A, step);
    ASSERT_OK(change_transition(&turn, 2, A));
}

/* The process of each step for itself: what is right */
static void run_apart(S(filter) * f)
{
    for (int t = 0; t < STEPS; t++) {
        put_turn(apart_A[t], t);
        put(&apart[t], apart_A[t], Q);
        if (t) ASSERT_OK(S(predict)(f, &apart[t].process, NULL));
        measure(f, t);
    }
}

static void run_in_place(S(filter) * f)
{
    for (int t = 0; t < STEPS; t++) {
        change(t);
        if (t) ASSERT_OK(S(predict)(f, &turn.process, NULL));
        measure(f, t);
    }
}

static void run_constant(S(filter) * f, const S(process) * p)
{
    for (int t = 0; t < 5; t++) {
        if (t) ASSERT_OK(S(predict)(f, p, NULL));
        measure(f, t);
    }
}

/* Refused in every way, as a whole; but the last step needs no process. */
static void assert_changed(void)
{
    ASSERT_REFUSED(KQ_ERR_CHANGED, S(smooth)(&tape));
    ASSERT_REFUSED(KQ_ERR_CHANGED, S(smooth_states)(&tape));
    ASSERT_OK(S(smooth_step)(&tape, NULL, NULL));
    ASSERT_REFUSED(KQ_ERR_CHANGED, S(smooth_step)(&tape, NULL, NULL));
}

static void assert_smooth_again(void)
{
    ASSERT_OK(init_filter(&track, &prior));
    ASSERT_OK(S(attach)(&track, &tape.attached));
    run_constant(&track, &turn.process);
    ASSERT_OK(S(smooth)(&tape));
}

/* ------------------------------------------------------------------------------- tapes */

TEST(a_process_changed_at_every_step_is_refused)
{
    run_in_place(&track);
    TEST_ASSERT_EQUAL_HEX(0, S(events)(&track));
    assert_changed();
    assert_smooth_again();
}

TEST(with_the_process_of_each_step_it_is_smoothed)
{
    reading expected, now;
    run_in_place(&track);
    run_apart(&twin);
    ASSERT_OK(S(smooth)(&right));
    ASSERT_OK(S(smooth_step)(&tape, NULL, NULL));
    for (int t = STEPS - 1; t > 0; t--) {
        if (t % 2) change(t);
        ASSERT_OK(S(smooth_step)(&tape, t % 2 ? &turn.process : &apart[t].process, NULL));
    }
    for (size_t t = 0; t < STEPS; t++) {
        read_smoothed_at(&expected, &right, t, &prior, 2);
        read_smoothed_at(&now, &tape, t, &prior, 2);
        ASSERT_SAME_BITS(expected, now);
    }
}

TEST(changed_between_two_predicts)
{
    for (int changed = 1; changed < 5; changed++) {
        set_up();
        for (int t = 0; t < 6; t++) {
            if (t == changed) change(t);
            ASSERT_OK(S(predict)(&track, &turn.process, NULL));
            measure(&track, t);
        }
        if (changed < 3) change(0);
        assert_changed();
    }
}

TEST(changed_after_the_recording)
{
    run_constant(&track, &turn.process);
    change(1);
    ASSERT_REFUSED(KQ_ERR_CHANGED, S(smooth)(&tape));
    change(0); /* as it was */
    ASSERT_OK(S(smooth)(&tape));
}

TEST(changed_while_it_is_smoothed)
{
    run_constant(&track, &turn.process);
    for (int k = 0; k < 3; k++) ASSERT_OK(S(smooth_step)(&tape, NULL, NULL));
    change(1);
    ASSERT_REFUSED(KQ_ERR_CHANGED, S(smooth_step)(&tape, NULL, NULL));
    change(0);
    for (int k = 3; k < 5; k++) ASSERT_OK(S(smooth_step)(&tape, NULL, NULL));
}

/* One of two that take turns changes while it is not in use, or has no more use. */
TEST(changed_while_another_was_in_use)
{
    for (int changed = 0; changed < 6; changed++) {
        set_up();
        for (int t = 0; t < 6; t++) {
            ASSERT_OK(S(predict)(&track, t / 2 % 2 ? &other.process : &turn.process, NULL));
            measure(&track, t);
            if (t == changed) change(7);
        }
        ASSERT_REFUSED(KQ_ERR_CHANGED, S(smooth)(&tape));
        if (changed == 5) change(0), ASSERT_OK(S(smooth)(&tape));
    }
}

TEST(the_same_a_again_is_no_change)
{
    static num again[4];
    for (int t = 0; t < 5; t++) {
        put_turn(again, 0);
        ASSERT_OK(change_transition(&turn, 2, t % 2 ? A : again));
        ASSERT_OK(S(predict)(&track, &turn.process, NULL));
        measure(&track, t);
    }
    ASSERT_OK(S(smooth)(&tape));
}

/* ------------------------------------------------------------------- whatever changes it */

TEST(another_init)
{
    run_constant(&track, &turn.process);
    put(&turn, A, Q2);
    ASSERT_REFUSED(KQ_ERR_CHANGED, S(smooth)(&tape));
#ifndef KQ_TEST_Q31
    ASSERT_OK(S(process_init_factor)(&turn.process, A, NULL, Q, 2));
    ASSERT_REFUSED(KQ_ERR_CHANGED, S(smooth)(&tape));
#endif
    put(&turn, A, Q);
    ASSERT_OK(S(smooth)(&tape));
}

TEST(an_assigned_struct)
{
    const S(process) before = turn.process;
    run_constant(&track, &turn.process);
    turn.process = other.process;
    ASSERT_REFUSED(KQ_ERR_CHANGED, S(smooth)(&tape));
    turn.process = before;
    ASSERT_OK(S(smooth)(&tape));
}

/* A copy of a process, with its own A at every step */
TEST(a_copy_that_is_changed)
{
    process_model now;
    for (int t = 0; t < 5; t++) {
        now = turn;
        put_turn(A, t);
        ASSERT_OK(change_transition(&now, 2, A));
        ASSERT_OK(S(predict)(&track, &now.process, NULL));
        measure(&track, t);
    }
    ASSERT_REFUSED(KQ_ERR_CHANGED, S(smooth)(&tape));
    ASSERT_OK(S(detach)(&tape.attached));
}

TEST(scaled_noise)
{
    ASSERT_OK(scale_noise(&other, &turn, number(4)));
    run_constant(&track, &other.process);
    ASSERT_OK(scale_noise(&other, &turn, number(5)));
    ASSERT_REFUSED(KQ_ERR_CHANGED, S(smooth)(&tape));
    ASSERT_OK(scale_noise(&other, &turn, number(1)));
    ASSERT_REFUSED(KQ_ERR_CHANGED, S(smooth)(&tape));
    ASSERT_OK(scale_noise(&other, &turn, number(4)));
    ASSERT_OK(S(smooth)(&tape));
}

/* As of Student's steps, whose history is smoothed with the scales */
TEST(noise_scaled_at_every_step)
{
    entry q[4];
    for (int t = 0; t < 5; t++) {
        if (t) {
            q[t - 1] = number(1 + t);
            ASSERT_OK(scale_noise(&other, &turn, q[t - 1]));
            ASSERT_OK(S(predict)(&track, &other.process, NULL));
        }
        measure(&track, t);
    }
    ASSERT_REFUSED(KQ_ERR_CHANGED, S(smooth)(&tape));
    ASSERT_OK(smooth_reweighted(&tape, &other, &turn, number(2), q));
}

/* Signs, exchanges, last bits and powers of 2, of each entry and of two at once */
TEST(every_entry_counts)
{
    static const num factor[] = {-1, 2, 0.5, 4, 0, N(1 + LAST_BIT)};
    num first[4];
    run_constant(&track, &turn.process);
    memcpy(first, A, sizeof A);
    for (int k = 0; k < 4; k++) {
        for (int j = 0; j < 4; j++) {
            for (int by = 0; by < COUNT(factor); by++) {
                A[k] = first[k] * factor[by];
                A[j] = j == k ? A[k] : first[j] * factor[COUNT(factor) - 1 - by];
                ASSERT_OK(change_transition(&turn, 2, A));
                ASSERT_REFUSED(KQ_ERR_CHANGED, S(smooth)(&tape));
                memcpy(A, first, sizeof A);
            }
            if (A[j] == A[k]) continue;
            A[j] = first[k], A[k] = first[j];
            ASSERT_OK(change_transition(&turn, 2, A));
            ASSERT_REFUSED(KQ_ERR_CHANGED, S(smooth)(&tape));
            memcpy(A, first, sizeof A);
        }
    }
    ASSERT_OK(change_transition(&turn, 2, A));
    ASSERT_OK(S(smooth)(&tape));
}

/* ------------------------------------------------------------------------------ on line */

static void assert_as_on_tape(const S(filter) *shown, size_t t)
{
    reading expected, now;
    read_smoothed_at(&expected, &right, t, &prior, 2);
    read_shown(&now, shown, &prior, 2);
    for (int i = 0; i < 2; i++) {
        ASSERT_ALIKE(whole(&expected, i), whole(&now, i), 8);
        ASSERT_WITHIN(2 * ROUNDING + sigma_step(range[i]), expected.sigma[i], now.sigma[i]);
    }
}

/* Nothing of a process is kept: it may change in place at every step. */
TEST(a_lag_and_an_instant_take_the_process_as_it_was)
{
    run_apart(&twin);
    ASSERT_OK(S(smooth)(&right));
    ASSERT_OK(S(attach)(&track, &past.attached));
    run_in_place(&track);
    change(0);
    for (size_t k = 0; k < STEPS; k++) {
        ASSERT_OK(S(lagged)(&past, k, &view));
        assert_as_on_tape(&view, STEPS - 1 - k);
    }
    ASSERT_OK(init_filter(&track, &prior));
    ASSERT_OK(S(attach)(&track, &instant.attached));
    run_in_place(&track);
    change(0);
    ASSERT_OK(S(instant_smooth)(&instant, &view));
    assert_as_on_tape(&view, 0);
}

/* The steps before the state is known need no process afterwards, the tape's do. */
TEST(a_start_smooths_what_has_not_changed)
{
    for (int changed = 0; changed < 5; changed++) {
        set_up();
        ASSERT_OK(S(detach)(&tape.attached));
        ASSERT_OK(init_start(&start, &track, &prior, 3));
        ASSERT_OK(S(attach)(&track, &tape.attached));
        for (int t = 0; t < 5; t++) {
            if (t == changed) change(t + 1);
            if (t) ASSERT_OK(S(predict)(&track, &turn.process, NULL));
            measure(&track, t);
        }
        const int early = (int)S(diffuse_steps)(&start, NULL);
        TEST_ASSERT_EQUAL_INT(1, early);
        if (changed > early + 1) ASSERT_REFUSED(KQ_ERR_CHANGED, S(diffuse_smooth)(&start));
        else ASSERT_OK(S(diffuse_smooth)(&start));
    }
}

#ifndef KQ_TEST_Q31
/* --------------------------------------------------------------------- tables in flash */

/* The root of Q, by columns: {{0.5, 0.25}, {0, 0.5}} times its transpose */
static const num table_A[] = {1, 0.5, 0, 1}, table_G[] = {0.5, 0.25, 0.5};
static const num table_Q[] = {0.3125, 0.125, 0.125, 0.25};
static const K(process) table = KQ_PROCESS_TABLE(2, 0, table_A, NULL, table_G);
static const K(sensor) radar_table = SENSOR_TABLE(2, 1, H, R);

TEST_FLOAT(a_const_table_is_a_process)
{
    reading expected, now;
    ASSERT_OK(K(process_init)(&turn.process, table_A, NULL, table_Q));
    for (int t = 0; t < 5; t++) {
        const num z[] = {N(3 * sin(1.7 * t))};
        ASSERT_OK(K(step)(&track, &turn.process, NULL, &radar.sensor, z));
        ASSERT_OK(K(step)(&twin, &table, NULL, &radar_table, z));
        read_filter(&expected, &track, 2);
        read_filter(&now, &twin, 2);
        for (int i = 0; i < 2; i++) {
            ASSERT_CLOSE(expected.mean[i], now.mean[i], 4);
            ASSERT_CLOSE(expected.sigma[i], now.sigma[i], 2);
        }
    }
    ASSERT_OK(K(smooth)(&tape));
    ASSERT_OK(K(smooth)(&right));
    for (size_t t = 0; t < 6; t++) {
        ASSERT_CLOSE(K(mean)(SMOOTHED(&tape, t), 0), K(mean)(SMOOTHED(&right, t), 0), 4);
    }
    ASSERT_OK(K(process_scale_noise)(&other.process, &table, 2));
}
#endif

SUITE(changed, set_up)
#include "changed.tests"
