/*
 * The textbook filter and smoother (Bryson and Frazier's, which inverts no P) in __float128.
 */
#ifndef KALMANQ_TESTS_WORD_TEXTBOOK_H
#define KALMANQ_TESTS_WORD_TEXTBOOK_H

#include <quadmath.h>

#include "word_models.h"

typedef __float128 quad;

/* A model as it is held, in the unit of the words */
typedef struct {
    int n, m, l, steps;
    quad A[64], B[16], Q[64], H[24], R[9], x0[8], P0[64];
    quad z[MOST_STEPS][3], u[MOST_STEPS][2];
    uint32_t present[MOST_STEPS];
} quad_model;

typedef struct {
    quad x[8], P[64];             /* filtered */
    quad before[8];               /* predicted */
    quad h[24], K[24], S[9], e[3]; /* of the components present */
    int m;
    quad smoothed[8], variance[8];
} quad_step;

/* out = M N, or M N' */
static inline void multiply(quad *out, const quad *M, const quad *N, int rows, int inner,
                            int columns, int transposed)
{
    for (int i = 0; i < rows; i++) {
        for (int j = 0; j < columns; j++) {
            quad total = 0;
            for (int k = 0; k < inner; k++) {
                total += M[i * inner + k] * N[transposed ? j * inner + k : k * columns + j];
            }
            out[i * columns + j] = total;
        }
    }
}

/* S <- S^-1, symmetric and positive */
static inline void invert(quad *S, int m)
{
    for (int k = 0; k < m; k++) {
        const quad pivot = 1 / S[k * m + k];
        S[k * m + k] = 1;
        for (int j = 0; j < m; j++) S[k * m + j] *= pivot;
        for (int i = 0; i < m; i++) {
            if (i == k) continue;
            const quad factor = S[i * m + k];
            S[i * m + k] = 0;
            for (int j = 0; j < m; j++) S[i * m + j] -= factor * S[k * m + j];
        }
    }
}

/* The rows of H, R and z that are present; returns their number. */
static inline int take_present(quad_step *s, quad *R, const quad_model *w, int t)
{
    int m = 0, of[3];
    for (int c = 0; c < w->m; c++) {
        if (w->present[t] >> c & 1) of[m++] = c;
    }
    for (int c = 0; c < m; c++) {
        s->e[c] = w->z[t][of[c]];
        for (int k = 0; k < w->n; k++) s->h[c * w->n + k] = w->H[of[c] * w->n + k];
        for (int j = 0; j < m; j++) R[c * m + j] = w->R[of[c] * w->m + of[j]];
    }
    return m;
}

static inline void quad_update(quad_step *s, const quad_model *w, int t)
{
    const int n = w->n;
    quad R[9], PH[24], C[64], T[64], KR[24];
    const int m = s->m = take_present(s, R, w, t);
    memcpy(s->before, s->x, sizeof s->x);
    if (m == 0) return;
    multiply(PH, s->P, s->h, n, n, m, 1);
    multiply(s->S, s->h, PH, m, n, m, 0);
    for (int k = 0; k < m * m; k++) s->S[k] += R[k];
    invert(s->S, m);
    multiply(s->K, PH, s->S, n, m, m, 0);
    for (int c = 0; c < m; c++) {
        for (int k = 0; k < n; k++) s->e[c] -= s->h[c * n + k] * s->before[k];
    }
    for (int i = 0; i < n; i++) {
        for (int c = 0; c < m; c++) s->x[i] += s->K[i * m + c] * s->e[c];
    }
    multiply(C, s->K, s->h, n, m, n, 0);
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) C[i * n + j] = (i == j) - C[i * n + j];
    }
    multiply(T, C, s->P, n, n, n, 0);
    multiply(s->P, T, C, n, n, n, 1);
    multiply(KR, s->K, R, n, m, m, 0);
    multiply(T, KR, s->K, n, m, n, 1);
    for (int k = 0; k < n * n; k++) s->P[k] += T[k];
}

static inline void quad_predict(quad_step *next, const quad_step *s, const quad_model *w, int t)
{
    const int n = w->n;
    quad T[64];
    multiply(next->x, w->A, s->x, n, n, 1, 0);
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < w->l; k++) next->x[i] += w->B[i * w->l + k] * w->u[t][k];
    }
    multiply(T, w->A, s->P, n, n, n, 0);
    multiply(next->P, T, w->A, n, n, n, 1);
    for (int k = 0; k < n * n; k++) next->P[k] += w->Q[k];
}

static inline void quad_filter(quad_step *s, const quad_model *w)
{
    memcpy(s[0].x, w->x0, sizeof s[0].x);
    memcpy(s[0].P, w->P0, sizeof s[0].P);
    for (int t = 0; t < w->steps; t++) {
        if (t) quad_predict(s + t, s + t - 1, w, t - 1);
        quad_update(s + t, w, t);
    }
}

/* (lambda, Lambda) back through the update and the predict before it */
static inline void quad_back(quad *lambda, quad *L, const quad_step *s, const quad_model *w)
{
    const int n = w->n, m = s->m;
    quad C[64], T[64], V[64], HS[24], a[8];
    multiply(C, s->K, s->h, n, m, n, 0);
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) C[i * n + j] = (i == j) - (m ? C[i * n + j] : 0);
    }
    multiply(T, L, C, n, n, n, 0);
    for (int i = 0; i < n; i++) {
        a[i] = 0;
        for (int k = 0; k < n; k++) a[i] += C[k * n + i] * lambda[k];
        for (int c = 0; c < m; c++) {
            HS[i * m + c] = 0;
            for (int k = 0; k < m; k++) HS[i * m + c] += s->h[k * n + i] * s->S[k * m + c];
            a[i] -= HS[i * m + c] * s->e[c];
        }
    }
    multiply(V, HS, s->h, n, m, n, 0);
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            for (int k = 0; k < n; k++) V[i * n + j] += C[k * n + i] * T[k * n + j];
        }
    }
    multiply(T, V, w->A, n, n, n, 0);
    for (int i = 0; i < n; i++) {
        lambda[i] = 0;
        for (int k = 0; k < n; k++) lambda[i] += w->A[k * n + i] * a[k];
        for (int j = 0; j < n; j++) {
            L[i * n + j] = 0;
            for (int k = 0; k < n; k++) L[i * n + j] += w->A[k * n + i] * T[k * n + j];
        }
    }
}

static inline void quad_smooth(quad_step *s, const quad_model *w)
{
    const int n = w->n;
    quad lambda[8] = {0}, L[64] = {0}, T[64];
    for (int t = w->steps - 1; t >= 0; t--) {
        if (t < w->steps - 1) quad_back(lambda, L, s + t + 1, w);
        multiply(T, s[t].P, L, n, n, n, 0);
        for (int i = 0; i < n; i++) {
            s[t].smoothed[i] = s[t].x[i];
            s[t].variance[i] = s[t].P[i * n + i];
            for (int k = 0; k < n; k++) {
                s[t].smoothed[i] -= s[t].P[i * n + k] * lambda[k];
                s[t].variance[i] -= T[i * n + k] * s[t].P[k * n + i];
            }
        }
    }
}

#endif
