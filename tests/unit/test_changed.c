/*
 * A process that has changed since a history recorded it is not smoothed with.  The recording is of
 * a coordinated turn whose A is made anew at every step, in place: the loop of an extended filter.
 */
#include "reading.h"
#include "unchanged.h"

#define STEPS 20

PROCESS(turn, 2, 0);
PROCESS(other, 2, 0);
SENSOR(radar, 2, 1);
FILTER(track, 2);
FILTER(twin, 2);
HISTORY(tape, 2, 1, STEPS, STEPS);
HISTORY(right, 2, 1, STEPS, STEPS);
LAG(past, 2, 1, STEPS);
INSTANT(instant, 2, 1);
static K(filter) past_view, instant_view;
START(start, 2, 4);

static K(process) apart[STEPS];
static num apart_A[STEPS][4], apart_memory[STEPS][KQ_PROCESS_LEN(2)];
static num A[4];
static const num Q[] = {0.25, 0.125, 0.125, 0.5}, Q2[] = {1, 0, 0, 0};
static const num H[] = {1, 0.25}, R[] = {0.5};
static const num x0[] = {1, -2}, P0[] = {2, 0.5, 0.5, 1};

/* A rotation, at each step by another angle */
static void put_turn(num *to, int step)
{
    const double angle = 0.3 + 0.1 * step;
    to[0] = to[3] = N(cos(angle));
    to[1] = N(-sin(angle));
    to[2] = -to[1];
}

static void set_up(void)
{
    put_turn(A, 0);
    ASSERT_OK(K(process_init)(&turn, A, NULL, Q));
    ASSERT_OK(K(process_init)(&other, A, NULL, Q2));
    ASSERT_OK(K(sensor_init)(&radar, H, R));
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    ASSERT_OK(K(filter_init)(&twin, x0, P0));
    ASSERT_OK(K(history_assign)(&tape, 2, tape_memory, COUNT(tape_memory)));
    ASSERT_OK(K(history_assign)(&right, 2, right_memory, COUNT(right_memory)));
    ASSERT_OK(K(attach)(&track, &tape.attached));
    ASSERT_OK(K(attach)(&twin, &right.attached));
    watch_nothing();
    WATCH(track), WATCH(track_memory), WATCH(tape), WATCH(tape_memory), WATCH(turn), WATCH(other);
}

static void measure(K(filter) * f, int step)
{
    const num z[] = {N(3 * sin(1.7 * step))};
    ASSERT_OK(K(update)(f, &radar, z));
}

static void change(int step)
{
    put_turn(A, step);
    ASSERT_OK(K(process_change_transition)(&turn, A));
}

/* The process of each step for itself: what is right */
static void run_apart(K(filter) * f)
{
    for (int t = 0; t < STEPS; t++) {
        put_turn(apart_A[t], t);
        ASSERT_OK(K(process_assign)(&apart[t], 2, 0, apart_memory[t], COUNT(apart_memory[t])));
        ASSERT_OK(K(process_init)(&apart[t], apart_A[t], NULL, Q));
        if (t) ASSERT_OK(K(predict)(f, &apart[t], NULL));
        measure(f, t);
    }
}

static void run_in_place(K(filter) * f)
{
    for (int t = 0; t < STEPS; t++) {
        change(t);
        if (t) ASSERT_OK(K(predict)(f, &turn, NULL));
        measure(f, t);
    }
}

static void run_constant(K(filter) * f, const K(process) * p)
{
    for (int t = 0; t < 5; t++) {
        if (t) ASSERT_OK(K(predict)(f, p, NULL));
        measure(f, t);
    }
}

/* Refused in every way, as a whole; but the last step needs no process. */
static void assert_changed(void)
{
    ASSERT_REFUSED(KQ_ERR_CHANGED, K(smooth)(&tape));
    ASSERT_REFUSED(KQ_ERR_CHANGED, K(smooth_states)(&tape));
    ASSERT_OK(K(smooth_step)(&tape, NULL, NULL));
    ASSERT_REFUSED(KQ_ERR_CHANGED, K(smooth_step)(&tape, NULL, NULL));
}

static void assert_smooth_again(void)
{
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    ASSERT_OK(K(attach)(&track, &tape.attached));
    run_constant(&track, &turn);
    ASSERT_OK(K(smooth)(&tape));
}

/* ------------------------------------------------------------------------------- tapes */

static void a_process_changed_at_every_step_is_refused(void)
{
    run_in_place(&track);
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&track));
    assert_changed();
    assert_smooth_again();
}

static void with_the_process_of_each_step_it_is_smoothed(void)
{
    reading expected, now;
    run_in_place(&track);
    run_apart(&twin);
    ASSERT_OK(K(smooth)(&right));
    ASSERT_OK(K(smooth_step)(&tape, NULL, NULL));
    for (int t = STEPS - 1; t > 0; t--) {
        if (t % 2) change(t);
        ASSERT_OK(K(smooth_step)(&tape, t % 2 ? &turn : &apart[t], NULL));
    }
    for (size_t t = 0; t < STEPS; t++) {
        read_smoothed(&expected, &right, t, 2);
        read_smoothed(&now, &tape, t, 2);
        ASSERT_SAME_BITS(expected, now);
    }
}

static void changed_between_two_predicts(void)
{
    for (int changed = 1; changed < 5; changed++) {
        set_up();
        for (int t = 0; t < 6; t++) {
            if (t == changed) change(t);
            ASSERT_OK(K(predict)(&track, &turn, NULL));
            measure(&track, t);
        }
        if (changed < 3) change(0);
        assert_changed();
    }
}

static void changed_after_the_recording(void)
{
    run_constant(&track, &turn);
    change(1);
    ASSERT_REFUSED(KQ_ERR_CHANGED, K(smooth)(&tape));
    change(0); /* as it was */
    ASSERT_OK(K(smooth)(&tape));
}

static void changed_while_it_is_smoothed(void)
{
    run_constant(&track, &turn);
    for (int k = 0; k < 3; k++) ASSERT_OK(K(smooth_step)(&tape, NULL, NULL));
    change(1);
    ASSERT_REFUSED(KQ_ERR_CHANGED, K(smooth_step)(&tape, NULL, NULL));
    change(0);
    for (int k = 3; k < 5; k++) ASSERT_OK(K(smooth_step)(&tape, NULL, NULL));
}

/* One of two that take turns changes while it is not in use, or has no more use. */
static void changed_while_another_was_in_use(void)
{
    for (int changed = 0; changed < 6; changed++) {
        set_up();
        for (int t = 0; t < 6; t++) {
            ASSERT_OK(K(predict)(&track, t / 2 % 2 ? &other : &turn, NULL));
            measure(&track, t);
            if (t == changed) change(7);
        }
        ASSERT_REFUSED(KQ_ERR_CHANGED, K(smooth)(&tape));
        if (changed == 5) change(0), ASSERT_OK(K(smooth)(&tape));
    }
}

static void the_same_a_again_is_no_change(void)
{
    static num again[4];
    for (int t = 0; t < 5; t++) {
        put_turn(again, 0);
        ASSERT_OK(K(process_change_transition)(&turn, t % 2 ? A : again));
        ASSERT_OK(K(predict)(&track, &turn, NULL));
        measure(&track, t);
    }
    ASSERT_OK(K(smooth)(&tape));
}

/* ------------------------------------------------------------------- whatever changes it */

static void another_init(void)
{
    run_constant(&track, &turn);
    ASSERT_OK(K(process_init)(&turn, A, NULL, Q2));
    ASSERT_REFUSED(KQ_ERR_CHANGED, K(smooth)(&tape));
    ASSERT_OK(K(process_assign)(&turn, 2, 0, turn_memory, COUNT(turn_memory)));
    ASSERT_OK(K(process_init_factor)(&turn, A, NULL, Q, 2));
    ASSERT_REFUSED(KQ_ERR_CHANGED, K(smooth)(&tape));
    ASSERT_OK(K(process_init)(&turn, A, NULL, Q));
    ASSERT_OK(K(smooth)(&tape));
}

static void an_assigned_struct(void)
{
    const K(process) before = turn;
    run_constant(&track, &turn);
    turn = other;
    ASSERT_REFUSED(KQ_ERR_CHANGED, K(smooth)(&tape));
    turn = before;
    ASSERT_OK(K(smooth)(&tape));
}

/* A copy of a process, with its own A at every step */
static void a_copy_that_is_changed(void)
{
    K(process) now;
    for (int t = 0; t < 5; t++) {
        now = turn;
        put_turn(A, t);
        ASSERT_OK(K(process_change_transition)(&now, A));
        ASSERT_OK(K(predict)(&track, &now, NULL));
        measure(&track, t);
    }
    ASSERT_REFUSED(KQ_ERR_CHANGED, K(smooth)(&tape));
    ASSERT_OK(K(detach)(&tape.attached));
}

static void scaled_noise(void)
{
    ASSERT_OK(K(process_scale_noise)(&other, &turn, 4));
    run_constant(&track, &other);
    ASSERT_OK(K(process_scale_noise)(&other, &turn, 5));
    ASSERT_REFUSED(KQ_ERR_CHANGED, K(smooth)(&tape));
    ASSERT_OK(K(process_scale_noise)(&other, &turn, 1));
    ASSERT_REFUSED(KQ_ERR_CHANGED, K(smooth)(&tape));
    ASSERT_OK(K(process_scale_noise)(&other, &turn, 4));
    ASSERT_OK(K(smooth)(&tape));
}

/* As of Student's steps, whose history is smoothed with the scales */
static void noise_scaled_at_every_step(void)
{
    num q[4];
    for (int t = 0; t < 5; t++) {
        if (t) {
            q[t - 1] = N(1 + t);
            ASSERT_OK(K(process_scale_noise)(&other, &turn, q[t - 1]));
            ASSERT_OK(K(predict)(&track, &other, NULL));
        }
        measure(&track, t);
    }
    ASSERT_REFUSED(KQ_ERR_CHANGED, K(smooth)(&tape));
    ASSERT_OK(K(smooth_reweighted)(&tape, &other, &turn, 2, q));
}

/* Signs, exchanges, last bits and powers of 2, of each entry and of two at once */
static void every_entry_counts(void)
{
    static const num factor[] = {-1, 2, 0.5, 4, 0, N(1 + EPS)};
    num first[4];
    run_constant(&track, &turn);
    memcpy(first, A, sizeof A);
    for (int k = 0; k < 4; k++) {
        for (int j = 0; j < 4; j++) {
            for (int by = 0; by < COUNT(factor); by++) {
                A[k] = first[k] * factor[by];
                A[j] = j == k ? A[k] : first[j] * factor[COUNT(factor) - 1 - by];
                ASSERT_OK(K(process_change_transition)(&turn, A));
                ASSERT_REFUSED(KQ_ERR_CHANGED, K(smooth)(&tape));
                memcpy(A, first, sizeof A);
            }
            if (A[j] == A[k]) continue;
            A[j] = first[k], A[k] = first[j];
            ASSERT_OK(K(process_change_transition)(&turn, A));
            ASSERT_REFUSED(KQ_ERR_CHANGED, K(smooth)(&tape));
            memcpy(A, first, sizeof A);
        }
    }
    ASSERT_OK(K(process_change_transition)(&turn, A));
    ASSERT_OK(K(smooth)(&tape));
}

/* ------------------------------------------------------------------------------ on line */

/* Nothing of a process is kept: it may change in place at every step. */
static void a_lag_takes_the_process_as_it_was(void)
{
    reading expected;
    run_apart(&twin);
    ASSERT_OK(K(smooth)(&right));
    ASSERT_OK(K(attach)(&track, &past.attached));
    for (int t = 0; t < STEPS; t++) {
        change(t);
        if (t) ASSERT_OK(K(predict)(&track, &turn, NULL));
        measure(&track, t);
    }
    change(0);
    for (size_t k = 0; k < STEPS; k++) {
        ASSERT_OK(K(lagged)(&past, k, &past_view));
        read_smoothed(&expected, &right, STEPS - 1 - k, 2);
        for (int i = 0; i < 2; i++) {
            ASSERT_CLOSE(expected.mean[i], K(mean)(&past_view, i), 8);
            ASSERT_CLOSE(expected.sigma[i], K(sigma)(&past_view, i), 2);
        }
    }
}

static void a_point_takes_the_process_as_it_was(void)
{
    reading expected;
    run_apart(&twin);
    ASSERT_OK(K(smooth)(&right));
    ASSERT_OK(K(attach)(&track, &instant.attached));
    for (int t = 0; t < STEPS; t++) {
        change(t);
        if (t) ASSERT_OK(K(predict)(&track, &turn, NULL));
        measure(&track, t);
    }
    change(0);
    ASSERT_OK(K(instant_smooth)(&instant, &instant_view));
    read_smoothed(&expected, &right, 0, 2);
    for (int i = 0; i < 2; i++) {
        ASSERT_CLOSE(expected.mean[i], K(mean)(&instant_view, i), 8);
        ASSERT_CLOSE(expected.sigma[i], K(sigma)(&instant_view, i), 2);
    }
}

/* The steps before the state is known need no process afterwards, the tape's do. */
static void a_start_smooths_what_has_not_changed(void)
{
    for (int changed = 0; changed < 5; changed++) {
        set_up();
        ASSERT_OK(K(detach)(&tape.attached));
        ASSERT_OK(K(diffuse_init)(&start, &track, x0, NULL, 3));
        ASSERT_OK(K(attach)(&track, &tape.attached));
        for (int t = 0; t < 5; t++) {
            const num z[] = {N(3 * sin(1.7 * t))};
            if (t == changed) change(t + 1);
            if (t) ASSERT_OK(K(predict)(&track, &turn, NULL));
            ASSERT_OK(K(update)(&track, &radar, z));
        }
        const int early = (int)K(diffuse_steps)(&start, NULL);
        TEST_ASSERT_EQUAL_INT(1, early);
        if (changed > early + 1) ASSERT_REFUSED(KQ_ERR_CHANGED, K(diffuse_smooth)(&start));
        else ASSERT_OK(K(diffuse_smooth)(&start));
    }
}

/* --------------------------------------------------------------------- tables in flash */

/* The root of Q, by columns: {{0.5, 0.25}, {0, 0.5}} times its transpose */
static const num table_A[] = {1, 0.5, 0, 1}, table_G[] = {0.5, 0.25, 0.5};
static const num table_Q[] = {0.3125, 0.125, 0.125, 0.25};
static const K(process) table = KQ_PROCESS_TABLE(2, 0, table_A, NULL, table_G);
static const K(sensor) radar_table = SENSOR_TABLE(2, 1, H, R);

static void a_const_table_is_a_process(void)
{
    reading expected, now;
    ASSERT_OK(K(process_init)(&turn, table_A, NULL, table_Q));
    for (int t = 0; t < 5; t++) {
        const num z[] = {N(3 * sin(1.7 * t))};
        ASSERT_OK(K(step)(&track, &turn, NULL, &radar, z));
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
    ASSERT_OK(K(process_scale_noise)(&other, &table, 2));
}

SUITE(changed, set_up)
{
    RUN_TEST(a_process_changed_at_every_step_is_refused);
    RUN_TEST(with_the_process_of_each_step_it_is_smoothed);
    RUN_TEST(changed_between_two_predicts);
    RUN_TEST(changed_after_the_recording);
    RUN_TEST(changed_while_it_is_smoothed);
    RUN_TEST(changed_while_another_was_in_use);
    RUN_TEST(the_same_a_again_is_no_change);
    RUN_TEST(another_init);
    RUN_TEST(an_assigned_struct);
    RUN_TEST(a_copy_that_is_changed);
    RUN_TEST(scaled_noise);
    RUN_TEST(noise_scaled_at_every_step);
    RUN_TEST(every_entry_counts);
    RUN_TEST(a_lag_takes_the_process_as_it_was);
    RUN_TEST(a_point_takes_the_process_as_it_was);
    RUN_TEST(a_start_smooths_what_has_not_changed);
    RUN_TEST(a_const_table_is_a_process);
}
