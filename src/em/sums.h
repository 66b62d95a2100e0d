/*
 * What an iteration remembers of all steps: noises, and what explains them.  A SUM is the upper
 * triangular root U of
 *     sum over steps of E[(e; x)(e; x)' | all] = U U',      U = [U11 U12; 0 U22]
 * where e are k noises in units of their root L (of a covariance L L', so that E[e e'] is I) and x
 * p regressors.  Least squares of e on x has the coefficients U12 U22^-1 and leaves U11 U11'.
 * With coefficients that are to be held, the residual is [U11 Y], Y = U12 less what x explains.
 */
#ifndef KQ_SRC_EM_SUMS_H
#define KQ_SRC_EM_SUMS_H

#include "../model/model.h"

typedef struct {
    int noises;     /* k */
    int regressors; /* p, 0 where nothing explains e */
    num *root;      /* U */
    num count;      /* steps */
} sums;

/* Scratch: for k + p rows of one number more, their pivots, and a root of as many */
typedef struct {
    num *rows;
    num *pivots;
    num *spare;
} sums_work;

static void sums_clear(num *root, int rows)
{
    for (int k = 0; k < KQ_TRIANGLE(rows); k++) root[k] = 0;
    for (int k = 0; k < rows; k++) root[column(k) + k] = num_tiny_root; /* model/advance.h: a pivot */
}

/* The first rows of a root of `width`, with its zeros */
static void root_rows(num *W, const num *root, int rows, int width)
{
    for (int i = 0; i < rows; i++) {
        for (int j = 0; j < width; j++) W[i * width + j] = j < i ? 0 : root[column(j) + i];
    }
}

/* U <- tria [U, W], W being the work's rows of `width` */
KQ_NOINLINE static void sums_add(num *root, const sums_work *w, int rows, int width)
{
    const process before = {.noise_root = w->spare};
    copy(w->spare, root, KQ_TRIANGLE(rows));
    triangularise(root, w->rows, width, &before, rows, w->pivots, SHAPE_DENSE);
}

/* U = tria W */
KQ_NOINLINE static void sums_make(const sums *s, const sums_work *w, int width)
{
    triangularise(s->root, w->rows, width, 0, s->noises + s->regressors, w->pivots, SHAPE_FULL);
}

/* ------------------------------------------------------------------ least squares */

/* Is the rest of regressor j that the ones behind it leave no more than rounding, or what stands
   for 0 in every step? */
static int is_explained_by_others(const sums *s, int j)
{
    const int rows = s->noises + s->regressors, i = s->noises + j;
    num total = 0;
    for (int k = i; k < rows; k++) total += s->root[column(k) + i] * s->root[column(k) + i];
    const num rest = s->root[column(i) + i];
    return rest <= 16 * num_epsilon * num_root(total) || rest <= 2 * s->count * num_tiny_root;
}

/* c (p) <- row i of U12 U22^-1, with 0 for what other regressors explain */
static void sums_coefficients(num *c, const sums *s, int i)
{
    for (int j = 0; j < s->regressors; j++) {
        const num *u = s->root + column(s->noises + j);
        num rest = u[i];
        for (int k = 0; k < j; k++) rest -= c[k] * u[s->noises + k];
        c[j] = is_explained_by_others(s, j) ? 0 : rest / u[s->noises + j];
    }
}

/* ------------------------------------------------------------------ coefficients */

static int is_live(const num *L, int i) { return L[column(i) + i] > num_tiny_root; }

/* M <- L M, n rows of `width`; exactly 0 where there is no noise */
static void root_times_rows(const num *L, num *M, int n, int width)
{
    for (int i = 0; i < n; i++) {
        const num pivot = is_live(L, i) ? L[column(i) + i] : 0;
        for (int c = 0; c < width; c++) {
            num total = pivot * M[i * width + c];
            for (int k = i + 1; k < n; k++) total += L[column(k) + i] * M[k * width + c];
            M[i * width + c] = total;
        }
    }
}

/* M <- L^-1 M, n rows of `width`; 0 where there is no noise */
static void rows_over_root(const num *L, num *M, int n, int width)
{
    for (int i = n - 1; i >= 0; i--) {
        for (int c = 0; c < width; c++) {
            num rest = M[i * width + c];
            for (int k = i + 1; k < n; k++) rest -= L[column(k) + i] * M[k * width + c];
            M[i * width + c] = is_live(L, i) ? rest / L[column(i) + i] : 0;
        }
    }
}

/* y (p), a row of U12, less what the coefficients c explain of it: all where a regressor has one */
static void keep_unexplained(num *y, const num *c, const sums *s)
{
    for (int j = 0; j < s->regressors; j++) {
        const num *u = s->root + column(s->noises + j) + s->noises;
        num rest = y[j];
        for (int h = 0; h < j; h++) rest -= c[h] * u[h];
        y[j] = is_explained_by_others(s, j) ? rest : 0;
    }
}

/* coefficients (k x p) += L U12 U22^-1; E's last p columns keep what x does not explain: in the
   columns of regressors that others explain, which hold rounding of x, but noise of E */
static void explain_freely(num *coefficients, num *E, const sums *s, const num *L)
{
    const int k = s->noises, p = s->regressors;
    num c[KQ_SIZE_MAX];
    for (int q = 0; q < k; q++) {
        if (!is_live(L, q)) continue; /* no noise, nothing to be explained */
        sums_coefficients(c, s, q);
        for (int i = 0; i <= q; i++) {
            for (int j = 0; j < p; j++) coefficients[i * p + j] += L[column(q) + i] * c[j];
        }
        keep_unexplained(E + q * (k + p) + k, c, s);
    }
}

/* c (n) <- column i of L^-1.  Answers whether row i of the noises can move without the others: not
   if there is no noise, and not if one without noise of its own depends on it by more than
   rounding. */
static int inverse_column(num *c, const num *L, int n, int i)
{
    for (int q = 0; q < n; q++) c[q] = 0;
    if (!is_live(L, i)) return 0;
    c[i] = 1 / L[column(i) + i];
    for (int q = i - 1; q >= 0; q--) {
        num total = 0, square = 0;
        for (int j = q + 1; j < n; j++) {
            total -= L[column(j) + q] * c[j];
            square += L[column(j) + q] * L[column(j) + q];
        }
        const num rounding = 16 * num_epsilon * num_root(square * dot(0, c, c, n));
        if (is_live(L, q)) c[q] = total / L[column(q) + q];
        else if (num_magnitude(total) > rounding) return 0;
    }
    return 1;
}

/* The sum of one noise, t (p), and the regressors that are not held; `w` is behind E. */
static sums sums_of_row(const num *t, const sums *s, const uint8_t *held, const sums_work *w)
{
    const int k = s->noises, p = s->regressors;
    sums row = {1, 0, w->spare, s->count};
    copy(w->rows, t, p);
    for (int j = 0; j < p; j++) {
        if (held[j]) continue;
        num *to = w->rows + ++row.regressors * p;
        for (int c = 0; c < p; c++) to[c] = c < j ? 0 : s->root[column(k + c) + k + j];
    }
    sums_make(&row, w, p);
    return row;
}

/* The free entries of row i, the other rows as they are; Y loses what they explain. */
static void explain_row(num *coefficients, num *E, const sums *s, const num *L, int i,
                        const uint8_t *held, const sums_work *w)
{
    const int k = s->noises, p = s->regressors, width = k + p;
    num c[KQ_SIZE_MAX], t[KQ_SIZE_MAX], delta[KQ_SIZE_MAX];
    if (!inverse_column(c, L, k, i)) return;
    const num square = dot(0, c, c, i + 1);
    for (int j = 0; j < p; j++) {
        num total = 0;
        for (int q = 0; q <= i; q++) total += c[q] * E[q * width + k + j];
        t[j] = total / square;
    }
    const sums row = sums_of_row(t, s, held, w);
    sums_coefficients(delta, &row, 0);
    for (int j = 0, at = 0; j < p; j++) {
        if (held[j]) continue;
        const num d = delta[at++];
        coefficients[i * p + j] += d;
        for (int q = 0; q <= i; q++) {
            for (int h = j; h < p; h++) {
                E[q * width + k + h] -= c[q] * d * s->root[column(k + h) + k + j];
            }
        }
    }
}

/* coefficients (k x p): the estimate as it is, moved to the best one; `held` as the coefficients,
   or NULL.  E is left holding the residual; behind it (1 + p) (p + 2) + KQ_TRIANGLE(1 + p) words
   are scratch, which leaves it within the work of a step. */
static void explain(num *coefficients, num *E, const sums *s, const num *L, const uint8_t *held)
{
    const int k = s->noises, p = s->regressors;
    if (!held) {
        explain_freely(coefficients, E, s, L);
        return;
    }
    num *behind = E + k * (k + p); /* scratch */
    const sums_work w = {behind, behind + (1 + p) * p, behind + (1 + p) * (p + 2)};
    for (int i = k - 1; i >= 0; i--) explain_row(coefficients, E, s, L, i, held + i * p, &w);
}

/* ------------------------------------------------------------------ covariance */

/* Of the noises whose coordinates are live, in units of their covariance: 1 if it is right */
static num noise_multiple(const num *E, const sums *s, const num *L)
{
    const int width = s->noises + s->regressors;
    num total = 0;
    int live = 0;
    for (int i = 0; i < s->noises; i++) {
        if (!is_live(L, i)) continue;
        total += dot(0, E + i * width, E + i * width, width);
        live++;
    }
    return live ? total / (s->count * (num)live) : 1;
}

/* covariance (n x n) <- M M' / count */
static void covariance_of(num *covariance, const num *M, int n, int width, num count)
{
    for (int i = 0; i < n; i++) {
        for (int j = i; j < n; j++) {
            covariance[i * n + j] = covariance[j * n + i] =
                dot(0, M + i * width, M + j * width, width) / count;
        }
    }
}

static void keep_diagonal(num *covariance, int n)
{
    for (int k = 0; k < n * n; k++) {
        if (k % (n + 1)) covariance[k] = 0;
    }
}

/* ------------------------------------------------------------------ gradient */

/* M <- L^-T M, n rows of `width`; NaN where L has no noise */
static void rows_over_transpose(const num *L, num *M, int n, int width)
{
    for (int i = 0; i < n; i++) {
        for (int c = 0; c < width; c++) {
            num rest = M[i * width + c];
            for (int k = 0; k < i; k++) {
                const num entry = L[column(i) + k];
                if (entry != 0) rest -= entry * M[k * width + c];
            }
            M[i * width + c] = is_live(L, i) ? rest / L[column(i) + i] : num_nan();
        }
    }
}

/* out (k x k) <- L^-T (E E' - count I) L^-1 / 2, E k rows of `width` */
static void covariance_gradient(num *out, const num *E, const num *L, int k, int width, num count)
{
    covariance_of(out, E, k, width, 2);
    for (int i = 0; i < k; i++) out[i * k + i] -= count / 2;
    rows_over_transpose(L, out, k, k);
    transpose(out, k);
    rows_over_transpose(L, out, k, k);
}

/* out (k x p) <- L^-T U12 U22' */
static void coefficient_gradient(num *out, const sums *s, const num *L)
{
    const int k = s->noises, p = s->regressors;
    for (int i = 0; i < k; i++) {
        for (int j = 0; j < p; j++) {
            num total = 0;
            for (int c = k + j; c < k + p; c++) {
                total += s->root[column(c) + i] * s->root[column(c) + k + j];
            }
            out[i * p + j] = total;
        }
    }
    rows_over_transpose(L, out, k, p);
}

#endif
