/*
 * The mean in 32 + 24 bits: x = (high + low 2^-24) words, 0 <= low < 2^24, in two planes of n
 * words.  |x| < 2^31 words always: what would leave it is held there, and that is the one place
 * of the arithmetic where the data can saturate.
 *
 * WIDE numbers are int64_t in units of 2^-24; sums of products are in units of 2^-26.
 */
#ifndef KALMANQ_MEAN_H
#define KALMANQ_MEAN_H

#include "kalmanq/status.h"
#include "scaled_q31.h"

#define MEAN_PLANES 2

typedef int64_t wide;

static const int64_t wide_max = (INT64_C(1) << 55) - 1;

static inline wide wide_get(const int32_t *x, int n, int i)
{
    return raise_wide(x[i], 24, 55) + x[n + i];
}

static inline void wide_set(int32_t *x, int n, int i, wide value)
{
    x[i] = (int32_t)(value >> 24); /* |value| < 2^55 */
    x[n + i] = (int32_t)(value & 0xffffff);
}

static inline wide wide_held(int64_t value)
{
    return value > wide_max ? wide_max : value < -wide_max ? -wide_max : value;
}

/* Held within the word; answers whether it had to be.  The top word alone tells most. */
static inline unsigned wide_set_held(int32_t *x, int n, int i, int64_t value)
{
    const int32_t top = (int32_t)(value >> 32), most = (INT32_C(1) << 23) - 1;
    const wide held = top >= -most && top <= most ? value : wide_held(value);
    wide_set(x, n, i, held);
    return held == value ? 0 : KQ_EVENT_SATURATED;
}

/*
 * c (high + low 2^-24) in units of 2^-26, rounded.  |c.mantissa| < 2^31 and |high| <= 2^31, so the
 * product with its lower part stays within 2^62; |c| <= 16, which is 2^30 2^-26, so nothing is
 * shifted up.
 */
static inline int64_t wide_product(scaled c, int32_t high, int32_t low)
{
    const int64_t p = sum_of(product(c.mantissa, high), product(c.mantissa, low) >> 24, 62);
    return lower_wide(p, -26 - c.exponent);
}

/* The same for c of any size: what it makes larger than a full word, 2^57, is held there. */
static inline int64_t wide_product_held(scaled c, int32_t high, int32_t low)
{
    const int64_t most = INT64_C(1) << 57;
    if (c.exponent <= -26) return wide_product(c, high, low);
    const int64_t p = sum_of(product(c.mantissa, high), product(c.mantissa, low) >> 24, 62);
    const int32_t shift = c.exponent + 26;
    if (p == 0) return 0;
    if (shift > 57 || p > most >> shift || p < -(most >> shift)) return p < 0 ? -most : most;
    return raise_wide(p, (int)shift, 57);
}

/* x_i as one word, and what that leaves */
static inline int32_t mean_get(const int32_t *x, int n, int i)
{
    const wide rounded = (wide_get(x, n, i) + (INT32_C(1) << 23)) >> 24;
    return rounded > INT32_MAX ? INT32_MAX : rounded < -INT32_MAX ? -INT32_MAX : (int32_t)rounded;
}

static inline int32_t mean_low(const int32_t *x, int n, int i)
{
    return (int32_t)(wide_get(x, n, i) - raise_wide(mean_get(x, n, i), 24, 55));
}

/* p 2^shift as a wide number, held at twice the word */
KQ_NOINLINE static wide wide_from(int64_t p, int32_t shift)
{
    const wide most = 2 * wide_max;
    if (p == 0) return 0;
    if (shift > 0) {
        if (shift > 56 || p > most >> shift || p < -(most >> shift)) return p < 0 ? -most : most;
        return raise_wide(p, (int)shift, 56);
    }
    const wide value = lower_wide(p, -shift);
    return value > most ? most : value < -most ? -most : value;
}

/* x_i += b w.  b: any mantissa below 2^30, so that a product that is shifted down by 6 bits or more
   is no more than twice the word */
KQ_INLINE unsigned mean_correct(int32_t *x, int n, int i, scaled b, scaled w)
{
    const int64_t p = product(b.mantissa, w.mantissa);
    const int32_t down = -24 - b.exponent - w.exponent;
    const wide d = down >= 6 ? lower_wide(p, down) : wide_from(p, -down);
    return wide_set_held(x, n, i, sum_of(wide_get(x, n, i), d, 58));
}

static inline unsigned mean_correct_exactly(int32_t *x, int n, int i, scaled b, scaled w)
{
    const wide d = wide_from(product(b.mantissa, w.mantissa), b.exponent + w.exponent + 24);
    return wide_set_held(x, n, i, sum_of(wide_get(x, n, i), d, 58));
}

KQ_INLINE void mean_settle(int32_t *x, int n) { (void)x, (void)n; }

/* t <- x, to be read while x is overwritten */
KQ_INLINE void mean_copy(int32_t *t, const int32_t *x, int n)
{
    for (int k = 0; k < 2 * n; k++) t[k] = x[k];
}

/* sum_k row_k u_k, in units of 2^-26.  Init has checked that sum |A_ik| + sum |B_ik| <= 16, so
   all sums of a row stay below 16 2^57 = 2^61, and their rounding. */
static inline int64_t control_drive(const scaled *row, const int32_t *u, int count)
{
    int64_t sum = 0;
    for (int k = 0; k < count; k++) {
        if (row[k].mantissa != 0) sum = sum_of(sum, wide_product(row[k], u[k], 0), 62);
    }
    return sum;
}

/* x_i <- row't + drive, where t is a copy of x and the row is zero left of `first` */
KQ_INLINE unsigned mean_advance(int32_t *x, int n, int i, const scaled *row, int first,
                                const int32_t *t, int64_t drive)
{
    int64_t sum = drive;
    KQ_UNROLL
    for (int k = first; k < n; k++) {
        if (row[k].mantissa == 0) continue;
        sum = sum_of(sum, wide_product(row[k], t[k], t[n + k]), 62);
    }
    return wide_set_held(x, n, i, lower_wide(sum, 2));
}

/* z - h'x, h being 0 outside of from .. to-1.  |z| 2^26 < 2^57, and |h'x| 2^26 <= 2^61 by init's
 * check. */
KQ_INLINE scaled mean_residual(int32_t z, const scaled *h, const int32_t *x, int n, int from,
                               int to)
{
    int64_t sum = raise_wide(z, 26, 57);
    for (int k = from; k < to; k++) {
        if (h[k].mantissa == 0) continue;
        sum = sum_of(sum, -wide_product(h[k], x[k], x[n + k]), 62);
    }
    return scaled_of(sum, -26);
}

#endif
