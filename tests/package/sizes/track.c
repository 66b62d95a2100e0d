/* See track.h. */
#include "track.h"

#include "kq_fixed_f32.h" /* in src/fixed_size of the library */

/* A, n x n */
static const float transition[16] = {
    1.0f, 1.0f, 0.0f, 0.0f,
    0.0f, 1.0f, 0.0f, 0.0f,
    0.0f, 0.0f, 1.0f, 1.0f,
    0.0f, 0.0f, 0.0f, 1.0f,
};
/* G: Q = G G' */
static const float noise_factor[16] = {
    0.06454972f, 0.1118034f, 0.0f, 0.0f,
    0.0f, 0.2236068f, 0.0f, 0.0f,
    0.0f, 0.0f, 0.06454972f, 0.1118034f,
    0.0f, 0.0f, 0.0f, 0.2236068f,
};
/* H, m x n */
static const float measurement[8] = {1.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f};
/* R: the noises are independent */
static const float variance[2] = {25.0f, 25.0f};
/* x0 and P0: before the first sample */
static const float first_mean[4] = {0.0f, 0.0f, 0.0f, 0.0f};
static const float first_covariance[16] = {
    10000.0f, 0.0f, 0.0f, 0.0f,
    0.0f, 100.0f, 0.0f, 0.0f,
    0.0f, 0.0f, 10000.0f, 0.0f,
    0.0f, 0.0f, 0.0f, 100.0f,
};

KQ_FILTER_F32(model_filter, 4);
KQ_PROCESS_F32(model_process, 4, 0);
KQ_SENSOR_DIAGONAL_F32(model_sensor, 4, 2);

kq_status track_init(void)
{
    kq_status status = kq_process_init_factor_f32(&model_process, transition, NULL, noise_factor, 4);
    if (!status) status = kq_sensor_init_diagonal_f32(&model_sensor, measurement, variance);
    if (!status) status = kq_filter_init_f32(&model_filter, first_mean, first_covariance);
    return status;
}

kq_status track_predict(void)
{
    return kq_fixed_predict_f32(&model_filter, &model_process, NULL, 4, 0, KQ_FIXED_UPPER);
}

kq_status track_update(const float z[2], uint32_t present)
{
    if (present == TRACK_ALL)
        return kq_fixed_update_f32(&model_filter, &model_sensor, z, 4, 2, 0);
    return kq_update_subset_f32(&model_filter, &model_sensor, z, present);
}

kq_status track_step(const float z[2], uint32_t present)
{
    const kq_status status = track_predict();
    return status ? status : track_update(z, present);
}

kq_filter_f32 *track_filter(void) { return &model_filter; }
