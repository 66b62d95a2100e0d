/* The diffuse start without ranges: what is unknown may be anywhere.  ranges_q31.h is the twin. */
#ifndef KQ_SRC_DIFFUSE_RANGES_FLOAT_H
#define KQ_SRC_DIFFUSE_RANGES_FLOAT_H

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/scaled.h"
#include "../model/types.h"
#include "../filter/likelihood.h"
#include "unknown.h"

static const num range_sigma = 1;

static void ranges_clear(const start *s) { (void)s; }

static scaled unknown_unit(const start *s, const filter *f, int i)
{
    (void)s, (void)f, (void)i;
    return 1;
}

static int range_says_more(scaled phi, scaled variance)
{
    (void)phi, (void)variance;
    return 0;
}

static void likelihood_to_units(const start *s, likelihood *p) { (void)s, (void)p; }

#endif
