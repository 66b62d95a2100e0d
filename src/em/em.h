/* EM: the object, the E-step in slices, the M-step. */
#ifndef KQ_SRC_EM_EM_H
#define KQ_SRC_EM_EM_H

#include "filter.h"
#include "maximise.h"

typedef T(kq_gradient) gradient;

static kq_status em_check_sizes(const estimation *e)
{
    if (!size_is_valid(e->states) || !size_is_valid(e->components)) return KQ_ERR_SIZE;
    if (!e->memory || e->length < (size_t)EM_LEN(e->states, e->components, 1)) return KQ_ERR_MEMORY;
    return KQ_OK;
}

kq_status T(kq_em_assign)(estimation *e, int n, int m, num *memory, size_t length)
{
    if (!e || !memory) return KQ_ERR_NULL;
    if (!size_is_valid(n) || !size_is_valid(m)) return KQ_ERR_SIZE;
    if (length < (size_t)EM_LEN(n, m, 1)) return KQ_ERR_MEMORY;
    *e = (estimation){
        .states = (uint8_t)n, .components = (uint8_t)m, .length = length, .memory = memory};
    return KQ_OK;
}

/* ------------------------------------------------------------------ init */

static kq_status em_check_recordings(const estimation *e, const parameters *p,
                                     const kq_em_choice *choice, const recording *r, size_t count)
{
    uint32_t measurements = 0, steps = 0;
    if (count < 1 || count > KQ_COUNT_MAX) return KQ_ERR_SIZE;
    for (size_t k = 0; k < count; k++) {
        const kq_status status = recording_check(e, r + k, (int)p->controls, &measurements);
        if (status) return status;
        steps += (uint32_t)r[k].steps;
        if (steps > INT32_MAX) return KQ_ERR_SIZE;
    }
    if (measurements == 0) return KQ_ERR_NO_DATA;
    const int noises = p->F ? (int)p->noises : e->states;
    return measurements < em_count_free(e, choice, noises) ? KQ_ERR_FEW_DATA : KQ_OK;
}

kq_status T(kq_em_init)(estimation *e, const parameters *p, const kq_em_choice *choice,
                        const recording *r, size_t count)
{
    if (!e || !p || !r) return KQ_ERR_NULL;
    kq_status status = em_check_sizes(e);
    if (status) return status;
    estimation now = {.states = e->states,
                      .components = e->components,
                      .length = e->length,
                      .memory = e->memory,
                      .model = p,
                      .choice = choice,
                      .recordings = r};
    const kq_em_choice *chosen = em_choice(&now);
    status = em_check_choice(chosen);
    if (!status) status = em_check_model(&now, p, chosen);
    if (!status) status = em_check_recordings(&now, p, chosen, r, count);
    if (status) return status;
    now.count = count;
    now.phase = EM_READY;
    now.log_likelihood = num_nan();
    now.gain = num_nan();
    now.change = num_nan();
    now.rate = num_nan();
    *e = now;
    return em_has_no_unit(e, p, chosen) ? KQ_NOT_IDENTIFIED : KQ_OK;
}

static kq_status em_check(const estimation *e)
{
    if (!e) return KQ_ERR_NULL;
    return e->phase == EM_UNUSED ? KQ_ERR_NOT_READY : KQ_OK;
}

/* ------------------------------------------------------------------ E-step */

static kq_status em_begin(estimation *e)
{
    const em_places w = em_at(e);
    kq_status status = em_check_model(e, e->model, em_choice(e));
    if (!status) status = em_prepare(e, &w, e->model);
    if (status) return status;
    for (int which = 0; which < EM_SUMS; which++) {
        sums_clear(w.sums[which], em_rows(e, which));
        if (which < EM_START) sums_clear(w.blocks[which], em_rows(e, which));
    }
    e->log_likelihood = 0;
    e->recording = 0;
    e->step = 0;
    e->remaining = 0;
    for (size_t k = 0; k < e->count; k++) e->remaining += 2 * (uint32_t)e->recordings[k].steps;
    e->phase = EM_FILTERING;
    return KQ_OK;
}

static void em_give_up(estimation *e, num log_likelihood)
{
    e->phase = EM_READY;
    e->remaining = 0;
    e->log_likelihood = log_likelihood;
    e->gain = num_nan();
}

/* What the M-step made is worse than what it replaced, which is put back. */
static void em_take_back(estimation *e)
{
    em_give_up(e, e->kept ? e->before : num_nan());
    em_exchange(e, e->kept);
    e->kept = 0;
}

kq_status T(kq_em_advance)(estimation *e)
{
    kq_status status = em_check(e);
    if (status) return status;
    if (!em_is_expecting(e)) status = em_begin(e);
    if (status) {
        em_give_up(e, num_nan());
        return status;
    }
    status = e->phase == EM_SMOOTHING ? em_smooth(e) : em_filter(e);
    if (status) em_take_back(e);
    else if (--e->remaining == 0) e->phase = EM_EXPECTED;
    return status;
}

num T(kq_em_log_likelihood)(const estimation *e)
{
    if (!e || e->phase == EM_UNUSED || em_is_expecting(e)) return num_nan();
    return e->log_likelihood;
}

/* ------------------------------------------------------------------ M-step */

kq_status T(kq_em_maximise)(estimation *e)
{
    kq_status status = em_check(e);
    if (status) return status;
    if (e->phase != EM_EXPECTED) return KQ_ERR_NOT_READY;
    const em_places w = em_at(e);
    const num before = e->change;
    e->change = 0;
    for (int which = 0; which < EM_SUMS && !status; which++) {
        status = em_maximise_part(e, &w, which);
        if (!status) status = em_check_spread(e, &w, which);
    }
    if (status) {
        e->change = before;
        return status;
    }
    e->kept = (uint8_t)em_choice(e)->free;
    em_exchange(e, e->kept);
    e->before = e->log_likelihood;
    e->rate = (e->change + 16 * num_epsilon) / before; /* rounded up */
    e->phase = EM_READY;
    return KQ_OK;
}

kq_status T(kq_em_iterate)(estimation *e)
{
    kq_status status;
    do status = T(kq_em_advance)(e);
    while (!status && e->remaining);
    return status ? status : T(kq_em_maximise)(e);
}

num T(kq_em_change)(const estimation *e)
{
    return e && e->phase != EM_UNUSED ? e->change : num_nan();
}

/* The gains go with the squares of the changes.  If these shrink by `rate` an M-step, gain rate^2 /
   (1 - rate^2) is left; if they vanish as 1 / k, twice that.  With 1 - rate below it is the latter,
   and not less than the former. */
num T(kq_em_distance)(const estimation *e)
{
    if (!e || e->phase == EM_UNUSED || em_is_expecting(e)) return num_nan();
    return e->rate < 1 ? e->gain * e->rate * e->rate / (1 - e->rate) : num_nan();
}

/* ------------------------------------------------------------------ gradient */

kq_status T(kq_em_gradient)(const estimation *e, const gradient *g)
{
    const kq_status status = em_check(e);
    if (status) return status;
    if (!g) return KQ_ERR_NULL;
    if (e->phase != EM_EXPECTED) return KQ_ERR_NOT_READY;
    if (g->A && !em_is_free(e, KQ_EM_A)) return KQ_ERR_NOT_READY;
    if (g->H && !em_is_free(e, KQ_EM_H)) return KQ_ERR_NOT_READY;
    if (g->x0 && !em_is_free(e, KQ_EM_X0)) return KQ_ERR_NOT_READY;
    const em_places w = em_at(e);
    em_part_gradient(e, &w, EM_PROCESS, g->A, g->Q);
    em_part_gradient(e, &w, EM_SENSOR, g->H, g->R);
    em_part_gradient(e, &w, EM_START, g->x0, g->P0);
    return KQ_OK;
}

uint32_t T(kq_em_remaining)(const estimation *em) { return em ? em->remaining : 0; }

#endif
