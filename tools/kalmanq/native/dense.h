/* Products of small matrices without gaps, row after row */
#ifndef KQ_NATIVE_DENSE_H
#define KQ_NATIVE_DENSE_H

#include <stddef.h>
#include <string.h>

static inline void clear(double *out, int count)
{
    memset(out, 0, sizeof *out * (size_t)count);
}

static inline void copied(double *out, const double *a, int count)
{
    memcpy(out, a, sizeof *out * (size_t)count);
}

/* out += share x; the one loop in which all products end.  Much of a transition is 0 */
static inline void add(double *restrict out, double share, const double *restrict x, int count)
{
    if (share == 0) return;
    for (int j = 0; j < count; j++) out[j] += share * x[j];
}

/* out (r x c) += A (r x k) B (k x c) */
static inline void add_product(double *restrict out, const double *A, const double *B, int r, int k, int c)
{
    for (int i = 0; i < r; i++) {
        for (int s = 0; s < k; s++) add(out + i * c, A[i * k + s], B + s * c, c);
    }
}

/* out (r x c) += A' B, A is k x r */
static inline void add_of_transposed(double *restrict out, const double *A, const double *B, int r, int k, int c)
{
    for (int s = 0; s < k; s++) {
        for (int i = 0; i < r; i++) add(out + i * c, A[s * r + i], B + s * c, c);
    }
}

/* out (r x c) += A B', B is c x k */
static inline void add_by_transposed(double *restrict out, const double *A, const double *B, int r, int k, int c)
{
    for (int i = 0; i < r; i++) {
        for (int j = 0; j < c; j++) {
            double sum = 0;
            for (int s = 0; s < k; s++) sum += A[i * k + s] * B[j * k + s];
            out[i * c + j] += sum;
        }
    }
}

static inline void product(double *out, const double *A, const double *B, int r, int k, int c)
{
    clear(out, r * c);
    add_product(out, A, B, r, k, c);
}

static inline void of_transposed(double *out, const double *A, const double *B, int r, int k, int c)
{
    clear(out, r * c);
    add_of_transposed(out, A, B, r, k, c);
}

static inline void by_transposed(double *out, const double *A, const double *B, int r, int k, int c)
{
    clear(out, r * c);
    add_by_transposed(out, A, B, r, k, c);
}

static inline void symmetrise(double *P, int n)
{
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < i; j++) P[i * n + j] = P[j * n + i] = (P[i * n + j] + P[j * n + i]) / 2;
    }
}

#endif
