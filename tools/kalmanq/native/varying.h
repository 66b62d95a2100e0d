/* Processes and sensors that are others from row to row, made in one call: `count` of each matrix, one after the other.
   memory: KQ_PROCESS_LEN(n), or KQ_SENSOR_LEN(m), words of each.  done: how many were made before one was refused. */
#ifndef KALMANQ_NATIVE_VARYING_H
#define KALMANQ_NATIVE_VARYING_H

#include "kalmanq/kalmanq.h"

/* Q: n x n; NULL: F, n x r, with Q = F F'.  B: NULL if l = 0 */
kq_status kq_processes_init_f32(size_t count, kq_process_f32 *processes, int n, int l, float *memory, const float *A,
                                const float *B, const float *Q, const float *F, int r, size_t *done);
kq_status kq_processes_init_f64(size_t count, kq_process_f64 *processes, int n, int l, double *memory, const double *A,
                                const double *B, const double *Q, const double *F, int r, size_t *done);

/* R: m x m; NULL: r, m variances */
kq_status kq_sensors_init_f32(size_t count, kq_sensor_f32 *sensors, int n, int m, float *memory, const float *H,
                              const float *R, const float *r, size_t *done);
kq_status kq_sensors_init_f64(size_t count, kq_sensor_f64 *sensors, int n, int m, double *memory, const double *H,
                              const double *R, const double *r, size_t *done);

#endif
