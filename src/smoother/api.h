/* The public functions of smoothers, those of a history here. */
#ifndef KQ_SRC_SMOOTHER_API_H
#define KQ_SRC_SMOOTHER_API_H

#include "delayed.h"
#include "instant.h"
#include "lag.h"
#include "smoother.h"

const hooks T(kq_history_hooks) = {KQ_RECORDS_STEPS};

KQ_COLD kq_status T(kq_history_assign)(history *h, int n, num *memory, size_t length)
{
    if (!h || !memory) return KQ_ERR_NULL;
    if (!size_is_valid(n)) return KQ_ERR_SIZE;
    if (length < history_least_length(n)) return KQ_ERR_MEMORY;
    *h = (history){.attached = {&T(kq_history_hooks)}, /* a filter that it still is attached to sees it by these */
                   .states = (uint8_t)n,
                   .length = length,
                   .memory = memory};
    return KQ_OK;
}

size_t T(kq_history_steps)(const history *h) { return h ? (size_t)h->steps : 0; }

kq_status T(kq_smooth)(history *h)
{
    return smooth_all(h, undo_mean_and_root, HISTORY_SMOOTHING);
}

kq_status T(kq_smooth_states)(history *h) { return smooth_all(h, undo_mean, HISTORY_STATES); }

kq_status T(kq_smooth_step)(history *h, const process *p, const smooth_extras *extras)
{
    kq_status status = smooth_check(h, 1);
    if (!status && p) status = smooth_check_process(h, p);
    if (status) return status;
    if (!p && h->phase == HISTORY_SMOOTHING && !history_knows_process(h)) return KQ_ERR_CHANGED;
    smooth_one(h, p, extras ? undo_with_extras : undo_mean_and_root, extras, HISTORY_SMOOTHING);
    return KQ_OK;
}

kq_status T(kq_smoothed_measurement_noise)(const history *h, int k, scaled *mean, scaled *variance)
{
    if (!h || !mean || !variance) return KQ_ERR_NULL;
    if (h->phase != HISTORY_SMOOTHING) return KQ_ERR_HISTORY_EMPTY;
    if (k < 0 || (unsigned)k >= h->records) return KQ_ERR_SIZE;
    const num *record =
        history_tape(h, h->states) + h->used + (size_t)k * UPDATE_RECORD_LEN(h->states);
    load_noise(record, mean, variance);
    return KQ_OK;
}

kq_status T(kq_smoothed)(const history *h, size_t t, filter *view)
{
    if (!view) return KQ_ERR_NULL;
    if (!h) return view_nothing(view, KQ_ERR_NULL);
    if (t >= h->steps) return view_nothing(view, KQ_ERR_SIZE);
    if (!smoothed_is_valid(h, t)) return view_nothing(view, KQ_ERR_NOT_READY);
    const int what = h->phase == HISTORY_STATES ? VIEW_OF_MEAN : VIEW_OF_STATE;
    view_state(view, history_slot(h, h->states, t), h->states, what, h->events);
    view_take_formats(view, h);
    return KQ_OK;
}

#endif
