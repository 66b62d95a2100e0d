/* A view: a filter that shows a state in the memory of another object.  It is never ready, so what moves a
   filter refuses it, as it refuses one that was not initialised. */
#ifndef KQ_SRC_FILTER_VIEW_H
#define KQ_SRC_FILTER_VIEW_H

#include <stdint.h>

#include "kalmanq/status.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/compiler.h"
#include "../model/types.h"
#include "filter.h"
#include "likelihood.h"

/* Of nothing: all readings are NaN.  Answers the status. */
KQ_COLD static kq_status view_nothing(filter *view, kq_status status)
{
    *view = (filter){0};
    return status;
}

/* Of all components of a state: what is VIEW_OF_MEAN or VIEW_OF_STATE */
KQ_COLD static void view_state(filter *view, num *state, int n, int what, unsigned events)
{
    *view = (filter){.states = (uint8_t)n, .plain = (uint8_t)what, .events = (uint16_t)events, .memory = state};
    view->known = (uint16_t)filter_all_known(view);
    likelihood_clear(&view->last); /* what a copy begins with */
    likelihood_run_clear(&view->run);
}

#endif
