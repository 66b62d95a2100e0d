/*
 * range_bearing: written by kalmanq compile --library.
 * Model file range_bearing.py, SHA-256 56bf3d693e76aa32d5097812f4f451ee43b7a5299a3c09a0672299b9fb472ec5
 */
#include "range_bearing.h"

#include <math.h>

#if defined __FAST_MATH__
#error "two floats a state need ordinary arithmetic: compile without -ffast-math"
#endif
static const float A[] = {1.0f, 0.0f, 1.0f, 0.0f, 0.0f, 1.0f, 0.0f, 1.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f};
static const float Q[] = {0.016666668f, 0.0f, 0.025f, 0.0f, 0.0f, 0.016666668f, 0.0f, 0.025f, 0.025f, 0.0f, 0.05f, 0.0f, 0.0f,
    0.025f, 0.0f, 0.05f};
static const float first[] = {-150.0f, 20.0f, 5.0f, 0.0f};
static const float P0[] = {25.0f, 0.0f, 0.0f, 0.0f, 0.0f, 25.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f};
static const float H[] = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
static const float R[] = {0.0004f, 1.0e-6f};

kq_status range_bearing_start(range_bearing_device *restrict f)
{
    for (int i = 0; i < 8; i++) f->H[i] = H[i];
    kq_status status = kq_filter_assign_f32(&f->filter, 4, f->filter_memory, KQ_FILTER_LEN_F32(4));
    if (!status) status = kq_process_assign_f32(&f->process, 4, 0, f->process_memory, KQ_PROCESS_LEN(4));
    if (!status) status = kq_sensor_assign_f32(&f->sensor, 4, 2, f->sensor_memory, KQ_SENSOR_DIAGONAL_LEN(2));
    if (!status) status = kq_filter_assign_f32(&f->trial, 4, f->trial_memory, KQ_FILTER_LEN_F32(4));
    if (!status) status = kq_process_init_f32(&f->process, A, NULL, Q);
    if (!status) status = kq_sensor_init_diagonal_extended_f32(&f->sensor, f->H, R);
    if (!status) status = kq_filter_init_f32(&f->filter, first, P0);
    return status;
}

kq_status range_bearing_start_at(range_bearing_device *restrict f, const float mean[4], const float sigma[4])
{
    float P[16] = {0};
    kq_status status = range_bearing_start(f);
    for (int i = 0; i < 4; i++) P[i * 5] = sigma[i] * sigma[i];
    return status ? status : kq_filter_init_f32(&f->filter, mean, P);
}

kq_status range_bearing_predict(range_bearing_device *restrict f)
{
    return kq_predict_f32(&f->filter, &f->process, NULL);
}

static kq_status linearise(range_bearing_device *restrict f, const float z[2], float e[2])
{
    const float x0 = kq_mean_f32(&f->trial, 0);
    const float x1 = kq_mean_f32(&f->trial, 1);
    const float z0 = z[0];
    const float z1 = z[1];
    const float t0 = x0 * x0 + x1 * x1;
    const float t1 = sqrtf(t0);
    const float t2 = z1 - atan2f(x1, x0);
    const float t3 = 1.0f / t1;
    const float t4 = 1.0f / t0;
    e[0] = z0 - t1;
    e[1] = 3.1415927f < t2 || t2 < (-3.1415927f) ? t2 - 6.2831855f * floorf(0.15915494f * t2 + 0.5f) : t2;
    f->H[0] = x0 * t3;
    f->H[1] = x1 * t3;
    f->H[4] = -(x1 * t4);
    f->H[5] = x0 * t4;
    for (int i = 0; i < 4; i++) {
        const float off = kq_mean_f32(&f->filter, i) - kq_mean_f32(&f->trial, i) + kq_mean_low_f32(&f->filter, i);
        for (int j = 0; j < 2; j++) e[j] -= f->H[j * 4 + i] * off;
    }
    return kq_sensor_change_measurement_f32(&f->sensor, f->H);
}

kq_status range_bearing_innovation(range_bearing_device *restrict f, const float z[2], float e[2])
{
    kq_status status = kq_filter_copy_f32(&f->trial, &f->filter);
    return status ? status : linearise(f, z, e);
}

kq_status range_bearing_update_some(range_bearing_device *restrict f, const float z[2], uint32_t present)
{
    float e[2];
    kq_status status = range_bearing_innovation(f, z, e);
    for (int pass = 1; pass < 4 && !status; pass++) {
        status = kq_filter_copy_f32(&f->trial, &f->filter);
        if (!status) status = kq_update_subset_f32(&f->trial, &f->sensor, e, present);
        if (!status) status = linearise(f, z, e);
    }
    if (!status) status = kq_update_subset_f32(&f->filter, &f->sensor, e, present);
    return status;
}

kq_status range_bearing_update(range_bearing_device *restrict f, const float z[2])
{
    return range_bearing_update_some(f, z, UINT32_MAX);
}

void range_bearing_point_innovation(void *context, const float *x, float *e)
{
    const range_bearing_row *row = context;
    const float x0 = x[0];
    const float x1 = x[1];
    const float z0 = row->z[0];
    const float z1 = row->z[1];
    const float t0 = z1 - atan2f(x1, x0);
    e[0] = z0 - sqrtf(x0 * x0 + x1 * x1);
    e[1] = 3.1415927f < t0 || t0 < (-3.1415927f) ? t0 - 6.2831855f * floorf(0.15915494f * t0 + 0.5f) : t0;
}
