#include "slopes.h"

#include <math.h>

#include "dense.h"
#include "kalmanq/kalmanq.h"

#define MOST KQ_SIZE_MAX
#define COLUMNS (MOST + 1)
#define LOG_2PI 1.8378770664093454836

/* What of a row is needed on the way back: what is there, p components `at`; S^-1, K = P H' S^-1 (n x p) and S^-1 V (p x
   columns); the filtered mean and covariance. */
typedef struct {
    double *count, *at, *inverse, *gain, *innovation, *mean, *covariance;
} kept;

size_t kq_slopes_kept(int n, int m, int columns)
{
    return (size_t)(1 + m + m * m + n * m + m * columns + n * columns + n * n);
}

static kept kept_of(const kq_slopes *q, size_t t)
{
    const int n = q->n, m = q->m, columns = q->columns;
    double *at = q->kept + (q->keeps ? t * kq_slopes_kept(n, m, columns) : 0);
    kept k = {.count = at, .at = at + 1};
    k.inverse = k.at + m;
    k.gain = k.inverse + m * m;
    k.innovation = k.gain + n * m;
    k.mean = k.innovation + m * columns;
    k.covariance = k.mean + n * columns;
    return k;
}

/* S^-1 in place, by L L'; the logarithm of its determinant */
static double inverted(double *S, int p)
{
    double half = 0, L[MOST * MOST] = {0};
    for (int i = 0; i < p; i++) {
        for (int j = 0; j <= i; j++) {
            double rest = S[i * p + j];
            for (int k = 0; k < j; k++) rest -= L[i * p + k] * L[j * p + k];
            L[i * p + j] = i == j ? sqrt(rest) : rest / L[j * p + j];
        }
        half += log(L[i * p + i]);
    }
    for (int c = 0; c < p; c++) { /* L^-1, column after column, in S */
        for (int i = 0; i < p; i++) {
            double rest = i == c;
            for (int k = c; k < i; k++) rest -= L[i * p + k] * S[k * p + c];
            S[i * p + c] = i < c ? 0 : rest / L[i * p + i];
        }
    }
    copied(L, S, p * p);
    of_transposed(S, L, L, p, p, p);
    return 2 * half;
}

/* The rows of H that are there, and how many */
static int there(const kq_slopes *q, size_t t, const kept *k, double *H)
{
    int p = 0;
    for (int c = 0; c < q->m; c++) {
        if (isnan(q->z[t * (size_t)q->m + (size_t)c])) continue;
        copied(H + p * q->n, q->H + c * q->n, q->n);
        k->at[p++] = c;
    }
    *k->count = p;
    return p;
}

static void innovations(const kq_slopes *q, size_t t, const kept *k, const double *H, const double *X, double *V, int p)
{
    product(V, H, X, p, q->n, q->columns);
    for (int i = 0; i < p * q->columns; i++) V[i] = -V[i];
    for (int c = 0; c < p; c++) V[c * q->columns] += q->z[t * (size_t)q->m + (size_t)k->at[c]];
}

/* X and P take the row; its part of the log-likelihood */
static double take(const kq_slopes *q, size_t t, double *X, double *P, double *squares)
{
    double H[MOST * MOST], HP[MOST * MOST], V[MOST * COLUMNS];
    const int n = q->n, columns = q->columns;
    const kept k = kept_of(q, t);
    const int p = there(q, t, &k, H);
    if (!p) return 0;
    product(HP, H, P, p, n, n);
    by_transposed(k.inverse, HP, H, p, n, p);
    for (int i = 0; i < p * p; i++) k.inverse[i] += q->R[(int)k.at[i / p] * q->m + (int)k.at[i % p]];
    const double logarithm = inverted(k.inverse, p);
    innovations(q, t, &k, H, X, V, p);
    product(k.innovation, k.inverse, V, p, p, columns);
    of_transposed(k.gain, HP, k.inverse, n, p, p);
    add_product(X, k.gain, V, n, p, columns);
    for (int i = 0; i < p * n; i++) HP[i] = -HP[i];
    add_product(P, k.gain, HP, n, p, n);
    symmetrise(P, n);
    add_of_transposed(squares, V, k.innovation, columns, p, columns);
    return -(logarithm + p * LOG_2PI) / 2;
}

static void move(const kq_slopes *q, size_t t, double *X, double *P)
{
    double AX[MOST * COLUMNS], AP[MOST * MOST];
    const int n = q->n, l = q->l;
    const size_t k = (size_t)q->which[t], square = (size_t)(n * n);
    const double *A = q->A + k * square;
    product(AX, A, X, n, n, q->columns);
    copied(X, AX, n * q->columns);
    for (int i = 0; q->u && i < n; i++) {
        for (int j = 0; j < l; j++) X[i * q->columns] += q->B[(k * (size_t)n + (size_t)i) * (size_t)l + (size_t)j] * q->u[t * (size_t)l + (size_t)j];
    }
    product(AP, A, P, n, n, n);
    copied(P, q->Q + k * square, n * n);
    add_by_transposed(P, AP, A, n, n, n);
}

double kq_slopes_forwards(const kq_slopes *q, double *squares)
{
    double X[MOST * COLUMNS], P[MOST * MOST], total = 0;
    const int n = q->n;
    copied(X, q->mean, n * q->columns);
    copied(P, q->P0, n * n);
    clear(squares, q->columns * q->columns);
    for (size_t t = 0; t < q->rows; t++) {
        total += take(q, t, X, P, squares);
        const kept k = kept_of(q, t);
        copied(k.mean, X, n * q->columns);
        copied(k.covariance, P, n * n);
        if (t + 1 < q->rows) move(q, t, X, P);
    }
    return total;
}

/* The way back, after row t: the weighed sums r (n x columns) of innovations, and their covariance N (n x n) */
typedef struct {
    double r[MOST * COLUMNS], N[MOST * MOST];
    const double *c, *C;
} back;

static void move_back(const kq_slopes *q, size_t t, back *b)
{
    double Ar[MOST * COLUMNS], rC[MOST * COLUMNS], seen[MOST * COLUMNS], NA[MOST * MOST], change[MOST * MOST] = {0};
    const int n = q->n, columns = q->columns;
    const size_t k = (size_t)q->which[t], square = (size_t)(n * n);
    const double *A = q->A + k * square;
    const kept row = kept_of(q, t);
    of_transposed(Ar, A, b->r, n, n, columns);
    product(rC, b->r, b->C, n, columns, columns);
    copied(seen, row.mean, n * columns);
    add_product(seen, row.covariance, Ar, n, n, columns);
    add_by_transposed(q->by_A + k * square, rC, seen, n, columns, n);
    product(NA, b->N, A, n, n, n);
    add_product(change, NA, row.covariance, n, n, n);
    add(q->by_A + k * square, -1, change, n * n);
    by_transposed(change, rC, b->r, n, columns, n);
    add(change, -1, b->N, n * n);
    add(q->by_Q + k * square, 0.5, change, n * n);
    for (int i = 0; q->u && i < n; i++) {
        double rc = 0;
        for (int j = 0; j < columns; j++) rc += b->r[i * columns + j] * b->c[j];
        add(q->by_B + (k * (size_t)n + (size_t)i) * (size_t)q->l, rc, q->u + t * (size_t)q->l, q->l);
    }
    copied(b->r, Ar, n * columns);
    of_transposed(b->N, A, NA, n, n, n);
}

/* Slopes to R and to rows of H, of what is there; gN: K' N (p x n), inside: S^-1 + K' N K */
static void measure_back(const kq_slopes *q, const kept *row, const back *b, const double *error, const double *gN, const double *inside, int p)
{
    double eC[MOST * COLUMNS], seen[MOST * COLUMNS], by_H[MOST * MOST] = {0}, by_R[MOST * MOST];
    const int n = q->n, columns = q->columns;
    product(eC, error, b->C, p, columns, columns);
    by_transposed(by_R, eC, error, p, columns, p);
    for (int i = 0; i < p * p; i++) q->by_R[(int)row->at[i / p] * q->m + (int)row->at[i % p]] += (by_R[i] - inside[i]) / 2;
    copied(seen, row->mean, n * columns);
    add_product(seen, row->covariance, b->r, n, n, columns);
    add_by_transposed(by_H, eC, seen, p, columns, n);
    add_product(by_H, gN, row->covariance, p, n, n);
    for (int i = 0; i < p * n; i++) by_H[i] -= row->gain[i % n * p + i / n];
    for (int c = 0; c < p; c++) add(q->by_H + (int)row->at[c] * n, 1, by_H + c * n, n);
}

static void take_back(const kq_slopes *q, size_t t, back *b)
{
    double H[MOST * MOST], error[MOST * COLUMNS] = {0}, gN[MOST * MOST], inside[MOST * MOST], HI[MOST * MOST];
    const int n = q->n, columns = q->columns;
    const kept row = kept_of(q, t);
    const int p = there(q, t, &row, H);
    if (!p) return;
    of_transposed(error, row.gain, b->r, p, n, columns);
    for (int i = 0; i < p * columns; i++) error[i] = row.innovation[i] - error[i];
    of_transposed(gN, row.gain, b->N, p, n, n);
    product(inside, gN, row.gain, p, n, p);
    add(inside, 1, row.inverse, p * p);
    measure_back(q, &row, b, error, gN, inside, p);
    add_of_transposed(b->r, H, error, n, p, columns);
    product(HI, inside, H, p, p, n); /* N - H' gN - gN' H + H' inside H */
    add(HI, -1, gN, p * n);
    add_of_transposed(b->N, H, HI, n, p, n);
    for (int i = 0; i < p * n; i++) gN[i] = -gN[i];
    add_of_transposed(b->N, gN, H, n, p, n);
    symmetrise(b->N, n);
}

void kq_slopes_backwards(const kq_slopes *q, const double *c, const double *C)
{
    back b = {.c = c, .C = C};
    double rC[MOST * COLUMNS], change[MOST * MOST];
    const int n = q->n, columns = q->columns;
    for (size_t t = q->rows; t-- > 0;) {
        if (t + 1 < q->rows) move_back(q, t, &b);
        take_back(q, t, &b);
    }
    product(rC, b.r, C, n, columns, columns);
    by_transposed(change, rC, b.r, n, columns, n);
    add(change, -1, b.N, n * n);
    add(q->by_P0, 0.5, change, n * n);
    add_product(q->by_mean, b.r, c, n, columns, 1);
}
