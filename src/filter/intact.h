/* Can a filter be what a call has left? */
#ifndef KQ_SRC_FILTER_INTACT_H
#define KQ_SRC_FILTER_INTACT_H

#include "attached.h"
#include "twins.h"

enum { ALL_EVENTS = 2 * KQ_EVENT_CONTRADICTION - 1 };

/* Is something unknown yet?  The start that knows what is attached then. */
KQ_COLD static int is_starting(const filter *f)
{
    return f->attached->hooks->give && f->known != filter_all_known(f);
}

/* Of a filter that is ready: `known` is whole, and a low-noise measurement is one (NARROW has SHARP). */
KQ_COLD static int flags_are_possible(const filter *f)
{
    const int between = FILTER_READY | FILTER_LOW_NOISE | FILTER_NARROW;
    const int plain = f->ready == FILTER_READY && !f->attached ? f->states : 0;
    if ((f->plain && f->plain != plain) || f->events > ALL_EVENTS) return 0;
    if (!f->ready) return 1;
    if (!(f->ready & FILTER_READY) || f->ready & ~between || f->known != filter_all_known(f)) return 0;
    return !(f->ready & FILTER_NARROW) || f->ready & FILTER_LOW_NOISE;
}

/* Mean and root as a step may leave them */
KQ_COLD static kq_status state_check(const filter *f)
{
    const int n = f->states;
    const num *S = filter_root(f);
    if (!mean_is_finite(f->memory, n)) return KQ_ERR_NOT_FINITE;
    for (int i = 0; i < n; i++) {
        if (!row_is_possible(S, n, i) || !mean_is_possible(f->memory, n, i)) return KQ_ERR_TABLE;
    }
    return KQ_OK;
}

KQ_COLD kq_status T(kq_filter_check)(filter *f)
{
    if (!f) return KQ_ERR_NULL;
    if (!f->ready && !f->attached) return KQ_ERR_NOT_READY;
    const uint8_t seal = seal_close(filter_addresses(f));
    if (!size_is_valid(f->states) || !f->memory || (f->seal && f->seal != seal)) return KQ_ERR_TABLE;
    if (!f->ready && !is_starting(f)) return KQ_ERR_NOT_READY;
    if (!flags_are_possible(f)) return KQ_ERR_TABLE;
    if (!likelihood_is_possible(&f->last) || !likelihood_run_is_possible(&f->run)) return KQ_ERR_TABLE;
    const kq_status status = state_check(f);
    if (!status) f->seal = seal;
    return status;
}

#endif
