/*
 * attitude: a Kalman filter of 6 states, 6 measurements and 3 controls in f32.
 * A device over the library (kalmanq/extended.h): its calls answer the library's statuses.
 * Written by kalmanq compile.
 *
 *     static attitude_device f;
 *     attitude_start(&f);                      once
 *     attitude_update_accelerometer(&f, z);    a sample
 *     attitude_update_magnetometer(&f, z);     a sample
 *     attitude_predict(&f, u);                 to the next instant
 *     attitude_mean_q_w(&f)                    the estimate
 *
 * For smoothers, attach a history after attitude_start (kalmanq/smoother.h):
 *
 *     KQ_HISTORY_F32(tape, 6, 6, STEPS, STEPS);
 *     KQ_JACOBIANS_F32(jacobians, tape, 6, STEPS, 1);
 *     kq_attach_f32(attitude_filter(&f), &jacobians.attached);
 *
 * A smoothed mean is the error of what f.x was when the next predict began: keep f.x of each step.  In another
 * device g, with g.x as it was and kq_filter_copy of the view, attitude_reset(&g) makes the whole of it.
 *
 * A robust update (kalmanq/robust.h):
 *
 *     attitude_innovation_accelerometer(&f, z, e);
 *     kq_update_robust_f32(attitude_filter(&f), &f.sensor_accelerometer, e, UINT32_MAX, &loss);
 *     attitude_reset(&f);
 *
 *                    name     unit   range
 *     state 0        turn_x   rad
 *     state 1        turn_y   rad
 *     state 2        turn_z   rad
 *     state 3        off_x    rad/s
 *     state 4        off_y    rad/s
 *     state 5        off_z    rad/s
 *     measurement 0  up_x     g
 *     measurement 1  up_y     g
 *     measurement 2  up_z     g
 *     measurement 3  north_x
 *     measurement 4  north_y
 *     measurement 5  north_z
 *     control 0      gyro_x   rad/s
 *     control 1      gyro_y   rad/s
 *     control 2      gyro_z   rad/s
 */
#ifndef ATTITUDE_H
#define ATTITUDE_H

#include <kalmanq/extended.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    kq_filter_f32 filter;
    kq_process_f32 process;
    kq_sensor_f32 sensor_accelerometer;
    kq_sensor_f32 sensor_magnetometer;
    float filter_memory[KQ_FILTER_LEN_F32(6)], process_memory[KQ_PROCESS_LEN(6)];
    float sensor_accelerometer_memory[KQ_SENSOR_DIAGONAL_LEN(3)];
    float sensor_magnetometer_memory[KQ_SENSOR_DIAGONAL_LEN(3)];
    float A[36];
    float H_accelerometer[18];
    float H_magnetometer[18];
    float x[7]; /* what the states are errors of */
} attitude_device;

/** Before the first sample.  Detaches what was attached. */
kq_status attitude_start(attitude_device *f);

/** The same from a mean and a sigma of each state that you give. */
kq_status attitude_start_at(attitude_device *f, const float mean[7], const float sigma[6]);

/** To the next instant. */
kq_status attitude_predict(attitude_device *f, const float u[3]);

/** The errors go into f->x, and are 0 then.  An update has done it. */
kq_status attitude_reset(attitude_device *f);

/** Takes a sample. */
kq_status attitude_update_accelerometer(attitude_device *f, const float z[3]);

/** Takes the components of a sample whose bits are set in `present`. */
kq_status attitude_update_accelerometer_some(attitude_device *f, const float z[3], uint32_t present);

/** Innovations e of a sample at the mean; the sensor's H becomes the derivative there. */
kq_status attitude_innovation_accelerometer(attitude_device *f, const float z[3], float e[3]);

/** Takes a sample. */
kq_status attitude_update_magnetometer(attitude_device *f, const float z[3]);

/** Takes the components of a sample whose bits are set in `present`. */
kq_status attitude_update_magnetometer_some(attitude_device *f, const float z[3], uint32_t present);

/** Innovations e of a sample at the mean; the sensor's H becomes the derivative there. */
kq_status attitude_innovation_magnetometer(attitude_device *f, const float z[3], float e[3]);

static inline float attitude_mean_q_w(const attitude_device *f) { return f->x[0]; }
static inline float attitude_mean_q_x(const attitude_device *f) { return f->x[1]; }
static inline float attitude_mean_q_y(const attitude_device *f) { return f->x[2]; }
static inline float attitude_mean_q_z(const attitude_device *f) { return f->x[3]; }
static inline float attitude_mean_bias_x(const attitude_device *f) { return f->x[4]; }
static inline float attitude_mean_bias_y(const attitude_device *f) { return f->x[5]; }
static inline float attitude_mean_bias_z(const attitude_device *f) { return f->x[6]; }

/** For the library's calls: readings, histories, robust updates. */
static inline kq_filter_f32 *attitude_filter(attitude_device *f) { return &f->filter; }

static inline float attitude_sigma_turn_x(const attitude_device *f) { return kq_sigma_f32(&f->filter, 0); }
static inline float attitude_sigma_turn_y(const attitude_device *f) { return kq_sigma_f32(&f->filter, 1); }
static inline float attitude_sigma_turn_z(const attitude_device *f) { return kq_sigma_f32(&f->filter, 2); }
static inline float attitude_sigma_off_x(const attitude_device *f) { return kq_sigma_f32(&f->filter, 3); }
static inline float attitude_sigma_off_y(const attitude_device *f) { return kq_sigma_f32(&f->filter, 4); }
static inline float attitude_sigma_off_z(const attitude_device *f) { return kq_sigma_f32(&f->filter, 5); }

#ifdef __cplusplus
}
#endif

#endif /* ATTITUDE_H */
