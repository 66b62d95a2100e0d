/* What moves a filter: predict and update. */
#ifndef KQ_SRC_FILTER_STEP_H
#define KQ_SRC_FILTER_STEP_H

#include <stdint.h>

#include "kalmanq/status.h"

#include "../arithmetic/arithmetic.h"
#include "../model/advance.h"
#include "../model/process.h"
#include "../model/types.h"
#include "checks.h"
#include "filter.h"
#include "likelihood.h"
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

static kq_status filter_predict(filter *f, const process *p, const num *u)
{
    const kq_status status = predict_check(f, p, u);
    if (status) return status;
    predict_now(f, p, u);
    return KQ_OK;
}

/* ------------------------------------------------------------------ update */

static kq_status filter_update(filter *f, const sensor *s, const num *z)
{
    const kq_status status = update_check(f, s, z, UINT32_MAX);
    return status ? status : s->kind->take(f, s, z, UINT32_MAX);
}

static kq_status filter_update_subset(filter *f, const sensor *s, const num *z, uint32_t present)
{
    const kq_status status = update_check(f, s, z, present);
    if (status) return status;
    const uint32_t all = (UINT32_C(1) << s->components) - 1;
    if (present & all) return s->kind->take(f, s, z, present);
    likelihood_clear(&f->last); /* the state keeps its very bits */
    return KQ_OK;
}

static kq_status filter_step(filter *f, const process *p, const num *u, const sensor *s,
                             const num *z)
{
    kq_status status = predict_check(f, p, u);
    if (status) return status;
    status = update_check(f, s, z, UINT32_MAX);
    if (status) return status;
    predict_now(f, p, u);
    return s->kind->take(f, s, z, UINT32_MAX);
}

#endif
