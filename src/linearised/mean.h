/* The mean of a filter, moved by others than its steps */
#ifndef KQ_SRC_LINEARISED_MEAN_H
#define KQ_SRC_LINEARISED_MEAN_H

#include "kalmanq/status.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/saturate.h"
#include "../arithmetic/mean.h"
#include "../model/types.h"
#include "../filter/attached.h"
#include "../filter/filter.h"

/* Has what is attached nothing to say of how the mean moves?  What is learnt from it, or moves it, has; a
   start of which nothing is unknown has not. */
static int mean_is_free(const filter *f)
{
    if (!f->attached) return 1;
    const hooks *with = f->attached->hooks;
    return with->is_recorder || (with->give && f->ready);
}

static kq_status free_mean_check(const filter *f)
{
    const kq_status status = filter_check(f);
    if (status) return status;
    return mean_is_free(f) ? KQ_OK : KQ_ERR_RECORDING;
}

/* x += d + low; low: NULL for none.  What is moved not representable is lost (arithmetic/saturate.h), and what is
   recorded ends. */
static void move_by(filter *f, const num *d, const num *low)
{
    num *x = f->memory;
    const int n = f->states;
    const unsigned events = mean_saturated(x, filter_root(f), n, mean_shift(x, n, d, low));
    filter_note(f, events);
    if ((events & KQ_EVENT_OVERFLOW) && f->attached) f->attached->hooks->record_end(f);
}

#endif
