/* The public functions of a history: what is recorded for the smoother. */
#ifndef KQ_SRC_SMOOTHER_HISTORY_H
#define KQ_SRC_SMOOTHER_HISTORY_H

#include <stddef.h>
#include <stdint.h>

#include "kalmanq/smoother.h"
#include "kalmanq/status.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/compiler.h"
#include "../arithmetic/size.h"
#include "../model/types.h"
#include "../filter/attached.h"
#include "../filter/filter.h"
#include "tape.h"

KQ_COLD kq_status T(kq_history_assign)(history *h, int n, num *memory, size_t length)
{
    if (!h || !memory) return KQ_ERR_NULL;
    if (!size_is_valid(n)) return KQ_ERR_SIZE;
    if (length < history_least_length(n)) return KQ_ERR_MEMORY;
    *h = (history){.states = (uint8_t)n, .length = length, .memory = memory};
    return KQ_OK;
}

KQ_COLD kq_status T(kq_history_attach)(history *h, filter *f)
{
    if (!h) return KQ_ERR_NULL;
    if (is_attached(f) && f->attached->hooks->give) return f->attached->hooks->give(f, h);
    kq_status status = filter_check(f);
    if (status) return status;
    if (!size_is_valid(h->states)) return KQ_ERR_SIZE;
    if (!h->memory || h->length < history_least_length(h->states)) return KQ_ERR_MEMORY;
    status = history_check_owner(h, f);
    if (status) return status;
    if (f->attached && !is_recorded(f)) return KQ_ERR_RECORDING;
    history_begin(h, f);
    return KQ_OK;
}

/* What has been smoothed stays to be read. */
kq_status T(kq_history_detach)(history *h)
{
    if (!h) return KQ_ERR_NULL;
    filter *f = h->filter;
    if (is_attached(f) && f->attached->hooks->lose) f->attached->hooks->lose(f, h);
    if (f && f->attached == &h->attached) filter_set_attached(f, 0);
    h->filter = 0;
    if (h->phase == HISTORY_SMOOTHING || h->phase == HISTORY_STATES) return KQ_OK;
    h->phase = HISTORY_UNUSED;
    h->steps = 0;
    return KQ_OK;
}

size_t T(kq_history_steps)(const history *h) { return h ? (size_t)h->steps : 0; }

unsigned T(kq_history_events)(const history *h) { return h ? h->events : 0; }

#endif
