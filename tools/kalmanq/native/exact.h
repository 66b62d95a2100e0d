/* The filter that compiled ones are compared with: in long double, by Joseph's form, of measurements with independent noises; and the
   states that both are shown. */
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

/* What a record of a filter is drawn from.  noise: n x r; back: r x n, eased: l x n, of the feedback on what is off from `rests`; holds, push,
   most, constant: l, of the controls; work: n + r */
typedef struct {
    int n, r, l;
    const double *A, *B, *noise, *back, *eased, *rests, *holds, *push, *most, *constant;
    double *now, *work;
} kq_path;

/* rows x r of w and rows x l of pushed, which are normal; moves: of each row, does a step lead to it.  now: the state before the first row;
   x: rows x n, u: rows x l, which are written */
void kq_path_run(const kq_path *p, size_t rows, const uint8_t *moves, const double *w, const double *pushed, double *x, double *u);

#endif
