/* Steps of a model in continuous time, and slopes through them. */
#ifndef KALMANQ_NATIVE_CONTINUOUS_H
#define KALMANQ_NATIVE_CONTINUOUS_H

#include <stddef.h>
#include <stdint.h>

/* A, Q and S = integral of e^(F s), n x n each, over each of `count` times h 2^doublings, by series of at most `terms` and by
   doubling: Q of twice the step is Q + A Q A'.  work: kq_steps_work() of the largest doublings */
void kq_steps(size_t count, int n, int terms, const double *F, const double *Qc, const double *h, const int64_t *doublings,
              double *A, double *Q, double *S, double *work);

/* Adds to by_F and by_Qc the slopes that those to A, Q (symmetric) and S make. */
void kq_steps_back(size_t count, int n, int terms, const double *F, const double *Qc, const double *h, const int64_t *doublings,
                   const double *by_A, const double *by_Q, const double *by_S, double *by_F, double *by_Qc, double *work);

size_t kq_steps_work(int n, int terms, int64_t doublings);

#endif
