/*
 * Updates that an outlier does not move far, or that follow a jump of the state.
 *
 * A loss chooses a number (the noise r of a scalar measurement, a factor of the root of P) from what is known before
 * the update.  The ordinary step is then taken with it: a history records that step, and the root stays sound.  NIS
 * and likelihood are those of the model as given.  The losses are in losses.h and gate.h.
 */
#ifndef KQ_SRC_ROBUST_UPDATE_H
#define KQ_SRC_ROBUST_UPDATE_H

#include "robust.h"

typedef T(kq_loss) loss;
typedef struct T(kq_loss_kind) loss_kind;

/* One scalar measurement as the arithmetic sees it before it is taken */
typedef struct {
    const scaled *h;
    int component, selected;
    scaled e;
    scaled *noise; /* its entry in the reading's noise */
} robust_scalar;

/* What is done for a loss, by reference, from the user's initialiser: a program links the losses that it names. */
struct T(kq_loss_kind) {
    kq_status (*check)(const filter *f, const loss *how);
    checked_update *update; /* update_robust, or one that needs none of what follows */
    /* Of a loss that changes r: the noise to take it with, e being the innovation and `square` h'P h */
    scaled (*noise)(scaled r, scaled square, scaled e, scaled parameter);
    /* Of one that changes P: what it does to f before m is taken */
    void (*raise)(filter *f, const reading *z, const robust_scalar *m, scaled square, scaled parameter);
};

/* A scalar measurement as the low-noise update has it (filter/low_noise.h), s the variance of its innovation */
static low_noise_scalar low_noise_of(const filter *f, const reading *z, const robust_scalar *m, scaled s,
                                 scaled *spare)
{
    const scaled least = project_with_floor(f, z, m->component, m->h, spare);
    return (low_noise_scalar){.z = z, .component = m->component, .h = m->h, .r = *m->noise, .e = m->e,
                            .floor = least, .s = s};
}

/* Would the plain update take it?  If not, the events are those of the plain update: a larger noise
   or a larger P would only hide why. */
KQ_NOINLINE static int plain_update_takes(filter *f, const reading *z, const robust_scalar *m, scaled s)
{
    scaled spare[FLOOR_PARTS * KQ_SIZE_MAX];
    const low_noise_scalar plain = low_noise_of(f, z, m, s, spare);
    return innovation_counts(f, &plain, spare);
}

static void project_scalar(num *row, const filter *f, const robust_scalar *m)
{
    const num *S = filter_root(f);
    const int k = m->selected - 1;
    if (m->selected) project_selected(row, S, m->h[k], k, f->states);
    else project(row, S, m->h, f->states);
}

/* Answers whether it may be taken, noise or root made ready for it; its weight, 1 where it is taken
   as it is, and the innovation variance as given. */
static int robust_prepare(filter *f, const reading *z, const robust_scalar *m, const loss *how,
                          scaled *weight, scaled *s)
{
    num row[ROW_LEN(KQ_SIZE_MAX)];
    const scaled r = *m->noise;
    scaled square;
    *weight = scaled_one;
    do {
        project_scalar(row, f, m);
        square = row_product(row, row, f->states);
        *s = scaled_plus(r, square);
    } while (variance_overflows(*s) && hold_state(f, m->h));
    const int is_plain = f->ready == FILTER_READY && is_ordinary(r, *s, m->e);
    if (!is_plain && !plain_update_takes(f, z, m, *s)) return 0;
    if (!how->kind->noise) {
        how->kind->raise(f, z, m, square, how->parameter);
        return 1;
    }
    *m->noise = how->kind->noise(r, square, m->e, how->parameter);
    if (!scaled_is_zero(*m->noise)) *weight = scaled_over(r, *m->noise);
    if (!likelihood_overflows(m->e, scaled_plus(*m->noise, *s))) return 1;
    f->events |= KQ_EVENT_OVERFLOW;
    return 0;
}

/* What is told of one that was taken: that of noise r and variance s, as given.  What contradicts
   (filter/low_noise.h) is no less one for being clipped. */
static void robust_tell(filter *f, const reading *z, const robust_scalar *m, scaled r, scaled s)
{
    const scaled nis = scaled_times(m->e, scaled_over(m->e, s));
    likelihood_add(&f->last, nis, physical_variance(z->sensor, m->component, s));
    if (scaled_is_less(num_tiny, r) || !scaled_is_less(num_most_sure, nis)) return;
    f->events |= KQ_EVENT_CONTRADICTION;
}

/* Takes it with a noise or a P of its own, and answers its weight. */
KQ_NOINLINE static scaled take_robust(filter *f, const reading *z, const robust_scalar *m,
                                      const loss *how)
{
    const scaled zero = scaled_zero();
    scaled weight, s;
    const scaled r = *m->noise;
    if (!robust_prepare(f, z, m, how, &weight, &s)) {
        if (f->attached) f->attached->hooks->record_nothing(f);
        return zero;
    }
    const likelihood before = f->last;
    const unsigned others = f->events | ~(unsigned)KQ_EVENT_CONTRADICTION;
    if (!take_scalar(f, z, m->component, m->h, m->selected, *m->noise, m->e, f->states,
                     MODE_GENERAL)) {
        take_with_care(f, z, m->component, m->h, m->e);
    }
    /* an outlier may say as little as it likes */
    if (scaled_is_less(weight, scaled_one)) f->events = (uint16_t)(f->events & others);
    if (f->last.count == before.count) return zero;
    f->last = before;
    robust_tell(f, z, m, r, s);
    return weight;
}

static void robust_scalar_of(robust_scalar *m, const filter *f, const reading *z, scaled *noise, int c,
                             scaled *buffer)
{
    const int n = f->states, correlated = sensor_is_correlated(z->sensor);
    m->component = c;
    m->selected = correlated ? 0 : z->sensor->selects[c];
    m->noise = noise + (correlated ? column(c) + c : c);
    m->h = scalar_row(z, c, buffer);
    const int from = m->selected ? m->selected - 1 : 0, to = m->selected ? m->selected : n;
    m->e = correlated || filter_is_wide(f)
               ? scalar_innovation(f, z, c)
               : mean_residual(z->z[c], m->h, f->memory, n, from, to);
}

/* A copy of the sensor's noise, made anew where components are missing */
static void noise_of_reading(scaled *noise, const sensor *s, uint32_t present)
{
    const int m = s->components, length = sensor_is_correlated(s) ? KQ_TRIANGLE(m) : m;
    const int remade = noise_is_of_others(s, present);
    if (remade) noise_of_present(noise, s, present);
    for (int k = 0; !remade && k < length; k++) noise[k] = s->noise[k];
}

static int is_none_present(const sensor *s, uint32_t present)
{
    return (present & ((UINT32_C(1) << s->components) - 1)) == 0;
}

KQ_NOINLINE static void update_robust(filter *f, const sensor *s, const num *z, uint32_t present, loss *how)
{
    const scaled zero = scaled_zero();
    scaled noise[KQ_TRIANGLE(KQ_SIZE_MAX)], buffer[KQ_SIZE_MAX];
    const reading now = {s, noise, z, present};
    robust_scalar one;
    noise_of_reading(noise, s, present);
    likelihood_clear(&f->last);
    for (int c = 0; c < s->components; c++) {
        scaled weight = zero;
        if (present >> c & 1) {
            robust_scalar_of(&one, f, &now, noise, c, buffer);
            weight = take_robust(f, &now, &one, how);
        }
        if (how->weights) how->weights[c] = weight;
    }
    if (is_none_present(s, present)) return; /* the state keeps its very bits */
    update_end(f);
}

kq_status T(kq_update_robust)(filter *f, const sensor *s, const num *z, uint32_t present, loss *how)
{
    kq_status status = update_check(f, s, z, present);
    if (status) return status;
    if (!how || !how->kind) return KQ_ERR_NULL;
    status = how->kind->check(f, how);
    if (status) return status;
    checked_update *update = how->kind->update;
    if (takes_innovations(s)) return innovation_kind_of(s)->around(f, s, z, present, update, how);
    update(f, s, z, present, how);
    return KQ_OK;
}

#endif
