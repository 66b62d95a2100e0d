/* The diffuse start: predict and update, its beginning, and what is known on the way. */
#ifndef KQ_SRC_DIFFUSE_DIFFUSE_H
#define KQ_SRC_DIFFUSE_DIFFUSE_H

#include "take.h"

static kq_status diffuse_check(const start *s)
{
    if (!s) return KQ_ERR_NULL;
    return s->phase == DIFFUSE_UNUSED ? KQ_ERR_NOT_READY : KQ_OK;
}

/* The filter is ready, and the start not attached, from here to diffuse_close. */
static void diffuse_open(start *s)
{
    filter_set_attached(s->filter, 0);
    filter_set_ready(s->filter, s->ready);
}

static void diffuse_close(start *s)
{
    filter *f = s->filter;
    s->ready = f->ready;
    f->known = known_states(s);
    f->seal = 0;
    if (!s->unknowns) return;
    filter_set_ready(f, 0);
    filter_set_attached(f, &s->attached);
}

/* The start that is attached to f, or NULL: then f is a copy of its filter. */
static start *diffuse_of(const filter *f)
{
    start *s = (start *)f->attached;
    return s->filter == f ? s : 0;
}

/* Where nothing was unknown f is ready from the beginning, and its start attached up to its first step,
   which has been taken without it. */
static kq_status diffuse_hands_over(filter *f, kq_status status)
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

static kq_status diffuse_predict(filter *f, const process *p, const num *u)
{
    if (f->ready) return diffuse_hands_over(f, predict_alone(f, p, u));
    start *s = diffuse_of(f);
    if (!s) return KQ_ERR_NOT_READY;
    const filter known = filter_known(f);
    const kq_status status = predict_check(&known, p, u);
    if (status) return status;
    diffuse_open(s);
    past_push(s);
    past_predict(s, p);
    (void)predict_now(f, p, u);
    unknown_advance(s, p);
    diffuse_forget(s);
    if (s->unknowns == 0) diffuse_end(s);
    diffuse_close(s);
    return KQ_OK;
}

static kq_status diffuse_update(filter *f, const sensor *by, const num *z, uint32_t present)
{
    if (f->ready) return diffuse_hands_over(f, update_alone(f, by, z, present));
    start *s = diffuse_of(f);
    if (!s) return KQ_ERR_NOT_READY;
    const filter known = filter_known(f);
    kq_status status = update_check(&known, by, z, present);
    if (!status) status = takes_measurements(by, KQ_ERR_NOT_READY);
    if (status) return status;
    const reading now = {by, by->noise, z, present};
    diffuse_open(s);
    likelihood_clear(&f->last);
    if (noise_is_of_others(by, present)) diffuse_take_present(s, &now);
    else diffuse_take(s, &now);
    if (s->unknowns == 0) likelihood_to_units(s, &f->last);
    settle(f, s->states);
    likelihood_run_add(&f->run, &f->last);
    diffuse_close(s);
    return KQ_OK;
}

static kq_status diffuse_step(filter *f, const process *p, const num *u, const sensor *by, const num *z)
{
    const filter known = filter_known(f);
    kq_status status = step_check(&known, p, u, by, z);
    if (!status && !f->ready) status = takes_measurements(by, KQ_ERR_NOT_READY);
    if (!status) status = diffuse_predict(f, p, u);
    return status ? status : T(kq_update)(f, by, z);
}

/* The history records from the instant on where all is known, the start what comes before it. */
static kq_status diffuse_give(filter *f, history *h)
{
    start *s = diffuse_of(f);
    if (!s) return KQ_ERR_NOT_READY;
    if (!size_is_valid(h->states)) return KQ_ERR_SIZE;
    if (!h->memory || h->length < (size_t)HISTORY_LEN(h->states, 1, 1, 0)) return KQ_ERR_MEMORY;
    const kq_status taken = history_check_owner(h, f);
    if (taken) return taken;
    diffuse_open(s);
    s->tape = h;
    diffuse_begin_tape(s);
    if (s->unknowns) h->steps = 0;
    diffuse_close(s);
    s->phase = DIFFUSE_WAITING;
    s->steps = 0;
    s->next = 0;
    return KQ_OK;
}

static void diffuse_lose(filter *f, const history *h)
{
    start *s = diffuse_of(f);
    if (s && s->tape == h) s->tape = 0;
}

static const hooks diffuse_hooks = {.predict = diffuse_predict,
                                  .update = diffuse_update,
                                  .step = diffuse_step,
                                  .give = diffuse_give,
                                  .lose = diffuse_lose,
                                  KQ_RECORDS_NOTHING};

/* ------------------------------------------------------------------ init */

kq_status T(kq_diffuse_assign)(start *s, int n, size_t early, num *memory, size_t length)
{
    if (!s || !memory) return KQ_ERR_NULL;
    if (!size_is_valid(n) || early >= UINT16_MAX) return KQ_ERR_SIZE;
    if (length < DIFFUSE_LEN((size_t)n, early)) return KQ_ERR_MEMORY;
    *s = (start){.attached = {&diffuse_hooks},
                 .states = (uint8_t)n,
                 .early = (uint16_t)early,
                 .memory = memory};
    return KQ_OK;
}

static kq_status diffuse_check_memory(const start *s, const filter *f)
{
    if (!s || !f) return KQ_ERR_NULL;
    if (!size_is_valid(s->states)) return KQ_ERR_SIZE;
    if (!s->memory) return KQ_ERR_MEMORY;
    return f->states == s->states ? KQ_OK : KQ_ERR_MISMATCH;
}

/* The filter has been initialised by what is known. */
static void diffuse_begin(start *s, filter *f, uint32_t unknown)
{
    const int n = s->states;
    const diffuse_memory v = diffuse_memory_of(s);
    const scaled zero = scaled_zero();
    s->attached.hooks = &diffuse_hooks;
    s->filter = f;
    s->tape = 0;
    s->steps = 0;
    s->next = 0;
    s->phase = DIFFUSE_WAITING;
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
    diffuse_close(s);
}

/* ------------------------------------------------------------------ what is known */

int T(kq_diffuse_count)(const start *s)
{
    if (diffuse_check(s)) return -1;
    return diffuse_is_open(s) ? s->unknowns : 0;
}

size_t T(kq_diffuse_steps)(const start *s, size_t *first)
{
    const int is_bad = diffuse_check(s) != KQ_OK;
    if (first) *first = is_bad ? 0 : (size_t)diffuse_first(s);
    return is_bad ? 0 : (size_t)s->steps;
}

#endif
