/*
 * A measurement that takes so little of P that the cosines of its rotations, and the entries of S, have too few bits for it.
 * Carlson's rotations (update.h) as what they take from S:
 *     S_j <- S_j - (g_j S_j + c_j f_j / a_{j-1} b),   g_j = 1 - c_j,   b <- b + f_j S_j
 * What is taken is rounded up or down as often as is right for it, so that many measurements take as much as they tell.
 */
#ifndef KQ_SRC_FILTER_WEAK_H
#define KQ_SRC_FILTER_WEAK_H

#include "state.h"

/* 1 - sqrt(1 - q), q below 2^-13 */
KQ_COLD static scaled cosine_lacks(scaled q)
{
    return scaled_plus(scaled_shift(q, -1), scaled_shift(scaled_times(q, q), -3));
}

/*
 * S by a weak measurement of f = S'h and noise r, and b = S f.  `weak` counts them: of each entry its multiples of the golden
 * ratio are spread evenly, those of every second or third measurement, too.
 */
KQ_COLD KQ_NOINLINE static void turn_weakly(filter *f, num *S, scaled *b, const scaled *row, scaled r)
{
    const int n = f->states;
    uint32_t place = ++f->weak * UINT32_C(0x9e3779b1);
    for (int i = 0; i < n; i++) b[i] = scaled_zero();
    for (int j = 0; j < n; j++) {
        const scaled before = r;
        r = scaled_add_square(r, row[j]);
        const scaled lacks = cosine_lacks(scaled_over(scaled_times(row[j], row[j]), r));
        const scaled cosine = scaled_minus(scaled_one, lacks);
        const scaled sine = scaled_times(cosine, scaled_over(row[j], before));
        for (int i = 0; i <= j; i++) {
            const scaled old = root_number(S, n, i, j);
            root_take(S, n, i, j, scaled_products(lacks, old, sine, b[i]), place += UINT32_C(0x85ebca6b));
            b[i] = scaled_plus(b[i], scaled_times(row[j], old));
        }
    }
}

#endif
