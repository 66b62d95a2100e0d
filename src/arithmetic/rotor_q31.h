#ifndef KQ_SRC_ARITHMETIC_ROTOR_Q31_H
#define KQ_SRC_ARITHMETIC_ROTOR_Q31_H

#include "rows_q31.h"

/* No measurement is sharper than the mean's last bit, unless s is not far above that itself: a
   noise-free one leaves a variance below the floor. */
static inline scaled least_noise(scaled r, scaled s, const scaled *h, int n)
{
    const scaled sharp = scaled_shift(s, -30);
    if (!scaled_is_less(r, sharp)) return r;
    const scaled last_bit = mean_resolution(h, n);
    const scaled least = scaled_is_less(sharp, last_bit) ? sharp : last_bit;
    return scaled_is_less(r, least) ? least : r;
}

/* Has it no low noise?  r >= 2^-8 s, and s above the variance that counts as 0 */
static inline int is_blunt(scaled r, scaled s, scaled e)
{
    (void)e;
    return r.mantissa > 0 && r.exponent > s.exponent - 8 && s.exponent > num_zero_variance.exponent;
}

/* Is there nothing for the careful update (low_noise.h): no low noise, and does it say enough? */
static inline int is_ordinary(scaled r, scaled s, scaled e) { return is_blunt(r, s, e) && !is_weak(r, s); }

/* May a sensor without the careful path take it?  It may where r >= 2^-16 s, and where r < 2^-17 s it
   may not: up to 9 more of 31 bits are lost than to what is ordinary. */
static inline int has_noise_enough(scaled r, scaled s, scaled e)
{
    (void)e;
    return r.mantissa > 0 && r.exponent >= s.exponent - 16 && s.exponent > num_zero_variance.exponent;
}

/* Raises the noise r of a low-noise measurement to twice the least that has_noise_enough takes; s grows with r. */
static inline int raise_noise(scaled *r, scaled s)
{
    const int counts = s.mantissa && s.exponent > num_zero_variance.exponent;
    *r = counts ? scaled_shift(s, -15) : scaled_shift(num_zero_variance, 1);
    return 1;
}

static inline int noise_is_ordinary(scaled r) { return r.mantissa > 0; }

static inline int is_certainly_blunt(scaled r, scaled s, scaled e) { return is_blunt(r, s, e); }

/*
 * The state of Carlson's sums a_j = r + f_0^2 + ... + f_j^2.  All in units of 2^(2 exponent),
 * where the last of them, the innovation variance, is in [2^59, 2^61); f moves by `down`.
 * root = sqrt(a) 2^(zeros/2 - 1), inverse = 2^(63 - zeros/2) / sqrt(a).
 */
typedef struct {
    uint64_t a;
    uint32_t root, inverse;
    int zeros;
    int32_t exponent, down;
} rotor;

/* The cosine and the sine of a rotation in Q31 */
typedef struct {
    int32_t c, t;
} rotation;

static inline void rotor_take_root(rotor *t)
{
    t->zeros = leading_zeros_wide(t->a) & ~1;
    const uint32_t v = upper_word_raised(t->a, t->zeros);
    t->inverse = inverse_root(v);
    t->root = root_by_inverse(v, t->inverse);
}

/* s = r + f'f, normalised */
KQ_KERNEL void rotor_begin(rotor *t, scaled r, scaled s, const int32_t *f, int n)
{
    t->exponent = (s.exponent - 29) >> 1;
    t->down = t->exponent - f[n];
    const int32_t up = r.exponent - 2 * t->exponent; /* <= 31, since r <= s */
    t->a = (uint64_t)(up >= 0 ? shift_up_word(r.mantissa, (int)up, 62)
                              : shift_down_rounded(r.mantissa, -up));
    if (t->a == 0) t->a = 1;
    rotor_take_root(t);
}

static inline int is_no_turn(int32_t f) { return f == 0; }

/* (p + 2^30) 2^-31 2^-down, rounded down, at most 1 in Q31 */
static inline int32_t cosine_of(uint64_t p, int down)
{
    p += UINT32_C(1) << 30;
    const uint32_t high = upper_word(p);
    const uint32_t c = down ? high >> (down - 1) : high << 1 | (uint32_t)p >> 31;
    if (down ? c > INT32_MAX : high >> 30) return INT32_MAX;
    return (int32_t)c;
}

/* p 2^-30, rounded, held within -1 and 1 in Q31, which the upper word alone tells of most */
static inline int32_t sine_of(int64_t p)
{
    const uint32_t most = (UINT32_C(1) << 29) - 2;
    if (upper_word((uint64_t)p) + most < 2 * most) return round_to_word(p, 30, 31);
    const int64_t sine = (p + (INT32_C(1) << 29)) >> 30;
    return sine > INT32_MAX ? INT32_MAX : sine < -INT32_MAX ? -INT32_MAX : (int32_t)sine;
}

/* c = sqrt(a_before / a),  t = f / sqrt(a); |f| < sqrt(a), which is below 2^(32 - zeros/2).  The two words are packed
   as those of a number are. */
KQ_OF_WORDS packed packed_turn(rotor *t, int32_t f)
{
    const uint32_t root = t->root;
    const int zeros = t->zeros;
    f = t->down >= 0 ? shift_down_rounded(f, t->down) : shift_up(f, (int)-t->down, 31);
    t->a += (uint64_t)product(f, f); /* <= s < 2^61, and its rounding */
    rotor_take_root(t);
    const int32_t c = cosine_of(product_unsigned(root, t->inverse), (zeros - t->zeros) >> 1);
    const int32_t tall = shift_up(f, t->zeros / 2 - 1, 31), half = (int32_t)(t->inverse >> 1);
    return pack(((scaled){c, sine_of(product(tall, half))}));
}

KQ_OF_NUMBERS rotation rotor_turn(rotor *t, int32_t f)
{
    const scaled words = unpack(packed_turn(t, f));
    return (rotation){words.mantissa, words.exponent};
}

/*
 * Column s of S, b_last being 0 before: s <- c s - t b,  b <- c b + t s: a row of S and its b are
 * together as long as the row was, so no row's norm grows but by rounding (rotate_words).  At the end b = S f / sqrt(a).
 */
KQ_KERNEL void rotate(int32_t *restrict s, int32_t *restrict b, rotation turn, int last)
{
    rotate_words(s, b, turn.c, turn.t, last);
}

/* The mean is to move by b times e / sqrt(a). */
static inline scaled rotor_weight(const rotor *t, scaled e, scaled s)
{
    (void)s;
    const int32_t half = (int32_t)(t->inverse >> 1);
    return scaled_of_product(e.mantissa, half, e.exponent + t->zeros / 2 - 62 - t->exponent);
}

static inline scaled weight_nis(scaled w, scaled e)
{
    (void)e;
    return scaled_times(w, w);
}

/* b_i in units of word i: not normalised */
static inline scaled column_entry(const int32_t *b, const int32_t *S, int n, int i)
{
    return (scaled){b[i], S[KQ_TRIANGLE(n) + i]};
}

/* Rows are at most sqrt(r / s) as long as before: where that may be below 1/2 they are renormalised
   at once, not only at the end of the update. */
static inline void renormalise_if_strong(int32_t *S, scaled r, scaled s, int n)
{
    if (r.exponent < s.exponent) renormalise(S, n);
}

#endif
