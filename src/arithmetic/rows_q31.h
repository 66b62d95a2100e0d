/*
 * Rows of mantissas with one exponent: the root S and everything that is made of it.
 *
 * A ROW of a dense matrix is its `width` words and, behind them, its exponent.  A ROOT is its
 * triangle by columns and, behind it, the exponents of its n rows.  The norm of a row, in units of
 * 2^exponent, is below 2^30; orthogonal maps keep it, and that is the bound of everything here.
 */
#ifndef KQ_SRC_ARITHMETIC_ROWS_Q31_H
#define KQ_SRC_ARITHMETIC_ROWS_Q31_H

#include "q31.h"
#include "sizes.h"
#include "kalmanq/port/vectors.h"

typedef int64_t sum;

#define ROW_LEN(width) ((width) + 1)
#define ROOT_LEN(n) KQ_ROOT_LEN_Q31(n)
#define SCALED_WORDS 2

/* One in a row of coordinates: those have norm 1 at most */
static const int32_t num_one = INT32_C(1) << 29;
static const int32_t one_exponent = -29;

static inline const int32_t *exponents_of(const int32_t *S, int n) { return S + KQ_TRIANGLE(n); }
/* Up to how many states a step of known size works on a copy, and up to how many it unrolls components */
enum { select_always = 1, states_in_registers = 0, states_unrolled = 1 };

/* rows_float.h */
enum { rows_in_pairs = 0, rows_share_exponents = 1 };

/* Of words of a row of exponent *E times h, where h is 2^k */
static inline int32_t entry_exponent(scaled h, const int32_t *E) { return h.exponent + 30 + *E; }

static inline void row_set_exponent(int32_t *row, int width, int32_t exponent)
{
    row[width] = exponent;
}

/* Entry k of a row as a number of its own */
static inline scaled row_entry(const int32_t *row, int width, int k)
{
    return scaled_of(row[k], row[width]);
}

KQ_KERNEL sum add_product(sum total, int32_t a, int32_t b) { return accumulate(total, a, b, 62); }

/* One entry of a combination as align has prepared it */
KQ_KERNEL int32_t combined(sum total) { return round_to_word(total, 30, 31); }

/* out_j = c'(column j) for j = n-1 .. from, the columns' entries from row `from` on; s: the last
   column's.  Downwards, because c may be in out. */
KQ_OUTLINE void row_times_triangle(int32_t *out, const int32_t *c, const int32_t *s, int from, int n)
{
    KQ_UNROLL
    for (int j = n - 1; j >= from; j--) {
        out[j - from] = combined(dot(0, c, s, j + 1 - from));
        s -= j;
    }
}

/* row_times_triangle for all columns, by a c that is 0 from `count` >= 1 on */
KQ_KERNEL void short_row_times_triangle(int32_t *out, const int32_t *c, int count, const int32_t *s,
                                        int n)
{
    KQ_UNROLL
    for (int j = n - 1; j >= 0; j--) {
        out[j] = combined(dot(0, c, s, j < count ? j + 1 : count));
        s -= j;
    }
}

/* Two of them, into w and v */
KQ_KERNEL void two_rows_times_triangle(int32_t *w, int32_t *v, const int32_t *a, const int32_t *b,
                                       const int32_t *s, int from, int n)
{
    row_times_triangle(w, a, s, from, n);
    row_times_triangle(v, b, s, from, n);
}

/* a'b 2^exponent as a number, where time does not count */
KQ_COLD KQ_NOINLINE static packed packed_dot(const int32_t *a, const int32_t *b, int count, int32_t exponent)
{
    return pack(scaled_of(dot(0, a, b, count), exponent));
}

/* a'b of two rows as a number */
static inline scaled row_product(const int32_t *a, const int32_t *b, int width)
{
    return scaled_of(dot(0, a, b, width), a[width] + b[width]);
}

/* r + f'f, r > 0: mostly in one sum, with r in units of the square */
KQ_OF_WORDS packed packed_add_square(int32_t r, int32_t p, const int32_t *f, int n)
{
    const sum square = squares(0, f, n); /* < 2^60.4 */
    const int32_t exponent = 2 * f[n], up = p - exponent;
    if (up < 0 || up > 29 || square == 0) {
        const scaled own = {r, p};
        return pack(scaled_plus(own, scaled_of(square, exponent)));
    }
    return pack(scaled_of_positive((uint64_t)sum_of(square, shift_up_word(r, (int)up, 60), 62), exponent));
}

KQ_OF_NUMBERS scaled add_square(scaled r, const int32_t *f, int n)
{
    return unpack(packed_add_square(r.mantissa, r.exponent, f, n));
}

static inline int32_t moved(int32_t a, int32_t down)
{
    return down >= 0 ? shift_down_rounded(a, down) : shift_up(a, (int)-down, 30);
}

/*
 * The coefficients of a combination sum_k row_k R_k of rows R_k on one scale:
 *     c_k = row_k 2^(E_k - scale),  sum |c_k| <= 2^30,
 * E_k (`stride` apart) being the exponents of the rows.  Then |sum_k c_k R_k| < 2^60: narrowed by
 * 30 it is a row of norm up to 2^30 with the exponent scale + 30, which is left in *exponent and is
 * not below what was there.
 */
KQ_OUTLINE const int32_t *align(int32_t *c, const scaled *row, const int32_t *E, int stride,
                              int count, int32_t *exponent)
{
    int32_t top = lowest_exponent;
    uint32_t total = 0; /* of the sizes in units of 2^(top + 4) */
    KQ_UNROLL
    for (int k = 0; k < count; k++) {
        if (row[k].mantissa == 0) continue;
        const int32_t own = row[k].exponent + E[k * stride];
        if (own > top) {
            total = own - top < 32 ? total >> (own - top) : 0;
            top = own;
        }
        if (top - own < 28) total += magnitude(row[k].mantissa) >> 4 >> (top - own);
    }
    total += (uint32_t)(2 * count); /* >= what the shifts and the rounding leave out */
    const int32_t fit = top + 4 + (32 - leading_zeros(total)) - 30;
    const int32_t scale = fit > *exponent - 30 ? fit : *exponent - 30;
    KQ_UNROLL
    for (int k = 0; k < count; k++) {
        const int32_t mantissa = row[k].mantissa;
        c[k] = mantissa ? moved(mantissa, scale - row[k].exponent - E[k * stride]) : 0;
    }
    *exponent = scale + 30;
    return c;
}

static inline scaled root_entry(const int32_t *S, int n, int i, int k)
{
    return (scaled){S[column(k) + i], S[KQ_TRIANGLE(n) + i]};
}

KQ_OF_WORDS packed packed_entry(const int32_t *S, int n, int i, int k)
{
    return pack(scaled_normal(root_entry(S, n, i, k)));
}

/* The entry, normalised */
KQ_OF_NUMBERS scaled root_number(const int32_t *S, int n, int i, int k) { return unpack(packed_entry(S, n, i, k)); }

/* S_ik - d, |d| far below the norm of its row: d is rounded down in a share 1 - place 2^-32 of what is left, otherwise up. */
KQ_COLD static inline void root_take(int32_t *S, int n, int i, int k, scaled d, uint32_t place)
{
    const uint32_t down = (uint32_t)S[KQ_TRIANGLE(n) + i] - (uint32_t)d.exponent;
    const int64_t taken = d.mantissa * (INT64_C(1) << 32) >> (down < 62 ? down : 62);
    S[column(k) + i] = (int32_t)sum_of(S[column(k) + i], -((taken + place) >> 32), 31);
}

/* A sum of products of the entries of rows i and j as a number */
static inline scaled root_sum(sum total, const int32_t *S, int n, int i, int j)
{
    return scaled_of(total, S[KQ_TRIANGLE(n) + i] + S[KQ_TRIANGLE(n) + j]);
}

/* S <- c S, c > 0 normalised, so that rows become no longer in a unit of 2^31; the caller
   renormalises it.  A power of 2 moves the exponents alone. */
KQ_SHARED void root_scale(int32_t *S, scaled c, int n)
{
    const int unit = scaled_is_unit(c);
    for (int k = 0; !unit && k < KQ_TRIANGLE(n); k++) {
        S[k] = round_to_word(product(S[k], c.mantissa), 31, 31);
    }
    for (int i = 0; i < n; i++) S[KQ_TRIANGLE(n) + i] += c.exponent + (unit ? 30 : 31);
}

/* S <- S + c S, c >= 0, rounded at the increment; the caller renormalises it.  c < 1/2, or it is a
   factor: the norm of a row stays below 1.5 2^30. */
static inline void root_grow(int32_t *S, scaled c, int n)
{
    if (c.exponent > -32) {
        root_scale(S, scaled_plus(scaled_one, c), n);
        return;
    }
    for (int k = 0; k < KQ_TRIANGLE(n); k++) {
        const int64_t increment = shift_down_rounded_wide(product(S[k], c.mantissa), -c.exponent);
        S[k] = (int32_t)sum_of(S[k], increment, 31);
    }
}

/*
 * The exponent of a row of these entries as long as it may be: its norm is in 2^29 .. 2^30, but for
 * rounding.
 */
KQ_SHARED int32_t fitted_exponent(const scaled *entries, int width)
{
    int32_t top = lowest_exponent;
    for (int k = 0; k < width; k++) {
        if (entries[k].mantissa && entries[k].exponent > top) top = entries[k].exponent;
    }
    int64_t square = 0; /* of 16 words below 2^27 */
    for (int k = 0; k < width; k++) {
        if (entries[k].mantissa == 0) continue;
        const int32_t word = shift_down_rounded(entries[k].mantissa, top + 4 - entries[k].exponent);
        square = accumulate(square, word, word, 58);
    }
    if (square == 0) return lowest_exponent;
    return top + 4 - ((leading_zeros_wide((uint64_t)square) - 4) >> 1);
}

static inline int32_t fitted_word(scaled entry, int32_t exponent)
{
    return entry.mantissa ? shift_down_rounded(entry.mantissa, exponent - entry.exponent) : 0;
}

/* A number in units of row i */
static inline int32_t word_of_row(scaled a, const int32_t *S, int n, int i)
{
    return fitted_word(a, S[KQ_TRIANGLE(n) + i]);
}

/* Of the inverse of S, its rows scaled to norm 1, words that are held at 2^30: that is the root of num_most_condition,
   2^27. */
static const int32_t inverse_one = 8;

KQ_COLD static inline int32_t entry_of_inverse(sum left, int32_t own)
{
    if (own == 0 || left == 0) return 0;
    return (int32_t)held_within(word_of(scaled_over(scaled_of(left, 0), scaled_of(own, 0))), INT64_C(1) << 30);
}

static inline int inverse_is_large(sum square) { return square >= INT64_C(1) << 60; }

/* Numbers into one row as long as it may be */
static inline void row_fitted(int32_t *row, const scaled *entries, int width)
{
    const int32_t exponent = fitted_exponent(entries, width);
    for (int k = 0; k < width; k++) row[k] = fitted_word(entries[k], exponent);
    row[width] = exponent;
}

/* Row i of S <- its n - i entries */
KQ_COLD static inline void root_set_row(int32_t *S, const scaled *entries, int n, int i)
{
    const int32_t exponent = fitted_exponent(entries, n - i);
    int32_t *s = S + column(i) + i;
    for (int j = i; j < n; j++) {
        *s = fitted_word(entries[j - i], exponent);
        s += j + 1;
    }
    S[KQ_TRIANGLE(n) + i] = exponent;
}

/* h'h 2^-48: what the mean's last bit of 2^-24 word in each state makes of h'P h */
KQ_SHARED scaled mean_resolution(const scaled *h, int n)
{
    scaled total = {0, 0};
    for (int k = 0; k < n; k++) scaled_add_times(&total, h + k, h + k);
    return scaled_shift(total, -48);
}

KQ_SHARED int32_t root_log(const int32_t *S, int n, int i, int k)
{
    const int32_t word = S[column(k) + i];
    return word == 0 ? lowest_exponent : exponents_of(S, n)[i] + 31 - leading_zeros(magnitude(word));
}

/* About log2 of what S_ij is rounded by: a word's last bit */
static inline int32_t entry_rounding(const int32_t *S, int n, int i, int j)
{
    (void)j;
    return exponents_of(S, n)[i];
}

/* About log2 of the squares of the terms that entry j of S'h is the sum of: of the largest */
KQ_KERNEL int32_t project_log(const int32_t *S, const scaled *h, int n, int j)
{
    int32_t most = lowest_exponent;
    for (int i = 0; i <= j; i++) {
        const int32_t term = h[i].exponent + root_log(S, n, i, j);
        if (h[i].mantissa != 0 && term > most) most = term;
    }
    return 2 * (most + 30);
}

/* The row's result takes the exponent of the row it was made in. */
static inline void root_take_exponent(int32_t *S, int n, int l, const int32_t *row, int width)
{
    S[KQ_TRIANGLE(n) + l] = row[width];
}

/* Brings every row's norm into [2^29, 2^30), the mantissas as long as they may be. */
KQ_OUTLINE void renormalise(int32_t *S, int n)
{
    int32_t *E = S + KQ_TRIANGLE(n), *row = S; /* at its diagonal entry */
    KQ_UNROLL
    for (int i = 0; i < n; i++) {
        const sum square = row_squares(row, i, n);                      /* < 2^60.4 */
        const int up = (leading_zeros_wide((uint64_t)square) - 4) >> 1; /* -1: down by one */
        if (square == 0) E[i] = lowest_exponent;
        if (E[i] > high_exponent) E[i] = high_exponent;
        if (square != 0 && up != 0 && E[i] >= low_exponent) {
            int32_t *t = row;
            KQ_UNROLL
            for (int j = i; j < n; j++) {
                *t = up > 0 ? shift_up(*t, up, 30) : shift_down_rounded(*t, 1);
                t += j + 1;
            }
            E[i] -= up;
        }
        row += i + 2;
    }
}

#endif
