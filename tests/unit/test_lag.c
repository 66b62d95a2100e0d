/* The fixed-lag smoother. */
#include "drive.h"
#include "sizes.h"
#include "unchanged.h"

#define LONGEST (STEPS + 2)

LAG(past, 2, MOST, LONGEST);
static K(filter) past_view, no_view;

/* never initialised, and of another size */
FILTER(blank, 2);
PROCESS(blank_process, 2, 1);
SENSOR(blank_sensor, 2, 1);
LAG(unused, 2, 1, 2);
FILTER(track3, 3);
PROCESS(motion3, 3, 0);
LAG(past3, 3, 1, 2);

static const num identity3[] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, zero3[3];

/* of each step given the data up to each later one */
static reading known[STEPS][STEPS];

static void attach(int longest)
{
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    ASSERT_OK(K(lag_assign)(&past, 2, MOST, (size_t)longest, past_memory, COUNT(past_memory)));
    ASSERT_OK(K(attach)(&track, &past.attached));
}

static void set_up(void)
{
    begin_drive();
    ASSERT_OK(K(process_init)(&motion3, identity3, NULL, identity3));
    ASSERT_OK(K(filter_init)(&track3, zero3, identity3));
    attach(5);
    watch_nothing();
    WATCH(track), WATCH(track_memory), WATCH(past), WATCH(motion), WATCH(motion_memory);
    WATCH(blank), WATCH(blank_memory), WATCH(unused), WATCH(past3), WATCH(past3_memory);
    WATCH(track3), WATCH(track3_memory);
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

static void every_lag_is_that_of_the_tape(void)
{
    static const int longest[] = {0, 1, 2, 3, 4, 5, 6, 9, 10, STEPS - 1, LONGEST};
    reading now;
    for (int last = 0; last < STEPS; last++) {
        smooth_to(last);
        for (int t = 0; t <= last; t++) read_smoothed(&known[last][t], &tape, (size_t)t, 2);
    }
    for (int l = 0; l < COUNT(longest); l++) {
        attach(longest[l]);
        for (int last = 0; last < STEPS; last++) {
            drive(last);
            TEST_ASSERT_EQUAL_INT(last < longest[l] ? last : longest[l], K(lag_steps)(&past));
            for (size_t k = 0; k <= K(lag_steps)(&past); k++) {
                ASSERT_OK(K(lagged)(&past, k, &past_view));
                read_view(&now, &past_view, 2);
                assert_read(&known[last][(size_t)last - k], &now);
            }
        }
        TEST_ASSERT_EQUAL_HEX(0, K(events)(&track));
    }
}

static void none_is_the_filter_bit_for_bit(void)
{
    reading filtered, now;
    static const int longest[] = {0, 4};
    for (int l = 0; l < COUNT(longest); l++) {
        attach(longest[l]);
        for (int step = 0; step < STEPS; step++) {
            drive(step);
            ASSERT_OK(K(lagged)(&past, 0, &past_view));
            read_view(&now, &past_view, 2);
            read_filter(&filtered, &track, 2);
            TEST_ASSERT_EQUAL_MEMORY(&filtered, &now, offsetof(reading, nis));
        }
    }
}

static void the_filter_is_the_same_with_a_lag(void)
{
    for (int step = 0; step < STEPS; step++) {
        drive(step);
        if (step) ASSERT_OK(K(predict)(&twin, process_of(step), control_of(step)));
        measure(&twin, step);
        ASSERT_OK(K(lagged)(&past, K(lag_steps)(&past), &past_view));
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
    LAG(beside, 2, MOST, 5);
    K(filter) beside_view;
    ASSERT_OK(K(attach)(&twin, &beside.attached));
    for (int step = 0; step < STEPS; step++) {
        ASSERT_OK(K(step)(&track, process_of(step), control_of(step), &radar, z_of(step)));
        ASSERT_OK(K(predict)(&twin, process_of(step), control_of(step)));
        ASSERT_OK(K(update)(&twin, &radar, z_of(step)));
        ASSERT_SAME_FILTER(&twin, &track, 2);
        TEST_ASSERT_EQUAL_MEMORY(twin_memory, track_memory, sizeof track_memory);
        ASSERT_OK(K(lagged)(&beside, K(lag_steps)(&beside), &beside_view));
        read_view(&expected, &beside_view, 2);
        ASSERT_OK(K(lagged)(&past, K(lag_steps)(&past), &past_view));
        read_view(&now, &past_view, 2);
        ASSERT_SAME_BITS(expected, now);
    }
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&track));
}

/* Whether and when it was asked before makes no difference. */
static void asking_changes_nothing(void)
{
    reading all[STEPS], now;
    for (int step = 0; step < STEPS; step++) {
        drive(step);
        ASSERT_OK(K(lagged)(&past, K(lag_steps)(&past), &past_view));
        read_view(&all[step], &past_view, 2);
    }
    attach(5);
    for (int step = 0; step < STEPS; step++) {
        drive(step);
        if (step % 4 != 3) continue;
        for (size_t k = K(lag_steps)(&past) + 1; k-- > 0;) ASSERT_OK(K(lagged)(&past, k, &past_view));
        ASSERT_OK(K(lagged_states)(&past, 1, &past_view));
        ASSERT_OK(K(lagged)(&past, K(lag_steps)(&past), &past_view));
        read_view(&now, &past_view, 2);
        ASSERT_SAME_BITS(all[step], now);
    }
}

static void an_answer_stays_until_the_next_one(void)
{
    reading now, later;
    for (int step = 0; step < 4; step++) drive(step);
    ASSERT_OK(K(lagged)(&past, 3, &past_view));
    read_view(&now, &past_view, 2);
    for (int step = 4; step < 12; step++) drive(step);
    read_view(&later, &past_view, 2);
    ASSERT_SAME_BITS(now, later);
}

/* An update more after the answer is in the next answer. */
static void updates_may_come_after_an_answer(void)
{
    static const num z[] = {1, -1};
    reading expected, now;
    for (int step = 0; step < 8; step++) drive(step);
    ASSERT_OK(K(lagged)(&past, 4, &past_view));
    ASSERT_OK(K(update_subset)(&track, &radar, z, 1));
    ASSERT_OK(K(lagged)(&past, 4, &past_view));
    read_view(&now, &past_view, 2);
    attach(5);
    for (int step = 0; step < 8; step++) drive(step);
    ASSERT_OK(K(update_subset)(&track, &radar, z, 1));
    ASSERT_OK(K(lagged)(&past, 4, &past_view));
    read_view(&expected, &past_view, 2);
    ASSERT_SAME_BITS(expected, now);
}

static void states_only_gives_the_means(void)
{
    num P[4] = {7, 7, 7, 7};
    reading now;
    WATCH(P);
    for (int step = 0; step < STEPS; step++) {
        drive(step);
        for (size_t k = 0; k <= K(lag_steps)(&past); k++) {
            ASSERT_OK(K(lagged)(&past, k, &past_view));
            read_view(&now, &past_view, 2);
            ASSERT_OK(K(lagged_states)(&past, k, &past_view));
            for (int i = 0; i < 2; i++) {
                TEST_ASSERT_TRUE(now.mean[i] == K(mean)(&past_view, i));
                TEST_ASSERT_TRUE(now.low[i] == K(mean_low)(&past_view, i));
                ASSERT_NAN(K(sigma)(&past_view, i));
            }
            ASSERT_REFUSED(KQ_ERR_NOT_READY, K(covariance)(&past_view, P));
        }
    }
}

static void it_may_be_attached_again(void)
{
    reading first, again;
    for (int step = 0; step < 9; step++) drive(step);
    ASSERT_OK(K(lagged)(&past, 5, &past_view));
    read_view(&first, &past_view, 2);
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    TEST_ASSERT_EQUAL_INT(0, K(lag_steps)(&past));
    ASSERT_OK(K(attach)(&track, &past.attached));
    TEST_ASSERT_EQUAL_INT(0, K(lag_steps)(&past));
    for (int step = 0; step < 9; step++) drive(step);
    ASSERT_OK(K(lagged)(&past, 5, &past_view));
    read_view(&again, &past_view, 2);
    ASSERT_SAME_BITS(first, again);
}

/* The same constant, through no process noise: known as now, at every step back */
static void a_constant_is_known_as_now(void)
{
    static const num still[] = {1, 0, 0, 1}, none[4], z[] = {3, -1};
    ASSERT_OK(K(process_init)(&motion, still, B, none));
    attach(10);
    for (int step = 0; step < STEPS; step++) {
        if (step) ASSERT_OK(K(predict)(&track, &motion, NULL));
        ASSERT_OK(K(update)(&track, &radar, z));
        for (size_t k = 0; k <= K(lag_steps)(&past); k++) {
            ASSERT_OK(K(lagged)(&past, k, &past_view));
            for (int i = 0; i < 2; i++) {
                ASSERT_CLOSE(K(mean)(&track, i), K(mean)(&past_view, i), 8);
                ASSERT_CLOSE(K(sigma)(&track, i), K(sigma)(&past_view, i), 1);
            }
        }
    }
}

/* A noise-free sensor in full: nothing more can be learned of its step, and S is singular. */
static void what_is_known_exactly_stays(void)
{
    static const num h[] = {1, 0, 0, 1}, free_of_noise[2], z[] = {3, 4};
    ASSERT_OK(K(sensor_init_diagonal)(&radar, h, free_of_noise));
    for (int step = 0; step < 8; step++) {
        if (step) ASSERT_OK(K(predict)(&track, &motion, NULL));
        ASSERT_OK(K(update)(&track, &radar, z));
        for (size_t k = 0; k <= K(lag_steps)(&past); k++) {
            ASSERT_OK(K(lagged)(&past, k, &past_view));
            for (int i = 0; i < 2; i++) {
                ASSERT_CLOSE(z[i], K(mean)(&past_view, i), 8);
                ASSERT_WITHIN(TOLERANCE, 0, K(sigma)(&past_view, i));
            }
        }
    }
}

/* A measurement at the rounding floor is not taken, and is nothing to the lag either. */
static void a_measurement_that_was_not_taken_is_nothing(void)
{
    static const num h[] = {1, 0.5, 1, 0.5}, free_of_noise[] = {0, 0}, z[] = {3, 3};
    reading once, twice;
    ASSERT_OK(K(sensor_init_diagonal)(&radar, h, free_of_noise));
    for (int both = 0; both < 2; both++) {
        attach(3);
        for (int step = 0; step < 6; step++) {
            if (step) ASSERT_OK(K(predict)(&track, &motion, NULL));
            ASSERT_OK(K(update_subset)(&track, &radar, z, both ? 3 : 1));
        }
        ASSERT_OK(K(lagged)(&past, 3, &past_view));
        read_view(both ? &twice : &once, &past_view, 2);
        TEST_ASSERT_EQUAL_HEX(both ? KQ_EVENT_REDUNDANT : 0, K(events)(&track));
    }
    ASSERT_SAME_BITS(once, twice);
}

/* ------------------------------------------------------------------------------- limits */

#define WIDE_LAG 3

static num wide_room[GUARDED(LAG_LEN(16, 16, WIDE_LAG))];
static num wide_filter[FILTER_LEN(16)], wide_P[256], wide_A[256], wide_Q[256];
PROCESS(wide_process, 16, 0);
SENSOR_DIAGONAL(wide_sensor, 16, 16);

/* Scalars of n = 1 side by side, or rotated, are what each of them is alone. */
static void sixteen_states_are_sixteen_scalars(void)
{
    static const num a = 0.5, q = 0.75, r = 2, p = 3, zero[16];
    static num z[16], ones[16];
    double d[16], sigma[16], mean[16];
    K(filter) wide, scalar;
    K(lag) window, line;
    K(filter) window_view, line_view;
    static num scalar_memory[FILTER_LEN(1)], line_memory[LAG_LEN(1, 1, WIDE_LAG)];
    PROCESS(scalar_process, 1, 0);
    SENSOR(scalar_sensor, 1, 1);
    num *memory = guard(wide_room, sizeof wide_room / sizeof(num));
    for (int i = 0; i < 16; i++) ones[i] = r, d[i] = 0.5;
    ASSERT_OK(K(process_init)(&scalar_process, &a, NULL, &q));
    ASSERT_OK(K(sensor_init)(&scalar_sensor, (const num[]){1}, &r));
    ASSERT_OK(K(filter_assign)(&scalar, 1, scalar_memory, COUNT(scalar_memory)));
    put_rotated(wide_A, d), put_identity(wide_Q, 16, q), put_identity(wide_P, 16, p);
    ASSERT_OK(K(process_init)(&wide_process, wide_A, NULL, wide_Q));
    ASSERT_OK(K(filter_assign)(&wide, 16, wide_filter, COUNT(wide_filter)));
    ASSERT_OK(K(filter_init)(&wide, zero, wide_P));
    put_identity(wide_P, 16, 1);
    ASSERT_OK(K(sensor_init_diagonal)(&wide_sensor, wide_P, ones));
    ASSERT_OK(K(lag_assign)(&window, 16, 16, WIDE_LAG, memory, LAG_LEN(16, 16, WIDE_LAG)));
    ASSERT_OK(K(attach)(&wide, &window.attached));
    for (int step = 0; step < 12; step++) {
        if (step) ASSERT_OK(K(predict)(&wide, &wide_process, NULL));
        for (int i = 0; i < 16; i++) z[i] = N((i * 5 + step * 3) % 11 - 5);
        ASSERT_OK(K(update)(&wide, &wide_sensor, z));
    }
    for (int i = 0; i < 16; i++) {
        ASSERT_OK(K(filter_init)(&scalar, zero, &p));
        ASSERT_OK(K(lag_assign)(&line, 1, 1, WIDE_LAG, line_memory, COUNT(line_memory)));
        ASSERT_OK(K(attach)(&scalar, &line.attached));
        for (int step = 0; step < 12; step++) {
            const num one = N((i * 5 + step * 3) % 11 - 5);
            if (step) ASSERT_OK(K(predict)(&scalar, &scalar_process, NULL));
            ASSERT_OK(K(update)(&scalar, &scalar_sensor, &one));
        }
        for (size_t k = 0; k <= WIDE_LAG; k++) {
            ASSERT_OK(K(lagged)(&line, k, &line_view));
            ASSERT_OK(K(lagged)(&window, k, &window_view));
            mean[i] = (double)K(mean)(&line_view, 0), sigma[i] = (double)K(sigma)(&line_view, 0);
            ASSERT_CLOSE(mean[i], K(mean)(&window_view, i), 8);
            ASSERT_CLOSE(sigma[i], K(sigma)(&window_view, i), 4);
        }
    }
    ASSERT_OK(K(covariance)(&window_view, wide_P));
    for (int i = 0; i < 256; i++) {
        ASSERT_CLOSE(i % 17 ? 0 : sigma[0] * sigma[0], wide_P[i], 4);
    }
    assert_guards(wide_room, LAG_LEN(16, 16, WIDE_LAG), sizeof wide_room / sizeof(num));
}

/* ---------------------------------------------------------------------------- refusals */

static void assign_refuses(void)
{
    static const int bad[] = {0, -1, 17, 258, -254, INT_MAX, INT_MIN};
    const size_t least = LAG_LEN(2, 1, 3);
    ASSERT_REFUSED(KQ_ERR_NULL, K(lag_assign)(NULL, 2, 1, 3, past_memory, 1000));
    ASSERT_REFUSED(KQ_ERR_NULL, K(lag_assign)(&past, 2, 1, 3, NULL, 1000));
    for (int k = 0; k < COUNT(bad); k++) {
        ASSERT_REFUSED(KQ_ERR_SIZE, K(lag_assign)(&past, bad[k], 1, 3, past_memory, SIZE_MAX));
    }
    ASSERT_REFUSED(KQ_ERR_SIZE, K(lag_assign)(&past, 2, 0, 3, past_memory, SIZE_MAX));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(lag_assign)(&past, 2, -1, 3, past_memory, SIZE_MAX));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(lag_assign)(&past, 2, 1, KQ_COUNT_MAX + 1, past_memory, SIZE_MAX));
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(lag_assign)(&past, 2, 1, 3, past_memory, least - 1));
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(lag_assign)(&past, 2, 1, INT_MAX, past_memory, least));
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(lag_assign)(&past, 2, INT_MAX, 3, past_memory, least));
    ASSERT_OK(K(lag_assign)(&past, 2, 1, 3, past_memory, least));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(lagged)(&past, 0, &no_view));
}

/* Sizes whose length is a little more than a multiple of 2^16 or 2^32: as a size_t of so many bits,
   and so many are the words that there are, it is short. */
static void a_length_that_would_wrap_is_refused(void)
{
    const int64_t step = LAG_LEN(2, MOST, 1) - LAG_LEN(2, MOST, 0), rest = LAG_LEN(2, MOST, 0);
    const int64_t each = LAG_LEN(2, 2, 5) - LAG_LEN(2, 1, 5), others = LAG_LEN(2, 0, 5);
    for (int bits = 16; bits <= 32; bits += 16) {
        for (int64_t k = 1; k <= 8; k++) {
            const int64_t L = ((k << bits) - rest + step - 1) / step;
            const int64_t m = ((k << bits) - others + each - 1) / each;
            if (L <= (int64_t)KQ_COUNT_MAX) {
                ASSERT_REFUSED(KQ_ERR_MEMORY, K(lag_assign)(&past, 2, MOST, (size_t)L, past_memory,
                                                            COUNT(past_memory)));
            }
            if (m <= INT_MAX) {
                ASSERT_REFUSED(KQ_ERR_MEMORY, K(lag_assign)(&past, 2, (int)m, 5, past_memory,
                                                            COUNT(past_memory)));
            }
        }
    }
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(lag_assign)(&past, 2, MOST, INT_MAX, past_memory,
                                                COUNT(past_memory)));
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(lag_assign)(&past, 2, INT_MAX, INT_MAX, past_memory,
                                                COUNT(past_memory)));
}

static void attach_refuses(void)
{
    K(lag) bare;
    memset(&bare, 0, sizeof bare);
    WATCH(bare);
    ASSERT_REFUSED(KQ_ERR_NULL, K(attach)(&track, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, K(attach)(NULL, &past.attached));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(attach)(&blank, &past.attached));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(attach)(&track, &bare.attached));
    bare.attached.hooks = past.attached.hooks; /* without sizes */
    ASSERT_REFUSED_SIZE_OR_MEMORY(K(attach)(&track, &bare.attached));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(attach)(&track, &past3.attached));
    TEST_ASSERT_EQUAL_INT(0, K(lag_steps)(NULL));
    TEST_ASSERT_EQUAL_INT(0, K(lag_steps)(&bare));
    TEST_ASSERT_EQUAL_INT(0, K(lag_steps)(&unused));
}

/* By the plain functions, and nothing has changed */
static void predict_and_step_refuse(void)
{
    static const num bad[] = {(num)NAN, 0}, z[] = {1, -1};
    drive(0), drive(1);
    watch(past_memory, LAG_LEN(2, MOST, 5) * sizeof(num));
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
    ASSERT_OK(K(lagged)(&past, 0, &past_view));
}

static void smooth_refuses(void)
{
    drive(0), drive(1), drive(2);
    watch(past_memory, LAG_LEN(2, MOST, 5) * sizeof(num));
    ASSERT_REFUSED(KQ_ERR_NULL, K(lagged)(NULL, 0, &no_view));
    ASSERT_REFUSED(KQ_ERR_NULL, K(lagged_states)(NULL, 0, &no_view));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(lagged)(&unused, 0, &no_view));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(lagged_states)(&unused, 0, &no_view));
    static const size_t bad[] = {3, SIZE_MAX, KQ_COUNT_MAX, SIZE_MAX / 2 + 1};
    for (int k = 0; k < COUNT(bad); k++) {
        ASSERT_REFUSED(KQ_ERR_SIZE, K(lagged)(&past, bad[k], &no_view));
        ASSERT_REFUSED(KQ_ERR_SIZE, K(lagged_states)(&past, bad[k], &no_view));
    }
    ASSERT_OK(K(lagged)(&past, 2, &past_view));
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
    TEST_ASSERT_EQUAL_INT(0, K(lag_steps)(&past));
    ASSERT_REFUSED(KQ_ERR_HISTORY_FULL, K(lagged)(&past, 0, &no_view));
    assert_goes_on_alone();
    ASSERT_REFUSED(KQ_ERR_HISTORY_FULL, K(lagged)(&past, 0, &no_view));
    ASSERT_OK(K(attach)(&track, &past.attached));
    drive(1);
    ASSERT_OK(K(lagged)(&past, 1, &past_view));
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
    WATCH(track), WATCH(track_memory), WATCH(past), WATCH(past_memory);
    assert_copies_go_on_alone();
    drive(2);
    ASSERT_OK(K(lagged)(&past, 1, &past_view));
}

/* Of a start it takes the place once nothing is unknown, not before. */
static void a_start_goes_before(void)
{
    START(unknown, 2, 2);
    const num z[] = {1, 2};
    ASSERT_OK(K(detach)(&past.attached));
    ASSERT_OK(K(diffuse_init)(&unknown, &track, x0, P0, 3));
    WATCH(unknown), WATCH(unknown_memory);
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(attach)(&track, &past.attached));
    ASSERT_OK(K(update)(&track, &radar, z));
    TEST_ASSERT_EQUAL_INT(0, K(diffuse_count)(&unknown));
    ASSERT_OK(K(attach)(&track, &past.attached));
    drive(1);
    ASSERT_OK(K(lagged)(&past, 1, &past_view));
    ASSERT_OK(K(detach)(&past.attached));
    ASSERT_OK(K(diffuse_init)(&unknown, &track, x0, P0, 0));
    ASSERT_OK(K(attach)(&track, &past.attached));
    drive(1);
    ASSERT_OK(K(lagged)(&past, 1, &past_view));
}

static void it_may_be_detached(void)
{
    drive(0), drive(1);
    ASSERT_OK(K(lagged)(&past, 1, &past_view));
    const double mean = (double)K(mean)(&past_view, 0);
    TEST_ASSERT_EQUAL_INT(KQ_ERR_RECORDING, K(attach)(&twin, &past.attached));
    ASSERT_OK(K(detach)(&past.attached));
    ASSERT_OK(K(detach)(&past.attached));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, K(detach)(NULL));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(lagged)(&past, 0, &no_view));
    ASSERT_WITHIN(0, mean, K(mean)(&past_view, 0));
    watch_nothing();
    WATCH(past), WATCH(past_memory);
    ASSERT_OK_UNCHANGED(K(predict)(&track, &motion, NULL));
    measure(&track, 0);
    watched_assert_unchanged(__LINE__);
    TEST_ASSERT_EQUAL_HEX(0, K(events)(&track));
    ASSERT_OK(K(attach)(&twin, &past.attached));
    watch_nothing();
    WATCH(past), WATCH(past_memory);
    ASSERT_OK_UNCHANGED(K(filter_init)(&twin, x0, P0));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(lagged)(&past, 0, &no_view));
}

static void another_history_takes_its_place(void)
{
    drive(0), drive(1);
    ASSERT_OK(K(lagged)(&past, 1, &past_view));
    ASSERT_OK(K(attach)(&track, &tape.attached));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(lagged)(&past, 1, &no_view));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(lagged)(&past, 0, &no_view));
    TEST_ASSERT_FALSE(isnan(K(mean)(&past_view, 0)));
    ASSERT_OK(K(predict)(&track, &motion, NULL));
    measure(&track, 3);
    ASSERT_OK(K(smooth)(&tape));
    TEST_ASSERT_EQUAL_UINT(2, K(history_steps)(&tape));
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
    ASSERT_OK(K(lagged)(&past, 0, &past_view));
    for (int k = 0; k < COUNT(bad); k++) assert_no_number(&past_view, bad[k]);
    ASSERT_REFUSED(KQ_ERR_NULL, K(covariance)(&past_view, NULL));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(lagged)(&past, 1, &past_view));
    assert_no_number(&past_view, 0);
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(covariance)(&past_view, P));
    ASSERT_REFUSED(KQ_ERR_NULL, K(lagged)(&past, 0, NULL));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(lagged)(&past, 0, &track));
}

SUITE(lag, set_up)
{
    RUN_TEST(every_lag_is_that_of_the_tape);
    RUN_TEST(none_is_the_filter_bit_for_bit);
    RUN_TEST(the_filter_is_the_same_with_a_lag);
    RUN_TEST(a_step_is_predict_and_update);
    RUN_TEST(asking_changes_nothing);
    RUN_TEST(an_answer_stays_until_the_next_one);
    RUN_TEST(updates_may_come_after_an_answer);
    RUN_TEST(states_only_gives_the_means);
    RUN_TEST(it_may_be_attached_again);
    RUN_TEST(a_constant_is_known_as_now);
    RUN_TEST(what_is_known_exactly_stays);
    RUN_TEST(a_measurement_that_was_not_taken_is_nothing);
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
