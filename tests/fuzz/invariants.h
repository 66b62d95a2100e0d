/* What holds for every filter after every call, whatever the data. */
#ifndef KALMANQ_FUZZ_INVARIANTS_H
#define KALMANQ_FUZZ_INVARIANTS_H

#include "models.h"

typedef struct {
    long models, calls, saturated, refused_tables, accepted_tables;
    double worst_norm;   /* of a row of S, over 2^30 */
    double worst_growth; /* smoothed variance over filtered, less 1, in any direction */
} statistics;

static statistics seen;

static void fail(const char *what, double value)
{
    fflush(stdout);
    fprintf(stderr, "violated: %s (%.17g)\n", what, value);
    abort();
}

static inline void demand(int holds, const char *what, double value)
{
    if (!holds) fail(what, value);
}

static void check_scaled(const kq_scaled_q31 *a, int count, const char *what)
{
    for (int k = 0; k < count; k++) {
        const int64_t size = llabs((long long)a[k].mantissa);
        const int zero = size == 0 && a[k].exponent == 0;
        demand(zero || (size >= INT64_C(1) << 30 && size < INT64_C(1) << 31), what,
               (double)a[k].mantissa);
    }
}

/* m 2^e / sqrt(a b), a and b variances */
static double correlation(kq_scaled_q31 p, kq_scaled_q31 a, kq_scaled_q31 b)
{
    if (p.mantissa == 0) return 0;
    if (a.mantissa <= 0 || b.mantissa <= 0) fail("covariance without variances", p.mantissa);
    const int32_t sum = a.exponent + b.exponent;
    const double m = p.mantissa / sqrt((double)a.mantissa * b.mantissa);
    return ldexp(sum & 1 ? m * sqrt(0.5) : m, p.exponent - (sum >> 1));
}

/* Is M - d I positive definite?  M has entries of about 1. */
static int is_definite(const double *M, int n, double d)
{
    double L[KQ_SIZE_MAX * KQ_SIZE_MAX];
    for (int j = 0; j < n; j++) {
        for (int i = j; i < n; i++) {
            double sum = M[i * n + j] - (i == j ? d : 0);
            for (int k = 0; k < j; k++) sum -= L[i * n + k] * L[j * n + k];
            if (i == j && !(sum > 0)) return 0;
            L[i * n + j] = i == j ? sqrt(sum) : sum / L[j * n + j];
        }
    }
    return 1;
}

/* P is positive semi-definite: S S' is, and its entries are rounded to 31 bits. */
static void check_covariance(const kq_scaled_q31 *P, int n)
{
    double C[KQ_SIZE_MAX * KQ_SIZE_MAX];
    check_scaled(P, n * n, "covariance: not normalised");
    for (int i = 0; i < n; i++) {
        demand(P[i * n + i].mantissa >= 0, "variance < 0", P[i * n + i].mantissa);
        for (int j = 0; j < n; j++) {
            demand(P[i * n + j].mantissa == P[j * n + i].mantissa, "not symmetric", 0);
            C[i * n + j] = correlation(P[i * n + j], P[i * n + i], P[j * n + j]);
        }
        if (P[i * n + i].mantissa == 0) C[i * n + i] = 1;
    }
    demand(is_definite(C, n, -n * 0x1p-29), "covariance not semi-definite", 0);
}

/* P_s <= P_f: P_f - P_s in units of the filtered sigmas has no eigenvalue below -most. */
static void check_not_above(const kq_scaled_q31 *smoothed, const kq_scaled_q31 *filtered, int n,
                            double most)
{
    double D[KQ_SIZE_MAX * KQ_SIZE_MAX], growth = 0x1p-40;
    for (int k = 0; k < n * n; k++) {
        const kq_scaled_q31 a = filtered[k / n * (n + 1)], b = filtered[k % n * (n + 1)];
        if (a.mantissa == 0 || b.mantissa == 0) {
            demand(smoothed[k].mantissa == 0, "smoothed variance of a known state", 0);
            D[k] = 0;
            continue;
        }
        D[k] = correlation(filtered[k], a, b) - correlation(smoothed[k], a, b);
    }
    while (growth < 2 * most && !is_definite(D, n, -growth)) growth *= 2;
    if (growth > seen.worst_growth) seen.worst_growth = growth;
    demand(growth <= most, "smoothed covariance above the filtered one", growth);
}

/* Norms of the rows of the root at S, and the exponents behind it */
static void check_root(const int32_t *S, int n)
{
    for (int i = 0; i < n; i++) {
        double square = 0;
        for (int j = i; j < n; j++) {
            const double entry = S[j * (j + 1) / 2 + i];
            square += entry * entry;
        }
        const double norm = sqrt(square) / 0x1p30;
        if (norm > seen.worst_norm) seen.worst_norm = norm;
        demand(norm < 1, "row norm of S", norm);
        demand(abs(S[KQ_TRIANGLE(n) + i]) <= 20000, "exponent of S", S[KQ_TRIANGLE(n) + i]);
    }
}

/* |x| < 2^31 words, in two planes of n words */
static void check_mean(const int32_t *x, int n)
{
    for (int i = 0; i < n; i++) {
        const int64_t whole = (int64_t)x[i] * (1 << 24) + x[n + i];
        demand(x[n + i] >= 0 && x[n + i] < 1 << 24, "low part of the mean", x[n + i]);
        demand(llabs(whole) < INT64_C(1) << 55, "mean beyond its word", (double)whole);
    }
}

static void check_readers(const kq_filter_q31 *f, int n)
{
    for (int i = 0; i < n; i++) {
        const int32_t mean = kq_mean_q31(f, i), low = kq_mean_low_q31(f, i);
        demand(mean != KQ_NOT_A_VALUE_Q31, "the mean of a good filter is not a word", mean);
        demand(llabs((long long)low) <= 1 << 24, "mean_low", low);
        demand(kq_sigma_q31(f, i) >= 0, "sigma < 0", kq_sigma_q31(f, i));
    }
    demand(kq_nis_q31(f) >= 0, "NIS < 0", (double)kq_nis_q31(f));
    demand(kq_log_likelihood_q31(f) != KQ_NOT_A_SCORE_Q31, "no score", 0);
    demand(kq_log_likelihood_last_q31(f) != KQ_NOT_A_SCORE_Q31, "no score", 0);
}

static void check_filter(kq_filter_q31 *f)
{
    const unsigned known = KQ_EVENT_SATURATED | KQ_EVENT_REDUNDANT | KQ_EVENT_HISTORY_FULL |
                           KQ_EVENT_PRECISION | KQ_EVENT_CONTRADICTION |
                           KQ_EVENT_OVERFLOW;
    const int n = f->states;
    kq_scaled_q31 P[KQ_SIZE_MAX * KQ_SIZE_MAX];
    demand(!(kq_events_q31(f) & ~known), "event", kq_events_q31(f));
    check_mean(f->memory, n);
    check_root(f->memory + 2 * n, n);
    check_readers(f, n);
    must(kq_filter_check_q31(f), "kq_filter_check_q31");
    must(kq_covariance_q31(f, P), "kq_covariance_q31");
    check_covariance(P, n);
    seen.calls++;
}

#endif
