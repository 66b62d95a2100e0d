/* The public functions with a process noise that is scaled, in fixed point: the
   caller has room for the scaled noise. */
#ifndef KQ_SRC_ROBUST_SCALED_NOISE_Q31_H
#define KQ_SRC_ROBUST_SCALED_NOISE_Q31_H

#include "kalmanq/robust.h"
#include "kalmanq/status.h"

#include "../arithmetic/q31.h"
#include "../arithmetic/scaled.h"
#include "../model/types.h"
#include "reweighted.h"

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
