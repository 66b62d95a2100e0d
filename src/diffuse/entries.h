/*
 * What rounding has left in numbers that have to be told from 0: it is counted in units of 16
 * roundings of a number's size, as a standard error.
 */
#ifndef KQ_SRC_DIFFUSE_ENTRIES_H
#define KQ_SRC_DIFFUSE_ENTRIES_H

#include "../arithmetic/arithmetic.h"

static scaled entry_get(const num *row, int j) { return load_scaled(row + j * SCALED_WORDS); }

static void entry_set(num *row, int j, scaled a)
{
    store_scaled(row + j * SCALED_WORDS, scaled_saturated(a));
}

/* sqrt(a^2 + b^2) of a, b >= 0, whose squares may be not representable */
static scaled hypotenuse(scaled a, scaled b)
{
    const scaled larger = scaled_is_less(a, b) ? b : a, smaller = scaled_is_less(a, b) ? a : b;
    if (scaled_is_zero(smaller)) return larger;
    const scaled share = scaled_over(smaller, larger);
    return scaled_times(larger, scaled_root(scaled_plus(scaled_one, scaled_times(share, share))));
}

/* Is it more than rounding, of standard error `error`, explains? */
static int is_significant(scaled a, scaled error)
{
    return scaled_is_less(scaled_times(error, scaled_rounding()), scaled_magnitude(a));
}

/* A sum of products, and the sum of their sizes */
typedef struct {
    scaled value, size;
    int is_exact; /* no product but one by 2^k */
} terms;

static terms terms_begin(void)
{
    const terms none = {.is_exact = 1};
    return none;
}

static void terms_add(terms *t, scaled a, scaled b)
{
    const scaled part = scaled_times(a, b);
    if (scaled_is_zero(part)) return;
    t->is_exact = scaled_is_zero(t->size) && scaled_is_unit(a);
    t->value = scaled_plus(t->value, part);
    t->size = scaled_plus(t->size, scaled_magnitude(part));
}

#endif
