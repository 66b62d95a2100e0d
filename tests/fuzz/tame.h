/* Tame models made of bytes, and what it means that two filters are alike: for laws. */
#ifndef KALMANQ_FUZZ_TAME_H
#define KALMANQ_FUZZ_TAME_H

#include "judge.h"

enum { RUN = 4, LATE = 3 };

static struct {
    int n, m;
    num A[SQUARE], Q[SQUARE], H[SQUARE], R[SQUARE], P[SQUARE];
    word x[MOST];
    K(process) process;
    K(sensor) sensor;
    K(filter) one, other;
    K(history) first, second;
    K(lag) lag;
    K(jacobians) jacobians;
} law;

/* -1 .. 1 */
static num tame(void) { return (num)((int)byte() - 128) / 128; }

/* Of correlations below 1, with sigmas from 1/4 to 4 */
static void tame_covariance(num *P, int n)
{
    num F[2 * SQUARE];
    for (int i = 0; i < n; i++) {
        const num size = (num)ldexp(1, (int)below(5) - 2);
        for (int k = 0; k < 2 * n; k++) F[i * 2 * n + k] = k < n ? (k == i ? size : 0) : size * tame() / (num)n;
    }
    square_of(P, F, n, 2 * n);
}

static void tame_model(void)
{
    const int n = law.n = states = size_drawn(), m = law.m = (int)below(4) + 1;
    choose_formats(1);
    spin_if_many(n);
    for (int k = 0; k < n * n; k++) law.A[k] = tame() / (num)n;
    for (int k = 0; k < m * n; k++) law.H[k] = tame();
    for (int i = 0; i < n; i++) law.x[i] = word_of(8 * tame()), law.A[i * n + i] = 1;
    tame_covariance(law.Q, n), tame_covariance(law.R, m), tame_covariance(law.P, n);
    spin_ends();
    DEMAND(put_process(&law.process, n, 0, law.A, NULL, law.Q) == KQ_OK);
    DEMAND(put_sensor(&law.sensor, below(3), n, m, law.H, law.R) == KQ_OK);
}

static void tame_filter(K(filter) *f)
{
    const size_t length = (size_t)LENGTH(FILTER)(law.n);
    DEMAND(K(filter_assign)(f, law.n, words(length), length) == KQ_OK && put_prior(f, law.n, law.x, law.P) == KQ_OK);
}

static void tame_words(word *z, int count)
{
    for (int c = 0; c < count; c++) z[c] = word_of(4 * tame());
}

/* The same state, but for rounding */
static void check_alike(const K(filter) *f, const K(filter) *g)
{
    entry P[SQUARE], of_g[SQUARE];
    DEMAND(sane(f, P) && sane(g, of_g));
    for (int i = 0; i < f->states; i++) {
        const double sigma = (double)K(sigma)(f, i), moved = (double)K(mean)(f, i) - (double)K(mean)(g, i);
        DEMAND(fabs(moved) <= IS_WHOLE + (WORD_ROUNDING + 1e-9) * (sigma + fabs((double)K(mean)(f, i))));
        for (int j = 0; j < f->states; j++) {
            const entry a = P[i * (f->states + 1)], b = P[j * (f->states + 1)];
            DEMAND(fabs(ratio(P[i * f->states + j], a, b) - ratio(of_g[i * f->states + j], a, b)) <= WORD_ROUNDING);
        }
    }
}

static void check_same(const K(filter) *f, const K(filter) *g)
{
    DEMAND(memcmp(f->memory, g->memory, sizeof(word) * (size_t)LENGTH(FILTER)(law.n)) == 0);
}

#endif
