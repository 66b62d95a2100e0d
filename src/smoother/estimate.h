#ifndef KQ_SRC_SMOOTHER_ESTIMATE_H
#define KQ_SRC_SMOOTHER_ESTIMATE_H

#include "kalmanq/size.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/compiler.h"
#include "../arithmetic/coordinates.h"
#include "../arithmetic/mean.h"
#include "../arithmetic/root.h"
#include "../arithmetic/rows.h"
#include "../arithmetic/scaled.h"
#include "../arithmetic/triangle.h"
#include "map.h"
#include "whitened.h"

/* ------------------------------------------------------------------ an estimate by maps */

/*
 * What is known of the coordinates given all data: the mean a, and their root as columns, n of them
 * and n for every map.  At the end it is the state: the filtered one of its step, moved, and the
 * columns of the root of its covariance.  What the last map has brought is still in that map.
 */
typedef struct {
    num *state;      /* mean and filtered root, whose exponents are those of the columns, too */
    num *columns;    /* `count` of them; there is room for ESTIMATE_MAPS + 1 times n */
    const num *last; /* `added` ones that come behind them */
    const num *a;
    num *next, *after; /* where the next a goes, and the one after it */
    int count, added;
} estimate;

enum { ESTIMATE_MAPS = 4 };

/* The first map, that from the newest coordinates */
KQ_KERNEL void estimate_begin(estimate *now, backward_map map, int states_only, int n)
{
    now->a = map.shift;
    now->last = map.columns;
    now->count = 0;
    now->added = states_only ? 0 : 2 * n;
}

/* Of the columns the last 2n become n. */
KQ_NOINLINE static void estimate_shorten(estimate *now, const workspace *v, int n)
{
    const backward_map last = {now->columns + (now->count - 2 * n) * n, 0};
    for (int k = 0; k < n; k++) {
        num *row = v->M + k * ROW_LEN(2 * n);
        for (int j = 0; j < n; j++) row[j] = last.columns[j * n + k];
    }
    map_join_noise(last, v, n);
    now->count -= n;
    copy(last.columns, last.columns + n * n, n * n);
}

/* Answers the events, as estimate_end does. */
KQ_KERNEL unsigned estimate_map_of(estimate *now, backward_map map, const workspace *v, int n)
{
    num *a = now->next;
    unsigned events = 0;
    for (int k = 0; k < n; k++) {
        const wide mean = coordinate_through(map.columns, k, now->a, map.shift, n);
        events |= coordinate_set(a, n, k, mean);
    }
    now->a = a;
    now->next = now->after;
    now->after = a;
    if (!now->added) return events;
    if (now->count + now->added > ESTIMATE_MAPS * n) estimate_shorten(now, v, n);
    num *x = now->columns;
    for (int j = 0; j < now->count; j++, x += n) map_column(x, map.columns, x, n);
    for (int j = 0; j < now->added; j++, x += n) {
        map_column(x, map.columns, now->last + j * n, n);
    }
    now->count += now->added;
    now->last = map.columns + n * n;
    now->added = n;
    return events;
}

KQ_NOINLINE static unsigned estimate_map_1(estimate *now, backward_map map, const workspace *v)
{
    return estimate_map_of(now, map, v, 1);
}

KQ_NOINLINE static unsigned estimate_map_2(estimate *now, backward_map map, const workspace *v)
{
    return estimate_map_of(now, map, v, 2);
}

KQ_NOINLINE static unsigned estimate_map_3(estimate *now, backward_map map, const workspace *v)
{
    return estimate_map_of(now, map, v, 3);
}

KQ_KERNEL unsigned estimate_map(estimate *now, backward_map map, const workspace *v, int n)
{
    if (n > KQ_STATES_APART) return estimate_map_of(now, map, v, n);
    if (n == 1) return estimate_map_1(now, map, v);
    return n == 2 ? estimate_map_2(now, map, v) : estimate_map_3(now, map, v);
}

/* The filter's own: no map */
KQ_KERNEL void estimate_filtered(estimate *now, const num *state, int states_only, int n)
{
    const num *s = state + MEAN_PLANES * n;
    copy(now->state, state, FILTER_LEN(n));
    now->count = states_only ? 0 : n;
    for (int j = 0; j < now->count; j++) {
        for (int k = 0; k < n; k++) now->columns[j * n + k] = k <= j ? *s++ : 0;
    }
}

/* S x, one column, which may be in the place of x */
KQ_KERNEL void root_column(num *out, const num *S, const num *x, int n)
{
    for (int i = 0; i < n; i++) {
        sum total = 0;
        for (int k = i; k < n; k++) total = add_product(total, S[column(k) + i], x[k]);
        out[i] = unit_of(total);
    }
}

/* x_s = x_f + S a, the columns by S.  Answers the events. */
KQ_KERNEL unsigned estimate_end_of(estimate *now, const num *state, int n)
{
    const num *S = state + MEAN_PLANES * n;
    num *x = now->columns;
    scaled row[KQ_SIZE_MAX];
    unsigned events = 0;
    copy(now->state, state, FILTER_LEN(n));
    for (int i = 0; i < n; i++) {
        root_row(row, S, n, i);
        events |= mean_move(now->state, n, i, row, now->a);
    }
    for (int j = 0; j < now->count; j++, x += n) root_column(x, S, x, n);
    for (int j = 0; j < now->added; j++, x += n) root_column(x, S, now->last + j * n, n);
    now->count += now->added;
    return events;
}

KQ_NOINLINE static unsigned estimate_end_1(estimate *now, const num *state)
{
    return estimate_end_of(now, state, 1);
}

KQ_NOINLINE static unsigned estimate_end_2(estimate *now, const num *state)
{
    return estimate_end_of(now, state, 2);
}

KQ_NOINLINE static unsigned estimate_end_3(estimate *now, const num *state)
{
    return estimate_end_of(now, state, 3);
}

KQ_KERNEL unsigned estimate_end(estimate *now, const num *state, int n)
{
    if (n > KQ_STATES_APART) return estimate_end_of(now, state, n);
    if (n == 1) return estimate_end_1(now, state);
    return n == 2 ? estimate_end_2(now, state) : estimate_end_3(now, state);
}

static scaled estimate_product(const estimate *now, int n, int i, int j)
{
    sum total = 0;
    for (int k = 0; k < now->count; k++) {
        total = add_product(total, now->columns[k * n + i], now->columns[k * n + j]);
    }
    return root_sum(total, now->state + MEAN_PLANES * n, n, i, j);
}

static void estimate_covariance(const estimate *now, scaled *P, int n)
{
    for (int i = 0; i < n; i++) {
        for (int j = i; j < n; j++) P[i * n + j] = P[j * n + i] = estimate_product(now, n, i, j);
    }
}

#endif
