/*
 * The mean in 32 + 24 bits: x = (high + low 2^-24) words, 0 <= low < 2^24, in two planes of n
 * words.  |x| < 2^31 words when a call ends: what would leave that is held there, and this is the
 * one place of the arithmetic where the data can saturate.
 *
 * Between the scalar updates of one measurement a mean may leave its word: its bits from 2^32
 * words on are a signed CARRY in the upper byte of its low word, which is 0 otherwise.  That holds
 * 64 words; a mean with carries is marked (MEAN_WIDE), and only the functions that say so read one.
 *
 * WIDE numbers are int64_t in units of 2^-24; sums of products are in units of 2^-26.
 */
#ifndef KQ_SRC_ARITHMETIC_MEAN_Q31_H
#define KQ_SRC_ARITHMETIC_MEAN_Q31_H

#include "q31.h"

#define MEAN_PLANES 2

typedef int64_t wide;

static const int64_t wide_max = (INT64_C(1) << 55) - 1;
static const int64_t carried_max = (INT64_C(1) << 61) - 1;

/* Among events: a mean has a carry, and is to be held within its word when the call ends. */
enum { MEAN_WIDE = 0x4000, mean_widens = 1 };

static inline wide wide_get(const int32_t *x, int n, int i)
{
    return shift_up_wide(x[i], 24, 55) | (uint32_t)x[n + i];
}

static inline void wide_set(int32_t *x, int n, int i, wide value)
{
    x[i] = (int32_t)(value >> 24); /* |value| < 2^55 */
    x[n + i] = (int32_t)(value & 0xffffff);
}

static inline wide wide_saturated(int64_t value) { return held_within(value, wide_max); }

/* Is it within the word by the top word alone, which tells most? */
static inline int is_within_word(int64_t value)
{
    const int32_t top = (int32_t)(value >> 32), most = (INT32_C(1) << 23) - 1;
    return top >= -most && top <= most;
}

/* *x <- value, held within the word; answers whether it had to be */
KQ_SHARED unsigned wide_set_saturated(int32_t *x, int n, int64_t value)
{
    const wide held = is_within_word(value) ? value : wide_saturated(value);
    wide_set(x, n, 0, held);
    return held == value ? 0 : KQ_EVENT_SATURATED;
}

/* x_i where it may have carries, |x_i| <= 2^61 */
static inline wide carried_get(const int32_t *x, int n, int i)
{
    const wide carry = shift_up_wide(x[n + i] >> 24, 56, 61);
    return carry + shift_up_wide(x[i], 24, 55) + (x[n + i] & 0xffffff);
}

/* Beyond the word: with a carry, and held where that ends */
KQ_COLD KQ_NOINLINE static unsigned carried_set(int32_t *x, int n, int64_t value)
{
    const wide held = held_within(value, carried_max);
    const uint32_t carry = (uint32_t)(((int32_t)(held >> 32) + (INT32_C(1) << 23)) >> 24);
    x[0] = (int32_t)(uint32_t)((uint64_t)held >> 24);
    x[n] = (int32_t)(carry << 24 | (uint32_t)(held & 0xffffff));
    if (held != value) return MEAN_WIDE | KQ_EVENT_SATURATED;
    return wide_saturated(value) == value ? 0 : MEAN_WIDE;
}

/* As it is, with a carry if need be; answers MEAN_WIDE then */
static inline unsigned wide_set_carried(int32_t *x, int n, int i, int64_t value)
{
    if (!is_within_word(value)) return carried_set(x + i, n, value);
    wide_set(x, n, i, value);
    return 0;
}

/* The mean that a call leaves: within its word */
static inline unsigned mean_saturate(int32_t *x, int n, int i)
{
    return wide_set_saturated(x + i, n, carried_get(x, n, i));
}

/* A mean that mean_saturate has seen */
static inline extent mean_extent(const int32_t *x, int n, int i)
{
    (void)x, (void)n, (void)i;
    return 0;
}

/*
 * c (high + low 2^-24) in units of 2^exponent: |c.mantissa| < 2^31, |high| <= 2^31, and |low|
 * <= 2^31, if there is a carry in it that does not belong there: below 2^62 + 2^39.
 */
static inline int64_t word_product(scaled c, int32_t high, int32_t low)
{
    return sum_of(product(c.mantissa, high), product(c.mantissa, low) >> 24, 63);
}

/* c x_i in units of 2^-26, rounded; |c| <= 16, which is 2^30 2^-26, so nothing is shifted up. */
static inline int64_t wide_product_inline(scaled c, int32_t high, int32_t low)
{
    return shift_down_rounded_wide(word_product(c, high, low), -26 - c.exponent);
}

/* One copy for all but the maps of a lag, which have many */
KQ_SHARED int64_t wide_product(scaled c, int32_t high, int32_t low) { return wide_product_inline(c, high, low); }

/* x_i as one word, and what that leaves */
KQ_SHARED int32_t mean_get(const int32_t *x, int n, int i)
{
    const int32_t word = x[i], is_upper = x[n + i] >> 23; /* of the halves between two words */
    if (word < INT32_MAX) return word + is_upper < -INT32_MAX ? -INT32_MAX : word + is_upper;
    return word;
}

static inline int32_t mean_low(const int32_t *x, int n, int i)
{
    return (int32_t)(wide_get(x, n, i) - shift_up_wide(mean_get(x, n, i), 24, 55));
}

/* p 2^shift as a wide number, cut at 2^bits: the sum that it is for has to be beyond its own bound
   then, or asks was_cut */
KQ_NOINLINE static wide wide_from(int64_t p, int32_t shift, int bits)
{
    const int64_t sign = p >> 63;
    const uint64_t upper = UINT32_C(1) << (bits - 32); /* of 2^bits: a shift of 64 bits by a variable would be a call */
    wide value = sign ^ INT64_MAX; /* what has no room is cut */
    if (p == 0) return 0;
    if (shift <= 0) value = shift_down_rounded_wide(p, -shift);
    else if (shift < leading_zeros_wide((uint64_t)(p ^ sign)) - (63 - bits)) value = shift_up_wide(p, (int)shift, bits);
    return held_within(value, (int64_t)(upper << 32));
}

static inline unsigned was_cut(wide a, int bits)
{
    return a == INT64_C(1) << bits || a == -(INT64_C(1) << bits) ? KQ_EVENT_SATURATED : 0;
}

/* x_i += b w, x being without carries.  b: any mantissa below 2^30, so that a product that is
   shifted down by 6 bits or more is below the word.  One that is cut takes x beyond carried_max. */
KQ_KERNEL unsigned mean_correct(int32_t *x, int n, int i, scaled b, scaled w)
{
    const int64_t p = product(b.mantissa, w.mantissa);
    const int32_t down = -24 - b.exponent - w.exponent;
    const wide d = down >= 6 ? shift_down_rounded_wide(p, down) : wide_from(p, -down, 62);
    return wide_set_carried(x, n, i, sum_of(wide_get(x, n, i), d, 63));
}

/* mean_correct where x may have carries: |x| < 2^61, so that nothing is cut unseen */
KQ_COLD static inline unsigned mean_correct_exactly(int32_t *x, int n, int i, scaled b, scaled w)
{
    const wide d = wide_from(product(b.mantissa, w.mantissa), b.exponent + w.exponent + 24, 62);
    return wide_set_carried(x, n, i, sum_of(carried_get(x, n, i), d, 63));
}

static inline void mean_set(int32_t *x, int n, int i, int32_t value)
{
    x[i] = value;
    x[n + i] = 0;
}

/* x += d words and low 2^-24 ones; low: NULL for none.  Both without carries */
KQ_SHARED extent mean_shift(int32_t *x, int n, const int32_t *d, const int32_t *low)
{
    unsigned events = 0;
    for (int i = 0; i < n; i++) {
        const wide move = shift_up_wide(d[i], 24, 55) | (uint32_t)(low ? low[i] : 0);
        events |= wide_set_saturated(x + i, n, sum_of(wide_get(x, n, i), move, 57));
    }
    return events;
}

/* Without a carry, as every call leaves it */
static inline int mean_is_possible(const int32_t *x, int n, int i)
{
    return (uint32_t)x[n + i] >> 24 == 0;
}

KQ_KERNEL void mean_settle(int32_t *x, int n) { (void)x, (void)n; }

/* t <- x, to be read while x is overwritten */
KQ_KERNEL void mean_copy(int32_t *t, const int32_t *x, int n)
{
    for (const int32_t *end = x + 2 * n; x != end;) *t++ = *x++;
}

/* sum_k row_k u_k, in units of 2^-26.  Init has checked that sum |A_ik| + sum |B_ik| <= 16, so
   all sums of a row stay below 16 2^57 = 2^61, and their rounding. */
KQ_SHARED int64_t control_drive(const scaled *row, const int32_t *u, int count)
{
    int64_t sum = 0;
    for (int k = 0; k < count; k++) {
        if (row[k].mantissa != 0) sum = sum_of(sum, wide_product(row[k], u[k], 0), 62);
    }
    return sum;
}

/* Nothing of A is rounded here. */
enum { mean_rounds = 0 };

static inline int transition_is_rounded(const scaled *A, int n)
{
    (void)A, (void)n;
    return 0;
}

static inline void mean_take_rests(int32_t *x, const scaled *A, int32_t *t, int n)
{
    (void)x, (void)A, (void)t, (void)n;
}

/* x_i <- row't + *drive, where t is a copy of x and the row is zero left of `first`; drive is NULL
   where there is none */
KQ_KERNEL extent mean_advance(int32_t *x, int n, int i, const scaled *row, int first,
                                const int32_t *t, const int64_t *drive)
{
    int64_t sum = drive ? *drive : 0;
    KQ_UNROLL
    for (int k = first; k < n; k++) {
        if (row[k].mantissa == 0) continue;
        sum = sum_of(sum, wide_product(row[k], t[k], t[n + k]), 62);
    }
    return wide_set_saturated(x + i, n, shift_down_rounded_wide(sum, 2));
}

/*
 * z - h'x, h being 0 outside of from .. to-1.  |z| 2^26 < 2^57, and |h'x| 2^26 <= 2^61 by init's
 * check.  Of a mean with carries it is not the residual, but within the same bound: a low word
 * of 2^31 is 2^7 words.
 */
KQ_KERNEL scaled mean_residual(int32_t z, const scaled *h, const int32_t *x, int n, int from,
                               int to)
{
    int64_t sum = shift_up_wide(z, 26, 57);
    for (int k = from; k < to; k++) {
        if (h[k].mantissa == 0) continue;
        sum = sum_of(sum, -wide_product(h[k], x[k], x[n + k]), 62);
    }
    return scaled_of(sum, -26);
}

/* A mean in fixed point is rounded far below its sigma. */
static inline scaled mean_terms(const scaled *a, const int32_t *x, int n, int own)
{
    (void)a, (void)x, (void)n, (void)own;
    return scaled_zero();
}

static inline scaled mean_size(const int32_t *x, int n, int i)
{
    (void)x, (void)n, (void)i;
    return scaled_zero();
}

static inline scaled mean_rounding(const scaled *a, const int32_t *x, int n, int own)
{
    return mean_terms(a, x, n, own);
}

/*
 * The same of a mean with carries, all of it: the words into `low`, in units of 2^-26, which stays
 * below 2^57 + 2^61 + 16 2^32, and the carries into `high`, in units of 2^6, and what these leave.
 * A carry of 2^5 at most times a mantissa is below 2^36.
 */
KQ_COLD KQ_NOINLINE static scaled mean_residual_carried(int32_t z, const scaled *h, const int32_t *x, int n)
{
    int64_t low = shift_up_wide(z, 26, 57), high = 0;
    for (int k = 0; k < n; k++) {
        if (h[k].mantissa == 0) continue;
        const int64_t carry = -product(h[k].mantissa, x[n + k] >> 24);
        const int32_t down = -26 - h[k].exponent; /* >= 0 */
        int64_t rest;
        if (down > 32) {
            rest = shift_down_rounded_wide(carry, down - 32);
        } else {
            high = sum_of(high, carry >> down, 41);
            rest = (uint32_t)((uint64_t)carry << (32 - down));
        }
        low = sum_of(low, rest - wide_product(h[k], x[k], x[n + k] & 0xffffff), 62);
    }
    high = sum_of(high, low >> 32, 42);
    if (high > INT32_MAX || high < INT32_MIN) return scaled_of(high, 6);
    return scaled_of(shift_up_wide(high, 32, 63) + (int64_t)((uint64_t)low & UINT32_MAX), -26);
}

/* What mean_residual lacks of a mean with carries, to the last bits of a number: less code than mean_residual_carried.
   A carry stands at 2^32 words, and was read as one at 1. */
KQ_COLD KQ_NOINLINE static void mean_take_carries(scaled *e, const scaled *h, const int32_t *x, int n)
{
    for (int k = 0; k < n; k++) {
        const scaled read = scaled_of_word(-(x[n + k] >> 24)), lacking = scaled_minus(scaled_shift(read, 32), read);
        scaled_add_times(e, h + k, &lacking);
    }
}

#endif
