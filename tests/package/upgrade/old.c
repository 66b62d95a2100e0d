/* A program of version 0.1, which tools/upgrade.py makes one of 1.0; one line is left to its owner. */
#include "kalmanq/kalmanq.h"
#include "kalmanq/point.h"
#include "kalmanq/start.h"

KQ_FILTER_F32(track, 2);
KQ_PROCESS_F32(motion, 2, 0);
KQ_SENSOR_F32(radar, 2, 1);
KQ_HISTORY_F32(tape, 2, 1, 10, 0);
KQ_START_F32(beginning, 2, 0);
KQ_POINT_F32(launch, 2, 1);
KQ_SETTLING_F32(lazy, 2, 1);

float run(kq_history_f32 *other, const float *x0, const float *z)
{
    kq_filter_f32 *f = &track;
    kq_status status = kq_start_init_f32(&beginning, f, x0, NULL, 3);
    if (!status) status = kq_history_attach_f32(&tape, f);
    if (!status) status = kq_history_detach_f32(other);
    if (!status) status = kq_point_attach_f32(&launch, &track);
    if (!status) status = kq_settling_init_f32(&lazy, KQ_SETTLED_BITS_MAX_F32);
    if (!status) status = kq_update_f32(f, &radar, z);
    if (!status && kq_events_f32(f) & KQ_EVENT_FLOOR) status = kq_fade_f32(f, 0.9f);
    if (!status && kq_start_count_f32(&beginning) == 0) status = kq_predict_f32(f, &motion, NULL);
    if (!status) status = kq_smooth_f32(&tape);
    return kq_smoothed_mean_f32(&tape, 0, kq_settling_is_settled_f32(&lazy)) + (float)status;
}
