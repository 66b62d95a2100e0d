/*
 * The upper triangular root of a covariance that may be singular.
 *
 * Cholesky with pivots: one column at a time, each for the row that keeps the largest share of its
 * variance, until no row keeps more than rounding; then the rows are brought back into their order.
 * Without pivots a column that is rounding alone could be scaled up.
 */
#ifndef KQ_SRC_MODEL_FACTOR_FLOAT_H
#define KQ_SRC_MODEL_FACTOR_FLOAT_H

#include "advance.h"

/* A pivot up to `rounding` of its row's norm becomes 0, and so does its column: what it holds of
   the rows above goes into theirs. */
KQ_COLD static void drop_pivots(num *S, int n, num rounding)
{
    for (int k = n - 1; k >= 0; k--) {
        num *pivot = S + column(k) + k, square = 0;
        for (int j = k + 1; j < n; j++) {
            if (S[column(j) + j] == 0) join_pivot(S + column(k), S + column(j), k);
        }
        for (int j = k; j < n; j++) square += S[column(j) + k] * S[column(j) + k];
        if (*pivot <= rounding * num_root(square) || *pivot <= num_tiny_root) *pivot = 0;
    }
}

/*
 * S S' = F F', F n x width, overwritten.  A row that is a combination of the rows below it is
 * left with rounding alone, up to 2 eps of its norm: its pivot and its column are 0.
 */
KQ_COLD static void root_of_factor(num *restrict S, num *restrict F, int n, int width)
{
    num pivots[REFLECTOR_LEN(KQ_SIZE_MAX)];
    (void)triangularise(S, F, width, 0, n, pivots, SHAPE_FULL);
    drop_pivots(S, n, 2 * num_epsilon);
}

/*
 * A covariance on its way into its root, from the last position to the first: which row each
 * position has, and the columns made so far, which begin at column `next`.
 */
typedef struct {
    num *S;
    const num *P;
    uint8_t *row;
    int n, next;
} pivoting;

/* P of two positions less what the columns made so far explain; reads P's upper triangle */
KQ_COLD static num unexplained(const pivoting *v, int i, int j)
{
    const int a = v->row[i], b = v->row[j];
    num rest = a < b ? v->P[a * v->n + b] : v->P[b * v->n + a];
    for (int k = v->next; k < v->n; k++) rest -= v->S[column(k) + i] * v->S[column(k) + j];
    return rest;
}

/* The position that keeps the largest share of its variance, more than `least`, or -1 */
KQ_COLD static int next_pivot(const pivoting *v, uint32_t present, num least)
{
    int best = -1;
    for (int j = v->next - 1; j >= 0; j--) {
        const num variance = v->P[v->row[j] * (v->n + 1)];
        if (!(present >> v->row[j] & 1) || variance == 0) continue;
        const num share = unexplained(v, j, j) / variance;
        if (share > least) {
            best = j;
            least = share;
        }
    }
    return best;
}

KQ_COLD static void swap_positions(pivoting *v, int i, int j)
{
    const uint8_t row = v->row[i];
    v->row[i] = v->row[j];
    v->row[j] = row;
    for (int k = v->next; k < v->n; k++) {
        num *s = v->S + column(k);
        const num entry = s[i];
        s[i] = s[j];
        s[j] = entry;
    }
}

/* Is what is left unexplained rounding, up to `rounding` sigma_i sigma_j?  What has overflowed is not. */
KQ_COLD static int is_explained(const pivoting *v, num rounding)
{
    for (int i = 0; i < v->next; i++) {
        for (int j = i; j < v->next; j++) {
            const int a = v->row[i], b = v->row[j];
            const num sigmas = num_root(v->P[a * (v->n + 1)]) * num_root(v->P[b * (v->n + 1)]);
            if (!(num_magnitude(unexplained(v, i, j)) <= rounding * sigmas)) return 0;
        }
    }
    return 1;
}

/* Columns with pivots as far as they go: a share of a variance up to `rounding` is none.  Rows whose
   bit in `present` is off count as 0. */
KQ_COLD static void make_columns(pivoting *v, uint32_t present, num rounding)
{
    for (int i = 0; i < v->n; i++) v->row[i] = (uint8_t)i;
    for (int j; (j = next_pivot(v, present, rounding)) >= 0; v->next--) {
        const int k = v->next - 1;
        swap_positions(v, j, k);
        num *s = v->S + column(k);
        const num root = num_root(unexplained(v, k, k));
        for (int i = 0; i < k; i++) {
            s[i] = present >> v->row[i] & 1 ? unexplained(v, i, k) / root : 0;
        }
        s[k] = root;
    }
    for (int k = 0; k < KQ_TRIANGLE(v->next); k++) v->S[k] = 0;
}

/*
 * The rows k and k + 1 change places.  What comes to stand below the diagonal is turned into the
 * pivot behind it.
 */
KQ_COLD static void exchange_rows(num *S, int n, int k)
{
    num *s = S + column(k), *t = S + column(k + 1);
    const num low = s[k], length = num_root(low * low + t[k] * t[k]), pivot = t[k + 1];
    const num cosine = length > 0 ? t[k] / length : 0, sine = length > 0 ? low / length : 1;
    for (int i = 0; i < k; i++) {
        const num old = s[i];
        s[i] = sine * t[i] - cosine * old;
        t[i] = cosine * t[i] + sine * old;
    }
    s[k] = sine * pivot;
    t[k] = cosine * pivot;
    t[k + 1] = length;
    for (int j = k + 2; j < n; j++) {
        num *u = S + column(j) + k;
        const num entry = u[0];
        u[0] = u[1];
        u[1] = entry;
    }
}

KQ_COLD static void sort_rows(pivoting *v)
{
    for (int end = v->n - 1; end > 0; end--) {
        for (int k = 0; k < end; k++) {
            const uint8_t row = v->row[k];
            if (row < v->row[k + 1]) continue;
            v->row[k] = v->row[k + 1];
            v->row[k + 1] = row;
            exchange_rows(v->S, v->n, k);
        }
    }
}

/* A share of a variance up to it is rounding. */
KQ_COLD static num root_rounding(int n) { return (num)(8 * n) * num_epsilon; }

/* row: n, scratch */
KQ_COLD KQ_NOINLINE static void begin_root(pivoting *v, uint8_t *row, num *S, const num *P, int n,
                                           uint32_t present)
{
    v->S = S;
    v->P = P;
    v->row = row;
    v->n = v->next = n;
    make_columns(v, present, root_rounding(n));
}

KQ_COLD KQ_NOINLINE static void end_root(pivoting *v)
{
    sort_rows(v);
    drop_pivots(v->S, v->n, root_rounding(v->n));
}

/* P = S S', P having passed covariance_check.  If more is left of it than twice the rounding, it is
   not a covariance. */
KQ_COLD static kq_status root_by_rows(num *restrict S, const num *restrict P, int n, uint8_t *row)
{
    pivoting v;
    begin_root(&v, row, S, P, n, UINT32_MAX);
    if (!is_explained(&v, 2 * root_rounding(n))) return KQ_ERR_NOT_SEMIDEFINITE;
    end_root(&v);
    return KQ_OK;
}

KQ_COLD static kq_status root_of(num *restrict S, const num *restrict P, int n)
{
    uint8_t row[KQ_SIZE_MAX];
    return root_by_rows(S, P, n, row);
}

/* The root of a covariance that has been found to be one, or of the rows and columns in `present` */
KQ_COLD KQ_NOINLINE static void root_of_covariance(num *restrict S, const num *restrict P, int n,
                                                   uint32_t present)
{
    pivoting v;
    uint8_t row[KQ_SIZE_MAX];
    begin_root(&v, row, S, P, n, present);
    end_root(&v);
}

/* root_of, which leaves S alone if P is no covariance; the scratch lives on the stack, in a few
   sizes. */
KQ_COLD KQ_NOINLINE static kq_status root_by(num *S, const num *P, int n, num *scratch)
{
    const kq_status status = root_of(scratch, P, n);
    if (!status) copy(S, scratch, KQ_TRIANGLE(n));
    return status;
}

KQ_COLD KQ_NOINLINE static kq_status root_to_4(num *S, const num *P, int n)
{
    num scratch[KQ_TRIANGLE(4)];
    return root_by(S, P, n, scratch);
}

KQ_COLD KQ_NOINLINE static kq_status root_to_16(num *S, const num *P, int n)
{
    num scratch[KQ_TRIANGLE(KQ_SIZE_MAX)];
    return root_by(S, P, n, scratch);
}

KQ_COLD static kq_status root_or_refuse(num *S, const num *P, int n)
{
    return n <= 4 ? root_to_4(S, P, n) : root_to_16(S, P, n);
}

#endif
