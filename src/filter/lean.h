/*
 * The update by a sensor without the careful path.  A measurement of low noise is taken in stages, each by the ordinary
 * kernel: with the least noise r1 that this bears, then what that leaves of the measurement, which is the same z with the
 * noise r r1 / (r1 - r), of the state as it is by then.  What is left of h'P h may be less than rounding makes of it:
 * to measure that would take variance from other directions.  No stage does.
 */
#ifndef KQ_SRC_FILTER_LEAN_H
#define KQ_SRC_FILTER_LEAN_H

#include "low_noise.h"
#include "update.h"

enum { LEAN_STAGES = 4 }; /* down to 2^-60 of H P H' (f64: 2^-144) */
enum { FLOOR_SHIFT = -4 }; /* a 16th of the floor of project_exactly is (16 eps)^2 of the terms of h'P h */

/* A measurement on its way; no noise is left where all of it has been taken. */
typedef struct {
    scaled noise, e; /* to be taken; its innovation */
    scaled r, s;     /* as given, and the variance of e then, for what is recorded and scored */
} staged;

/* The noise r that the next stage takes, and s = r + |row|^2.  Answers 1, 2 if r was raised, or 0: it overflows. */
KQ_KERNEL int stage_noise(scaled *r, scaled *s, const staged *m, const num *row, int n)
{
    int answer = 1;
    *r = m->noise;
    while (*s = add_square(*r, row, n), !has_noise_enough(*r, *s, m->e)) {
        if (!raise_noise(r, *s)) return 0;
        answer = 2;
    }
    return answer;
}

/* r and s as given, unless they count as 0: then as they are taken */
KQ_COLD KQ_NOINLINE static void stage_take_given(staged *m, const num *row, const scaled *h, int n)
{
    const scaled s = add_square(m->noise, row, n);
    if (!scaled_is_less(num_zero_variance, s)) return;
    m->s = s;
    m->r = least_noise(m->noise, s, h, n);
}

/* One stage of component c.  Answers 0 where it overflows. */
KQ_KERNEL int take_stage(filter *f, const reading *z, int c, staged *m, int is_first, int n)
{
    num row[ROW_LEN(KQ_SIZE_MAX)], *S = filter_root(f);
    const scaled *h = z->sensor->measurement + c * n;
    const int selected = z->sensor->selects[c], from = selected ? selected - 1 : 0, to = selected ? selected : n;
    m->e = mean_residual(z->z[c], h, f->memory, n, from, to);
    if (selected) project_selected(row, S, h[from], from, n);
    else project(row, S, h, n);
    scaled r, s;
    const int answer = stage_noise(&r, &s, m, row, n);
    if (!answer) return 0;
    m->r = r, m->s = s;
    if (is_first && answer == 2) stage_take_given(m, row, h, n);
    if (is_first && f->attached) f->attached->hooks->record_update(f, h, row, 0, m->r, m->e, m->s);
    rotor end;
    rotate_root(&end, S, row, r, s, n);
    const scaled w = rotor_weight(&end, m->e, s);
    move_mean(f, row, S, w, n);
    renormalise_if_strong(S, r, s, n);
    if (is_first) {
        const scaled nis = answer == 1 ? weight_nis(w, m->e) : scaled_times(m->e, scaled_over(m->e, m->s));
        likelihood_add(&f->last, nis, physical_variance(z->sensor, c, m->s));
        if (is_weak(m->r, m->s)) count_weak(f);
    }
    if (answer == 1) m->noise = scaled_zero();
    else m->noise = scaled_over(scaled_times(r, m->noise), scaled_minus(r, m->noise));
    return answer;
}

/* Is what is left of h'P h more than rounding makes of the rows as they are by now? */
KQ_COLD KQ_NOINLINE static int stage_counts(const num *S, const scaled *h, int n)
{
    scaled F[KQ_SIZE_MAX], spare[KQ_SIZE_MAX];
    const scaled floor = project_exactly(F, S, h, spare, n);
    return scaled_is_less(scaled_shift(floor, FLOOR_SHIFT), square_of(F, n));
}

/* Makes ready for the next stage: the mean within its words, the rows as long as they may be.  Is there one? */
KQ_COLD KQ_NOINLINE static int stage_begin(filter *f, const reading *z, int c)
{
    const int n = f->states, has_noise = scaled_is_less(num_tiny, z->noise[c]);
    settle(f, n);
    filter_set_ready(f, f->ready | FILTER_LOW_NOISE | (has_noise ? FILTER_NARROW : 0));
    return stage_counts(filter_root(f), z->sensor->measurement + c * n, n);
}

/* Component c of a reading.  Answers 0 where it overflows, and has done nothing. */
KQ_NOINLINE static int take_lean_component(filter *f, const reading *z, int c)
{
    const int n = f->states;
    staged m;
    m.noise = z->noise[c];
    if (filter_is_wide(f)) filter_saturate(f);
    for (int stage = 0; stage < LEAN_STAGES; stage++) {
        if (stage && !stage_begin(f, z, c)) break;
        const int answer = take_stage(f, z, c, &m, stage == 0, n);
        if (answer != 2) return answer || stage;
    }
    f->events |= KQ_EVENT_LOW_NOISE;
    return 1;
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
