/*
 * The smoother, in the coordinates of the roots:
 *     filtered  x = x_f + S xi,    predicted  x = x_p + S- alpha,    xi, alpha ~ N(0, I)
 * given the data so far.  Both steps of the filter are orthogonal maps of these coordinates
 * with the noise of the step:
 *     predict  (xi; eta) = Theta (alpha; beta),  w = G eta, and beta stays N(0, I)
 *     update   n rotations take (u; alpha) to (nu; xi), u the measurement noise over sqrt(r)
 * The smoother runs them backwards on the mean a and the root T of the coordinates given all
 * data, from a = 0, T = I at the last step.  x_s = x_f + S a, S_s = S T.  T T' <= I always.
 */
#ifndef KQ_SRC_SMOOTHER_WHITENED_H
#define KQ_SRC_SMOOTHER_WHITENED_H

#include "resolution.h"

/* The workspace, by name */
typedef struct {
    num *W, *pq;    /* the reflectors of Theta: n rows of n, 2 n */
    num *M;         /* n rows of 2n: rows of Theta, then of Theta diag(T, I) */
    num *T;         /* root of the coordinates given all data */
    num *predicted; /* S-, a root */
    num *a;         /* mean of the coordinates */
    num *spare;     /* of the same length */
} workspace;

KQ_KERNEL workspace workspace_at(num *memory, int n)
{
    workspace v;
    v.W = memory;
    v.M = v.W + n * ROW_LEN(n);
    v.T = v.M + n * ROW_LEN(2 * n);
    v.predicted = v.T + ROOT_LEN(n);
    v.pq = v.predicted + ROOT_LEN(n);
    v.a = v.pq + REFLECTOR_LEN(n);
    v.spare = v.a + COORDINATE_PLANES * n;
    return v;
}

/*
 * Theta's rows of xi.  A row is e_k through the reflectors from the last: those that begin behind
 * its entry k leave it alone, the first one that does not makes it full from there on.
 */

/* The entries of row k behind this one are 0: the reflectors of rows below it are behind entry k.
 */
KQ_KERNEL int last_of_theta(const process *m, int k, int n, int shape)
{
    int i = n - 1;
    if (shape == SHAPE_UPPER) return k;
    while (shape == SHAPE_AS_FOUND && i > k && first_column(m, i, shape) > k) i--;
    return i;
}

/* Row k: row[0 .. last] gets its part along alpha, row[n .. 2n) that along beta. */
KQ_KERNEL void theta_row(num *row, const process *m, const workspace *v, int k, int last, int n,
                         int shape)
{
    num *beta = row + n;
    const num *r = v->W + last * ROW_LEN(n), *pq = v->pq + 2 * last;
    int i = last, c = n;
    for (; i >= 0 && (c = first_column(m, i, shape)) > k; i--) {
        row[i] = 0;
        r -= ROW_LEN(n);
        pq -= 2;
    }
    if (i >= 0) row[i] = reflect_unit(beta + c, r + c, pq, k - c, n - c);
    else c = n;
    KQ_UNROLL
    for (i--; i >= 0; i--) {
        const int full = c;
        c = first_column(m, i, shape);
        r -= ROW_LEN(n);
        pq -= 2;
        row[i] = reflect_longer(beta + c, r + c, pq, full - c, n - c);
    }
    KQ_UNROLL
    for (int j = 0; j < c; j++) beta[j] = 0;
    if (c > k) beta[k] = num_one; /* no reflector took it */
}

/* row[0 .. n) <- row[0 .. count) T, in place, columns from the last */
KQ_KERNEL void row_times_root(num *row, const num *T, int count, int n)
{
    num space[KQ_SIZE_MAX];
    scaled entries[KQ_SIZE_MAX];
    int32_t exponent = one_exponent;
    KQ_UNROLL
    for (int k = 0; k < count; k++) entries[k] = unit_entry(row[k]);
    const num *c = align(space, entries, exponents_of(T, n), 1, count, &exponent);
    short_row_times_triangle(row, c, count, T + column(n - 1), n);
    row_join(row, n, exponent);
}

/* M <- [Theta11 T, Theta12], spare <- Theta11 a.  Answers the events. */
KQ_KERNEL unsigned theta_times_root_of(const process *m, const workspace *v, int n, int shape)
{
    unsigned events = 0;
    KQ_UNROLL
    for (int k = 0; k < n; k++) {
        num *theta = v->M + k * ROW_LEN(2 * n);
        const int last = last_of_theta(m, k, n, shape);
        theta_row(theta, m, v, k, last, n, shape);
        const wide mean = coordinate_dot(theta, v->a, n, last + 1);
        row_times_root(theta, v->T, last + 1, n);
        events |= coordinate_set(v->spare, n, k, mean);
    }
    return events;
}

KQ_NOINLINE static unsigned theta_times_root(const process *m, const workspace *v, int n)
{
    return theta_times_root_of(m, v, n, SHAPE_AS_FOUND);
}

/* Then xi's mean and root are ready: a <- Theta11 a, T <- tria M. */
KQ_OUTLINE void take_coordinates(const workspace *v, int n)
{
    KQ_UNROLL
    for (int k = 0; k < COORDINATE_PLANES * n; k++) v->a[k] = v->spare[k];
    triangularise(v->T, v->M, 2 * n, 0, n, v->pq, SHAPE_FULL);
    renormalise(v->T, n);
}

/* Row i of S T, from entry i on */
KQ_KERNEL void root_times_root(num *out, const scaled *row, const num *T, int n, int i)
{
    num space[KQ_SIZE_MAX];
    int32_t exponent = lowest_exponent;
    const num *c = align(space, row, exponents_of(T, n) + i, 1, n - i, &exponent);
    row_times_triangle(out + i, c, T + column(n - 1) + i, i, n);
    row_set_exponent(out, n, exponent);
}

/* x_s = x_f + S a and, T given, S_s = S T, in place.  Answers the events. */
KQ_OUTLINE unsigned smoothed_state(num *state, const num *a, const num *T, int n)
{
    unsigned events = 0;
    num *S = state + MEAN_PLANES * n, u[ROW_LEN(KQ_SIZE_MAX)];
    scaled row[KQ_SIZE_MAX];
    KQ_UNROLL
    for (int i = 0; i < n; i++) {
        root_row(row, S, n, i);
        events |= mean_move(state, n, i, row, a);
        if (!T) continue;
        root_times_root(u, row, T, n, i);
        num *s = S + column(i) + i;
        KQ_UNROLL
        for (int j = i; j < n; j++) {
            *s = u[j];
            s += j + 1;
        }
        root_take_exponent(S, n, i, u, n);
    }
    if (T) renormalise(S, n);
    return events | means_saturated(state, S, n);
}

/* The rotations of one update backwards: from xi to alpha, and from nu to the measurement noise,
   whose mean goes into *mean and whose row along T's columns into u (n).  Answers the events. */
KQ_KERNEL unsigned undo_rotations(wide *mean, num *u, const num *record, const workspace *v, int n,
                                  int states_only)
{
    unsigned events = coordinate_of(mean, load_scaled(record + n));
    row_set_exponent(u, n, lowest_exponent);
    KQ_UNROLL
    for (int i = n - 1; i >= 0; i--) {
        scaled c, s;
        u[i] = 0;
        if (record[i] == 0) continue; /* no turn */
        rotation_of(record[i], &c, &s);
        events |= coordinate_turn(v->a, n, i, mean, c, s);
        if (!states_only) turn_row(v->T, n, i, u, c, s);
    }
    if (!states_only) renormalise(v->T, n);
    return events;
}

/* The record of an update that is undone holds the mean and the variance of its noise. */
KQ_KERNEL unsigned undo_update(num *record, const workspace *v, int n, int states_only)
{
    num u[ROW_LEN(KQ_SIZE_MAX)]; /* from the entry of the last rotation on; 0 to the left of it */
    wide mean;
    const unsigned events = undo_rotations(&mean, u, record, v, n, states_only);
    store_noise(record, coordinate_scaled(mean), row_product(u, u, n));
    return events;
}

/* Smoothed step h->step - 1 to its place, which may overlap where it is, further down */
KQ_KERNEL void keep_state(const history *h, const num *state, int n)
{
    num *slot = history_slot(h, n, (size_t)h->step - 1);
    KQ_UNROLL
    for (int k = FILTER_LEN(n) - 1; k >= 0; k--) slot[k] = state[k];
}

/* All updates of the step, the last one first */
KQ_OUTLINE void undo_updates(history *h, int n, int states_only)
{
    const workspace v = workspace_at(h->memory, n);
    for (uint16_t k = 0; k < h->records; k++) {
        h->used -= UPDATE_RECORD_LEN(n);
        history_note(h, undo_update(history_tape(h, n) + h->used, &v, n, states_only));
    }
}

#endif
