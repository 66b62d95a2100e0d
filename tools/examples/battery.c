#include "battery.h"

#include <math.h>

enum { N = BATTERY_STATES, STEPS = BATTERY_STEPS };

/* 2.5 Ah; 20 mOhm and 60 s; 30 mOhm */
#define DECAY 0.846481725f /* exp(-10 / 60) */
static const float series = 0.03f;
static const float A[] = {1, 0, 0, DECAY};
static const float B[] = {-10.0f / 9000, 0.02f * (1 - DECAY)};
static const float Q[] = {1e-10f, 0, 0, 1e-8f}; /* what the model and the current sensor miss in 10 s */
static const float x0[] = {0.8f, 0}, P0[] = {1e-2f, 0, 0, 1e-4f};
static const float r[] = {1e-4f}; /* 10 mV */

KQ_PROCESS_F32(discharge, N, 1);
KQ_SENSOR_DIAGONAL_F32(voltmeter, N, 1);
KQ_FILTER_F32(cell, N);
KQ_HISTORY_F32(tape, N, 1, STEPS, 0);

static float H[N] = {0, -1};

/* The open-circuit voltage and its slope */
static float ocv(float s)
{
    return 3.3f + 0.9f * s - 0.15f * expf(-20 * s) + 0.1f * sinf(6 * s);
}

static float ocv_slope(float s) { return 0.9f + 3 * expf(-20 * s) + 0.6f * cosf(6 * s); }

kq_status battery_start(void)
{
    H[0] = ocv_slope(x0[0]);
    kq_status status = kq_process_init_f32(&discharge, A, B, Q);
    if (!status) status = kq_sensor_init_diagonal_extended_f32(&voltmeter, H, r);
    if (!status) status = kq_filter_init_f32(&cell, x0, P0);
    if (!status) status = kq_detach_f32(&tape.attached);
    if (!status) status = kq_attach_f32(&cell, &tape.attached);
    return status;
}

kq_status battery_discharge(float current) { return kq_predict_f32(&cell, &discharge, &current); }

kq_status battery_measure(float voltage, float current)
{
    const float s = kq_mean_f32(&cell, 0), v = kq_mean_f32(&cell, 1);
    const float e = voltage - (ocv(s) - v - series * current);
    H[0] = ocv_slope(s);
    kq_status status = kq_sensor_change_measurement_f32(&voltmeter, H);
    if (!status) status = kq_update_f32(&cell, &voltmeter, &e);
    return status;
}

kq_status battery_read(float mean[N], float P[N * N])
{
    for (int i = 0; i < N; i++) mean[i] = kq_mean_f32(&cell, i);
    return kq_covariance_f32(&cell, P);
}

kq_status battery_smooth(void) { return kq_smooth_f32(&tape); }

kq_status battery_read_smoothed(size_t step, float mean[N], float P[N * N])
{
    kq_filter_f32 view;
    const kq_status status = kq_smoothed_f32(&tape, step, &view);
    for (int i = 0; i < N; i++) mean[i] = kq_mean_f32(&view, i);
    return status ? status : kq_covariance_f32(&view, P);
}

unsigned battery_events(void)
{
    kq_filter_f32 view;
    const kq_status status = kq_smoothed_f32(&tape, 0, &view);
    return kq_events_f32(&cell) | (status ? 0 : kq_events_f32(&view));
}
