/*
 * The update by a sensor without the careful path.  A measurement of low noise r is taken in stages, each by the ordinary
 * kernel.  The first has the least noise r1 that this kernel bears.  What is left of the measurement is the same z with the
 * noise r r1 / (r1 - r), and the next stage takes it.  No stage measures less of h'P h than rounding makes of it: that would
 * take variance from other directions.
 */
#ifndef KQ_SRC_FILTER_LEAN_H
#define KQ_SRC_FILTER_LEAN_H

#include "low_noise.h"
#include "update.h"
#include "weak.h"

enum { LEAN_STAGES = 4 }; /* down to 2^-60 of H P H' (f64: 2^-144) */

/* x += b w, of a mean that may have carries */
KQ_INLINE void move_lean_mean(filter *f, const num *b, const num *S, scaled w, int n)
{
    unsigned events = 0;
    if (!mean_widens) {
        move_mean(f, b, S, w, n);
        return;
    }
    for (int i = 0; i < n; i++) events |= mean_correct_exactly(f->memory, n, i, column_entry(b, S, n, i), w);
    filter_note_move(f, events);
}

/* Root and mean by f = S'h.  Answers the NIS. */
KQ_PART scaled take_row(filter *f, num *row, scaled r, scaled s, scaled e)
{
    num *S = filter_root(f);
    rotor end;
    if (is_weak(r, s)) {
        const scaled share = scaled_over(e, s);
        take_weak(f, &(weak_scalar){row, 0, r, s}, share, 0);
        return scaled_times(e, share);
    }
    rotate_root(&end, S, row, r, s, f->states);
    const scaled w = rotor_weight(&end, e, s);
    move_lean_mean(f, row, S, w, f->states);
    renormalise_if_strong(S, r, s, f->states);
    return weight_nis(w, e);
}

/*
 * One stage of component c.  *left: the noise of what has not been taken, before and after.  least: the least h'P h that
 * is more than rounding.  The first stage is recorded and scored, with noise and variance as given.  Answers STAGE_..., and has
 * done nothing where the variance overflows or says nothing.
 */
enum { STAGE_REFUSED, STAGE_LAST, STAGE_MORE };

KQ_NOINLINE static int take_stage(filter *f, num *row, const reading *z, int c, scaled *left, scaled least, int is_first)
{
    const int n = f->states, selected = z->sensor->selects[c];
    const int from = selected ? selected - 1 : 0, to = selected ? selected : n;
    const scaled *h = z->sensor->measurement + c * n, given = *left;
    num *S = filter_root(f);
    scaled e = mean_residual(z->z[c], h, f->memory, n, from, to);
    if (filter_is_wide(f)) mean_take_carries(&e, h, f->memory, n);
    if (selected) project_selected(row, S, h[from], from, n);
    else project(row, S, h, n);
    const scaled variance = add_square(given, row, n);
    if (!is_first && scaled_is_less(variance, scaled_plus(least, given))) return STAGE_REFUSED;
    scaled r = given, s = variance;
    int answer = STAGE_LAST;
    while (!has_noise_enough(r, s, e)) {
        if (!raise_noise(&r, s)) return STAGE_REFUSED;
        s = add_square(r, row, n);
        answer = STAGE_MORE;
    }
    const int counts = scaled_is_less(num_zero_variance, variance);
    const scaled s0 = counts ? variance : s, r0 = counts ? given : r;
    if (is_first && f->attached) f->attached->hooks->record_update(f, h, row, 0, least_noise(r0, s0, h, n), e, s0);
    const scaled last = take_row(f, row, r, s, e);
    if (is_first) {
        const scaled nis = answer == STAGE_LAST ? last : scaled_times(e, scaled_over(e, s0));
        likelihood_add(&f->last, nis, physical_variance(z->sensor, c, s0));
    }
    if (answer == STAGE_MORE) *left = scaled_times(r, scaled_over(given, scaled_minus(r, given)));
    return answer;
}

/* Makes ready for another stage: the rows as long as they may be.  Answers a 16th of the floor, (16 eps)^2 of the terms of
   h'P h: the rows are shorter by now, and their rounding. */
KQ_COLD KQ_NOINLINE static scaled stage_begin(filter *f, const reading *z, int c)
{
    const int n = f->states, has_noise = scaled_is_less(num_tiny, z->noise[c]);
    mean_settle(f->memory, n);
    renormalise(filter_root(f), n);
    filter_set_ready(f, f->ready | FILTER_LOW_NOISE | (has_noise ? FILTER_NARROW : 0));
    const scaled *h = z->sensor->measurement + c * n;
    if (has_noise) note_rounding(f, z, c, h, z->noise[c]);
    return scaled_shift(floor_of_square(filter_root(f), h, n), -4);
}

/* Component c of a reading.  Answers 0 where it overflows, and has done nothing. */
KQ_INLINE int take_lean_component(filter *f, const reading *z, int c)
{
    num row[ROW_LEN(KQ_SIZE_MAX)];
    scaled left = z->noise[c], least = scaled_zero();
    for (int stage = 1;; stage++) {
        const int answer = take_stage(f, row, z, c, &left, least, stage == 1);
        if (answer == STAGE_LAST || (answer == STAGE_REFUSED && stage == 1)) return answer;
        if (answer == STAGE_REFUSED || stage == LEAN_STAGES) break;
        least = stage_begin(f, z, c);
    }
    f->events |= KQ_EVENT_LOW_NOISE;
    return STAGE_LAST;
}

static kq_status take_lean(filter *f, const sensor *s, const num *z, uint32_t present)
{
    const reading now = {s, s->noise, z, present};
    likelihood_clear(&f->last);
    for (int c = 0; c < s->components; c++) {
        if (!(present >> c & 1)) continue;
        while (!take_lean_component(f, &now, c)) {
            if (hold_state(f, s->measurement + c * f->states)) continue; /* once: then it is held */
            if (f->attached) f->attached->hooks->record_nothing(f);
            break;
        }
    }
    settle(f, f->states);
    return KQ_OK;
}

#endif
