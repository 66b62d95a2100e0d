/*
 * Random models for the words of fixed point: sizes, scales over eight decades, singular Q,
 * correlated R, gaps, controls, a prior that may be far wider than the states are.
 */
#ifndef KALMANQ_TESTS_WORD_MODELS_H
#define KALMANQ_TESTS_WORD_MODELS_H

#include <math.h>
#include <stdint.h>
#include <string.h>

enum { MOST_STATES = 8, MOST_COMPONENTS = 3, MOST_CONTROLS = 2, MOST_STEPS = 200 };

/* In physical units, matrices by rows */
typedef struct {
    int n, m, l, noises, correlated, steps;
    double A[64], B[16], F[64], H[24], R[9]; /* Q = F F', F n x noises */
    double x0[8], S0[64];                    /* P0 = S0 S0' */
    double z[MOST_STEPS][3], u[MOST_STEPS][2];
    uint32_t present[MOST_STEPS];
    double scale[8], unit[3];
} word_model;

static uint64_t random_state;

static inline double uniform(double from, double to)
{
    uint64_t a = random_state += UINT64_C(0x9e3779b97f4a7c15);
    a = (a ^ a >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    a = (a ^ a >> 27) * UINT64_C(0x94d049bb133111eb);
    return from + (to - from) * (double)((a ^ a >> 31) >> 11) * 0x1p-53;
}

static inline int below(int count) { return (int)uniform(0, count); }

static inline double decades(double from, double to) { return pow(10, uniform(from, to)); }

static inline double normal(void)
{
    double total = 0;
    for (int k = 0; k < 12; k++) total += uniform(-0.5, 0.5);
    return total;
}

/* A rotation of rows i and j */
static inline void turn_rows(double *A, int n, int i, int j, double angle)
{
    for (int k = 0; k < n; k++) {
        const double a = A[i * n + k], b = A[j * n + k];
        A[i * n + k] = cos(angle) * a - sin(angle) * b;
        A[j * n + k] = sin(angle) * a + cos(angle) * b;
    }
}

/* Kinematic, or rotations with decay, or dense and stable */
static inline void draw_transition(word_model *w)
{
    const int n = w->n, kind = below(3);
    const double dt = decades(-1.5, 0);
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            double a = i == j;
            if (kind == 0 && j > i) a = j - i > 3 ? 0 : pow(dt, j - i) / tgamma(j - i + 1);
            if (kind == 1 && i == j) a = uniform(0.8, 1);
            if (kind == 2) a = normal() * 0.6 / sqrt(n);
            w->A[i * n + j] = a;
        }
    }
    for (int k = 0; kind == 1 && n > 1 && k < 2 * n; k++) {
        const int i = below(n), j = below(n);
        if (i != j) turn_rows(w->A, n, i, j, uniform(-1, 1));
    }
}

static inline void draw_matrix(double *M, int rows, int columns, double size, double density)
{
    for (int k = 0; k < rows * columns; k++) {
        M[k] = uniform(0, 1) < density ? size * normal() : 0;
    }
}

static inline void draw_measurement(word_model *w)
{
    const int n = w->n, m = w->m, select = below(2);
    double L[9];
    draw_matrix(w->H, m, n, 1, select ? 0 : 0.8);
    for (int c = 0; c < m; c++) {
        if (select) w->H[c * n + below(n)] = 1;
        w->unit[c] = decades(-4, 4);
    }
    draw_matrix(L, m, m, 1, 1);
    w->correlated = m > 1 && below(2);
    const double size = decades(-3, 0);
    for (int c = 0; c < m; c++) {
        for (int j = 0; j < m; j++) {
            double r = c == j ? 0.01 : 0;
            for (int k = 0; k < m; k++) r += L[c * m + k] * L[j * m + k];
            w->R[c * m + j] = c == j || w->correlated ? r * size * size : 0;
        }
    }
}

/* The states' and measurements' units */
static inline void rescale(word_model *w)
{
    const int n = w->n, m = w->m;
    for (int i = 0; i < n; i++) w->scale[i] = decades(-4, 4);
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            w->A[i * n + j] *= w->scale[i] / w->scale[j];
            w->S0[i * n + j] *= w->scale[i];
        }
        for (int k = 0; k < w->l; k++) w->B[i * w->l + k] *= w->scale[i];
        for (int k = 0; k < w->noises; k++) w->F[i * w->noises + k] *= w->scale[i];
        w->x0[i] *= w->scale[i];
    }
    for (int c = 0; c < m; c++) {
        for (int i = 0; i < n; i++) w->H[c * n + i] *= w->unit[c] / w->scale[i];
        for (int j = 0; j < m; j++) w->R[c * m + j] *= w->unit[c] * w->unit[j];
    }
}

static inline void times(double *out, const double *M, const double *x, int rows, int columns)
{
    for (int i = 0; i < rows; i++) {
        for (int k = 0; k < columns; k++) out[i] += M[i * columns + k] * x[k];
    }
}

/* Lower triangular L of R = L L' */
static inline void cholesky(double *L, const double *R, int m)
{
    for (int i = 0; i < m; i++) {
        for (int j = 0; j < m; j++) {
            double a = R[i * m + j];
            for (int k = 0; k < j; k++) a -= L[i * m + k] * L[j * m + k];
            L[i * m + j] = j > i ? 0 : j == i ? sqrt(a) : a / L[j * m + j];
        }
    }
}

/* Data of the model, its true state beginning within `share` of the prior's sigma */
static inline void simulate(word_model *w, double share)
{
    double x[8] = {0}, next[8], v[8], L[9];
    for (int i = 0; i < w->n; i++) v[i] = share * normal();
    memcpy(x, w->x0, sizeof x);
    times(x, w->S0, v, w->n, w->n);
    cholesky(L, w->R, w->m);
    for (int t = 0; t < w->steps; t++) {
        for (int c = 0; c < w->m; c++) v[c] = normal();
        memset(w->z[t], 0, sizeof w->z[t]);
        times(w->z[t], w->H, x, w->m, w->n);
        times(w->z[t], L, v, w->m, w->m);
        w->present[t] = below(10) ? UINT32_MAX : (uint32_t)below(1 << w->m);
        memset(next, 0, sizeof next);
        times(next, w->A, x, w->n, w->n);
        for (int k = 0; k < w->l; k++) w->u[t][k] = normal();
        times(next, w->B, w->u[t], w->n, w->l);
        for (int k = 0; k < w->noises; k++) v[k] = normal();
        times(next, w->F, v, w->n, w->noises);
        memcpy(x, next, sizeof x);
    }
}

static inline void draw_model(word_model *w, uint64_t seed)
{
    random_state = seed * UINT64_C(0x2545f4914f6cdd1d) + 1;
    memset(w, 0, sizeof *w);
    w->n = 1 + below(MOST_STATES);
    w->m = 1 + below(MOST_COMPONENTS);
    w->l = below(MOST_CONTROLS + 1);
    w->noises = below(w->n + 1);
    w->steps = 20 + below(MOST_STEPS - 19);
    draw_transition(w);
    draw_matrix(w->B, w->n, w->l, 0.3, 0.5);
    draw_matrix(w->F, w->n, w->noises, decades(-3, 0), 0.7);
    draw_measurement(w);
    const double wide = decades(0, 4);
    draw_matrix(w->S0, w->n, w->n, wide / sqrt(w->n), 1);
    for (int i = 0; i < w->n; i++) w->x0[i] = normal();
    rescale(w);
    simulate(w, below(2) ? 1 : 1 / wide);
}

#endif
