/* The limit of a state that grows without end, in fixed point: predict holds the exponents of the root.
   hold_float.h is the twin. */
#ifndef KQ_SRC_ARITHMETIC_HOLD_Q31_H
#define KQ_SRC_ARITHMETIC_HOLD_Q31_H

#include <stdint.h>

#include "kalmanq/size.h"
#include "kalmanq/status.h"

#include "q31.h"
#include "compiler.h"
#include "rows.h"
#include "scaled.h"

/* Of a row of norm up to 2^30: sigma up to 2^56 words, against which an update still sees a noise of one word */
static const int32_t most_exponent = 26;

static inline unsigned state_hold(int32_t *x, int32_t *S, int n)
{
    (void)x, (void)S, (void)n;
    return 0;
}

KQ_INLINE unsigned mean_held(int32_t *x, int32_t *S, int n, extent far)
{
    (void)x, (void)S, (void)n;
    return far;
}

KQ_INLINE int state_is_within(const int32_t *S, int n, extent far)
{
    int32_t top = lowest_exponent;
    (void)far;
    KQ_UNROLL
    for (int i = 0; i < n; i++) top = S[KQ_TRIANGLE(n) + i] > top ? S[KQ_TRIANGLE(n) + i] : top;
    return top <= most_exponent;
}

/* Rows at the limit keep the correlations that they have. */
KQ_COLD KQ_NOINLINE static unsigned root_hold(int32_t *S, int n)
{
    for (int i = 0; i < n; i++) {
        int32_t *exponent = S + KQ_TRIANGLE(n) + i;
        if (*exponent > most_exponent) *exponent = most_exponent;
    }
    return KQ_EVENT_OVERFLOW;
}

KQ_INLINE unsigned state_held(int32_t *x, int32_t *S, int n, extent far)
{
    (void)x; /* held at its word by mean_advance */
    return far | (state_is_within(S, n, far) ? 0 : root_hold(S, n));
}

#endif
