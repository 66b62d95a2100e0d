/* What turned.c turns bits in: an arithmetic, three models with their measurements, and the objects of one, in one piece of memory. */
#ifndef KALMANQ_TESTS_CAMPAIGN_TURNED_H
#define KALMANQ_TESTS_CAMPAIGN_TURNED_H

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "kalmanq/kalmanq.h"
#include "kalmanq/prepare.h"

enum { N = 4, M = 2, L = 1, BEFORE = 40, STEPS = 50 };

#if defined(KQ_TURNED_Q31)
typedef int32_t num;
typedef kq_scaled_q31 coefficient;
typedef int64_t score;
#define NUMBER(x) whole((x))
#define T(name) name##_q31
#define LENGTH(name) KQ_##name##_LEN_Q31
#elif defined(KQ_TURNED_F64)
typedef double num, coefficient, score;
#define NUMBER(x) (x)
#define T(name) name##_f64
#define LENGTH(name) KQ_##name##_LEN_F64
#else
typedef float num, coefficient, score;
#define NUMBER(x) ((float)(x))
#define T(name) name##_f32
#define LENGTH(name) KQ_##name##_LEN_F32
#endif

/* ------------------------------------------------------------------ models and what is measured */

typedef struct {
    int n, m, l;
    double A[N * N], B[N * L], F[N * N]; /* Q = F F' */
    double H[M * N], R[M * M];
} model;

static const model models[] = {
    {2, 1, 0, {1, 0.1, 0, 1}, {0}, {0.005, 0.003, 0, 0.1}, {1, 0}, {0.04}},
    {4, 2, 0,
     {1, 0, 0.1, 0, 0, 1, 0, 0.1, 0, 0, 1, 0, 0, 0, 0, 1},
     {0},
     {0.005, 0, 0.003, 0, 0, 0.005, 0, 0.003, 0, 0, 0.1, 0, 0, 0, 0, 0.1},
     {1, 0, 0, 0, 0, 1, 0, 0},
     {0.04, 0, 0, 0.04}},
    {3, 2, 1,
     {0.9, 0.1, 0.05, -0.1, 0.95, 0.1, 0, -0.05, 0.8},
     {0.1, 0.2, 0.5},
     {0.1, 0, 0, 0.05, 0.1, 0, 0, 0.05, 0.2},
     {1, 0.5, 0, 0, 1, -1},
     {0.09, 0.03, 0.03, 0.04}},
};
enum { MODELS = sizeof models / sizeof models[0] };

static uint64_t state;

static double normal(void)
{
    double sum = -6;
    for (int k = 0; k < 12; k++) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        sum += (double)(state >> 11) * 0x1p-53;
    }
    return sum;
}

static double z_at[BEFORE + STEPS][M], u_at[BEFORE + STEPS][L];

static void measure(const model *p, uint64_t seed)
{
    double x[N] = {0};
    state = seed * 0x9E3779B97F4A7C15u;
    for (int t = 0; t < BEFORE + STEPS; t++) {
        double next[N], w[N], v[M];
        for (int i = 0; i < N; i++) w[i] = normal();
        for (int c = 0; c < M; c++) v[c] = normal();
        u_at[t][0] = normal();
        for (int i = 0; i < p->n; i++) {
            next[i] = p->l ? p->B[i] * u_at[t][0] : 0;
            for (int k = 0; k < p->n; k++) next[i] += p->A[i * p->n + k] * x[k] + p->F[i * p->n + k] * w[k];
        }
        memcpy(x, next, sizeof x);
        for (int c = 0; c < p->m; c++) {
            z_at[t][c] = sqrt(p->R[c * p->m + c]) * v[c];
            for (int k = 0; k < p->n; k++) z_at[t][c] += p->H[c * p->n + k] * x[k];
        }
    }
}

/* ------------------------------------------------------------------ the objects */

typedef union {
    T(kq_history) history;
    T(kq_lag) lag;
    T(kq_instant) instant;
    T(kq_adaptation) adaptation;
    T(kq_freeze) freeze;
    T(kq_diffuse) start;
    T(kq_loss) loss;
    T(kq_consistency) window;
    T(kq_steady) steady;
    T(kq_least_squares) fit;
#if !defined(KQ_TURNED_Q31)
    T(kq_em) em;
#endif
} object;

enum { WORDS = 2000, NUMBERS = 64 };

typedef struct {
    T(kq_process) process;
    T(kq_sensor) sensor;
    T(kq_filter) filter;
    object other; /* one of them, with its memory (turned_objects.h) */
    T(kq_history) tape;
    num memory[WORDS], tape_memory[WORDS];
    coefficient numbers[NUMBERS];
    num filter_memory[LENGTH(FILTER)(N)];
#if defined(KQ_TURNED_Q31)
    kq_format_q31 x[N], z[M], u[L];
    kq_scaled_q31 A[N * N], B[N * L], H[M * N], noise[KQ_TRIANGLE(M)];
    num G[KQ_ROOT_LEN_Q31(N)];
#else
    num A[N * N], B[N * L], H[M * N], R[M * M];
    num G[KQ_PROCESS_LEN(N)], noise[KQ_SENSOR_LEN(M)];
#endif
} world;

static world now;
static num x0[N]; /* 0 */
#if defined(KQ_TURNED_Q31)
static num P0[KQ_ROOT_LEN_Q31(N)];
static kq_prior_table_q31 prior;
#else
static num P0[N * N];
#endif

static void need(kq_status status, const char *what)
{
    if (!status) return;
    fprintf(stderr, "turned: %s answers %d\n", what, status);
    exit(1);
}

static void square(double *Q, const double *F, int n)
{
    for (int k = 0; k < n * n; k++) {
        Q[k] = 0;
        for (int j = 0; j < n; j++) Q[k] += F[k / n * n + j] * F[k % n * n + j];
    }
}

#if defined(KQ_TURNED_Q31)

static double value(int i, double raw) { return ldexp(raw, -now.x[i].fraction); }
static double mean(const kq_filter_q31 *f, int i) { return value(i, kq_mean_q31(f, i) + kq_mean_low_q31(f, i) * 0x1p-24); }
static double sigma(const kq_filter_q31 *f, int i)
{
    kq_scaled_q31 P[N * N];
    if (kq_covariance_q31(f, P) < 0) return NAN;
    const kq_scaled_q31 p = P[i * (f->states + 1)];
    return value(i, sqrt(ldexp(p.mantissa, p.exponent)));
}
static double points(score x) { return (double)x * 0x1p-24; }
static score of_points(double x) { return (score)(x * 0x1p24); }
static kq_scaled_q31 whole(double x)
{
    const kq_format_q31 one = {1, 0};
    kq_scaled_q31 made;
    need(kq_matrix_prepare_q31(&made, &x, 1, 1, &one, &one), "a number");
    return made;
}
static double likelihood(void) { return (double)kq_log_likelihood_q31(&now.filter) * 0x1p-24; }
static num measured(int t, int c) { return (num)lrint(ldexp(z_at[t][c], now.z[c].fraction)); }
static num driven(int t) { return (num)lrint(ldexp(u_at[t][0], now.u[0].fraction)); }

static void make(const model *p)
{
    double Q[N * N], I[N * N] = {0};
    const int n = p->n, m = p->m, is_correlated = p->R[1] != 0 && m > 1;
    square(Q, p->F, n);
    memset(&now, 0, sizeof now);
    const int best = KQ_FRACTION_BEST_Q31;
    for (int i = 0; i < n; i++) need(kq_format_prepare_q31(&now.x[i], best, 200, NULL), "format"), I[i * (n + 1)] = 1;
    for (int c = 0; c < m; c++) need(kq_format_prepare_q31(&now.z[c], best, 200, NULL), "format");
    need(kq_format_prepare_q31(&now.u[0], best, 20, NULL), "format");
    need(kq_matrix_prepare_q31(now.A, p->A, n, n, now.x, now.x), "A");
    if (p->l) need(kq_matrix_prepare_q31(now.B, p->B, n, p->l, now.x, now.u), "B");
    need(kq_matrix_prepare_q31(now.H, p->H, m, n, now.z, now.x), "H");
    need(kq_root_prepare_q31(now.G, Q, n, now.x), "Q");
    need(kq_root_prepare_q31(P0, I, n, now.x), "P0");
    if (is_correlated) need(kq_noise_prepare_q31(now.noise, p->R, m, now.z), "R");
    const double r[] = {p->R[0], p->R[m * m - 1]};
    if (!is_correlated) need(kq_noise_prepare_diagonal_q31(now.noise, r, m, now.z), "r");
    const kq_process_table_q31 moves = {n, p->l, now.x, now.u, now.A, now.B, now.G};
    const kq_sensor_table_q31 sees = {n, m, is_correlated, now.x, now.z, now.H, now.noise};
    prior = (kq_prior_table_q31){n, now.x, x0, P0};
    need(kq_process_init_q31(&now.process, &moves, NULL), "process");
    need(kq_sensor_init_q31(&now.sensor, &sees, NULL), "sensor");
    need(kq_filter_assign_q31(&now.filter, n, now.filter_memory, LENGTH(FILTER)((size_t)n)), "filter");
    need(kq_filter_init_q31(&now.filter, &prior, NULL), "filter");
}

#else

static double mean(const T(kq_filter) *f, int i) { return (double)T(kq_mean)(f, i) + (double)T(kq_mean_low)(f, i); }
static double sigma(const T(kq_filter) *f, int i) { return (double)T(kq_sigma)(f, i); }
static double points(score x) { return (double)x; }
static score of_points(double x) { return (score)x; }
static double likelihood(void) { return (double)T(kq_log_likelihood)(&now.filter); }
static num measured(int t, int c) { return (num)z_at[t][c]; }
static num driven(int t) { return (num)u_at[t][0]; }

static void make(const model *p)
{
    double Q[N * N];
    num q[N * N];
    const int n = p->n, m = p->m;
    square(Q, p->F, n);
    memset(&now, 0, sizeof now);
    memset(P0, 0, sizeof P0);
    for (int k = 0; k < n * n; k++) now.A[k] = (num)p->A[k], q[k] = (num)Q[k];
    for (int k = 0; k < n; k++) now.B[k] = (num)p->B[k], P0[k * (n + 1)] = 1;
    for (int k = 0; k < m * n; k++) now.H[k] = (num)p->H[k];
    for (int k = 0; k < m * m; k++) now.R[k] = (num)p->R[k];
    need(T(kq_process_assign)(&now.process, n, p->l, now.G, (size_t)KQ_PROCESS_LEN(n)), "process");
    need(T(kq_process_init)(&now.process, now.A, now.B, q), "process");
    need(T(kq_sensor_assign)(&now.sensor, n, m, now.noise, (size_t)KQ_SENSOR_LEN(m)), "sensor");
    need(T(kq_sensor_init)(&now.sensor, now.H, now.R), "sensor");
    need(T(kq_filter_assign)(&now.filter, n, now.filter_memory, (size_t)LENGTH(FILTER)(n)), "filter");
    need(T(kq_filter_init)(&now.filter, x0, P0), "filter");
}

#endif

#endif
