#ifndef KALMANQ_ROBUST_H
#define KALMANQ_ROBUST_H

#include "smoother.h"

#ifdef __cplusplus
extern "C" {
#endif

/** A chi-square gate.  limit and run are the user's, rejected is counted. */
typedef struct {
    float limit;       /* of NIS */
    uint16_t run;      /* so many rejections in a row are an event; 0: never */
    uint16_t rejected; /* in a row, so far */
} kq_gate_f32;

typedef struct {
    double limit;
    uint16_t run;
    uint16_t rejected;
} kq_gate_f64;

/** Probability that a good measurement passes: 0.9, 0.95, 0.99, 0.999, 0.9999 */
typedef enum { KQ_LEVEL_90, KQ_LEVEL_95, KQ_LEVEL_99, KQ_LEVEL_999, KQ_LEVEL_9999 } kq_level;

/** limit in Q39.24, as kq_nis_q31 */
typedef struct {
    int64_t limit;
    uint16_t run;
    uint16_t rejected;
} kq_gate_q31;

kq_status kq_update_gated_f32(kq_filter_f32 *f, kq_gate_f32 *g, const kq_sensor_f32 *s,
                              const float *z, uint32_t present);
float kq_chi_square_limit_f32(int m, kq_level level);
kq_status kq_update_huber_f32(kq_filter_f32 *f, const kq_sensor_f32 *s, const float *z,
                              uint32_t present, float k, float *weights);
kq_status kq_update_student_f32(kq_filter_f32 *f, const kq_sensor_f32 *s, const float *z,
                                uint32_t present, float nu, float *weights);
kq_status kq_update_jump_f32(kq_filter_f32 *f, const kq_sensor_f32 *s, const float *z,
                             uint32_t present, float g);
kq_status kq_step_student_f32(kq_filter_f32 *f, const kq_process_f32 *p, const float *u,
                              const kq_sensor_f32 *s, const float *z, uint32_t present, float nu,
                              kq_process_f32 *target, float *q);
kq_status kq_process_scale_noise_f32(kq_process_f32 *target, const kq_process_f32 *source, float q);
kq_status kq_smooth_reweighted_f32(kq_history_f32 *h, kq_process_f32 *target,
                                   const kq_process_f32 *source, float nu, float *q);
kq_status kq_update_gated_f64(kq_filter_f64 *f, kq_gate_f64 *g, const kq_sensor_f64 *s,
                              const double *z, uint32_t present);
double kq_chi_square_limit_f64(int m, kq_level level);
kq_status kq_update_huber_f64(kq_filter_f64 *f, const kq_sensor_f64 *s, const double *z,
                              uint32_t present, double k, double *weights);
kq_status kq_update_student_f64(kq_filter_f64 *f, const kq_sensor_f64 *s, const double *z,
                                uint32_t present, double nu, double *weights);
kq_status kq_update_jump_f64(kq_filter_f64 *f, const kq_sensor_f64 *s, const double *z,
                             uint32_t present, double g);
kq_status kq_step_student_f64(kq_filter_f64 *f, const kq_process_f64 *p, const double *u,
                              const kq_sensor_f64 *s, const double *z, uint32_t present, double nu,
                              kq_process_f64 *target, double *q);
kq_status kq_process_scale_noise_f64(kq_process_f64 *target, const kq_process_f64 *source,
                                     double q);
kq_status kq_smooth_reweighted_f64(kq_history_f64 *h, kq_process_f64 *target,
                                   const kq_process_f64 *source, double nu, double *q);
kq_status kq_update_gated_q31(kq_filter_q31 *f, kq_gate_q31 *g, const kq_sensor_q31 *s,
                              const int32_t *z, uint32_t present);
int64_t kq_chi_square_limit_q31(int m, kq_level level);
kq_status kq_update_huber_q31(kq_filter_q31 *f, const kq_sensor_q31 *s, const int32_t *z,
                              uint32_t present, kq_scaled_q31 k, kq_scaled_q31 *weights);
kq_status kq_update_student_q31(kq_filter_q31 *f, const kq_sensor_q31 *s, const int32_t *z,
                                uint32_t present, kq_scaled_q31 nu, kq_scaled_q31 *weights);
kq_status kq_update_jump_q31(kq_filter_q31 *f, const kq_sensor_q31 *s, const int32_t *z,
                             uint32_t present, kq_scaled_q31 g);
kq_status kq_step_student_q31(kq_filter_q31 *f, const kq_process_q31 *p, const int32_t *u,
                              const kq_sensor_q31 *s, const int32_t *z, uint32_t present,
                              kq_scaled_q31 nu, kq_process_q31 *target, int32_t *root,
                              kq_scaled_q31 *q);
kq_status kq_process_scale_noise_q31(kq_process_q31 *target, const kq_process_q31 *source,
                                     kq_scaled_q31 q, int32_t *root);
kq_status kq_smooth_reweighted_q31(kq_history_q31 *h, kq_process_q31 *target,
                                   const kq_process_q31 *source, int32_t *root, kq_scaled_q31 nu,
                                   kq_scaled_q31 *q);

#ifdef __cplusplus
}
#endif
#endif
