/*
 * battery: written by kalmanq compile --library.
 * Model file battery.py, SHA-256 5e387f6c1dff9c3d0d1361711b9cb3172138157faf627fbf1cfe7f120836f68c
 */
#include "battery.h"

#include <math.h>

#if defined __FAST_MATH__
#error "two floats a state need ordinary arithmetic: compile without -ffast-math"
#endif
static const float A[] = {1.0f, 0.0f, 0.0f, 0.84648174f};
static const float B[] = {-0.0011111111f, 0.0030703654f};
static const float Q[] = {1.0e-10f, 0.0f, 0.0f, 1.0e-8f};
static const float first[] = {0.8f, 0.0f};
static const float P0[] = {0.01f, 0.0f, 0.0f, 0.0001f};
static const float H[] = {0.0f, -1.0f};
static const float R[] = {0.0001f};

kq_status battery_start(battery_device *restrict f)
{
    for (int i = 0; i < 2; i++) f->H[i] = H[i];
    kq_status status = kq_filter_assign_f32(&f->filter, 2, f->filter_memory, KQ_FILTER_LEN_F32(2));
    if (!status) status = kq_process_assign_f32(&f->process, 2, 1, f->process_memory, KQ_PROCESS_LEN(2));
    if (!status) status = kq_sensor_assign_f32(&f->sensor, 2, 1, f->sensor_memory, KQ_SENSOR_DIAGONAL_LEN(1));
    if (!status) status = kq_process_init_f32(&f->process, A, B, Q);
    if (!status) status = kq_sensor_init_diagonal_extended_f32(&f->sensor, f->H, R);
    if (!status) status = kq_filter_init_f32(&f->filter, first, P0);
    return status;
}

kq_status battery_start_at(battery_device *restrict f, const float mean[2], const float sigma[2])
{
    float P[4] = {0};
    kq_status status = battery_start(f);
    for (int i = 0; i < 2; i++) P[i * 3] = sigma[i] * sigma[i];
    return status ? status : kq_filter_init_f32(&f->filter, mean, P);
}

kq_status battery_predict(battery_device *restrict f, const float u[1])
{
    return kq_predict_f32(&f->filter, &f->process, u);
}

kq_status battery_innovation(battery_device *restrict f, const float z[1], const float u[1], float e[1])
{
    const float x0 = kq_mean_f32(&f->filter, 0);
    const float x1 = kq_mean_f32(&f->filter, 1);
    const float u0 = u[0];
    const float z0 = z[0];
    const float t0 = expf(-(20.0f * x0));
    const float t1 = 6.0f * x0;
    e[0] = z0 - (3.3f + 0.9f * x0 - 0.15f * t0 + 0.1f * sinf(t1) - x1 - 0.03f * u0);
    f->H[0] = 0.9f + 3.0f * t0 + 0.6f * cosf(t1);
    return kq_sensor_change_measurement_f32(&f->sensor, f->H);
}

kq_status battery_update(battery_device *restrict f, const float z[1], const float u[1])
{
    float e[1];
    kq_status status = battery_innovation(f, z, u, e);
    if (!status) status = kq_update_f32(&f->filter, &f->sensor, e);
    return status;
}

void battery_point_innovation(void *context, const float *x, float *e)
{
    const battery_row *row = context;
    const float x0 = x[0];
    const float x1 = x[1];
    const float u0 = row->u[0];
    const float z0 = row->z[0];
    e[0] = z0 - (3.3f + 0.9f * x0 - 0.15f * expf(-(20.0f * x0)) + 0.1f * sinf(6.0f * x0) - x1 - 0.03f * u0);
}
