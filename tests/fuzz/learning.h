/*
 * EM of any model (f32, f64): controls, a factor of the noise, gaps, held entries, several recordings.  What must hold after
 * every call: what is refused has changed no parameter; what is fixed or held stays, bit for bit; the others are finite, and
 * covariances are positive semi-definite.
 */
#ifndef KALMANQ_FUZZ_LEARNING_H
#define KALMANQ_FUZZ_LEARNING_H

#include "judge.h"

enum { PARAMETERS = 6, RECORDINGS = 2, RECORDED = 4 };

typedef struct {
    int n, m, r, count[PARAMETERS];
    num *now[PARAMETERS], *first[PARAMETERS]; /* A, H, Q, R, x0, P0: as KQ_EM_A ... count them */
    K(parameters) model;
    kq_em_choice choice;
    K(recording) recordings[RECORDINGS];
    K(em) em;
} learning;

/* Of what is given the upper triangle counts: what is not learnt stays as it came. */
static void mirror(num *P, int n)
{
    for (int i = 0; i < n; i++)
        for (int j = 0; j < i; j++) P[i * n + j] = P[j * n + i];
}

static void mirror_covariances(learning *e)
{
    const int sizes[PARAMETERS] = {[2] = e->r, [3] = e->m, [5] = e->n};
    for (int k = 0; k < PARAMETERS; k++) mirror(e->now[k], sizes[k]), mirror(e->first[k], sizes[k]);
}

/* Of numbers of its own, exactly as many as it needs; B and F: NULL for none */
static void learn_from(learning *e, int l, const num *B, int r, const num *F, const num *const from[PARAMETERS])
{
    const int n = e->n, m = e->m;
    const int count[PARAMETERS] = {n * n, m * n, (r ? r * r : n * n), m * m, n, n * n};
    e->r = r ? r : n;
    for (int k = 0; k < PARAMETERS; k++) {
        e->count[k] = count[k];
        e->now[k] = keep_numbers(from[k], count[k]), e->first[k] = keep_numbers(from[k], count[k]);
    }
    num *const *p = e->now;
    e->model = (K(parameters)){l, r, p[0], B, F, p[2], p[1], p[3], p[4], p[5]};
}

static const uint8_t *mask_of(int count)
{
    if (below(3)) return NULL;
    uint8_t *made = KEEP(uint8_t, count);
    spin();
    for (int k = 0; k < count; k++) made[k] = byte() < 64;
    spin_ends();
    return made;
}

static void choose_free(learning *e)
{
    e->choice = (kq_em_choice){below(64), (kq_em_form)below(3), (kq_em_form)below(3), mask_of(e->n * e->n), mask_of(e->m * e->n)};
}

static void record(learning *e, int l)
{
    for (int k = 0; k < RECORDINGS; k++) {
        const size_t steps = below(RECORDED) + 1;
        num *z = KEEP(num, steps * (size_t)e->m), *u = l && below(4) ? KEEP(num, (steps - 1) * (size_t)l) : NULL;
        uint16_t *present = below(2) ? KEEP(uint16_t, steps) : NULL;
        numbers(z, (int)steps * e->m);
        if (u) numbers(u, ((int)steps - 1) * l);
        for (size_t t = 0; present && t < steps; t++) present[t] = (uint16_t)byte();
        e->recordings[k] = (K(recording)){steps, z, present, u};
    }
}

static int is_same(const learning *e, int k, num *const *other)
{
    return memcmp(e->now[k], other[k], sizeof(num) * (size_t)e->count[k]) == 0;
}

static void check_held(const learning *e, int k, const uint8_t *held)
{
    for (int i = 0; held && i < e->count[k]; i++) DEMAND(!held[i] || memcmp(e->now[k] + i, e->first[k] + i, sizeof(num)) == 0);
}

static void check_parameters(const learning *e)
{
    for (int k = 0; k < PARAMETERS; k++) {
        DEMAND(e->choice.free >> k & 1 || is_same(e, k, e->first));
        for (int i = 0; i < e->count[k]; i++) DEMAND(isfinite(e->now[k][i]));
    }
    check_held(e, 0, e->choice.A_held), check_held(e, 1, e->choice.H_held);
    check_covariance(e->now[2], e->r), check_covariance(e->now[3], e->m), check_covariance(e->now[5], e->n);
}

/* The M-step of a complete E-step; a refused one has changed nothing. */
static kq_status maximise(learning *e)
{
    num *before[PARAMETERS];
    for (int k = 0; k < PARAMETERS; k++) before[k] = keep_numbers(e->now[k], e->count[k]);
    const kq_status status = K(em_maximise)(&e->em);
    for (int k = 0; status < 0 && k < PARAMETERS; k++) DEMAND(is_same(e, k, before));
    return status;
}

static void read_gradient(const learning *e)
{
    num *to[PARAMETERS];
    for (int k = 0; k < PARAMETERS; k++) to[k] = below(4) ? KEEP(num, e->count[k]) : NULL;
    const K(gradient) gradient = {to[0], to[1], to[2], to[3], to[4], to[5]};
    (void)!K(em_gradient)(&e->em, &gradient);
}

static kq_status begin_learning(learning *e, size_t count)
{
    const size_t length = LENGTH(EM)(e->n, e->m, RECORDED);
    memset(&e->em, 0, sizeof e->em);
    DEMAND(K(em_assign)(&e->em, e->n, e->m, words(length), length) == KQ_OK);
    const kq_status status = K(em_init)(&e->em, &e->model, &e->choice, e->recordings, count);
    for (int k = 0; k < PARAMETERS; k++) DEMAND(is_same(e, k, e->first));
    return status;
}

static void go_on_learning(learning *e)
{
    if (begin_learning(e, below(RECORDINGS) + 1) < 0) return;
    for (int k = 0; k < 2; k++) {
        kq_status status;
        do status = K(em_advance)(&e->em);
        while (status >= 0 && K(em_remaining)(&e->em));
        if (status >= 0 && k == 1) read_gradient(e);
        if (status >= 0) status = maximise(e);
        check_parameters(e);
        if (status < 0) return;
        DEMAND(isfinite(K(em_log_likelihood)(&e->em)));
    }
}

#endif
