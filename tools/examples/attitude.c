/*
 * attitude: written by kalmanq compile --library.
 * Model file attitude.py, SHA-256 9de191ff19a8a0a50fab7a11f8b00aa6dbe0c26a78c9dab0788a1935a7392ee9
 */
#include "attitude.h"

#include <math.h>

#if defined __FAST_MATH__
#error "two floats a state need ordinary arithmetic: compile without -ffast-math"
#endif
static const float A[] = {1.0f, 0.0f, 0.0f, -0.01f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, -0.01f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f,
    0.0f, -0.01f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f};
static const float Q[] = {9.0e-6f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 9.0e-6f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 9.0e-6f,
    0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 2.5e-7f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 2.5e-7f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f,
    0.0f, 2.5e-7f};
static const float first[] = {1.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
static const float P0[] = {0.09f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.09f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.09f, 0.0f,
    0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0009f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0009f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f,
    0.0009f};
static const float H_accelerometer[] = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f,
    0.0f, 0.0f, 0.0f, 0.0f};
static const float R_accelerometer[] = {0.0009f, 0.0009f, 0.0009f};
static const float H_magnetometer[] = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f,
    0.0f, 0.0f, 0.0f};
static const float R_magnetometer[] = {0.0009f, 0.0009f, 0.0009f};

kq_status attitude_start(attitude_device *restrict f)
{
    static const float none[6] = {0};
    for (int i = 0; i < 36; i++) f->A[i] = A[i];
    for (int i = 0; i < 18; i++) f->H_accelerometer[i] = H_accelerometer[i];
    for (int i = 0; i < 18; i++) f->H_magnetometer[i] = H_magnetometer[i];
    for (int i = 0; i < 7; i++) f->x[i] = first[i];
    kq_status status = kq_filter_assign_f32(&f->filter, 6, f->filter_memory, KQ_FILTER_LEN_F32(6));
    if (!status) status = kq_process_assign_f32(&f->process, 6, 0, f->process_memory, KQ_PROCESS_LEN(6));
    if (!status) status = kq_sensor_assign_f32(&f->sensor_accelerometer, 6, 3, f->sensor_accelerometer_memory,
        KQ_SENSOR_DIAGONAL_LEN(3));
    if (!status) status = kq_sensor_assign_f32(&f->sensor_magnetometer, 6, 3, f->sensor_magnetometer_memory,
        KQ_SENSOR_DIAGONAL_LEN(3));
    if (!status) status = kq_process_init_f32(&f->process, f->A, NULL, Q);
    if (!status) status = kq_sensor_init_diagonal_extended_f32(&f->sensor_accelerometer, f->H_accelerometer, R_accelerometer);
    if (!status) status = kq_sensor_init_diagonal_extended_f32(&f->sensor_magnetometer, f->H_magnetometer, R_magnetometer);
    if (!status) status = kq_filter_init_f32(&f->filter, none, P0);
    return status;
}

kq_status attitude_start_at(attitude_device *restrict f, const float mean[7], const float sigma[6])
{
    static const float none[6] = {0};
    float P[36] = {0};
    kq_status status = attitude_start(f);
    for (int i = 0; i < 6; i++) P[i * 7] = sigma[i] * sigma[i];
    for (int i = 0; i < 7; i++) f->x[i] = mean[i];
    return status ? status : kq_filter_init_f32(&f->filter, none, P);
}

kq_status attitude_predict(attitude_device *restrict f, const float u[3])
{
    const float x0 = f->x[0];
    const float x1 = f->x[1];
    const float x2 = f->x[2];
    const float x3 = f->x[3];
    const float x4 = f->x[4];
    const float x5 = f->x[5];
    const float x6 = f->x[6];
    const float u0 = u[0];
    const float u1 = u[1];
    const float u2 = u[2];
    const float t0 = u0 - x4;
    const float t1 = 0.005f * t0;
    const float t2 = u1 - x5;
    const float t3 = 0.005f * t2;
    const float t4 = u2 - x6;
    const float t5 = 0.005f * t4;
    const float t6 = sqrtf(t1 * t1 + t3 * t3 + t5 * t5);
    const int t7 = 5.0e-5f < t6;
    const float t8 = cosf(t6);
    const float t9 = sinf(t6) / t6;
    const float t10 = t1 * t9;
    const float t11 = t3 * t9;
    const float t12 = t5 * t9;
    const float t13 = x0 * t8 - (x1 * t10 + x2 * t11 + x3 * t12);
    const float t14 = x0 * t10 + x1 * t8 + x2 * t12 - x3 * t11;
    const float t15 = x0 * t11 + x2 * t8 + x3 * t10 - x1 * t12;
    const float t16 = x0 * t12 + x3 * t8 + x1 * t11 - x2 * t10;
    const float t17 = 1.0f / sqrtf(t13 * t13 + t14 * t14 + t15 * t15 + t16 * t16);
    const float t18 = x0 - (x1 * t1 + x2 * t3 + x3 * t5);
    const float t19 = x0 * t1 + x1 + x2 * t5 - x3 * t3;
    const float t20 = x0 * t3 + x2 + x3 * t1 - x1 * t5;
    const float t21 = x0 * t5 + x3 + x1 * t3 - x2 * t1;
    const float t22 = 1.0f / sqrtf(t18 * t18 + t19 * t19 + t20 * t20 + t21 * t21);
    const float t23 = 0.01f * t4;
    const float t24 = 0.01f * t2;
    const float t25 = 0.01f * t0;
    const float t26 = t7 ? t13 * t17 : t18 * t22;
    const float t27 = t7 ? t14 * t17 : t19 * t22;
    const float t28 = t7 ? t15 * t17 : t20 * t22;
    const float t29 = t7 ? t16 * t17 : t21 * t22;
    const float t30 = t26 + t27 + t28 + t29 + x4 + x5 + x6;
    if (!(t30 * t30 <= 1.0e+36f)) return KQ_ERR_NOT_FINITE;
    static const float d[6] = {0};
    f->A[1] = t23;
    f->A[2] = -t24;
    f->A[6] = -t23;
    f->A[8] = t25;
    f->A[12] = t24;
    f->A[13] = -t25;
    kq_status status = kq_process_change_transition_f32(&f->process, f->A);
    if (!status) status = kq_predict_extended_f32(&f->filter, &f->process, d);
    if (status) return status;
    f->x[0] = t26;
    f->x[1] = t27;
    f->x[2] = t28;
    f->x[3] = t29;
    return status;
}

kq_status attitude_reset(attitude_device *restrict f)
{
    const float x0 = f->x[0];
    const float x1 = f->x[1];
    const float x2 = f->x[2];
    const float x3 = f->x[3];
    const float x4 = f->x[4];
    const float x5 = f->x[5];
    const float x6 = f->x[6];
    const float d0 = kq_mean_f32(&f->filter, 0);
    const float d1 = kq_mean_f32(&f->filter, 1);
    const float d2 = kq_mean_f32(&f->filter, 2);
    const float d3 = kq_mean_f32(&f->filter, 3);
    const float d4 = kq_mean_f32(&f->filter, 4);
    const float d5 = kq_mean_f32(&f->filter, 5);
    const float t0 = 0.5f * d0;
    const float t1 = 0.5f * d1;
    const float t2 = 0.5f * d2;
    const float t3 = sqrtf(t0 * t0 + t1 * t1 + t2 * t2);
    const int t4 = 5.0e-5f < t3;
    const float t5 = cosf(t3);
    const float t6 = sinf(t3) / t3;
    const float t7 = t0 * t6;
    const float t8 = t1 * t6;
    const float t9 = t2 * t6;
    const float t10 = x0 * t5 - (x1 * t7 + x2 * t8 + x3 * t9);
    const float t11 = x0 * t7 + x1 * t5 + x2 * t9 - x3 * t8;
    const float t12 = x0 * t8 + x2 * t5 + x3 * t7 - x1 * t9;
    const float t13 = x0 * t9 + x3 * t5 + x1 * t8 - x2 * t7;
    const float t14 = 1.0f / sqrtf(t10 * t10 + t11 * t11 + t12 * t12 + t13 * t13);
    const float t15 = x0 - (x1 * t0 + x2 * t1 + x3 * t2);
    const float t16 = x0 * t0 + x1 + x2 * t2 - x3 * t1;
    const float t17 = x0 * t1 + x2 + x3 * t0 - x1 * t2;
    const float t18 = x0 * t2 + x3 + x1 * t1 - x2 * t0;
    const float t19 = 1.0f / sqrtf(t15 * t15 + t16 * t16 + t17 * t17 + t18 * t18);
    const float t20 = t4 ? t10 * t14 : t15 * t19;
    const float t21 = t4 ? t11 * t14 : t16 * t19;
    const float t22 = t4 ? t12 * t14 : t17 * t19;
    const float t23 = t4 ? t13 * t14 : t18 * t19;
    const float t24 = x4 + d3;
    const float t25 = x5 + d4;
    const float t26 = x6 + d5;
    const float t27 = t20 + t21 + t22 + t23 + t24 + t25 + t26;
    if (!(t27 * t27 <= 1.0e+36f)) return KQ_ERR_NOT_FINITE;
    const float back[6] = {-d0, -d1, -d2, -d3, -d4, -d5};
    const kq_status status = kq_move_f32(&f->filter, back);
    if (status) return status;
    f->x[0] = t20;
    f->x[1] = t21;
    f->x[2] = t22;
    f->x[3] = t23;
    f->x[4] = t24;
    f->x[5] = t25;
    f->x[6] = t26;
    return status;
}

kq_status attitude_innovation_accelerometer(attitude_device *restrict f, const float z[3], float e[3])
{
    const float x0 = f->x[0];
    const float x1 = f->x[1];
    const float x2 = f->x[2];
    const float x3 = f->x[3];
    const float z0 = z[0];
    const float z1 = z[1];
    const float z2 = z[2];
    const float t0 = 2.0f * x1;
    const float t1 = 2.0f * x2;
    const float t2 = x3 * t0 - x0 * t1;
    const float t3 = x0 * t0 + x3 * t1;
    const float t4 = 1.0f + -(x2 * t1) - x1 * t0;
    e[0] = z0 - t2;
    e[1] = z1 - t3;
    e[2] = z2 - t4;
    f->H_accelerometer[1] = -t4;
    f->H_accelerometer[2] = t3;
    f->H_accelerometer[6] = t4;
    f->H_accelerometer[8] = -t2;
    f->H_accelerometer[12] = -t3;
    f->H_accelerometer[13] = t2;
    return kq_sensor_change_measurement_f32(&f->sensor_accelerometer, f->H_accelerometer);
}

kq_status attitude_update_accelerometer_some(attitude_device *restrict f, const float z[3], uint32_t present)
{
    float e[3];
    kq_status status = attitude_innovation_accelerometer(f, z, e);
    if (!status) status = kq_update_subset_f32(&f->filter, &f->sensor_accelerometer, e, present);
    if (!status) status = attitude_reset(f);
    return status;
}

kq_status attitude_update_accelerometer(attitude_device *restrict f, const float z[3])
{
    return attitude_update_accelerometer_some(f, z, UINT32_MAX);
}

kq_status attitude_innovation_magnetometer(attitude_device *restrict f, const float z[3], float e[3])
{
    const float x0 = f->x[0];
    const float x1 = f->x[1];
    const float x2 = f->x[2];
    const float x3 = f->x[3];
    const float z3 = z[0];
    const float z4 = z[1];
    const float z5 = z[2];
    const float t0 = 1.732f * x2;
    const float t1 = 2.0f * (0.866f * x1 - 0.5f * x3);
    const float t2 = 0.5f - x0 * t0 + x3 * t1 - x2 * x2;
    const float t3 = x0 * t1 + x1 * x2 + x3 * t0;
    const float t4 = 0.866f + x0 * x2 + -(x2 * t0) - x1 * t1;
    e[0] = z3 - t2;
    e[1] = z4 - t3;
    e[2] = z5 - t4;
    f->H_magnetometer[1] = -t4;
    f->H_magnetometer[2] = t3;
    f->H_magnetometer[6] = t4;
    f->H_magnetometer[8] = -t2;
    f->H_magnetometer[12] = -t3;
    f->H_magnetometer[13] = t2;
    return kq_sensor_change_measurement_f32(&f->sensor_magnetometer, f->H_magnetometer);
}

kq_status attitude_update_magnetometer_some(attitude_device *restrict f, const float z[3], uint32_t present)
{
    float e[3];
    kq_status status = attitude_innovation_magnetometer(f, z, e);
    if (!status) status = kq_update_subset_f32(&f->filter, &f->sensor_magnetometer, e, present);
    if (!status) status = attitude_reset(f);
    return status;
}

kq_status attitude_update_magnetometer(attitude_device *restrict f, const float z[3])
{
    return attitude_update_magnetometer_some(f, z, UINT32_MAX);
}
