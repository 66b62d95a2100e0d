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
#include "recorder.h"
#include "tape.h"

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

#endif
