/* The public functions with a process noise that is scaled, in fixed point: the
   caller has room for the scaled noise. */
#ifndef KQ_SRC_ROBUST_STUDENT_Q31_H
#define KQ_SRC_ROBUST_STUDENT_Q31_H

#include <stdint.h>

#include "kalmanq/robust.h"
#include "kalmanq/status.h"

#include "../arithmetic/q31.h"
#include "../arithmetic/scaled.h"
#include "../model/types.h"
#include "reweighted.h"
#include "student_step.h"

kq_status T(kq_step_student)(filter *f, const process *p, const num *u, const sensor *s,
                             const num *z, uint32_t present, scaled nu, process *target, num *root,
                             scaled *q)
{
    return filter_step_student(f, &(student_step){p, u, s, z, present, nu, target, root}, q);
}

kq_status T(kq_process_scale_noise)(process *target, const process *source, num *root, scaled q)
{
    return process_scale_noise(target, source, root, q);
}

kq_status T(kq_smooth_reweighted)(history *h, process *target, const process *source, num *root,
                                  scaled nu, scaled *q)
{
    return smooth_reweighted(h, target, source, root, nu, q);
}

#endif
