/* The log-likelihood of a record of a linear model and its slopes, in f64, by the disturbance smoother (Koopman and Shephard,
   Biometrika 79, 1992; with an unknown start de Jong, Annals of Statistics 19, 1991). */
#ifndef KALMANQ_NATIVE_SLOPES_H
#define KALMANQ_NATIVE_SLOPES_H

#include <stddef.h>
#include <stdint.h>

/* A record.  Matrices have no gaps; those of steps are one after the other. */
typedef struct {
    int n, m, l, columns;  /* states, measurements, controls; 1, and 1 for each unknown state */
    size_t rows;
    const double *z;       /* rows x m; NaN: missing */
    const double *u;       /* rows x l, or NULL */
    const int64_t *which;  /* rows - 1: of the steps */
    const double *A, *Q, *B;
    const double *H, *R;
    const double *mean;    /* n x columns: x0, and 1 in the place of each unknown state */
    const double *P0;
    double *kept;          /* rows x kq_slopes_kept(), or that of one row where no slopes are wanted */
    int keeps;
    double *by_A, *by_Q, *by_B, *by_H, *by_R, *by_mean, *by_P0; /* read and written: slopes are added */
} kq_slopes;

size_t kq_slopes_kept(int n, int m, int columns);

/* The log-likelihood but for its part of the unknown start; squares: columns x columns, V' S^-1 V of all rows.  NaN: some S is not
   positive definite. */
double kq_slopes_forwards(const kq_slopes *q, double *squares);

/* Adds the slopes, given the start c (columns, the first is 1) and C, c c' and the covariance of the start. */
void kq_slopes_backwards(const kq_slopes *q, const double *c, const double *C);

#endif
