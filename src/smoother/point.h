/*
 * The fixed-point smoother: the state of one instant s, the map of its coordinates from the newest
 * ones, and a map of one predict to compose it with.
 */
#ifndef KQ_SRC_SMOOTHER_POINT_H
#define KQ_SRC_SMOOTHER_POINT_H

#include <stddef.h>
#include <stdint.h>

#include "kalmanq/point.h"
#include "kalmanq/size.h"
#include "kalmanq/smoother.h"
#include "kalmanq/status.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/compiler.h"
#include "../arithmetic/coordinates.h"
#include "../arithmetic/mean.h"
#include "../arithmetic/root.h"
#include "../arithmetic/scaled.h"
#include "../arithmetic/size.h"
#include "../model/types.h"
#include "../filter/attached.h"
#include "../filter/checks.h"
#include "../filter/filter.h"
#include "../filter/step.h"
#include "estimate.h"
#include "map.h"
#include "on_line.h"
#include "tape.h"
#include "whitened.h"

KQ_KERNEL num *point_state(const T(kq_point) *point)
{
    const int n = point->tape.states;
    return point->tape.memory + point->tape.length + POINT_COLUMNS_LEN(n);
}

KQ_KERNEL backward_map point_map(const T(kq_point) *point)
{
    const int n = point->tape.states;
    return map_at(point_state(point) + FILTER_LEN(n), n);
}

/*
 * Without process noise C falls without end, by less and less, which has to count: where its words
 * get short they are raised, and S_s is lowered.  c is taken into the mean first, and is 0 then.
 * Answers the events.
 */
static unsigned point_settle(num *state, backward_map map, int n)
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

static kq_status point_predict(filter *f, const process *p, const num *u)
{
    const kq_status status = predict_check(f, p, u);
    if (status) return status;
    if (!on_line_goes_on(f)) {
        predict_now(f, p, u);
        return KQ_OK;
    }
    T(kq_point) *point = (T(kq_point) *)f->attached;
    const int n = f->states;
    const workspace v = workspace_at(point->tape.memory, n);
    const backward_map so_far = point_map(point), of_step = map_at(so_far.columns + MAP_LEN(n), n);
    map_take_tape(so_far, &point->tape, n);
    filter_note(f, point_settle(point_state(point), so_far, n));
    predict_by_map(f, p, u, of_step, &v, n);
    filter_note(f, map_compose(so_far, of_step, &v, n));
    return KQ_OK;
}

kq_status T(kq_point_assign)(T(kq_point) *point, int n, int m, num *memory, size_t length)
{
    if (!point || !memory) return KQ_ERR_NULL;
    if (!size_is_valid(n) || m < 1) return KQ_ERR_SIZE;
    if (length < POINT_LEN(n, m)) return KQ_ERR_MEMORY;
    *point = (T(kq_point)){
        .tape = {.attached = {&T(kq_point_hooks)},
                 .states = (uint8_t)n,
                 .length = (size_t)ON_LINE_LEN(n, m),
                 .memory = memory}};
    return KQ_OK;
}

static kq_status point_attach(filter *f, attached *object)
{
    T(kq_point) *point = (T(kq_point) *)object;
    const kq_status status = on_line_attach(&point->tape, f, &T(kq_point_hooks));
    if (status) return status;
    copy(point_state(point), f->memory, FILTER_LEN(f->states));
    map_set_unit(point_map(point), f->states);
    point->columns = 0;
    return KQ_OK;
}

const hooks T(kq_point_hooks) = {.attach = point_attach, .predict = point_predict, .step = step_attached,
                                   KQ_RECORDS_ROWS};


kq_status T(kq_point_smooth)(T(kq_point) *point)
{
    if (!point) return KQ_ERR_NULL;
    const kq_status status = on_line_check(&point->tape);
    if (status) return status;
    const int n = point->tape.states;
    estimate now = answer_of(&point->tape, 0, n);
    map_take_tape(point_map(point), &point->tape, n);
    estimate_begin(&now, point_map(point), 0, n);
    filter_note(point->tape.filter, estimate_end(&now, point_state(point), n));
    point->columns = (uint8_t)now.count;
    return KQ_OK;
}

static int point_is_smoothed(const T(kq_point) *point) { return point && point->columns; }

num T(kq_point_mean)(const T(kq_point) *point, int i)
{
    return point_is_smoothed(point) ? answer_mean(&point->tape, i) : num_nan();
}

num T(kq_point_mean_low)(const T(kq_point) *point, int i)
{
    return point_is_smoothed(point) ? answer_mean_low(&point->tape, i) : num_nan();
}

num T(kq_point_sigma)(const T(kq_point) *point, int i)
{
    return point_is_smoothed(point) ? answer_sigma(&point->tape, point->columns, i) : num_nan();
}

kq_status T(kq_point_covariance)(const T(kq_point) *point, scaled *P)
{
    return point ? answer_covariance(&point->tape, point->columns, P) : KQ_ERR_NULL;
}

#endif
