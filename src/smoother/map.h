#ifndef KQ_SRC_SMOOTHER_MAP_H
#define KQ_SRC_SMOOTHER_MAP_H

#include "whitened.h"

/*
 * Maps of the smoother's coordinates, for the smoothers that work on line.
 *
 * A map says what the coordinates of a step are, given those of a later one and all data between:
 *     xi = J xi_later + d + E zeta,    zeta ~ N(0, I), of nothing that comes later
 * It is made forwards:
 *     measurement   J <- J F, d <- d + J g nu, the n rotations of the update taking (u; alpha)
 *                   to (nu; xi), so that alpha = F xi + g nu
 *     predict       J <- J Theta11,  E <- tria [J Theta12, E]
 * J J' + E E' <= I: no entry is above 1, and nothing is subtracted anywhere.
 *
 * In memory: the 2n columns of [J, E], n numbers each, and d.  What is no more than 1 needs no
 * exponent: a number of these is a UNIT, in units of 2^one_exponent.
 */
typedef struct {
    num *columns;
    num *shift;
} backward_map;

KQ_KERNEL backward_map map_at(num *memory, int n)
{
    return (backward_map){memory, memory + 2 * n * n};
}

/* One entry of J X: row k of J by one column */
KQ_KERNEL num map_entry(const num *J, int k, const num *x, int n)
{
    sum total = 0;
    for (int i = 0; i < n; i++) total = add_product(total, J[i * n + k], x[i]);
    return unit_of(total);
}

/* Row k of J X, X being n columns */
KQ_KERNEL void map_row(num *out, const num *J, int k, const num *X, int n)
{
    for (int j = 0; j < n; j++) out[j] = map_entry(J, k, X + j * n, n);
}

/* xi is the later xi. */
static void map_set_unit(backward_map map, int n)
{
    for (int k = 0; k < MAP_LEN(n); k++) map.columns[k] = 0;
    for (int k = 0; k < n; k++) map.columns[k * n + k] = num_one;
}

/* The map of a predict: J = Theta11, E = Theta12; the workspace holds Theta's reflectors. */
KQ_KERNEL void map_set_predict_of(backward_map map, const process *m, const workspace *v, int n)
{
    num *row = v->M;
    for (int k = 0; k < n; k++) {
        const int last = last_of_theta(m, k, n, SHAPE_AS_FOUND);
        theta_row(row, m, v, k, last, n, SHAPE_AS_FOUND);
        for (int j = last + 1; j < n; j++) row[j] = 0;
        for (int j = 0; j < 2 * n; j++) map.columns[j * n + k] = row[j];
    }
    for (int k = 0; k < COORDINATE_PLANES * n; k++) map.shift[k] = 0;
}

KQ_NOINLINE static void map_set_predict_1(backward_map map, const process *m, const workspace *v)
{
    map_set_predict_of(map, m, v, 1);
}

KQ_NOINLINE static void map_set_predict_2(backward_map map, const process *m, const workspace *v)
{
    map_set_predict_of(map, m, v, 2);
}

KQ_NOINLINE static void map_set_predict_3(backward_map map, const process *m, const workspace *v)
{
    map_set_predict_of(map, m, v, 3);
}

KQ_KERNEL void map_set_predict(backward_map map, const process *m, const workspace *v, int n)
{
    if (n > KQ_STATES_APART) map_set_predict_of(map, m, v, n);
    else if (n == 1) map_set_predict_1(map, m, v);
    else if (n == 2) map_set_predict_2(map, m, v);
    else map_set_predict_3(map, m, v);
}

/* A measurement more: J <- J F, d <- d + J g nu, rotation by rotation.  Answers the events. */
KQ_KERNEL unsigned map_take_of(backward_map map, const num *record, int n)
{
    unsigned events = 0;
    num along[KQ_SIZE_MAX]; /* of each row, that of nu */
    const row_record update = load_row_record(record, n);
    rotor state;
    rotor_begin(&state, update.r, update.s, record, n);
    for (int k = 0; k < n; k++) along[k] = 0;
    for (int i = 0; i < n; i++) {
        num c, s;
        if (is_no_turn(record[i])) continue;
        unit_rotation(&state, record[i], &c, &s);
        unit_turn(map.columns + i * n, along, c, s, n);
    }
    const scaled nu = unit_innovation(&state, update.e, update.s);
    for (int k = 0; k < n; k++) events |= coordinate_move(map.shift, n, k, along[k], nu);
    return events;
}

KQ_NOINLINE static unsigned map_take_1(backward_map map, const num *record)
{
    return map_take_of(map, record, 1);
}

KQ_NOINLINE static unsigned map_take_2(backward_map map, const num *record)
{
    return map_take_of(map, record, 2);
}

KQ_NOINLINE static unsigned map_take_3(backward_map map, const num *record)
{
    return map_take_of(map, record, 3);
}

KQ_KERNEL unsigned map_take(backward_map map, const num *record, int n)
{
    if (n > KQ_STATES_APART) return map_take_of(map, record, n);
    if (n == 1) return map_take_1(map, record);
    return n == 2 ? map_take_2(map, record) : map_take_3(map, record);
}

/* All that is on the tape, which is empty then */
KQ_KERNEL void map_take_tape(backward_map map, history *h, int n)
{
    for (size_t at = 0; at < h->used; at += ROW_RECORD_LEN(n)) {
        filter_note(h->filter, map_take(map, history_tape(h, n) + at, n));
    }
    h->used = 0;
    h->records = 0;
}

/* E <- tria [X, E], X being n columns in the first of the rows of M */
KQ_KERNEL void map_join_noise(backward_map map, const workspace *v, int n)
{
    num *E = map.columns + n * n;
    for (int k = 0; k < n; k++) {
        num *row = v->M + k * ROW_LEN(2 * n);
        for (int j = 0; j < n; j++) row[n + j] = E[j * n + k];
        row_set_exponent(row, 2 * n, one_exponent);
    }
    triangularise(v->T, v->M, 2 * n, 0, n, v->pq, SHAPE_FULL);
    const num *t = v->T;
    for (int j = 0; j < n; j++) {
        for (int k = 0; k < n; k++) *E++ = k <= j ? *t++ : 0;
    }
}

/* older <- older o newer: from the coordinates that newer begins with.  Answers the events. */
KQ_KERNEL unsigned map_compose_of(backward_map older, backward_map newer, const workspace *v, int n)
{
    unsigned events = 0;
    num t[KQ_SIZE_MAX], *J = older.columns;
    for (int k = 0; k < n; k++) {
        const wide shift = coordinate_through(J, k, newer.shift, older.shift, n);
        events |= coordinate_set(older.shift, n, k, shift);
        map_row(v->M + k * ROW_LEN(2 * n), J, k, newer.columns + n * n, n);
        map_row(t, J, k, newer.columns, n);
        for (int j = 0; j < n; j++) J[j * n + k] = t[j];
    }
    map_join_noise(older, v, n);
    return events;
}

KQ_NOINLINE static unsigned map_compose_1(backward_map older, backward_map newer,
                                          const workspace *v)
{
    return map_compose_of(older, newer, v, 1);
}

KQ_NOINLINE static unsigned map_compose_2(backward_map older, backward_map newer,
                                          const workspace *v)
{
    return map_compose_of(older, newer, v, 2);
}

KQ_NOINLINE static unsigned map_compose_3(backward_map older, backward_map newer,
                                          const workspace *v)
{
    return map_compose_of(older, newer, v, 3);
}

KQ_KERNEL unsigned map_compose(backward_map older, backward_map newer, const workspace *v, int n)
{
    if (n > KQ_STATES_APART) return map_compose_of(older, newer, v, n);
    if (n == 1) return map_compose_1(older, newer, v);
    return n == 2 ? map_compose_2(older, newer, v) : map_compose_3(older, newer, v);
}

/* Predicts the filter, and makes the map of it.  Where the state had to be held there is none, and the recording
   ends. */
KQ_KERNEL void predict_by_map(filter *f, const process *p, const num *u, backward_map map,
                              const workspace *v, int n)
{
    num *S = f->memory + MEAN_PLANES * n;
    const extent of_mean = predict_mean(f->memory, p, p->controls ? u : 0, v->W, n, SHAPE_AS_FOUND);
    const extent far = extent_join(of_mean, predict_root(S, S, p, v->W, v->pq));
    renormalise(S, n);
    const unsigned events = state_saturated(f->memory, S, n, far);
    f->events = (uint16_t)(f->events | events);
    if (!KQ_MOSTLY(!(events & KQ_EVENT_OVERFLOW))) f->attached->hooks->record_end(f);
    if (f->ready != FILTER_READY) predict_ends_low_noise(f);
    map_set_predict(map, p, v, n);
}

#endif
