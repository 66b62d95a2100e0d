/* What comes with a steady state, checked: in floating point. */
#ifndef KQ_SRC_STEADY_CHECKS_FLOAT_H
#define KQ_SRC_STEADY_CHECKS_FLOAT_H

#include "../model/model.h"

/* Numbers that come with a model: gains and means */
static kq_status numbers_check(const num *a, int count)
{
    return all_finite(a, count) ? KQ_OK : KQ_ERR_NOT_FINITE;
}

static kq_status mean_check(const sensor *s, const num *x, int n)
{
    (void)s;
    return numbers_check(x, n);
}

/* What z is not is seen in its innovations (innovations_are_finite). */
KQ_KERNEL kq_status measured_check(const sensor *s, const num *z, int m)
{
    (void)s, (void)z, (void)m;
    return KQ_OK;
}

/* May x become this? */
static kq_status moved_check(const steady_word *t, int n)
{
    for (int i = 0; i < n; i++) {
        if (!num_is_finite(t[i])) return KQ_ERR_NOT_FINITE;
    }
    return KQ_OK;
}

/* Have the two, of the same number of states, the same units? */
static int sensor_is_for(const sensor *s, const process *p)
{
    (void)s, (void)p;
    return 1;
}

#endif
