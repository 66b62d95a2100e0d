/*
 * range_bearing: a Kalman filter of 4 states, 2 measurements and no controls in f32.
 * A device over the library (kalmanq/extended.h): its calls answer the library's statuses.
 * Written by kalmanq compile.
 *
 *     static range_bearing_device f;
 *     range_bearing_start(&f);          once
 *     range_bearing_update(&f, z);      a sample
 *     range_bearing_predict(&f);        to the next instant
 *     range_bearing_mean_east(&f)       the estimate
 *
 * For smoothers, attach a history after range_bearing_start (kalmanq/smoother.h):
 *
 *     KQ_HISTORY_F32(tape, 4, 2, STEPS, 0);
 *     kq_attach_f32(range_bearing_filter(&f), &tape.attached);
 *
 * A robust update (kalmanq/robust.h):
 *
 *     range_bearing_innovation(&f, z, e);
 *     kq_update_robust_f32(range_bearing_filter(&f), &f.sensor, e, UINT32_MAX, &loss);
 *
 * Sigma points (kalmanq/sigma_points.h), with float work[KQ_SIGMA_POINTS_LEN(4, 2)]:
 *
 *     range_bearing_row row = {z};
 *     kq_update_sigma_points_f32(range_bearing_filter(&f), &f.sensor, range_bearing_point_innovation, &row,
 *         KQ_SIGMA_POINTS_CUBATURE, work);
 *
 *                    name     unit  range
 *     state 0        east     m     2000
 *     state 1        north    m     2000
 *     state 2        v_east   m/s   50
 *     state 3        v_north  m/s   50
 *     measurement 0  range    m     2000
 *     measurement 1  bearing  rad   1000
 */
#ifndef RANGE_BEARING_H
#define RANGE_BEARING_H

#include <kalmanq/sigma_points.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    kq_filter_f32 filter;
    kq_process_f32 process;
    kq_sensor_f32 sensor;
    float filter_memory[KQ_FILTER_LEN_F32(4)], process_memory[KQ_PROCESS_LEN(4)];
    float sensor_memory[KQ_SENSOR_DIAGONAL_LEN(2)];
    kq_filter_f32 trial; /* where an update comes out */
    float trial_memory[KQ_FILTER_LEN_F32(4)];
    float H[8];
} range_bearing_device;

/** Before the first sample.  Detaches what was attached. */
kq_status range_bearing_start(range_bearing_device *f);

/** The same from a mean and a sigma of each state that you give. */
kq_status range_bearing_start_at(range_bearing_device *f, const float mean[4], const float sigma[4]);

/** To the next instant. */
kq_status range_bearing_predict(range_bearing_device *f);

/** Takes a sample. */
kq_status range_bearing_update(range_bearing_device *f, const float z[2]);

/** Takes the components of a sample whose bits are set in `present`. */
kq_status range_bearing_update_some(range_bearing_device *f, const float z[2], uint32_t present);

/** Innovations e of a sample at the mean; the sensor's H becomes the derivative there. */
kq_status range_bearing_innovation(range_bearing_device *f, const float z[2], float e[2]);

/** What the functions for sigma points read of a row beside the state. */
typedef struct {
    const float *z;
} range_bearing_row;

/** z - h(x) at a sigma point.  context: a row. */
void range_bearing_point_innovation(void *context, const float *x, float *e);

static inline float range_bearing_mean_east(const range_bearing_device *f) { return kq_mean_f32(&f->filter, 0); }
static inline float range_bearing_mean_north(const range_bearing_device *f) { return kq_mean_f32(&f->filter, 1); }
static inline float range_bearing_mean_v_east(const range_bearing_device *f) { return kq_mean_f32(&f->filter, 2); }
static inline float range_bearing_mean_v_north(const range_bearing_device *f) { return kq_mean_f32(&f->filter, 3); }

/** For the library's calls: readings, histories, robust updates. */
static inline kq_filter_f32 *range_bearing_filter(range_bearing_device *f) { return &f->filter; }

static inline float range_bearing_sigma_east(const range_bearing_device *f) { return kq_sigma_f32(&f->filter, 0); }
static inline float range_bearing_sigma_north(const range_bearing_device *f) { return kq_sigma_f32(&f->filter, 1); }
static inline float range_bearing_sigma_v_east(const range_bearing_device *f) { return kq_sigma_f32(&f->filter, 2); }
static inline float range_bearing_sigma_v_north(const range_bearing_device *f) { return kq_sigma_f32(&f->filter, 3); }

#ifdef __cplusplus
}
#endif

#endif /* RANGE_BEARING_H */
