/* The public functions with a process noise that is scaled, in floating point: the
   scaled process has room for its noise. */
#ifndef KQ_SRC_ROBUST_STUDENT_FLOAT_H
#define KQ_SRC_ROBUST_STUDENT_FLOAT_H

#include <stdint.h>

#include "kalmanq/robust.h"
#include "kalmanq/status.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/scaled.h"
#include "../model/types.h"
#include "reweighted.h"
#include "student_step.h"

kq_status T(kq_step_student)(filter *f, const process *p, const num *u, const sensor *s,
                             const num *z, uint32_t present, scaled nu, process *target,
                             scaled *q)
{
    return filter_step_student(f, &(student_step){p, u, s, z, present, nu, target, 0}, q);
}

kq_status T(kq_process_scale_noise)(process *target, const process *source, scaled q)
{
    return process_scale_noise(target, source, 0, q);
}

kq_status T(kq_smooth_reweighted)(history *h, process *target, const process *source,
                                  scaled nu, scaled *q)
{
    return smooth_reweighted(h, target, source, 0, nu, q);
}

#endif
