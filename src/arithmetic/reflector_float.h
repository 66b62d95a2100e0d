#ifndef KQ_SRC_ARITHMETIC_REFLECTOR_FLOAT_H
#define KQ_SRC_ARITHMETIC_REFLECTOR_FLOAT_H

#include "rows_float.h"

static inline int32_t noise_exponent(const num *G, int n, int l)
{
    (void)G, (void)n, (void)l;
    return 0;
}

static inline int32_t noise_shift(const num *G, int n, int l, const num *row, int width)
{
    (void)G, (void)n, (void)l, (void)row, (void)width;
    return 0;
}

static inline num noise_word(const num *g, int32_t shift)
{
    (void)shift;
    return *g;
}

static inline num reflector_pivot(const num *g) { return *g; }

/* r and g_pivot are not normalised: p = 1 / s and q = 1 / (s + g_pivot), s their norm */
KQ_KERNEL num reflect(num *restrict w, num g, const num *restrict r, num g_pivot, const num *pq,
                      int count)
{
    const num entry = dot(g * g_pivot, w, r, count) * pq[0];
    const num factor = -(entry + g) * pq[1];
    KQ_UNROLL
    for (int k = 0; k < count; k++) w[k] += factor * r[k];
    return entry;
}

KQ_KERNEL num reflect_unit(num *restrict w, const num *restrict r, const num *pq, int at, int count)
{
    const num entry = r[at] * pq[0], factor = -entry * pq[1];
    KQ_UNROLL
    for (int k = 0; k < count; k++) w[k] = factor * r[k];
    w[at] += 1;
    return entry;
}

KQ_KERNEL num reflect_longer(num *restrict w, const num *restrict r, const num *pq, int zeros,
                             int count)
{
    const int first = zeros + 1;
    const num entry = dot(w[zeros] * r[zeros], w + first, r + first, count - first) * pq[0];
    const num factor = -entry * pq[1];
    KQ_UNROLL
    for (int k = 0; k < zeros; k++) w[k] = factor * r[k];
    KQ_UNROLL
    for (int k = zeros; k < count; k++) w[k] += factor * r[k];
    return entry;
}

/* Two rows w and v, their entries into s and the word before it.  Answers how far these, too, reach. */
KQ_KERNEL extent reflect_two(extent far, num *s, num *restrict w, num *restrict v, num g_w, num g_v,
                           const num *restrict r, num g_pivot, const num *pq, int count)
{
    num of_w = g_w * g_pivot, of_v = g_v * g_pivot;
    KQ_UNROLL
    for (int k = 0; k < count; k++) {
        of_w = add_product(of_w, w[k], r[k]);
        of_v = add_product(of_v, v[k], r[k]);
    }
    of_w *= pq[0];
    of_v *= pq[0];
    s[0] = of_w;
    s[-1] = of_v;
    far = extent_join(extent_join(far, extent_of(of_w)), extent_of(of_v));
    of_w = -(of_w + g_w) * pq[1];
    of_v = -(of_v + g_v) * pq[1];
    KQ_UNROLL
    for (int k = 0; k < count; k++) {
        w[k] += of_w * r[k];
        v[k] += of_v * r[k];
    }
    return far;
}

/* The pivot of a row without noise.  G_ii >= num_tiny_root, so no norm is ever 0 and nothing needs
   a test. */
#define num_no_noise num_tiny_root

KQ_KERNEL num close_reflector(const num *w, num g, num *pq, int count)
{
    const num s = num_root(dot(g * g, w, w, count));
    pq[0] = 1 / s;
    pq[1] = 1 / (s + g);
    return s;
}

#endif
