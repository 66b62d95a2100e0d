/*
 * The formulas of any textbook, in double, for up to 3 states and 3 measured components: what
 * the tests expect.  Inverses and all; models are chosen so that this is accurate.
 *
 *     predict   x- = A x + B u    P- = A P A' + Q
 *     update    S = H P H' + R    K = P H' S^-1     x += K (z - H x)     P -= K S K'
 *     smooth    G = P A' (P-)^-1  x_s = x + G (x_s+ - x-)     P_s = P + G (P_s+ - P-) G'
 */
#ifndef KALMANQ_TESTS_TEXTBOOK_H
#define KALMANQ_TESTS_TEXTBOOK_H

#include "arithmetic.h"

#define TEXTBOOK_MAX 3
#define TEXTBOOK_SQUARE (TEXTBOOK_MAX * TEXTBOOK_MAX)

typedef struct {
    int n;
    double x[TEXTBOOK_MAX], P[TEXTBOOK_SQUARE];
    double size[TEXTBOOK_MAX];                     /* sigma before the last update */
    double K[TEXTBOOK_SQUARE], S[TEXTBOOK_SQUARE]; /* of the last update */
    double nis, log_likelihood;
} textbook;

static inline void textbook_widen(double *to, const num *from, int count)
{
    for (int k = 0; k < count; k++) to[k] = (double)from[k];
}

/* C = X Y, r x k times k x c */
static inline void textbook_multiply(double *C, const double *X, const double *Y, int r, int k,
                                     int c)
{
    for (int i = 0; i < r; i++) {
        for (int j = 0; j < c; j++) {
            double sum = 0;
            for (int l = 0; l < k; l++) sum += X[i * k + l] * Y[l * c + j];
            C[i * c + j] = sum;
        }
    }
}

/* C = X Y', r x k times (c x k)' */
static inline void textbook_multiply_transposed(double *C, const double *X, const double *Y, int r,
                                                int k, int c)
{
    for (int i = 0; i < r; i++) {
        for (int j = 0; j < c; j++) {
            double sum = 0;
            for (int l = 0; l < k; l++) sum += X[i * k + l] * Y[j * k + l];
            C[i * c + j] = sum;
        }
    }
}

/* M = M^-1, positive definite, n x n; answers det M. */
static inline double textbook_invert(double *M, int n)
{
    double determinant = 1;
    for (int k = 0; k < n; k++) {
        const double pivot = M[k * n + k];
        determinant *= pivot;
        M[k * n + k] = 1;
        for (int j = 0; j < n; j++) M[k * n + j] /= pivot;
        for (int i = 0; i < n; i++) {
            const double factor = M[i * n + k];
            if (i == k) continue;
            M[i * n + k] = 0;
            for (int j = 0; j < n; j++) M[i * n + j] -= factor * M[k * n + j];
        }
    }
    return determinant;
}

static inline void textbook_note_size(textbook *t)
{
    for (int i = 0; i < t->n; i++) t->size[i] = sqrt(t->P[i * t->n + i]);
}

static inline void textbook_init(textbook *t, int n, const num *x0, const num *P0)
{
    memset(t, 0, sizeof *t);
    t->n = n;
    textbook_widen(t->x, x0, n);
    textbook_widen(t->P, P0, n * n);
    textbook_note_size(t);
}

/* B (n x l) may be NULL */
static inline void textbook_predict(textbook *t, const num *A, const num *B, const num *u, int l,
                                    const num *Q)
{
    const int n = t->n;
    double a[TEXTBOOK_SQUARE], AP[TEXTBOOK_SQUARE], x[TEXTBOOK_MAX];
    textbook_widen(a, A, n * n);
    textbook_multiply(x, a, t->x, n, n, 1);
    for (int i = 0; i < n; i++) {
        t->x[i] = x[i];
        for (int k = 0; B && k < l; k++) t->x[i] += (double)B[i * l + k] * (double)u[k];
    }
    textbook_multiply(AP, a, t->P, n, n, n);
    textbook_multiply_transposed(t->P, AP, a, n, n, n);
    for (int k = 0; k < n * n; k++) t->P[k] += (double)Q[k];
    textbook_note_size(t);
}

static inline void textbook_update(textbook *t, const num *H, const num *R, const num *z, int m)
{
    const int n = t->n;
    double h[TEXTBOOK_SQUARE], PH[TEXTBOOK_SQUARE], inverse[TEXTBOOK_SQUARE];
    double e[TEXTBOOK_MAX], change[TEXTBOOK_SQUARE];
    textbook_note_size(t);
    textbook_widen(h, H, m * n);
    textbook_multiply_transposed(PH, t->P, h, n, n, m);
    textbook_multiply(t->S, h, PH, m, n, m);
    for (int k = 0; k < m * m; k++) inverse[k] = t->S[k] += (double)R[k];
    const double determinant = textbook_invert(inverse, m);
    textbook_multiply(t->K, PH, inverse, n, m, m);
    textbook_multiply(e, h, t->x, m, n, 1);
    for (int c = 0; c < m; c++) e[c] = (double)z[c] - e[c];
    textbook_multiply(change, t->K, e, n, m, 1);
    for (int i = 0; i < n; i++) t->x[i] += change[i];
    textbook_multiply_transposed(change, t->K, PH, n, m, n);
    for (int k = 0; k < n * n; k++) t->P[k] -= change[k];
    /* Symmetric: with an A that grows, what rounding makes of the difference would grow, too */
    for (int k = 0; k < n * n; k++) t->P[k] = t->P[k % n * n + k / n];
    t->nis = 0;
    for (int k = 0; k < m * m; k++) t->nis += e[k / m] * inverse[k] * e[k % m];
    t->log_likelihood = -0.5 * (m * 1.8378770664093454836 + log(determinant) + t->nis);
}

/* s: filtered at t, on return smoothed; predicted and next (smoothed) at t + 1;
   lag_one: n x n, Cov(x[t+1], x[t] | T) */
static inline void textbook_smooth(textbook *s, const textbook *predicted, const textbook *next,
                                   const num *A, double *lag_one)
{
    const int n = s->n;
    double a[TEXTBOOK_SQUARE], PA[TEXTBOOK_SQUARE], G[TEXTBOOK_SQUARE], D[TEXTBOOK_SQUARE];
    textbook_widen(a, A, n * n);
    memcpy(D, predicted->P, sizeof D);
    (void)textbook_invert(D, n);
    textbook_multiply_transposed(PA, s->P, a, n, n, n);
    textbook_multiply(G, PA, D, n, n, n);
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < n; k++) s->x[i] += G[i * n + k] * (next->x[k] - predicted->x[k]);
    }
    for (int k = 0; k < n * n; k++) D[k] = next->P[k] - predicted->P[k];
    textbook_multiply(PA, G, D, n, n, n);
    textbook_multiply_transposed(D, PA, G, n, n, n);
    for (int k = 0; k < n * n; k++) s->P[k] += D[k];
    textbook_multiply_transposed(lag_one, next->P, G, n, n, n);
}

/* The filter's mean and covariance are those of the textbook, up to the rounding of what they
   were before the last update. */
static inline void assert_textbook(const textbook *t, const K(filter) * f, UNITY_LINE_TYPE line)
{
    num P[TEXTBOOK_SQUARE];
    const int n = t->n;
    UNITY_TEST_ASSERT_EQUAL_INT(KQ_OK, K(covariance)(f, P), line, NULL);
    for (int i = 0; i < n; i++) {
        const double size = TOLERANCE * (t->size[i] + fabs(t->x[i]));
        assert_within(size, t->x[i], (double)K(mean)(f, i), line);
        for (int j = 0; j < n; j++) {
            const double scale = TOLERANCE * t->size[i] * t->size[j];
            assert_within(scale, t->P[i * n + j], (double)P[i * n + j], line);
        }
        const double sigma = (double)K(sigma)(f, i);
        assert_within(TOLERANCE * t->size[i] * t->size[i], t->P[i * n + i], sigma * sigma, line);
    }
}

#define ASSERT_TEXTBOOK(expected, f) assert_textbook(expected, f, __LINE__)

#endif
