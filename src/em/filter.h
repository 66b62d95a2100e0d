/* The E-step's filter over a recording; and is the likelihood, then, what the M-step promised? */
#ifndef KQ_SRC_EM_FILTER_H
#define KQ_SRC_EM_FILTER_H

#include "expect.h"

static kq_status em_begin_recording(estimation *e, const em_places *w)
{
    copy(filter_root(&e->filter), w->of_P0, KQ_TRIANGLE(e->states));
    filter_begin(&e->filter, e->model->x0);
    return T(kq_attach)(&e->filter, &e->history.attached);
}

static kq_status em_predict(estimation *e, const recording *r)
{
    const size_t l = e->process.controls;
    const num *u = r->u && l ? r->u + (e->step - 1) * l : 0;
    return T(kq_predict)(&e->filter, &e->process, u);
}

/* A measurement that is not taken has a density that is infinite or 0. */
static kq_status em_update(estimation *e, const recording *r)
{
    const uint32_t present = present_at(e, r, e->step);
    if (!present) return KQ_OK;
    const num *z = r->z + e->step * e->components;
    const kq_status status = T(kq_update_subset)(&e->filter, &e->sensor, z, present);
    if (status) return status;
    return (int)e->filter.last.count == count_of(present) ? KQ_OK : KQ_ERR_LIKELIHOOD;
}

/* The unit of the log-likelihood's rounding: it falls by up to 1.2 of them where it cannot rise */
static num em_rounding(const estimation *e)
{
    num measurements = 0;
    for (size_t k = 0; k < e->count; k++) {
        measurements += (num)e->recordings[k].steps * (num)e->components;
    }
    return num_epsilon * (measurements + num_magnitude(e->log_likelihood));
}

/* All recordings are filtered: has the M-step made them likelier?  Then what it replaced is of no
   more use. */
static kq_status em_compare(estimation *e)
{
    const num rounding = em_rounding(e), gain = e->log_likelihood - e->before;
    e->gain = num_nan();
    if (!e->kept) return KQ_OK;
    if (!(gain >= -64 * rounding)) return KQ_ERR_LIKELIHOOD;
    e->gain = gain > rounding ? gain : rounding;
    e->kept = 0;
    return KQ_OK;
}

static kq_status em_end_filter(estimation *e)
{
    e->log_likelihood += likelihood_run_log(&e->filter.run);
    e->phase = EM_SMOOTHING;
    if (!num_is_finite(e->log_likelihood)) return KQ_ERR_LIKELIHOOD;
    return e->recording + 1 == e->count ? em_compare(e) : KQ_OK;
}

static kq_status em_filter(estimation *e)
{
    const em_places w = em_at(e);
    const recording *r = e->recordings + e->recording;
    kq_status status = e->step == 0 ? em_begin_recording(e, &w) : em_predict(e, r);
    if (!status) status = em_update(e, r);
    if (!status && e->history.phase != HISTORY_RECORDING) status = KQ_ERR_LIKELIHOOD; /* a state overflowed */
    if (status) return status;
    return ++e->step < r->steps ? KQ_OK : em_end_filter(e);
}

#endif
