/*
 * The diffuse start within declared ranges.  delta is counted in the ranges of the unknown states, so
 * that x^, which is as near to x0 as the measurements allow, is as near in shares of the ranges.  A
 * direction of delta has sigma 1/3 by the ranges alone.  Where a measurement
 * would tell less of it than half of that, it is given this prior, and the measurement is then
 * an ordinary one: the exact estimate would overflow.  ranges_float.h is the twin.
 */
#ifndef KQ_SRC_DIFFUSE_RANGES_Q31_H
#define KQ_SRC_DIFFUSE_RANGES_Q31_H

#include "../arithmetic/q31.h"
#include "../filter/filter.h"
#include "unknown.h"

enum { range_event = KQ_EVENT_PRECISION };

static void ranges_clear(const start *s) { store_scaled(diffuse_memory_of(s).ranges, scaled_one); }

/* The range of state i in words.  What its unit is in it is kept, squared, of all together. */
static scaled unknown_unit(const start *s, const filter *f, int i)
{
    num *kept = diffuse_memory_of(s).ranges;
    const scaled range = scaled_of_word(f->state_format[i].range);
    const scaled share = scaled_over(scaled_shift(scaled_one, f->state_format[i].fraction), range);
    const scaled shares = scaled_times(load_scaled(kept), scaled_times(share, share));
    store_scaled(kept, scaled_saturated(shares));
    return range;
}

/* Of a direction that a measurement of that variance sees by phi: the sigma of the ranges, or 0 if it says more */
static scaled range_sigma(const scaled *k, int n, scaled phi, scaled variance)
{
    const scaled third = {INT32_C(0x55555555), -32};
    const scaled seen = scaled_shift(scaled_times(phi, third), -1);
    (void)k, (void)n;
    return scaled_is_less(scaled_times(seen, seen), variance) ? third : scaled_zero();
}

/* A mean is saturated. */
static int move_is_finite(const filter *f, const scaled *k, scaled e)
{
    (void)f, (void)k, (void)e;
    return 1;
}

/* From the ranges of all that was unknown to its units */
static void likelihood_to_units(const start *s, likelihood *p)
{
    likelihood_multiply(p, load_scaled(diffuse_memory_of(s).ranges));
}

#endif
