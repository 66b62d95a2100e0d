/*
 * Model builders.  Each checks all that it was given, then writes; a model's arrays begin as zeros.
 */
#ifndef KQ_SRC_STATISTICS_MODELS_FLOAT_H
#define KQ_SRC_STATISTICS_MODELS_FLOAT_H

#include <stddef.h>
#include <stdint.h>

#include "kalmanq/models.h"
#include "kalmanq/size.h"
#include "kalmanq/status.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/compiler.h"
#include "../arithmetic/matrix_float.h"
#include "../arithmetic/root.h"
#include "../arithmetic/rows.h"
#include "../arithmetic/size.h"
#include "../model/units.h"

typedef T(kq_model) model;

/* ------------------------------------------------------------------ the arrays */

kq_status T(kq_model_assign)(model *made, int n, int r, int m, num *memory, size_t length)
{
    if (!made || !memory) return KQ_ERR_NULL;
    if (!size_is_valid(n) || !size_is_valid(r) || !size_is_valid(m)) return KQ_ERR_SIZE;
    if (length < (size_t)KQ_MODEL_LEN(n, r, m)) return KQ_ERR_MEMORY;
    made->states = (uint8_t)n;
    made->noises = (uint8_t)r;
    made->components = (uint8_t)m;
    made->A = memory;
    made->F = made->A + n * n;
    made->H = made->F + n * r;
    made->R = made->H + m * n;
    made->x0 = made->R + m;
    made->P0 = made->x0 + n;
    return KQ_OK;
}

/* Has it n states, r noises and m components? */
static kq_status model_check(const model *made, int n, int r, int m)
{
    if (!made) return KQ_ERR_NULL;
    if (!size_is_valid(n) || !size_is_valid(r) || !size_is_valid(m)) return KQ_ERR_SIZE;
    if (!made->A || !made->F || !made->H || !made->R || !made->x0 || !made->P0) {
        return KQ_ERR_MEMORY;
    }
    if (made->states != n || made->noises != r || made->components != m) return KQ_ERR_MISMATCH;
    return KQ_OK;
}

static kq_status variances_check(const num *variance, int count)
{
    if (!variance) return KQ_ERR_NULL;
    if (!all_finite(variance, count)) return KQ_ERR_NOT_FINITE;
    for (int k = 0; k < count; k++) {
        if (variance[k] < 0) return KQ_ERR_NOT_SEMIDEFINITE;
    }
    return KQ_OK;
}

/* mean: n, or NULL */
static kq_status prior_values_check(const num *mean, const num *variance, int n)
{
    if (mean && !all_finite(mean, n)) return KQ_ERR_NOT_FINITE;
    return variances_check(variance, n);
}

static void fill(num *to, num value, int count)
{
    for (int k = 0; k < count; k++) to[k] = value;
}

static void model_clear(model *made)
{
    const int n = made->states, r = made->noises, m = made->components;
    fill(made->A, 0, n * n);
    fill(made->F, 0, n * r);
    fill(made->H, 0, m * n);
    fill(made->R, 0, m);
    fill(made->x0, 0, n);
    fill(made->P0, 0, n * n);
}

static void set_prior(model *made, const num *mean, const num *variance)
{
    const int n = made->states;
    for (int i = 0; i < n; i++) {
        if (mean) made->x0[i] = mean[i];
        made->P0[i * n + i] = variance[i];
    }
}

/* Noise `column` alone moves state i. */
static void set_drift(model *made, int i, int column, num variance)
{
    made->F[i * made->noises + column] = num_root(variance);
}

/* State i takes state k, as it was. */
static void set_link(model *made, int i, int k) { made->A[i * made->states + k] = 1; }

/* ------------------------------------------------------------------ ARMA */

/*
 * The autocovariances of an autoregression, `count` of them.  The partial autocorrelations k_j by
 * Durbin's recursion backwards, |k_j| < 1 if and only if it is stationary, and Levinson's recursion
 * forwards:
 *     gamma_0 = variance / prod (1 - k_j^2),   gamma_j = sum_i a_i gamma_j-i + k_j v,
 * a being the autoregression of order j - 1 and v its variance.
 */
static kq_status partial_autocorrelations(num *k, const num *phi, int p)
{
    copy(k, phi, p);
    for (int j = p - 1; j >= 0; j--) {
        const num own = k[j], rest = (1 - own) * (1 + own);
        if (!(rest > 0)) return KQ_ERR_NO_CONVERGENCE;
        for (int i = 0; 2 * i < j; i++) {
            const num a = k[i], b = k[j - 1 - i];
            k[i] = (a + own * b) / rest;
            k[j - 1 - i] = (b + own * a) / rest;
        }
    }
    return KQ_OK;
}

/* a, the autoregression of order j, gets the coefficient k of order j + 1. */
static void lengthen(num *a, int j, num k)
{
    for (int i = 0; 2 * i < j; i++) {
        const num front = a[i], back = a[j - 1 - i];
        a[i] = front - k * back;
        a[j - 1 - i] = back - k * front;
    }
    a[j] = k;
}

static kq_status autocovariances(num *gamma, int count, const num *phi, int p, num variance)
{
    num k[KQ_SIZE_MAX], a[KQ_SIZE_MAX];
    const kq_status status = partial_autocorrelations(k, phi, p);
    if (status) return status;
    gamma[0] = variance;
    for (int j = 0; j < p; j++) gamma[0] /= (1 - k[j]) * (1 + k[j]);
    num rest = gamma[0];
    for (int j = 1; j < count; j++) {
        const int known = j - 1 < p ? j - 1 : p;
        num sum = j <= p ? k[j - 1] * rest : 0;
        for (int i = 0; i < known; i++) sum += a[i] * gamma[j - 1 - i];
        gamma[j] = sum;
        if (j > p) continue;
        lengthen(a, j - 1, k[j - 1]);
        rest *= (1 - k[j - 1]) * (1 + k[j - 1]);
    }
    return all_finite(gamma, count) ? KQ_OK : KQ_ERR_NOT_FINITE;
}

static kq_status arma_check(const num *coefficients, int count, num variance, num noise)
{
    if (count && !coefficients) return KQ_ERR_NULL;
    if (count && !all_finite(coefficients, count)) return KQ_ERR_NOT_FINITE;
    const kq_status status = variances_check(&variance, 1);
    return status ? status : variances_check(&noise, 1);
}

kq_status T(kq_model_arma)(model *made, const num *phi, int p, const num *theta, int q,
                           num variance, num noise)
{
    num gamma[KQ_SIZE_MAX];
    if (p < 0 || p > KQ_SIZE_MAX || q < 0 || q >= KQ_SIZE_MAX) return KQ_ERR_SIZE;
    const int n = KQ_ARMA_STATES(p, q);
    kq_status status = model_check(made, n, 1, 1);
    if (!status) status = arma_check(phi, p, variance, noise);
    if (!status) status = arma_check(theta, q, variance, noise);
    if (!status) status = autocovariances(gamma, n, phi, p, variance);
    if (status) return status;
    model_clear(made);
    for (int j = 0; j < p; j++) made->A[j] = phi[j];
    for (int i = 1; i < n; i++) set_link(made, i, i - 1);
    set_drift(made, 0, 0, variance);
    made->H[0] = 1;
    for (int j = 0; j < q; j++) made->H[j + 1] = theta[j];
    made->R[0] = noise;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) made->P0[i * n + j] = gamma[i > j ? i - j : j - i];
    }
    return KQ_OK;
}

kq_status T(kq_model_ar)(model *made, const num *phi, int p, num variance, num noise)
{
    if (p < 1) return KQ_ERR_SIZE;
    return T(kq_model_arma)(made, phi, p, 0, 0, variance, noise);
}

kq_status T(kq_model_ma)(model *made, const num *theta, int q, num variance, num noise)
{
    if (q < 0 || q >= KQ_SIZE_MAX) return KQ_ERR_SIZE;
    const int n = q + 1;
    kq_status status = model_check(made, n, 1, 1);
    if (!status) status = arma_check(theta, q, variance, noise);
    if (status) return status;
    model_clear(made);
    for (int i = 0; i < q; i++) set_link(made, i, i + 1);
    set_drift(made, q, 0, variance);
    for (int j = 0; j < q; j++) made->H[j] = theta[q - 1 - j];
    made->H[q] = 1;
    made->R[0] = noise;
    for (int i = 0; i < n; i++) made->P0[i * n + i] = variance;
    return KQ_OK;
}

/* ------------------------------------------------------------------ structural models */

kq_status T(kq_model_regression)(model *made, const num *regressors, int k, const num *drift,
                                 num noise, const num *mean, const num *variance)
{
    kq_status status = model_check(made, k, k, 1);
    if (status) return status;
    if (!regressors) return KQ_ERR_NULL;
    if (!all_finite(regressors, k)) return KQ_ERR_NOT_FINITE;
    status = variances_check(drift, k);
    if (!status) status = variances_check(&noise, 1);
    if (!status) status = prior_values_check(mean, variance, k);
    if (status) return status;
    model_clear(made);
    for (int i = 0; i < k; i++) {
        set_link(made, i, i);
        set_drift(made, i, i, drift[i]);
        made->H[i] = regressors[i];
    }
    made->R[0] = noise;
    set_prior(made, mean, variance);
    return KQ_OK;
}

kq_status T(kq_model_level)(model *made, num drift, num noise, num mean, num variance)
{
    static const num one[] = {1};
    return T(kq_model_regression)(made, one, 1, &drift, noise, &mean, &variance);
}

/* The parts of a structural model: `drifts` noises, n states */
static kq_status structure_check(const model *made, int n, const num *drift, int drifts, num noise,
                                 const num *mean, const num *variance)
{
    kq_status status = model_check(made, n, drifts, 1);
    if (!status) status = variances_check(drift, drifts);
    if (!status) status = variances_check(&noise, 1);
    return status ? status : prior_values_check(mean, variance, n);
}

static void set_trend(model *made, const num *drift)
{
    set_link(made, 0, 0);
    set_link(made, 0, 1);
    set_link(made, 1, 1);
    set_drift(made, 0, 0, drift[0]);
    set_drift(made, 1, 1, drift[1]);
    made->H[0] = 1;
}

/* The effects are the states from `first` on, moved by noise `column`. */
static void set_season(model *made, int first, int column, num drift)
{
    const int n = made->states;
    fill(made->A + first * n + first, -1, n - first);
    for (int i = first + 1; i < n; i++) set_link(made, i, i - 1);
    set_drift(made, first, column, drift);
    made->H[first] = 1;
}

kq_status T(kq_model_trend)(model *made, const num *drift, num noise, const num *mean,
                            const num *variance)
{
    const kq_status status = structure_check(made, 2, drift, 2, noise, mean, variance);
    if (status) return status;
    model_clear(made);
    set_trend(made, drift);
    made->R[0] = noise;
    set_prior(made, mean, variance);
    return KQ_OK;
}

kq_status T(kq_model_season)(model *made, int seasons, num drift, num noise, const num *mean,
                             const num *variance)
{
    if (seasons < 2 || seasons > KQ_SIZE_MAX + 1) return KQ_ERR_SIZE;
    const kq_status status =
        structure_check(made, KQ_SEASON_STATES(seasons), &drift, 1, noise, mean, variance);
    if (status) return status;
    model_clear(made);
    set_season(made, 0, 0, drift);
    made->R[0] = noise;
    set_prior(made, mean, variance);
    return KQ_OK;
}

kq_status T(kq_model_trend_season)(model *made, int seasons, const num *drift, num noise,
                                   const num *mean, const num *variance)
{
    if (seasons < 2 || seasons >= KQ_SIZE_MAX) return KQ_ERR_SIZE;
    const kq_status status =
        structure_check(made, KQ_TREND_SEASON_STATES(seasons), drift, 3, noise, mean, variance);
    if (status) return status;
    model_clear(made);
    set_trend(made, drift);
    set_season(made, 2, 2, drift[2]);
    made->R[0] = noise;
    set_prior(made, mean, variance);
    return KQ_OK;
}

/* ------------------------------------------------------------------ stationary covariance */

/* P <- P + T M', which is symmetric */
static void add_image(num *restrict P, const num *restrict T, const num *restrict M, int n)
{
    for (int i = 0; i < n; i++) {
        for (int j = i; j < n; j++) {
            P[j * n + i] = P[i * n + j] += dot(0, T + i * n, M + j * n, n);
        }
    }
}

/* Is the rounding of M^2 below 1?  Where it is not, as at a double root of 1, M may vanish by it.
   Its diagonal tells, which no choice of units changes. */
static int square_is_good(const num *M, int n)
{
    num size = 0;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) size += num_magnitude(M[i * n + j] * M[j * n + i]);
    }
    return num_epsilon * size < 1;
}

static int is_nothing(const num *M, int count)
{
    for (int k = 0; k < count; k++) {
        if (!(num_magnitude(M[k]) < num_tiny_root)) return 0;
    }
    return 1;
}

/* P = F F' on entry.  M is used up, T is scratch. */
static kq_status sum_by_doubling(num *P, num *M, num *T, int n)
{
    for (int k = 0; k < num_doublings && square_is_good(M, n); k++) {
        multiply(T, M, P, n, n, n);
        add_image(P, T, M, n);
        multiply(T, M, M, n, n, n);
        copy(M, T, n * n);
        if (is_nothing(M, n * n)) return all_finite(P, n * n) ? KQ_OK : KQ_ERR_NOT_FINITE;
    }
    return KQ_ERR_NO_CONVERGENCE;
}

/* P = A P A' + Q; Q, n x n, is used up. */
KQ_NOINLINE static kq_status solve_stationary(num *P, const num *A, num *Q, int n)
{
    num M[KQ_SIZE_MAX * KQ_SIZE_MAX], T[KQ_SIZE_MAX * KQ_SIZE_MAX];
    copy(M, A, n * n);
    const kq_status status = sum_by_doubling(Q, M, T, n);
    if (!status) copy(P, Q, n * n);
    return status;
}

kq_status T(kq_stationary_covariance)(num *P, const num *A, const num *F, int n, int r)
{
    num Q[KQ_SIZE_MAX * KQ_SIZE_MAX] = {0};
    if (!P || !A || (r && !F)) return KQ_ERR_NULL;
    if (!size_is_valid(n) || r < 0 || r > KQ_SIZE_MAX) return KQ_ERR_SIZE;
    if (!all_finite(A, n * n) || (r && !all_finite(F, n * r))) return KQ_ERR_NOT_FINITE;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) Q[i * n + j] = r ? dot(0, F + i * r, F + j * r, r) : 0;
    }
    return solve_stationary(P, A, Q, n);
}

kq_status T(kq_model_factor)(model *made, int k, int m, const num *loadings, const num *transition,
                             const num *drift, const num *noise)
{
    num Q[KQ_SIZE_MAX * KQ_SIZE_MAX] = {0};
    kq_status status = model_check(made, k, k, m);
    if (status) return status;
    if (!loadings || !transition) return KQ_ERR_NULL;
    if (!all_finite(loadings, m * k) || !all_finite(transition, k * k)) return KQ_ERR_NOT_FINITE;
    status = variances_check(drift, k);
    if (!status) status = variances_check(noise, m);
    if (status) return status;
    for (int i = 0; i < k; i++) Q[i * k + i] = drift[i];
    status = solve_stationary(made->P0, transition, Q, k);
    if (status) return status;
    copy(made->A, transition, k * k);
    fill(made->F, 0, k * k);
    for (int i = 0; i < k; i++) set_drift(made, i, i, drift[i]);
    copy(made->H, loadings, m * k);
    copy(made->R, noise, m);
    fill(made->x0, 0, k);
    return KQ_OK;
}

/* ------------------------------------------------------------------ motion */

/* One axis of `order` 2 (velocity) or 3 (acceleration): its blocks of A and F, order x order */
typedef struct {
    num A[9], F[9];
} axis;

/*
 * Q = q times the integral of g(s) g(s)' over s = 0 .. dt, g = (s, 1) or (s^2/2, s, 1), and F its
 * upper triangular factor.
 */
static kq_status axis_of(axis *made, int order, num dt, num density)
{
    const num sigma = num_root(density * dt), square = dt * dt;
    const axis two = {{1, dt, 0, 1}, {sigma * dt / num_root(12), sigma * dt / 2, 0, sigma}};
    const axis three = {{1, dt, square / 2, 0, 1, dt, 0, 0, 1},
                        {sigma * square / num_root(720), sigma * square / num_root(48),
                         sigma * square / 6, 0, sigma * dt / num_root(12), sigma * dt / 2, 0, 0,
                         sigma}};
    *made = order == 2 ? two : three;
    const int count = order * order;
    const int good = all_finite(made->A, count) && all_finite(made->F, count);
    return good ? KQ_OK : KQ_ERR_NOT_FINITE;
}

/* Writes the block of axis k, n x n being all of it. */
static void set_block(num *M, const num *block, int order, int k, int n)
{
    num *at = M + k * order * (n + 1);
    for (int i = 0; i < order; i++) copy(at + i * n, block + i * order, order);
}

static kq_status motion_check(const model *made, int order, int d, num dt, const num *density,
                              const num *noise)
{
    if (d < 1 || d > 3) return KQ_ERR_SIZE;
    kq_status status = model_check(made, order * d, order * d, d);
    if (status) return status;
    if (!num_is_finite(dt)) return KQ_ERR_NOT_FINITE;
    if (!(dt > 0)) return KQ_ERR_RANGE;
    status = variances_check(density, d);
    return status ? status : variances_check(noise, d);
}

static kq_status model_motion(model *made, int order, int d, num dt, const num *density,
                              const num *noise, const num *mean, const num *variance)
{
    axis axes[3];
    const int n = order * d;
    kq_status status = motion_check(made, order, d, dt, density, noise);
    if (!status) status = prior_values_check(mean, variance, n);
    for (int k = 0; k < d && !status; k++) status = axis_of(&axes[k], order, dt, density[k]);
    if (status) return status;
    model_clear(made);
    for (int k = 0; k < d; k++) {
        set_block(made->A, axes[k].A, order, k, n);
        set_block(made->F, axes[k].F, order, k, n);
        made->H[k * n + k * order] = 1;
        made->R[k] = noise[k];
    }
    set_prior(made, mean, variance);
    return KQ_OK;
}

kq_status T(kq_model_velocity)(model *made, int d, num dt, const num *density, const num *noise,
                               const num *mean, const num *variance)
{
    return model_motion(made, 2, d, dt, density, noise, mean, variance);
}

kq_status T(kq_model_acceleration)(model *made, int d, num dt, const num *density, const num *noise,
                                   const num *mean, const num *variance)
{
    return model_motion(made, 3, d, dt, density, noise, mean, variance);
}

#endif
