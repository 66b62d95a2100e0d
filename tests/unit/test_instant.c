/* The fixed-point smoother. */
#include "drive.h"
#include "sizes.h"
#include "unchanged.h"

INSTANT(start, 2, MOST);
static K(filter) start_view, no_view;

/* never initialised, and of another size */
FILTER(blank, 2);
PROCESS(blank_process, 2, 1);
SENSOR(blank_sensor, 2, 1);
INSTANT(unused, 2, 1);
FILTER(track3, 3);
PROCESS(motion3, 3, 0);
INSTANT(start3, 3, 1);

static const num identity3[] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, zero3[3];

static void attach(void)
{
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    ASSERT_OK(K(instant_assign)(&start, 2, MOST, start_memory, COUNT(start_memory)));
    ASSERT_OK(K(attach)(&track, &start.attached));
}

static void set_up(void)
{
    begin_drive();
    ASSERT_OK(K(process_init)(&motion3, identity3, NULL, identity3));
    ASSERT_OK(K(filter_init)(&track3, zero3, identity3));
    attach();
    watch_nothing();
    WATCH(track), WATCH(track_memory), WATCH(start), WATCH(start_memory), WATCH(motion);
    WATCH(blank), WATCH(blank_memory), WATCH(unused), WATCH(start3), WATCH(start3_memory);
    WATCH(track3), WATCH(track3_memory), WATCH(motion_memory);
}

static void assert_read(const reading *expected, const reading *actual)
{
    for (int i = 0; i < 2; i++) {
        ASSERT_CLOSE((double)expected->mean[i] + (double)expected->low[i],
                     (double)actual->mean[i] + (double)actual->low[i], 8);
        ASSERT_CLOSE(expected->sigma[i], actual->sigma[i], 2);
    }
    for (int k = 0; k < 4; k++) ASSERT_CLOSE(expected->P[k], actual->P[k], 2);
    TEST_ASSERT_EQUAL_MEMORY(&actual->P[1], &actual->P[2], sizeof(num));
}

/* The step with the number `step`, but for its last predict */
static void drive(int step)
{
    if (step) ASSERT_OK(K(predict)(&track, process_of(step), control_of(step)));
    measure(&track, step);
}

/* --------------------------------------------------------------------------- what it is */

/* Attached before or after the measurements of the step s: it is the tape's step s. */
static void an_instant_is_that_of_the_tape(void)
{
    reading expected, now;
    for (int s = 0; s < STEPS; s += 5) {
        for (int after = 0; after < 2; after++) {
            ASSERT_OK(K(filter_init)(&track, x0, P0));
            for (int step = 0; step < STEPS; step++) {
                if (step > s) {
                    ASSERT_OK(K(predict)(&track, process_of(step), control_of(step)));
                } else if (step) {
                    ASSERT_OK(K(predict)(&track, process_of(step), control_of(step)));
                }
                if (step == s && !after) ASSERT_OK(K(attach)(&track, &start.attached));
                measure(&track, step);
                if (step == s && after) ASSERT_OK(K(attach)(&track, &start.attached));
                if (step < s) continue;
                smooth_to(step);
                read_smoothed(&expected, &tape, (size_t)s, 2);
                ASSERT_OK(K(instant_smooth)(&start, &start_view));
                read_view(&now, &start_view, 2);
                assert_read(&expected, &now);
            }
        }
    }
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&track));
}

static void the_filter_is_the_same_with_an_instant(void)
{
    for (int step = 0; step < STEPS; step++) {
        drive(step);
        if (step) ASSERT_OK(K(predict)(&twin, process_of(step), control_of(step)));
        measure(&twin, step);
        ASSERT_OK(K(instant_smooth)(&start, &start_view));
        ASSERT_SAME_FILTER(&twin, &track, 2);
        TEST_ASSERT_EQUAL_MEMORY(twin_memory, track_memory, sizeof track_memory);
    }
}

static const num *z_of(int step)
{
    static num z[2];
    z[0] = N(0.75 * (step % 5) - 1), z[1] = N(2 - 0.5 * (step % 7));
    return z;
}

static void a_step_is_predict_and_update(void)
{
    reading expected, now;
    INSTANT(beside, 2, MOST);
    K(filter) beside_view;
    ASSERT_OK(K(attach)(&twin, &beside.attached));
    for (int step = 0; step < STEPS; step++) {
        ASSERT_OK(K(step)(&track, process_of(step), control_of(step), &radar, z_of(step)));
        ASSERT_OK(K(predict)(&twin, process_of(step), control_of(step)));
        ASSERT_OK(K(update)(&twin, &radar, z_of(step)));
        ASSERT_SAME_FILTER(&twin, &track, 2);
        TEST_ASSERT_EQUAL_MEMORY(twin_memory, track_memory, sizeof track_memory);
        ASSERT_OK(K(instant_smooth)(&beside, &beside_view));
        read_view(&expected, &beside_view, 2);
        ASSERT_OK(K(instant_smooth)(&start, &start_view));
        read_view(&now, &start_view, 2);
        ASSERT_SAME_BITS(expected, now);
    }
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&track));
}

static void asking_changes_nothing(void)
{
    reading often, once;
    for (int step = 0; step < STEPS; step++) {
        drive(step);
        ASSERT_OK(K(instant_smooth)(&start, &start_view));
    }
    read_view(&often, &start_view, 2);
    attach();
    for (int step = 0; step < STEPS; step++) drive(step);
    ASSERT_OK(K(instant_smooth)(&start, &start_view));
    ASSERT_OK(K(instant_smooth)(&start, &start_view));
    read_view(&once, &start_view, 2);
    ASSERT_SAME_BITS(often, once);
}

static void an_answer_stays_until_the_next_one(void)
{
    reading now, later;
    for (int step = 0; step < 4; step++) drive(step);
    ASSERT_OK(K(instant_smooth)(&start, &start_view));
    read_view(&now, &start_view, 2);
    for (int step = 4; step < 12; step++) drive(step);
    read_view(&later, &start_view, 2);
    ASSERT_SAME_BITS(now, later);
}

/* Long after, measurements say nothing more of the instant, and rounding does not add up. */
static void a_long_run_changes_nothing_any_more(void)
{
    reading early, late;
    for (int step = 0; step < 100; step++) drive(step);
    ASSERT_OK(K(instant_smooth)(&start, &start_view));
    read_view(&early, &start_view, 2);
    for (int step = 100; step < 3000; step++) drive(step);
    ASSERT_OK(K(instant_smooth)(&start, &start_view));
    read_view(&late, &start_view, 2);
    assert_read(&early, &late);
}

/* The same constant, through no process noise: the start is known as now. */
static void a_constant_is_known_as_now(void)
{
    static const num still[] = {1, 0, 0, 1}, none[4], z[] = {3, -1};
    ASSERT_OK(K(process_init)(&motion, still, B, none));
    for (int step = 0; step < STEPS; step++) {
        if (step) ASSERT_OK(K(predict)(&track, &motion, NULL));
        ASSERT_OK(K(update)(&track, &radar, z));
        ASSERT_OK(K(instant_smooth)(&start, &start_view));
        for (int i = 0; i < 2; i++) {
            ASSERT_CLOSE(K(mean)(&track, i), K(mean)(&start_view, i), 8);
            ASSERT_CLOSE(K(sigma)(&track, i), K(sigma)(&start_view, i), 1);
        }
    }
}

/* ------------------------------------------------------------------------------- limits */

static num wide_room[GUARDED(INSTANT_LEN(16, 16))];
static num wide_filter[FILTER_LEN(16)], wide_P[256], wide_A[256], wide_Q[256];
PROCESS(wide_process, 16, 0);
SENSOR_DIAGONAL(wide_sensor, 16, 16);

/* Scalars of n = 1 side by side are what each of them is alone. */
static void sixteen_states_are_sixteen_scalars(void)
{
    static const num a = 0.5, q = 0.75, r = 2, p = 3, zero[16];
    static num z[16], ones[16], scalar_memory[FILTER_LEN(1)], line_memory[INSTANT_LEN(1, 1)];
    K(filter) wide, scalar;
    K(instant) instant, line;
    K(filter) instant_view, line_view;
    PROCESS(scalar_process, 1, 0);
    SENSOR(scalar_sensor, 1, 1);
    num *memory = guard(wide_room, sizeof wide_room / sizeof(num));
    for (int i = 0; i < 16; i++) ones[i] = r;
    ASSERT_OK(K(process_init)(&scalar_process, &a, NULL, &q));
    ASSERT_OK(K(sensor_init)(&scalar_sensor, (const num[]){1}, &r));
    ASSERT_OK(K(filter_assign)(&scalar, 1, scalar_memory, COUNT(scalar_memory)));
    put_identity(wide_A, 16, a), put_identity(wide_Q, 16, q), put_identity(wide_P, 16, p);
    ASSERT_OK(K(process_init)(&wide_process, wide_A, NULL, wide_Q));
    ASSERT_OK(K(filter_assign)(&wide, 16, wide_filter, COUNT(wide_filter)));
    ASSERT_OK(K(filter_init)(&wide, zero, wide_P));
    put_identity(wide_P, 16, 1);
    ASSERT_OK(K(sensor_init_diagonal)(&wide_sensor, wide_P, ones));
    ASSERT_OK(K(instant_assign)(&instant, 16, 16, memory, INSTANT_LEN(16, 16)));
    ASSERT_OK(K(attach)(&wide, &instant.attached));
    for (int step = 0; step < 5; step++) {
        if (step) ASSERT_OK(K(predict)(&wide, &wide_process, NULL));
        for (int i = 0; i < 16; i++) z[i] = N((i * 5 + step * 3) % 11 - 5);
        ASSERT_OK(K(update)(&wide, &wide_sensor, z));
    }
    ASSERT_OK(K(instant_smooth)(&instant, &instant_view));
    ASSERT_OK(K(covariance)(&instant_view, wide_P));
    for (int i = 0; i < 16; i++) {
        ASSERT_OK(K(filter_init)(&scalar, zero, &p));
        ASSERT_OK(K(instant_assign)(&line, 1, 1, line_memory, COUNT(line_memory)));
        ASSERT_OK(K(attach)(&scalar, &line.attached));
        for (int step = 0; step < 5; step++) {
            const num one = N((i * 5 + step * 3) % 11 - 5);
            if (step) ASSERT_OK(K(predict)(&scalar, &scalar_process, NULL));
            ASSERT_OK(K(update)(&scalar, &scalar_sensor, &one));
        }
        ASSERT_OK(K(instant_smooth)(&line, &line_view));
        ASSERT_CLOSE(K(mean)(&line_view, 0), K(mean)(&instant_view, i), 8);
        const double sigma = (double)K(sigma)(&line_view, 0);
        for (int j = 0; j < 16; j++) {
            ASSERT_CLOSE(i == j ? sigma * sigma : 0, wide_P[i * 16 + j], 4);
        }
    }
    assert_guards(wide_room, INSTANT_LEN(16, 16), sizeof wide_room / sizeof(num));
}

/* ---------------------------------------------------------------------------- refusals */

static void assign_refuses(void)
{
    static const int bad[] = {0, -1, 17, 258, -254, INT_MAX, INT_MIN};
    const size_t least = INSTANT_LEN(2, 1);
    ASSERT_REFUSED(KQ_ERR_NULL, K(instant_assign)(NULL, 2, 1, start_memory, 1000));
    ASSERT_REFUSED(KQ_ERR_NULL, K(instant_assign)(&start, 2, 1, NULL, 1000));
    for (int k = 0; k < COUNT(bad); k++) {
        ASSERT_REFUSED(KQ_ERR_SIZE, K(instant_assign)(&start, bad[k], 1, start_memory, SIZE_MAX));
    }
    ASSERT_REFUSED(KQ_ERR_SIZE, K(instant_assign)(&start, 2, 0, start_memory, SIZE_MAX));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(instant_assign)(&start, 2, -1, start_memory, SIZE_MAX));
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(instant_assign)(&start, 2, 1, start_memory, least - 1));
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(instant_assign)(&start, 2, INT_MAX, start_memory, least));
    ASSERT_OK(K(instant_assign)(&start, 2, 1, start_memory, least));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(instant_smooth)(&start, &no_view));
}

/* The length is a little more than a multiple of 2^16 or 2^32: as a size_t of so many bits it is
   short. */
static void a_length_that_would_wrap_is_refused(void)
{
    const int64_t each = INSTANT_LEN(2, 2) - INSTANT_LEN(2, 1), others = INSTANT_LEN(2, 0);
    for (int bits = 16; bits <= 32; bits += 16) {
        for (int64_t k = 1; k <= 2; k++) {
            const int64_t m = ((k << bits) - others + each - 1) / each;
            if (m > INT_MAX) continue;
            ASSERT_REFUSED(KQ_ERR_MEMORY, K(instant_assign)(&start, 2, (int)m, start_memory,
                                                          COUNT(start_memory)));
        }
    }
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(instant_assign)(&start, 2, INT_MAX, start_memory,
                                                  COUNT(start_memory)));
}

static void attach_refuses(void)
{
    K(instant) bare;
    memset(&bare, 0, sizeof bare);
    WATCH(bare);
    ASSERT_REFUSED(KQ_ERR_NULL, K(attach)(&track, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, K(attach)(NULL, &start.attached));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(attach)(&blank, &start.attached));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(attach)(&track, &bare.attached));
    bare.attached.hooks = start.attached.hooks; /* without sizes */
    ASSERT_REFUSED_SIZE_OR_MEMORY(K(attach)(&track, &bare.attached));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(attach)(&track, &start3.attached));
}

/* By the plain functions, and nothing has changed */
static void predict_and_step_refuse(void)
{
    static const num bad[] = {(num)NAN, 0}, z[] = {1, -1};
    drive(0), drive(1);
    watch(start_memory, INSTANT_LEN(2, MOST) * sizeof(num));
    ASSERT_REFUSED(KQ_ERR_NULL, K(predict)(NULL, &motion, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, K(predict)(&track, NULL, NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(predict)(&track, &blank_process, NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(predict)(&blank, &motion, NULL));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(predict)(&track, &motion3, NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(predict)(&track, &motion, bad));
    ASSERT_REFUSED(KQ_ERR_NULL, K(step)(NULL, &motion, NULL, &radar, z));
    ASSERT_REFUSED(KQ_ERR_NULL, K(step)(&track, NULL, NULL, &radar, z));
    ASSERT_REFUSED(KQ_ERR_NULL, K(step)(&track, &motion, NULL, NULL, z));
    ASSERT_REFUSED(KQ_ERR_NULL, K(step)(&track, &motion, NULL, &radar, NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(step)(&track, &blank_process, NULL, &radar, z));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(step)(&track, &motion, NULL, &blank_sensor, z));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(step)(&blank, &motion, NULL, &radar, z));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(step)(&track, &motion3, NULL, &radar, z));
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(step)(&track, &motion, bad, &radar, z));
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(step)(&track, &motion, NULL, &radar, bad));
    drive(2);
    ASSERT_OK(K(instant_smooth)(&start, &start_view));
}

static void smooth_refuses(void)
{
    drive(0), drive(1);
    watch(start_memory, INSTANT_LEN(2, MOST) * sizeof(num));
    ASSERT_REFUSED(KQ_ERR_NULL, K(instant_smooth)(NULL, &no_view));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(instant_smooth)(&unused, &no_view));
}

/* The chain is broken, and the filter goes on: by the bits of the twin, which has the same state and
   nothing attached. */
static void assert_goes_on_alone(void)
{
    ASSERT_OK(K(filter_copy)(&twin, &track));
    for (int step = 1; step < 6; step++) {
        ASSERT_OK(K(predict)(&twin, process_of(step), control_of(step)));
        ASSERT_OK(K(predict)(&track, process_of(step), control_of(step)));
        ASSERT_OK(K(update)(&twin, &radar, z_of(step)));
        ASSERT_OK(K(update)(&track, &radar, z_of(step)));
        ASSERT_OK(K(step)(&twin, process_of(step), control_of(step), &compass, z_of(step)));
        ASSERT_OK(K(step)(&track, process_of(step), control_of(step), &compass, z_of(step)));
        TEST_ASSERT_EQUAL_MEMORY(twin_memory, track_memory, sizeof track_memory);
    }
}

static void assert_broken(void)
{
    TEST_ASSERT_TRUE(K(events)(&track) & KQ_EVENT_HISTORY_FULL);
    ASSERT_REFUSED(KQ_ERR_HISTORY_FULL, K(instant_smooth)(&start, &no_view));
    assert_goes_on_alone();
    ASSERT_REFUSED(KQ_ERR_HISTORY_FULL, K(instant_smooth)(&start, &no_view));
    ASSERT_OK(K(attach)(&track, &start.attached));
    drive(1);
    ASSERT_OK(K(instant_smooth)(&start, &start_view));
}

static void after_too_many_measurements_the_filter_goes_on(void)
{
    drive(0), drive(1);
    measure(&track, 3);
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&track));
    measure(&track, 3);
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_HISTORY_FULL, K(events)(&track));
    assert_broken();
}

#include "copies.h"

/* What is attached to its original knows nothing of it. */
static void an_assigned_copy_goes_on_alone(void)
{
    drive(0), drive(1);
    watch_nothing();
    WATCH(track), WATCH(track_memory), WATCH(start), WATCH(start_memory);
    assert_copies_go_on_alone();
    drive(2);
    ASSERT_OK(K(instant_smooth)(&start, &start_view));
}

/* Of a start it takes the place once nothing is unknown, not before. */
static void a_start_goes_before(void)
{
    START(unknown, 2, 2);
    const num z[] = {1, 2};
    ASSERT_OK(K(detach)(&start.attached));
    ASSERT_OK(K(diffuse_init)(&unknown, &track, x0, P0, 3));
    WATCH(unknown), WATCH(unknown_memory);
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(attach)(&track, &start.attached));
    ASSERT_OK(K(update)(&track, &radar, z));
    TEST_ASSERT_EQUAL_INT(0, K(diffuse_count)(&unknown));
    ASSERT_OK(K(attach)(&track, &start.attached));
    drive(1);
    ASSERT_OK(K(instant_smooth)(&start, &start_view));
    ASSERT_OK(K(detach)(&start.attached));
    ASSERT_OK(K(diffuse_init)(&unknown, &track, x0, P0, 0));
    ASSERT_OK(K(attach)(&track, &start.attached));
    drive(1);
    ASSERT_OK(K(instant_smooth)(&start, &start_view));
}

static void it_may_be_detached(void)
{
    drive(0), drive(1);
    ASSERT_OK(K(instant_smooth)(&start, &start_view));
    const double mean = (double)K(mean)(&start_view, 0);
    TEST_ASSERT_EQUAL_INT(KQ_ERR_RECORDING, K(attach)(&twin, &start.attached));
    ASSERT_OK(K(detach)(&start.attached));
    ASSERT_OK(K(detach)(&start.attached));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, K(detach)(NULL));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(instant_smooth)(&start, &no_view));
    ASSERT_WITHIN(0, mean, K(mean)(&start_view, 0));
    watch_nothing();
    WATCH(start), WATCH(start_memory);
    ASSERT_OK_UNCHANGED(K(predict)(&track, &motion, NULL));
    measure(&track, 0);
    watched_assert_unchanged(__LINE__);
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&track));
    ASSERT_OK(K(attach)(&twin, &start.attached));
    watch_nothing();
    WATCH(start), WATCH(start_memory);
    ASSERT_OK_UNCHANGED(K(filter_init)(&twin, x0, P0));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(instant_smooth)(&start, &no_view));
}

static void another_history_takes_its_place(void)
{
    drive(0), drive(1);
    ASSERT_OK(K(instant_smooth)(&start, &start_view));
    ASSERT_OK(K(attach)(&track, &tape.attached));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(instant_smooth)(&start, &no_view));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(instant_smooth)(&start, &no_view));
    TEST_ASSERT_FALSE(isnan(K(mean)(&start_view, 0)));
    ASSERT_OK(K(attach)(&track, &start.attached));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(smooth)(&tape));
}

static void assert_no_number(const K(filter) * view, int i)
{
    ASSERT_NAN(K(mean)(view, i));
    ASSERT_NAN(K(mean_low)(view, i));
    ASSERT_NAN(K(sigma)(view, i));
}

static void what_is_not_shown_is_no_number(void)
{
    static const int bad[] = {-1, 2, INT_MAX, INT_MIN};
    num P[9] = {7};
    WATCH(P);
    drive(0);
    ASSERT_OK(K(instant_smooth)(&start, &start_view));
    for (int k = 0; k < COUNT(bad); k++) assert_no_number(&start_view, bad[k]);
    ASSERT_REFUSED(KQ_ERR_NULL, K(covariance)(&start_view, NULL));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(instant_smooth)(&unused, &start_view));
    assert_no_number(&start_view, 0);
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(covariance)(&start_view, P));
    ASSERT_REFUSED(KQ_ERR_NULL, K(instant_smooth)(&start, NULL));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(instant_smooth)(&start, &track));
}

SUITE(instant, set_up)
{
    RUN_TEST(an_instant_is_that_of_the_tape);
    RUN_TEST(the_filter_is_the_same_with_an_instant);
    RUN_TEST(a_step_is_predict_and_update);
    RUN_TEST(asking_changes_nothing);
    RUN_TEST(an_answer_stays_until_the_next_one);
    RUN_TEST(a_long_run_changes_nothing_any_more);
    RUN_TEST(a_constant_is_known_as_now);
    RUN_TEST(sixteen_states_are_sixteen_scalars);
    RUN_TEST(assign_refuses);
    RUN_TEST(a_length_that_would_wrap_is_refused);
    RUN_TEST(attach_refuses);
    RUN_TEST(predict_and_step_refuse);
    RUN_TEST(smooth_refuses);
    RUN_TEST(after_too_many_measurements_the_filter_goes_on);
    RUN_TEST(an_assigned_copy_goes_on_alone);
    RUN_TEST(a_start_goes_before);
    RUN_TEST(it_may_be_detached);
    RUN_TEST(another_history_takes_its_place);
    RUN_TEST(what_is_not_shown_is_no_number);
}
