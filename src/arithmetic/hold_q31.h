/* The limit of a state that grows without end, in fixed point: renormalise holds the exponents of the
   root before it moves the mantissas up by less than 32 bits, and here that is seen.  hold_float.h is
   the twin. */
#ifndef KQ_SRC_ARITHMETIC_HOLD_Q31_H
#define KQ_SRC_ARITHMETIC_HOLD_Q31_H

#include <stdint.h>

#include "kalmanq/size.h"
#include "kalmanq/status.h"

#include "q31.h"
#include "compiler.h"
#include "rows.h"
#include "scaled.h"

static inline unsigned state_hold(int32_t *x, int32_t *S, int n)
{
    (void)x, (void)S, (void)n;
    return 0;
}

/* A state in fixed point is always held. */
static inline int state_is_finite(const int32_t *x, const int32_t *S, int n)
{
    (void)x, (void)S, (void)n;
    return 1;
}

KQ_INLINE int root_is_within(const int32_t *S, int n)
{
    int32_t top = lowest_exponent;
    KQ_UNROLL
    for (int i = 0; i < n; i++) top = S[KQ_TRIANGLE(n) + i] > top ? S[KQ_TRIANGLE(n) + i] : top;
    return top <= high_exponent - 32;
}

KQ_INLINE unsigned state_held(int32_t *x, int32_t *S, int n)
{
    (void)x; /* held at its word by mean_advance */
    return root_is_within(S, n) ? 0 : KQ_EVENT_OVERFLOW;
}

#endif
