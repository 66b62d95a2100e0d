/*
 * What q31 is compared with: the Kalman filter as fixed point code usually has it.  Every number
 * is an int32_t in Q16.16, the covariance itself is carried:
 *     predict   x <- A x,  P <- A P A' + Q
 *     update    one scalar measurement after the other, P <- P - K (P h)'
 * As good as this form gets: products are summed in 64 bits and rounded once, zeros of A and H
 * cost nothing, P is computed in one triangle and mirrored.
 */
#ifndef KALMANQ_Q16_FILTER_H
#define KALMANQ_Q16_FILTER_H

#include <stdint.h>

enum { Q16_STATES = 9, Q16_COMPONENTS = 3 };

typedef struct {
    int n;
    int32_t x[Q16_STATES], P[Q16_STATES * Q16_STATES];
} q16_filter;

typedef struct {
    int n;
    int32_t A[Q16_STATES * Q16_STATES], Q[Q16_STATES * Q16_STATES];
} q16_process;

typedef struct {
    int n, m;
    int32_t H[Q16_COMPONENTS * Q16_STATES], R[Q16_COMPONENTS];
} q16_sensor;

void q16_predict(q16_filter *f, const q16_process *p);
void q16_update(q16_filter *f, const q16_sensor *s, const int32_t *z);

/** Both. */
void q16_step(q16_filter *f, const q16_process *p, const q16_sensor *s, const int32_t *z);

#endif
