/*
 * Statistical linearisation by sigma points, in floating point.
 *
 * Pairs x +- h S_j about a density (x, S), and its centre.  Of the values at a pair, half the difference over h is
 * column j of D = J S, J the linear function that is nearest to g under that density: Cov(g, x) = J P.  The sums
 * over both, less the centre's twice, are the bends; they make the mean, and a root E of what J leaves:
 *     Cov(g) = D D' + E E'
 * Both rules have weights >= 0: nothing is ever subtracted from a covariance.
 */
#ifndef KQ_SRC_NONLINEAR_LINEARISE_FLOAT_H
#define KQ_SRC_NONLINEAR_LINEARISE_FLOAT_H

#include "../filter/filter.h"

/* What is called, and where */
typedef struct {
    const filter *at;
    T(kq_function) *g;
    void *context;
    int rows;
    kq_sigma_points rule;
} sampling;

/* What a rule is: pairs `h` sigma out, h^2 = `square`; of what bends E is `share`, less `common` of its mean */
typedef struct {
    num square, h, share, common;
} weights;

/* The row of one component: values at the pairs, `plus` in D and `minus` in E, become half their difference over
   h and a row of what a linear function leaves.  y: the value at the centre becomes the mean.  Answers 0, or no
   number where one of them is none. */
KQ_KERNEL num close_row_of(num *y, num *D, num *E, weights by, int n)
{
    num shift = 0, none = 0;
    for (int j = 0; j < n; j++) {
        const num plus = D[j], minus = E[j];
        D[j] = num_half / by.h * (plus - minus);
        E[j] = (plus - *y) + (minus - *y);
        shift += E[j];
    }
    shift /= by.square;
    *y += num_half * shift;
    for (int j = 0; j < n; j++) {
        E[j] = by.share * (E[j] - by.common * shift);
        none += (E[j] - E[j]) + (D[j] - D[j]);
    }
    return none + (*y - *y);
}

/* g at x, spread over a column of M, in rows of `stride`.  What it does not write is no number. */
static void sample_point(const sampling *q, const num *x, num *M, int stride)
{
    num value[KQ_SIZE_MAX];
    for (int c = 0; c < q->rows; c++) value[c] = num_nan();
    q->g(q->context, x, value);
    for (int c = 0; c < q->rows; c++) M[c * stride] = value[c];
}

/* The values at all points: the centre's in y; at x + h S_j in D, at x - h S_j in E */
static void sample_points(const sampling *q, num *y, num *D, num *E, num h)
{
    num centre[KQ_SIZE_MAX], x[KQ_SIZE_MAX];
    const int n = q->at->states;
    const num *s = filter_root(q->at);
    x[0] = 0; /* n > 0: of that some compilers are not sure */
    for (int i = 0; i < n; i++) x[i] = centre[i] = mean_get(q->at->memory, n, i);
    sample_point(q, x, y, 1);
    for (int j = 0; j < n; j++) {
        num *M = D, c = h;
        for (int sides = 0; sides < 2; sides++) {
            for (int i = 0; i <= j; i++) x[i] = centre[i] + c * s[i]; /* behind j x is still at the centre */
            sample_point(q, x, M + j, n);
            M = E;
            c = -h;
        }
        s += j + 1;
    }
}

/* The mean of g into y; D and E, rows x n */
static kq_status sample(const sampling *q, num *y, num *D, num *E)
{
    const int n = q->at->states;
    weights by = {3, num_root(3), num_root(2) / 6, 0};
    num none = 0;
    if (!q->g) return KQ_ERR_NULL;
    if (q->rule != KQ_SIGMA_POINTS_CUBATURE && q->rule != KQ_SIGMA_POINTS_CENTRAL) return KQ_ERR_RANGE;
    if (q->rule == KQ_SIGMA_POINTS_CUBATURE) {
        by.square = (num)n;
        by.h = num_root(by.square);
        by.share = num_half / by.h;
        by.common = 1;
    }
    sample_points(q, y, D, E, by.h);
    for (int c = 0; c < q->rows; c++) {
        none += close_row_of(y + c, D, E, by, n);
        D += n;
        E += n;
    }
    return none == 0 ? KQ_OK : KQ_ERR_NOT_FINITE;
}

/* D <- D S^-1, rows of n.  A pivot that is rounding of its row of S says nothing: the coefficient is 0, and the
   columns behind it say what there is to say. */
static void divide_by_root(num *D, const num *s, int rows, int n)
{
    for (int j = 0; j < n; j++) {
        const num *entry = s + j, pivot = *entry;
        num size = 0;
        for (int k = j; k < n; entry += ++k) size += num_magnitude(*entry);
        const num inverse = pivot <= 4 * num_epsilon * size ? 0 : 1 / pivot;
        num *row = D;
        for (int c = 0; c < rows; c++) {
            row[j] = (row[j] - dot(0, row, s, j)) * inverse;
            row += n;
        }
        s += j + 1;
    }
}

kq_status T(kq_linearise)(const filter *at, T(kq_function) *g, void *context, int rows, kq_sigma_points rule, num *y,
                          num *J, num *E)
{
    const sampling q = {at, g, context, rows, rule};
    kq_status status = state_check_known(at);
    if (status) return status;
    if (!y || !J || !E) return KQ_ERR_NULL;
    if (!size_is_valid(rows)) return KQ_ERR_SIZE;
    status = sample(&q, y, J, E);
    if (!status) divide_by_root(J, filter_root(at), rows, at->states);
    return status;
}

#endif
