/*
 * gps_imu: written by kalmanq compile --library.
 * Model file gps_imu.py, SHA-256 627219660d43b40c766e7fb75a83bfe40189e3cb634b70225f497a82d2386d65
 */
#include "gps_imu.h"

#include <math.h>

#if defined __FAST_MATH__
#error "two floats a state need ordinary arithmetic: compile without -ffast-math"
#endif
static const float A[] = {1.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, -0.1f,
    0.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, -0.1f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f};
static const float Q[] = {1.0e-6f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0e-6f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0001f,
    0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0e-6f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0e-8f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f,
    0.0f, 1.0e-10f};
static const float first[] = {500.0f, -300.0f, 10.0f, 0.5f, 0.0f, 0.0f};
static const float P0[] = {4.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 4.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f,
    0.0f, 0.0f, 0.0f, 0.0f, 0.04f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.01f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0001f};
static const float H[] = {1.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 0.0f};
static const float R[] = {4.0f, 4.0f};

kq_status gps_imu_start(gps_imu_device *restrict f)
{
    for (int i = 0; i < 36; i++) f->A[i] = A[i];
    kq_status status = kq_filter_assign_f32(&f->filter, 6, f->filter_memory, KQ_FILTER_LEN_F32(6));
    if (!status) status = kq_process_assign_f32(&f->process, 6, 0, f->process_memory, KQ_PROCESS_LEN(6));
    if (!status) status = kq_sensor_assign_f32(&f->sensor, 6, 2, f->sensor_memory, KQ_SENSOR_DIAGONAL_LEN(2));
    if (!status) status = kq_process_init_f32(&f->process, f->A, NULL, Q);
    if (!status) status = kq_sensor_init_diagonal_f32(&f->sensor, H, R);
    if (!status) status = kq_filter_init_f32(&f->filter, first, P0);
    return status;
}

kq_status gps_imu_start_at(gps_imu_device *restrict f, const float mean[6], const float sigma[6])
{
    float P[36] = {0};
    kq_status status = gps_imu_start(f);
    for (int i = 0; i < 6; i++) P[i * 7] = sigma[i] * sigma[i];
    return status ? status : kq_filter_init_f32(&f->filter, mean, P);
}

kq_status gps_imu_predict(gps_imu_device *restrict f, const float u[2])
{
    const float x2 = kq_mean_f32(&f->filter, 2);
    const float x3 = kq_mean_f32(&f->filter, 3);
    const float x4 = kq_mean_f32(&f->filter, 4);
    const float x5 = kq_mean_f32(&f->filter, 5);
    const float u0 = u[0];
    const float u1 = u[1];
    const float t0 = 0.1f * x2;
    const float t1 = cosf(x3);
    const float t2 = t0 * t1;
    const float t3 = sinf(x3);
    const float t4 = t0 * t3;
    const float d[6] = {t2, t4, 0.1f * (u0 - x4), 0.1f * (u1 - x5), 0.0f, 0.0f};
    f->A[2] = 0.1f * t1;
    f->A[3] = -t4;
    f->A[8] = 0.1f * t3;
    f->A[9] = t2;
    kq_status status = kq_process_change_transition_f32(&f->process, f->A);
    if (!status) status = kq_predict_extended_f32(&f->filter, &f->process, d);
    return status;
}

kq_status gps_imu_update_some(gps_imu_device *restrict f, const float z[2], uint32_t present)
{
    return kq_update_subset_f32(&f->filter, &f->sensor, z, present);
}

kq_status gps_imu_update(gps_imu_device *restrict f, const float z[2])
{
    return gps_imu_update_some(f, z, UINT32_MAX);
}

void gps_imu_point_increment(void *context, const float *x, float *d)
{
    const gps_imu_row *row = context;
    const float x2 = x[2];
    const float x3 = x[3];
    const float x4 = x[4];
    const float x5 = x[5];
    const float u0 = row->u[0];
    const float u1 = row->u[1];
    const float t0 = 0.1f * x2;
    d[0] = t0 * cosf(x3);
    d[1] = t0 * sinf(x3);
    d[2] = 0.1f * (u0 - x4);
    d[3] = 0.1f * (u1 - x5);
    d[4] = 0.0f;
    d[5] = 0.0f;
}
