/*
 * The fixed-point smoother: the state of one instant s, the map of its coordinates from the newest
 * ones, and a map of one predict to compose it with.
 */
#ifndef KQ_SRC_SMOOTHER_INSTANT_H
#define KQ_SRC_SMOOTHER_INSTANT_H

#include "on_line.h"

KQ_KERNEL num *instant_state(const T(kq_instant) *instant) { return on_line_end_of_tape(&instant->tape); }

KQ_KERNEL backward_map instant_map(const T(kq_instant) *instant)
{
    const int n = instant->tape.states;
    return map_at(instant_state(instant) + FILTER_LEN(n), n);
}

/*
 * Without process noise C falls without end, by less and less, which has to count: where its words
 * get short they are raised, and S_s is lowered.  c is taken into the mean first, and is 0 then.
 * Answers the events.
 */
static unsigned instant_settle(num *state, backward_map map, int n)
{
    const int up = unit_room(map.columns, 2 * n * n);
    if (!up) return 0;
    scaled row[KQ_SIZE_MAX];
    unsigned events = 0;
    for (int i = 0; i < n; i++) {
        root_row(row, state + MEAN_PLANES * n, n, i);
        events |= mean_gather(state, n, i, row, map.shift);
    }
    for (int k = 0; k < COORDINATE_PLANES * n; k++) map.shift[k] = 0;
    units_raise(map.columns, up, 2 * n * n);
    root_lower(state + MEAN_PLANES * n, up, n);
    return events;
}

/* In the first step of its tape, until a predict, the instant is the filter's state: no map undoes what is measured then. */
static void instant_take_state(T(kq_instant) *instant, const filter *f)
{
    if (instant->tape.steps > 1) return;
    copy(instant_state(instant), f->memory, FILTER_LEN(f->states));
    instant->tape.used = 0;
    instant->tape.records = 0;
    instant->tape.rounding = 0;
}

static void instant_move(filter *f, const process *p, const num *u)
{
    T(kq_instant) *instant = (T(kq_instant) *)f->attached;
    const int n = f->states;
    instant_take_state(instant, f);
    instant->tape.steps = 2;
    const workspace v = workspace_at(instant->tape.memory, n);
    const backward_map so_far = instant_map(instant), of_step = map_at(so_far.columns + MAP_LEN(n), n);
    map_take_tape(so_far, &instant->tape, n);
    filter_note(f, instant_settle(instant_state(instant), so_far, n));
    predict_by_map(f, p, u, of_step, &v, n);
    filter_note(f, map_compose(so_far, of_step, &v, n));
}

static kq_status instant_predict(filter *f, const process *p, const num *u)
{
    return on_line_predict(f, p, u, instant_move);
}

kq_status T(kq_instant_assign)(T(kq_instant) *instant, int n, int m, num *memory, size_t length)
{
    if (!instant || !memory) return KQ_ERR_NULL;
    if (!size_is_valid(n) || m < 1) return KQ_ERR_SIZE;
    if (length < INSTANT_LEN(n, m)) return KQ_ERR_MEMORY;
    *instant = (T(kq_instant)){
        .tape = {.attached = {&T(kq_instant_hooks)},
                 .states = (uint8_t)n,
                 .length = (size_t)ON_LINE_LEN(n, m),
                 .memory = memory}};
    return KQ_OK;
}

static kq_status instant_attach(filter *f, attached *object)
{
    T(kq_instant) *instant = (T(kq_instant) *)object;
    const kq_status status = on_line_attach(&instant->tape, f, &T(kq_instant_hooks));
    if (status) return status;
    map_set_unit(instant_map(instant), f->states);
    return KQ_OK;
}

const hooks T(kq_instant_hooks) = {
    .attach = instant_attach, .predict = instant_predict, .step = step_attached, KQ_RECORDS_ROWS};

kq_status T(kq_instant_smooth)(T(kq_instant) *instant, filter *view)
{
    const kq_status status = on_line_check_view(instant ? &instant->tape : 0, view);
    if (status) return status;
    const int n = instant->tape.states;
    estimate now = {workspace_at(instant->tape.memory, n), 0, 0, 0};
    instant_take_state(instant, instant->tape.filter);
    map_take_tape(instant_map(instant), &instant->tape, n);
    estimate_begin(&now, instant_map(instant), n);
    const unsigned events = estimate_end(&now, &instant->tape, instant_state(instant), n);
    return on_line_show(&instant->tape, view, 0, events);
}

#endif
