#ifndef KQ_SRC_FILTER_PRIOR_Q31_H
#define KQ_SRC_FILTER_PRIOR_Q31_H

#include "../arithmetic/q31.h"
#include "state.h"

/* ------------------------------------------------------------------ prior */

KQ_COLD static kq_status prior_check(const kq_prior_table_q31 *prior, int n, kq_range_error_q31 *range_error)
{
    if (!prior || !prior->state_format || !prior->mean || !prior->root) return KQ_ERR_NULL;
    if (prior->states != n) return KQ_ERR_MISMATCH;
    kq_status status = formats_check(prior->state_format, n);
    if (!status) status = root_check(prior->root, n);
    for (int i = 0; i < n && !status; i++) {
        status = ranges_check(prior->mean + i, prior->state_format + i, 1, 1);
        if (!status || !range_error) continue;
        *range_error = (kq_range_error_q31){.quantity = KQ_STATE, .component = i, .bits = 0};
    }
    return status;
}

static int mean_is_finite(const num *x, int n)
{
    (void)x, (void)n;
    return 1;
}

/* Row i of a root: normalised, but for rounding, and an exponent that is one */
KQ_COLD static int row_is_possible(const num *S, int n, int i)
{
    const int32_t exponent = exponents_of(S, n)[i];
    uint64_t square = 0; /* in units of 16 */
    uint32_t any = 0;
    for (int j = i; j < n; j++) {
        const uint64_t size = magnitude(S[column(j) + i]);
        square += size * size >> 4;
        any |= (uint32_t)size;
    }
    if (square > (UINT64_C(1) << 56) + (UINT64_C(1) << 41)) return 0;
    if (!any) return exponent == lowest_exponent;
    if (exponent > high_exponent || exponent < lowest_exponent) return 0;
    return exponent < low_exponent || square > (UINT64_C(1) << 54) - (UINT64_C(1) << 40);
}

#endif
