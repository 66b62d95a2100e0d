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

#include "kalmanq/points.h"
#include "kalmanq/size.h"
#include "kalmanq/status.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/compiler.h"
#include "../arithmetic/mean.h"
#include "../arithmetic/root.h"
#include "../arithmetic/rows.h"
#include "../arithmetic/scaled.h"
#include "../arithmetic/size.h"
#include "../arithmetic/triangle.h"
#include "../model/types.h"
#include "../model/units.h"
#include "../filter/filter.h"

/* What is called, and where */
typedef struct {
    const filter *at;
    T(kq_function) *g;
    void *context;
    int rows;
    kq_points rule;
} sampling;

static kq_status sampling_check(const sampling *q)
{
    const kq_status status = filter_check(q->at);
    if (status) return status;
    if (!q->g) return KQ_ERR_NULL;
    if (!size_is_valid(q->rows)) return KQ_ERR_SIZE;
    return q->rule == KQ_POINTS_CUBATURE || q->rule == KQ_POINTS_CENTRAL ? KQ_OK : KQ_ERR_RANGE;
}

/* x = centre + c S_j */
static void point_at(num *x, const num *centre, const num *S, int j, num c, int n)
{
    copy(x, centre, n);
    for (int i = 0; i <= j; i++) x[i] += c * S[column(j) + i];
}

/* g at x.  What it does not write is no number. */
static void value_at(const sampling *q, const num *x, num *y)
{
    for (int c = 0; c < q->rows; c++) y[c] = num_nan();
    q->g(q->context, x, y);
}

/* Pair j, h sigma out: its columns of D and of the bends, whose sum goes into y */
static void sample_pair(const sampling *q, const num *centre, const num *middle, int j, num h, num *y, num *D,
                        num *bends, int stride)
{
    num x[KQ_SIZE_MAX], plus[KQ_SIZE_MAX], minus[KQ_SIZE_MAX];
    const int n = q->at->states;
    const num *S = filter_root(q->at), part = num_half / h;
    point_at(x, centre, S, j, h, n);
    value_at(q, x, plus);
    point_at(x, centre, S, j, -h, n);
    value_at(q, x, minus);
    for (int c = 0; c < q->rows; c++) {
        const num bend = (plus[c] - middle[c]) + (minus[c] - middle[c]);
        D[c * stride + j] = part * (plus[c] - minus[c]);
        bends[c * stride + j] = bend;
        y[c] += bend;
    }
}

/* The mean of g into y; D and E, rows of `stride`.  Answers whether all of it is finite. */
static int sample(const sampling *q, num *y, num *D, num *E, int stride)
{
    num centre[KQ_SIZE_MAX] = {0}, middle[KQ_SIZE_MAX];
    const int n = q->at->states, cubature = q->rule == KQ_POINTS_CUBATURE;
    const num square = cubature ? (num)n : 3, h = num_root(square);
    const num share = cubature ? num_half / h : num_root(square - 1) / (2 * square);
    int finite = 1;
    mean_copy(centre, q->at->memory, n);
    value_at(q, centre, middle);
    for (int c = 0; c < q->rows; c++) y[c] = 0;
    for (int j = 0; j < n; j++) sample_pair(q, centre, middle, j, h, y, D, E, stride);
    for (int c = 0; c < q->rows; c++) {
        y[c] /= 2 * square;
        const num common = cubature ? y[c] / h : 0; /* the bends' own mean is no spread */
        for (int j = 0; j < n; j++) E[c * stride + j] = share * E[c * stride + j] - common;
        y[c] += middle[c];
        finite &= all_finite(D + c * stride, n) && all_finite(E + c * stride, n) && num_is_finite(y[c]);
    }
    return finite;
}

/* D <- D S^-1, rows of n.  A pivot that is rounding of its row of S says nothing: the coefficient is 0, and the
   columns behind it say what there is to say. */
static void divide_by_root(num *D, const num *S, int rows, int n)
{
    for (int j = 0; j < n; j++) {
        const num pivot = S[column(j) + j];
        num size = 0;
        for (int k = j; k < n; k++) size += num_magnitude(S[column(k) + j]);
        const num inverse = pivot <= 4 * num_epsilon * size ? 0 : 1 / pivot;
        for (int c = 0; c < rows; c++) {
            num *row = D + c * n;
            row[j] = (row[j] - dot(0, row, S + column(j), j)) * inverse;
        }
    }
}

kq_status T(kq_linearise)(const filter *at, T(kq_function) *g, void *context, int rows, kq_points rule, num *y,
                          num *J, num *E)
{
    const sampling q = {at, g, context, rows, rule};
    const kq_status status = sampling_check(&q);
    if (status) return status;
    if (!y || !J || !E) return KQ_ERR_NULL;
    if (!sample(&q, y, J, E, at->states)) return KQ_ERR_NOT_FINITE;
    divide_by_root(J, filter_root(at), rows, at->states);
    return KQ_OK;
}

#endif
