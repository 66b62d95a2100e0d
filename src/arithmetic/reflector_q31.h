#ifndef KQ_SRC_ARITHMETIC_REFLECTOR_Q31_H
#define KQ_SRC_ARITHMETIC_REFLECTOR_Q31_H

#include "rows_q31.h"

/* The noise block G of predict: its rows, of norm 2^30 at most, are brought to the exponent of
   their row of A S, at least one above their own: the norm of both is below 2^30.2. */
static inline int32_t noise_exponent(const int32_t *G, int n, int l)
{
    return G[KQ_TRIANGLE(n) + l] + 1;
}

static inline int32_t noise_shift(const int32_t *G, int n, int l, const int32_t *row, int width)
{
    return row[width] - G[KQ_TRIANGLE(n) + l];
}

static inline int32_t noise_word(const int32_t *g, int32_t shift)
{
    return shift_down_rounded(*g, shift);
}

static const int32_t num_no_noise = 0;

/* The pivot of a reflector in G, which here is in its p. */
static inline int32_t reflector_pivot(const int32_t *g)
{
    (void)g;
    return 0;
}

/*
 * One row (w, g), |w| < 2^30.2 and g <= 2^29, through the reflector (V, p) of norm 1 in Q30, with
 * q = 1 / (1 + p) in Q31: returns its entry in the pivot's column.
 *     |entry| < 2^30.2,  |entry + g| <= sqrt(1 - p^2) |w| + (1 + p) g < 1.75 2^30 < 2^31,
 *     |d| = |g + V'w / (1 + p)| < 2^31
 */
KQ_OUTLINE int32_t reflect(int32_t *restrict w, int32_t g, const int32_t *restrict V, int32_t g_pivot,
                         const int32_t *pq, int count)
{
    (void)g_pivot;
    const int32_t entry = round_to_word(dot(product(g, pq[0]), w, V, count), 30, 31);
    const int32_t d = round_product_to_word((int32_t)sum_of(entry, g, 31), pq[1], 31, 31);
    subtract_multiple(w, V, d, count);
    return entry;
}

/* reflect for a row of coordinates that is num_one at `at` and 0 elsewhere, g = 0 */
KQ_KERNEL int32_t reflect_unit(int32_t *restrict w, const int32_t *restrict V, const int32_t *pq,
                               int at, int count)
{
    const int32_t entry = shift_down_rounded(V[at], 1);
    const int32_t d = round_to_word(product(entry, pq[1]), 31, 31);
    KQ_UNROLL
    for (int k = 0; k < count; k++) w[k] = -round_to_word(product(V[k], d), 30, 31);
    w[at] += num_one;
    return entry;
}

/* ... and for one that is 0 (and need not be set) in its first `zeros` words */
KQ_KERNEL int32_t reflect_longer(int32_t *restrict w, const int32_t *restrict V, const int32_t *pq,
                                 int zeros, int count)
{
    const int32_t entry = round_to_word(dot(0, w + zeros, V + zeros, count - zeros), 30, 31);
    const int32_t d = round_to_word(product(entry, pq[1]), 31, 31);
    KQ_UNROLL
    for (int k = 0; k < zeros; k++) w[k] = -round_to_word(product(V[k], d), 30, 31);
    KQ_UNROLL
    for (int k = zeros; k < count; k++) {
        w[k] = (int32_t)sum_of(w[k], -round_to_word(product(V[k], d), 30, 31), 31);
    }
    return entry;
}

/* Two rows w and v, their entries into s and the word before it */
KQ_KERNEL extent reflect_two(extent far, int32_t *s, int32_t *restrict w, int32_t *restrict v, int32_t g_w,
                           int32_t g_v, const int32_t *restrict V, int32_t g_pivot,
                           const int32_t *pq, int count)
{
    s[0] = reflect(w, g_w, V, g_pivot, pq, count);
    s[-1] = reflect(v, g_v, V, g_pivot, pq, count);
    return far;
}

/*
 * The reflector of a row (w, g), g >= 0: w <- V = w / s in Q30, p = g / s, q = 1 / (1 + p);
 * returns s, the row's norm.  w 2^h and g 2^h are below 2^31, and the square of s 2^h, with
 * 2h + 2 zeros on top, is normalised to [2^62, 2^64).  By rounding an entry of V or p may be 2
 * units above 1.
 */
KQ_OUTLINE int32_t close_reflector(int32_t *w, int32_t g, int32_t *pq, int count)
{
    const uint64_t square = (uint64_t)squares(product(g, g), w, count); /* < 2^60.4 */
    if (square == 0) { /* a reflector that leaves everything alone */
        pq[0] = INT32_C(1) << 30;
        pq[1] = INT32_C(1) << 30;
        return 0;
    }
    const int zeros = leading_zeros_wide(square) & ~1, h = zeros / 2 - 1;
    const uint32_t v = upper_word_raised(square, zeros), inverse = inverse_root(v);
    const int32_t half = (int32_t)(inverse >> 1); /* 2^h / s = half 2^-61 */
    scale(w, h, half, count);
    const int32_t p = round_product_to_word(shift_up(g, h, 31), half, 31, 31);
    const uint32_t one_plus = (UINT32_C(1) << 30) + (uint32_t)p; /* Q30, 1 .. 2 */
    const uint32_t share = one_plus >> 31 ? UINT32_C(1) << 31 : reciprocal(one_plus << 1);
    pq[0] = p;
    pq[1] = (int32_t)(share >> 1);
    return shift_down_rounded((int32_t)root_by_inverse(v, inverse), h);
}

#endif
