/*
 * The update by a scalar measurement that is unusual: it has low noise or comes after one that has, it is redundant, it
 * overflows, or the one before it has left the mean beyond its range.  It begins anew, so that the ordinary update
 * carries nothing along for it.
 */
#ifndef KQ_SRC_FILTER_LOW_NOISE_H
#define KQ_SRC_FILTER_LOW_NOISE_H

#include "attached.h"
#include "match.h"
#include "rounding.h"
#include "twins.h"
#include "weak.h"

/* One scalar measurement */
typedef struct {
    const reading *z;
    int component;
    const scaled *h; /* its row of H, decorrelated */
    scaled r, e;     /* its noise and its innovation */
    scaled floor;    /* what rounding alone makes of h'P h */
    scaled s, w;     /* the innovation variance, and e / s */
    int exact;       /* it has no noise */
    int sharp;       /* r is so far below s that the root has to be matched */
    int weak;        /* it takes next to nothing of P (weak.h) */
} low_noise_scalar;

/*
 * F = S'h, and what rounding alone makes of h'P h.  A decorrelated row and its innovation are sums,
 * which may cancel: they are rounded as their terms are, not as what is left of them.
 */
KQ_COLD static scaled project_with_floor(const filter *f, const reading *z, int c, const scaled *h,
                                 scaled *F)
{
    const num *S = filter_root(f);
    const int n = f->states;
    scaled *other = F + n, *sizes = F + 2 * n;
    const scaled least = project_exactly(F, S, h, other, n);
    if (!sensor_is_correlated(z->sensor)) return least;
    z->sensor->kind->row_sizes(z, c, sizes);
    return project_exactly(other, S, sizes, sizes + n, n);
}

/*
 * The rounding that S has by now, beside that floor: what is left of h'P h of a noise-free component
 * that came before in this update is rounding, too, of rows that were longer.
 */
KQ_COLD static scaled rounding_before(const filter *f, const reading *z, int c, scaled *spare)
{
    scaled most = {0}, *buffer = spare + 3 * f->states;
    for (int j = 0; j < c; j++) {
        if (!(z->present >> j & 1) || scaled_is_less(num_tiny, scalar_noise(z, j))) continue;
        const scaled least = project_with_floor(f, z, j, scalar_row(z, j, buffer), spare);
        const scaled left = square_of(spare, f->states);
        if (!scaled_is_less(num_left_over, left)) continue;
        const scaled share = scaled_over(left, least);
        if (scaled_is_less(most, share)) most = share;
    }
    return most;
}

/* Is the variance s no more than what rounding makes of H x?  Looked at only where that can be: for
   a noise-free component, or after a sharp one at this instant; 8 times the sigma of the rounding
   before count.  spare: FLOOR_PARTS n */
KQ_COLD static int is_redundant(const filter *f, const low_noise_scalar *m, scaled *spare)
{
    if (!scaled_is_less(num_zero_variance, m->s)) return 1;
    if (!(f->ready & FILTER_LOW_NOISE) && scaled_is_less(num_tiny, m->r)) return 0;
    if (!scaled_is_less(m->floor, m->s)) return 1;
    const scaled before = rounding_before(f, m->z, m->component, spare);
    const scaled least = scaled_times(scaled_times(scaled_of_count(64), before), m->floor);
    return !scaled_is_less(least, m->s);
}

/* What is not representable is not taken.  Where it is the state that is too large, or too uncertain for h'P h, it is
   held, and the measurement brings it back.  Answers whether it was held. */
KQ_COLD static int hold_state(filter *f, const scaled *h)
{
    f->events |= KQ_EVENT_OVERFLOW;
    if (!state_saturate(f->memory, filter_root(f), h, f->states)) return 0;
    if (f->attached) f->attached->hooks->record_end(f);
    return 1;
}

/* Does the innovation say something?  If not, there is an event. */
KQ_COLD static int innovation_counts(filter *f, const low_noise_scalar *m, scaled *spare)
{
    if (variance_overflows(m->s)) return 0;
    if (is_redundant(f, m, spare)) f->events |= KQ_EVENT_REDUNDANT;
    else if (likelihood_overflows(m->e, m->s)) hold_state(f, m->h);
    else return 1;
    return 0;
}

/*
 * A sharp component of which nothing more is known by now than rounding tells moves the state by as much
 * as its innovation is, and the other states by what rounding makes of that.  Rounding is not seen in its
 * variance where sharp ones that came at other instants have left it; it is seen where the innovation is
 * that far beyond its sigma.
 */
KQ_COLD static int contradicts(const low_noise_scalar *m, scaled nis)
{
    return m->sharp && scaled_is_less(num_most_sure, nis);
}

/* Is H x rounded by an eighth of the sigma that is left of it, or more?  That is sqrt(r), without noise nothing: of the
   innovation's sigma then.  Where h takes a state as it is a pair does not round. */
KQ_COLD static void note_rounding(filter *f, const reading *z, int c, const scaled *h, scaled least)
{
    if (mean_widens) return;
    const scaled square = mean_rounding(h, f->memory, f->states, z->sensor->selects[c] - 1);
    if (scaled_is_less(least, scaled_times(scaled_of_count(64), square))) f->events |= KQ_EVENT_PRECISION;
}

/* f and s, given h, r and e; does the innovation say something? */
KQ_COLD KQ_NOINLINE static int weigh_scalar(filter *f, low_noise_scalar *m, const low_noise_work *w)
{
    do {
        m->floor = project_with_floor(f, m->z, m->component, m->h, w->f);
        m->s = scaled_plus(m->r, square_of(w->f, f->states));
    } while (variance_overflows(m->s) && hold_state(f, m->h));
    return innovation_counts(f, m, w->floor);
}

/* What is known of it before the root is turned, recorded and told */
KQ_COLD KQ_NOINLINE static void tell_scalar(filter *f, low_noise_scalar *m, const low_noise_work *w)
{
    m->exact = !scaled_is_less(num_tiny, m->r);
    m->r = least_noise(m->r, m->s, m->h, f->states);
    m->w = scaled_over(m->e, m->s);
    m->sharp = scaled_is_less(m->r, low_noise_share(m->s));
    m->weak = !m->sharp && !m->exact && is_weak(m->r, m->s);
    if (!m->sharp && !m->exact && is_watched(f)) watch_row(f, m->h, m->r, WATCH_PERIOD); /* a sharp one outweighs rounding */
    if (f->attached) f->attached->hooks->record_update(f, m->h, 0, w->f, m->r, m->e, m->s);
    const scaled nis = scaled_times(m->e, m->w);
    likelihood_add(&f->last, nis, physical_variance(m->z->sensor, m->component, m->s));
    if (contradicts(m, nis)) f->events |= KQ_EVENT_CONTRADICTION;
}

/* Takes a scalar measurement, given h, r and e, into the root, the likelihood and the history, and
   fills in the rest of it and w; a weak one moves the mean, too.  Answers whether it was taken.  (Each part has
   its own frame, so that the stack is no deeper than the deepest of them.) */
KQ_COLD static int update_root(filter *f, low_noise_scalar *m, const low_noise_work *w)
{
    if (!weigh_scalar(f, m, w)) {
        if (f->attached) f->attached->hooks->record_nothing(f);
        return 0;
    }
    if (rows_share_exponents) note_condition(f);
    tell_scalar(f, m, w);
    /* where a sigma was at rounding before this instant's low-noise measurements, as q31's may, it is not theirs that is
       lost */
    const int was_ill = rows_share_exponents && m->sharp && !m->exact && !(f->ready & FILTER_LOW_NOISE) &&
                        root_is_ill_conditioned(filter_root(f), f->states, 1);
    const int narrows = m->sharp && !m->exact && !was_ill;
    if (m->weak) take_weak(f, &(weak_scalar){0, w->f, m->r, m->s}, m->w, w->b);
    else rotate_root_apart(filter_root(f), m->h, m->r, m->exact, w, m->sharp, f->states);
    if (m->sharp) filter_set_ready(f, f->ready | FILTER_LOW_NOISE | (narrows ? FILTER_NARROW : 0));
    return 1;
}

/* x += b w */
KQ_COLD KQ_NOINLINE static void update_mean(filter *f, const scaled *b, scaled w)
{
    unsigned events = 0;
    for (int i = 0; i < f->states; i++) {
        events |= mean_correct_exactly(f->memory, f->states, i, b[i], w);
    }
    filter_note_move(f, events);
}

/* Was the prediction further off than what was measured is large?  What the rounding of its innovation
   leaves is beyond the last bit of x then.  In fixed point it never is. */
KQ_COLD static int was_far_off(const low_noise_scalar *m)
{
    const scaled z = scaled_of_word(m->z->z[m->component]);
    return !mean_widens && scaled_is_less(scaled_magnitude(z), scaled_magnitude(m->e));
}

/*
 * After a low-noise measurement the residual is e r / s, but x has been moved with the rounding of one
 * number, perhaps many sigma: what is left of it is moved again.  Answers its square.  Where H x of the moved
 * mean is beyond the numbers that cannot be told: it moves nothing.
 */
KQ_COLD KQ_NOINLINE static scaled update_mean_again(filter *f, const low_noise_scalar *m,
                                                    const scaled *b)
{
    const scaled left = scalar_innovation(f, m->z, m->component);
    const scaled rest = scaled_minus(left, scaled_times(m->e, scaled_over(m->r, m->s)));
    if (likelihood_overflows(rest, m->s)) {
        f->events |= KQ_EVENT_PRECISION;
        return scaled_zero();
    }
    update_mean(f, b, scaled_over(rest, m->s));
    return scaled_times(rest, rest);
}

/* Each time leaves a rounding of what was left. */
KQ_COLD static void update_mean_to_end(filter *f, const low_noise_scalar *m, const scaled *b)
{
    const int is_far = was_far_off(m);
    for (int times = 0; times < (is_far ? mean_moves : 1); times++) {
        const scaled moved = update_mean_again(f, m, b);
        if (times >= 3 && !scaled_is_less(m->r, moved)) return;
    }
}

KQ_COLD KQ_NOINLINE static void take_scalar_in(filter *f, low_noise_scalar *m, scaled *memory)
{
    const low_noise_work w = low_noise_work_at(memory, f->states);
    if (!update_root(f, m, &w)) return;
    if (!m->weak) update_mean(f, w.b, m->w);
    if (m->sharp) update_mean_to_end(f, m, w.b);
    note_rounding(f, m->z, m->component, m->h, m->exact ? m->s : m->r);
}

/* The scratch lives on the stack, in a few sizes. */
KQ_COLD KQ_NOINLINE static void take_scalar_to_2(filter *f, low_noise_scalar *m)
{
    scaled memory[LOW_NOISE_PARTS * 2];
    take_scalar_in(f, m, memory);
}

KQ_COLD KQ_NOINLINE static void take_scalar_to_4(filter *f, low_noise_scalar *m)
{
    scaled memory[LOW_NOISE_PARTS * 4];
    take_scalar_in(f, m, memory);
}

KQ_COLD KQ_NOINLINE static void take_scalar_to_16(filter *f, low_noise_scalar *m)
{
    scaled memory[LOW_NOISE_PARTS * KQ_SIZE_MAX];
    take_scalar_in(f, m, memory);
}

/* Component c of a reading, of row h and innovation e */
KQ_COLD KQ_NOINLINE static void take_with_care(filter *f, const reading *z, int c, const scaled *h, scaled e)
{
    low_noise_scalar m; /* the rest of it is found on the way */
    m.z = z;
    m.component = c;
    m.h = h;
    m.r = scalar_noise(z, c);
    m.e = filter_is_wide(f) ? scalar_innovation(f, z, c) : e;
    if (f->states <= 2) take_scalar_to_2(f, &m);
    else if (f->states <= 4) take_scalar_to_4(f, &m);
    else take_scalar_to_16(f, &m);
}

#endif
