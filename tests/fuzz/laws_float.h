/*
 * Laws of f32 and f64 alone: two half steps of continuous time are one, a correlated process noise is what its formula says;
 * sigma points of linear functions are linear steps, a step by sigma points is that of its parts; EM knows no control that is
 * 0, takes from the measurements what controls do, and a factor that is the identity for none.
 */
#ifndef KALMANQ_FUZZ_LAWS_FLOAT_H
#define KALMANQ_FUZZ_LAWS_FLOAT_H

#include "functions.h"
#include "learning.h"
#include "tame.h"

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

/* ------------------------------------------------------------------ sigma points */

/* A x - x + (A x)^2 * bend; innovations z - H x + (H x)^2 * bend */
typedef struct {
    const num *M, *z;
    int rows;
    num bend;
} tame_function;

static void tame_values(void *context, const num *x, num *y)
{
    const tame_function *g = context;
    for (int c = 0; c < g->rows; c++) {
        num sum = 0;
        for (int i = 0; i < law.n; i++) sum += (g->M[c * law.n + i] - (num)(!g->z && c == i)) * x[i];
        y[c] = (g->z ? g->z[c] - sum : sum) + g->bend * sum * sum;
    }
}

/* A step by sigma points, and another that should be alike */
typedef void step_otherwise(tame_function *increment, tame_function *innovation, kq_sigma_points rule);

static void check_sigma_points(num bend, step_otherwise *predict, step_otherwise *update)
{
    const size_t length = KQ_SIGMA_POINTS_LEN((size_t)law.n, (size_t)law.m);
    const kq_sigma_points rule = (kq_sigma_points)below(2);
    num z[MOST], *work = words(length);
    tame_words(z, law.m);
    tame_function f = {law.A, NULL, law.n, bend}, h = {law.H, z, law.m, bend};
    DEMAND(K(predict_sigma_points)(&law.one, &law.process, tame_values, &f, rule, work) == KQ_OK);
    predict(&f, &h, rule);
    check_alike(&law.one, &law.other);
    DEMAND(K(filter_copy)(&law.one, &law.other) == KQ_OK);
    DEMAND(K(update_sigma_points)(&law.one, &law.sensor, tame_values, &h, rule, work) == KQ_OK);
    update(&f, &h, rule);
    if (!K(events)(&law.one) && !K(events)(&law.other)) check_alike(&law.one, &law.other);
}

static void predict_linearly(tame_function *f, tame_function *h, kq_sigma_points rule)
{
    (void)f, (void)h, (void)rule;
    DEMAND(K(predict)(&law.other, &law.process, NULL) == KQ_OK);
}

static void update_linearly(tame_function *f, tame_function *h, kq_sigma_points rule)
{
    (void)f, (void)rule;
    DEMAND(K(update)(&law.other, &law.sensor, h->z) == KQ_OK);
}

static void sigma_points_are_linear(void) { check_sigma_points(0, predict_linearly, update_linearly); }

/* Of s + bend s^2, s = M x + c: the mean has bend times the variance of s in it, the slope is 1 + 2 bend s. */
static void check_bent(const tame_function *g, const num *y, const num *J)
{
    const int n = law.n;
    num P[SQUARE];
    DEMAND(K(covariance)(&law.other, P) == KQ_OK);
    for (int c = 0; c < g->rows; c++) {
        double M[MOST], mean = 0, size = 1, variance = 0;
        const double bend = (double)g->bend, sign = g->z ? -1 : 1;
        for (int i = 0; i < n; i++) {
            M[i] = (double)g->M[c * n + i] - (!g->z && c == i);
            mean += M[i] * (double)K(mean)(&law.other, i), size += fabs(M[i] * (double)K(mean)(&law.other, i));
        }
        for (int i = 0; i < n * n; i++) variance += M[i / n] * M[i % n] * (double)P[i];
        const double expected = (g->z ? (double)g->z[c] : 0) + sign * mean + bend * (mean * mean + variance), most = WORD_ROUNDING * (size * size + variance);
        DEMAND(fabs((double)y[c] - expected) <= most);
        for (int i = 0; i < n; i++) {
            const double slope = (double)J[c * n + i] - M[i] * (sign + 2 * bend * mean);
            DEMAND(fabs(slope) * (double)K(sigma)(&law.other, i) <= most * 16);
        }
    }
}

static void predict_by_parts(tame_function *f, tame_function *h, kq_sigma_points rule)
{
    num d[MOST], J[SQUARE], E[SQUARE];
    const size_t root = KQ_PROCESS_LEN((size_t)law.n);
    K(process) found;
    (void)h;
    DEMAND(K(process_assign)(&found, law.n, 0, words(root), root) == KQ_OK);
    DEMAND(K(linearise)(&law.other, tame_values, f, law.n, rule, d, J, E) == KQ_OK);
    check_bent(f, d, J);
    for (int i = 0; i < law.n; i++) J[i * (law.n + 1)] += 1;
    DEMAND(K(process_linearise)(&found, &law.process, J, E) == KQ_OK);
    DEMAND(K(predict_extended)(&law.other, &found, d) == KQ_OK);
}

static void update_by_parts(tame_function *f, tame_function *h, kq_sigma_points rule)
{
    num e[MOST], J[SQUARE], E[SQUARE], R[SQUARE];
    const int m = law.m;
    const size_t length = (size_t)KQ_SENSOR_LEN(m);
    K(sensor) found;
    (void)f;
    DEMAND(K(sensor_assign)(&found, law.n, m, words(length), length) == KQ_OK);
    DEMAND(K(linearise)(&law.other, tame_values, h, m, rule, e, J, E) == KQ_OK);
    check_bent(h, e, J);
    for (int k = 0; k < m * law.n; k++) J[k] = -J[k];
    DEMAND(K(sensor_linearise)(&found, &law.sensor, J, E, R) == KQ_OK);
    DEMAND(K(update)(&law.other, &found, e) == KQ_OK);
}

static void parts_are_the_step(void) { check_sigma_points(tame() / 64, predict_by_parts, update_by_parts); }

/* ------------------------------------------------------------------ EM */

static learning learnt, also_learnt;

static void tame_recording(K(recording) *r, int l)
{
    num *z = KEEP(num, RECORDED * law.m), *u = l ? KEEP(num, (RECORDED - 1) * l) : NULL;
    spin_if_many(RECORDED * law.m);
    tame_words(z, RECORDED * law.m);
    for (int k = 0; k < (RECORDED - 1) * l; k++) u[k] = tame();
    spin_ends();
    *r = (K(recording)){RECORDED, z, NULL, u};
}

/* Each component sees the first state: of noise alone that is 0, R would become 0, which is refused. */
static void tame_learning(learning *e, int l, const num *B, int r, const num *F)
{
    const num *const from[PARAMETERS] = {law.A, law.H, law.Q, law.R, law.x, law.P};
    memset(e, 0, sizeof *e);
    e->n = law.n, e->m = law.m;
    for (int c = 0; c < law.m; c++) law.H[c * law.n] = 1;
    learn_from(e, l, B, r, F, from);
}

/* Two iterations of both, which raise the likelihood; 0 if there are too few data */
static int learn_both(void)
{
    learning *const both[] = {&learnt, &also_learnt};
    for (int k = 0; k < 2; k++) {
        const kq_status status = begin_learning(both[k], RECORDINGS);
        if (status == KQ_ERR_FEW_DATA) return 0;
        DEMAND(status >= 0);
        for (int t = 0; t < 2; t++) DEMAND(K(em_iterate)(&both[k]->em) == KQ_OK);
        check_parameters(both[k]);
    }
    return 1;
}

static void check_learnt_alike(void)
{
    const num *const *a = (const num *const *)learnt.now, *const *b = (const num *const *)also_learnt.now;
    const double one = (double)K(em_log_likelihood)(&learnt.em), other = (double)K(em_log_likelihood)(&also_learnt.em);
    DEMAND(fabs(one - other) <= WORD_ROUNDING * (1 + fabs(one)));
    for (int k = 0; k < PARAMETERS; k++) {
        double size = 1;
        for (int i = 0; i < learnt.count[k]; i++) size = fmax(size, fabs((double)a[k][i]));
        for (int i = 0; i < learnt.count[k]; i++) DEMAND(fabs((double)a[k][i] - (double)b[k][i]) <= WORD_ROUNDING * size);
    }
}

/* What controls do to z, and is taken from it: H e, e <- A e + B u */
static void take_controls_away(const K(recording) *r, num *z, const num *B, int l)
{
    double e[MOST] = {0}, next[MOST];
    for (int t = 0; t < RECORDED; t++) {
        for (int c = 0; c < law.m; c++) {
            double sum = (double)r->z[t * law.m + c];
            for (int i = 0; i < law.n; i++) sum -= (double)law.H[c * law.n + i] * e[i];
            z[t * law.m + c] = (num)sum;
        }
        for (int i = 0; t + 1 < RECORDED && i < law.n; i++) {
            next[i] = 0;
            for (int k = 0; k < law.n; k++) next[i] += (double)law.A[i * law.n + k] * e[k];
            for (int k = 0; k < l; k++) next[i] += (double)B[i * l + k] * (double)r->u[t * l + k];
        }
        memcpy(e, next, sizeof e);
    }
}

/* EM with controls is EM of what they do not explain; with those that are 0, bit for bit. */
static void controls_are_taken_away(void)
{
    const int l = (int)below(3) + 1, is_none = below(4) == 0;
    num B[3 * MOST];
    for (int k = 0; k < law.n * l; k++) B[k] = tame();
    tame_learning(&learnt, l, B, 0, NULL), tame_learning(&also_learnt, 0, NULL, 0, NULL);
    learnt.choice = also_learnt.choice = (kq_em_choice){below(16) << 2, KQ_EM_MULTIPLE, KQ_EM_MULTIPLE, NULL, NULL};
    for (int k = 0; k < RECORDINGS; k++) {
        num *z = KEEP(num, RECORDED * law.m);
        tame_recording(&learnt.recordings[k], l);
        if (is_none) memset((num *)(uintptr_t)learnt.recordings[k].u, 0, sizeof(num) * (size_t)((RECORDED - 1) * l));
        take_controls_away(&learnt.recordings[k], z, B, l);
        also_learnt.recordings[k] = (K(recording)){RECORDED, z, NULL, NULL};
    }
    if (!learn_both()) return;
    check_learnt_alike();
    for (int k = 0; is_none && k < PARAMETERS; k++) DEMAND(is_same(&learnt, k, also_learnt.now));
}

/* A factor F that is the identity is as if there were none. */
static void factor_of_one_is_none(void)
{
    num F[SQUARE] = {0};
    for (int i = 0; i < law.n; i++) F[i * (law.n + 1)] = 1;
    tame_learning(&learnt, 0, NULL, law.n, F), tame_learning(&also_learnt, 0, NULL, 0, NULL);
    learnt.choice = also_learnt.choice = (kq_em_choice){below(16) << 2, below(2) ? KQ_EM_FULL : KQ_EM_MULTIPLE, KQ_EM_MULTIPLE, NULL, NULL};
    for (int k = 0; k < RECORDINGS; k++) {
        tame_recording(&learnt.recordings[k], 0);
        also_learnt.recordings[k] = learnt.recordings[k];
    }
    if (learn_both()) check_learnt_alike();
}

#endif
