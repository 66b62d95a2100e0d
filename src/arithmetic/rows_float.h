/*
 * Rows of a matrix in floating point, where a row needs no exponent: the twin of rows_q31.h, which
 * says what each operation is.
 */
#ifndef KQ_SRC_ARITHMETIC_ROWS_FLOAT_H
#define KQ_SRC_ARITHMETIC_ROWS_FLOAT_H

#include "scaled_float.h"
#include "sizes.h"

typedef num sum;

#define ROW_LEN(width) (width)
#define ROOT_LEN(n) KQ_TRIANGLE(n)
#define SCALED_WORDS 1

static const int32_t lowest_exponent = 0;
static const int32_t one_exponent = 0;
static const num num_one = 1;

static inline const num *exponents_of(const num *S, int n) { return S + KQ_TRIANGLE(n); }

/* Two rows at a time save loads, which count where the core has instructions for the products and memory is not
   short. */
#if defined(KQ_SMALL_CODE)
enum { rows_in_pairs = 0 };
#else
enum { rows_in_pairs = KQ_NUM_BITS <= KQ_FLOAT_BITS };
#endif
enum { rows_share_exponents = 0 };

/* Where sizes are known, S is in registers: a row of it cannot be selected.  Up to so many states a
   step works on a copy that is in registers, and up to so many its components are unrolled. */
enum { select_always = 0, states_in_registers = 3, states_unrolled = 4 };

static inline int32_t entry_exponent(scaled h, const num *E)
{
    (void)h, (void)E;
    return 0;
}

static inline void row_set_exponent(num *row, int width, int32_t exponent)
{
    (void)row, (void)width, (void)exponent;
}

static inline scaled row_entry(const num *row, int width, int k)
{
    (void)width;
    return row[k];
}

static inline sum add_product(sum total, num a, num b) { return total + a * b; }

static inline num combined(sum total) { return total; }

KQ_KERNEL sum dot(sum total, const num *a, const num *b, int count)
{
    KQ_UNROLL
    for (int k = 0; k < count; k++) total = add_product(total, a[k], b[k]);
    return total;
}

/* rows_q31.h */
KQ_KERNEL void row_times_triangle(num *out, const num *c, const num *s, int from, int n)
{
    KQ_UNROLL
    for (int j = n - 1; j >= from; j--) {
        out[j - from] = dot(c[0] * s[0], c + 1, s + 1, j - from);
        s -= j;
    }
}

KQ_KERNEL void short_row_times_triangle(num *out, const num *c, int count, const num *s, int n)
{
    KQ_UNROLL
    for (int j = n - 1; j >= 0; j--) {
        out[j] = dot(c[0] * s[0], c + 1, s + 1, (j < count ? j + 1 : count) - 1);
        s -= j;
    }
}

/* A column is loaded once for both. */
KQ_KERNEL void two_rows_times_triangle(num *w, num *v, const num *a, const num *b, const num *s,
                                       int from, int n)
{
    KQ_UNROLL
    for (int j = n - 1; j >= from; j--) {
        num of_a = a[0] * s[0], of_b = b[0] * s[0];
        KQ_UNROLL
        for (int k = 1; k <= j - from; k++) {
            of_a = add_product(of_a, a[k], s[k]);
            of_b = add_product(of_b, b[k], s[k]);
        }
        w[j - from] = of_a;
        v[j - from] = of_b;
        s -= j;
    }
}

static inline scaled row_product(const num *a, const num *b, int width)
{
    return dot(0, a, b, width);
}

/* r + f'f */
static inline scaled add_square(scaled r, const num *f, int n)
{
    const num first = n > 0 ? f[0] * f[0] : 0; /* not added to 0 */
    return r + dot(first, f + 1, f + 1, n - 1);
}

static inline const num *align(num *c, const scaled *row, const num *E, int stride, int count,
                               int32_t *exponent)
{
    (void)c, (void)E, (void)stride, (void)count, (void)exponent;
    return row;
}

static inline scaled root_entry(const num *S, int n, int i, int k)
{
    (void)n;
    return S[column(k) + i];
}

static inline scaled root_number(const num *S, int n, int i, int k) { return root_entry(S, n, i, k); }

/* S_ik - d, rounded down in a share of what is left that is 1 - place 2^-32, otherwise up */
KQ_COLD static inline void root_take(num *S, int n, int i, int k, num d, uint32_t place)
{
    const num old = root_entry(S, n, i, k), share = (num)(int32_t)(place ^ UINT32_C(0x80000000)) * (num)0x1p-32;
    S[column(k) + i] = old - (d + share * num_power(old) * num_epsilon);
}

static inline scaled root_sum(sum total, const num *S, int n, int i, int j)
{
    (void)S, (void)n, (void)i, (void)j;
    return total;
}

/* S <- c S; the caller renormalises it */
static inline void root_scale(num *S, scaled c, int n)
{
    for (int k = 0; k < KQ_TRIANGLE(n); k++) S[k] *= c;
}

/* S <- S + c S, c >= 0, rounded at the increment; the caller renormalises it */
static inline void root_grow(num *S, scaled c, int n)
{
    for (int k = 0; k < KQ_TRIANGLE(n); k++) S[k] += c * S[k];
}

/* A number in units of row i */
static inline num word_of_row(scaled a, const num *S, int n, int i)
{
    (void)S, (void)n, (void)i;
    return a;
}

/* Of the inverse of S, its rows scaled to norm 1: 1, an entry, and the square of what is too large */
static const num inverse_one = 1;

static inline num entry_of_inverse(sum left, num own) { return own == 0 ? 0 : left / own; }

static inline int inverse_is_large(sum square) { return !(square < num_most_condition); }

static inline void row_fitted(num *row, const scaled *entries, int width)
{
    for (int k = 0; k < width; k++) row[k] = entries[k];
}

/* A pair of floats has no last bit that a noise would have to be above. */
static inline scaled mean_resolution(const scaled *h, int n)
{
    (void)h, (void)n;
    return 0;
}

static inline int32_t root_log(const num *S, int n, int i, int k) { return scaled_log(root_entry(S, n, i, k)); }

static inline int32_t entry_rounding(const num *S, int n, int i, int j) { return scaled_log(root_entry(S, n, i, j)) + num_watched / 2; }

/* About log2 of the squares of the terms that entry j of S'h is the sum of */
KQ_KERNEL int32_t project_log(const num *S, const scaled *h, int n, int j)
{
    num total = 0;
    (void)n;
    S += column(j);
    for (int i = 0; i <= j; i++) {
        const num term = h[i] * S[i];
        total += term * term;
    }
    return scaled_log(total);
}

static inline void root_take_exponent(num *S, int n, int l, const num *row, int width)
{
    (void)S, (void)n, (void)l, (void)row, (void)width;
}

static inline void renormalise(num *S, int n) { (void)S, (void)n; }

#endif
