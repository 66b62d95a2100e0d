/* What comes with a steady state, checked: in fixed point. */
#ifndef KQ_SRC_STEADY_CHECKS_Q31_H
#define KQ_SRC_STEADY_CHECKS_Q31_H

#include "../arithmetic/q31.h"
#include "../model/model.h"

/* Gains are coefficients. */
static kq_status numbers_check(const scaled *a, int count) { return coefficients_check(a, count); }

static kq_status mean_check(const sensor *s, const num *x, int n)
{
    return ranges_check(x, s->state_format, n, UINT32_MAX);
}

KQ_KERNEL kq_status measured_check(const sensor *s, const num *z, int m)
{
    return sensor_check_values(s, z, m, UINT32_MAX);
}

static kq_status moved_check(const steady_word *t, int n)
{
    (void)t, (void)n;
    return KQ_OK;
}

/* Have the two, of the same number of states, the same units? */
static int sensor_is_for(const sensor *s, const process *p)
{
    return formats_agree(s->state_format, p->state_format, p->states);
}

#endif
