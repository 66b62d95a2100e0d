/*
 * Numbers of any size in integers: mantissa 2^exponent, 2^30 <= |mantissa| < 2^31, or 0.  For
 * what has no bound known beforehand: variances, gains, coefficients.  Each operation is
 * correct to about 2^-30.
 */
#ifndef KALMANQ_SCALED_Q31_H
#define KALMANQ_SCALED_Q31_H

#include "inverse_q31.h"
#include "kalmanq/fixed_point.h"

typedef kq_scaled_q31 scaled;

/* a 2^exponent, rounded */
static inline scaled scaled_of(int64_t a, int32_t exponent)
{
    if (a == 0) return (scaled){0, 0};
    const uint64_t size = a < 0 ? 0 - (uint64_t)a : (uint64_t)a;
    const int zeros = leading_zeros_wide(size);
    /* the highest bit to bit 62, then half of the last bit kept is added: < 2^63 */
    const uint64_t top = zeros ? size << (zeros - 1) : size >> 1;
    uint32_t mantissa = (uint32_t)((top + UINT32_C(0x80000000)) >> 32); /* 2^30 .. 2^31 */
    exponent += 33 - zeros;
    if (mantissa >> 31) {
        mantissa >>= 1;
        exponent++;
    }
    return (scaled){a < 0 ? -(int32_t)mantissa : (int32_t)mantissa, exponent};
}

static inline int scaled_is_zero(scaled a) { return a.mantissa == 0; }
static inline scaled scaled_negative(scaled a) { return (scaled){-a.mantissa, a.exponent}; }

/* a 2^shift */
static inline scaled scaled_shift(scaled a, int32_t shift)
{
    return (scaled){a.mantissa, a.mantissa ? a.exponent + shift : 0};
}

static inline scaled scaled_times(scaled a, scaled b) /* |product| < 2^62 */
{
    return scaled_of(product(a.mantissa, b.mantissa), a.exponent + b.exponent);
}

/* b != 0 and normalised.  1 / |b| = reciprocal(2 |b|) 2^-62 */
static inline scaled scaled_over(scaled a, scaled b)
{
    const uint32_t inverse = reciprocal(magnitude(b.mantissa) << 1);
    const int64_t quotient = product(a.mantissa, (int32_t)(inverse >> 1)); /* < 2^62 */
    return scaled_of(b.mantissa < 0 ? -quotient : quotient, a.exponent - b.exponent - 61);
}

static inline scaled scaled_plus(scaled a, scaled b)
{
    if (scaled_is_zero(a)) return b;
    if (scaled_is_zero(b)) return a;
    if (a.exponent < b.exponent) {
        const scaled larger = b;
        b = a;
        a = larger;
    }
    const int64_t high = raise_wide(a.mantissa, 30, 61), low = raise_wide(b.mantissa, 30, 61);
    return scaled_of(sum_of(high, lower_wide(low, a.exponent - b.exponent), 62), a.exponent - 30);
}

static inline scaled scaled_minus(scaled a, scaled b) { return scaled_plus(a, scaled_negative(b)); }

/* a >= 0: sqrt(m 2^e) = sqrt(v) 2^((e - odd) / 2), v = m or, for e odd, 2 m: in [2^30, 2^32) */
static inline scaled scaled_root(scaled a)
{
    if (a.mantissa <= 0) return (scaled){0, 0};
    const int odd = a.exponent & 1;
    const uint32_t v = (uint32_t)a.mantissa << odd;
    const uint32_t root = root_by_inverse(v, inverse_root(v)); /* sqrt(v) 2^15 < 2^31 */
    const uint32_t least = UINT32_C(1) << 30;                  /* 1 is held just below */
    return (scaled){(int32_t)(root < least ? least : root), (a.exponent - odd) / 2 - 15};
}

/* a < b, for a, b >= 0 */
static inline int scaled_is_less(scaled a, scaled b)
{
    if (a.mantissa == 0 || b.mantissa == 0) return a.mantissa < b.mantissa;
    return a.exponent < b.exponent || (a.exponent == b.exponent && a.mantissa < b.mantissa);
}

/* a as a word, rounded, held at +-(2^31 - 1) */
static inline int32_t word_of(scaled a)
{
    if (a.exponent > 0) return a.mantissa < 0 ? -INT32_MAX : a.mantissa ? INT32_MAX : 0;
    return lower(a.mantissa, -a.exponent);
}

#endif
