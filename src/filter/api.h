/* The public functions of a filter: what moves it, looks ahead on it and copies it. */
#ifndef KQ_SRC_FILTER_API_H
#define KQ_SRC_FILTER_API_H

#include "copies.h"
#include "correlated.h"
#include "gain.h"
#include "independent.h"
#include "intact.h"
#include "lean.h"
#include "readings.h"
#include "step.h"
#if KQ_FLOATING
#include "init_float.h"
#else
#include "init_q31.h"
#endif

/* The kinds of sensor */
const sensor_kind T(kq_sensor_independent) = {.take = take_independent, .watch = watch_independent, .plain = 1};
const sensor_kind T(kq_sensor_lean) = {.take = take_lean};
const sensor_kind T(kq_sensor_correlated) = {.take = take_correlated_reading,
                                       .row = correlated_row,
                                       .row_sizes = correlated_row_sizes,
                                       .innovation = correlated_innovation};

KQ_COLD kq_status T(kq_filter_assign)(filter *f, int n, num *memory, size_t length)
{
    if (!f || !memory) return KQ_ERR_NULL;
    if (!size_is_valid(n)) return KQ_ERR_SIZE;
    if (length < (size_t)FILTER_LEN(n)) return KQ_ERR_MEMORY;
    *f = (filter){.states = (uint8_t)n, .memory = memory};
    return KQ_OK;
}

kq_status T(kq_predict)(filter *f, const process *p, const num *u)
{
    if (is_attached(f)) return f->attached->hooks->predict(f, p, u);
    return predict_plain(f, p, u);
}

/* Does what is attached take its updates? */
KQ_INLINE int has_updates(const filter *f) { return is_attached(f) && f->attached->hooks->update; }

kq_status T(kq_update)(filter *f, const sensor *s, const num *z)
{
    if (has_updates(f)) return f->attached->hooks->update(f, s, z, UINT32_MAX);
    const kq_status status = update_check(f, s, z, UINT32_MAX);
    return status ? status : s->kind->take(f, s, z, UINT32_MAX);
}

kq_status T(kq_update_subset)(filter *f, const sensor *s, const num *z, uint32_t present)
{
    if (has_updates(f)) return f->attached->hooks->update(f, s, z, present);
    return update_present(f, s, z, present);
}

kq_status T(kq_step)(filter *f, const process *p, const num *u, const sensor *s, const num *z)
{
    if (is_attached(f)) return f->attached->hooks->step(f, p, u, s, z);
    kq_status status = predict_check(f, p, u);
    if (status) return status;
    status = update_check(f, s, z, UINT32_MAX);
    if (status) return status;
    (void)predict_now(f, p, u);
    return s->kind->take(f, s, z, UINT32_MAX);
}

KQ_COLD kq_status T(kq_gain)(const filter *f, const sensor *s, scaled *K)
{
    const kq_status status = sensor_check_reading(f, s);
    if (status) return status;
    if (!K) return KQ_ERR_NULL;
    if (noise_is_of_others(s, UINT32_MAX)) gain_of_some(f, s, K);
    else gain_with(f, &(reading){s, s->noise, 0, UINT32_MAX}, K);
    return KQ_OK;
}

KQ_COLD kq_status T(kq_forecast)(const filter *f, const process *p, const num *u, size_t steps,
                                 filter *ahead)
{
    kq_status status = state_check_known(f);
    if (!status) status = process_check_fit(f, p);
    if (!status) status = copy_check(ahead, f);
    if (status) return status;
    if (steps > KQ_COUNT_MAX) return KQ_ERR_SIZE;
    const size_t l = p->controls;
    for (size_t k = 0; u && k < steps; k++) {
        const kq_status wrong = process_check_controls(p, u + k * l);
        if (wrong) return wrong;
    }
    copy_state(ahead, f);
    for (size_t k = 0; k < steps; k++) predict_now(ahead, p, u ? u + k * l : 0);
    return KQ_OK;
}

kq_status T(kq_filter_copy)(filter *to, const filter *from)
{
    kq_status status = state_check_known(from);
    if (!status) status = copy_check(to, from);
    if (!status) copy_state(to, from);
    return status;
}

kq_status T(kq_attach)(filter *f, attached *object)
{
    if (!f || !object) return KQ_ERR_NULL;
    if (!object->hooks || !object->hooks->attach) return KQ_ERR_NOT_READY;
    return object->hooks->attach(f, object);
}

kq_status T(kq_detach)(attached *object)
{
    if (!object) return KQ_ERR_NULL;
    if (!object->hooks || !object->hooks->detach) return KQ_ERR_NOT_READY;
    return object->hooks->detach(object);
}

#endif
