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

/* The first `count` entries of x: centre + c s */
static void point_at(num *x, const num *centre, const num *s, num c, int count)
{
    for (int i = 0; i < count; i++) x[i] = centre[i] + c * s[i];
}

/* Pair j, h sigma out: its columns of D and of the bends.  x is at the centre from entry j on, and S is upper
   triangular: entry j + 1 and those behind it stay. */
static void sample_pair(const sampling *q, const num *centre, const num *middle, num *x, int j, num h, num *D,
                        num *bends, int stride)
{
    num plus[KQ_SIZE_MAX], minus[KQ_SIZE_MAX];
    const num *s = filter_root(q->at) + column(j), part = num_half / h;
    point_at(x, centre, s, h, j + 1);
    q->g(q->context, x, plus);
    point_at(x, centre, s, -h, j + 1);
    q->g(q->context, x, minus);
    for (int c = 0; c < q->rows; c++) {
        D[j] = part * (plus[c] - minus[c]);
        bends[j] = (plus[c] - middle[c]) + (minus[c] - middle[c]);
        D += stride;
        bends += stride;
    }
}

/* A row of bends becomes one of E, and y the mean.  Answers 0, or what is no number where one of them is not. */
static num close_sample(const sampling *q, num *y, num middle, const num *D, num *E, num square, num h)
{
    const int n = q->at->states, cubature = q->rule == KQ_POINTS_CUBATURE;
    const num share = cubature ? num_half / h : num_root(square - 1) / (2 * square);
    num total = 0;
    for (int j = 0; j < n; j++) total += E[j];
    total /= 2 * square;
    *y = middle + total;
    const num common = cubature ? total / h : 0; /* the bends' own mean is no spread */
    num none = *y - *y;
    for (int j = 0; j < n; j++) {
        E[j] = share * E[j] - common;
        none += (E[j] - E[j]) + (D[j] - D[j]);
    }
    return none;
}

/* The mean of g into y; D and E, rows of `stride`.  Answers whether all of it is finite. */
static int sample(const sampling *q, num *y, num *D, num *E, int stride)
{
    num centre[KQ_SIZE_MAX], x[KQ_SIZE_MAX], middle[KQ_SIZE_MAX], none = 0;
    x[0] = 0; /* n > 0: of that some compilers are not sure */
    const int n = q->at->states;
    const num square = q->rule == KQ_POINTS_CUBATURE ? (num)n : 3, h = num_root(square);
    mean_copy(centre, q->at->memory, n);
    copy(x, centre, n);
    q->g(q->context, x, middle);
    for (int j = 0; j < n; j++) sample_pair(q, centre, middle, x, j, h, D, E, stride);
    for (int c = 0; c < q->rows; c++) {
        none += close_sample(q, y + c, middle[c], D + c * stride, E + c * stride, square, h);
    }
    return none == 0;
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
