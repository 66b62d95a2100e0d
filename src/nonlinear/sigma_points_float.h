/*
 * Steps by what sigma points have found (linearise_float.h): their processes and sensors, and whole steps.  What a
 * linear function leaves becomes noise.
 */
#ifndef KQ_SRC_NONLINEAR_SIGMA_POINTS_FLOAT_H
#define KQ_SRC_NONLINEAR_SIGMA_POINTS_FLOAT_H

#include "../linearised/linearised.h"
#include "linearise_float.h"

/* ------------------------------------------------------------------ models of what was found */

/* Is there room in the numbers for the noise that E makes? */
static int left_over_fits(const num *E, int count)
{
    for (int k = 0; k < count; k++) {
        if (num_magnitude(E[k]) > num_most_sigma) return 0;
    }
    return 1;
}

static kq_status process_room_check(const process *p)
{
    if (!p) return KQ_ERR_NULL;
    if (!size_is_valid(p->states)) return KQ_ERR_SIZE;
    return p->memory && p->length >= (unsigned)KQ_PROCESS_LEN(p->states) ? KQ_OK : KQ_ERR_MEMORY;
}

kq_status T(kq_process_linearise)(process *p, const process *base, const num *A, num *E)
{
    num pq[REFLECTOR_LEN(KQ_SIZE_MAX)];
    kq_status status = process_check(base);
    if (!status) status = process_room_check(p);
    if (status) return status;
    if (!A || !E) return KQ_ERR_NULL;
    const int n = base->states;
    if (p->states != n || p == base || p->memory == base->noise_root) return KQ_ERR_MISMATCH;
    if (!all_finite(A, n * n) || !all_finite(E, n * n)) return KQ_ERR_NOT_FINITE;
    if (!left_over_fits(E, n * n)) return KQ_ERR_RANGE;
    (void)T(kq_root_of_rows)(p->memory, E, base, pq);
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
            *noise++ = noise_entry(base, j, c) + dot(0, E + j * n, E + c * n, n);
        }
    }
}

/* a -= share b; what is left in the last 7 bits of the two is rounding, and 0 */
static void take_away(num *a, const num *b, num share, int count)
{
    for (int k = 0; k < count; k++) {
        const num part = share * b[k], rest = a[k] - part;
        a[k] = part + rest / 128 == part ? 0 : rest;
    }
}

/* noise = U D U', by columns from the last, in its place, D on the diagonal; and what U^-1 makes of e and of the rows
   of J, of n words.  What cancels, a variance or a row, is not to become one of rounding. */
static void decorrelate_rows(num *noise, num *e, num *J, int m, int n)
{
    for (int j = m - 1; j >= 0; j--) {
        num *u = noise + column(j);
        num inverse = 0;
        if (u[j] <= num_tiny) u[j] = num_tiny; /* of a 0 an update would divide by 0 */
        else inverse = 1 / u[j];
        for (int i = j - 1; i >= 0; i--) {
            const num share = u[i] * inverse;
            take_away(noise + column(i), u, share, i + 1);
            take_away(e + i, e + j, share, 1);
            take_away(J + i * n, J + j * n, share, n);
            u[i] = share;
        }
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
    num rest[KQ_SIZE_MAX] = {0}; /* nothing is measured yet */
    kq_status status = sensor_check(base);
    if (!status) status = sensor_room_check(s);
    if (status) return status;
    if (!H || !E || !R) return KQ_ERR_NULL;
    const int n = base->states, m = base->components;
    if (s->states != n || s->components != m || s == base || s->memory == base->noise) return KQ_ERR_MISMATCH;
    if (R == base->covariance) return KQ_ERR_MISMATCH;
    if (!all_finite(H, m * n) || !all_finite(E, m * n)) return KQ_ERR_NOT_FINITE;
    if (!left_over_fits(E, m * n)) return KQ_ERR_RANGE;
    widen_noise(s->memory, base, E);
    for (int c = 0; c < m; c++) {
        for (int j = 0; j <= c; j++) R[j * m + c] = R[c * m + j] = s->memory[column(c) + j];
    }
    decorrelate_rows(s->memory, rest, rest, m, 0); /* rows of 0 words, but not of NULL */
    invert_unit(s->memory, m);
    s->noise = s->memory;
    s->covariance = R;
    s->kind = &T(kq_sensor_correlated_extended).kind;
    s->plain = 0;
    return T(kq_sensor_change_measurement)(s, H);
}

/* ------------------------------------------------------------------ steps in one call */

/* What is attached asks for A: D becomes it.  own: all of the noise */
static kq_status predict_explicitly(filter *f, process *own, const num *y, num *D)
{
    const int n = f->states;
    divide_by_root(D, filter_root(f), n, n);
    for (int i = 0; i < n; i++) D[i * (n + 1)] += 1;
    const kq_status status = T(kq_process_change_transition)(own, D);
    return status ? status : T(kq_predict_extended)(f, own, y);
}

/* S <- tria [S + D, G] */
static void predict_by_rows(filter *f, const process *own, const num *y, num *D, num *pq)
{
    const int n = f->states;
    const num *s = filter_root(f);
    for (int j = 0; j < n; j++) {
        for (int i = 0; i <= j; i++) D[i * n + j] += *s++;
    }
    const extent of_root = T(kq_root_of_rows)(filter_root(f), D, own, pq);
    if (f->attached) filter_set_attached(f, 0); /* a start that is over */
    (void)T(kq_predict_end)(f, y, of_root);
}

kq_status T(kq_predict_sigma_points)(filter *f, const process *p, T(kq_function) *increment, void *context, kq_sigma_points rule,
                               num *work)
{
    kq_status status = T(kq_predict_check)(f, p);
    if (status) return status;
    if (!work) return KQ_ERR_NULL;
    const int n = f->states;
    const sampling q = {f, increment, context, n, rule};
    num *y = work, *D = y + n, *E = D + n * n, *pq = E + n * n, *G = pq + REFLECTOR_LEN(n);
    status = sample(&q, y, D, E);
    if (status) return status;
    process own = *p;
    (void)T(kq_root_of_rows)(G, E, p, pq);
    own.noise_root = G;
    if (is_recorded(f)) return predict_explicitly(f, &own, y, D);
    predict_by_rows(f, &own, y, D, pq);
    return KQ_OK;
}

kq_status T(kq_update_sigma_points)(filter *f, const sensor *s, T(kq_function) *innovation, void *context, kq_sigma_points rule,
                              num *work)
{
    kq_status status = T(kq_update_check)(f, s);
    if (status) return status;
    if (!work) return KQ_ERR_NULL;
    const int n = f->states, m = s->components;
    const sampling q = {f, innovation, context, m, rule};
    num *e = work, *noise = e + m, *D = noise + KQ_TRIANGLE(m), *E = D + m * n, *own = E; /* where E is used up */
    status = sample(&q, e, D, E);
    if (status) return status;
    if (!left_over_fits(E, m * n)) return KQ_ERR_RANGE;
    widen_noise(noise, s, E);
    decorrelate_rows(noise, e, D, m, n);
    sensor rows = *s;
    for (int c = 0; c < m; c++) {
        e[c] = -e[c]; /* D is -(S'H')' */
        noise[c] = noise[column(c) + c];
        rows.selects[c] = 0;
    }
    rows.kind = &T(kq_sensor_independent);
    rows.measurement = D;
    rows.noise = noise;
    rows.covariance = 0;
    return T(kq_update_by_rows)(f, &rows, e, own);
}

#endif
