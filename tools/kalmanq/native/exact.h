/* The filter that compiled ones are compared with: in long double, by Joseph's form, of measurements with independent noises. */
#ifndef KALMANQ_NATIVE_EXACT_H
#define KALMANQ_NATIVE_EXACT_H

#include <stddef.h>
#include <stdint.h>

/* A, Q: n x n; B: n x l; H: m x n; R: m variances.  nu: degrees of freedom of Student's noise, found by `steps` of EM; 0: normal noise;
   work: n x n + 3 n */
typedef struct {
    int n, m, l, steps;
    const long double *A, *B, *H, *Q, *R;
    long double nu, *work;
} kq_exact;

/* rows x l of u and rows x m of z; predicts, taken: of each row, does a step lead to it, and bits of the components that are taken.
   means: rows x n, covariances: rows x n x n; before the first row they have what the filter begins with, in their first place. */
void kq_exact_run(const kq_exact *e, size_t rows, const uint8_t *predicts, const uint32_t *taken, const long double *u,
                  const long double *z, long double *means, long double *covariances);

#endif
