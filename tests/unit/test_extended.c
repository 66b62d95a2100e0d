/* Steps of nonlinear models: runs, increments, what is refused (test_linearised.c: linear f and h). */
#include "drive.h"
#include "losses.h"
#include "unchanged.h"

FREEZE(calm, 2, 2);

/* A range and a bearing of a target with the state position, velocity in a plane */
#define N4 4
PROCESS(plane, N4, 0);
SENSOR(polar, N4, 2);
FILTER(target, N4);
HISTORY(course, N4, 2, STEPS, STEPS);
JACOBIANS(kept, course, N4, STEPS, STEPS);

PROCESS(changing, 2, 0);
HISTORY(record, 2, MOST, STEPS, STEPS);
JACOBIANS(jacobians, record, 2, STEPS, STEPS);

SENSOR(blank_sensor, 2, 1);
FILTER(blank, 2);
PROCESS(motion3, 3, 0);
ADAPTATION(tuner, 2, 2);
DIFFUSE(begin, 2, 0);
PROCESS(scaled, 2, 1);

static const K(adaptation_rule) rule = {KQ_ADAPT_BOTH, 50, 0.5, 0.25, 4, 0.25, 4};
static const num identity3[] = {1, 0, 0, 0, 1, 0, 0, 0, 1};

static void set_up(void)
{
    begin_drive();
    ASSERT_OK(K(process_init)(&changing, A, NULL, Q));
    ASSERT_OK(K(process_init)(&motion3, identity3, NULL, identity3));
    watch_nothing();
    WATCH(track), WATCH(track_memory), WATCH(changing), WATCH(changing_memory), WATCH(record);
    WATCH(record_memory), WATCH(jacobians), WATCH(jacobians_memory), WATCH(blank), WATCH(blank_memory);
}

/* By A or A2; nobody needs the process any more. */
static void predict_linearised(const num *transition)
{
    static const num d[] = {0.5, -0.25};
    ASSERT_OK(K(process_init)(&changing, transition, NULL, Q));
    ASSERT_OK(K(predict_extended)(&track, &changing, d));
    ASSERT_OK(K(process_init)(&changing, identity3, NULL, Q));
}

/* ------------------------------------------------------------------ a nonlinear run */

static num turn[N4 * N4], slope[2 * N4];

/* Drag: v' = v (1 - |v| / 64), by position and velocity in turn */
static void linearise_motion(const K(filter) * f, num *d)
{
    const num vx = K(mean)(f, 2), vy = K(mean)(f, 3), speed = (num)sqrt((double)(vx * vx + vy * vy));
    for (int k = 0; k < N4 * N4; k++) turn[k] = k % (N4 + 1) == 0;
    d[0] = vx * N(0.1), d[1] = vy * N(0.1), d[2] = -vx * speed / 64, d[3] = -vy * speed / 64;
    turn[2] = turn[7] = N(0.1);
    turn[10] -= (speed + vx * vx / speed) / 64, turn[15] -= (speed + vy * vy / speed) / 64;
    turn[11] = turn[14] = -vx * vy / speed / 64;
    ASSERT_OK(K(process_change_transition)(&plane, turn));
}

static void take_polar(K(filter) * f, double range, double bearing)
{
    const double x = (double)K(mean)(f, 0), y = (double)K(mean)(f, 1), r = sqrt(x * x + y * y);
    const num e[] = {N(range - r), N(bearing - atan2(y, x))};
    memset(slope, 0, sizeof slope);
    slope[0] = N(x / r), slope[1] = N(y / r), slope[N4] = N(-y / r / r), slope[N4 + 1] = N(x / r / r);
    ASSERT_OK(K(sensor_change_measurement)(&polar, slope));
    ASSERT_OK(K(update)(f, &polar, e));
}

static void begin_plane(K(filter) * f)
{
    static const num start[] = {30, -8, -4, 5};
    static num cov[N4 * N4], drift[N4 * N4], r[] = {N(0.04), N(0.0001)};
    for (int i = 0; i < N4; i++) cov[i * (N4 + 1)] = 4, drift[i * (N4 + 1)] = N(0.01);
    ASSERT_OK(K(process_init)(&plane, cov, NULL, drift));
    ASSERT_OK(K(sensor_init_diagonal_extended)(&polar, cov, r));
    ASSERT_OK(K(filter_init)(f, start, cov));
}

static K(process) process_at[STEPS];
static num transition_at[STEPS][N4 * N4];

/* The tape's own processes are those that were kept by hand, to the bit. */
TEST(a_nonlinear_run_is_smoothed_by_each_steps_own_process)
{
    static num expected[STEPS][N4], low[STEPS][N4], cov[STEPS][N4 * N4], P[N4 * N4], d[N4];
    for (int by_hand = 1; by_hand >= 0; by_hand--) {
        begin_plane(&target);
        ASSERT_OK(K(attach)(&target, &kept.attached));
        for (int step = 0; step < STEPS; step++) {
            if (step) {
                linearise_motion(&target, d);
                process_at[step] = plane;
                memcpy(transition_at[step], turn, sizeof turn);
                ASSERT_OK(K(process_change_transition)(&process_at[step], transition_at[step]));
                ASSERT_OK(K(predict_extended)(&target, &plane, d));
            }
            take_polar(&target, 30 - 0.3 * step, -0.26 + 0.05 * step * step);
        }
        for (size_t t = STEPS; by_hand && t-- > 0;) {
            ASSERT_OK(K(smooth_step)(&course, t + 1 < STEPS ? &process_at[t + 1] : NULL, NULL));
        }
        if (!by_hand) ASSERT_OK(K(smooth)(&course));
        for (size_t t = 0; t < STEPS; t++) {
            for (int i = 0; i < N4; i++) {
                if (by_hand) expected[t][i] = K(mean)(SMOOTHED(&course, t), i);
                if (by_hand) low[t][i] = K(mean_low)(SMOOTHED(&course, t), i);
                TEST_ASSERT_TRUE(expected[t][i] == K(mean)(SMOOTHED(&course, t), i));
                TEST_ASSERT_TRUE(low[t][i] == K(mean_low)(SMOOTHED(&course, t), i));
            }
            ASSERT_OK(K(covariance)(SMOOTHED(&course, t), by_hand ? cov[t] : P));
            if (!by_hand) TEST_ASSERT_EQUAL_MEMORY(cov[t], P, sizeof P);
        }
    }
}

/* ------------------------------------------------------------------ an innovation is a measurement of 0 */

static const num at_zero[] = {0, 0}, e[] = {2, -4};

static void begin_at_zero(void)
{
    ASSERT_OK(init_filter(&track, &prior));
    ASSERT_OK(K(filter_init)(&twin, at_zero, P0));
}

/* track is where twin is, but for x0 */
static void assert_shifted(void)
{
    reading expected, actual;
    read_filter(&expected, &twin, 2);
    read_filter(&actual, &track, 2);
    for (int i = 0; i < 2; i++) {
        ASSERT_WITHIN(EPS, (double)x0[i] + (double)expected.mean[i] + (double)expected.low[i],
                      (double)actual.mean[i] + (double)actual.low[i]);
    }
    TEST_ASSERT_EQUAL_MEMORY(expected.P, actual.P, sizeof actual.P);
    TEST_ASSERT_TRUE(expected.nis == actual.nis && expected.run == actual.run);
    TEST_ASSERT_EQUAL_INT(expected.taken, actual.taken);
    TEST_ASSERT_EQUAL_UINT(expected.events, actual.events);
}

/* Of which nothing is there, an update leaves the mean bit for bit. */
TEST(an_innovation_that_is_missing_moves_nothing)
{
    reading before, after;
    begin_at_zero();
    read_filter(&before, &track, 2);
    ASSERT_OK(K(update_subset)(&track, of_innovations(&radar), e, 0));
    read_filter(&after, &track, 2);
    ASSERT_SAME_BITS(before, after);
}

/* e is at the mean that the predict leaves. */
TEST(a_step_is_a_predict_and_an_update)
{
    reading expected, actual;
    for (int step = 0; step < 4; step++) {
        const K(sensor) *differs = of_innovations(&radar);
        ASSERT_OK(K(predict)(&twin, &motion.process, control_of(step)));
        ASSERT_OK(K(update)(&twin, differs, e));
        ASSERT_OK(K(step)(&track, &motion.process, control_of(step), differs, e));
        read_filter(&expected, &twin, 2);
        read_filter(&actual, &track, 2);
        ASSERT_SAME_BITS(expected, actual);
    }
}

TEST(a_lean_sensor_says_what_it_takes_in_part)
{
    SENSOR_DIAGONAL(sharp, 2, 1);
    static const num r[] = {0};
    begin_at_zero();
    ASSERT_OK(K(sensor_init_lean)(&sharp, H, r));
    ASSERT_OK(K(update)(&twin, &sharp, e));
    ASSERT_OK(K(sensor_init_lean_extended)(&sharp, H, r));
    const num before = K(sigma)(&track, 0);
    ASSERT_OK(K(update)(&track, &sharp, e));
    assert_shifted();
    TEST_ASSERT_EQUAL_INT(KQ_EVENT_LOW_NOISE, K(events)(&track));
    TEST_ASSERT_TRUE(K(sigma)(&track, 0) < before);
}

/* ------------------------------------------------------------------ increments */

/* 4096 increments of which a number of 1000 would have nothing */
TEST(an_increment_below_the_last_bit_counts)
{
    const num far[] = {1000, -1000}, step[] = {N(1000 * EPS / 4096), 0};
    ASSERT_OK(K(filter_init)(&track, far, P0));
    for (int k = 0; k < 4096; k++) ASSERT_OK(K(move)(&track, step));
    if (sizeof(num) == 4) ASSERT_WITHIN(1000 * EPS / 64, 1000 + 1000 * EPS, whole_mean(&track, 0));
    TEST_ASSERT_TRUE(K(mean)(&track, 1) == -1000);
    ASSERT_OK(K(filter_init)(&track, far, P0));
    ASSERT_OK(K(process_change_transition)(&changing, A));
    for (int k = 0; k < 16; k++) ASSERT_OK(K(predict_extended)(&track, &changing, step));
    if (sizeof(num) == 4) ASSERT_WITHIN(1000 * EPS / 4096, 1000 + 1000 * EPS / 256, whole_mean(&track, 0));
}

TEST(a_move_leaves_all_but_the_mean)
{
    const num there[] = {-1, 2};
    reading before, after;
    measure(&track, 0);
    read_filter(&before, &track, 2);
    ASSERT_OK(K(move)(&track, there));
    read_filter(&after, &track, 2);
    for (int i = 0; i < 2; i++) {
        ASSERT_CLOSE((double)before.mean[i] + (double)there[i], (double)after.mean[i] + (double)after.low[i], 4);
        before.mean[i] = after.mean[i], before.low[i] = after.low[i];
    }
    TEST_ASSERT_EQUAL_MEMORY(&before, &after, sizeof after);
}

/* ------------------------------------------------------------------ refusals */

TEST(an_init_refuses_as_the_plain_one)
{
    const num less[] = {-1}, wild[] = {(num)NAN};
    K(sensor) nothing;
    memset(&nothing, 0, sizeof nothing);
    ASSERT_REFUSED(KQ_ERR_NULL, K(sensor_init_extended)(NULL, H, R));
    ASSERT_REFUSED(KQ_ERR_NULL, K(sensor_init_diagonal_extended)(&blank_sensor, NULL, R));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(sensor_init_lean_extended)(&nothing, H, R));
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(sensor_init_extended)(&blank_sensor, H, wild));
    ASSERT_REFUSED(KQ_ERR_NOT_SEMIDEFINITE, K(sensor_init_diagonal_extended)(&blank_sensor, H, less));
    ASSERT_REFUSED(KQ_ERR_NOT_SEMIDEFINITE, K(sensor_init_lean_extended)(&blank_sensor, H, less));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(update)(&track, &blank_sensor, H));
}

/* What is no filter's and no process's number of states is not read. */
TEST(an_increment_has_no_more_entries_than_both_have_states)
{
    const num d[] = {0, 0, N(NAN), N(NAN)};
    begin_plane(&target);
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(predict_extended)(&target, &changing, d));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(predict_extended)(&track, &motion3, d + 2));
}

/* The move that takes it there says so, and the measurements that follow bring the state back. */
TEST(a_mean_that_is_moved_beyond_the_numbers_is_held_at_once)
{
    const num most = NUM_MAX / 2, far[] = {most, 0}, z[] = {2, -4};
    num e_then[2];
    ASSERT_OK(K(attach)(&track, &jacobians.attached));
    for (int k = 0; k < 3; k++) ASSERT_OK(K(move)(&track, far));
    TEST_ASSERT_EQUAL_UINT(KQ_EVENT_OVERFLOW | KQ_EVENT_HISTORY_FULL, K(events)(&track));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_HISTORY_FULL, K(smooth)(&record));
    TEST_ASSERT_TRUE(K(mean)(&track, 0) == 0);
    TEST_ASSERT_TRUE((double)K(sigma)(&track, 0) >= MOST_SIGMA * 0x1p-16);
    ASSERT_OK(K(innovation)(&track, &radar.sensor, z, e_then));
    ASSERT_OK(K(update)(&track, of_innovations(&radar), e_then));
    TEST_ASSERT_TRUE(K(sigma)(&track, 0) < 8);
}

TEST(what_learns_from_the_mean_or_moves_it_is_refused)
{
    const num d[] = {1, 2};
    K(loss) gate = {.kind = &K(loss_gate), .limit = 12};
    const K(sensor) *differs = of_innovations(&radar);
    for (int k = 0; k < 3; k++) {
        if (k == 0) ASSERT_OK(K(adaptation_init)(&tuner, &motion.process, &radar.sensor, &rule));
        if (k == 1) ASSERT_OK(K(adaptation_init)(&tuner, &motion.process, differs, &rule));
        if (k < 2) ASSERT_OK(K(attach)(&track, &tuner.attached));
        if (k == 2) ASSERT_OK(K(freeze_init)(&calm, 10));
        if (k == 2) ASSERT_OK(K(attach)(&track, &calm.attached));
        ASSERT_REFUSED(KQ_ERR_RECORDING, K(predict_extended)(&track, &changing, d));
        ASSERT_REFUSED(KQ_ERR_RECORDING, K(update)(&track, differs, d));
        ASSERT_REFUSED(KQ_ERR_RECORDING, K(update_subset)(&track, differs, d, 1));
        ASSERT_REFUSED(KQ_ERR_RECORDING, K(step)(&track, &motion.process, NULL, differs, d));
        ASSERT_REFUSED(KQ_ERR_RECORDING, K(update_robust)(&track, differs, d, 3, &gate));
        ASSERT_REFUSED(KQ_ERR_RECORDING, update_huber(&track, differs, d, 3, 3, NULL));
        ASSERT_REFUSED(KQ_ERR_RECORDING, update_student(&track, differs, d, 3, 4, NULL));
        ASSERT_REFUSED(KQ_ERR_RECORDING, update_jump(&track, differs, d, 3, 9));
        ASSERT_REFUSED(KQ_ERR_RECORDING, K(move)(&track, d));
        if (k < 2) ASSERT_OK(K(detach)(&tuner.attached));
        else ASSERT_OK(K(detach)(&calm.attached));
    }
    ASSERT_OK(K(predict_extended)(&track, &changing, d));
}

TEST(a_history_that_keeps_no_jacobians_refuses_linearised_predicts)
{
    const num d[] = {1, 2};
    ASSERT_OK(K(attach)(&track, &tape.attached));
    ASSERT_REFUSED(KQ_ERR_RECORDING, K(predict_extended)(&track, &changing, d));
    ASSERT_OK(K(update)(&track, of_innovations(&radar), d));
    ASSERT_OK(K(predict)(&track, &changing, NULL));
    ASSERT_OK(K(smooth)(&tape));
}

TEST(a_start_that_is_over_is_in_nobodys_way)
{
    const num d[] = {1, 2};
    ASSERT_OK(K(diffuse_init)(&begin, &track, x0, P0, 3));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(predict_extended)(&track, &changing, d));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(update)(&track, of_innovations(&radar), d));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(step)(&track, &motion.process, NULL, of_innovations(&radar), d));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, update_jump(&track, of_innovations(&radar), d, 3, 9));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(attach)(&track, &jacobians.attached));
    ASSERT_OK(K(update)(&track, &radar.sensor, d));
    TEST_ASSERT_EQUAL_INT(0, K(diffuse_count)(&begin));
    ASSERT_OK(K(update)(&track, of_innovations(&radar), d));
    ASSERT_OK(K(predict_extended)(&track, &changing, d));
    ASSERT_OK(K(attach)(&track, &jacobians.attached));
}

TEST(a_process_that_changes_between_plain_predicts_is_noticed)
{
    ASSERT_OK(K(attach)(&track, &jacobians.attached));
    predict_linearised(A);
    ASSERT_OK(K(process_change_transition)(&changing, A));
    ASSERT_OK(K(predict)(&track, &changing, NULL));
    ASSERT_OK(K(process_change_transition)(&changing, A2));
    ASSERT_OK(K(predict)(&track, &changing, NULL));
    predict_linearised(A2);
    ASSERT_REFUSED(KQ_ERR_CHANGED, K(smooth)(&record));
}

TEST(one_process_for_all_steps_smooths_no_linearised_tape)
{
    num q[STEPS] = {1, 1, 1};
    ASSERT_OK(K(attach)(&track, &jacobians.attached));
    predict_linearised(A);
    predict_linearised(A2);
    ASSERT_REFUSED(KQ_ERR_RECORDING, K(smooth_reweighted)(&record, &scaled, &motion.process, 4, q));
    ASSERT_OK(K(smooth)(&record));
}

TEST(a_keeper_that_is_full_ends_the_recording)
{
    static num few[JACOBIANS_LEN(2, 2, 1)];
    static K(process) two[2];
    static K(jacobians) small;
    const num d[] = {0, 0};
    for (int changes = 0; changes < 2; changes++) { /* of A more than two; of Q more than one */
        begin_drive();
        ASSERT_OK(K(jacobians_assign)(&small, &record, 2, two, 2, few, COUNT(few)));
        ASSERT_OK(K(attach)(&track, &small.attached));
        ASSERT_OK(K(process_init)(&changing, A, NULL, Q));
        ASSERT_OK(K(predict_extended)(&track, &changing, d));
        if (changes) ASSERT_OK(K(process_init)(&changing, A, NULL, Q2));
        ASSERT_OK(K(predict_extended)(&track, &changing, d));
        TEST_ASSERT_EQUAL_UINT(changes ? KQ_EVENT_HISTORY_FULL : 0, K(events)(&track));
        ASSERT_OK(K(predict_extended)(&track, &changing, d));
        TEST_ASSERT_EQUAL_UINT(KQ_EVENT_HISTORY_FULL, K(events)(&track));
        TEST_ASSERT_EQUAL_INT(KQ_ERR_HISTORY_FULL, K(smooth)(&record));
    }
}

TEST(a_copy_of_a_filter_records_nothing)
{
    const num d[] = {0, 0};
    ASSERT_OK(K(attach)(&track, &jacobians.attached));
    ASSERT_OK(K(predict_extended)(&track, &changing, d));
    K(filter) assigned = track;
    ASSERT_OK(K(predict_extended)(&assigned, &changing, d));
    TEST_ASSERT_EQUAL_UINT(KQ_EVENT_HISTORY_FULL, K(events)(&assigned));
    TEST_ASSERT_EQUAL_UINT(0, K(events)(&track));
    TEST_ASSERT_EQUAL_UINT(2, K(history_steps)(&record));
}

SUITE(extended, set_up)
#include "extended.tests"
