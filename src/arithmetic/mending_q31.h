/* Rows and what a low-noise measurement does to them, every entry a number until the row has its new exponent. */
#ifndef KQ_SRC_ARITHMETIC_MENDING_Q31_H
#define KQ_SRC_ARITHMETIC_MENDING_Q31_H

#include "rows_q31.h"

/* A cosine or sine in Q31 */
KQ_COLD KQ_NOINLINE static int32_t turn_word(const scaled *a) { return word_of(scaled_shift(*a, 31)); }

/* Row i of S through the rotations of cosines c and sines t.  Its exponent becomes the exponent of what is
   left.  Answers entry i of S f / sqrt(s), which is as long as the row was at most; reach: the largest of that and of the
   row's entries, its sigma before but for a factor of up to 5. */
KQ_COLD static inline scaled turn_root_row(int32_t *S, const scaled *c, const scaled *t, scaled *entries,
                                   int n, int i, scaled *reach)
{
    const int32_t exponent = S[KQ_TRIANGLE(n) + i], *s = S + column(i) + i;
    int32_t b = 0;
    uint32_t most = 0;
    for (int j = i; j < n; j++) {
        const scaled old = {*s, exponent}, other = {-b, exponent};
        entries[j - i] = scaled_products(c[j], old, t[j], other);
        b = round_products_to_word(turn_word(c + j), b, turn_word(t + j), *s, 31, 31);
        s += j + 1;
    }
    root_set_row(S, entries, n, i);
    for (int j = i; j < n; j++) most = magnitude(S[column(j) + i]) > most ? magnitude(S[column(j) + i]) : most;
    const scaled lost = scaled_of(b, exponent), size = scaled_magnitude(lost);
    *reach = scaled_of(most, S[KQ_TRIANGLE(n) + i]);
    if (scaled_is_less(*reach, size)) *reach = size;
    return lost;
}

static inline void row_clear(int32_t *S, int n, int i)
{
    for (int j = i; j < n; j++) S[column(j) + i] = 0;
    S[KQ_TRIANGLE(n) + i] = lowest_exponent;
}

/* Is what mend_root_row adds rounded at more than 2^-12 of what it leaves?  It is as rounding has left the row, 2^-30
   of sigma = sqrt(s), and has 31 bits: r < 2^-96 s */
static inline int mending_rounds(scaled r, scaled sigma) { return r.exponent < 2 * sigma.exponent - 66; }

/* Row i of S, columns i .. end - 1, += rest / h, or <- 0 where there is no rest.  Its exponent becomes the exponent
   of what is left. */
KQ_COLD static inline void mend_root_row(int32_t *S, const scaled *rest, scaled h, scaled *entries, int n,
                                         int i, int end)
{
    for (int j = i; j < n; j++) {
        scaled part = scaled_zero();
        if (rest && j < end) part = scaled_over(rest[j], h);
        entries[j - i] = rest || j >= end ? root_number(S, n, i, j) : scaled_zero();
        scaled_add(entries + j - i, &part);
    }
    root_set_row(S, entries, n, i);
}

/* f_j += h_k S_kj, k <= j, for rows that have no bit on the scale of all of them */
KQ_COLD static void project_far(scaled *f, const int32_t *S, const scaled *h, uint32_t far, int n)
{
    for (int k = 0; k < n; k++) {
        for (int j = k; j < n && (far >> k & 1); j++) {
            const scaled entry = root_number(S, n, k, j);
            scaled_add_times(f + j, h + k, &entry);
        }
    }
}

/* The lower word of a 2^-down, rounded, -27 < down < 5 */
static inline uint32_t remainder_word(int32_t a, int32_t down)
{
    return down > 0 ? (uint32_t)(a >> down) + (uint32_t)(a >> (down - 1) & 1) : (uint32_t)a << -down;
}

KQ_COLD static scaled floor_of_length(scaled length, const scaled *h, int n)
{
    const scaled of_root = scaled_times(scaled_of_count(512 * n), scaled_times(length, length));
    const scaled of_mean = scaled_shift(mean_resolution(h, n), 2);
    return scaled_is_less(of_root, of_mean) ? of_mean : of_root;
}

/*
 * f = S'h, every entry to its own last bit: on the scale of all of h a coefficient that is small
 * beside others has but a few.  What they lack is in `rests`, n words of at most 2^26, in units of 2^-27:
 * its product with 16 words of a column is below 2^60.  One that has none is left to project_far.  Answers
 * what rounding alone makes of f'f, 16 units of each entry, or 2 last bits of the mean: a variance
 * below either says nothing.
 */
KQ_COLD static scaled project_exactly(scaled *f, const int32_t *S, const scaled *h, scaled *rests, int n)
{
    int32_t *c = &f[0].mantissa, *low = &rests[0].mantissa, exponent = lowest_exponent;
    uint32_t size = 0, far = 0;
    (void)align(c, h, exponents_of(S, n), 1, n, &exponent);
    const int32_t scale = exponent - 30;
    for (int k = 0; k < n; k++) {
        const int32_t a = h[k].mantissa, down = scale - h[k].exponent - S[KQ_TRIANGLE(n) + k];
        low[k] = 0;
        size += magnitude(c[k]);
        if (a == 0 || down <= 0) continue;
        if (down > 31) far |= UINT32_C(1) << k;
        else low[k] = (int32_t)(remainder_word(a, down - 27) - ((uint32_t)c[k] << 27));
    }
    for (int j = n - 1; j >= 0; j--) { /* downwards, because c is in f */
        const int32_t *s = S + column(j);
        const packed rest = packed_dot(low, s, j + 1, scale - 27);
        f[j] = scaled_plus(unpack(packed_dot(c, s, j + 1, scale)), unpack(rest));
    }
    project_far(f, S, h, far, n);
    return floor_of_length(scaled_of(size, scale), h, n);
}

/* That alone */
KQ_COLD static scaled floor_of_square(const int32_t *S, const scaled *h, int n)
{
    scaled length = scaled_zero();
    for (int k = 0; k < n; k++) {
        const scaled part = scaled_shift(scaled_magnitude(h[k]), exponents_of(S, n)[k]);
        scaled_add(&length, &part);
    }
    return floor_of_length(length, h, n);
}

#endif
