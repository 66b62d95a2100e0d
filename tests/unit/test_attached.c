/*
 * What is attached to a filter, of every kind and in all arithmetics: whose it is, what becomes of it where the filter is
 * copied, begins anew or is taken by another one, and what may be gone.  (What it makes of the steps: test_smoother.c,
 * test_on_line.c, test_learning.c, test_freeze.c.)
 */
#define WATCHED_BYTES (1024 * sizeof(word))

#include "models.h"
#include "unchanged.h"

static process_model motion;
static sensor_model radar;
static prior_model prior;
S_FILTER(track, 2);
S_FILTER(twin, 2);
S_FILTER(copied, 2);
S_HISTORY(tape, 2, 2, 16, 0);
S_HISTORY(other_tape, 2, 2, 16, 0);
S_LAG(past, 2, 2, 3);
S_INSTANT(instant, 2, 2);
S_ADAPTATION(tuner, 2, 2);
S_FREEZE(lazy, 2, 2);

/* ----------------------------------------------------------------------------- the kinds */

static kq_status assign_tape(void) { return S(history_assign)(&tape, 2, tape_memory, COUNT(tape_memory)); }

static kq_status assign_past(void) { return S(lag_assign)(&past, 2, 2, 3, past_memory, COUNT(past_memory)); }

static kq_status assign_instant(void)
{
    return S(instant_assign)(&instant, 2, 2, instant_memory, COUNT(instant_memory));
}

static kq_status assign_tuner(void)
{
    const S(adaptation_rule) rule = usual_rule();
    ASSERT_OK(ASSIGN_ADAPTATION(tuner, 2, 2));
    return S(adaptation_init)(&tuner, &motion.process, &radar.sensor, &rule);
}

static kq_status assign_lazy(void)
{
    ASSERT_OK(S(freeze_assign)(&lazy, 2, 2, lazy_memory, COUNT(lazy_memory), lazy_gain));
    return S(freeze_init)(&lazy, 8);
}

typedef struct {
    const char *name;
    struct S(attached) *attached;
    kq_status (*assign)(void); /* and init */
    void *object, *memory;
    size_t size, length;
    int steps;   /* until it is at work */
    int records; /* there is one of these at a time, and a filter that has lost it says so */
} kind;

#define KIND(object, steps, records)                                                               \
    {#object, &object.attached, assign_##object, &object, object##_memory, sizeof object, sizeof object##_memory, steps, records}

static const kind kinds[] = {KIND(tape, 6, 1), KIND(past, 6, 1), KIND(instant, 6, 1), KIND(tuner, 60, 0), KIND(lazy, 60, 0)};

static void set_up(void)
{
    static const num A[] = {0.5, N(0.4), N(0.6), N(0.3)}, B[] = {1, 0.5}, Q[] = {N(0.3), 0, 0, N(0.3)};
    static const num H[] = {1, 0, 0.5, 1}, R[] = {0.5, 0.25, 0.25, 0.75}, x0[] = {1, -2}, P0[] = {4, 1, 1, 3};
    static const num range[] = {100, 100}, drive_range[] = {10}, measured_range[] = {200, 200};
    put_process(&motion, 2, 1, range, drive_range, A, B, Q);
    put_sensor(&radar, 2, 2, range, measured_range, H, R);
    put_prior(&prior, 2, range, x0, P0);
    ASSERT_OK(S(history_assign)(&other_tape, 2, other_tape_memory, COUNT(other_tape_memory)));
}

enum { PREDICTED, UPDATED, STEPPED, MOVES };

static void move(S(filter) *f, int t, int how)
{
    const num z[] = {N(0.5 * (t * 7 % 11 - 5)), N(0.25 * (t * 5 % 13 - 6))}, push = N(t % 3 - 1);
    const word *seen = measured(&radar.sensor, z), *u = driven(&motion.process, &push, 1);
    if (how == PREDICTED) ASSERT_OK(S(predict)(f, &motion.process, u));
    else if (how == UPDATED) ASSERT_OK(S(update)(f, &radar.sensor, seen));
    else ASSERT_OK(S(step)(f, &motion.process, u, &radar.sensor, seen));
}

static void watch_object(const kind *k)
{
    watch_nothing();
    watch(k->object, k->size), watch(k->memory, k->length);
}

/* Attached to `track`, and at work; `twin` has its state, and nothing attached. */
static void begin(const kind *k)
{
    describe(k->name, "", 0, "", 0);
    ASSERT_OK(k->assign());
    ASSERT_OK(S(filter_assign)(&track, 2, track_memory, COUNT(track_memory)));
    ASSERT_OK(init_filter(&track, &prior));
    ASSERT_OK(S(attach)(&track, k->attached));
    for (int t = 0; t < k->steps; t++) move(&track, t, STEPPED);
    TEST_ASSERT_EQUAL_HEX_MESSAGE(0, S(events)(&track), k->name);
    if (k->attached == &lazy.attached) TEST_ASSERT_EQUAL_INT(1, S(freeze_is_active)(&lazy));
    ASSERT_OK(S(filter_copy)(&twin, &track));
    watch_object(k);
}

/* `f` moves as `twin` does, and leaves what was attached alone.  `says`: its event, at its first move. */
static void assert_alone(S(filter) *f, int first, unsigned says)
{
    for (int t = 0; t < 4; t++) {
        watched_store();
        move(f, t, t ? t - 1 : first);
        watched_assert_unchanged(__LINE__);
        move(&twin, t, t ? t - 1 : first);
        TEST_ASSERT_EQUAL_HEX_MESSAGE(t ? 0 : says, S(events)(f), description());
        S(events_clear)(f);
        ASSERT_SAME(&twin, f, 2);
        TEST_ASSERT_EQUAL_MEMORY_MESSAGE(twin_memory, f->memory, sizeof twin_memory, description());
    }
}

/* ------------------------------------------------------------------------------ whose it is */

/* Until it is detached or assigned anew, whatever has become of the filter: attach and assign do not look at that. */
TEST(it_has_one_filter)
{
    for (const kind *k = kinds; k < kinds + COUNT(kinds); k++) {
        begin(k);
        WATCH(twin), WATCH(twin_memory);
        ASSERT_REFUSED(KQ_ERR_RECORDING, S(attach)(&twin, k->attached));
        ASSERT_OK(S(attach)(&track, k->attached)); /* to its own once more */
        if (k->attached == &lazy.attached) TEST_ASSERT_EQUAL_INT(0, S(freeze_is_active)(&lazy)); /* begins again */
        ASSERT_OK(init_filter(&track, &prior));
        ASSERT_REFUSED(KQ_ERR_RECORDING, S(attach)(&twin, k->attached));
        for (int twice = 0; twice < 2; twice++) ASSERT_OK(S(detach)(k->attached));
        ASSERT_OK(S(attach)(&twin, k->attached));
        memset(&twin, 0xa5, sizeof twin);
        ASSERT_REFUSED(KQ_ERR_RECORDING, S(attach)(&track, k->attached));
        ASSERT_OK(k->assign());
        ASSERT_OK(S(attach)(&track, k->attached));
        ASSERT_OK(S(filter_assign)(&twin, 2, twin_memory, COUNT(twin_memory)));
    }
}

TEST(a_detached_filter_goes_on_by_itself)
{
    for (const kind *k = kinds; k < kinds + COUNT(kinds); k++) {
        begin(k);
        ASSERT_OK(S(detach)(k->attached));
        assert_alone(&track, STEPPED, 0);
        ASSERT_OK_UNCHANGED(S(detach)(k->attached));
    }
}

/* By kq_filter_copy or by assignment: the original has lost nothing. */
TEST(a_copied_filter_goes_on_by_itself)
{
    for (const kind *k = kinds; k < kinds + COUNT(kinds); k++) {
        for (int way = 0; way < 2 * MOVES; way++) {
            const int is_assigned = way / MOVES;
            begin(k);
            ASSERT_OK_UNCHANGED(S(filter_copy)(&copied, &track));
            if (is_assigned) copied = track, copied.memory = copied_memory;
            assert_alone(&copied, way % MOVES, is_assigned && k->records ? KQ_EVENT_HISTORY_FULL : 0);
            ASSERT_REFUSED(KQ_ERR_RECORDING, S(attach)(&copied, k->attached));
            move(&track, 0, STEPPED);
            TEST_ASSERT_EQUAL_HEX(0, S(events)(&track));
            if (k->attached == &lazy.attached) TEST_ASSERT_EQUAL_INT(1, S(freeze_is_active)(&lazy));
        }
    }
}

/* ------------------------------------------------------------------------ what may be gone */

/* The filter still points to it, which may be another one's by now. */
TEST(what_is_assigned_anew_is_not_attached)
{
    for (const kind *k = kinds; k < kinds + COUNT(kinds); k++) {
        for (int way = 0; way < 2 * MOVES; way++) {
            begin(k);
            ASSERT_OK(k->assign());
            ASSERT_OK(init_filter(&copied, &prior));
            if (way / MOVES) ASSERT_OK(S(attach)(&copied, k->attached));
            assert_alone(&track, way % MOVES, k->records ? KQ_EVENT_HISTORY_FULL : 0);
            TEST_ASSERT_EQUAL_HEX(0, S(events)(&copied));
        }
    }
}

enum { BEGUN, FORECAST, COPIED, ASSIGNED, ATTACHED, ENDS };

/* `f` becomes another filter. */
static kq_status end(S(filter) *f, int how)
{
    const S(filter) *from = &copied;
    if (how == BEGUN) return init_filter(f, &prior);
    if (how == FORECAST) return S(forecast)(from, &motion.process, NULL, 2, f);
    if (how == COPIED) return S(filter_copy)(f, from);
    if (how == ATTACHED) return S(attach)(f, &other_tape.attached);
    ASSERT_OK(S(filter_assign)(f, 2, f->memory, COUNT(track_memory)));
    return init_filter(f, &prior);
}

/* It has gone out of scope, and its memory is someone else's; only where another one takes its place it must be there. */
TEST(what_a_filter_has_left_may_be_gone)
{
    for (const kind *k = kinds; k < kinds + COUNT(kinds); k++) {
        for (int how = 0; how < (k->records ? ENDS : ATTACHED); how++) {
            begin(k);
            ASSERT_OK(init_filter(&copied, &prior));
            if (how != ATTACHED) memset(k->object, 0xa5, k->size), memset(k->memory, 0xa5, k->length);
            ASSERT_OK_UNCHANGED(end(&track, how));
            if (how != ATTACHED) ASSERT_OK(end(&twin, how));
            assert_alone(&track, STEPPED, 0);
            ASSERT_OK(S(detach)(&other_tape.attached));
        }
        ASSERT_OK(k->assign());
    }
}

/* ------------------------------------------------------------------------- beside each other */

/* Only what records gives way, to what records: its recording has ended then. */
TEST(what_records_takes_the_place_of_what_records)
{
    for (const kind *a = kinds; a < kinds + COUNT(kinds); a++) {
        for (const kind *b = kinds; b < kinds + COUNT(kinds); b++) {
            if (a == b) continue;
            begin(a);
            ASSERT_OK(b->assign());
            if (!a->records || !b->records) {
                ASSERT_REFUSED(KQ_ERR_RECORDING, S(attach)(&track, b->attached));
                continue;
            }
            ASSERT_OK(S(attach)(&track, b->attached));
            assert_alone(&track, STEPPED, 0);
            ASSERT_OK(S(attach)(&track, a->attached));
            watch_object(b);
            assert_alone(&track, STEPPED, 0);
        }
    }
}

/* A history is attached to a start as well; all others need the whole state. */
TEST(a_start_goes_before)
{
    S_DIFFUSE(start, 2, 2);
    for (const kind *k = kinds; k < kinds + COUNT(kinds); k++) {
        begin(k);
        ASSERT_OK(S(detach)(k->attached));
        ASSERT_OK(init_start(&start, &track, &prior, 3));
        WATCH(start), WATCH(start_memory), WATCH(track);
        if (k->attached == &tape.attached) ASSERT_OK(S(attach)(&track, k->attached));
        else ASSERT_REFUSED(KQ_ERR_NOT_READY, S(attach)(&track, k->attached));
        move(&track, 0, UPDATED);
        TEST_ASSERT_EQUAL_INT(0, S(diffuse_count)(&start));
        ASSERT_OK(S(attach)(&track, k->attached));
        move(&track, 1, STEPPED);
        ASSERT_OK(S(detach)(k->attached));
        ASSERT_OK(init_start(&start, &track, &prior, 0)); /* nothing is unknown */
        ASSERT_OK(S(attach)(&track, k->attached));
        move(&track, 1, STEPPED);
        TEST_ASSERT_EQUAL_HEX(0, S(events)(&track));
    }
}

SUITE(attached, set_up)
#include "attached.tests"
