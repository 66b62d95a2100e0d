/* How a history, and what begins with one, is attached and detached. */
#ifndef KQ_SRC_SMOOTHER_RECORDER_H
#define KQ_SRC_SMOOTHER_RECORDER_H

#include "tape.h"

static kq_status history_attach(filter *f, attached *object)
{
    if (f->attached && f->attached->hooks->give) return f->attached->hooks->give(f, (history *)object);
    return tape_attach((history *)object, f, &T(kq_history_hooks));
}

/* What has been smoothed stays to be read. */
static kq_status history_detach(attached *object)
{
    history *h = (history *)object;
    filter *f = h->filter;
    if (is_attached(f) && f->attached->hooks->lose) f->attached->hooks->lose(f, h);
    if (f && f->attached == object) filter_set_attached(f, 0);
    h->filter = 0;
    if (h->phase == HISTORY_SMOOTHING || h->phase == HISTORY_STATES) return KQ_OK;
    h->phase = HISTORY_UNUSED;
    h->steps = 0;
    return KQ_OK;
}

#define KQ_RECORDS_STEPS                                                                           \
    .attach = history_attach, .detach = history_detach, .predict = history_predict,                \
    .step = step_attached, .record_predict = history_record_predict,                               \
    .record_update = history_record_update, .record_nothing = history_record_nothing,              \
    .record_end = history_end, .is_recorder = RECORDS_BY_REFERENCE

#endif
