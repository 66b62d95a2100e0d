/*
 * The fixed-lag smoother.
 *
 * A ring of slots holds, of each of the last L steps, the filtered state and the map of its
 * coordinates from those of the step after it (map.h).  A slot's AGE is how many
 * steps ago its step was; the youngest, of age 1, is still open: it takes the updates since.
 *
 * So that L does not count, maps are composed beforehand, at most two a predict.  Slots make
 * blocks of h = (L + 1) / 2.  Of the block that is being filled there is one map of all its closed
 * slots, the HEAD.  Of the block before there is one map of all of it, the MIDDLE, while its
 * slots become, one a predict and the youngest first, maps of all of the block from there on.  In
 * the block before that they all are.  So it takes at most four maps from the newest coordinates to
 * a slot of age L, and no more than h + 1 to any other.
 *
 * A lag for late measurements (delayed.h) keeps its maps apart: one block that never ends, without head and middle.
 */
#ifndef KQ_SRC_SMOOTHER_LAG_H
#define KQ_SRC_SMOOTHER_LAG_H

#include "on_line.h"

/* ------------------------------------------------------------------ the ring */

#define LAG_APART UINT32_MAX /* `head` of a block that never ends */

KQ_KERNEL backward_map lag_head(const T(kq_lag) *lag, int n)
{
    return map_at(on_line_end_of_tape(&lag->tape), n);
}

KQ_KERNEL backward_map lag_middle(const T(kq_lag) *lag, int n)
{
    return map_at(lag_head(lag, n).columns + MAP_LEN(n), n);
}

/* The filtered state of the slot of an age, 1 .. L; its map is behind it */
KQ_KERNEL num *lag_slot(const T(kq_lag) *lag, uint32_t age, int n)
{
    const uint32_t place = (lag->next >= age ? lag->next : lag->next + lag->most) - age;
    const size_t slot_length = (size_t)(FILTER_LEN(n) + MAP_LEN(n));
    return lag_middle(lag, n).columns + MAP_LEN(n) + place * slot_length;
}

KQ_KERNEL backward_map lag_map(const T(kq_lag) *lag, uint32_t age, int n)
{
    return map_at(lag_slot(lag, age, n) + FILTER_LEN(n), n);
}

/* The youngest slot's step is over.  Answers the events. */
KQ_KERNEL unsigned lag_close(T(kq_lag) *lag, const workspace *v, int n)
{
    unsigned events = 0;
    const backward_map youngest = lag_map(lag, 1, n), head = lag_head(lag, n);
    map_take_tape(youngest, &lag->tape, n);
    if (lag->head == 1) copy(head.columns, youngest.columns, MAP_LEN(n));
    else events = map_compose(head, youngest, v, n);
    if (lag->head == lag->block) {
        copy(lag_middle(lag, n).columns, head.columns, MAP_LEN(n));
        lag->head = 0;
        lag->joined = 1;
    } else if (lag->joined && lag->joined < lag->head + lag->block &&
               lag->joined + 2 <= lag->most) { /* the next slot will be of use */
        const backward_map older = lag_map(lag, lag->joined + 1, n);
        events |= map_compose(older, lag_map(lag, lag->joined, n), v, n);
        lag->joined++;
    }
    return events;
}

/* A slot for the step that is being left; it takes the place of one that is too old. */
KQ_KERNEL backward_map lag_open(T(kq_lag) *lag, const filter *f, int n)
{
    if (lag->steps < lag->most) lag->steps++;
    lag->next = lag->next + 1 < lag->most ? lag->next + 1 : 0;
    copy(lag_slot(lag, 1, n), f->memory, FILTER_LEN(n));
    return lag_map(lag, 1, n);
}

KQ_KERNEL void lag_move_of(filter *f, const process *p, const num *u, int n)
{
    T(kq_lag) *lag = (T(kq_lag) *)f->attached;
    const workspace v = workspace_at(lag->tape.memory, n);
    if (lag->steps) filter_note(f, lag_close(lag, &v, n));
    lag->tape.used = 0;
    lag->tape.records = 0;
    if (lag->most) lag->head++;
    if (lag->joined) lag->joined++;
    predict_by_map(f, p, u, lag->most ? lag_open(lag, f, n) : lag_head(lag, n), &v, n);
}

KQ_NOINLINE static void lag_move_1(filter *f, const process *p, const num *u) { lag_move_of(f, p, u, 1); }

KQ_NOINLINE static void lag_move_2(filter *f, const process *p, const num *u) { lag_move_of(f, p, u, 2); }

KQ_NOINLINE static void lag_move_3(filter *f, const process *p, const num *u) { lag_move_of(f, p, u, 3); }

static void lag_move(filter *f, const process *p, const num *u)
{
    const int n = f->states;
    if (n > KQ_STATES_APART) lag_move_of(f, p, u, n);
    else if (n == 1) lag_move_1(f, p, u);
    else if (n == 2) lag_move_2(f, p, u);
    else lag_move_3(f, p, u);
}

static kq_status lag_predict(filter *f, const process *p, const num *u)
{
    return on_line_predict(f, p, u, lag_move);
}

/* ------------------------------------------------------------------ the estimate of age k */

/* From the newest coordinates, which are those of the open slot's map, to the slot of age k.
   Answers the events. */
static unsigned lag_walk(const T(kq_lag) *lag, estimate *now, uint32_t k, int n)
{
    unsigned events = 0;
    const uint32_t middle_end = lag->head + lag->block;
    uint32_t age = 1;
    if (lag->head > 1 && k >= lag->head) {
        events = estimate_map(now, lag_head(lag, n), n);
        age = lag->head;
    }
    if (k >= middle_end) {
        events |= estimate_map(now, lag_middle(lag, n), n);
        if (k > middle_end) events |= estimate_map(now, lag_map(lag, k, n), n);
        return events;
    }
    if (k > lag->head) {
        age = k < lag->joined ? k : lag->joined;
        events |= estimate_map(now, lag_map(lag, age, n), n);
    }
    while (age < k) events |= estimate_map(now, lag_map(lag, ++age, n), n);
    return events;
}

/* The state of age k >= 1 into the answer.  Answers the events. */
static unsigned lag_estimate(T(kq_lag) *lag, uint32_t k, int states_only, num *rows, int n)
{
    estimate now = {workspace_at(lag->tape.memory, n), rows, states_only, 0};
    const backward_map newest = lag_map(lag, 1, n);
    map_take_tape(newest, &lag->tape, n);
    estimate_begin(&now, newest, n);
    const unsigned walked = lag_walk(lag, &now, k, n);
    return walked | estimate_end(&now, &lag->tape, lag_slot(lag, k, n), n);
}

KQ_NOINLINE static unsigned lag_estimate_of_few(T(kq_lag) *lag, uint32_t k, int states_only, int n)
{
    num rows[ESTIMATE_FEW * ROW_LEN(ESTIMATE_COLUMNS * ESTIMATE_FEW)];
    return lag_estimate(lag, k, states_only, rows, n);
}

static kq_status lag_show(T(kq_lag) *lag, size_t k, filter *view, int states_only)
{
    const kq_status status = on_line_check_view(lag ? &lag->tape : 0, view);
    if (status) return status;
    if (k > lag->steps) return view_nothing(view, KQ_ERR_SIZE);
    unsigned events = 0;
    const int n = lag->tape.states;
    if (k == 0) copy(on_line_answer(&lag->tape, n), lag->tape.filter->memory, FILTER_LEN(n));
    else if (n > ESTIMATE_FEW) events = lag_estimate(lag, (uint32_t)k, states_only, 0, n);
    else events = lag_estimate_of_few(lag, (uint32_t)k, states_only, n);
    return on_line_show(&lag->tape, view, states_only, events);
}

/* ------------------------------------------------------------------ the object */

static kq_status lag_assign(T(kq_lag) *lag, int n, int m, size_t most, num *memory, size_t length,
                            const hooks *with)
{
    if (!lag || !memory) return KQ_ERR_NULL;
    if (!size_is_valid(n) || m < 1 || most > KQ_COUNT_MAX) return KQ_ERR_SIZE;
    if (length < LAG_LEN(n, m, most)) return KQ_ERR_MEMORY;
    *lag = (T(kq_lag)){
        .tape = {.attached = {with}, .states = (uint8_t)n, .length = (size_t)ON_LINE_LEN(n, m), .memory = memory},
        .most = (uint32_t)most};
    return KQ_OK;
}

kq_status T(kq_lag_assign)(T(kq_lag) *lag, int n, int m, size_t most, num *memory, size_t length)
{
    return lag_assign(lag, n, m, most, memory, length, &T(kq_lag_hooks));
}

static kq_status lag_begin(T(kq_lag) *lag, filter *f, const hooks *with, uint32_t block, uint32_t head)
{
    const kq_status status = on_line_attach(&lag->tape, f, with);
    if (status) return status;
    lag->block = block;
    lag->steps = 0;
    lag->next = 0;
    lag->head = head;
    lag->joined = 0;
    return KQ_OK;
}

static kq_status lag_attach(filter *f, attached *object)
{
    T(kq_lag) *lag = (T(kq_lag) *)object;
    return lag_begin(lag, f, &T(kq_lag_hooks), (lag->most + 1) / 2, 0);
}

const hooks T(kq_lag_hooks) = {.attach = lag_attach, .predict = lag_predict, .step = step_attached,
                                   KQ_RECORDS_ROWS};

size_t T(kq_lag_steps)(const T(kq_lag) *lag)
{
    return lag && !on_line_check(&lag->tape) ? (size_t)lag->steps : 0;
}

kq_status T(kq_lagged)(T(kq_lag) *lag, size_t k, filter *view) { return lag_show(lag, k, view, 0); }

kq_status T(kq_lagged_states)(T(kq_lag) *lag, size_t k, filter *view) { return lag_show(lag, k, view, 1); }

#endif
