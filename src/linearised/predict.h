/*
 * The predict of a nonlinear model, linearised by the caller: the mean goes where the caller says, the root goes the
 * linear way.  Nothing of the smoothers reads how a mean has moved, but for the filtered mean of each step:
 * x_s = x_f + S a.
 */
#ifndef KQ_SRC_LINEARISED_PREDICT_H
#define KQ_SRC_LINEARISED_PREDICT_H

#include "linearised.h"
#if KQ_FLOATING
#include "linearised_float.h"
#else
#include "linearised_q31.h"
#endif

/* What is attached and keeps all of the process of a linearised predict begins its hooks with this; predict:
   of one that has been checked. */
typedef struct {
    hooks steps;
    void (*predict)(filter *f, const process *p, const num *d);
} linearised_hooks;

/* ------------------------------------------------------------------ checks */

KQ_KERNEL kq_status move_check(const filter *f, const num *d)
{
    return d ? increment_check(d, f->states) : KQ_ERR_NULL;
}

/* Of what takes part in a predict: 0, or RECORDS_... */
KQ_KERNEL int recorder_of(const filter *f) { return f->attached ? f->attached->hooks->is_recorder : 0; }

/* A tape that refers to processes would have nothing of an A that is gone. */
kq_status T(kq_predict_check)(const filter *f, const process *p)
{
    kq_status status = free_mean_check(f);
    if (!status) status = jacobian_check(p, f);
    if (status) return status;
    return recorder_of(f) == RECORDS_BY_REFERENCE ? KQ_ERR_RECORDING : KQ_OK;
}

/* ------------------------------------------------------------------ predict */

/* P <- A P A' + Q.  One text for all sizes of scratch */
KQ_NOINLINE static extent advance_root(filter *f, const process *p, num *scratch)
{
    const int n = f->states;
    num *S = filter_root(f);
    return predict_root(S, S, p, scratch, scratch + n * ROW_LEN(n));
}

KQ_NOINLINE static extent advance_root_to_4(filter *f, const process *p)
{
    num scratch[PREDICT_SCRATCH(4)];
    return advance_root(f, p, scratch);
}

KQ_NOINLINE static extent advance_root_to_9(filter *f, const process *p)
{
    num scratch[PREDICT_SCRATCH(9)];
    return advance_root(f, p, scratch);
}

KQ_NOINLINE static extent advance_root_to_16(filter *f, const process *p)
{
    num scratch[PREDICT_SCRATCH(16)];
    return advance_root(f, p, scratch);
}

unsigned T(kq_predict_end)(filter *f, const num *d, extent of_root)
{
    const int n = f->states;
    const extent far = extent_join(of_root, mean_shift(f->memory, n, d, 0));
    renormalise(filter_root(f), n);
    const unsigned events = state_saturated(f->memory, filter_root(f), n, far);
    filter_note(f, events);
    predict_ends_low_noise(f);
    return events;
}

/* A predict that has been checked, of a filter that is not recorded or has been.  Answers the
   events. */
static unsigned predict_linearised(filter *f, const process *p, const num *d)
{
    if (f->states <= 4) return T(kq_predict_end)(f, d, advance_root_to_4(f, p));
    if (f->states <= 9) return T(kq_predict_end)(f, d, advance_root_to_9(f, p));
    return T(kq_predict_end)(f, d, advance_root_to_16(f, p));
}

/* The smoothers on line take the whole predict in the place of the filter's.  Where it leaves the mean is not
   what is wanted, and nobody looks at it. */
KQ_NOINLINE static kq_status predict_by_maps(filter *f, const process *p, const num *d)
{
    num aside[MEAN_PLANES * KQ_SIZE_MAX];
    const int words = MEAN_PLANES * f->states;
    kq_status status = jacobian_check_mean(p);
    if (status) return status;
    copy(aside, f->memory, words);
    status = f->attached->hooks->predict(f, p, 0);
    if (status) return status;
    copy(f->memory, aside, words);
    move_by(f, d, 0);
    return KQ_OK;
}

kq_status T(kq_predict_extended)(filter *f, const process *p, const num *d)
{
    process own;
    kq_status status = T(kq_predict_check)(f, p);
    if (!status) status = move_check(f, d);
    if (status) return status;
    const process *m = jacobian_process(p, &own);
    const int recorder = recorder_of(f);
    if (recorder == RECORDS_MAPS) return predict_by_maps(f, m, d);
    if (recorder) {
        ((const linearised_hooks *)f->attached->hooks)->predict(f, m, d);
    } else {
        if (f->attached) filter_set_attached(f, 0); /* a start that is over */
        (void)predict_linearised(f, m, d);
    }
    return KQ_OK;
}

kq_status T(kq_move)(filter *f, const num *d)
{
    kq_status status = free_mean_check(f);
    if (!status) status = move_check(f, d);
    if (!status) move_by(f, d, 0);
    return status;
}

#endif
