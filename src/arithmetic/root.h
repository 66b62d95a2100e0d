/*
 * Roots: upper triangular matrices packed by columns.  Column j is j + 1 contiguous numbers, so
 * that a column is read along and a row of a dense matrix meets it in one dot product.
 */
#ifndef KQ_SRC_ARITHMETIC_ROOT_H
#define KQ_SRC_ARITHMETIC_ROOT_H

#include "twins.h"

static inline void copy(num *restrict to, const num *restrict from, int count)
{
    for (int k = 0; k < count; k++) to[k] = from[k];
}

/* f = S'h, a row */
KQ_KERNEL void project(num *f, const num *S, const scaled *h, int n)
{
    int32_t exponent = lowest_exponent;
    const num *c = align(f, h, exponents_of(S, n), 1, n, &exponent);
    row_times_triangle(f, c, S + column(n - 1), 0, n);
    row_set_exponent(f, n, exponent);
}

/* f = S'h for an h that takes state k alone, as it is: f is row k of S. */
KQ_INLINE void project_selected(num *f, const num *S, scaled h, int k, int n)
{
    const num *s = S + column(k) + k;
    for (int j = 0; j < k; j++) f[j] = 0;
    for (int j = k; j < n; j++) {
        f[j] = *s;
        s += j + 1;
    }
    row_set_exponent(f, n, entry_exponent(h, exponents_of(S, n) + k));
}

/* The n - i entries of row i of S */
KQ_KERNEL void root_row(scaled *out, const num *S, int n, int i)
{
    out[0] = root_entry(S, n, i, i);
    KQ_UNROLL
    for (int k = i + 1; k < n; k++) out[k - i] = root_entry(S, n, i, k);
}

/* S f as numbers, f a row */
static inline void root_times_row(scaled *out, const num *S, const num *f, int n)
{
    for (int i = 0; i < n; i++) {
        out[i] = (scaled){0};
        for (int j = i; j < n; j++) {
            const scaled entry = root_number(S, n, i, j);
            out[i] = scaled_plus(out[i], scaled_times(entry, row_entry(f, n, j)));
        }
    }
}

/* (S S')_ij */
static scaled root_product(const num *S, int n, int i, int j)
{
    sum total = 0;
    for (int k = i > j ? i : j; k < n; k++) {
        total = add_product(total, S[column(k) + i], S[column(k) + j]);
    }
    return root_sum(total, S, n, i, j);
}

/* P = S S', n x n */
static void root_square(scaled *restrict P, const num *restrict S, int n)
{
    for (int i = 0; i < n; i++) {
        for (int j = i; j < n; j++) P[i * n + j] = P[j * n + i] = root_product(S, n, i, j);
    }
}

/*
 * Is the condition number of S, its rows scaled to norm 1, too large?  It is |S^-1 D|, found column by column.
 * Rows that are rounded by a part of their norm move the sigma of the combination that is known best by that
 * many such parts.  is_singular: the answer where a state is known exactly, given those behind it, if not 0; such a state
 * has no such sigma.
 */
KQ_COLD KQ_NOINLINE static int root_is_ill_conditioned(const num *S, int n, int is_singular)
{
    num v[KQ_SIZE_MAX];
    sum total = 0;
    for (int j = 0; j < n; j++) {
        const num sigma = word_of_row(scaled_root(root_product(S, n, j, j)), S, n, j), *own = S + column(j) + j;
        v[j] = 0;
        if (sigma == 0) continue;
        if (*own == 0 && is_singular) return is_singular;
        for (int i = *own == 0 ? -1 : j; i >= 0; i--) {
            sum left = i == j ? add_product(0, sigma, inverse_one) : 0;
            for (int k = i + 1; k <= j; k++) left = add_product(left, -S[column(k) + i], v[k]);
            v[i] = entry_of_inverse(left, S[column(i) + i]);
            total = add_product(total, v[i], v[i]);
            if (inverse_is_large(total)) return 1;
        }
    }
    return 0;
}

#endif
