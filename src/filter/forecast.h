/* A copy of a filter, and a look ahead on one. */
#ifndef KQ_SRC_FILTER_FORECAST_H
#define KQ_SRC_FILTER_FORECAST_H

#include "kalmanq/status.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/root.h"
#include "../model/types.h"
#include "filter.h"

/* Has `to` room for the state of `from` beside it? */
static kq_status copy_check(const filter *to, const filter *from)
{
    if (!to) return KQ_ERR_NULL;
    if (filter_check_memory(to)) return KQ_ERR_MEMORY;
    if (to == from || to->memory == from->memory || to->states != from->states) {
        return KQ_ERR_MISMATCH;
    }
    return KQ_OK;
}

/* All but the memory, which is its own, and what is attached, which goes on by `from` alone */
static void copy_state(filter *to, const filter *from)
{
    num *memory = to->memory;
    *to = *from;
    to->memory = memory;
    if (!to->ready) to->ready = FILTER_READY; /* from a view */
    filter_set_attached(to, 0);
    copy(memory, from->memory, FILTER_LEN(from->states));
}

#endif
