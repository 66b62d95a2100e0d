/*
 * Every size from 1 to 16: the memory of each object, of exactly its length, and what each call answers lie between
 * guards, and nothing outside is written.  (What the numbers of sixteen states are: test_wide.c.)
 */
#define MAX 16

#include "models.h"
#include "sizes.h"

enum { GUARD = 4, STEPS = 4, TAPE = S_HISTORY_LEN(16, 16, STEPS, 2), PAST = S_LAG_LEN(16, 16, 2) };

static entry room[(TAPE > PAST ? TAPE : PAST) + 2 * GUARD], answers[256 + 2 * GUARD];
static word filter_memory[S_FILTER_LEN(16)], ahead_memory[S_FILTER_LEN(16)];
static S(filter) f, ahead;
static process_model motion, other;
static sensor_model sensor;
static prior_model prior;
static num dense[256], spread[256], zero[16], range[16];
static int n, m;

static void *guarded(void) { return guarded_in(room, sizeof room, GUARD * sizeof(entry)); }

static void assert_guarded(size_t bytes) { assert_guard_bytes(room, sizeof room, GUARD * sizeof(entry), bytes); }

static void *guarded_answer(void) { return guarded_in(answers, sizeof answers, GUARD * sizeof(entry)); }

static void assert_answered(size_t bytes) { assert_guard_bytes(answers, sizeof answers, GUARD * sizeof(entry), bytes); }

/* `size` states and 17 - `size` components, dense and correlated */
static void begin(int size)
{
    n = size, m = 17 - size;
    describe("size", "states", n, "components", m);
    for (int k = 0; k < 256; k++) dense[k] = N(0.0625);
    for (int k = 0; k < n * m; k += n + 1) dense[k] = 1;
    for (int i = 0; i < 16; i++) range[i] = 100;
    put_identity(spread, m, 1);
    if (m > 1) spread[1] = spread[m] = 0.5;
    put_sensor(&sensor, n, m, range, range, dense, spread);
    put_identity(spread, n, 1);
    if (n > 1) spread[1] = spread[n] = 0.5;
    put_identity(dense, n, 1);
    put_process(&motion, n, 0, range, NULL, dense, NULL, spread);
    put_process(&other, n, 0, range, NULL, dense, NULL, spread);
    put_prior(&prior, n, range, zero, spread);
    ASSERT_OK(S(filter_assign)(&f, n, filter_memory, (size_t)S_FILTER_LEN(n)));
    ASSERT_OK(init_filter(&f, &prior));
}

static const word *seen(int t)
{
    static num z[16];
    for (int c = 0; c < m; c++) z[c] = N(0.5 * (t % 3 - 1) + 0.0625 * c);
    return measured(&sensor.sensor, z);
}

/* With components missing, and with another process, by turns */
static void run(int steps)
{
    for (int t = 0; t < steps; t++) {
        if (t) ASSERT_OK(S(predict)(&f, t % 3 == 2 ? &other.process : &motion.process, NULL));
        ASSERT_OK(S(update_subset)(&f, &sensor.sensor, seen(t), t % 4 == 3 ? 0x5555 : UINT32_MAX));
    }
}

/* The macros that declare an object with its memory: as long as assign asks for (test_lengths.c) */
TEST(declared_objects_have_their_lengths)
{
    S_FILTER(track, 3);
    S_HISTORY(tape, 3, 2, 4, 1);
    S_LAG(past, 3, 2, 4);
    S_INSTANT(instant, 3, 2);
    S_DIFFUSE(start, 3, 2);
    S_FREEZE(lazy, 3, 2);
    S_STEADY(steady, 3, 2);
    S_CONSISTENCY(recent, 2, 5);
    TEST_ASSERT_TRUE(COUNT(track_memory) == S_FILTER_LEN(3) && track.states == 3);
    TEST_ASSERT_TRUE(COUNT(tape_memory) == S_HISTORY_LEN(3, 2, 4, 1) && tape.length == COUNT(tape_memory));
    TEST_ASSERT_TRUE(COUNT(past_memory) == S_LAG_LEN(3, 2, 4) && COUNT(instant_memory) == S_INSTANT_LEN(3, 2));
    TEST_ASSERT_TRUE(COUNT(start_memory) == S_DIFFUSE_LEN(3, 2) && COUNT(recent_memory) == S_CONSISTENCY_LEN(2, 5));
    TEST_ASSERT_TRUE(COUNT(lazy_memory) == S_FREEZE_LEN(3) && COUNT(steady_memory) == S_STEADY_LEN(3));
    (void)past, (void)instant, (void)start, (void)lazy, (void)lazy_gain, (void)steady, (void)recent;
#ifndef KQ_TEST_Q31
    PROCESS(process, 3, 1);
    SENSOR(full, 3, 2);
    SENSOR_DIAGONAL(narrow, 3, 2);
    TEST_ASSERT_TRUE(COUNT(process_memory) == 6 && process.states == 3 && process.controls == 1);
    TEST_ASSERT_TRUE(COUNT(full_memory) == 3 && COUNT(narrow_memory) == 2 && full.components == 2 && narrow.states == 3);
#endif
}

/* ----------------------------------------------------------------------------- what is answered */

TEST(a_filter_writes_within_its_memory)
{
    for (int size = 1; size <= 16; size++) {
        const size_t length = (size_t)S_FILTER_LEN(size);
        begin(size);
        S(loss) gate = {.kind = &S(loss_gate), .limit = S(chi_square_limit)(m, KQ_LEVEL_9999)};
        S(loss) closed = {.kind = &S(loss_gate), .limit = score_of(0x1p-20)};
        S(loss) huber = {.kind = &S(loss_huber), .parameter = number(2)};
        ASSERT_OK(S(filter_assign)(&f, n, guarded(), length));
        assert_guarded(0);
        ASSERT_OK(init_filter(&f, &prior));
        run(STEPS);
        ASSERT_OK(S(step)(&f, &motion.process, NULL, &sensor.sensor, seen(1)));
        ASSERT_OK(S(filter_assign)(&ahead, n, ahead_memory, COUNT(ahead_memory)));
        ASSERT_OK(S(filter_copy)(&ahead, &f));
        ASSERT_OK(S(update_robust)(&f, &sensor.sensor, seen(2), UINT32_MAX, &closed));
        TEST_ASSERT_EQUAL_HEX(KQ_EVENT_GATED, S(events)(&f));
        ASSERT_OK(S(update_robust)(&f, &sensor.sensor, seen(2), UINT32_MAX, &gate));
        ASSERT_OK(S(update)(&ahead, &sensor.sensor, seen(2)));
        TEST_ASSERT_EQUAL_MEMORY(ahead_memory, f.memory, length * sizeof(word));
        TEST_ASSERT_EQUAL_INT(S(taken)(&ahead), S(taken)(&f));
        ASSERT_OK(S(update_robust)(&f, &sensor.sensor, seen(0), UINT32_MAX, &huber));
        assert_guarded(length * sizeof(word));
        ASSERT_OK(S(filter_assign)(&f, n, guarded(), length));
        ASSERT_OK(S(forecast)(&ahead, &motion.process, NULL, 2, &f));
        assert_guarded(length * sizeof(word));
    }
}

TEST(no_answer_is_written_beyond_its_end)
{
    for (int size = 1; size <= 16; size++) {
        begin(size);
        ASSERT_OK(S(covariance)(&f, guarded_answer()));
        assert_answered((size_t)(n * n) * sizeof(entry));
        ASSERT_OK(S(gain)(&f, &sensor.sensor, guarded_answer()));
        assert_answered((size_t)(n * m) * sizeof(entry));
        ASSERT_OK(S(measurement)(&f, &sensor.sensor, guarded_answer(), NULL));
        assert_answered((size_t)m * sizeof(word));
        ASSERT_OK(S(measurement)(&f, &sensor.sensor, NULL, guarded_answer()));
        assert_answered((size_t)(m * m) * sizeof(entry));
        ASSERT_OK(S(innovation)(&f, &sensor.sensor, seen(0), guarded_answer()));
        assert_answered((size_t)m * sizeof(word));
    }
}

#ifndef KQ_TEST_Q31
TEST_FLOAT(a_model_writes_within_its_memory)
{
    for (int size = 1; size <= 16; size++) {
        const size_t root = (size_t)KQ_PROCESS_LEN(size), full = (size_t)KQ_SENSOR_LEN(size), diagonal = (size_t)size;
        K(process) p;
        K(sensor) s;
        begin(size);
        ASSERT_OK(K(process_assign)(&p, n, 0, guarded(), root));
        assert_guarded(0);
        ASSERT_OK(K(process_init)(&p, dense, NULL, spread));
        ASSERT_OK(K(process_init_factor)(&p, dense, NULL, spread, n));
        ASSERT_OK(K(process_change_transition)(&p, spread));
        assert_guarded(root * sizeof(num));
        ASSERT_OK(K(sensor_assign)(&s, n, n, guarded(), full));
        assert_guarded(0);
        ASSERT_OK(K(sensor_init)(&s, dense, spread));
        ASSERT_OK(K(sensor_change_measurement)(&s, spread));
        assert_guarded(full * sizeof(num));
        ASSERT_OK(K(sensor_assign)(&s, n, n, guarded(), diagonal));
        ASSERT_OK(K(sensor_init_diagonal)(&s, dense, range));
        assert_guarded(diagonal * sizeof(num));
    }
}
#endif

/* ----------------------------------------------------------------------------- what is attached */

TEST(a_history_writes_within_its_memory)
{
    for (int size = 1; size <= 16; size++) {
        const size_t length = (size_t)S_HISTORY_LEN(size, 17 - size, STEPS, 2);
        S(history) h;
        begin(size);
        ASSERT_OK(S(history_assign)(&h, n, guarded(), length));
        assert_guarded(0);
        ASSERT_OK(S(attach)(&f, &h.attached));
        run(STEPS);
        TEST_ASSERT_EQUAL_HEX(0, S(events)(&f));
        for (int t = 0; t < STEPS; t++) {
            entry *const square = guarded_answer();
            const S(smooth_extras) extras = {t == 1 ? square : NULL, NULL, t == 2 ? square : NULL};
            ASSERT_OK(S(smooth_step)(&h, NULL, &extras));
            assert_answered(t == 1 || t == 2 ? (size_t)(n * n) * sizeof(entry) : 0);
        }
        ASSERT_OK(S(covariance)(S_SMOOTHED(&h, 0), guarded_answer()));
        assert_answered((size_t)(n * n) * sizeof(entry));
        assert_guarded(length * sizeof(word));
    }
}

TEST(smoothers_on_line_write_within_their_memory)
{
    S(filter) view;
    for (int size = 1; size <= 16; size++) {
        const size_t lag_length = (size_t)S_LAG_LEN(size, 17 - size, 2), instant_length = (size_t)S_INSTANT_LEN(size, 17 - size);
        S(lag) lag;
        S(instant) instant;
        begin(size);
        ASSERT_OK(S(lag_assign)(&lag, n, m, 2, guarded(), lag_length));
        ASSERT_OK(S(attach)(&f, &lag.attached));
        run(STEPS);
        ASSERT_OK(S(lagged)(&lag, 2, &view));
        assert_guarded(lag_length * sizeof(word));
        begin(size);
        ASSERT_OK(S(instant_assign)(&instant, n, m, guarded(), instant_length));
        ASSERT_OK(S(attach)(&f, &instant.attached));
        run(STEPS);
        ASSERT_OK(S(instant_smooth)(&instant, &view));
        TEST_ASSERT_EQUAL_HEX(0, S(events)(&f));
        assert_guarded(instant_length * sizeof(word));
    }
}

TEST(a_start_writes_within_its_memory)
{
    S(filter) view;
    for (int size = 1; size <= 16; size++) {
        const size_t length = (size_t)S_DIFFUSE_LEN(size, 2);
        S(diffuse) s;
        begin(size);
        m = n; /* all of them are seen */
        put_sensor(&sensor, n, n, range, range, dense, spread);
        ASSERT_OK(S(diffuse_assign)(&s, n, 2, guarded(), length));
        assert_guarded(0);
        ASSERT_OK(init_start(&s, &f, &prior, UINT32_MAX));
        for (int t = 0; t < 2; t++) ASSERT_OK(S(predict)(&f, &motion.process, NULL));
        run(2);
        TEST_ASSERT_EQUAL_INT(0, S(diffuse_count)(&s));
        TEST_ASSERT_EQUAL_INT(KQ_ERR_NOT_READY, S(diffuse_smoothed)(&s, 0, &view));
        assert_guarded(length * sizeof(word));
    }
}

TEST(an_adaptation_learns_within_its_memory)
{
    const S(adaptation_rule) rule = usual_rule();
    for (int size = 1; size <= 16; size++) {
        const size_t length = (size_t)S(length)(KQ_OBJECT_ADAPTATION, size, 17 - size, 0, 0);
        S(adaptation) a;
        entry q, r;
        begin(size);
#ifdef KQ_TEST_Q31
        static int32_t root[S_ROOT_LEN(16)];
        ASSERT_OK(kq_adaptation_assign_q31(&a, n, m, guarded(), length, root));
#else
        ASSERT_OK(K(adaptation_assign)(&a, n, m, guarded(), length));
#endif
        ASSERT_OK(S(adaptation_init)(&a, &motion.process, &sensor.sensor, &rule));
        ASSERT_OK(S(attach)(&f, &a.attached));
        run(20);
        ASSERT_OK(S(adaptation_scales)(&a, &q, &r));
        TEST_ASSERT_TRUE(number_of(q) != 1 && number_of(r) != 1);
        assert_guarded(length * sizeof(entry));
    }
}

TEST(a_gain_is_frozen_and_kept_within_its_memory)
{
    static entry gain[256];
    for (int size = 1; size <= 16; size++) {
        const size_t freeze_length = (size_t)S_FREEZE_LEN(size), steady_length = (size_t)S_STEADY_LEN(size);
        S(freeze) w;
        S(steady) st;
        begin(size);
        ASSERT_OK(S(freeze_assign)(&w, n, m, guarded(), freeze_length, guarded_answer()));
        ASSERT_OK(S(freeze_init)(&w, 4));
        ASSERT_OK(S(attach)(&f, &w.attached));
        for (int t = 0; t < 60; t++) ASSERT_OK(S(step)(&f, &motion.process, NULL, &sensor.sensor, seen(t)));
        TEST_ASSERT_EQUAL_INT(1, S(freeze_is_active)(&w));
        assert_guarded(freeze_length * sizeof(word));
        assert_answered((size_t)(n * m) * sizeof(entry));
        ASSERT_OK(S(gain)(&f, &sensor.sensor, gain));
        ASSERT_OK(S(steady_assign)(&st, n, m, guarded(), steady_length));
        ASSERT_OK(S(steady_init)(&st, &motion.process, &sensor.sensor, prior.mean, gain, 1));
        for (int t = 0; t < STEPS; t++) ASSERT_OK(S(steady_step)(&st, NULL, seen(t)));
        assert_guarded(steady_length * sizeof(word));
    }
}

/* ----------------------------------------------------------------------------- what is watched */

TEST(a_consistency_is_kept_within_its_memory)
{
    score a, b, c, d;
    for (int size = 1; size <= 16; size++) {
        const int window = size == 16 ? 1 : 3;
        const size_t length = (size_t)S_CONSISTENCY_LEN(17 - size, window);
        S(consistency) recent;
        begin(size);
        ASSERT_OK(S(consistency_assign)(&recent, m, (size_t)window, guarded(), length));
        for (int t = 0; t < 2 * window + 1; t++) {
            ASSERT_OK(S(consistency_watch)(&recent, &f, &sensor.sensor, seen(t), UINT32_MAX));
            ASSERT_OK(S(update)(&f, &sensor.sensor, seen(t)));
            ASSERT_OK(S(consistency_record)(&recent, &f));
        }
        TEST_ASSERT_EQUAL_INT(window, S(consistency_count)(&recent));
        ASSERT_OK(S(consistency_nis)(&recent, score_of(2), &a, &b, &c));
        ASSERT_OK(S(consistency_innovation)(&recent, m - 1, score_of(2), &a, &b, &c, &d));
        assert_guarded(length * sizeof(word));
    }
}

SUITE(sizes, NULL)
#include "sizes.tests"
