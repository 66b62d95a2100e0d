/*
 * A measurement that takes so little of P that the cosines of its rotations, and the entries of S, have too few bits for it.
 * Of Carlson's rotations (update.h) what they take from S, to a share f_j^2 / a_j of it:
 *     S_j <- S_j - f_j (b + b') / (a_{j-1} + a_j),   b' = b + f_j S_j
 * It is rounded up or down as often as is right for it, so that many measurements take as much as they tell.
 */
#ifndef KQ_SRC_FILTER_WEAK_H
#define KQ_SRC_FILTER_WEAK_H

#include "state.h"

/*
 * S by a weak measurement of f = S'h, a row or `exact`, and noise r, and b = S f.  `weak` counts them: of each entry its multiples of the golden
 * ratio are spread evenly, those of every second or third measurement, too.
 */
KQ_COLD KQ_NOINLINE static void turn_weakly(filter *f, num *S, scaled *b, const num *row, const scaled *exact, scaled r)
{
    const int n = f->states;
    uint32_t place = ++f->weak * UINT32_C(0x9e3779b1);
    for (int i = 0; i < n; i++) b[i] = scaled_zero();
    for (int j = 0; j < n; j++) {
        const scaled before = r, entry = row ? row_entry(row, n, j) : exact[j];
        r = scaled_add_square(r, entry);
        const scaled slope = scaled_over(entry, scaled_plus(before, r));
        for (int i = 0; i <= j; i++) {
            const scaled was = b[i];
            b[i] = scaled_plus(was, scaled_times(entry, root_number(S, n, i, j)));
            root_take(S, n, i, j, scaled_times(slope, scaled_plus(was, b[i])), place += UINT32_C(0x85ebca6b));
        }
    }
}

#endif
