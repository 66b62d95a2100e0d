/* The unknown start: predict and update, its beginning, and what is known on the way. */
#ifndef KQ_SRC_START_START_H
#define KQ_SRC_START_START_H

#include <stddef.h>
#include <stdint.h>

#include "kalmanq/filter.h"
#include "kalmanq/start.h"
#include "kalmanq/status.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/coordinates.h"
#include "../arithmetic/scaled.h"
#include "../arithmetic/size.h"
#include "../model/sensor.h"
#include "../model/types.h"
#include "../model/units.h"
#include "../filter/alone.h"
#include "../filter/attached.h"
#include "../filter/checks.h"
#include "../filter/filter.h"
#include "../filter/likelihood.h"
#include "../filter/step.h"
#include "../filter/update.h"
#include "../smoother/tape.h"
#include "columns.h"
#include "entries.h"
#include "past.h"
#include "ranges.h"
#include "rounding.h"
#include "take.h"
#include "unknown.h"

static kq_status start_check(const start *s)
{
    if (!s) return KQ_ERR_NULL;
    return s->phase == START_UNUSED ? KQ_ERR_NOT_READY : KQ_OK;
}

/* The filter is ready, and the start not attached, from here to start_close. */
static void start_open(start *s)
{
    filter_set_attached(s->filter, 0);
    filter_set_ready(s->filter, s->ready);
}

static void start_close(start *s)
{
    filter *f = s->filter;
    s->ready = f->ready;
    f->known = 0;
    for (int i = 0; i < s->states; i++) {
        if (unknown_is_zero(s, i)) f->known = (uint16_t)(f->known | UINT32_C(1) << i);
    }
    f->seal = 0;
    if (!s->unknowns) return;
    filter_set_ready(f, 0);
    filter_set_attached(f, &s->attached);
}

/* The start that is attached to f, or NULL: then f is a copy of its filter. */
static start *start_of(const filter *f)
{
    start *s = (start *)f->attached;
    return s->filter == f ? s : 0;
}

/* Where nothing was unknown f is ready from the beginning, and its start attached up to its first step,
   which has been taken without it. */
static kq_status start_hands_over(filter *f, kq_status status)
{
    if (!status) filter_set_attached(f, 0);
    return status;
}

/* As if it were ready: what a step is checked against */
static filter filter_known(const filter *f)
{
    filter known = *f;
    known.ready = FILTER_READY;
    known.attached = 0;
    return known;
}

static kq_status start_predict(filter *f, const process *p, const num *u)
{
    if (f->ready) return start_hands_over(f, predict_alone(f, p, u));
    start *s = start_of(f);
    if (!s) return KQ_ERR_NOT_READY;
    const filter known = filter_known(f);
    const kq_status status = predict_check(&known, p, u);
    if (status) return status;
    start_open(s);
    past_push(s);
    past_predict(s, p);
    predict_now(f, p, u);
    unknown_advance(s, p);
    start_forget(s);
    if (s->unknowns == 0) start_end(s);
    start_close(s);
    return KQ_OK;
}

static kq_status start_update(filter *f, const sensor *by, const num *z, uint32_t present)
{
    if (f->ready) return start_hands_over(f, update_alone(f, by, z, present));
    start *s = start_of(f);
    if (!s) return KQ_ERR_NOT_READY;
    const filter known = filter_known(f);
    kq_status status = update_check(&known, by, z, present);
    if (!status) status = takes_measurements(by, KQ_ERR_NOT_READY);
    if (status) return status;
    const reading now = {by, by->noise, z, present};
    start_open(s);
    likelihood_clear(&f->last);
    if (noise_is_of_others(by, present)) start_take_present(s, &now);
    else start_take(s, &now);
    if (s->unknowns == 0) likelihood_to_units(s, &f->last);
    settle(f, s->states);
    likelihood_run_add(&f->run, &f->last);
    start_close(s);
    return KQ_OK;
}

static kq_status start_step(filter *f, const process *p, const num *u, const sensor *by, const num *z)
{
    const filter known = filter_known(f);
    kq_status status = step_check(&known, p, u, by, z);
    if (!status && !f->ready) status = takes_measurements(by, KQ_ERR_NOT_READY);
    if (!status) status = start_predict(f, p, u);
    return status ? status : T(kq_update)(f, by, z);
}

/* The history records from the instant on where all is known, the start what comes before it. */
static kq_status start_give(filter *f, history *h)
{
    start *s = start_of(f);
    if (!s) return KQ_ERR_NOT_READY;
    if (!size_is_valid(h->states)) return KQ_ERR_SIZE;
    if (!h->memory || h->length < (size_t)HISTORY_LEN(h->states, 1, 1, 0)) return KQ_ERR_MEMORY;
    const kq_status taken = history_check_owner(h, f);
    if (taken) return taken;
    start_open(s);
    s->tape = h;
    start_begin_tape(s);
    if (s->unknowns) h->steps = 0;
    start_close(s);
    s->phase = START_WAITING;
    s->steps = 0;
    s->next = 0;
    return KQ_OK;
}

static void start_lose(filter *f, const history *h)
{
    start *s = start_of(f);
    if (s && s->tape == h) s->tape = 0;
}

static const hooks start_hooks = {.predict = start_predict,
                                  .update = start_update,
                                  .step = start_step,
                                  .give = start_give,
                                  .lose = start_lose,
                                  KQ_RECORDS_NOTHING};

/* ------------------------------------------------------------------ init */

kq_status T(kq_start_assign)(start *s, int n, size_t early, num *memory, size_t length)
{
    if (!s || !memory) return KQ_ERR_NULL;
    if (!size_is_valid(n) || early >= UINT16_MAX) return KQ_ERR_SIZE;
    if (length < START_LEN((size_t)n, early)) return KQ_ERR_MEMORY;
    *s = (start){.attached = {&start_hooks},
                 .states = (uint8_t)n,
                 .early = (uint16_t)early,
                 .memory = memory};
    return KQ_OK;
}

static kq_status start_check_memory(const start *s, const filter *f)
{
    if (!s || !f) return KQ_ERR_NULL;
    if (!size_is_valid(s->states)) return KQ_ERR_SIZE;
    if (!s->memory) return KQ_ERR_MEMORY;
    return f->states == s->states ? KQ_OK : KQ_ERR_MISMATCH;
}

/* The filter has been initialised by what is known. */
static void start_begin(start *s, filter *f, uint32_t unknown)
{
    const int n = s->states;
    const start_memory v = start_memory_of(s);
    static const scaled zero;
    s->attached.hooks = &start_hooks;
    s->filter = f;
    s->tape = 0;
    s->steps = 0;
    s->next = 0;
    s->phase = START_WAITING;
    s->unknowns = 0;
    s->ready = FILTER_READY;
    store_scaled(v.volume, scaled_one);
    ranges_clear(s);
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            entry_set(unknown_row(v.unknown, n, i), j, zero);
            entry_set(rounding_row(v.rounding, n, i), j, zero);
        }
    }
    for (int i = 0; i < n; i++) {
        if (!(unknown >> i & 1)) continue;
        entry_set(unknown_row(v.unknown, n, i), s->unknowns++, unknown_unit(s, f, i));
    }
    filter_set_attached(f, &s->attached);
    start_close(s);
}

/* ------------------------------------------------------------------ what is known */

int T(kq_start_is_determined)(const start *s, int i)
{
    return !start_check(s) && index_is_valid(s->filter, i);
}

int T(kq_start_count)(const start *s)
{
    if (start_check(s)) return -1;
    return start_is_open(s) ? s->unknowns : 0;
}

size_t T(kq_start_steps)(const start *s) { return start_check(s) ? 0 : (size_t)s->steps; }

size_t T(kq_start_first)(const start *s)
{
    return start_check(s) ? 0 : (size_t)start_first(s);
}

#endif
