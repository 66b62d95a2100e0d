/*
 * Whether a full step leaves the root of a filter as it is, and what it then does to the mean (calm.h).  Compiled once
 * for all sizes: unrolled it is a quarter of a million bytes, and takes longer than all else.
 */
#ifndef KQ_NATIVE_CALM_FIND_H
#define KQ_NATIVE_CALM_FIND_H

#include "fixed_size.h"

#include "fixed_size/steps.h"

#include <string.h>

/* take_scalar for the root alone.  Answers 0 where the component may be unusual. */
static int calm_keep(T(kq_calm) *k, num *S, const sensor *s, int c)
{
    const int n = s->states;
    const scaled *h = s->measurement + c * n, r = s->noise[c];
    num *f = k->directions + c * n;
    project(f, S, h, n);
    const scaled variance = add_square(r, f, n);
    if (!is_certainly_ordinary(r, variance, 0)) return 0;
    rotate_root(S, f, r, variance, n);
    k->variances[c] = variance;
    likelihood_add(&k->last, 0, physical_variance(s, c, variance));
    return 1;
}

int T(kq_calm_find)(T(kq_calm) *k, const filter *f, const process *p, const sensor *s)
{
    num S[KQ_TRIANGLE(KQ_SIZE_MAX)], scratch[PREDICT_SCRATCH(KQ_SIZE_MAX)];
    const int n = f->states;
    const size_t size = sizeof(num) * (size_t)ROOT_LEN(n);
    if (!filter_is_plain(f, n) || !sensor_is_plain(s, f, n, s->components)) return 0;
    const extent far = predict_root_of(S, filter_root(f), p, scratch, scratch + n * ROW_LEN(n), n, SHAPE_AS_FOUND);
    renormalise(S, n);
    if (!state_is_within(S, n, far)) return 0;
    likelihood_clear(&k->last);
    for (int c = 0; c < s->components; c++) {
        if (!calm_keep(k, S, s, c)) return 0;
    }
    renormalise(S, n);
    return !memcmp(S, filter_root(f), size);
}

#endif
