/*
 * Numbers of any size in integers: mantissa 2^exponent, 2^30 <= |mantissa| < 2^31, or 0.  For
 * what has no bound known beforehand: variances, gains, coefficients.  Each operation is
 * correct to about 2^-30.
 */
#ifndef KQ_SRC_ARITHMETIC_SCALED_Q31_H
#define KQ_SRC_ARITHMETIC_SCALED_Q31_H

#include "kalmanq/fixed_point.h"
#include "inverse_q31.h"
#include "fixed.h"

typedef kq_scaled_q31 scaled;

/* a, held at +-most */
KQ_SHARED int64_t held_within(int64_t a, int64_t most) { return a > most ? most : a < -most ? -most : a; }

/* What tells a number from others, in 32 bits */
static inline uint32_t scaled_bits(scaled a)
{
    return (uint32_t)a.mantissa ^ (uint32_t)a.exponent * UINT32_C(0x9e3779b1);
}

/* 2^k */
#define SCALED_POWER(k) {INT32_C(1) << 30, (k) - 30}

static const scaled scaled_one = SCALED_POWER(0);

/* A word with so many bits behind the point.  Its mantissa is not normalised: for products that take such a factor */
KQ_INLINE scaled scaled_fraction(int32_t word, int32_t bits) { return (scaled){word, -bits}; }

/* 0 by two stores: of (scaled){0} gcc makes a call for a Cortex-M0 */
static inline scaled scaled_zero(void)
{
    scaled a;
    a.mantissa = 0;
    a.exponent = 0;
    return a;
}

/* A large operation is two functions: packed_... of words, and scaled_... of numbers.  One of them is called, the other
   is inlined into it or into its callers.  Arm returns a number, a struct, through memory, but 64 bits in registers. */
#if defined(__arm__)
#define KQ_OF_WORDS KQ_SHARED
#define KQ_OF_NUMBERS KQ_INLINE
typedef uint64_t packed;

KQ_INLINE packed pack(scaled a) { return (uint64_t)(uint32_t)a.exponent << 32 | (uint32_t)a.mantissa; }

KQ_INLINE scaled unpack(packed a) { return (scaled){(int32_t)(uint32_t)a, (int32_t)(uint32_t)(a >> 32)}; }
#else
#define KQ_OF_WORDS KQ_INLINE
#define KQ_OF_NUMBERS KQ_SHARED
typedef scaled packed;

#define pack(number) (number)
#define unpack(number) (number)
#endif

static inline scaled scaled_negative(scaled a) { return (scaled){-a.mantissa, a.exponent}; }

/* a 2^exponent, rounded, a > 0 */
KQ_OF_WORDS packed packed_of_positive(uint64_t a, int32_t exponent)
{
    const int zeros = leading_zeros_wide(a);
    const uint32_t top = upper_word_raised(a, zeros);
    uint32_t mantissa = (top >> 1) + (top & 1); /* 2^30 .. 2^31 */
    exponent += 33 - zeros;
    if (mantissa >> 31) {
        mantissa >>= 1;
        exponent++;
    }
    return pack(((scaled){(int32_t)mantissa, exponent}));
}

KQ_OF_NUMBERS scaled scaled_of_positive(uint64_t a, int32_t exponent)
{
    return unpack(packed_of_positive(a, exponent));
}

/* a 2^exponent, rounded */
KQ_OF_WORDS packed packed_of_wide(int64_t a, int32_t exponent)
{
    if (a == 0) return pack(((scaled){0, 0}));
    if (a > 0) return pack(scaled_of_positive((uint64_t)a, exponent));
    return pack(scaled_negative(scaled_of_positive(0 - (uint64_t)a, exponent)));
}

KQ_OF_NUMBERS scaled scaled_of(int64_t a, int32_t exponent) { return unpack(packed_of_wide(a, exponent)); }

/* a with a normalised mantissa */
static inline scaled scaled_normal(scaled a) { return scaled_of(a.mantissa, a.exponent); }

static inline int scaled_is_zero(scaled a) { return a.mantissa == 0; }
/* Does a factor of a leave every bit as it is?  2^k, k any */
static inline int scaled_is_unit(scaled a) { return a.mantissa == INT32_C(1) << 30; }

static inline int scaled_is_negative(scaled a) { return a.mantissa < 0; }

/* a whole number */
static inline scaled scaled_of_count(int32_t count) { return scaled_of(count, 0); }

/* a 2^shift */
static inline scaled scaled_shift(scaled a, int32_t shift)
{
    return (scaled){a.mantissa, a.mantissa ? a.exponent + shift : 0};
}

/* a b 2^exponent for normalised mantissas, or 0: the product is in [2^60, 2^62) */
KQ_OF_WORDS packed packed_of_product(int32_t a, int32_t b, int32_t exponent)
{
    const int64_t p = product(a, b);
    const int32_t long_one = round_to_word(p, 31, 31);
    if (p == 0) return pack(((scaled){0, 0}));
    if (magnitude(long_one) >> 30) return pack(((scaled){long_one, exponent + 31}));
    return pack(((scaled){round_to_word(p, 30, 31), exponent + 30}));
}

KQ_OF_NUMBERS scaled scaled_of_product(int32_t a, int32_t b, int32_t exponent)
{
    return unpack(packed_of_product(a, b, exponent));
}

/* The exponent of a turned bit may be any: the sum wraps. */
static inline scaled scaled_times(scaled a, scaled b)
{
    return scaled_of_product(a.mantissa, b.mantissa, (int32_t)((uint32_t)a.exponent + (uint32_t)b.exponent));
}

/* b != 0.  1 / |b| = reciprocal(2 |b|) 2^-62; exponent: a's less b's */
KQ_OF_WORDS packed packed_over(int32_t a, int32_t b, int32_t exponent)
{
    const int32_t inverse = (int32_t)(reciprocal(magnitude(b) << 1) >> 1);
    return pack(scaled_of_product(b < 0 ? -a : a, inverse, exponent - 61));
}

KQ_OF_NUMBERS scaled scaled_over(scaled a, scaled b)
{
    return unpack(packed_over(a.mantissa, b.mantissa, a.exponent - b.exponent));
}

KQ_OF_WORDS packed packed_plus(int32_t a, int32_t p, int32_t b, int32_t q)
{
    if (a == 0) return pack(((scaled){b, q}));
    if (b == 0) return pack(((scaled){a, p}));
    if (p < q) {
        const int32_t larger = b, exponent = q;
        b = a, q = p;
        a = larger, p = exponent;
    }
    const int64_t high = shift_up_wide(a, 30, 61), low = shift_up_wide(b, 30, 61);
    const uint32_t down = (uint32_t)p - (uint32_t)q;
    return pack(scaled_of(sum_of(high, down < 63 ? low >> down : 0, 62), p - 30));
}

KQ_OF_NUMBERS scaled scaled_plus(scaled a, scaled b)
{
    return unpack(packed_plus(a.mantissa, a.exponent, b.mantissa, b.exponent));
}

static inline scaled scaled_minus(scaled a, scaled b) { return scaled_plus(a, scaled_negative(b)); }

/* In place, for cold code: *total <- *total + a, and + a b */
KQ_COLD KQ_NOINLINE static void scaled_add(scaled *total, const scaled *a) { *total = scaled_plus(*total, *a); }

KQ_COLD KQ_NOINLINE static void scaled_add_times(scaled *total, const scaled *a, const scaled *b)
{
    *total = scaled_plus(*total, scaled_times(*a, *b));
}

/* a 2^p + b 2^q, rounded once */
KQ_SHARED packed packed_of_sum(int64_t a, int64_t b, int32_t p, int32_t q)
{
    int32_t down = p - q;
    if (a == 0 || (b != 0 && down < 0)) {
        const int64_t other = a;
        a = b;
        b = other;
        p = q;
        down = -down;
    }
    if (b != 0) a = sum_of(a, down < 63 ? b >> down : 0, 63);
    return pack(scaled_of(a, p));
}

/* a b + c d, rounded once; the mantissas need not be normalised */
static inline scaled scaled_products(scaled a, scaled b, scaled c, scaled d)
{
    return unpack(packed_of_sum(product(a.mantissa, b.mantissa), product(c.mantissa, d.mantissa),
                                a.exponent + b.exponent, c.exponent + d.exponent));
}

/* total + a^2 */
KQ_OF_WORDS packed packed_square_added(int32_t total, int32_t p, int32_t a, int32_t q)
{
    return packed_of_sum(shift_up_wide(total, 30, 61), product(a, a), p - 30, 2 * q);
}

KQ_OF_NUMBERS scaled scaled_add_square(scaled total, scaled a)
{
    return unpack(packed_square_added(total.mantissa, total.exponent, a.mantissa, a.exponent));
}

/* a >= 0: sqrt(m 2^e) = sqrt(v) 2^((e - odd) / 2), v = m or, for e odd, 2 m: in [2^30, 2^32) */
KQ_OF_WORDS packed packed_root(int32_t a, int32_t exponent)
{
    if (a <= 0) return pack(((scaled){0, 0}));
    const int odd = exponent & 1;
    const uint32_t v = (uint32_t)a << odd;
    const uint32_t root = root_by_inverse(v, inverse_root(v)); /* sqrt(v) 2^15 < 2^31 */
    const uint32_t least = UINT32_C(1) << 30;                  /* 1 is held just below */
    return pack(((scaled){(int32_t)(root < least ? least : root), (exponent - odd) / 2 - 15}));
}

KQ_OF_NUMBERS scaled scaled_root(scaled a) { return unpack(packed_root(a.mantissa, a.exponent)); }

static inline scaled scaled_of_word(int32_t a) { return scaled_of(a, 0); }

/* a 2^p < b 2^q, for a, b >= 0 */
KQ_SHARED int words_are_less(int32_t a, int32_t p, int32_t b, int32_t q)
{
    if (a == 0 || b == 0) return a < b;
    return p < q || (p == q && a < b);
}

KQ_INLINE int scaled_is_less(scaled a, scaled b)
{
    if (KQ_IS_KNOWN(a.mantissa == 0)) return b.mantissa > 0; /* num_tiny is 0 */
    return words_are_less(a.mantissa, a.exponent, b.mantissa, b.exponent);
}

/* floor(log2 |a|), least for a = 0 */
static inline int32_t scaled_log(scaled a) { return a.mantissa ? a.exponent + 30 : -32768; }

static inline scaled scaled_magnitude(scaled a)
{
    return (scaled){a.mantissa < 0 ? -a.mantissa : a.mantissa, a.exponent};
}

static inline int scaled_is_finite(scaled a)
{
    (void)a;
    return 1;
}

/* More than an operation rounds a number by, of its size: 16 units, as in rounding_floor */
static inline scaled scaled_rounding(void) { return (scaled)SCALED_POWER(-26); }

/* A row that holds nothing; what is below it is not followed further down. */
static const int32_t lowest_exponent = -16384;
static const int32_t low_exponent = -8192;
static const int32_t high_exponent = 8192;

/* An exponent that nothing lets grow without end */
static inline scaled scaled_saturated(scaled a)
{
    if (a.exponent < low_exponent) return (scaled){0, 0};
    return (scaled){a.mantissa, a.exponent > high_exponent ? high_exponent : a.exponent};
}

/* a as a word, rounded, held at +-(2^31 - 1) */
static inline int32_t word_of(scaled a)
{
    if (a.exponent > 0) return a.mantissa < 0 ? -INT32_MAX : a.mantissa ? INT32_MAX : 0;
    return shift_down_rounded(a.mantissa, -a.exponent);
}

/* How far means reach, found on the way: they are held at once, and this is the events of it.  What a row
   reaches is its exponent. */
typedef unsigned extent;

KQ_KERNEL extent extent_of(int32_t a)
{
    (void)a;
    return 0;
}

KQ_KERNEL extent extent_join(extent a, extent b) { return a | b; }

#endif
