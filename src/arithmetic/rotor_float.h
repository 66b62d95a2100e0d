#ifndef KQ_SRC_ARITHMETIC_ROTOR_FLOAT_H
#define KQ_SRC_ARITHMETIC_ROTOR_FLOAT_H

#include "scaled_float.h"

/* ------------------------------------------------------------------ update */

static inline scaled least_noise(scaled r, scaled s, const scaled *h, int n)
{
    (void)s, (void)h, (void)n;
    return r;
}

/* Has it no low noise, and does it not overflow? */
static inline int is_blunt(scaled r, scaled s, scaled e)
{
    return r >= low_noise_share(s) + num_zero_variance && e * (e / s) <= num_most_nis;
}

/* Is there nothing for the careful update (low_noise.h): no low noise, no overflow, and does it say enough? */
static inline int is_ordinary(scaled r, scaled s, scaled e) { return is_blunt(r, s, e) && !is_weak(r, s); }

/* May a sensor without the careful path take it? */
static inline int has_noise_enough(scaled r, scaled s, scaled e) { return is_blunt(r, s, e); }

/* Raises the noise r of a low-noise measurement to twice the least that has_noise_enough takes; s grows with r.
   Answers 0 where r is that large already, or s no number: the measurement overflows. */
static inline int raise_noise(scaled *r, scaled s)
{
    const num least = 2 * (low_noise_share(s) + num_zero_variance);
    if (!(least > *r && s <= num_max)) return 0;
    *r = least;
    return 1;
}

/* Is a noise large enough for the variance of an innovation, which is no smaller, to count? */
static inline int noise_is_ordinary(scaled r) { return r >= 2 * num_zero_variance; }

/* Is it blunt, in one comparison that some blunt ones fail, too?  r is not below twice its share of
   s, and e^2 / s is below 2^16 or, in double, 2^48. */
static inline int is_certainly_blunt(scaled r, scaled s, scaled e)
{
    return r > num_sure_share * (s + e * e);
}

typedef struct {
    num a;
} rotor;

typedef struct {
    num c, g, f;
} rotation;

static inline void rotor_begin(rotor *t, scaled r, scaled s, const num *f, int n)
{
    (void)s, (void)f, (void)n;
    *t = (rotor){.a = r};
}

/* A turn by 0 costs less than the question. */
static inline int is_no_turn(num f)
{
    (void)f;
    return 0;
}

/* Two divisions, not one reciprocal: its rounding would add up in steady operation. */
KQ_KERNEL rotation rotor_turn(rotor *t, num f)
{
    const num before = t->a;
    t->a += f * f;
    const num c = num_root(before / t->a);
    return (rotation){.c = c, .g = c * (f / before), .f = f};
}

/* Column s of S, b_last being 0 before: s <- c s - g b,  b <- b + f s, which is S f so far. */
KQ_KERNEL void rotate(num *restrict s, num *restrict b, rotation turn, int last)
{
    KQ_UNROLL
    for (int i = 0; i < last; i++) {
        const num old = s[i];
        s[i] = turn.c * old - turn.g * b[i];
        b[i] += turn.f * old;
    }
    b[last] = turn.f * s[last];
    s[last] *= turn.c;
}

/* The x of the state is to move by b times this. */
static inline scaled rotor_weight(const rotor *t, scaled e, scaled s)
{
    (void)t;
    return e / s;
}

static inline scaled weight_nis(scaled w, scaled e) { return w * e; }

static inline scaled column_entry(const num *b, const num *S, int n, int i)
{
    (void)S, (void)n;
    return b[i];
}

KQ_INLINE void renormalise_if_strong(num *S, scaled r, scaled s, int n)
{
    (void)S, (void)r, (void)s, (void)n;
}

#endif
