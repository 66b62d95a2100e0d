/* The public functions with a process noise that is scaled, in floating point: the
   scaled process has room for its noise. */
#ifndef KQ_SRC_ROBUST_SCALED_NOISE_FLOAT_H
#define KQ_SRC_ROBUST_SCALED_NOISE_FLOAT_H

#include "kalmanq/robust.h"
#include "kalmanq/status.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/scaled.h"
#include "../model/types.h"
#include "reweighted.h"

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
