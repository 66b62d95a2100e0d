/*
 * Models in floating point: process, sensor and prior checked, the roots of their noises made.
 * (The q31 arithmetic has tables instead: tables_q31.h.)
 */
#ifndef KQ_SRC_MODEL_MATRICES_FLOAT_H
#define KQ_SRC_MODEL_MATRICES_FLOAT_H

#include "factor_float.h"
#include "sensor.h"
#include "units_float.h"

/* Is P a covariance?  Entries finite, variances >= 0, P = P' up to 8 eps of sigma_i sigma_j. */
KQ_COLD static kq_status covariance_check(const num *P, int n)
{
    if (!all_finite(P, n * n)) return KQ_ERR_NOT_FINITE;
    for (int i = 0; i < n; i++) {
        if (P[i * n + i] < 0) return KQ_ERR_NOT_SEMIDEFINITE;
    }
    for (int i = 0; i < n; i++) {
        for (int j = i + 1; j < n; j++) {
            const num scale = num_root(P[i * n + i]) * num_root(P[j * n + j]);
            const num difference = num_magnitude(P[i * n + j] - P[j * n + i]);
            if (difference > 8 * num_epsilon * scale) return KQ_ERR_NOT_SYMMETRIC;
        }
    }
    return KQ_OK;
}

/* Of a process or a prior: no variance is beyond what predict holds (arithmetic/saturate_float.h). */
KQ_COLD static kq_status largest_variance_check(const num *P, int n)
{
    for (int i = 0; i < n; i++) {
        if (P[i * n + i] > num_most_sigma * num_most_sigma) return KQ_ERR_RANGE;
    }
    return KQ_OK;
}

KQ_COLD static kq_status state_covariance_check(const num *P, int n)
{
    const kq_status status = covariance_check(P, n);
    return status ? status : largest_variance_check(P, n);
}

/* Is F, n x r, finite, and no variance of F F' beyond what predict holds?  An infinite square is. */
KQ_COLD static kq_status factor_check(const num *F, int n, int r)
{
    if (!all_finite(F, n * r)) return KQ_ERR_NOT_FINITE;
    for (int i = 0; i < n; i++) {
        if (!(dot(0, F + i * r, F + i * r, r) <= num_most_sigma * num_most_sigma))
            return KQ_ERR_RANGE;
    }
    return KQ_OK;
}

/* A root: finite, its diagonal not negative, no sigma beyond what predict holds */
KQ_COLD static kq_status root_check(const num *S, int n)
{
    if (!all_finite(S, KQ_TRIANGLE(n))) return KQ_ERR_NOT_FINITE;
    for (int i = 0; i < n; i++) {
        if (S[column(i) + i] < 0) return KQ_ERR_NOT_SEMIDEFINITE;
        if (!(root_product(S, n, i, i) <= num_most_sigma * num_most_sigma)) return KQ_ERR_RANGE;
    }
    return KQ_OK;
}

/* ------------------------------------------------------------------ process */

/* `others` of its controls have no column of B. */
KQ_COLD static kq_status process_check_given(const process *p, const num *A, const num *B, int others)
{
    if (!p || !A) return KQ_ERR_NULL;
    const int n = p->states, l = p->controls - others;
    if (!size_is_valid(n) || p->controls > KQ_SIZE_MAX || l < 0) return KQ_ERR_SIZE;
    if (!p->memory || p->length < (unsigned)KQ_PROCESS_LEN(n)) return KQ_ERR_MEMORY;
    if (l && !B) return KQ_ERR_NULL;
    if (!all_finite(A, n * n) || (l && !all_finite(B, n * l))) return KQ_ERR_NOT_FINITE;
    return KQ_OK;
}

KQ_COLD static kq_status process_check_model(const process *p, const num *A, const num *B)
{
    return process_check_given(p, A, B, 0);
}

/* With the noise's root, which is in its memory.  A pivot of it is never 0: predict divides by what it
   leads to. */
KQ_COLD static void process_set_model(process *p, const num *A, const num *B)
{
    const int n = p->states;
    for (int i = 0; i < n; i++) {
        num *pivot = p->memory + column(i) + i;
        if (*pivot < num_tiny_root) *pivot = num_tiny_root;
    }
    p->noise_root = p->memory;
    p->control = p->controls ? B : 0;
    process_set_transition(p, A);
}

/* ------------------------------------------------------------------ sensor */

KQ_COLD static kq_status sensor_check_model(const sensor *s, const num *H, const num *R, int length)
{
    if (!s || !H || !R) return KQ_ERR_NULL;
    if (!size_is_valid(s->states) || !size_is_valid(s->components)) return KQ_ERR_SIZE;
    if (!s->memory || s->length < (unsigned)length) return KQ_ERR_MEMORY;
    if (!all_finite(H, s->components * s->states)) return KQ_ERR_NOT_FINITE;
    return KQ_OK;
}

/* A root of R into M and D; a variance is at least num_tiny. */
KQ_COLD static void decorrelate_root(num *M, int m)
{
    for (int j = 0; j < m; j++) {
        const num root = M[column(j) + j];
        for (int i = 0; i < j && root > 0; i++) M[column(j) + i] /= root;
        M[column(j) + j] = root * root > num_tiny ? root * root : num_tiny;
    }
    invert_unit(M, m);
}

/* A root of R into M and D.  R's variances are rounded to eps, and so is what the other components
   leave of one: up to 8 m eps of it there is no noise. */
KQ_COLD static void decorrelate(num *M, int m)
{
    drop_pivots(M, m, num_root((num)(8 * m) * num_epsilon));
    decorrelate_root(M, m);
}

KQ_COLD static int is_diagonal(const num *R, int m)
{
    for (int i = 0; i < m; i++) {
        for (int j = 0; j < m; j++) {
            if (i != j && R[i * m + j] != 0) return 0;
        }
    }
    return 1;
}

/* variances: m of them, `stride` apart */
KQ_COLD static void sensor_set_diagonal(sensor *s, const sensor_kind *kind, const num *H,
                                        const num *variances, int stride)
{
    for (int c = 0; c < s->components; c++) {
        const num r = variances[c * stride];
        s->memory[c] = r > num_tiny ? r : num_tiny;
    }
    s->noise = s->memory;
    sensor_set_measurement(s, H);
    s->covariance = 0;
    s->kind = kind;
    sensor_set_plain(s);
}

/* A sensor whose R has correlations: R decorrelated, M and D, is in the sensor's memory. */
KQ_COLD static void sensor_set_correlated(sensor *s, const num *H, const num *R)
{
    s->noise = s->memory;
    sensor_set_measurement(s, H);
    s->covariance = R;
    s->kind = &T(kq_sensor_correlated);
    sensor_set_plain(s);
}

KQ_COLD static kq_status sensor_init_diagonal(sensor *s, const sensor_kind *kind, const num *H,
                                              const num *r)
{
    const kq_status status = sensor_check_model(s, H, r, s ? s->components : 0);
    if (status) return status;
    if (!all_finite(r, s->components)) return KQ_ERR_NOT_FINITE;
    for (int c = 0; c < s->components; c++) {
        if (r[c] < 0) return KQ_ERR_NOT_SEMIDEFINITE;
    }
    sensor_set_diagonal(s, kind, H, r, 1);
    return KQ_OK;
}

/* R_jc */
KQ_COLD static num noise_entry(const sensor *s, int j, int c)
{
    if (s->covariance) return s->covariance[j * s->components + c];
    return j == c ? s->noise[c] : 0;
}

/* The decorrelated noise of the components present alone, made anew */
KQ_COLD static void noise_of_present(num *noise, const sensor *s, uint32_t present)
{
    root_of_covariance(noise, s->covariance, s->components, present);
    decorrelate(noise, s->components);
}

#endif
