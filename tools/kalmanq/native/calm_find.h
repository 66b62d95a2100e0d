/*
 * Whether a full step makes the root of a filter the one that is known to follow, and what it then does to the mean (calm.h).  Compiled once
 * for all sizes: unrolled it is a quarter of a million bytes, and takes longer than all else.
 */
#ifndef KQ_NATIVE_CALM_FIND_H
#define KQ_NATIVE_CALM_FIND_H

#include "fixed_size.h"

#include "steps.h"

#include "calm.h"

#include <string.h>

/* As history_record_update has it */
static void calm_rotations(T(kq_calm) *k, scaled r, int n, int c)
{
    scaled variance = r, sigma = scaled_root(r);
    for (int i = 0; i < n; i++) {
        const scaled entry = k->directions[c * n + i];
        variance = scaled_plus(variance, scaled_times(entry, entry));
        const scaled next = scaled_root(variance);
        k->rotations[c * n + i] = rotation_word(entry, sigma, next);
        sigma = next;
    }
}

/* take_scalar for the root alone.  Answers 0 where the component may be unusual. */
static int calm_keep(T(kq_calm) *k, num *S, const sensor *s, int c)
{
    const int n = s->states;
    const scaled *h = s->measurement + c * n, r = s->noise[c];
    num *f = k->directions + c * n;
    project(f, S, h, n);
    const scaled variance = add_square(r, f, n);
    if (!is_certainly_blunt(r, variance, 0) || is_weak(r, variance)) return 0;
    calm_rotations(k, r, n, c);
    rotor turned;
    rotate_root(&turned, S, f, r, variance, n);
    k->variances[c] = variance;
    k->sigmas[c] = scaled_root(variance);
    likelihood_add(&k->last, 0, physical_variance(s, c, variance));
    return 1;
}

int T(kq_calm_find)(T(kq_calm) *k, const filter *f, const process *p, const sensor *s, const num *next)
{
    num S[KQ_TRIANGLE(KQ_SIZE_MAX)], scratch[PREDICT_SCRATCH(KQ_SIZE_MAX)];
    const int n = f->states;
    const size_t size = sizeof(num) * (size_t)ROOT_LEN(n);
    if (f->ready != FILTER_READY || !sensor_is_plain(s, f, n, s->components)) return 0;
    const extent far = predict_root_of(S, filter_root(f), p, scratch, scratch + n * ROW_LEN(n), n, SHAPE_AS_FOUND);
    renormalise(S, n);
    if (!state_is_within(S, n, far)) return 0;
    likelihood_clear(&k->last);
    for (int c = 0; c < s->components; c++) {
        if (!calm_keep(k, S, s, c)) return 0;
    }
    renormalise(S, n);
    return !memcmp(S, next, size);
}

int T(kq_calm_any)(const T(kq_calm) *k, filter *f, const process *p, const num *u, const sensor *s, const num *z, num *e)
{
    return calm_step(k, f, p, u, s, z, e, f->states, s->components);
}

void T(kq_calm_record)(const T(kq_calm) *k, filter *f, const process *p, const num *e, int m)
{
    const int n = f->states;
    f->attached->hooks->record_predict(f, p);
    for (int c = 0; c < m && f->attached; c++) {
        num *record = history_extend(f, UPDATE_RECORD_LEN(n));
        if (!record) return;
        copy(record, k->rotations + c * n, n);
        store_scaled(record + n, scaled_over(e[c], k->sigmas[c]));
        history_of(f)->records++;
    }
}

#endif
