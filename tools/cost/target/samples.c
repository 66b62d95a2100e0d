/*
 * A user's functions for one sample.  With what is past: predict, update, and the past anew, LAG
 * steps back or the chosen instant.  With scales of the noises that adapt: predict and update.
 */
#include "library.h"

#include "samples.h"

kq_status TYPED(user_lag)(TYPED(kq_lag) * past, const TYPED(kq_process) * p, TYPED(kq_filter) * f,
                          const TYPED(kq_sensor) * s, const word *z)
{
    kq_status status = TYPED(kq_lag_predict)(past, p, NULL);
    if (!status) status = TYPED(kq_update)(f, s, z);
    return status ? status : TYPED(kq_lag_smooth)(past, LAG);
}

kq_status TYPED(user_lag_states)(TYPED(kq_lag) * past, const TYPED(kq_process) * p,
                                 TYPED(kq_filter) * f, const TYPED(kq_sensor) * s, const word *z)
{
    kq_status status = TYPED(kq_lag_predict)(past, p, NULL);
    if (!status) status = TYPED(kq_update)(f, s, z);
    return status ? status : TYPED(kq_lag_smooth_states)(past, LAG);
}

kq_status TYPED(user_point)(TYPED(kq_point) * start, const TYPED(kq_process) * p,
                            TYPED(kq_filter) * f, const TYPED(kq_sensor) * s, const word *z)
{
    kq_status status = TYPED(kq_point_predict)(start, p, NULL);
    if (!status) status = TYPED(kq_update)(f, s, z);
    return status ? status : TYPED(kq_point_smooth)(start);
}

kq_status TYPED(user_adapted)(TYPED(kq_adaptation) * tuner, TYPED(kq_filter) * f, const word *z)
{
    const kq_status status = TYPED(kq_adaptation_predict)(tuner, f, NULL);
    return status ? status : TYPED(kq_adaptation_update)(tuner, f, z, UINT32_MAX);
}
