/*
 * Rows of a matrix in floating point, where a row needs no exponent: the twin of rows_q31.h, which
 * says what each operation is.
 */
#ifndef KALMANQ_ROWS_H
#define KALMANQ_ROWS_H

#include "scaled_float.h"
#include "triangle.h"

typedef num sum;

#define ROW_LEN(width) (width)
#define ROOT_LEN(n) KQ_TRIANGLE(n)
#define SCALED_WORDS 1

static const int32_t lowest_exponent = 0;
static const int32_t one_exponent = 0;
static const num num_one = 1;

static inline const num *exponents_of(const num *S, int n) { return S + KQ_TRIANGLE(n); }

static inline void row_set_exponent(num *row, int width, int32_t exponent)
{
    (void)row, (void)width, (void)exponent;
}

static inline scaled row_entry(const num *row, int width, int k)
{
    (void)width;
    return row[k];
}

static inline sum add_product(sum total, num a, num b) { return total + a * b; }

static inline sum dot(sum total, const num *a, const num *b, int count)
{
    for (int k = 0; k < count; k++) total = add_product(total, a[k], b[k]);
    return total;
}

static inline scaled row_product(const num *a, const num *b, int width)
{
    return dot(0, a, b, width);
}

static inline const num *align(num *c, const scaled *row, const num *E, int stride, int count,
                               int32_t *exponent)
{
    (void)c, (void)E, (void)stride, (void)count, (void)exponent;
    return row;
}

static inline scaled root_entry(const num *S, int n, int i, int k)
{
    (void)n;
    return S[column(k) + i];
}

static inline scaled root_sum(sum total, const num *S, int n, int i, int j)
{
    (void)S, (void)n, (void)i, (void)j;
    return total;
}

static inline void row_of(num *row, const scaled *entries, int width)
{
    for (int k = 0; k < width; k++) row[k] = entries[k];
}

static inline num combined(sum total) { return total; }

static inline int32_t noise_exponent(const num *G, int n, int l)
{
    (void)G, (void)n, (void)l;
    return 0;
}

static inline num noise_entry(const num *G, int n, int l, int i, const num *row, int width)
{
    (void)n, (void)row, (void)width;
    if (!G) return i == l ? num_tiny_root : 0;
    return G[column(i) + l];
}

static inline num reflector_pivot(const num *G, int i) { return G ? G[column(i) + i] : 0; }

/* r and g_pivot are not normalised: p = 1 / s and q = 1 / (s + g_pivot), s their norm */
static inline num reflect(num *restrict w, num g, const num *restrict r, num g_pivot, num p, num q,
                          int count)
{
    const num entry = dot(g * g_pivot, w, r, count) * p;
    const num factor = -(entry + g) * q;
    for (int k = 0; k < count; k++) w[k] += factor * r[k];
    return entry;
}

/* G_ii >= num_tiny_root, so no norm is ever 0 and nothing needs a test. */
static inline num close_reflector(num *w, num g, num *p, num *q, int count)
{
    const num s = num_root(dot(g * g, w, w, count));
    *p = 1 / s;
    *q = 1 / (s + g);
    return s;
}

static inline void root_take_exponent(num *S, int n, int l, const num *row, int width)
{
    (void)S, (void)n, (void)l, (void)row, (void)width;
}

static inline void renormalise(num *S, int n) { (void)S, (void)n; }

/* ------------------------------------------------------------------ update */

/*
 * What rounding alone makes of h'S S'h, squared sums of its terms' sizes: a variance below
 * it says nothing.  (16 eps)^2: f's own rounding, and that of S from earlier updates.
 */
static num rounding_floor(const num *S, const num *h, const num *f, int n)
{
    (void)f;
    num total = 0;
    for (int j = 0; j < n; j++) {
        num size = 0;
        for (int i = 0; i <= j; i++) size += num_magnitude(h[i] * S[column(j) + i]);
        total += size * size;
    }
    return 256 * num_epsilon * num_epsilon * total;
}

static inline scaled least_noise(scaled r, scaled s, const scaled *h, int n)
{
    (void)s, (void)h, (void)n;
    return r;
}

typedef struct {
    num a;
} rotor;

typedef struct {
    num c, g, f;
} rotation;

static inline rotor rotor_begin(scaled r, scaled s, const num *f, int n)
{
    (void)s, (void)f, (void)n;
    return (rotor){.a = r};
}

/* Two divisions, not one reciprocal: its rounding would add up in steady operation. */
static inline rotation rotor_turn(rotor *t, num f)
{
    const num before = t->a;
    t->a += f * f;
    const num c = num_root(before / t->a);
    return (rotation){.c = c, .g = c * (f / before), .f = f};
}

static inline void rotate(num *s, scaled *b, rotation turn)
{
    const num old = *s;
    *s = turn.c * old - turn.g * *b;
    *b += turn.f * old;
}

static inline void rotor_end(const rotor *t, num *S, scaled *b, int n)
{
    (void)t, (void)S, (void)b, (void)n;
}

#endif
