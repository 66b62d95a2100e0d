/* Models of floats, and what must hold of the numbers of a state: the twin of models_q31.h. */
#ifndef KALMANQ_FUZZ_MODELS_FLOAT_H
#define KALMANQ_FUZZ_MODELS_FLOAT_H

#include "input.h"

static void choose_formats(int is_tame) { (void)is_tame; }

/* A copy of exactly so many numbers */
static num *keep_numbers(const num *of, int count)
{
    num *made = KEEP(num, count);
    if (count) memcpy(made, of, sizeof *of * (size_t)count);
    return made;
}

static kq_status put_process(K(process) *p, int n, int l, const num *A, const num *B, const num *Q)
{
    const size_t length = KQ_PROCESS_LEN((size_t)n);
    num *kept_A = keep_numbers(A, n * n), *kept_B = keep_numbers(B, n * l);
    DEMAND(K(process_assign)(p, n, l, words(length), length) == KQ_OK);
    return K(process_init)(p, kept_A, l ? kept_B : NULL, Q);
}

/* Of a kind: any R, lean, independent; from 3 on of innovations */
static kq_status put_sensor(K(sensor) *s, unsigned kind, int n, int m, const num *H, const num *R)
{
    num r[MOST], *kept_H = keep_numbers(H, m * n);
    DEMAND(K(sensor_assign)(s, n, m, words((size_t)KQ_SENSOR_LEN(m)), (size_t)KQ_SENSOR_LEN(m)) == KQ_OK);
    for (int c = 0; c < m; c++) r[c] = R[c * m + c];
    if (kind == 0) return K(sensor_init)(s, kept_H, R);
    if (kind == 3) return K(sensor_init_extended)(s, kept_H, R);
    if (kind == 4) return K(sensor_init_lean_extended)(s, kept_H, r);
    if (kind == 5) return K(sensor_init_diagonal_extended)(s, kept_H, r);
    return kind == 1 ? K(sensor_init_lean)(s, kept_H, r) : K(sensor_init_diagonal)(s, kept_H, r);
}

static kq_status put_prior(K(filter) *f, int n, const word *x, const num *P) { return (void)n, K(filter_init)(f, x, P); }

static kq_status begin_start(K(diffuse) *s, K(filter) *f, int n, const word *x, const num *P, unsigned unknown)
{
    return (void)n, K(diffuse_init)(s, f, x, P, unknown);
}

/* Words for calls: of bytes, of numbers */
static void state_words(word *x, int n) { numbers(x, n); }
static void sensor_words(word *z, const K(sensor) *s) { numbers(z, s->components); }
static void control_words(word *u, const K(process) *p) { numbers(u, p->controls); }
static entry entry_of(num a) { return a; }
static word word_of(num a) { return a; }

static kq_status change_transition(K(process) *p, int n)
{
    num *A = KEEP(num, n * n);
    return numbers(A, n * n), K(process_change_transition)(p, A);
}

static kq_status change_jacobian(K(process) *p, int n) { return change_transition(p, n); }

static kq_status change_measurement(K(sensor) *s, int n)
{
    num *H = KEEP(num, s->components * n);
    return numbers(H, s->components * n), K(sensor_change_measurement)(s, H);
}

static kq_status scale_noise(K(process) *to, const K(process) *from, int n, entry q)
{
    if (!to->states) DEMAND(K(process_assign)(to, n, from->controls, words(KQ_PROCESS_LEN((size_t)n)), KQ_PROCESS_LEN((size_t)n)) == KQ_OK);
    return K(process_scale_noise)(to, from, q);
}

static kq_status smooth_reweighted(K(history) *h, K(process) *to, const K(process) *from, entry nu, entry *q)
{
    return K(smooth_reweighted)(h, to, from, nu, q);
}

static void assign_adaptation(K(adaptation) *a, int n, int m)
{
    const size_t length = (size_t)LENGTH(ADAPTATION)(n, m);
    DEMAND(K(adaptation_assign)(a, n, m, words(length), length) == KQ_OK);
}

static num limit_of(num a) { return a; }

/* ------------------------------------------------------------------ what must hold of numbers */

static double value_of(entry a) { return (double)a; }
static int is_none(entry variance) { return (double)variance < 16 * TINY * TINY; }
static int is_negative(entry variance) { return variance < 0; }

/* p / sqrt(a b) */
static double ratio(entry p, entry a, entry b) { return (double)p / (sqrt((double)a) * sqrt((double)b)); }

static void check_entries(const entry *a, int count) { (void)a, (void)count; }

/* Of a filter or a view */
static void check_numbers(const K(filter) *f, const entry *P)
{
    const int is_told = (K(events)(f) & KQ_EVENT_OVERFLOW) != 0;
    (void)P;
    for (int i = 0; i < f->states; i++) {
        DEMAND(isfinite(K(sigma)(f, i)) || is_told);
        DEMAND(isfinite(K(mean)(f, i)) || is_told);
    }
}

#endif
