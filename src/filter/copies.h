/* A filter as a view of a state that another object keeps, and as a copy of another filter. */
#ifndef KQ_SRC_FILTER_COPIES_H
#define KQ_SRC_FILTER_COPIES_H

#include "twins.h"

/* ------------------------------------------------------------------ views */

/* A view is never ready: what moves a filter refuses it, as it refuses one that was not initialised. */

/* Of nothing: all readings are NaN.  Answers the status. */
KQ_COLD static kq_status view_nothing(filter *view, kq_status status)
{
    clear_bytes(view, sizeof *view);
    return status;
}

/* Of all components of a state: what is VIEW_OF_MEAN or VIEW_OF_STATE */
KQ_COLD static void view_state(filter *view, num *state, int n, int what, unsigned events)
{
    clear_bytes(view, sizeof *view);
    view->states = (uint8_t)n;
    view->plain = (uint8_t)what;
    view->events = (uint16_t)events;
    view->memory = state;
    view->known = (uint16_t)filter_all_known(view);
    likelihood_clear(&view->last); /* what a copy begins with */
    likelihood_run_clear(&view->run);
}

/* ------------------------------------------------------------------ copies */

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
