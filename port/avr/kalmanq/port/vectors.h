/*
 * AVR: the loops as in include/kalmanq/port/vectors.h, which says what each one is, but out of line at
 * every level.
 */
#ifndef KALMANQ_PORT_VECTORS_H
#define KALMANQ_PORT_VECTORS_H

#include <stdint.h>

/* total + a'b.  For rows of norm below 2^30 it is below 2^60, and so is every part of it. */
KQ_OUT_OF_LINE int64_t dot(int64_t total, const int32_t *a, const int32_t *b, int count)
{
    for (int k = 0; k < count; k++) total = sum_of(total, product(a[k], b[k]), 62);
    return total;
}

/* total + a'a, the same */
static inline int64_t squares(int64_t total, const int32_t *a, int count)
{
    return dot(total, a, a, count);
}

/* The same of a row of a triangle by columns, from its diagonal entry in column i on */
KQ_OUT_OF_LINE int64_t row_squares(const int32_t *s, int i, int n)
{
    int64_t total = 0;
    for (int j = i; j < n; j++) {
        total = sum_of(total, product(*s, *s), 62);
        s += j + 1;
    }
    return total;
}

/* w -= V d 2^-30; |V_k| <= 2^30 + 2, |d| < 2^31 */
KQ_OUT_OF_LINE void subtract_multiple(int32_t *restrict w, const int32_t *restrict V, int32_t d,
                                 int count)
{
    for (int k = 0; k < count; k++) {
        w[k] = (int32_t)sum_of(w[k], -round_to_word(product(V[k], d), 30, 31), 31);
    }
}

/* w <- w 2^up factor 2^-31; |w_k| 2^up < 2^31, factor >= 0 */
KQ_OUT_OF_LINE void scale(int32_t *w, int up, int32_t factor, int count)
{
    for (int k = 0; k < count; k++) w[k] = round_to_word(product(shift_up(w[k], up, 31), factor), 31, 31);
}

/* s <- c s - t b,  b <- c b + t s, with b_last = 0 before.  c and t are a cosine >= 0 and a sine in
   Q31, c^2 + t^2 <= 1 + 2^-28.  |s_i| and |b_i| are, and stay, below 2^30 + 2^10. */
KQ_OUT_OF_LINE void rotate_words(int32_t *restrict s, int32_t *restrict b, int32_t c, int32_t t, int last)
{
    const int32_t back = -t;
    for (int i = 0; i < last; i++) {
        const int32_t old = s[i], own = b[i];
        s[i] = round_to_word(sum_of(product(c, old), product(back, own), 62), 31, 31);
        b[i] = round_to_word(sum_of(product(c, own), product(t, old), 62), 31, 31);
    }
    const int32_t old = s[last];
    s[last] = round_to_word(product(c, old), 31, 31);
    b[last] = round_to_word(product(t, old), 31, 31);
}

#endif
