/* What moves a filter: predict and update. */
#ifndef KQ_SRC_FILTER_STEP_H
#define KQ_SRC_FILTER_STEP_H

#include "attached.h"
#include "checks.h"
#include "rounding.h"
#include "twins.h"

/* ------------------------------------------------------------------ predict */

/* After a low-noise measurement */
KQ_COLD KQ_NOINLINE static void predict_ends_low_noise(filter *f)
{
    note_condition(f);
    filter_set_ready(f, FILTER_READY);
}

/* Answers the events, which have been told. */
static unsigned predict_now(filter *f, const process *p, const num *u)
{
    watch_predict(f, p);
    const unsigned events = predict_state(f->memory, filter_root(f), p, p->controls ? u : 0);
    f->events = (uint16_t)(f->events | events);
    if (f->ready != FILTER_READY) predict_ends_low_noise(f);
    return events;
}

/* predict_now of a filter that may be recorded */
static void predict_recorded(filter *f, const process *p, const num *u)
{
    if (f->attached) f->attached->hooks->record_predict(f, p);
    if ((predict_now(f, p, u) & KQ_EVENT_OVERFLOW) && f->attached) f->attached->hooks->record_end(f);
}

/* kq_predict of a filter whose predicts are its own */
static kq_status predict_plain(filter *f, const process *p, const num *u)
{
    const kq_status status = predict_check(f, p, u);
    if (status) return status;
    (void)predict_now(f, p, u);
    return KQ_OK;
}

/* ------------------------------------------------------------------ update */

/* kq_update_subset of a filter whose updates are its own */
static kq_status update_present(filter *f, const sensor *s, const num *z, uint32_t present)
{
    const kq_status status = update_check(f, s, z, present);
    if (status) return status;
    const uint32_t all = (UINT32_C(1) << s->components) - 1;
    if (present & all) return s->kind->take(f, s, z, present);
    likelihood_clear(&f->last); /* the state keeps its very bits */
    return KQ_OK;
}

/* Is all right with a step?  (What is attached asks before it moves anything.) */
KQ_KERNEL kq_status step_check(const filter *f, const process *p, const num *u, const sensor *s, const num *z)
{
    const kq_status status = predict_check(f, p, u);
    return status ? status : update_check(f, s, z, UINT32_MAX);
}

#endif
