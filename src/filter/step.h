/* What moves a filter: predict and update. */
#ifndef KQ_SRC_FILTER_STEP_H
#define KQ_SRC_FILTER_STEP_H

#include <stdint.h>

#include "kalmanq/status.h"

#include "../arithmetic/arithmetic.h"
#include "../model/advance.h"
#include "../model/process.h"
#include "../model/types.h"
#include "filter.h"
#include "tape.h"

/* ------------------------------------------------------------------ predict */

static void predict_now(filter *f, const process *p, const num *u)
{
    if (f->history) f->history->recorder->predict(f, p);
    const unsigned events =
        predict_state(f->memory, filter_root(f), p, p->controls ? u : 0, f->states, SHAPE_AS_FOUND);
    f->events = (uint16_t)(f->events | events);
    if ((events & KQ_EVENT_OVERFLOW) && f->history) history_end(f);
    if (f->ready != FILTER_READY) filter_set_ready(f, FILTER_READY);
}

/* ------------------------------------------------------------------ update */

#endif
