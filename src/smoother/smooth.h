/* The public functions of the fixed-interval smoother, and what can be read of what it has smoothed. */
#ifndef KQ_SRC_SMOOTHER_SMOOTH_H
#define KQ_SRC_SMOOTHER_SMOOTH_H

#include <stddef.h>

#include "kalmanq/smoother.h"
#include "kalmanq/status.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/compiler.h"
#include "../arithmetic/coordinates.h"
#include "../arithmetic/mean.h"
#include "../arithmetic/root.h"
#include "../arithmetic/scaled.h"
#include "../model/types.h"
#include "smoother.h"
#include "tape.h"

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

/* Smoothed step t, or NULL where there is no component i of it */
KQ_SHARED const num *smoothed_at(const history *h, size_t t, int i)
{
    if (!smoothed_is_valid(h, t) || i < 0 || i >= h->states) return 0;
    return history_slot(h, h->states, t);
}

num T(kq_smoothed_mean)(const history *h, size_t t, int i)
{
    const num *state = smoothed_at(h, t, i);
    return state ? mean_get(state, h->states, i) : num_nan();
}

num T(kq_smoothed_mean_low)(const history *h, size_t t, int i)
{
    const num *state = smoothed_at(h, t, i);
    return state ? mean_low(state, h->states, i) : num_nan();
}

num T(kq_smoothed_sigma)(const history *h, size_t t, int i)
{
    const num *state = smoothed_at(h, t, i);
    if (!state || h->phase == HISTORY_STATES) return num_nan();
    return word_of(scaled_root(root_product(state + MEAN_PLANES * h->states, h->states, i, i)));
}

kq_status T(kq_smoothed_covariance)(const history *h, size_t t, scaled *P)
{
    if (!h || !P) return KQ_ERR_NULL;
    if (t >= h->steps) return KQ_ERR_SIZE;
    if (!smoothed_is_valid(h, t) || h->phase == HISTORY_STATES) return KQ_ERR_NOT_READY;
    root_square(P, history_slot(h, h->states, t) + MEAN_PLANES * h->states, h->states);
    return KQ_OK;
}

#endif
