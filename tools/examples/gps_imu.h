/*
 * gps_imu: a Kalman filter of 6 states, 2 measurements and 2 controls in f32.
 * A device over the library (kalmanq/extended.h): its calls answer the library's statuses.
 * Written by kalmanq compile.
 *
 *     static gps_imu_device f;
 *     gps_imu_start(&f);          once
 *     gps_imu_update(&f, z);      a sample
 *     gps_imu_predict(&f, u);     to the next instant
 *     gps_imu_mean_east(&f)       the estimate
 *
 * For smoothers, attach a history after gps_imu_start (kalmanq/smoother.h):
 *
 *     KQ_HISTORY_F32(tape, 6, 2, STEPS, STEPS);
 *     KQ_JACOBIANS_F32(jacobians, tape, 6, STEPS, 1);
 *     kq_attach_f32(gps_imu_filter(&f), &jacobians.attached);
 *
 * A robust update (kalmanq/robust.h):
 *
 *     kq_update_robust_f32(gps_imu_filter(&f), &f.sensor, z, UINT32_MAX, &loss);
 *
 * Sigma points (kalmanq/sigma_points.h), with float work[KQ_SIGMA_POINTS_LEN(6, 2)]; a KQ_JACOBIANS has STEPS noises then:
 *
 *     gps_imu_row row = {u};
 *     kq_predict_sigma_points_f32(gps_imu_filter(&f), &f.process, gps_imu_point_increment, &row,
 *         KQ_SIGMA_POINTS_CUBATURE, work);
 *
 *                    name                unit   range
 *     state 0        east                m
 *     state 1        north               m
 *     state 2        speed               m/s
 *     state 3        heading             rad
 *     state 4        accelerometer bias  m/s2
 *     state 5        gyro bias           rad/s
 *     measurement 0  gps east            m
 *     measurement 1  gps north           m
 *     control 0      acceleration        m/s2
 *     control 1      turn                rad/s
 */
#ifndef GPS_IMU_H
#define GPS_IMU_H

#include <kalmanq/sigma_points.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    kq_filter_f32 filter;
    kq_process_f32 process;
    kq_sensor_f32 sensor;
    float filter_memory[KQ_FILTER_LEN_F32(6)], process_memory[KQ_PROCESS_LEN(6)];
    float sensor_memory[KQ_SENSOR_DIAGONAL_LEN(2)];
    float A[36];
} gps_imu_device;

/** Before the first sample.  Detaches what was attached. */
kq_status gps_imu_start(gps_imu_device *f);

/** The same from a mean and a sigma of each state that you give. */
kq_status gps_imu_start_at(gps_imu_device *f, const float mean[6], const float sigma[6]);

/** To the next instant. */
kq_status gps_imu_predict(gps_imu_device *f, const float u[2]);

/** Takes a sample. */
kq_status gps_imu_update(gps_imu_device *f, const float z[2]);

/** Takes the components of a sample whose bits are set in `present`. */
kq_status gps_imu_update_some(gps_imu_device *f, const float z[2], uint32_t present);

/** What the functions for sigma points read of a row beside the state. */
typedef struct {
    const float *u;
} gps_imu_row;

/** f(x) - x at a sigma point.  context: a row. */
void gps_imu_point_increment(void *context, const float *x, float *d);

static inline float gps_imu_mean_east(const gps_imu_device *f) { return kq_mean_f32(&f->filter, 0); }
static inline float gps_imu_mean_north(const gps_imu_device *f) { return kq_mean_f32(&f->filter, 1); }
static inline float gps_imu_mean_speed(const gps_imu_device *f) { return kq_mean_f32(&f->filter, 2); }
static inline float gps_imu_mean_heading(const gps_imu_device *f) { return kq_mean_f32(&f->filter, 3); }
static inline float gps_imu_mean_accelerometer_bias(const gps_imu_device *f) { return kq_mean_f32(&f->filter, 4); }
static inline float gps_imu_mean_gyro_bias(const gps_imu_device *f) { return kq_mean_f32(&f->filter, 5); }

/** For the library's calls: readings, histories, robust updates. */
static inline kq_filter_f32 *gps_imu_filter(gps_imu_device *f) { return &f->filter; }

static inline float gps_imu_sigma_east(const gps_imu_device *f) { return kq_sigma_f32(&f->filter, 0); }
static inline float gps_imu_sigma_north(const gps_imu_device *f) { return kq_sigma_f32(&f->filter, 1); }
static inline float gps_imu_sigma_speed(const gps_imu_device *f) { return kq_sigma_f32(&f->filter, 2); }
static inline float gps_imu_sigma_heading(const gps_imu_device *f) { return kq_sigma_f32(&f->filter, 3); }
static inline float gps_imu_sigma_accelerometer_bias(const gps_imu_device *f) { return kq_sigma_f32(&f->filter, 4); }
static inline float gps_imu_sigma_gyro_bias(const gps_imu_device *f) { return kq_sigma_f32(&f->filter, 5); }

#ifdef __cplusplus
}
#endif

#endif /* GPS_IMU_H */
