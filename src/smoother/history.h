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
    *h = (history){.attached = {&history_hooks}, /* a filter that it still is attached to sees it by these */
                   .states = (uint8_t)n,
                   .length = length,
                   .memory = memory};
    return KQ_OK;
}

kq_status T(kq_history_attach)(history *h, filter *f)
{
    if (h && is_attached(f) && f->attached->hooks->give) return f->attached->hooks->give(f, h);
    return tape_attach(h, f, &history_hooks);
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

#endif
