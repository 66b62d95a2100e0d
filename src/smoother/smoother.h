/* The smoother at sizes known at run time, the noises, and what is asked of it. */
#ifndef KQ_SRC_SMOOTHER_SMOOTHER_H
#define KQ_SRC_SMOOTHER_SMOOTHER_H

#include "recorder.h"
#include "whitened.h"

typedef T(kq_smooth_extras) smooth_extras;

/* out = sum over k = from .. n-1 of c_{k-from} times row k of M, rows of `width` */
static void combine_rows(num *out, const scaled *c, const num *M, int width, int from, int n)
{
    num space[KQ_SIZE_MAX];
    int32_t exponent = lowest_exponent;
    const num *rows = M + from * ROW_LEN(width);
    const num *aligned = align(space, c, rows + width, ROW_LEN(width), n - from, &exponent);
    for (int j = 0; j < width; j++) {
        sum total = 0;
        for (int k = from; k < n; k++) {
            total = add_product(total, aligned[k - from], M[k * ROW_LEN(width) + j]);
        }
        out[j] = combined(total);
    }
    row_set_exponent(out, width, exponent);
}

/* Row k of Theta's rows of eta, on G's side: all of its entries */
KQ_KERNEL void theta_noise_row(num *row, const process *m, const workspace *v, int k)
{
    const int n = m->states;
    num *beta = row + n;
    for (int j = 0; j < 2 * n; j++) row[j] = 0;
    for (int i = k; i >= 0; i--) {
        const int c = first_column(m, i, SHAPE_AS_FOUND);
        row[i] = reflect(beta + c, i == k ? num_one : 0, v->W + i * ROW_LEN(n) + c,
                         reflector_pivot(m->noise_root + column(i) + i), v->pq + 2 * i, n - c);
    }
}

/* eta = Theta21 alpha + Theta22 beta, w = G eta.  Answers the events. */
KQ_NOINLINE static unsigned smooth_process_noise(const process *m, const workspace *v,
                                                 const smooth_extras *extras)
{
    const int n = m->states;
    unsigned events = 0;
    scaled row[KQ_SIZE_MAX];
    for (int k = 0; k < n; k++) {
        num *theta = v->M + k * ROW_LEN(2 * n);
        theta_noise_row(theta, m, v, k);
        events |= coordinate_set(v->spare, n, k, coordinate_dot(theta, v->a, n, n));
        row_times_root(theta, v->T, n, n);
    }
    for (int i = 0; i < n; i++) {
        root_row(row, m->noise_root, n, i);
        if (extras->noise_mean) extras->noise_mean[i] = mean_part(row, v->spare, n, i);
        if (!extras->noise_covariance) continue;
        combine_rows(v->M + i * ROW_LEN(2 * n), row, v->M, 2 * n, i, n);
    }
    for (int i = 0; extras->noise_covariance && i < n; i++) {
        for (int j = 0; j <= i; j++) {
            extras->noise_covariance[i * n + j] = extras->noise_covariance[j * n + i] =
                row_product(v->M + i * ROW_LEN(2 * n), v->M + j * ROW_LEN(2 * n), 2 * n);
        }
    }
    return events;
}

/* out = S_s (S Theta11 T)', S_s the smoothed root of the step after and the first n columns of M
   holding Theta11 T.  S- T is S_s but for rounding, of terms that cancel where a low-noise measurement came
   between the two.  W is used up. */
KQ_NOINLINE static void smooth_lag_one(scaled *out, const workspace *v, const num *S,
                                       const num *after, int n)
{
    num now[ROW_LEN(2 * KQ_SIZE_MAX)]; /* row j of S [Theta11 T, ...] */
    scaled row[KQ_SIZE_MAX];
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < i; j++) row[j] = unit_entry(0);
        root_row(row + i, after, n, i);
        for (int j = i; j < n; j++) row[j] = scaled_normal(row[j]);
        row_fitted(v->W + i * ROW_LEN(n), row, n);
    }
    for (int j = 0; j < n; j++) {
        root_row(row, S, n, j);
        combine_rows(now, row, v->M, 2 * n, j, n);
        row_set_exponent(now, n, row_exponent(now, 2 * n));
        for (int i = 0; i < n; i++) out[i * n + j] = row_product(v->W + i * ROW_LEN(n), now, n);
    }
}

/* The mean alone: Theta (a; 0), reflector by reflector */
KQ_KERNEL unsigned undo_predict_mean(const process *m, const num *S, const workspace *v)
{
    const int n = m->states;
    unsigned events = 0;
    predict_root(v->predicted, S, m, v->W, v->pq);
    for (int k = 0; k < COORDINATE_PLANES * n; k++) v->spare[k] = 0;
    for (int i = 0; i < n; i++) {
        const int c = first_column(m, i, SHAPE_AS_FOUND);
        events |= reflect_back(v->spare, n, c, coordinate_get(v->a, n, i),
                               v->W + i * ROW_LEN(n) + c, v->pq + 2 * i);
    }
    copy(v->a, v->spare, COORDINATE_PLANES * n);
    return events;
}

/*
 * How a predict is undone: from alpha of the step after to xi, S the filtered root, `after` the smoothed one
 * of the step after.  By reference, so that a program links what it asks for alone.  Answers the events.
 */
typedef unsigned undo_predict(const process *m, const num *S, const num *after, const workspace *v,
                              const smooth_extras *extras);

/* a <- Theta11 a, T <- tria [Theta11 T, Theta12] */
static unsigned undo_mean_and_root(const process *m, const num *S, const num *after, const workspace *v,
                                   const smooth_extras *extras)
{
    (void)after, (void)extras;
    predict_root(v->predicted, S, m, v->W, v->pq);
    const unsigned events = theta_times_root(m, v, m->states);
    take_coordinates(v, m->states);
    return events;
}

static unsigned undo_with_extras(const process *m, const num *S, const num *after, const workspace *v,
                                 const smooth_extras *extras)
{
    const int n = m->states;
    unsigned events = 0;
    predict_root(v->predicted, S, m, v->W, v->pq);
    if (extras->noise_mean || extras->noise_covariance) events = smooth_process_noise(m, v, extras);
    events |= theta_times_root(m, v, n);
    if (extras->lag_one) smooth_lag_one(extras->lag_one, v, S, after, n);
    take_coordinates(v, n);
    return events;
}

static unsigned undo_mean(const process *m, const num *S, const num *after, const workspace *v,
                          const smooth_extras *extras)
{
    (void)after, (void)extras;
    return undo_predict_mean(m, S, v);
}

/* The last step is the filter's own: it takes the last slot. */
static void smooth_begin(history *h)
{
    filter *f = h->filter;
    const int n = h->states;
    const workspace v = workspace_at(h->memory, n);
    for (int k = 0; k < COORDINATE_PLANES * n; k++) v.a[k] = 0;
    for (int k = 0; k < KQ_TRIANGLE(n); k++) v.T[k] = 0;
    for (int k = 0; k < n; k++) root_set_unit(v.T, n, k);
    copy(history_slot(h, n, (size_t)h->steps - 1), f->memory, FILTER_LEN(n));
    filter_set_attached(f, 0);
    h->filter = 0;
}

/* The step before the one done last */
static void smooth_back(history *h, const process *p, undo_predict *undo, const smooth_extras *extras,
                        int states_only)
{
    const process *before;
    const int n = h->states;
    const workspace v = workspace_at(h->memory, n);
    num *state = history_pop_predict(h, &before, n), *S = state + MEAN_PLANES * n;
    const num *after = history_slot(h, n, (size_t)h->step) + MEAN_PLANES * n;
    const process *m = p ? p : h->process;
    const int is_short = !states_only && root_is_short(v.T, n);
    h->process = before;
    history_note(h, undo(m, S, after, &v, extras));
    if (is_short) history_note(h, smoothing_events(m->transition, state, v.predicted, after, h->rounding, n));
    if (!mean_widens && !states_only && (h->step & 3) == 0) {
        const int i = watched_column((int32_t)(h->step >> 2), n);
        history_note(h, rounded_mean_events(m->transition, state, v.predicted, after, i, n));
    }
    const int is_short_now = !states_only && root_is_short(v.T, n);
    if (is_short_now) copy(v.predicted, S, ROOT_LEN(n));
    history_note(h, smoothed_state(state, v.a, states_only ? 0 : v.T, n));
    if (is_short_now) history_note(h, smoothing_events(m->transition, state, v.predicted, S, h->rounding, n));
    keep_state(h, state, n);
}

static void smooth_one(history *h, const process *p, undo_predict *undo, const smooth_extras *extras,
                       uint8_t phase)
{
    const int n = h->states, states_only = phase == HISTORY_STATES;
    if (h->phase == HISTORY_RECORDING) smooth_begin(h);
    else smooth_back(h, p, undo, extras, states_only);
    h->phase = phase;
    h->step--;
    undo_updates(h, n, states_only);
}

static kq_status smooth_check(const history *h, int going_on)
{
    if (!h) return KQ_ERR_NULL;
    if (h->phase == HISTORY_FULL) return KQ_ERR_HISTORY_FULL;
    if (h->phase == HISTORY_RECORDING) {
        return h->filter && h->filter->attached == &h->attached ? KQ_OK : KQ_ERR_HISTORY_EMPTY;
    }
    return going_on && h->phase == HISTORY_SMOOTHING && h->step > 0 ? KQ_OK : KQ_ERR_HISTORY_EMPTY;
}

/* Is every process of the tape what it was? */
static int history_knows_processes(const history *h)
{
    const process *before;
    history at = *h;
    while (at.steps-- > 1) {
        if (!history_knows_process(&at)) return 0;
        at.used -= at.records * UPDATE_RECORD_LEN(at.states);
        (void)history_pop_predict(&at, &before, at.states);
        at.process = before;
    }
    return 1;
}

static kq_status smooth_check_process(const history *h, const process *p)
{
    const kq_status status = process_check(p);
    if (status) return status;
    return p->states == h->states && processes_agree(p, h->process) ? KQ_OK : KQ_ERR_MISMATCH;
}

static kq_status smooth_all(history *h, undo_predict *undo, uint8_t phase)
{
    const kq_status status = smooth_check(h, 0);
    if (status) return status;
    if (!history_knows_processes(h)) return KQ_ERR_CHANGED;
    do smooth_one(h, 0, undo, 0, phase);
    while (h->step > 0);
    return KQ_OK;
}

/* ------------------------------------------------------------------ what is known */

static int smoothed_is_valid(const history *h, size_t t)
{
    return h && (h->phase == HISTORY_SMOOTHING || h->phase == HISTORY_STATES) && t >= h->step &&
           t < h->steps;
}

#endif
