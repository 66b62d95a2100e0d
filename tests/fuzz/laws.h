/*
 * Laws of calls that mean the same, of tame models made of bytes: what comes late is as if in time, a smoother run in slices
 * is the run, the last step of a view is the filter, two half steps of continuous time are one, a correlated process noise
 * is what its formula says.
 */
#ifndef KALMANQ_FUZZ_LAWS_H
#define KALMANQ_FUZZ_LAWS_H

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
    const int n = law.n = states = (int)below(MOST) + 1, m = law.m = (int)below(4) + 1;
    choose_formats(1);
    for (int k = 0; k < n * n; k++) law.A[k] = tame() / (num)n;
    for (int k = 0; k < m * n; k++) law.H[k] = tame();
    for (int i = 0; i < n; i++) law.x[i] = word_of(8 * tame()), law.A[i * n + i] = 1;
    tame_covariance(law.Q, n), tame_covariance(law.R, m), tame_covariance(law.P, n);
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
        DEMAND(fabs(moved) <= (WORD_ROUNDING + 1e-9) * (sigma + fabs((double)K(mean)(f, i))));
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

/* A measurement taken `late` steps later is as in time; an on-line view of the present is the filter. */
static void late_is_in_time(void)
{
    const size_t length = LENGTH(LAG)(law.n, law.m, LATE);
    const int late = (int)below(LATE) + 1;
    word z[RUN + 1][MOST];
    K(filter) view;
    for (int t = 0; t <= RUN; t++) tame_words(z[t], law.m);
    DEMAND(K(delay_assign)(&law.lag, law.n, law.m, LATE, words(length), length) == KQ_OK);
    DEMAND(K(attach)(&law.one, &law.lag.attached) == KQ_OK);
    for (int t = 0; t < RUN; t++) {
        DEMAND(K(predict)(&law.one, &law.process, NULL) == KQ_OK && K(predict)(&law.other, &law.process, NULL) == KQ_OK);
        DEMAND(K(update)(&law.one, &law.sensor, z[t]) == KQ_OK && K(update)(&law.other, &law.sensor, z[t]) == KQ_OK);
        if (t == RUN - 1 - late) DEMAND(K(update)(&law.other, &law.sensor, z[RUN]) == KQ_OK);
    }
    DEMAND(K(update_delayed)(&law.lag, (size_t)late, &law.sensor, z[RUN], UINT32_MAX) == KQ_OK);
    if (!K(events)(&law.one) && !K(events)(&law.other)) check_alike(&law.one, &law.other);
    DEMAND(K(lagged)(&law.lag, 0, &view) == KQ_OK);
    check_same(&view, &law.one);
    DEMAND(K(predict)(&view, &law.process, NULL) == KQ_ERR_NOT_READY && K(update)(&view, &law.sensor, z[0]) == KQ_ERR_NOT_READY);
}

/* A run smoothed step by step is the run smoothed at once, bit for bit; what a view says of the last step is the filter's. */
static void slices_are_the_whole(void)
{
    const size_t length = LENGTH(HISTORY)(law.n, law.m, RUN + 1, 1);
    word z[MOST];
    K(filter) view, same;
    DEMAND(K(history_assign)(&law.first, law.n, words(length), length) == KQ_OK && K(attach)(&law.one, &law.first.attached) == KQ_OK);
    DEMAND(K(history_assign)(&law.second, law.n, words(length), length) == KQ_OK && K(attach)(&law.other, &law.second.attached) == KQ_OK);
    for (int t = 0; t < RUN; t++) {
        tame_words(z, law.m);
        DEMAND(K(step)(&law.one, &law.process, NULL, &law.sensor, z) == KQ_OK);
        DEMAND(K(predict)(&law.other, &law.process, NULL) == KQ_OK && K(update)(&law.other, &law.sensor, z) == KQ_OK);
    }
    check_same(&law.one, &law.other);
    DEMAND(K(smooth)(&law.first) == KQ_OK);
    for (size_t t = RUN + 1; t-- > 0;) {
        DEMAND(K(smooth_step)(&law.second, NULL, NULL) == KQ_OK);
        DEMAND(K(smoothed)(&law.first, t, &view) == KQ_OK && K(smoothed)(&law.second, t, &same) == KQ_OK);
        check_same(&view, &same);
        if (t == RUN) check_same(&view, &law.one);
    }
}

#ifndef KQ_FUZZ_Q31
/* Two steps of dt / 2 are one of dt: exp(F dt) and Q of Van Loan. */
static void halves_are_a_step(void)
{
    const size_t length = KQ_CONTINUOUS_LEN((size_t)law.n, 0), root = KQ_PROCESS_LEN((size_t)law.n);
    const num dt = (num)ldexp(1, -(int)below(8));
    num F[SQUARE];
    K(process) whole, half;
    for (int k = 0; k < law.n * law.n; k++) F[k] = tame();
    DEMAND(K(process_assign)(&whole, law.n, 0, words(root), root) == KQ_OK && K(process_assign)(&half, law.n, 0, words(root), root) == KQ_OK);
    DEMAND(K(process_init_continuous)(&whole, F, NULL, law.Q, dt, words(length), length) == KQ_OK);
    DEMAND(K(process_init_continuous)(&half, F, NULL, law.Q, dt / 2, words(length), length) == KQ_OK);
    DEMAND(K(predict)(&law.one, &whole, NULL) == KQ_OK);
    for (int k = 0; k < 2; k++) DEMAND(K(predict)(&law.other, &half, NULL) == KQ_OK);
    check_alike(&law.one, &law.other);
}

/* Noises correlated with those of one component: A* = A - K H, Q* = Q - K S', K = S / R */
static void correlated_is_its_formula(void)
{
    const int n = law.n;
    const size_t length = KQ_CORRELATED_LEN((size_t)n, 0, 1);
    num S[MOST], r = 0, A[SQUARE], B[MOST], Q[SQUARE];
    word z[1];
    K(process) ours, formula;
    K(sensor) sensor;
    for (int i = 0; i < n; i++) S[i] = tame() / (8 * (num)n);
    r = 1 + law.R[0];
    DEMAND(put_sensor(&sensor, 0, n, 1, law.H, &r) == KQ_OK);
    for (int i = 0; i < n; i++) {
        B[i] = S[i] / r;
        for (int j = 0; j < n; j++) {
            A[i * n + j] = law.A[i * n + j] - B[i] * law.H[j];
            Q[i * n + j] = law.Q[i * n + j] - S[i] * S[j] / r;
        }
    }
    DEMAND(put_process(&formula, n, 1, A, B, Q) == KQ_OK && K(process_assign)(&ours, n, 1, words(length), length) == KQ_OK);
    DEMAND(K(process_init_correlated)(&ours, law.A, NULL, law.Q, &sensor, S, UINT32_MAX) == KQ_OK);
    tame_words(z, 1);
    DEMAND(K(predict)(&law.one, &ours, z) == KQ_OK && K(predict)(&law.other, &formula, z) == KQ_OK);
    check_alike(&law.one, &law.other);
}
#endif

static void check_a_law(void)
{
    tame_model();
    tame_filter(&law.one), tame_filter(&law.other);
    switch (below(4)) {
    case 0: late_is_in_time(); break;
#ifndef KQ_FUZZ_Q31
    case 1: halves_are_a_step(); break;
    case 2: correlated_is_its_formula(); break;
#endif
    default: slices_are_the_whole();
    }
}

#endif
