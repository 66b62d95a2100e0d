/* The unknown start: predict and update, its beginning, and what is known on the way. */
#ifndef KQ_SRC_START_START_H
#define KQ_SRC_START_START_H

#include <stddef.h>
#include <stdint.h>

#include "kalmanq/filter.h"
#include "kalmanq/smoother.h"
#include "kalmanq/start.h"
#include "kalmanq/status.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/coordinates.h"
#include "../arithmetic/mean.h"
#include "../arithmetic/root.h"
#include "../arithmetic/scaled.h"
#include "../arithmetic/scores.h"
#include "../arithmetic/size.h"
#include "../model/sensor.h"
#include "../model/types.h"
#include "../model/units.h"
#include "../filter/checks.h"
#include "../filter/filter.h"
#include "../filter/likelihood.h"
#include "../filter/step.h"
#include "../filter/update.h"
#include "../filter/tape.h"
#include "columns.h"
#include "entries.h"
#include "past.h"
#include "rounding.h"
#include "take.h"
#include "unknown.h"

static kq_status start_check(const unknown_start *s)
{
    if (!s) return KQ_ERR_NULL;
    return s->phase == START_UNUSED ? KQ_ERR_NOT_READY : KQ_OK;
}

/* The filter is ready from here to start_close. */
static void start_open(unknown_start *s)
{
    filter_set_history(s->filter, 0);
    filter_set_ready(s->filter, s->ready);
}

static void start_close(unknown_start *s)
{
    s->ready = s->filter->ready;
    if (s->unknowns) filter_set_ready(s->filter, 0);
}

kq_status T(kq_start_predict)(unknown_start *s, const process *p, const num *u)
{
    kq_status status = start_check(s);
    if (status) return status;
    if (!start_is_open(s)) return T(kq_predict)(s->filter, p, u);
    filter known = *s->filter; /* as if it were ready */
    known.ready = FILTER_READY;
    status = predict_check(&known, p, u);
    if (status) return status;
    start_open(s);
    past_push(s);
    past_predict(s, p);
    predict_now(s->filter, p, u);
    unknown_advance(s, p);
    start_forget(s);
    if (s->unknowns == 0) start_end(s);
    start_close(s);
    return KQ_OK;
}

kq_status T(kq_start_update_subset)(unknown_start *s, const sensor *by, const num *z,
                                    uint32_t present)
{
    kq_status status = start_check(s);
    if (status) return status;
    filter *f = s->filter;
    if (!start_is_open(s)) return T(kq_update_subset)(f, by, z, present);
    filter known = *f; /* as if it were ready */
    known.ready = FILTER_READY;
    status = update_check(&known, by, z, present);
    if (status) return status;
    const reading now = {by, by->noise, z, present};
    start_open(s);
    likelihood_clear(&f->last);
    if (noise_is_of_others(by, present)) start_take_present(s, &now);
    else start_take(s, &now);
    settle(f, s->states);
    likelihood_run_add(&f->run, &f->last);
    start_close(s);
    return KQ_OK;
}

/* ------------------------------------------------------------------ init */

kq_status T(kq_start_assign)(unknown_start *s, int n, size_t early, num *memory, size_t length)
{
    if (!s || !memory) return KQ_ERR_NULL;
    if (!size_is_valid(n) || early >= UINT16_MAX) return KQ_ERR_SIZE;
    if (length < START_LEN((size_t)n, early)) return KQ_ERR_MEMORY;
    *s = (unknown_start){.states = (uint8_t)n, .early = (uint16_t)early, .memory = memory};
    return KQ_OK;
}

static kq_status start_check_memory(const unknown_start *s, const filter *f)
{
    if (!s || !f) return KQ_ERR_NULL;
    if (!size_is_valid(s->states)) return KQ_ERR_SIZE;
    if (!s->memory) return KQ_ERR_MEMORY;
    return f->states == s->states ? KQ_OK : KQ_ERR_MISMATCH;
}

/* The filter has been initialised by what is known. */
static void start_begin(unknown_start *s, filter *f, uint32_t unknown)
{
    const int n = s->states;
    const start_memory v = start_memory_of(s);
    static const scaled zero;
    s->filter = f;
    s->tape = 0;
    s->steps = 0;
    s->next = 0;
    s->phase = START_WAITING;
    s->unknowns = 0;
    s->ready = FILTER_READY;
    store_scaled(v.volume, scaled_one);
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            entry_set(unknown_row(v.unknown, n, i), j, zero);
            entry_set(rounding_row(v.rounding, n, i), j, zero);
        }
    }
    for (int i = 0; i < n; i++) {
        if (!(unknown >> i & 1)) continue;
        entry_set(unknown_row(v.unknown, n, i), s->unknowns++, physical_unit(f, i));
    }
    start_close(s);
}

kq_status T(kq_start_attach)(unknown_start *s, history *h)
{
    const kq_status status = start_check(s);
    if (status) return status;
    if (!h) return KQ_ERR_NULL;
    if (!size_is_valid(h->states)) return KQ_ERR_SIZE;
    if (!h->memory || h->length < (size_t)HISTORY_LEN(h->states, 1, 1, 0)) return KQ_ERR_MEMORY;
    filter *f = s->filter;
    const kq_status taken = history_check_owner(h, f);
    if (taken) return taken;
    const int open = start_is_open(s);
    if (open) start_open(s);
    history_begin(h, f);
    if (open) {
        filter_set_history(f, 0);
        h->steps = 0; /* the tape begins when the state is determined */
        start_close(s);
    }
    s->phase = START_WAITING;
    s->tape = h;
    s->steps = 0;
    s->next = 0;
    return KQ_OK;
}

kq_status T(kq_start_detach)(unknown_start *s)
{
    const kq_status status = start_check(s);
    if (status || !s->tape) return status;
    history *h = s->tape;
    s->tape = 0;
    return T(kq_history_detach)(h);
}

/* ------------------------------------------------------------------ what is known */

int T(kq_start_is_determined)(const unknown_start *s, int i)
{
    if (start_check(s) || i < 0 || i >= s->states) return 0;
    if (!start_is_open(s)) return s->filter->ready != 0;
    return unknown_is_zero(s, i);
}

int T(kq_start_count)(const unknown_start *s)
{
    if (start_check(s)) return -1;
    return start_is_open(s) ? s->unknowns : 0;
}

num T(kq_start_mean)(const unknown_start *s, int i)
{
    return T(kq_start_is_determined)(s, i) ? mean_get(s->filter->memory, s->states, i) : num_nan();
}

num T(kq_start_mean_low)(const unknown_start *s, int i)
{
    return T(kq_start_is_determined)(s, i) ? mean_low(s->filter->memory, s->states, i) : num_nan();
}

num T(kq_start_sigma)(const unknown_start *s, int i)
{
    if (!T(kq_start_is_determined)(s, i)) return num_nan();
    return word_of(scaled_root(root_product(filter_root(s->filter), s->states, i, i)));
}

static score start_log_likelihood(const unknown_start *s, int whole_run)
{
    if (start_check(s)) return not_a_score();
    return whole_run ? likelihood_run_log(&s->filter->run) : likelihood_log(&s->filter->last);
}

kq_status T(kq_start_update)(unknown_start *s, const sensor *by, const num *z)
{
    return T(kq_start_update_subset)(s, by, z, UINT32_MAX);
}

score T(kq_start_log_likelihood_last)(const unknown_start *s) { return start_log_likelihood(s, 0); }

score T(kq_start_log_likelihood)(const unknown_start *s) { return start_log_likelihood(s, 1); }

size_t T(kq_start_steps)(const unknown_start *s) { return start_check(s) ? 0 : (size_t)s->steps; }

size_t T(kq_start_first)(const unknown_start *s)
{
    return start_check(s) ? 0 : (size_t)start_first(s);
}

#endif
