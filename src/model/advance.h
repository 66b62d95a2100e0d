/*
 * The time update of the root: [A S, G] Theta = [0, S-], Theta orthogonal, S- upper triangular.
 *
 * Householder, row by row from the last.  The reflector of row i takes its pivot in column i
 * of G, not in A S: a row of A S is finished before the next one begins, G stays triangular
 * and is read in place, and column i of S- is just (row . row_i) / norm(row_i).
 *     v_i = (w_i, g_ii + s_i),  s_i = norm(w_i, g_ii)
 * The sign of each column is turned so that S-_ii >= 0.  What is kept of v_i in p_i and q_i is
 * the arithmetic's own (reflect, close_reflector).
 */
#ifndef KQ_SRC_MODEL_ADVANCE_H
#define KQ_SRC_MODEL_ADVANCE_H

#include "process.h"

/* Row l of A as coefficients of the rows of S, in the place of row l of W or where they are.  The
   row gets an exponent that its row of G fits too. */
KQ_KERNEL const num *align_transition(num *w, const process *m, const num *S, int n, int l, int c)
{
    int32_t exponent = noise_exponent(m->noise_root, n, l);
    const num *a =
        align(w + c, m->transition + l * n + c, exponents_of(S, n) + c, 1, n - c, &exponent);
    row_set_exponent(w, n, exponent);
    return a;
}

/* Row l of W = A S, from column first_column on; to the left of it A's rows >= l are 0. */
KQ_KERNEL void transition_row(num *W, const process *m, const num *S, int n, int l, int shape)
{
    const int c = first_column(m, l, shape);
    num *w = W + l * ROW_LEN(n);
    const num *a = align_transition(w, m, S, n, l, c);
    row_times_triangle(w + c, a, S + column(n - 1) + c, c, n);
}

/* Rows l and l + 1: a column of S is loaded once for both. */
KQ_KERNEL void two_transition_rows(num *W, const process *m, const num *S, int n, int l, int shape)
{
    const int c = first_column(m, l, shape);
    num *w = W + l * ROW_LEN(n), *v = w + ROW_LEN(n);
    const num *a = align_transition(w, m, S, n, l, c);
    const num *b = align_transition(v, m, S, n, l + 1, c);
    two_rows_times_triangle(w + c, v + c, a, b, S + column(n - 1) + c, c, n);
}

KQ_KERNEL void transition_times_root(num *W, const process *m, const num *S, int n, int shape)
{
    int l = 0;
    KQ_UNROLL
    for (; rows_in_pairs && l + 1 < n; l += 2) two_transition_rows(W, m, S, n, l, shape);
    KQ_UNROLL
    for (; l < n; l++) transition_row(W, m, S, n, l, shape);
}

/*
 * The rows of [W, G] on their way into S.  W: n rows of `width`, the rows l and below of it
 * starting at column first_column(model, l, shape).  SHAPE_FULL: there is no model and no G.
 */
typedef struct {
    num *S, *W;
    int n, width;
    const process *model;
    num *pq; /* 2 words a reflector */
    int shape;
} triangle_work;

/* Row l, reflected by all rows below, becomes a reflector itself. */
KQ_KERNEL extent close_row(const triangle_work *t, int l)
{
    const int c = first_column(t->model, l, t->shape);
    const num *G = t->shape != SHAPE_FULL ? t->model->noise_root : 0;
    num *w = t->W + l * ROW_LEN(t->width);
    const num g = t->shape != SHAPE_FULL
                      ? noise_word(G + column(l) + l, noise_shift(G, t->n, l, w, t->width))
                      : num_no_noise;
    KQ_IN_ORDER;
    const num pivot = close_reflector(w + c, g, t->pq + 2 * l, t->width - c);
    t->S[column(l) + l] = pivot;
    root_take_exponent(t->S, t->n, l, w, t->width);
    return extent_of(pivot);
}

KQ_KERNEL int32_t row_noise_shift(const triangle_work *t, int l)
{
    const num *w = t->W + l * ROW_LEN(t->width);
    return t->shape != SHAPE_FULL ? noise_shift(t->model->noise_root, t->n, l, w, t->width) : 0;
}

/* Row l by the reflector of row i; shift: that of the row's noise */
KQ_KERNEL extent reflect_row(const triangle_work *t, int l, int i, int32_t shift)
{
    const int c = first_column(t->model, i, t->shape);
    const num *g = t->shape != SHAPE_FULL ? t->model->noise_root + column(i) + l : 0;
    const num noise = t->shape != SHAPE_FULL ? noise_word(g, shift) : 0;
    const num entry =
        reflect(t->W + l * ROW_LEN(t->width) + c, noise, t->W + i * ROW_LEN(t->width) + c,
                t->shape != SHAPE_FULL ? reflector_pivot(g + i - l) : 0, t->pq + 2 * i,
                t->width - c);
    t->S[column(i) + l] = entry;
    return extent_of(entry);
}

/* Row l by all reflectors below */
KQ_KERNEL extent reflect_one_row(const triangle_work *t, int l, extent far)
{
    const int32_t shift = row_noise_shift(t, l);
    KQ_UNROLL
    for (int i = t->n - 1; i > l; i--) far = extent_join(far, reflect_row(t, l, i, shift));
    return far;
}

/* Rows l and l - 1 by all reflectors below */
KQ_KERNEL extent reflect_two_rows(const triangle_work *t, int l, extent far)
{
    const int n = t->n, stride = ROW_LEN(t->width);
    const num *G = t->shape != SHAPE_FULL ? t->model->noise_root : 0, *g = G;
    if (t->shape != SHAPE_FULL) g += column(n - 1) + l;
    num *w = t->W + l * stride, *v = w - stride, *s = t->S + column(n - 1) + l;
    const num *r = t->W + (n - 1) * stride, *pq = t->pq + 2 * (n - 1);
    const int32_t shift_w = row_noise_shift(t, l), shift_v = row_noise_shift(t, l - 1);
    KQ_UNROLL
    for (int i = n - 1; i > l; i--) {
        const int c = first_column(t->model, i, t->shape);
        const num noise_w = t->shape != SHAPE_FULL ? noise_word(g, shift_w) : 0;
        const num noise_v = t->shape != SHAPE_FULL ? noise_word(g - 1, shift_v) : 0;
        const num pivot = t->shape != SHAPE_FULL ? reflector_pivot(g + i - l) : 0;
        far = reflect_two(far, s, w + c, v + c, noise_w, noise_v, r + c, pivot, pq, t->width - c);
        s -= i;
        if (t->shape != SHAPE_FULL) g -= i;
        r -= stride;
        pq -= 2;
    }
    return far;
}

/* [W, G] Theta = [0, S].  On return W and pq hold the reflectors, and S is yet to be renormalised.
   Rows are taken two at a time, so that a reflector is loaded once for both.  Answers how far S reaches. */
KQ_KERNEL extent triangularise(num *S, num *W, int width, const process *model, int n, num *pq,
                             int shape)
{
    const triangle_work t = {S, W, n, width, model, pq, shape};
    extent far = 0;
    KQ_UNROLL
    for (int l = n; l-- > 0;) {
        if (!rows_in_pairs) far = reflect_one_row(&t, l, far);
        else if (l & 1) far = reflect_two_rows(&t, l, far);
        else if (l < n - 1) far = extent_join(far, reflect_row(&t, l, l + 1, row_noise_shift(&t, l)));
        far = extent_join(far, close_row(&t, l));
    }
    return far;
}

KQ_KERNEL extent predict_root_of(num *predicted, const num *root, const process *m, num *W, num *pq,
                               int n, int shape)
{
    transition_times_root(W, m, root, n, shape);
    KQ_IN_ORDER;
    return triangularise(predicted, W, n, m, n, pq, shape);
}

/*
 * predicted <- tria [A root, G], yet to be renormalised; the two may be the same array.  W (n rows)
 * and pq (2 n) are left holding Theta's reflectors.  One function for filter and smoother: the
 * smoother must meet the very factor that the filter used.
 */
KQ_NOINLINE static extent predict_root(num *predicted, const num *root, const process *m, num *W,
                                      num *pq)
{
    return predict_root_of(predicted, root, m, W, pq, m->states, SHAPE_AS_FOUND);
}

/* x <- A t + B u with l controls, t being a copy of x.  Answers how far the mean reaches. */
KQ_INLINE extent predict_mean_of(num *x, const process *m, const num *u, int l, const num *t, int n,
                                int shape)
{
    const scaled *row = m->transition, *control = m->control;
    extent far = 0;
    KQ_UNROLL
    for (int i = 0; i < n; i++) {
        sum drive = 0;
        if (u) {
            drive = control_drive(control, u, l);
            control += l;
        }
        far = extent_join(far, mean_advance(x, n, i, row, first_column(m, i, shape), t, u ? &drive : 0));
        row += n;
    }
    return far;
}

/* x <- A x + B u; t: scratch, MEAN_PLANES n */
KQ_INLINE extent predict_mean(num *x, const process *m, const num *u, num *t, int n, int shape)
{
    mean_copy(t, x, n);
    if (mean_rounds && (m->plain & PROCESS_ROUNDED)) mean_take_rests(x, m->transition, t, n);
    return predict_mean_of(x, m, u, m->controls, t, n, shape);
}

/* The scratch lives on the stack, in a few sizes. */
#define PREDICT_SCRATCH(n) ((n)*ROW_LEN(n) + 2 * (n))

/* One text for all sizes of scratch */
KQ_NOINLINE static unsigned predict_any(num *x, num *S, const process *m, const num *u,
                                        num *scratch)
{
    const int n = m->states;
    num *pq = scratch + n * ROW_LEN(n);
    const extent far = predict_mean(x, m, u, scratch, n, SHAPE_AS_FOUND);
    const extent of_root = predict_root(S, S, m, scratch, pq);
    renormalise(S, n);
    return state_saturated(x, S, n, extent_join(far, of_root));
}

KQ_NOINLINE static unsigned predict_to_4(num *x, num *S, const process *m, const num *u)
{
    num scratch[PREDICT_SCRATCH(4)];
    return predict_any(x, S, m, u, scratch);
}

KQ_NOINLINE static unsigned predict_to_9(num *x, num *S, const process *m, const num *u)
{
    num scratch[PREDICT_SCRATCH(9)];
    return predict_any(x, S, m, u, scratch);
}

KQ_NOINLINE static unsigned predict_to_16(num *x, num *S, const process *m, const num *u)
{
    num scratch[PREDICT_SCRATCH(16)];
    return predict_any(x, S, m, u, scratch);
}

/* Answers the events. */
KQ_KERNEL unsigned predict_state(num *x, num *S, const process *m, const num *u)
{
    if (m->states <= 4) return predict_to_4(x, S, m, u);
    if (m->states <= 9) return predict_to_9(x, S, m, u);
    return predict_to_16(x, S, m, u);
}

#endif
