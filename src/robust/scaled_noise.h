/* The predict with a scaled process noise.  How a scale is given differs. */
#ifndef KQ_SRC_ROBUST_SCALED_NOISE_H
#define KQ_SRC_ROBUST_SCALED_NOISE_H

#include "reweighted.h"

#if KQ_FLOATING

kq_status T(kq_process_scale_noise)(process *target, const process *source, scaled q)
{
    return process_scale_noise(target, source, 0, q);
}

kq_status T(kq_smooth_reweighted)(history *h, process *target, const process *source,
                                  scaled nu, scaled *q)
{
    return smooth_reweighted(h, target, source, 0, nu, q);
}

#else

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

#endif
