/*
 * A measurement that takes so little of P that the cosines of its rotations, and the entries of S, have too few bits for it.
 * Of Carlson's rotations (update.h) what they take from S, to a share (s - r) / s of it:
 *     S_j <- S_j - f_j (b + b') / (r + s),   b' = b + f_j S_j
 * It is rounded up or down as often as is right for it, so that many measurements take as much as they tell.
 */
#ifndef KQ_SRC_FILTER_WEAK_H
#define KQ_SRC_FILTER_WEAK_H

#include "state.h"

/* One of f = S'h, a row or `exact`, noise r and variance s */
typedef struct {
    const num *row;
    const scaled *exact;
    scaled r, s;
} weak_scalar;

/*
 * S by it, x += b w, and b = S f unless it is NULL.  `weak` counts them.  For each entry its multiples of the golden ratio are
 * spread evenly, also where another sensor takes every second or third count.
 */
KQ_COLD KQ_NOINLINE static void take_weak(filter *f, const weak_scalar *m, scaled w, scaled *b)
{
    const int n = f->states;
    num *S = filter_root(f);
    const scaled inverse = scaled_over(scaled_one, scaled_plus(m->r, m->s));
    uint32_t place = ++f->weak * UINT32_C(0x9e3779b1);
    unsigned events = 0;
    for (int i = 0; i < n; i++) {
        scaled sum = scaled_zero();
        for (int j = i; j < n; j++) {
            const scaled entry = m->row ? row_entry(m->row, n, j) : m->exact[j], old = root_number(S, n, i, j);
            scaled both = sum, slope = scaled_zero(), taken = scaled_zero();
            scaled_add_times(&sum, &entry, &old);
            scaled_add(&both, &sum);
            scaled_add_times(&slope, &entry, &inverse);
            scaled_add_times(&taken, &slope, &both);
            root_take(S, n, i, j, taken, place += UINT32_C(0x85ebca6b));
        }
        events |= mean_correct_exactly(f->memory, n, i, sum, w);
        if (b) b[i] = sum;
    }
    filter_note_move(f, events);
}

#endif
