/*
 * inverse_root and reciprocal of each number that they may be given, or of each STRIDE-th: bounds of inverse_q31.h (KEPT,
 * acsl.txt), results, and how far these are off.  Signed overflow stops it.  exhaust PART PARTS STRIDE takes one part.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static unsigned long long broken;
#define KEPT(bound) (broken += !(bound))
#include "arithmetic/inverse_q31.h"

static double worst_root, worst_reciprocal;

static void note(double *worst, double error)
{
    if (fabs(error) > *worst) *worst = fabs(error);
}

/* Of y^2 v - 1 half is the relative error of y. */
static void look_at_root(uint32_t v)
{
    const uint32_t y = inverse_root(v);
    broken += y < UINT32_C(1) << 31;
    broken += root_by_inverse(v, y) >> 31;
    broken += root_by_inverse(v, y) < UINT32_C(1) << 30 && v > UINT32_C(1) << 30;
    note(&worst_root, ((double)y * y * 0x1p-62 * v * 0x1p-32 - 1) / 2);
}

static void look_at_reciprocal(uint32_t d)
{
    const uint32_t y = reciprocal(d);
    broken += y < UINT32_C(1) << 31;
    note(&worst_reciprocal, (double)y * d * 0x1p-63 - 1);
}

static void look_at_zeros(uint32_t a)
{
    const uint64_t wide = (uint64_t)a << 32 | (a * 0x9e3779b1u);
    broken += leading_zeros(a) != leading_zeros_of_compiler(a);
    broken += leading_zeros_wide(wide) != leading_zeros_wide_of_words(wide);
    broken += leading_zeros_wide(a) != leading_zeros_wide_of_words(a);
}

int main(int argc, char **argv)
{
    if (argc < 4) return 2;
    const uint64_t part = strtoull(argv[1], 0, 10), parts = strtoull(argv[2], 0, 10), stride = strtoull(argv[3], 0, 10);
    const uint64_t from = (UINT64_C(1) << 32) / parts * part, to = (UINT64_C(1) << 32) / parts * (part + 1);
    for (uint64_t v = from; v < to; v += stride) {
        look_at_zeros((uint32_t)v);
        if (v >> 30) look_at_root((uint32_t)v);
        if (v >> 31) look_at_reciprocal((uint32_t)v);
    }
    broken += worst_root > 0x1.1p-31; /* lemmas.py: ROOT */
    printf("%llu broken, 2^%.3f off in a root, 2^%.3f in a reciprocal\n", broken, log2(worst_root), log2(worst_reciprocal));
    return broken != 0;
}
