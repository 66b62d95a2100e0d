/*
 * A random model in fixed point, ranges declared as 1.5 times the largest exact state: the library
 * and the textbook on the very numbers that its tables hold.
 */
#ifndef KALMANQ_TESTS_WORD_RUN_H
#define KALMANQ_TESTS_WORD_RUN_H

#include "kalmanq/kalmanq.h"
#include "kalmanq/prepare.h"

#include "word_textbook.h"

static kq_format_q31 state_format[8], measurement_format[3], control_format[2];
static kq_scaled_q31 transition[64], control[16], measurement[24], noise[9];
static int32_t noise_root[KQ_ROOT_LEN_Q31(8)], prior_root[KQ_ROOT_LEN_Q31(8)], prior_mean[8];
static int32_t measured[MOST_STEPS][3], controls[MOST_STEPS][2];

static kq_process_q31 motion;
static kq_sensor_q31 sensor;
static kq_prior_table_q31 prior;

static inline quad absolute(quad a) { return a < 0 ? -a : a; }

static inline quad larger(quad a, quad b) { return a < b ? b : a; }

/* The model as it was drawn */
static inline void quad_of_model(quad_model *q, const word_model *w)
{
    memset(q, 0, sizeof *q);
    q->n = w->n, q->m = w->m, q->l = w->l, q->steps = w->steps;
    quad F[64], S0[64];
    for (int k = 0; k < w->n * w->n; k++) q->A[k] = w->A[k], S0[k] = w->S0[k];
    for (int k = 0; k < w->n * w->l; k++) q->B[k] = w->B[k];
    for (int k = 0; k < w->n * w->noises; k++) F[k] = w->F[k];
    for (int k = 0; k < w->m * w->n; k++) q->H[k] = w->H[k];
    for (int k = 0; k < w->m * w->m; k++) q->R[k] = w->R[k];
    for (int k = 0; k < w->n; k++) q->x0[k] = w->x0[k];
    multiply(q->Q, F, F, w->n, w->noises, w->n, 1);
    multiply(q->P0, S0, S0, w->n, w->n, w->n, 1);
    for (int t = 0; t < w->steps; t++) {
        q->present[t] = w->present[t];
        for (int c = 0; c < w->m; c++) q->z[t][c] = w->z[t][c];
        for (int k = 0; k < w->l; k++) q->u[t][k] = w->u[t][k];
    }
}

/* The largest state of a run: predicted, filtered, smoothed */
static inline void largest_states(quad *most, const quad_step *s, const quad_model *q)
{
    for (int i = 0; i < q->n; i++) {
        most[i] = absolute(q->x0[i]);
        for (int t = 0; t < q->steps; t++) {
            most[i] = larger(most[i], absolute(s[t].x[i]));
            most[i] = larger(most[i], absolute(s[t].before[i]));
            most[i] = larger(most[i], absolute(s[t].smoothed[i]));
        }
    }
}

/* room: by how much the ranges are wider than 1.5 times what is in them */
static inline int choose_formats(const word_model *w, const quad_step *s, const quad_model *q,
                                 double room)
{
    quad most[8];
    int status = 0;
    largest_states(most, s, q);
    for (int i = 0; i < w->n; i++) {
        status |= kq_format_prepare_q31(state_format + i, KQ_FRACTION_BEST_Q31, 1.5 * room * (double)most[i], NULL);
    }
    for (int c = 0; c < w->m; c++) {
        double range = 1e-300;
        for (int t = 0; t < w->steps; t++) range = fmax(range, fabs(w->z[t][c]));
        status |= kq_format_prepare_q31(measurement_format + c, KQ_FRACTION_BEST_Q31, 1.5 * room * range, NULL);
    }
    for (int k = 0; k < w->l; k++) status |= kq_format_prepare_q31(control_format + k, KQ_FRACTION_BEST_Q31, 8, NULL);
    return status;
}

static inline int prepare_tables(const word_model *w)
{
    const int n = w->n, m = w->m, l = w->l;
    int status = kq_matrix_prepare_q31(transition, w->A, n, n, state_format, state_format);
    if (l) status |= kq_matrix_prepare_q31(control, w->B, n, l, state_format, control_format);
    status |= kq_matrix_prepare_q31(measurement, w->H, m, n, measurement_format, state_format);
    status |= kq_root_prepare_factor_q31(noise_root, w->F, n, w->noises, state_format);
    status |= kq_root_prepare_factor_q31(prior_root, w->S0, n, n, state_format);
    double variances[3];
    for (int c = 0; c < m; c++) variances[c] = w->R[c * m + c];
    status |= w->correlated ? kq_noise_prepare_q31(noise, w->R, m, measurement_format)
                            : kq_noise_prepare_diagonal_q31(noise, variances, m, measurement_format);
    status |= kq_vector_prepare_q31(prior_mean, w->x0, n, state_format, NULL);
    for (int t = 0; t < w->steps; t++) {
        status |= kq_vector_prepare_q31(measured[t], w->z[t], m, measurement_format, NULL);
        if (l) status |= kq_vector_prepare_q31(controls[t], w->u[t], l, control_format, NULL);
    }
    return status;
}

static inline int init_objects(const word_model *w)
{
    const kq_process_table_q31 p = {w->n, w->l, state_format, control_format,
                                    transition, control, noise_root};
    const kq_sensor_table_q31 s = {w->n, w->m, w->correlated, state_format, measurement_format,
                                   measurement, noise};
    prior = (kq_prior_table_q31){w->n, state_format, prior_mean, prior_root};
    return kq_process_init_q31(&motion, &p, NULL) | kq_sensor_init_q31(&sensor, &s, NULL);
}

static inline quad quad_of(kq_scaled_q31 a) { return scalbnq(a.mantissa, a.exponent); }

/* P of a root's words */
static inline void quad_of_root(quad *P, const int32_t *root, int n)
{
    quad S[64] = {0};
    for (int i = 0; i < n; i++) {
        for (int j = i; j < n; j++) {
            S[i * n + j] = scalbnq(root[j * (j + 1) / 2 + i], root[n * (n + 1) / 2 + i]);
        }
    }
    multiply(P, S, S, n, n, n, 1);
}

/* R = U D U' */
static inline void quad_of_noise(quad *R, const word_model *w)
{
    const int m = w->m;
    for (int i = 0; i < m; i++) {
        for (int j = 0; j < m; j++) {
            R[i * m + j] = i == j && !w->correlated ? quad_of(noise[i]) : 0;
            for (int k = i > j ? i : j; w->correlated && k < m; k++) {
                const kq_scaled_q31 *c = noise + k * (k + 1) / 2;
                R[i * m + j] += quad_of(c[k]) * (i < k ? quad_of(c[i]) : 1) *
                                (j < k ? quad_of(c[j]) : 1);
            }
        }
    }
}

/* The model as the tables hold it */
static inline void quad_of_words(quad_model *q, const word_model *w)
{
    memset(q, 0, sizeof *q);
    q->n = w->n, q->m = w->m, q->l = w->l, q->steps = w->steps;
    for (int k = 0; k < w->n * w->n; k++) q->A[k] = quad_of(transition[k]);
    for (int k = 0; k < w->n * w->l; k++) q->B[k] = quad_of(control[k]);
    for (int k = 0; k < w->m * w->n; k++) q->H[k] = quad_of(measurement[k]);
    for (int k = 0; k < w->n; k++) q->x0[k] = prior_mean[k];
    quad_of_root(q->Q, noise_root, w->n);
    quad_of_root(q->P0, prior_root, w->n);
    quad_of_noise(q->R, w);
    for (int t = 0; t < w->steps; t++) {
        q->present[t] = w->present[t];
        for (int c = 0; c < w->m; c++) q->z[t][c] = measured[t][c];
        for (int k = 0; k < w->l; k++) q->u[t][k] = controls[t][k];
    }
}

#endif
