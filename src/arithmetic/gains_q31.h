/* The mean of a steady-state filter in fixed point has the format of a filter's mean. */
#ifndef KQ_SRC_ARITHMETIC_GAINS_Q31_H
#define KQ_SRC_ARITHMETIC_GAINS_Q31_H

#include "coordinates_q31.h"

/* A state between predict and update: wide, held within the word */
typedef wide steady_word;

static inline int32_t steady_get(const int32_t *x, int n, int i) { return mean_get(x, n, i); }

static inline void steady_set(int32_t *x, int n, int i, int32_t value)
{
    wide_set(x, n, i, shift_up_wide(value, 24, 55));
}

static inline void steady_keep(int32_t *x, int n, int i, steady_word value)
{
    wide_set(x, n, i, value);
}

static inline steady_word steady_whole(const int32_t *x, int n, int i) { return wide_get(x, n, i); }

static inline int is_one(scaled a) { return a.mantissa == INT32_C(1) << 30 && a.exponent == -30; }

/* Is it within half of the word?  Then nothing has to be held. */
static inline int is_small(int64_t value)
{
    return ((uint32_t)(int32_t)(value >> 32) + (UINT32_C(1) << 22)) >> 23 == 0;
}

KQ_KERNEL unsigned steady_saturate(steady_word *t, int64_t value)
{
    *t = value;
    if (KQ_MOSTLY(is_small(value))) return 0;
    *t = wide_saturated(value);
    return *t == value ? 0 : KQ_EVENT_SATURATED;
}

/* *part <- p 2^-down as a wide number, cut at 2^58, which it answers; |p| <= 2^62 */
KQ_KERNEL unsigned steady_part(wide *part, int64_t p, int32_t down)
{
    if (KQ_MOSTLY((uint32_t)(down - 6) < 26)) {
        *part = shift_rounded_long(p, (int)down);
        return 0;
    }
    *part = wide_from(p, -down, 58);
    return was_cut(*part, 58);
}

/* c (high + low 2^-24) in units of 2^-24, rounded, for |c| <= 16 */
KQ_KERNEL wide steady_times(scaled c, int32_t high, int32_t low)
{
    const int64_t p = sum_of(product(c.mantissa, high), product(c.mantissa, low) >> 24, 62);
    const int32_t down = -24 - c.exponent;
    if (KQ_MOSTLY((uint32_t)(down - 1) < 31)) return shift_rounded_long(p, (int)down);
    return shift_down_rounded_wide(p, down);
}

/* total + row'x, where the row is zero left of `first`; a coefficient of 1 is none.  The sum of a
   row's sizes is 16 words at most: 2^59. */
KQ_KERNEL wide steady_dot(wide total, int n, const scaled *row, int first, const int32_t *x)
{
    KQ_UNROLL
    for (int k = first; k < n; k++) {
        if (row[k].mantissa == 0) continue;
        const wide part = is_one(row[k]) ? wide_get(x, n, k) : steady_times(row[k], x[k], x[n + k]);
        total = sum_of(total, part, 60);
    }
    return total;
}

/* *t <- row'x, and with a drive in units of 2^-26 */
KQ_KERNEL unsigned steady_row(steady_word *t, int n, const scaled *row, int first, const int32_t *x)
{
    return steady_saturate(t, steady_dot(0, n, row, first, x));
}

KQ_KERNEL unsigned steady_drive(steady_word *t, int n, const scaled *row, int first,
                                const int32_t *x, int64_t drive)
{
    return steady_saturate(t, steady_dot(shift_down_rounded_wide(drive, 2), n, row, first, x));
}

/* An innovation: mantissa 2^(-24 - down), so that its product with a number of exponent E is to be
   moved by down - E */
typedef struct {
    int32_t mantissa, down;
} steady_number;

/* A wide number with a mantissa of 31 bits, truncated, or all of it */
KQ_KERNEL steady_number steady_mantissa(wide a)
{
    const int32_t high = (int32_t)(a >> 32), low = (int32_t)(uint32_t)(uint64_t)a;
    if (high == low >> 31) return (steady_number){low, 0};
    const int shift = leading_zeros((uint32_t)(high ^ high >> 31)) - 1;
    return (steady_number){(int32_t)(shift_up_wide(a, shift, 63) >> 32), shift - 32};
}

/* h't, at most 16 words */
static inline wide steady_sum(const scaled *h, const steady_word *t, int n)
{
    int64_t total = 0;
    for (int k = 0; k < n; k++) {
        if (h[k].mantissa == 0) continue;
        const wide part = steady_times(h[k], (int32_t)(t[k] >> 24), (int32_t)(t[k] & 0xffffff));
        total = sum_of(total, part, 60);
    }
    return total;
}

/* z - h't; selected: 1 + the state that h takes alone, as it is, or 0 */
KQ_KERNEL steady_number steady_residual(int32_t z, const scaled *h, int selected,
                                        const steady_word *t, int n)
{
    const int alone = selected && h[selected - 1].exponent == -30;
    const wide measured = alone ? t[selected - 1] : steady_sum(h, t, n);
    return steady_mantissa(sum_of(shift_up_wide(z, 24, 55), -measured, 61));
}

KQ_KERNEL int innovations_are_finite(const steady_number *e, int m)
{
    (void)e, (void)m;
    return 1;
}

static inline int32_t steady_word_of(steady_number e)
{
    return word_of(scaled_of(e.mantissa, -24 - e.down));
}

/* x_i <- t + row'e, which alone is held: 16 parts of 2^58, 8 words each, and t. */
KQ_KERNEL unsigned steady_add(int32_t *x, steady_word t, int n, int i, const scaled *row,
                              const steady_number *e, int m)
{
    int64_t total = t;
    unsigned events = 0;
    KQ_UNROLL
    for (int c = 0; c < m; c++) {
        wide part;
        const int64_t p = product(row[c].mantissa, e[c].mantissa);
        events |= steady_part(&part, p, e[c].down - row[c].exponent);
        total = sum_of(total, part, 63);
    }
    events |= steady_saturate(&t, total);
    wide_set(x, n, i, t);
    return events;
}

#endif
