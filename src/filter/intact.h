/* Can a filter be what a call has left? */
#ifndef KQ_SRC_FILTER_INTACT_H
#define KQ_SRC_FILTER_INTACT_H

#include <stdint.h>

#include "kalmanq/filter.h"
#include "kalmanq/status.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/compiler.h"
#include "../arithmetic/size.h"
#include "../model/types.h"
#include "filter.h"
#include "prior.h"

enum { ALL_EVENTS = 2 * KQ_EVENT_CONTRADICTION - 1 };

/* A start knows less than all. */
KQ_COLD static int flags_are_possible(const filter *f)
{
    const int between = FILTER_READY | FILTER_SHARP | FILTER_NARROW;
    const uint32_t all = (UINT32_C(1) << f->states) - 1;
    const int plain = f->ready == FILTER_READY && !f->attached ? f->states : 0;
    if (!(f->ready & FILTER_READY) || f->ready & ~between) return 0;
    if (f->known != all || f->plain != plain) return 0;
    return !(f->events & ~ALL_EVENTS);
}

KQ_COLD kq_status T(kq_filter_check)(const filter *f)
{
    const kq_status status = filter_check(f);
    if (status) return status;
    if (!size_is_valid(f->states) || !f->memory || !flags_are_possible(f)) return KQ_ERR_TABLE;
    return state_is_possible(f) ? KQ_OK : KQ_ERR_TABLE;
}

#endif
