/*
 * The loops over words that a core may do better than C says them: the portable form.  Replaced as
 * integer.h is (port/README.md), with the same bits.  Not for callers of the library.
 *
 * `bits` and the bounds are in src/arithmetic/fixed.h.
 */
#ifndef KALMANQ_PORT_VECTORS_H
#define KALMANQ_PORT_VECTORS_H

#include <stdint.h>

/* total + a'b.  For rows of norm below 2^30 it is below 2^60, and so is every part of it. */
KQ_KERNEL int64_t dot(int64_t total, const int32_t *a, const int32_t *b, int count)
{
    KQ_UNROLL
    for (int k = 0; k < count; k++) total = accumulate(total, a[k], b[k], 62);
    return total;
}

/* total + a'a, the same */
KQ_KERNEL int64_t squares(int64_t total, const int32_t *a, int count)
{
    return dot(total, a, a, count);
}

/* The same of a row of a triangle by columns, from its diagonal entry in column i on */
KQ_KERNEL int64_t row_squares(const int32_t *s, int i, int n)
{
    int64_t total = 0;
    KQ_UNROLL
    for (int j = i; j < n; j++) {
        total = accumulate(total, *s, *s, 62);
        s += j + 1;
    }
    return total;
}

/* w -= V d 2^-30; |V_k| <= 2^30 + 2, |d| < 2^31 */
KQ_KERNEL void subtract_multiple(int32_t *restrict w, const int32_t *restrict V, int32_t d,
                                 int count)
{
    KQ_UNROLL
    for (int k = 0; k < count; k++) {
        w[k] = (int32_t)sum_of(w[k], -round_product_to_word(V[k], d, 30, 31), 31);
    }
}

/* w <- w 2^up factor 2^-31; |w_k| 2^up < 2^31, factor >= 0 */
KQ_KERNEL void scale(int32_t *w, int up, int32_t factor, int count)
{
    KQ_UNROLL
    for (int k = 0; k < count; k++) w[k] = round_product_to_word(shift_up(w[k], up, 31), factor, 31, 31);
}

/* s <- c s - t b,  b <- c b + t s, with b_last = 0 before.  c and t are a cosine >= 0 and a sine in
   Q31, c^2 + t^2 <= 1 + 2^-28.  By rounding a norm grows by less than 3: over the 16 components of an update
   of 16 states (s_i, b_i) and rows stay below 2^30 + 2^10. */
KQ_KERNEL void rotate_words(int32_t *restrict s, int32_t *restrict b, int32_t c, int32_t t, int last)
{
    const int32_t back = -t;
    KQ_UNROLL
    for (int i = 0; i < last; i++) {
        const int32_t old = s[i], own = b[i];
        s[i] = round_products_to_word(c, old, back, own, 31, 31);
        b[i] = round_products_to_word(c, own, t, old, 31, 31);
    }
    const int32_t old = s[last];
    s[last] = round_product_to_word(c, old, 31, 31);
    b[last] = round_product_to_word(t, old, 31, 31);
}

#endif
