/* The filter object and its memory: the mean, then the root. */
#ifndef KQ_SRC_FILTER_STATE_H
#define KQ_SRC_FILTER_STATE_H

#include "../model/model.h"

static num *filter_root(const filter *f) { return f->memory + MEAN_PLANES * f->states; }

/* Bits of `ready`, beside which an unusual update may be in progress or done.  LOW_NOISE: one has been
   low-noise since the last predict.  WIDE: the mean has carries (mean_q31.h), until the call ends.
   OPEN: the call that will end it is the caller's.  NARROW: a low-noise one had noise: what it tells has to
   outlive the next predict. */
enum { FILTER_READY = 1, FILTER_LOW_NOISE = 2, FILTER_WIDE = 4, FILTER_OPEN = 8, FILTER_NARROW = 16 };

/* `plain` of a view (copies.h), which is never ready: a mean and no root, or both */
enum { VIEW_OF_MEAN = 64, VIEW_OF_STATE = 128 };

/* plain is what the steps of compile-time sizes look at. */
KQ_INLINE void filter_set_ready(filter *f, int ready)
{
    f->ready = (uint8_t)ready;
    f->plain = ready == FILTER_READY && !f->attached ? f->states : 0;
}

KQ_KERNEL void filter_note(filter *f, unsigned events)
{
    const unsigned inner = mean_widens ? MEAN_WIDE : 0; /* is told to nobody */
    if (events) f->events = (uint16_t)(f->events | (events & ~inner));
}

/* The events of a move of the mean, MEAN_WIDE among them */
KQ_KERNEL void filter_note_move(filter *f, unsigned events)
{
    filter_note(f, events);
    if (mean_widens && (events & MEAN_WIDE)) filter_set_ready(f, f->ready | FILTER_WIDE);
}

/* The mean that the call leaves is held within its words. */
KQ_COLD KQ_NOINLINE static void filter_saturate(filter *f)
{
    unsigned events = 0;
    if (f->ready & FILTER_OPEN) return;
    for (int i = 0; i < f->states; i++) events |= mean_saturate(f->memory, f->states, i);
    filter_note(f, events);
    filter_set_ready(f, f->ready & ~FILTER_WIDE);
}

KQ_KERNEL int filter_is_wide(const filter *f) { return mean_widens && (f->ready & FILTER_WIDE); }

/* What a low-noise measurement has told may be lost where S is rounded next, and later measurements bring that
   into sigmas. */
KQ_COLD KQ_NOINLINE static void note_condition(filter *f)
{
    if (!(f->ready & FILTER_NARROW)) return;
    if (root_is_ill_conditioned(filter_root(f), f->states, 0)) f->events |= KQ_EVENT_PRECISION;
}

/* What was attached before is not looked at: it may be gone. */
KQ_COLD static void filter_set_attached(filter *f, struct T(kq_attached) *a)
{
    f->attached = a;
    f->seal = 0;
    filter_set_ready(f, f->ready);
}

static inline uint32_t filter_all_known(const filter *f) { return (UINT32_C(1) << f->states) - 1; }

/* With the mean and the root that are in its memory, and nothing attached; what was is not looked at: it may
   be gone.  Every component can be read. */
KQ_COLD static void filter_make_ready(filter *f)
{
    f->ready = FILTER_READY;
    f->known = (uint16_t)filter_all_known(f);
    filter_set_attached(f, 0);
}

KQ_INLINE kq_status filter_check(const filter *f)
{
    if (!f) return KQ_ERR_NULL;
    return f->ready ? KQ_OK : KQ_ERR_NOT_READY;
}

KQ_COLD static kq_status filter_check_memory(const filter *f)
{
    if (!f) return KQ_ERR_NULL;
    if (!size_is_valid(f->states)) return KQ_ERR_SIZE;
    return f->memory && f->plain <= KQ_SIZE_MAX ? KQ_OK : KQ_ERR_MEMORY; /* a view's memory is another's */
}

/* Component c of z - H x */
KQ_COLD static scaled component_innovation(const filter *f, const reading *z, int c)
{
    const int n = f->states;
    const scaled *h = z->sensor->measurement + c * n;
    if (filter_is_wide(f)) return mean_residual_carried(z->z[c], h, f->memory, n);
    return mean_residual(z->z[c], h, f->memory, n, 0, n);
}

/* The innovation of decorrelated component c */
KQ_COLD static scaled correlated_innovation(const filter *f, const reading *z, int c)
{
    const sensor *s = z->sensor;
    scaled e = component_innovation(f, z, c);
    for (int j = c + 1; j < s->components; j++) {
        if (!(z->present >> j & 1)) continue;
        const scaled other = component_innovation(f, z, j);
        e = scaled_plus(e, scaled_times(z->noise[column(j) + c], other));
    }
    return e;
}

KQ_COLD static scaled scalar_innovation(const filter *f, const reading *z, int c)
{
    if (sensor_is_correlated(z->sensor)) return z->sensor->kind->innovation(f, z, c);
    return component_innovation(f, z, c);
}

#endif
