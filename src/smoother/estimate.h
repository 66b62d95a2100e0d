#ifndef KQ_SRC_SMOOTHER_ESTIMATE_H
#define KQ_SRC_SMOOTHER_ESTIMATE_H

#include "map.h"

/* What lag and instant have in common: the tape of the current step, with room for the answer behind it */
KQ_KERNEL num *on_line_answer(const history *h, int n) { return h->memory + h->length - FILTER_LEN(n); }

/* ------------------------------------------------------------------ an estimate by maps */

/*
 * What is known of the coordinates given all data, map by map: from the newest ones, of mean 0 and root 1, to
 * those of the step that is asked for.  Mean a and root T are where the smoother of a run has them:
 *     a <- J a + d,    T <- tria [J T, E]
 * Of few states roots and divisions cost more than columns: `rows` gather [J X, E] of some maps, and T is made of
 * them once.
 */
typedef struct {
    workspace v;
    num *rows;       /* n rows of ESTIMATE_COLUMNS n units, or NULL */
    int states_only;
    int count;       /* columns so far; 0: no map yet */
} estimate;

enum { ESTIMATE_COLUMNS = 5, ESTIMATE_FEW = 3 }; /* the same in every build: so are the bits */

/* T <- tria rows */
KQ_NOINLINE static void estimate_join(const estimate *now, int n)
{
    const int width = ESTIMATE_COLUMNS * n;
    for (int k = 0; k < n; k++) {
        num *row = now->rows + k * ROW_LEN(width);
        for (int j = now->count; j < width; j++) row[j] = 0;
        row_set_exponent(row, width, one_exponent);
    }
    triangularise(now->v.T, now->rows, width, 0, n, now->v.pq, SHAPE_FULL);
}

/* No room for another map: T in the place of the rows */
KQ_NOINLINE static void estimate_shorten(estimate *now, int n)
{
    const num *t = now->v.T;
    estimate_join(now, n);
    for (int j = 0; j < n; j++) {
        for (int k = 0; k < n; k++) now->rows[k * ROW_LEN(ESTIMATE_COLUMNS * n) + j] = k <= j ? *t++ : 0;
    }
    now->count = n;
}

/* X <- [J X, E] */
KQ_KERNEL void estimate_gather_of(estimate *now, backward_map map, int n)
{
    const num *given = map.columns;
    num x[KQ_SIZE_MAX];
    const int stride = ROW_LEN(ESTIMATE_COLUMNS * n);
    if (now->count == ESTIMATE_COLUMNS * n) estimate_shorten(now, n);
    for (int j = 0; j < now->count; j++) {
        for (int k = 0; k < n; k++) x[k] = now->rows[k * stride + j];
        for (int k = 0; k < n; k++) now->rows[k * stride + j] = map_entry(map.columns, k, x, n);
    }
    int end = now->count + n;
    if (now->count) given += n * n;
    else end += n;
    for (int j = now->count; j < end; j++) {
        for (int k = 0; k < n; k++) now->rows[k * stride + j] = *given++;
    }
    now->count = end;
}

KQ_NOINLINE static void estimate_gather_1(estimate *now, backward_map map) { estimate_gather_of(now, map, 1); }

KQ_NOINLINE static void estimate_gather_2(estimate *now, backward_map map) { estimate_gather_of(now, map, 2); }

KQ_NOINLINE static void estimate_gather_3(estimate *now, backward_map map) { estimate_gather_of(now, map, 3); }

/* T <- tria [J T, E]; of the first map tria [J, E] */
KQ_OUTLINE void estimate_map_root(estimate *now, backward_map map, int n)
{
    const workspace *v = &now->v;
    for (int k = 0; k < n; k++) {
        num *row = v->M + k * ROW_LEN(2 * n);
        for (int j = 0; j < 2 * n; j++) row[j] = map.columns[j * n + k];
        if (now->count) row_times_root(row, v->T, n, n);
        else row_set_exponent(row, 2 * n, one_exponent);
    }
    triangularise(v->T, v->M, 2 * n, 0, n, v->pq, SHAPE_FULL);
    renormalise(v->T, n);
    now->count = n;
}

KQ_KERNEL void estimate_take_root(estimate *now, backward_map map, int n)
{
    if (!now->rows) estimate_map_root(now, map, n);
    else if (KQ_STATES_APART == 0) estimate_gather_of(now, map, n);
    else if (n == 1) estimate_gather_1(now, map);
    else if (n == 2) estimate_gather_2(now, map);
    else estimate_gather_3(now, map);
}

/* The first map, that from the newest coordinates */
KQ_KERNEL void estimate_begin(estimate *now, backward_map map, int n)
{
    copy(now->v.a, map.shift, COORDINATE_PLANES * n);
    now->count = 0;
    if (!now->states_only) estimate_take_root(now, map, n);
}

/* Answers the events. */
static unsigned estimate_map(estimate *now, backward_map map, int n)
{
    unsigned events = 0;
    for (int k = 0; k < n; k++) {
        const wide mean = coordinate_through(map.columns, k, now->v.a, map.shift, n);
        events |= coordinate_set(now->v.spare, n, k, mean);
    }
    copy(now->v.a, now->v.spare, COORDINATE_PLANES * n);
    if (!now->states_only) estimate_take_root(now, map, n);
    return events;
}

/* The smoothed state of a step whose filtered one is `state`, into the answer of the tape h.  Answers the events. */
static unsigned estimate_end(estimate *now, const history *h, const num *state, int n)
{
    num *answer = on_line_answer(h, n);
    copy(answer, state, FILTER_LEN(n));
    if (now->states_only) return smoothed_state(answer, now->v.a, 0, n);
    if (now->rows) {
        estimate_join(now, n);
        renormalise(now->v.T, n);
    }
    const unsigned events = smoothed_state(answer, now->v.a, now->v.T, n);
    if (!root_is_short(now->v.T, n)) return events;
    const num *S = state + MEAN_PLANES * n, *smoothed = answer + MEAN_PLANES * n;
    return events | smoothing_events(0, state, S, smoothed, h->rounding, n);
}

#endif
