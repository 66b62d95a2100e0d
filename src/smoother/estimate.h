#ifndef KQ_SRC_SMOOTHER_ESTIMATE_H
#define KQ_SRC_SMOOTHER_ESTIMATE_H

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/compiler.h"
#include "../arithmetic/coordinates.h"
#include "../arithmetic/root.h"
#include "../arithmetic/rows.h"
#include "map.h"
#include "whitened.h"

/* ------------------------------------------------------------------ an estimate by maps */

/*
 * What is known of the coordinates given all data, map by map: from the newest ones, of mean 0 and root 1, to
 * those of the step that is asked for.  Mean a and root T are where the smoother of a run has them:
 *     a <- J a + d,    T <- tria [J T, E]
 */

/* a <- J a + d.  Answers the events. */
KQ_KERNEL unsigned estimate_map_mean(const workspace *v, backward_map map, int n)
{
    unsigned events = 0;
    for (int k = 0; k < n; k++) {
        const wide mean = coordinate_through(map.columns, k, v->a, map.shift, n);
        events |= coordinate_set(v->spare, n, k, mean);
    }
    copy(v->a, v->spare, COORDINATE_PLANES * n);
    return events;
}

/* T <- tria [J T, E]; of the first map tria [J, E] */
KQ_OUTLINE void estimate_map_root(const workspace *v, backward_map map, int is_first, int n)
{
    for (int k = 0; k < n; k++) {
        num *row = v->M + k * ROW_LEN(2 * n);
        for (int j = 0; j < 2 * n; j++) row[j] = map.columns[j * n + k];
        if (is_first) row_set_exponent(row, 2 * n, one_exponent);
        else row_times_root(row, v->T, n, n);
    }
    triangularise(v->T, v->M, 2 * n, 0, n, v->pq, SHAPE_FULL);
    renormalise(v->T, n);
}

/* The first map, that from the newest coordinates */
KQ_KERNEL void estimate_begin(const workspace *v, backward_map map, int states_only, int n)
{
    copy(v->a, map.shift, COORDINATE_PLANES * n);
    if (!states_only) estimate_map_root(v, map, 1, n);
}

/* Answers the events. */
KQ_KERNEL unsigned estimate_map(const workspace *v, backward_map map, int states_only, int n)
{
    if (!states_only) estimate_map_root(v, map, 0, n);
    return estimate_map_mean(v, map, n);
}

/* The smoothed state of a step whose filtered one is `state`, into the answer.  Answers the events. */
KQ_KERNEL unsigned estimate_end(num *answer, const workspace *v, const num *state, int states_only, int n)
{
    copy(answer, state, FILTER_LEN(n));
    return smoothed_state(answer, v->a, states_only ? 0 : v->T, n);
}

#endif
