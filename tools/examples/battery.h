/*
 * battery: a Kalman filter of 2 states, 1 measurement and 1 control in f32.
 * A device over the library (kalmanq/extended.h): its calls answer the library's statuses.
 * Written by kalmanq compile.
 *
 *     static battery_device f;
 *     battery_start(&f);           once
 *     battery_update(&f, z, u);    a sample
 *     battery_predict(&f, u);      to the next instant
 *     battery_mean_charge(&f)      the estimate
 *
 * For smoothers, attach a history after battery_start (kalmanq/smoother.h):
 *
 *     KQ_HISTORY_F32(tape, 2, 1, STEPS, 0);
 *     kq_attach_f32(battery_filter(&f), &tape.attached);
 *
 * A robust update (kalmanq/robust.h):
 *
 *     battery_innovation(&f, z, u, e);
 *     kq_update_robust_f32(battery_filter(&f), &f.sensor, e, UINT32_MAX, &loss);
 *
 * Sigma points (kalmanq/sigma_points.h), with float work[KQ_SIGMA_POINTS_LEN(2, 1)]:
 *
 *     battery_row row = {z, u};
 *     kq_update_sigma_points_f32(battery_filter(&f), &f.sensor, battery_point_innovation, &row,
 *         KQ_SIGMA_POINTS_CUBATURE, work);
 *
 *                    name          unit  range
 *     state 0        charge              2
 *     state 1        polarisation  V     1
 *     measurement 0  voltage       V     16
 *     control 0      current       A
 */
#ifndef BATTERY_H
#define BATTERY_H

#include <kalmanq/sigma_points.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    kq_filter_f32 filter;
    kq_process_f32 process;
    kq_sensor_f32 sensor;
    float filter_memory[KQ_FILTER_LEN_F32(2)], process_memory[KQ_PROCESS_LEN(2)];
    float sensor_memory[KQ_SENSOR_DIAGONAL_LEN(1)];
    float H[2];
} battery_device;

/** Before the first sample.  Detaches what was attached. */
kq_status battery_start(battery_device *f);

/** The same from a mean and a sigma of each state that you give. */
kq_status battery_start_at(battery_device *f, const float mean[2], const float sigma[2]);

/** To the next instant. */
kq_status battery_predict(battery_device *f, const float u[1]);

/** Takes a sample. */
kq_status battery_update(battery_device *f, const float z[1], const float u[1]);

/** Innovations e of a sample at the mean; the sensor's H becomes the derivative there. */
kq_status battery_innovation(battery_device *f, const float z[1], const float u[1], float e[1]);

/** What the functions for sigma points read of a row beside the state. */
typedef struct {
    const float *z;
    const float *u;
} battery_row;

/** z - h(x) at a sigma point.  context: a row. */
void battery_point_innovation(void *context, const float *x, float *e);

static inline float battery_mean_charge(const battery_device *f) { return kq_mean_f32(&f->filter, 0); }
static inline float battery_mean_polarisation(const battery_device *f) { return kq_mean_f32(&f->filter, 1); }

/** For the library's calls: readings, histories, robust updates. */
static inline kq_filter_f32 *battery_filter(battery_device *f) { return &f->filter; }

static inline float battery_sigma_charge(const battery_device *f) { return kq_sigma_f32(&f->filter, 0); }
static inline float battery_sigma_polarisation(const battery_device *f) { return kq_sigma_f32(&f->filter, 1); }

#ifdef __cplusplus
}
#endif

#endif /* BATTERY_H */
