/*
 * Steps by what sigma points have found (linearise_float.h): their processes and sensors, and whole steps.  What a
 * linear function leaves becomes noise.
 */
#ifndef KQ_SRC_NONLINEAR_POINTS_FLOAT_H
#define KQ_SRC_NONLINEAR_POINTS_FLOAT_H

#include <stddef.h>
#include <stdint.h>

#include "kalmanq/extended.h"
#include "kalmanq/points.h"
#include "kalmanq/size.h"
#include "kalmanq/status.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/root.h"
#include "../arithmetic/rows.h"
#include "../arithmetic/size.h"
#include "../arithmetic/triangle.h"
#include "../model/definitions.h"
#include "../model/process.h"
#include "../model/sensor.h"
#include "../model/types.h"
#include "../model/units.h"
#include "../filter/attached.h"
#include "../filter/checks.h"
#include "../filter/filter.h"
#include "../filter/prior.h"
#include "../smoother/smoother.h"
#include "../smoother/tape.h"
#include "../linearised/mean.h"
#include "../linearised/rows.h"
#include "linearise_float.h"

/* ------------------------------------------------------------------ models of what was found */

static kq_status process_room_check(const process *p)
{
    if (!p) return KQ_ERR_NULL;
    if (!size_is_valid(p->states)) return KQ_ERR_SIZE;
    return p->memory && p->length >= (unsigned)KQ_PROCESS_LEN(p->states) ? KQ_OK : KQ_ERR_MEMORY;
}

kq_status T(kq_process_linearise)(process *p, const process *base, const num *A, num *E)
{
    num pq[2 * KQ_SIZE_MAX];
    kq_status status = process_check(base);
    if (!status) status = process_room_check(p);
    if (status) return status;
    if (!A || !E) return KQ_ERR_NULL;
    const int n = base->states;
    if (p->states != n || p == base || p->memory == base->noise_root) return KQ_ERR_MISMATCH;
    if (!all_finite(A, n * n) || !all_finite(E, n * n)) return KQ_ERR_NOT_FINITE;
    T(kq_root_of_rows)(p->memory, E, n, base, pq);
    p->noise_root = p->memory;
    p->controls = 0;
    p->control = 0;
    return T(kq_process_change_transition)(p, A);
}

/* The upper triangle of R + E E' */
static void widen_noise(num *noise, const sensor *base, const num *E)
{
    const int n = base->states;
    for (int c = 0; c < base->components; c++) {
        for (int j = 0; j <= c; j++) {
            *noise++ = noise_covariance(base, j, c) + dot(0, E + j * n, E + c * n, n);
        }
    }
}

/* noise = U D U', by columns from the last, in its place: D on the diagonal.  What the other components leave of one
   is none below 8 m eps of it (sensor.h). */
static void take_apart(num *noise, int m)
{
    const num rounding = (num)(8 * m) * num_epsilon;
    num whole[KQ_SIZE_MAX];
    for (int j = 0; j < m; j++) whole[j] = noise[column(j) + j];
    for (int j = m - 1; j >= 0; j--) {
        num *u = noise + column(j);
        if (u[j] <= rounding * whole[j] || u[j] < num_tiny) u[j] = 0;
        const num inverse = u[j] > 0 ? 1 / u[j] : 0;
        for (int i = 0; i < j; i++) {
            const num share = u[i] * inverse;
            for (int k = 0; k <= i; k++) noise[column(i) + k] -= share * u[k];
        }
        for (int i = 0; i < j; i++) u[i] *= inverse;
    }
}

static kq_status sensor_room_check(const sensor *s)
{
    if (!s) return KQ_ERR_NULL;
    if (!size_is_valid(s->states) || !size_is_valid(s->components)) return KQ_ERR_SIZE;
    return s->memory && s->length >= (unsigned)KQ_SENSOR_LEN(s->components) ? KQ_OK : KQ_ERR_MEMORY;
}

kq_status T(kq_sensor_linearise)(sensor *s, const sensor *base, const num *H, const num *E, num *R)
{
    kq_status status = sensor_check(base);
    if (!status) status = sensor_room_check(s);
    if (status) return status;
    if (!H || !E || !R) return KQ_ERR_NULL;
    const int n = base->states, m = base->components;
    if (s->states != n || s->components != m || s == base || s->memory == base->noise) return KQ_ERR_MISMATCH;
    if (R == base->covariance) return KQ_ERR_MISMATCH;
    if (!all_finite(H, m * n) || !all_finite(E, m * n)) return KQ_ERR_NOT_FINITE;
    widen_noise(s->memory, base, E);
    for (int c = 0; c < m; c++) {
        for (int j = 0; j <= c; j++) R[j * m + c] = R[c * m + j] = s->memory[column(c) + j];
    }
    take_apart(s->memory, m);
    invert_unit(s->memory, m);
    s->noise = s->memory;
    s->covariance = R;
    s->kind = &T(kq_sensor_correlated);
    s->plain = 0;
    return T(kq_sensor_change_measurement)(s, H);
}

/* ------------------------------------------------------------------ steps in one call */

static kq_status predict_points_check(const sampling *q, const process *p, const num *work)
{
    kq_status status = sampling_check(q);
    if (!status) status = free_mean_check(q->at);
    if (!status) status = process_check(p);
    if (status) return status;
    if (!work) return KQ_ERR_NULL;
    if (!process_fits(p, q->at)) return KQ_ERR_MISMATCH;
    const attached *with = q->at->attached;
    return with && with->hooks->is_recorder == RECORDS_BY_REFERENCE ? KQ_ERR_RECORDING : KQ_OK;
}

/* What is attached asks for A and a noise: D becomes A, and the bends become a part of the noise. */
static kq_status predict_explicitly(filter *f, const process *p, const num *y, num *D, num *E)
{
    process own = *p;
    const int n = f->states;
    num *pq = E + n * n, *G = pq + 2 * n;
    divide_by_root(D, filter_root(f), n, n);
    for (int i = 0; i < n; i++) D[i * (n + 1)] += 1;
    T(kq_root_of_rows)(G, E, n, p, pq);
    own.noise_root = G;
    T(kq_process_change_transition)(&own, D);
    return T(kq_predict_extended)(f, &own, y);
}

/* S <- tria [S + D, E, G], the rows of D and E side by side */
static void advance_by_rows(filter *f, const process *p, const num *y, num *rows)
{
    const int n = f->states;
    num *S = filter_root(f), *pq = rows + 2 * n * n;
    for (int j = 0; j < n; j++) {
        for (int i = 0; i <= j; i++) rows[2 * n * i + j] += S[column(j) + i];
    }
    T(kq_root_of_rows)(S, rows, 2 * n, p, pq);
    T(kq_predict_end)(f, y);
}

kq_status T(kq_predict_points)(filter *f, const process *p, T(kq_function) *increment, void *context, kq_points rule,
                               num *work)
{
    const sampling q = {f, increment, context, f ? f->states : 0, rule};
    const kq_status status = predict_points_check(&q, p, work);
    if (status) return status;
    const int n = f->states, is_recorder = is_recorded(f);
    num *y = work, *D = y + n, *E = is_recorder ? D + n * n : D + n;
    if (!sample(&q, y, D, E, is_recorder ? n : 2 * n)) return KQ_ERR_NOT_FINITE;
    if (is_recorder) return predict_explicitly(f, p, y, D, E);
    f->attached = 0; /* a start that is over */
    advance_by_rows(f, p, y, D);
    return KQ_OK;
}

/* a - b; what is rounding of the two is 0 */
static num difference(num a, num b)
{
    const num rest = a - b;
    return num_magnitude(rest) <= 64 * num_epsilon * (num_magnitude(a) + num_magnitude(b)) ? 0 : rest;
}

/* e = J x + v: each component less what those after it say of its noise, which is U D U' in `noise`.  Then D, in its
   first words, is all that there is of it.  A row that cancels is not to become one of rounding: D may be 0. */
static void decorrelate_rows(num *e, num *J, num *noise, int m, int n)
{
    for (int i = m - 2; i >= 0; i--) {
        for (int j = i + 1; j < m; j++) {
            const num u = noise[column(j) + i];
            e[i] -= u * e[j];
            for (int k = 0; k < n; k++) J[i * n + k] = difference(J[i * n + k], u * J[j * n + k]);
        }
    }
    for (int c = 1; c < m; c++) noise[c] = noise[column(c) + c];
}

kq_status T(kq_update_points)(filter *f, const sensor *s, T(kq_function) *innovation, void *context, kq_points rule,
                              num *work)
{
    const sampling q = {f, innovation, context, s ? s->components : 1, rule};
    kq_status status = sensor_check_for(f, s);
    if (!status) status = sampling_check(&q);
    if (!status) status = free_mean_check(f);
    if (status) return status;
    if (!work) return KQ_ERR_NULL;
    const int n = f->states, m = s->components;
    num *e = work, *J = e + m, *E = J + m * n, *noise = E + m * n;
    if (!sample(&q, e, J, E, n)) return KQ_ERR_NOT_FINITE;
    divide_by_root(J, filter_root(f), m, n);
    widen_noise(noise, s, E);
    take_apart(noise, m);
    decorrelate_rows(e, J, noise, m, n);
    for (int c = 0; c < m; c++) e[c] = -e[c]; /* J is -H */
    sensor own = *s;
    own.kind = &T(kq_sensor_independent);
    own.measurement = J;
    own.noise = noise;
    own.covariance = 0;
    for (int c = 0; c < m; c++) own.selects[c] = 0;
    return T(kq_update_extended)(f, &own, e);
}

/* ------------------------------------------------------------------ a smoothed step to linearise at */

kq_status T(kq_smoothed_copy)(const history *h, size_t t, filter *to)
{
    if (!h || !to) return KQ_ERR_NULL;
    if (filter_check_memory(to)) return KQ_ERR_MEMORY;
    if (t >= h->steps) return KQ_ERR_SIZE;
    if (!smoothed_is_valid(h, t) || h->phase == HISTORY_STATES) return KQ_ERR_NOT_READY;
    if (to->states != h->states) return KQ_ERR_MISMATCH;
    const num *state = history_slot(h, h->states, t);
    filter_begin(to, state);
    copy(to->memory, state, FILTER_LEN(h->states));
    return KQ_OK;
}

#endif
