/*
 * What the process and the increment of a linearised predict are in fixed point.  The limits of A's rows are
 * those of the mean's sum (model/tables_q31.h).  A process whose A has not been held to them has no
 * noise_root, so that nothing else takes it: the root is where its B would be; neither a tape that has recorded it
 * before nor a step of compile-time sizes knows it as it was.
 */
#ifndef KQ_SRC_LINEARISED_JACOBIAN_Q31_H
#define KQ_SRC_LINEARISED_JACOBIAN_Q31_H

#include <stdint.h>

#include "kalmanq/extended.h"
#include "kalmanq/fixed_point.h"
#include "kalmanq/status.h"

#include "../arithmetic/q31.h"
#include "../arithmetic/compiler.h"
#include "../arithmetic/scaled.h"
#include "../model/definitions.h"
#include "../model/process.h"
#include "../model/types.h"
#include "../model/units.h"

static kq_status jacobian_is_ready(const process *p)
{
    if (!p) return KQ_ERR_NULL;
    return p->noise_root || (p->transition && p->control) ? KQ_OK : KQ_ERR_NOT_READY;
}

/* Is it a process, and f's? */
static kq_status jacobian_check(const process *p, const filter *f)
{
    const kq_status status = jacobian_is_ready(p);
    if (status) return status;
    return process_fits(p, f) ? KQ_OK : KQ_ERR_MISMATCH;
}

/* In `plain`: of a Jacobian alone */
enum { PROCESS_OF_JACOBIAN = 32 };

/* As the root is predicted by it: p, or `own` */
KQ_INLINE const process *jacobian_process(const process *p, process *own)
{
    if (p->noise_root) return p;
    *own = *p;
    own->noise_root = (const num *)p->control;
    own->control = 0;
    own->plain = (uint8_t)(p->plain & ~PROCESS_OF_JACOBIAN);
    own->fingerprint = p->fingerprint & ~process_mixed;
    return own;
}

/* Could the mean go through A, too? */
static kq_status jacobian_check_mean(const process *p)
{
    return transition_check(p->transition, 0, p->states, 0, 0);
}

static kq_status increment_check(const num *d, int n)
{
    for (int i = 0; i < n; i++) {
        if (d[i] == KQ_NOT_A_VALUE_Q31) return KQ_ERR_RANGE;
    }
    return KQ_OK;
}

KQ_COLD kq_status T(kq_process_change_jacobian)(process *p, const scaled *A, kq_range_error_q31 *range_error)
{
    kq_status status = jacobian_is_ready(p);
    if (status) return status;
    if (!A) return KQ_ERR_NULL;
    status = rows_check(A, p->states, p->states, KQ_STATE, range_error);
    if (status) return status;
    process own;
    own = *jacobian_process(p, &own);
    process_set_transition(&own, A);
    own.control = (const scaled *)own.noise_root;
    own.controls = 0;
    own.control_format = 0;
    own.noise_root = 0;
    own.plain |= PROCESS_OF_JACOBIAN;
    own.fingerprint |= process_mixed;
    *p = own;
    say_all_fit(range_error);
    return KQ_OK;
}

#endif
