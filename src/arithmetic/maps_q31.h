/* The maps of coordinates: rows of units, their rotations, and what a map makes of a mean. */
#ifndef KQ_SRC_ARITHMETIC_MAPS_Q31_H
#define KQ_SRC_ARITHMETIC_MAPS_Q31_H

#include "coordinates_q31.h"

/* A sum of products with a unit (smoother/map.h) in units of the other factors: below 2^60 */
static inline int32_t unit_of(int64_t total) { return round_to_word(total, 29, 31); }

/* By how many bits the units of a map may be raised, all `count` of them: to 2^26 at most, rows of
   32 of them below 2^29 */
static inline int unit_room(const int32_t *units, int count)
{
    uint32_t bits = 0;
    for (int k = 0; k < count; k++) bits |= magnitude(units[k]);
    const int up = leading_zeros(bits) - 6;
    return bits && up > 0 ? up : 0;
}

static inline void units_raise(int32_t *units, int up, int count)
{
    for (int k = 0; k < count; k++) units[k] = shift_up(units[k], up, 26);
}

/* S <- S 2^-down */
static inline void root_lower(int32_t *S, int down, int n)
{
    for (int i = 0; i < n; i++) S[KQ_TRIANGLE(n) + i] -= down;
}

static inline scaled turn_number(int32_t c) { return scaled_of(c, -31); }

/* Cosine and sine, in Q31, of the next rotation of an update, by entry f of its row */
static inline void unit_rotation(rotor *t, int32_t f, int32_t *c, int32_t *s)
{
    const rotation turn = rotor_turn(t, f);
    *c = turn.c;
    *s = turn.t;
}

/* The units a and b: (a, b) <- (c a - s b, s a + c b) */
KQ_KERNEL void unit_turn_entry(int32_t *restrict a, int32_t *restrict b, int32_t c, int32_t s)
{
    const int32_t old = *a, other = *b;
    *a = round_to_word(accumulate(product(c, old), -s, other, 62), 31, 30);
    *b = round_to_word(accumulate(product(s, old), c, other, 62), 31, 30);
}

/* Columns of them */
KQ_SHARED void unit_turn(int32_t *restrict a, int32_t *restrict b, int32_t c, int32_t s, int n)
{
    for (int k = 0; k < n; k++) unit_turn_entry(a + k, b + k, c, s);
}

/* nu = e / sqrt(s) */
static inline scaled unit_innovation(const rotor *t, scaled e, scaled s)
{
    return rotor_weight(t, e, s);
}

/* a_i += unit times b */
static inline unsigned coordinate_move(int32_t *a, int n, int i, int32_t unit, scaled b)
{
    const int32_t up = one_exponent + b.exponent - coordinate_exponent;
    const wide d = wide_from(product(unit, b.mantissa), up, 57);
    return coordinate_set(a, n, i, sum_of(wide_get(a, n, i), d, 58));
}

/* shift_k + row k of J a, J by columns; |row| <= 1: at most 16 2^57, and a word more for the shift */
KQ_SHARED wide coordinate_through(const int32_t *J, int k, const int32_t *a, const int32_t *shift,
                                  int n)
{
    int64_t total = 0;
    for (int i = 0; i < n; i++) {
        const scaled c = unit_entry(J[i * n + k]);
        total = sum_of(total, wide_product_inline(c, a[i], a[n + i]), 62);
    }
    return sum_of(wide_get(shift, n, k), shift_down_rounded_wide(total, 2), 60);
}

#endif
