/* The update by scalar measurements, one after the other. */
#ifndef KQ_SRC_FILTER_UPDATE_H
#define KQ_SRC_FILTER_UPDATE_H

#include "attached.h"
#include "rounding.h"
#include "twins.h"

/*
 * The measurement update of the root by one scalar measurement, Carlson's form.
 *     f = S'h,   a_j = r + f_0^2 + ... + f_j^2,   s = a_{n-1} the innovation variance
 *     c_j = sqrt(a_{j-1} / a_j),   S_j <- c_j S_j - (c_j f_j / a_{j-1}) b,   b += f_j S_j
 * At the end b = S f is s times the gain.  It is n Givens rotations of (r, f) that the
 * smoother will undo.  r > 0, so no a_j is 0; each c_j <= 1 and rows only shrink.
 *
 * b takes the place of f: entry j is read before the first of b's that comes there.
 */
KQ_KERNEL void rotate_root(rotor *state, num *restrict S, num *restrict f, scaled r, scaled s, int n)
{
    rotor_begin(state, r, s, f, n);
    KQ_UNROLL
    for (int j = 0; j < n; j++) {
        if (is_no_turn(f[j])) {
            f[j] = 0;
        } else {
            const rotation turn = rotor_turn(state, f[j]);
            rotate(S, f, turn, j);
        }
        S += j + 1;
    }
}

/* x += b w */
KQ_KERNEL void move_mean(filter *f, const num *b, const num *S, scaled w, int n)
{
    unsigned events = 0;
    KQ_UNROLL
    for (int i = 0; i < n; i++) {
        events |= mean_correct(f->memory, n, i, column_entry(b, S, n, i), w);
    }
    filter_note_move(f, events);
}

/*
 * Takes component c of a reading into the filter: row h, noise r, innovation e.  selected: 1 + the state that h takes
 * alone and as it is, or 0.  Answers 0, and has done nothing, where something is unusual (low_noise.h).
 *   may_ask      the state may be unusual; steps of compile-time sizes have asked before the first component
 *   is_copy      a step of compile-time sizes works on a copy, which is forgotten where anything is unusual
 *   surely       a cheaper bound says that the measurement is blunt; a copy has no other, and asks at its end whether it is weak
 */
KQ_KERNEL int take_scalar(filter *f, const reading *z, int c, const scaled *h, int selected,
                          scaled r, scaled e, int n, int mode)
{
    num row[ROW_LEN(KQ_SIZE_MAX)], *S = f->memory + MEAN_PLANES * n;
    if (selected) project_selected(row, S, h[selected - 1], selected - 1, n);
    else project(row, S, h, n);
    const scaled s = add_square(r, row, n);
    const int may_ask = mode == MODE_GENERAL || (mean_widens && c > 0);
    const int is_copy = mode != MODE_GENERAL && n <= states_in_registers;
    const int surely = mode != MODE_GENERAL && KQ_MOSTLY(is_certainly_blunt(r, s, e));
    const int blunt = surely || (!is_copy && is_blunt(r, s, e));
    if ((may_ask && f->ready != FILTER_READY) || !blunt || (!is_copy && is_weak(r, s))) return 0;
    if (mode == MODE_GENERAL && f->attached) f->attached->hooks->record_update(f, h, row, 0, r, e, s);
    if (mode == MODE_GENERAL && is_watched(f)) watch_rounding(f, h, row, r, s, WATCH_PERIOD);
    rotor end;
    rotate_root(&end, S, row, r, s, n);
    const num *gain = row; /* b = s K has taken the place of S'h */
    const scaled w = rotor_weight(&end, e, s);
    KQ_IN_ORDER;
    move_mean(f, gain, S, w, n);
    renormalise_if_strong(S, r, s, n);
    if (mode != MODE_BARE) likelihood_add(&f->last, weight_nis(w, e), physical_variance(z->sensor, c, s));
    return !is_copy || !is_weak(r, s);
}

/* What is left to the end of an update */
KQ_INLINE void settle(filter *f, int n)
{
    mean_settle(f->memory, n);
    if (filter_is_wide(f)) filter_saturate(f);
    renormalise(f->memory + MEAN_PLANES * n, n);
}

/* What ends an update */
KQ_INLINE void update_end(filter *f)
{
    settle(f, f->states);
    likelihood_run_add(&f->run, &f->last);
}

/* Component c of a sensor whose components are independent.  Where the mean has carries e is not yet
   its innovation: that is unusual. */
KQ_KERNEL int take_component(filter *f, const reading *z, int c, int n, int mode)
{
    const scaled *h = z->sensor->measurement + c * n;
    const int selected = mode == MODE_GENERAL || select_always ? z->sensor->selects[c] : 0;
    const int from = selected ? selected - 1 : 0, to = selected ? selected : n;
    const scaled e = mean_residual(z->z[c], h, f->memory, n, from, to);
    return take_scalar(f, z, c, h, selected, z->noise[c], e, n, mode);
}

#endif
