/* What a steady filter tells in fixed point alone: its events, and what the rounding of a mean has left. */
#ifndef KQ_SRC_STEADY_TOLD_Q31_H
#define KQ_SRC_STEADY_TOLD_Q31_H

#include "../arithmetic/q31.h"
#include "steady.h"

num T(kq_steady_mean_low)(const steady *st, int i)
{
    return steady_has(st, i) ? mean_low(st->memory, st->states, i) : num_nan();
}

unsigned T(kq_steady_events)(const steady *st) { return st ? st->events : 0; }

void T(kq_steady_events_clear)(steady *st) { if (st) st->events = 0; }

#endif
