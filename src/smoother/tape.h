/*
 * The history: a tape of words behind the smoother's workspace.  predict and update append,
 * the smoother takes records off its end.
 *
 *   update   n words: its n rotations;  1 number: nu = e / sqrt(s), the normalised innovation
 *   predict  the filtered mean and root;  pointer and fingerprint of the process before, only if
 *            this predict has another one;  1 word: +-(1 + number of update records since the predict
 *            before it), negative if a process pointer comes before
 *
 * A smoothed step is a slot of mean and root, no larger than its predict record; the slots
 * fill the tape's memory from its far end down, behind the records still to be read.
 */
#ifndef KQ_SRC_SMOOTHER_TAPE_H
#define KQ_SRC_SMOOTHER_TAPE_H

#include "../filter/filter.h"

enum {
    HISTORY_UNUSED,
    HISTORY_FULL,
    HISTORY_SMOOTHING,
    HISTORY_STATES,
    HISTORY_RECORDING,
    HISTORY_ROWS /* recording for a smoother on line: of one step, what its updates were made of */
};

KQ_KERNEL void history_note(history *h, unsigned events)
{
    if (events) h->events = (uint8_t)(h->events | events);
}

KQ_KERNEL num *history_tape(const history *h, int n)
{
    return h->memory + HISTORY_WORKSPACE_LEN(n);
}

KQ_KERNEL size_t history_tape_length(const history *h, int n)
{
    return h->length - HISTORY_WORKSPACE_LEN(n);
}

/* One step without a measurement is the least that there must be room for. */
KQ_KERNEL size_t history_least_length(int n)
{
    return HISTORY_WORKSPACE_LEN(n) + (size_t)FILTER_LEN(n) + 1;
}

/* Of a filter that a history, or a tape that begins with one, is attached to */
KQ_INLINE history *history_of(const filter *f) { return (history *)f->attached; }

/* Nothing that comes after this can be smoothed, and nothing before it with what comes after.  A history
   that was assigned anew, or whose filter f is a copy of, is left alone. */
static void history_end(filter *f)
{
    history *h = history_of(f);
    if (h->filter == f) h->phase = HISTORY_FULL;
    else filter_set_attached(f, 0);
    f->events |= KQ_EVENT_HISTORY_FULL;
}

/* `words` more at the end of the tape, with room left for the slot of the last step; or NULL,
   and the history is full for good. */
KQ_COLD static num *history_extend(filter *f, size_t words)
{
    history *h = history_of(f);
    const size_t last = (size_t)FILTER_LEN(h->states);
    if (h->filter != f || h->phase < HISTORY_RECORDING || h->records == UINT16_MAX ||
        h->used + words + last > history_tape_length(h, h->states)) {
        history_end(f);
        return 0;
    }
    num *end = history_tape(h, h->states) + h->used;
    h->used += words;
    return end;
}

KQ_COLD static void copy_bytes(void *to, const void *from, size_t count)
{
    unsigned char *t = to;
    const unsigned char *f = from;
    for (size_t k = 0; k < count; k++) t[k] = f[k];
}

KQ_COLD static void history_record_predict(filter *f, const process *p)
{
    history *h = history_of(f);
    const int change = h->process && h->process != p;
    const size_t state = (size_t)FILTER_LEN(h->states);
    num *record = history_extend(f, state + (change ? HISTORY_CHANGE_LEN : 0) + 1);
    if (!record) return;
    copy(record, f->memory, (int)state);
    record += state;
    if (change) {
        unsigned char *before = (unsigned char *)record;
        copy_bytes(before, &h->process, sizeof h->process);
        copy_bytes(before + sizeof h->process, &h->fingerprint, sizeof h->fingerprint);
        record += HISTORY_CHANGE_LEN;
    }
    const int mixed = h->process == p && h->fingerprint != p->fingerprint;
    h->fingerprint = mixed ? process_mixed : p->fingerprint;
    const num count = (num)h->records + 1; /* uint16_t may be unsigned int: no minus in it */
    *record = change ? -count : count;
    h->process = p;
    h->records = 0;
    h->steps++;
    h->step = h->steps;
}

#define UPDATE_RECORD_LEN(n) ((size_t)(n) + SCALED_WORDS)
#define ROW_RECORD_LEN(n) ((size_t)ROW_LEN(n) + 3 * SCALED_WORDS)

typedef struct {
    scaled r, e, s;
} row_record;

KQ_KERNEL row_record load_row_record(const num *record, int n)
{
    record += ROW_LEN(n);
    return (row_record){load_scaled(record), load_scaled(record + SCALED_WORDS),
                        load_scaled(record + 2 * SCALED_WORDS)};
}

/* Behind the row */
static void store_row_record(num *record, scaled r, scaled e, scaled s)
{
    store_scaled(record, r);
    store_scaled(record + SCALED_WORDS, e);
    store_scaled(record + 2 * SCALED_WORDS, s);
}

/*
 * What a tape's measurements were rounded by, in squares: the rounding of h'S, as that of the rows of S, beside the
 * innovation's sigma.  In quarters of the square of one rounding, at least one a measurement, to powers of 2.  Rotations
 * of the smoother make no error larger: times the filter's sigmas, it is what smoothed means and sigmas are off by.
 */
KQ_COLD KQ_NOINLINE static void history_add_rounding(filter *f, const scaled *h, scaled s, uint32_t times)
{
    const uint32_t most = UINT32_C(1) << 30;
    history *past = history_of(f);
    scaled terms = scaled_zero();
    for (int k = 0; k < f->states; k++) {
        if (scaled_is_zero(h[k])) continue;
        const scaled part = scaled_times(h[k], root_product(filter_root(f), f->states, k, k));
        scaled_add_times(&terms, h + k, &part);
    }
    for (s = scaled_shift(s, -2); times < most && scaled_is_less(s, terms); times <<= 1) terms = scaled_shift(terms, -1);
    past->rounding = times < most - past->rounding ? past->rounding + times : most;
}

KQ_COLD static void history_record_update(filter *f, const scaled *h, const num *row, const scaled *exact,
                                          scaled r, scaled e, scaled s)
{
    const int n = f->states;
    num *record = history_extend(f, UPDATE_RECORD_LEN(n));
    if (!record) return;
    const int looks = (history_of(f)->steps & 7) == 1; /* at one step in 8 of the ordinary ones */
    if (exact || looks) history_add_rounding(f, h, s, exact ? 1 : 8);
    scaled variance = r, sigma = scaled_root(r);
    for (int i = 0; i < n; i++) {
        const scaled entry = row ? row_entry(row, n, i) : exact[i];
        variance = scaled_plus(variance, scaled_times(entry, entry));
        const scaled next = scaled_root(variance);
        record[i] = rotation_word(entry, sigma, next);
        sigma = next;
    }
    store_scaled(record + n, scaled_over(e, scaled_root(s)));
    history_of(f)->records++;
}

/* A measurement that was not taken: n rotations by nothing */
KQ_COLD static void history_record_nothing(filter *f)
{
    num *record = history_extend(f, UPDATE_RECORD_LEN(f->states));
    if (!record) return;
    for (size_t i = 0; i < UPDATE_RECORD_LEN(f->states); i++) record[i] = 0;
    history_of(f)->records++;
}

/* ------------------------------------------------------------------ the object */

static kq_status history_predict(filter *f, const process *p, const num *u)
{
    const kq_status status = predict_check(f, p, u);
    if (!status) predict_recorded(f, p, u);
    return status;
}

/* kq_step of a filter whose predicts are not its own */
static kq_status step_attached(filter *f, const process *p, const num *u, const sensor *s, const num *z)
{
    kq_status status = step_check(f, p, u, s, z);
    if (!status) status = f->attached->hooks->predict(f, p, u);
    return status ? status : s->kind->take(f, s, z, UINT32_MAX);
}

static kq_status history_check_owner(const history *h, const filter *f)
{
    if (h->states != f->states) return KQ_ERR_MISMATCH;
    return has_other_filter(h->filter, f) ? KQ_ERR_RECORDING : KQ_OK;
}

/* h is empty, and records f from now on: they have been found to fit. */
static void history_begin(history *h, filter *f, const hooks *with)
{
    h->phase = HISTORY_RECORDING;
    h->records = 0;
    h->steps = 1;
    h->step = 1;
    h->used = 0;
    h->events = 0;
    h->rounding = 0;
    h->process = 0;
    h->filter = f;
    history_keep_formats(h, f);
    h->attached.hooks = with;
    filter_set_attached(f, &h->attached);
}

/* A tape that records f from now on, if all fits; with: what it does in the steps */
KQ_COLD static kq_status tape_attach(history *h, filter *f, const hooks *with)
{
    if (!h) return KQ_ERR_NULL;
    kq_status status = filter_check(f);
    if (status) return status;
    if (!size_is_valid(h->states)) return KQ_ERR_SIZE;
    if (!h->memory || h->length < history_least_length(h->states)) return KQ_ERR_MEMORY;
    status = history_check_owner(h, f);
    if (status) return status;
    if (has_other_attached(f, &h->attached) && !is_recorded(f)) return KQ_ERR_RECORDING;
    history_begin(h, f, with);
    return KQ_OK;
}

/* ------------------------------------------------------------------ what is on the tape */

/* Is the process at the tape's end what it was at all predicts in a row that it was recorded at? */
KQ_KERNEL int history_knows_process(const history *h)
{
    return h->process->fingerprint == h->fingerprint;
}

/* Takes the predict record off the tape's end: the filtered mean and root, still in place.
   `before` gets the process of the step before it, h the fingerprint that this had. */
KQ_KERNEL num *history_pop_predict(history *h, const process **before, int n)
{
    num *end = history_tape(h, n) + h->used - 1;
    const int change = *end < 0;
    h->records = (uint16_t)((change ? -*end : *end) - 1);
    *before = h->process;
    size_t words = (size_t)FILTER_LEN(n) + 1;
    if (change) {
        const unsigned char *words_before = (const unsigned char *)(end - HISTORY_CHANGE_LEN);
        copy_bytes(before, words_before, sizeof *before);
        copy_bytes(&h->fingerprint, words_before + sizeof *before, sizeof h->fingerprint);
        words += HISTORY_CHANGE_LEN;
    }
    h->used -= words;
    return history_tape(h, n) + h->used;
}

/* Where smoothed step t is kept */
KQ_KERNEL num *history_slot(const history *h, int n, size_t t)
{
    return h->memory + h->length - (h->steps - t) * (size_t)FILTER_LEN(n);
}

#endif
