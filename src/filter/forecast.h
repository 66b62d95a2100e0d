/* A copy of a filter, and a look ahead on one. */
#ifndef KQ_SRC_FILTER_FORECAST_H
#define KQ_SRC_FILTER_FORECAST_H

#include <stddef.h>
#include <stdint.h>

#include "kalmanq/status.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/compiler.h"
#include "../arithmetic/root.h"
#include "../model/types.h"
#include "../model/units.h"
#include "checks.h"
#include "filter.h"
#include "step.h"

/* Has `to` room for the state of `from` beside it? */
static kq_status copy_check(const filter *to, const filter *from)
{
    if (!to) return KQ_ERR_NULL;
    if (filter_check_memory(to)) return KQ_ERR_MEMORY;
    if (to == from || to->memory == from->memory || to->states != from->states) {
        return KQ_ERR_MISMATCH;
    }
    return KQ_OK;
}

/* All but the memory, which is its own, and the history, which goes on by `from` alone */
static void copy_state(filter *to, const filter *from)
{
    const uint16_t length = to->length;
    num *memory = to->memory;
    *to = *from;
    to->length = length;
    to->memory = memory;
    filter_set_history(to, 0);
    copy(memory, from->memory, FILTER_LEN(from->states));
}

static kq_status filter_copy(filter *to, const filter *from)
{
    kq_status status = filter_check(from);
    if (!status) status = copy_check(to, from);
    if (!status) copy_state(to, from);
    return status;
}

KQ_COLD static kq_status filter_forecast(const filter *f, const process *p, const num *u, int steps,
                                 filter *ahead)
{
    const kq_status status = predict_check(f, p, 0);
    if (status) return status;
    const kq_status unfit = copy_check(ahead, f);
    if (unfit) return unfit;
    if (steps < 0) return KQ_ERR_SIZE;
    const size_t l = p->controls;
    for (int k = 0; u && k < steps; k++) {
        const kq_status wrong = process_check_controls(p, u + (size_t)k * l);
        if (wrong) return wrong;
    }
    copy_state(ahead, f);
    for (int k = 0; k < steps; k++) predict_now(ahead, p, u ? u + (size_t)k * l : 0);
    return KQ_OK;
}

#endif
