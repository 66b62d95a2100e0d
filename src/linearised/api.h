/*
 * A history of linearised predicts.  It refers to processes, as any history does: here to copies of them, each
 * with its own A and, where it is another one, its own G.  So the smoother knows nothing of this.  While the tape
 * is recording its workspace is free, and says where the copies are.
 */
#ifndef KQ_SRC_LINEARISED_API_H
#define KQ_SRC_LINEARISED_API_H

#include "../smoother/smoother.h"
#include "predict.h"
#if KQ_FLOATING
#include "rows_float.h"
#endif

typedef T(kq_jacobians) jacobians;

static size_t transition_words(int n) { return (size_t)n * (size_t)n * SCALED_WORDS; }

static int noise_is(const num *G, const num *other, int n)
{
    for (int k = 0; k < ROOT_LEN(n); k++) {
        if (G[k] != other[k]) return 0;
    }
    return 1;
}

/* A copy of p, with its own A and G; NULL where there is no room left */
static const process *keep_process(jacobians *j, const process *p)
{
    const int n = p->states, same_noise = j->noise && noise_is(j->noise, p->noise_root, n);
    const size_t noise = same_noise ? 0 : (size_t)ROOT_LEN(n), words = transition_words(n) + noise;
    if (j->kept == j->predicts || words > j->length - j->used) return 0;
    num *A = j->memory + j->used;
    process *own = j->processes + j->kept++;
    j->used += words;
    *own = *p;
    copy(A, (const num *)p->transition, (int)transition_words(n));
    if (!same_noise) {
        j->noise = A + transition_words(n);
        copy(A + transition_words(n), p->noise_root, ROOT_LEN(n));
    }
    own->transition = (const scaled *)A;
    own->noise_root = j->noise;
    own->control = 0;
    own->controls = 0;
    own->seal = 0;
    return own;
}

static void history_record_linearised(filter *f, const process *p)
{
    history *h = history_of(f);
    const process *own = 0;
    if (h->filter == f && h->phase == HISTORY_RECORDING) {
        jacobians *j;
        copy_bytes(&j, h->memory, sizeof j);
        own = keep_process(j, p);
    }
    if (own) h->attached.hooks->record_predict(f, own);
    else h->attached.hooks->record_end(f);
}

static void history_predict_linearised(filter *f, const process *p, const num *d)
{
    history_record_linearised(f, p);
    if ((predict_linearised(f, p, d) & KQ_EVENT_OVERFLOW) && f->attached) history_end(f);
}

static const linearised_hooks history_linearised_hooks = {
    .steps = {.attach = history_attach,
              .detach = history_detach,
              .predict = history_predict,
              .step = step_attached,
              .record_predict = history_record_predict,
              .record_update = history_record_update,
              .record_nothing = history_record_nothing,
              .record_end = history_end,
              .is_recorder = RECORDS_PROCESSES},
    .predict = history_predict_linearised};

KQ_COLD kq_status T(kq_jacobians_assign)(jacobians *j, history *h, int n, process *processes, size_t predicts,
                                         num *memory, size_t length)
{
    if (!j || !h || !processes || !memory) return KQ_ERR_NULL;
    if (!size_is_valid(n) || predicts < 1 || predicts > KQ_COUNT_MAX) return KQ_ERR_SIZE;
    if (length < JACOBIANS_LEN(n, 1, 1)) return KQ_ERR_MEMORY;
    *j = (jacobians){.attached = {&T(kq_jacobians_hooks)},
                     .states = (uint8_t)n,
                     .predicts = predicts,
                     .length = length,
                     .processes = processes,
                     .memory = memory,
                     .history = h};
    return KQ_OK;
}

static kq_status jacobians_attach(filter *f, attached *object)
{
    jacobians *j = (jacobians *)object;
    history *h = j->history;
    if (!h) return KQ_ERR_NOT_READY;
    if (!size_is_valid(j->states)) return KQ_ERR_SIZE;
    if (!j->memory || !j->processes) return KQ_ERR_MEMORY;
    if (h->states && h->states != j->states) return KQ_ERR_MISMATCH;
    const kq_status status = tape_attach(h, f, &history_linearised_hooks.steps);
    if (status) return status;
    j->kept = 0;
    j->used = 0;
    j->noise = 0;
    copy_bytes(h->memory, &j, sizeof j);
    return KQ_OK;
}

static kq_status jacobians_detach(attached *object)
{
    const jacobians *j = (const jacobians *)object;
    return j->history ? history_detach(&j->history->attached) : KQ_ERR_NOT_READY;
}

/* What is attached is the history. */
const hooks T(kq_jacobians_hooks) = {.attach = jacobians_attach, .detach = jacobians_detach, KQ_RECORDS_NOTHING};

#endif
