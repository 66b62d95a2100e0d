/* The smoother's numbers in floating point: the twin of coordinates_q31.h. */
#ifndef KQ_SRC_ARITHMETIC_COORDINATES_FLOAT_H
#define KQ_SRC_ARITHMETIC_COORDINATES_FLOAT_H

#include "mean_float.h"
#include "rotor_float.h"
#include "rows_float.h"

#define COORDINATE_PLANES 1

typedef num wide;

static inline wide coordinate_get(const num *a, int n, int i)
{
    (void)n;
    return a[i];
}

/* The events that it answers: none, here as below. */
static inline unsigned coordinate_set(num *a, int n, int i, wide value)
{
    (void)n;
    a[i] = value;
    return 0;
}

static inline scaled coordinate_scaled(wide a) { return a; }

static inline unsigned coordinate_of(wide *a, scaled value)
{
    *a = value;
    return 0;
}

/* An entry of a row of Theta */
static inline scaled unit_entry(num entry) { return entry; }

/* The first `count` >= 1 terms of a row's product with a */
KQ_KERNEL wide coordinate_dot(const num *row, const num *a, int n, int count)
{
    (void)n;
    return dot(row[0] * a[0], row + 1, a + 1, count - 1);
}

static inline unsigned coordinate_turn(num *a, int n, int i, wide *b, scaled c, scaled s)
{
    (void)n;
    const num old = a[i];
    a[i] = c * old + s * *b;
    *b = c * *b - s * old;
    return 0;
}

static inline unsigned reflect_back(num *xi, int n, int first, wide alpha, const num *r,
                                    const num *pq)
{
    const num along = dot(0, r, xi + first, n - first) * pq[1];
    for (int k = first; k < n; k++) xi[k] += (alpha - along) * pq[0] * r[k - first];
    return 0;
}

/* Row i of a root times a */
KQ_KERNEL scaled mean_part(const scaled *row, const num *a, int n, int i)
{
    return dot(row[0] * a[i], row + 1, a + i + 1, n - 1 - i);
}

KQ_KERNEL unsigned mean_move(num *x, int n, int i, const scaled *row, const num *a)
{
    return mean_correct_exactly(x, n, i, mean_part(row, a, n, i), 1);
}

KQ_KERNEL unsigned mean_gather(num *x, int n, int i, const scaled *row, const num *a)
{
    return mean_move(x, n, i, row, a);
}

KQ_KERNEL void turn_row(num *T, int n, int i, num *u, scaled c, scaled s)
{
    num *t = T + column(i) + i;
    u[i] = -s * *t;
    *t *= c;
    KQ_UNROLL
    for (int j = i + 1; j < n; j++) {
        t += j;
        const num old = *t;
        *t = c * old + s * u[j];
        u[j] = c * u[j] - s * old;
    }
}

static inline void row_join(num *row, int n, int32_t exponent)
{
    (void)row, (void)n, (void)exponent;
}

/* s / 2 where |s| < c, otherwise +-2 / c with the sign of s (Stewart, The economical storage of
   plane rotations, Numer. Math. 25, 1976) */
static inline num rotation_word(scaled f, scaled before, scaled after)
{
    if (num_magnitude(f) < before) return num_half * (f / after);
    return (f < 0 ? -2 : 2) * (after / before);
}

static inline void rotation_of(num word, scaled *c, scaled *s)
{
    if (num_magnitude(word) < 1) {
        *s = 2 * word;
        *c = num_root(1 - *s * *s);
    } else {
        *c = 2 / num_magnitude(word);
        *s = num_root(1 - *c * *c);
        if (word < 0) *s = -*s;
    }
}

static inline int32_t row_exponent(const num *row, int width)
{
    (void)row, (void)width;
    return 0;
}

static inline void root_set_unit(num *T, int n, int k)
{
    (void)n;
    T[column(k) + k] = 1;
}

static inline void store_scaled(num *word, scaled a) { *word = a; }
static inline scaled load_scaled(const num *word) { return *word; }

/* Mean and variance of a measurement noise into the update record that they come from */
static inline void store_noise(num *record, scaled mean, scaled variance)
{
    record[0] = mean;
    record[1] = variance;
}

static inline void load_noise(const num *record, scaled *mean, scaled *variance)
{
    *mean = record[0];
    *variance = record[1];
}

#endif
