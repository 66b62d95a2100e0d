/* What must hold of a filter or a view after every call, whatever the data. */
#ifndef KALMANQ_FUZZ_JUDGE_H
#define KALMANQ_FUZZ_JUDGE_H

#include "input.h"
#ifdef KQ_FUZZ_Q31
#include "models_q31.h"
#else
#include "models_float.h"
#endif

/* Is M + most I positive semi-definite?  M has entries of about 1. */
static int is_semidefinite(const double *M, int n, double most)
{
    double L[SQUARE];
    for (int j = 0; j < n; j++)
        for (int i = j; i < n; i++) {
            double sum = M[i * n + j] + (i == j ? most : 0);
            for (int k = 0; k < j; k++) sum -= L[i * n + k] * L[j * n + k];
            if (i == j && !(sum > 0)) return 0;
            L[i * n + j] = i == j ? sqrt(sum) : sum / L[j * n + j];
        }
    return 1;
}

/* P is symmetric, and positive semi-definite but for what its entries are rounded by. */
static void check_covariance(const entry *P, int n)
{
    double C[SQUARE];
    for (int i = 0; i < n; i++) {
        DEMAND(!is_negative(P[i * n + i]));
        for (int j = 0; j < n; j++) {
            const entry a = P[i * n + i], b = P[j * n + j];
            DEMAND(memcmp(P + i * n + j, P + j * n + i, sizeof *P) == 0);
            C[i * n + j] = i == j ? 1 : is_none(a) || is_none(b) ? 0 : ratio(P[i * n + j], a, b);
        }
    }
    DEMAND(is_semidefinite(C, n, (n + 1) * ROUNDING));
}

/* smoothed <= filtered, in units of the filtered sigmas */
static void check_not_above(const entry *smoothed, const entry *filtered, int n)
{
    double D[SQUARE];
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            const entry a = filtered[i * n + i], b = filtered[j * n + j];
            const int is_known = is_none(a) || is_none(b);
            D[i * n + j] = is_known ? 0 : ratio(filtered[i * n + j], a, b) - ratio(smoothed[i * n + j], a, b);
        }
    DEMAND(is_semidefinite(D, n, GROWTH));
}

/* Answers whether it has a covariance, P: not so a view of means, or a filter without a start. */
static int sane(const K(filter) *f, entry *P)
{
    if (K(covariance)(f, P) != KQ_OK) return 0;
    check_numbers(f, P);
    if (!(K(events)(f) & KQ_EVENT_OVERFLOW)) check_covariance(P, f->states);
    return 1;
}

#endif
