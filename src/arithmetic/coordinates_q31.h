/*
 * The smoother's numbers: the mean of the coordinates, their root and the tape's rotations.
 *
 * The mean a is wide, in units of 2^-40: held at +-32768 standard deviations, which is an event.
 * The root T and the rows of Theta are rows as everywhere, of norm 1 at most.
 */
#ifndef KQ_SRC_ARITHMETIC_COORDINATES_Q31_H
#define KQ_SRC_ARITHMETIC_COORDINATES_Q31_H

#include "mean_q31.h"
#include "rotor_q31.h"

#define COORDINATE_PLANES 2

static inline wide coordinate_get(const int32_t *a, int n, int i) { return wide_get(a, n, i); }

/* Answers KQ_EVENT_SATURATED if it had to be held. */
static inline unsigned coordinate_set(int32_t *a, int n, int i, wide value)
{
    return wide_set_saturated(a + i, n, value);
}

static const int32_t coordinate_exponent = -40;

static inline scaled coordinate_scaled(wide a) { return scaled_of(a, coordinate_exponent); }

/* *a <- value, held; answers as coordinate_set */
static inline unsigned coordinate_saturate(wide *a, int64_t value)
{
    *a = wide_saturated(value);
    return *a == value ? 0 : KQ_EVENT_SATURATED;
}

static inline unsigned coordinate_of(wide *a, scaled value)
{
    return coordinate_saturate(a, wide_from(value.mantissa, value.exponent - coordinate_exponent, 56));
}

/* An entry of a row of Theta */
KQ_INLINE scaled unit_entry(int32_t entry) { return scaled_fraction(entry, -one_exponent); }

/* c a in units of 2^-26 of a word of a */
static inline int64_t coordinate_part(scaled c, wide a)
{
    if (scaled_is_zero(c)) return 0;
    return wide_product(c, (int32_t)(a >> 24), (int32_t)(a & 0xffffff));
}

/* The first `count` terms of row'a of a row of coordinates; |row| <= 1: at most 16 2^57 */
KQ_KERNEL wide coordinate_dot(const int32_t *row, const int32_t *a, int n, int count)
{
    int64_t total = 0;
    KQ_UNROLL
    for (int k = 0; k < count; k++) {
        const scaled c = unit_entry(row[k]);
        total = sum_of(total, wide_product(c, a[k], a[n + k]), 62);
    }
    return shift_down_rounded_wide(total, 2);
}

/* a <- c a + s b,  b <- c b - s a */
static inline unsigned coordinate_turn(int32_t *a, int n, int i, wide *b, scaled c, scaled s)
{
    const wide old = wide_get(a, n, i);
    const int64_t now = sum_of(coordinate_part(c, old), coordinate_part(s, *b), 60);
    const int64_t other = sum_of(coordinate_part(c, *b), -coordinate_part(s, old), 60);
    const unsigned events = coordinate_saturate(b, shift_down_rounded_wide(other, 2));
    return events | coordinate_set(a, n, i, shift_down_rounded_wide(now, 2));
}

/* One reflector (V, q) backwards: xi += V (alpha - q V'xi); V in Q30, q in Q31, p is not needed */
static inline unsigned reflect_back(int32_t *xi, int n, int first, wide alpha, const int32_t *V,
                                    const int32_t *pq)
{
    wide length, d;
    int64_t along = 0; /* |V| <= 1: at most 16 2^57 */
    for (int k = first; k < n; k++) {
        const scaled c = scaled_fraction(V[k - first], 30);
        along = sum_of(along, wide_product(c, xi[k], xi[n + k]), 62);
    }
    const scaled share = scaled_fraction(pq[1], 31);
    unsigned events = coordinate_saturate(&length, shift_down_rounded_wide(along, 2));
    events |= coordinate_saturate(&d, alpha - shift_down_rounded_wide(coordinate_part(share, length), 2));
    for (int k = first; k < n; k++) {
        const scaled c = scaled_fraction(V[k - first], 30);
        const wide move = shift_down_rounded_wide(coordinate_part(c, d), 2);
        events |= coordinate_set(xi, n, k, sum_of(wide_get(xi, n, k), move, 57));
    }
    return events;
}

/* Row i of a root times a */
static inline scaled mean_part(const scaled *row, const int32_t *a, int n, int i)
{
    scaled total = {0, 0};
    for (int k = i; k < n; k++) {
        const scaled entry = scaled_normal(row[k - i]);
        const scaled mean = coordinate_scaled(coordinate_get(a, n, k));
        total = scaled_plus(total, scaled_times(entry, mean));
    }
    return total;
}

/*
 * x_i and row i of the root times a, of which no part is held.  The row's mantissas, of one
 * exponent, have a norm below 2^30 and the n <= 16 words of a one below 2^33: no sum of their
 * products is beyond 2^63, whatever cancels.  A total that is cut then, at 2^62, takes x_i, which
 * may have carries, beyond carried_max.
 */
static inline int64_t mean_moved(const int32_t *x, int n, int i, const scaled *row,
                                 const int32_t *a)
{
    const int32_t up = row[0].exponent + 24 + coordinate_exponent + 26; /* to units of 2^-26 */
    int64_t total = 0;
    for (int k = i; k < n; k++) {
        const int64_t part = word_product(row[k - i], a[k], a[n + k]);
        total = sum_of(total, up < 0 ? shift_down_rounded_wide(part, -up) : part, 63);
    }
    return sum_of(carried_get(x, n, i), wide_from(total, up > 0 ? up - 2 : -2, 62), 63);
}

/* x_i += row i of the root times a, held */
KQ_SHARED unsigned mean_move(int32_t *x, int n, int i, const scaled *row, const int32_t *a)
{
    return wide_set_saturated(x + i, n, mean_moved(x, n, i, row, a));
}

/* mean_move for an x that is no result yet: it may have carries. */
static inline unsigned mean_gather(int32_t *x, int n, int i, const scaled *row, const int32_t *a)
{
    return wide_set_carried(x, n, i, mean_moved(x, n, i, row, a));
}

/* ------------------------------------------------------------------ rows */

/* Row i of the triangle T and the row u: T_i <- c T_i + s u,  u <- c u - s T_i */
static inline void turn_row(int32_t *T, int n, int i, int32_t *u, scaled c, scaled s)
{
    const scaled now[2] = {c, s}, other[2] = {scaled_negative(s), c};
    const int32_t E[2] = {T[KQ_TRIANGLE(n) + i], u[n]};
    int32_t p[2], q[2], now_exponent = lowest_exponent, other_exponent = lowest_exponent;
    (void)align(p, now, E, 1, 2, &now_exponent);
    (void)align(q, other, E, 1, 2, &other_exponent);
    uint32_t bits = 0;
    for (int j = i; j < n; j++) {
        int32_t *t = T + column(j) + i;
        const int32_t old = *t;
        *t = combined(sum_of(product(p[0], old), product(p[1], u[j]), 62));
        u[j] = combined(sum_of(product(q[0], old), product(q[1], u[j]), 62));
        bits |= magnitude(u[j]);
    }
    T[KQ_TRIANGLE(n) + i] = now_exponent;
    const int up = bits ? leading_zeros(bits) - 4 : 0; /* n <= 16 entries of 28 bits */
    for (int j = i; up > 0 && j < n; j++) u[j] = shift_up(u[j], up, 30);
    u[n] = bits ? other_exponent - (up > 0 ? up : 0) : lowest_exponent;
}

/* The row [row T, beta], beta (n words behind) being in units of 2^one_exponent: both parts of one
   exponent, `exponent` by align */
KQ_SHARED void row_join(int32_t *row, int n, int32_t exponent)
{
    for (int k = n; k < 2 * n; k++) row[k] = shift_down_rounded(row[k], exponent - one_exponent);
    row[2 * n] = exponent;
}

/* ------------------------------------------------------------------ tape */

/*
 * A rotation in one word: the smaller of |c| and |s| to 26 bits (a sign bit of s, one bit that
 * says which, 5 bits of exponent + 1, 0 for none, and 25 bits behind the leading one).
 * c = before / after, s = f / after.
 */
static inline int32_t rotation_word(scaled f, scaled before, scaled after)
{
    const scaled size = {f.mantissa < 0 ? -f.mantissa : f.mantissa, f.exponent};
    const int is_cosine = !scaled_is_less(size, before);
    const scaled smaller = scaled_over(is_cosine ? before : size, after);
    if (scaled_is_zero(smaller)) return 0;
    uint32_t mantissa = ((uint32_t)smaller.mantissa + 16) >> 5; /* 2^25 .. 2^26 */
    int32_t down = -31 - smaller.exponent;
    if (mantissa >> 26) {
        mantissa >>= 1;
        down--;
    }
    if (down < 0) down = 0;
    if (down > 30) down = 30;
    const uint32_t word = (uint32_t)(f.mantissa < 0) << 31 | (uint32_t)is_cosine << 30 |
                          (uint32_t)(down + 1) << 25 | (mantissa & 0x1ffffff);
    return word >> 31 ? -(int32_t)(UINT32_MAX - word) - 1 : (int32_t)word;
}

KQ_SHARED void rotation_of(int32_t word, scaled *c, scaled *s)
{
    const scaled one = SCALED_POWER(0);
    const uint32_t bits = (uint32_t)word;
    const int32_t down = (int32_t)(bits >> 25 & 31) - 1;
    const scaled smaller = {(int32_t)((bits & 0x1ffffff) | 0x2000000) << 5, -31 - down};
    const scaled larger = scaled_root(scaled_minus(one, scaled_times(smaller, smaller)));
    const int is_cosine = bits >> 30 & 1;
    *c = is_cosine ? smaller : larger;
    *s = is_cosine ? larger : smaller;
    if (down < 0) {
        *c = one;
        *s = (scaled){0, 0};
    }
    if (bits >> 31) *s = scaled_negative(*s);
}

static inline int32_t row_exponent(const int32_t *row, int width) { return row[width]; }

static inline void root_set_unit(int32_t *T, int n, int k)
{
    T[column(k) + k] = num_one;
    T[KQ_TRIANGLE(n) + k] = one_exponent;
}

static inline void store_scaled(int32_t *word, scaled a)
{
    word[0] = a.mantissa;
    word[1] = a.exponent;
}

static inline scaled load_scaled(const int32_t *word) { return (scaled){word[0], word[1]}; }

/* Mean and variance of a measurement noise into the update record that they come from, which
   has n + 2 >= 3 words: the variance is 1 at most, in Q30 */
static inline void store_noise(int32_t *record, scaled mean, scaled variance)
{
    store_scaled(record, mean);
    record[2] = word_of(scaled_shift(variance, 30));
}

static inline void load_noise(const int32_t *record, scaled *mean, scaled *variance)
{
    *mean = load_scaled(record);
    *variance = scaled_of(record[2], -30);
}

#endif
