/*
 * The diffuse start without ranges: what is unknown may be anywhere up to the largest sigma, as in a predict.
 * ranges_q31.h is the twin.
 */
#ifndef KQ_SRC_DIFFUSE_RANGES_FLOAT_H
#define KQ_SRC_DIFFUSE_RANGES_FLOAT_H

#include "../filter/filter.h"
#include "unknown.h"

enum { range_event = KQ_EVENT_OVERFLOW };

static void ranges_clear(const start *s) { (void)s; }

static scaled unknown_unit(const start *s, const filter *f, int i)
{
    (void)s, (void)f, (void)i;
    return 1;
}

/* Of a direction that a measurement of that variance sees by phi, and that moves x by k: the sigma that it is held
   at, or 0 if it is below.  An infinite k is none to be held: it moves nothing. */
static num range_sigma(const num *k, int n, num phi, num variance)
{
    num most = 0;
    for (int i = 0; i < n; i++) {
        if (num_magnitude(k[i]) > most) most = num_magnitude(k[i]);
    }
    return num_root(variance) * most <= num_most_sigma ? 0 : num_most_sigma / most / num_magnitude(phi);
}

/* Is x + k e within the numbers?  Twice that, so that it is however x takes it. */
static int move_is_finite(const filter *f, const num *k, num e)
{
    int finite = 1;
    for (int i = 0; i < f->states; i++) finite &= num_is_finite(2 * (mean_get(f->memory, f->states, i) + k[i] * e));
    return finite;
}

static void likelihood_to_units(const start *s, likelihood *p) { (void)s, (void)p; }

#endif
