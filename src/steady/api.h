/* The public functions of steady states, those of the steady filter here. */
#ifndef KQ_SRC_STEADY_API_H
#define KQ_SRC_STEADY_API_H

#include "freeze.h"
#include "steady.h"
#if KQ_FLOATING
#include "riccati_float.h"
#else
#include "told_q31.h"
#endif

kq_status T(kq_steady_assign)(steady *st, int n, int m, num *memory, size_t length)
{
    if (!st || !memory) return KQ_ERR_NULL;
    if (!size_is_valid(n) || !size_is_valid(m)) return KQ_ERR_SIZE;
    if (length < (size_t)STEADY_LEN(n)) return KQ_ERR_MEMORY;
    *st = (steady){.states = (uint8_t)n,
                   .components = (uint8_t)m,
                   .length = (uint8_t)STEADY_LEN(n),
                   .memory = memory};
    return KQ_OK;
}

static kq_status steady_check_memory(const steady *st)
{
    if (!size_is_valid(st->states) || !size_is_valid(st->components)) return KQ_ERR_SIZE;
    return st->memory && st->length >= STEADY_LEN((unsigned)st->states) ? KQ_OK : KQ_ERR_MEMORY;
}

kq_status T(kq_steady_init)(steady *st, const process *p, const sensor *s, const num *x0,
                            const scaled *gains, size_t count)
{
    if (!st || !x0 || !gains) return KQ_ERR_NULL;
    kq_status status = steady_check_memory(st);
    if (!status) status = process_check(p);
    if (!status) status = sensor_check(s);
    if (status) return status;
    if (count < 1 || count > KQ_COUNT_MAX) return KQ_ERR_SIZE;
    const int n = st->states, m = st->components;
    if (p->states != n || s->states != n || s->components != m) return KQ_ERR_MISMATCH;
    if (!sensor_is_for(s, p) || takes_innovations(s)) return KQ_ERR_MISMATCH;
    status = mean_check(s, x0, n);
    for (size_t k = 0; k < count && !status; k++) {
        status = numbers_check(gains + k * (size_t)(n * m), n * m);
    }
    if (status) return status;
    for (int i = 0; i < n; i++) steady_set(st->memory, n, i, x0[i]);
    st->process = p;
    st->sensor = s;
    st->gain = gains;
    st->left = count - 1;
    st->events = 0;
    st->plain = (uint16_t)(count > 1 ? 0 : process_shape(p) | m << 8);
    return KQ_OK;
}

static kq_status steady_check(const steady *st, const num *u)
{
    if (!st) return KQ_ERR_NULL;
    if (!st->gain) return KQ_ERR_NOT_READY;
    return u ? process_check_controls(st->process, u) : KQ_OK;
}

static kq_status steady_check_measured(const steady *st, const num *z)
{
    const kq_status status = steady_check(st, 0);
    if (status) return status;
    if (!z) return KQ_ERR_NULL;
    return measured_check(st->sensor, z, st->components);
}

static const num *steady_controls(const steady *st, const num *u)
{
    return st->process->controls ? u : 0;
}

kq_status T(kq_steady_predict)(steady *st, const num *u)
{
    steady_word t[KQ_SIZE_MAX];
    const kq_status status = steady_check(st, u);
    if (status) return status;
    const int n = st->states;
    const num *drive = steady_controls(st, u);
    const unsigned events = steady_move(t, st->memory, st->process, drive, n, st->process->controls, SHAPE_AS_FOUND);
    if (moved_check(t, n)) return KQ_ERR_NOT_FINITE;
    steady_note(st, events);
    for (int i = 0; i < n; i++) steady_keep(st->memory, n, i, t[i]);
    return KQ_OK;
}

static void steady_state(steady_word *t, const steady *st)
{
    for (int i = 0; i < st->states; i++) t[i] = steady_whole(st->memory, st->states, i);
}

kq_status T(kq_steady_update)(steady *st, const num *z)
{
    steady_word t[KQ_SIZE_MAX];
    steady_number e[KQ_SIZE_MAX];
    const kq_status status = steady_check_measured(st, z);
    if (status) return status;
    const int n = st->states, m = st->components;
    steady_state(t, st);
    if (!steady_residuals(e, t, st->sensor, z, n, m)) return KQ_ERR_NOT_FINITE;
    steady_note(st, steady_correct(st->memory, t, st->gain, e, n, m));
    steady_next_gain(st);
    return KQ_OK;
}

kq_status T(kq_steady_step)(steady *st, const num *u, const num *z)
{
    kq_status status = steady_check(st, u);
    if (!status) status = steady_check_measured(st, z);
    if (status) return status;
    if (!steady_step_now(st, steady_controls(st, u), z, st->states, st->components,
                         st->process->controls, SHAPE_AS_FOUND)) {
        return KQ_ERR_NOT_FINITE;
    }
    steady_next_gain(st);
    return KQ_OK;
}

kq_status T(kq_steady_innovation)(const steady *st, const num *z, num *e)
{
    steady_word t[KQ_SIZE_MAX];
    steady_number found[KQ_SIZE_MAX];
    const kq_status status = steady_check_measured(st, z);
    if (status) return status;
    if (!e) return KQ_ERR_NULL;
    const int m = st->components;
    steady_state(t, st);
    if (!steady_residuals(found, t, st->sensor, z, st->states, m)) return KQ_ERR_NOT_FINITE;
    for (int c = 0; c < m; c++) e[c] = steady_word_of(found[c]);
    return KQ_OK;
}

num T(kq_steady_mean)(const steady *st, int i)
{
    return steady_has(st, i) ? steady_get(st->memory, st->states, i) : num_nan();
}

#endif
