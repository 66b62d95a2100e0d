/* The maps of coordinates: the twin of maps_q31.h */
#ifndef KQ_SRC_ARITHMETIC_MAPS_FLOAT_H
#define KQ_SRC_ARITHMETIC_MAPS_FLOAT_H

#include "coordinates_float.h"

/* A sum of products with a unit (smoother/map.h) in units of the other factors */
static inline num unit_of(sum total) { return total; }

/* The units of a map have exponents of their own: no need to raise them. */
static inline int unit_room(const num *units, int count)
{
    (void)units, (void)count;
    return 0;
}

static inline void units_raise(num *units, int up, int count)
{
    (void)units, (void)up, (void)count;
}

static inline void root_lower(num *S, int down, int n) { (void)S, (void)down, (void)n; }

/* A cosine or sine as unit_rotation answers it */
static inline scaled turn_number(num c) { return c; }

/* Cosine and sine of the next rotation of an update, by entry f of its row */
static inline void unit_rotation(rotor *t, num f, num *c, num *s)
{
    const num before = t->a;
    t->a += f * f;
    *c = num_root(before / t->a);
    *s = f / num_root(t->a);
}

/* The units a and b: (a, b) <- (c a - s b, s a + c b) */
KQ_KERNEL void unit_turn_entry(num *restrict a, num *restrict b, num c, num s)
{
    const num old = *a;
    *a = c * old - s * *b;
    *b = s * old + c * *b;
}

/* Columns of them */
static inline void unit_turn(num *restrict a, num *restrict b, num c, num s, int n)
{
    for (int k = 0; k < n; k++) unit_turn_entry(a + k, b + k, c, s);
}

/* nu = e / sqrt(s) */
static inline scaled unit_innovation(const rotor *t, scaled e, scaled s)
{
    (void)t;
    return e / num_root(s);
}

/* a_i += unit times b */
static inline unsigned coordinate_move(num *a, int n, int i, num unit, scaled b)
{
    (void)n;
    a[i] += unit * b;
    return 0;
}

/* shift_k + row k of J a, J by columns */
static inline wide coordinate_through(const num *J, int k, const num *a, const num *shift, int n)
{
    num total = shift[k];
    for (int i = 0; i < n; i++) total += J[i * n + k] * a[i];
    return total;
}

#endif
