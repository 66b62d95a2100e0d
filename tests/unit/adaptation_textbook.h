/*
 * Recursive maximum likelihood of the noise scales as adaptation.h has it, in double: two states,
 * two components, scalar measurement by scalar measurement, with P and its slope in full.
 */
#ifndef KALMANQ_TESTS_ADAPTATION_TEXTBOOK_H
#define KALMANQ_TESTS_ADAPTATION_TEXTBOOK_H

#include <math.h>
#include <stdint.h>

typedef struct {
    double A[4], Q[4], H[4], R[4];
    double x[2], P[4]; /* the filter */
    double d[2], D[4]; /* their slopes with log q */
    double q, r;
    double J[3]; /* qq, qr, rr */
    double g[2]; /* the last update's scores */
    int waiting;
} scale_textbook;

/* M <- A M A' + c Q */
static inline void textbook_move(double *M, const double *A, double c, const double *Q)
{
    double T[4];
    for (int i = 0; i < 2; i++) {
        for (int j = 0; j < 2; j++) T[2 * i + j] = A[2 * i] * M[j] + A[2 * i + 1] * M[2 + j];
    }
    for (int i = 0; i < 2; i++) {
        for (int j = 0; j < 2; j++) {
            M[2 * i + j] = T[2 * i] * A[2 * j] + T[2 * i + 1] * A[2 * j + 1] + c * Q[2 * i + j];
        }
    }
}

static inline void textbook_turn(double *v, const double *A)
{
    const double a = A[0] * v[0] + A[1] * v[1];
    v[1] = A[2] * v[0] + A[3] * v[1];
    v[0] = a;
}

static inline void textbook_predict(scale_textbook *t)
{
    textbook_move(t->P, t->A, t->q, t->Q);
    textbook_move(t->D, t->A, t->q, t->Q);
    textbook_turn(t->x, t->A);
    textbook_turn(t->d, t->A);
}

/* A scalar measurement h x + v, v ~ N(0, r); adds its scores and its information. */
static inline void textbook_scalar(scale_textbook *t, const double *h, double z, double r,
                                   double *J)
{
    static const double none[4];
    const double Ph[] = {t->P[0] * h[0] + t->P[1] * h[1], t->P[2] * h[0] + t->P[3] * h[1]};
    const double Dh[] = {t->D[0] * h[0] + t->D[1] * h[1], t->D[2] * h[0] + t->D[3] * h[1]};
    const double s = h[0] * Ph[0] + h[1] * Ph[1] + r, sigma = sqrt(s);
    const double K[] = {Ph[0] / s, Ph[1] / s};
    const double left[] = {1 - K[0] * h[0], -K[0] * h[1], -K[1] * h[0], 1 - K[1] * h[1]};
    const double e = z - h[0] * t->x[0] - h[1] * t->x[1];
    const double nu = fmax(-4, fmin(4, e / sigma));
    const double a = (h[0] * Dh[0] + h[1] * Dh[1]) / s;
    const double y = fmax(-4, fmin(4, (h[0] * t->d[0] + h[1] * t->d[1]) / sigma));
    t->g[0] += a * (nu * nu - 1) / 2 + nu * y;
    t->g[1] += (1 - a) * (nu * nu - 1) / 2 - nu * y;
    J[0] += a * a / 2 + y * y;
    J[1] += a * (1 - a) / 2 - y * y;
    J[2] += (1 - a) * (1 - a) / 2 + y * y;
    for (int i = 0; i < 2; i++) t->d[i] += Dh[i] * nu / sigma;
    textbook_turn(t->d, left);
    textbook_move(t->D, left, 0, none);
    textbook_move(t->P, left, 0, none);
    for (int i = 0; i < 4; i++) t->P[i] += K[i / 2] * r * K[i % 2];
    for (int i = 0; i < 2; i++) t->x[i] += K[i] * e;
}

/* R = [a b; b c]: z_0 - (b / c) z_1 has the noise a - b b / c, independent of z_1. */
static inline int textbook_measure(scale_textbook *t, const double *z, uint32_t present, double *J)
{
    const double b = (present & 3) == 3 ? t->R[1] / t->R[3] : 0;
    const double h[] = {t->H[0] - b * t->H[2], t->H[1] - b * t->H[3]};
    t->g[0] = t->g[1] = 0;
    if (present & 1) textbook_scalar(t, h, z[0] - b * z[1], t->r * (t->R[0] - b * t->R[1]), J);
    if (present & 2) textbook_scalar(t, t->H + 2, z[1], t->r * t->R[3], J);
    return (int)(present & 1) + (int)(present >> 1 & 1);
}

static inline double textbook_scale(double scale, double move, double step)
{
    move = fmax(-step, fmin(step, move));
    return move < 0 ? scale / (1 - move) : scale * (1 + move);
}

/* which: 0 both, 1 q, 2 r */
static inline void textbook_update(scale_textbook *t, const double *z, uint32_t present, int which,
                                   double memory, double step)
{
    double J[3] = {0, 0, 0};
    const int count = textbook_measure(t, z, present, J);
    if (t->waiting > 0) {
        t->waiting -= count;
        return;
    }
    if (count == 0) return;
    for (int k = 0; k < 3; k++) t->J[k] = (1 - 1 / memory) * t->J[k] + J[k];
    const double qq = t->J[0] + 4, rr = t->J[2] + 4, qr = which == 0 ? t->J[1] : 0;
    const double determinant = qq * rr - qr * qr;
    const double to_q = (rr * t->g[0] - qr * t->g[1]) / determinant;
    const double to_r = (qq * t->g[1] - qr * t->g[0]) / determinant;
    if (which != 2) t->q = textbook_scale(t->q, to_q, step);
    if (which != 1) t->r = textbook_scale(t->r, to_r, step);
}

#endif
