/* The limit of a state that grows without end, in fixed point: renormalise holds the exponents of the
   root before it moves the mantissas up by less than 32 bits, and here that is seen.  saturate_float.h is
   the twin. */
#ifndef KQ_SRC_ARITHMETIC_SATURATE_Q31_H
#define KQ_SRC_ARITHMETIC_SATURATE_Q31_H

#include "rows_q31.h"

static inline unsigned state_saturate(int32_t *x, int32_t *S, const scaled *h, int n)
{
    (void)x, (void)S, (void)h, (void)n;
    return 0;
}

KQ_INLINE unsigned mean_saturated(int32_t *x, int32_t *S, int n, extent far)
{
    (void)x, (void)S, (void)n;
    return far;
}

/* Each mean was held as it was moved. */
KQ_INLINE unsigned means_saturated(int32_t *x, int32_t *S, int n)
{
    (void)x, (void)S, (void)n;
    return 0;
}

/* Is there nothing to hold in what predict made of the state? */
KQ_INLINE int state_is_within(const int32_t *S, int n, extent far)
{
    int32_t room = 0; /* negative where one of them is */
    (void)far;
    KQ_UNROLL
    for (int i = 0; i < n; i++) room |= high_exponent - 32 - S[KQ_TRIANGLE(n) + i];
    return room >= 0;
}

KQ_INLINE unsigned state_saturated(int32_t *x, int32_t *S, int n, extent far)
{
    (void)x; /* held at its word by mean_advance */
    return far | (state_is_within(S, n, far) ? 0 : KQ_EVENT_OVERFLOW);
}

#endif
