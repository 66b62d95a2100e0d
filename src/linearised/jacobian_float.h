/* What the process and the increment of a linearised predict are in floating point. */
#ifndef KQ_SRC_LINEARISED_JACOBIAN_FLOAT_H
#define KQ_SRC_LINEARISED_JACOBIAN_FLOAT_H

#include "kalmanq/status.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/compiler.h"
#include "../filter/checks.h"
#include "../model/types.h"
#include "../model/units.h"

/* Is it a process, and f's? */
static kq_status jacobian_check(const process *p, const filter *f) { return predict_check(f, p, 0); }

/* As the root is predicted by it */
KQ_INLINE const process *jacobian_process(const process *p, process *own)
{
    (void)own;
    return p;
}

/* Could the mean go through A, too? */
static kq_status jacobian_check_mean(const process *p)
{
    (void)p;
    return KQ_OK;
}

static kq_status increment_check(const num *d, int n) { return all_finite(d, n) ? KQ_OK : KQ_ERR_NOT_FINITE; }

#endif
