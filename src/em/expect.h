/*
 * The E-step: the memory by name, and the smoother over a recording, which filter.h has
 * filtered, with what the sums take of every step.
 *
 * All of it is in the coordinates of the smoother (smoother/whitened.h), where the noises of a step
 * and its state are rows along the same independent directions, with their means:
 *     from step t to t + 1   eta = [Theta21 T, Theta22],  x_t = S [Theta11 T, Theta12]
 *     at step t              u = the rows that the rotations leave,  x_t = S T
 *     before the first       alpha = T
 * The process noise is G eta, the measurement noise L u (R = L L'), x_0 - x0 = S0 alpha.
 */
#ifndef KQ_SRC_EM_EXPECT_H
#define KQ_SRC_EM_EXPECT_H

#include "../smoother/smoother.h"
#include "sums.h"

typedef T(kq_em) estimation;
typedef T(kq_recording) recording;

enum { EM_UNUSED, EM_READY, EM_FILTERING, EM_SMOOTHING, EM_EXPECTED };

/* Is it in the E-step? */
static int em_is_expecting(const estimation *e)
{
    return e->phase == EM_FILTERING || e->phase == EM_SMOOTHING;
}

enum { EM_PROCESS, EM_SENSOR, EM_START, EM_SUMS };

/* Steps that are summed by themselves, so that each is rounded beside as few and not beside all */
enum { EM_BLOCK = 128 };

/* The memory, by name */
typedef struct {
    num *history, *filter, *process, *sensor;
    num *of_Q, *of_R, *of_P0; /* roots */
    num *map;                 /* F^+ G, r x n, only with F */
    num *sums[EM_SUMS];       /* roots */
    num *blocks[EM_START];    /* those of the last steps, not yet in the sums */
    sums_work work;
    num *ordered; /* scratch: R, its components in another order */
    /* The parameters that are free: new ones, until the M-step exchanges them with the
       caller's; then those that they replace, until the E-step has found them worse */
    num *A, *H, *Q, *R, *x0, *P0;
} em_places;

static em_places em_at(const estimation *e)
{
    em_places w;
    const size_t n = e->states, m = e->components;
    const size_t k = n + (n > m ? n : m);
    w.filter = e->memory;
    w.process = w.filter + FILTER_LEN(n);
    w.sensor = w.process + KQ_TRIANGLE(n);
    w.of_Q = w.sensor + KQ_TRIANGLE(m);
    w.of_R = w.of_Q + KQ_TRIANGLE(n);
    w.of_P0 = w.of_R + KQ_TRIANGLE(m);
    w.map = w.of_P0 + KQ_TRIANGLE(n);
    w.sums[EM_PROCESS] = w.map + n * n;
    w.sums[EM_SENSOR] = w.sums[EM_PROCESS] + KQ_TRIANGLE(2 * n);
    w.sums[EM_START] = w.sums[EM_SENSOR] + KQ_TRIANGLE(n + m);
    w.blocks[EM_PROCESS] = w.sums[EM_START] + KQ_TRIANGLE(n + 1);
    w.blocks[EM_SENSOR] = w.blocks[EM_PROCESS] + KQ_TRIANGLE(2 * n);
    w.work.rows = w.blocks[EM_SENSOR] + KQ_TRIANGLE(n + m);
    w.work.pivots = w.work.rows + k * (k + 1);
    w.work.spare = w.work.pivots + 2 * k;
    w.ordered = w.work.spare + KQ_TRIANGLE(k);
    w.A = w.ordered + m * m;
    w.H = w.A + n * n;
    w.Q = w.H + m * n;
    w.R = w.Q + n * n;
    w.x0 = w.R + m * m;
    w.P0 = w.x0 + n;
    w.history = w.P0 + n * n;
    return w;
}

static const kq_em_choice *em_choice(const estimation *e)
{
    static const kq_em_choice usual = {KQ_EM_Q | KQ_EM_R, KQ_EM_FULL, KQ_EM_FULL, 0, 0};
    return e->choice ? e->choice : &usual;
}

static int em_is_free(const estimation *e, unsigned parameter)
{
    return (em_choice(e)->free & parameter) != 0;
}

static int em_noises(const estimation *e)
{
    return e->model->F ? (int)e->model->noises : e->states;
}

static uint32_t present_at(const estimation *e, const recording *r, size_t t)
{
    const uint32_t all = UINT32_MAX >> (32 - e->components);
    return r->present ? r->present[t] & all : all;
}

static int count_of(uint32_t present)
{
    int count = 0;
    for (; present; present &= present - 1) count++;
    return count;
}

/* What explains the noises of a sum, if it is free: the state or, of the start, 1 */
static int em_regressors(const estimation *e, int which)
{
    static const unsigned explained_by[] = {KQ_EM_A, KQ_EM_H, KQ_EM_X0};
    if (!em_is_free(e, explained_by[which])) return 0;
    return which == EM_START ? 1 : e->states;
}

/* Of a sum: noises and what explains them */
static int em_rows(const estimation *e, int which)
{
    return (which == EM_SENSOR ? e->components : e->states) + em_regressors(e, which);
}

/* Back through a predict: the smoothed mean of the step before, its root as it was filtered */
static num *em_undo_predict(estimation *e, const em_places *w)
{
    const process *before, *m = &e->process;
    const int n = e->states, width = 2 * n + 1, explained = em_is_free(e, KQ_EM_A);
    const workspace v = workspace_at(e->history.memory, n);
    num *state = history_pop_predict(&e->history, &before, n), *S = state + MEAN_PLANES * n;
    num *rows = w->work.rows;
    scaled row[KQ_SIZE_MAX];
    predict_root(v.predicted, S, m, v.W, v.pq);
    for (int k = 0; k < n; k++, rows += width) {
        theta_noise_row(rows, m, &v, k);
        rows[2 * n] = coordinate_dot(rows, v.a, n, n);
        row_times_root(rows, v.T, n, n);
    }
    history_note(&e->history, theta_times_root(m, &v, n));
    for (int i = 0; explained && i < n; i++) {
        root_row(row, S, n, i);
        combine_rows(rows + i * width, row, v.M, 2 * n, i, n);
    }
    take_coordinates(&v, n);
    history_note(&e->history, smoothed_state(state, v.a, 0, n));
    for (int i = 0; explained && i < n; i++) rows[i * width + 2 * n] = mean_get(state, n, i);
    sums_add(w->blocks[EM_PROCESS], &w->work, em_rows(e, EM_PROCESS), width);
    return state;
}

/* The components in the order: missing ones, then those that are present */
static void missing_first(int *order, uint32_t present, int m)
{
    int missing = 0, there = m - count_of(present);
    for (int c = 0; c < m; c++) {
        if (present >> c & 1) order[there++] = c;
        else order[missing++] = c;
    }
}

/*
 * Some components of a correlated R are missing.  The rows hold the noises of the others in units
 * of the root of their own covariance, and independent ones for those missing.  With the missing
 * ones first, [L_11 L_12; 0 L_22] is the root of all, and L_22 that of the others: v is this root
 * times the rows, and u is L^-1 v.
 */
static void correlate_missing(const estimation *e, const em_places *w, uint32_t present, int width)
{
    const int m = e->components;
    int order[KQ_SIZE_MAX];
    num *rows = w->work.rows, *root = w->work.spare;
    missing_first(order, present, m);
    for (int i = 0; i < m; i++) {
        for (int j = 0; j < m; j++) w->ordered[i * m + j] = e->model->R[order[i] * m + order[j]];
    }
    root_of_covariance(root, w->ordered, m, UINT32_MAX);
    for (int i = 0; i < m; i++) {
        for (int c = 0; c < width; c++) {
            num total = 0;
            for (int k = i; k < m; k++) total += root[column(k) + i] * rows[order[k] * width + c];
            rows[order[i] * width + c] = total;
        }
    }
    rows_over_root(w->of_R, rows, m, width);
}

/* Row i of S T and its mean, of `width` numbers */
static void state_row(num *out, const num *state, const num *T, int n, int i, int width)
{
    scaled row[KQ_SIZE_MAX];
    for (int k = 0; k < width; k++) out[k] = 0;
    root_row(row, state + MEAN_PLANES * n, n, i);
    root_times_root(out, row, T, n, i);
    out[width - 1] = mean_get(state, n, i);
}

/* Back through the updates of a step: its measurement noises, and its state.  A step without a
   measurement has no part in R and H. */
static void em_undo_updates(estimation *e, const em_places *w, const num *state, uint32_t present)
{
    history *h = &e->history;
    const int n = e->states, m = e->components, explained = em_is_free(e, KQ_EM_H);
    const int missing = m - count_of(present), width = n + missing + 1;
    const workspace v = workspace_at(h->memory, n);
    num *rows = w->work.rows;
    if (!present) return;
    for (int i = 0; explained && i < n; i++) {
        state_row(rows + (m + i) * width, state, v.T, n, i, width);
    }
    for (int c = m - 1, other = n; c >= 0; c--) {
        num *row = rows + c * width;
        for (int k = 0; k < width; k++) row[k] = 0;
        if (present >> c & 1) {
            h->used -= UPDATE_RECORD_LEN(n);
            const num *record = history_tape(h, n) + h->used;
            history_note(h, undo_rotations(row + width - 1, row, record, &v, n, 0));
        } else {
            row[other++] = 1;
        }
    }
    if (missing && e->sensor.covariance) correlate_missing(e, w, present, width);
    sums_add(w->blocks[EM_SENSOR], &w->work, em_rows(e, EM_SENSOR), width);
}

/* The coordinates of x_0 before its measurement, and the 1 that explains their mean */
static void em_add_start(const estimation *e, const em_places *w)
{
    const int n = e->states, width = n + 1;
    const workspace v = workspace_at(e->history.memory, n);
    num *rows = w->work.rows;
    for (int i = 0; i < n; i++, rows += width) {
        for (int j = 0; j < n; j++) rows[j] = j < i ? 0 : v.T[column(j) + i];
        rows[n] = v.a[i];
    }
    for (int j = 0; j < n; j++) rows[j] = 0;
    rows[n] = 1;
    sums_add(w->sums[EM_START], &w->work, em_rows(e, EM_START), width);
}

/* The block is full, or the recording at its end. */
static void em_end_block(const estimation *e, const em_places *w)
{
    for (int which = 0; which < EM_START; which++) {
        const int rows = em_rows(e, which);
        root_rows(w->work.rows, w->blocks[which], rows, rows);
        sums_add(w->sums[which], &w->work, rows, rows);
        sums_clear(w->blocks[which], rows);
    }
}

/* A mean that has overflowed would teach. */
static kq_status em_smooth(estimation *e)
{
    const em_places w = em_at(e);
    const recording *r = e->recordings + e->recording;
    history *h = &e->history;
    num *state;
    if (e->step == r->steps) {
        smooth_begin(h);
        state = history_slot(h, e->states, (size_t)h->steps - 1);
    } else {
        state = em_undo_predict(e, &w);
    }
    e->step--;
    em_undo_updates(e, &w, state, present_at(e, r, e->step));
    if (e->step % EM_BLOCK == 0) em_end_block(e, &w);
    if (h->events & KQ_EVENT_OVERFLOW) return KQ_ERR_LIKELIHOOD;
    if (e->step > 0) return KQ_OK;
    em_add_start(e, &w);
    e->recording++;
    e->phase = EM_FILTERING;
    return KQ_OK;
}

#endif
