/*
 * kalmanq: sizes and lengths as functions, for languages that have no C macros.
 *
 * What C says with KQ_FILTER_LEN_F32(n) and sizeof(kq_filter_f32) is here a call: a binding, or a program that
 * links the shared library, allocates an object and its memory by these, gives it both by kq_..._assign, and
 * never looks inside.
 *
 *     kq_..._length_<T>   numbers of memory for these sizes, of the arithmetic's kind: float, double, and in
 *                         q31 int32_t (adaptation: kq_scaled_q31).  Each is the macro KQ_..._LEN, in whose
 *                         header the arguments are described.  0 where a size is not in its range: one
 *                         that assign refuses; of a history, whose assign is not told of it, m outside of
 *                         1 .. 65535 (that of a history, a lag and an instant is the most scalar measurements
 *                         of one step, of all sensors together, and may be above 16)
 *     kq_..._size_<T>     bytes of the object itself
 *
 * They cost a few instructions, keep no state and can be called from everywhere.
 */
#ifndef KALMANQ_LENGTHS_H
#define KALMANQ_LENGTHS_H

#include "adaptation.h"
#include "consistency.h"
#include "em.h"
#include "lag.h"
#include "least_squares.h"
#include "models.h"
#include "instant.h"
#include "robust.h"
#include "start.h"
#include "steady.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------ words of memory */

kq_length kq_process_length_f32(int n);
kq_length kq_process_length_f64(int n);
kq_length kq_sensor_length_f32(int m);
kq_length kq_sensor_length_f64(int m);
kq_length kq_filter_length_f32(int n);
kq_length kq_filter_length_f64(int n);
kq_length kq_filter_length_q31(int n);
kq_length kq_history_length_f32(int n, int m, size_t steps, size_t changes);
kq_length kq_history_length_f64(int n, int m, size_t steps, size_t changes);
kq_length kq_history_length_q31(int n, int m, size_t steps, size_t changes);
kq_length kq_lag_length_f32(int n, int m, size_t L);
kq_length kq_lag_length_f64(int n, int m, size_t L);
kq_length kq_lag_length_q31(int n, int m, size_t L);
kq_length kq_instant_length_f32(int n, int m);
kq_length kq_instant_length_f64(int n, int m);
kq_length kq_instant_length_q31(int n, int m);
kq_length kq_start_length_f32(int n, size_t early);
kq_length kq_start_length_f64(int n, size_t early);
kq_length kq_start_length_q31(int n, size_t early);
kq_length kq_adaptation_length_f32(int n, int m);
kq_length kq_adaptation_length_f64(int n, int m);
kq_length kq_adaptation_length_q31(int n, int m);
kq_length kq_consistency_length_f32(int m, size_t window);
kq_length kq_consistency_length_f64(int m, size_t window);
kq_length kq_consistency_length_q31(int m, size_t window);
kq_length kq_steady_length_f32(int n);
kq_length kq_steady_length_f64(int n);
kq_length kq_steady_length_q31(int n);
kq_length kq_steady_work_length_f32(int n, int m);
kq_length kq_steady_work_length_f64(int n, int m);
kq_length kq_steady_work_length_q31(int n, int m);
kq_length kq_steady_solve_length_f32(int n, int m);
kq_length kq_steady_solve_length_f64(int n, int m);
kq_length kq_settling_length_f32(int n);
kq_length kq_settling_length_f64(int n);
kq_length kq_settling_length_q31(int n);
kq_length kq_em_length_f32(int n, int m, size_t steps);
kq_length kq_em_length_f64(int n, int m, size_t steps);
kq_length kq_model_length_f32(int n, int r, int m);
kq_length kq_model_length_f64(int n, int r, int m);
kq_length kq_root_length_q31(int n);

/* ------------------------------------------------------------------ bytes of an object */

size_t kq_process_size_f32(void);
size_t kq_process_size_f64(void);
size_t kq_process_size_q31(void);
size_t kq_sensor_size_f32(void);
size_t kq_sensor_size_f64(void);
size_t kq_sensor_size_q31(void);
size_t kq_filter_size_f32(void);
size_t kq_filter_size_f64(void);
size_t kq_filter_size_q31(void);
size_t kq_history_size_f32(void);
size_t kq_history_size_f64(void);
size_t kq_history_size_q31(void);
size_t kq_lag_size_f32(void);
size_t kq_lag_size_f64(void);
size_t kq_lag_size_q31(void);
size_t kq_instant_size_f32(void);
size_t kq_instant_size_f64(void);
size_t kq_instant_size_q31(void);
size_t kq_start_size_f32(void);
size_t kq_start_size_f64(void);
size_t kq_start_size_q31(void);
size_t kq_adaptation_size_f32(void);
size_t kq_adaptation_size_f64(void);
size_t kq_adaptation_size_q31(void);
size_t kq_consistency_size_f32(void);
size_t kq_consistency_size_f64(void);
size_t kq_consistency_size_q31(void);
size_t kq_least_squares_size_f32(void);
size_t kq_least_squares_size_f64(void);
size_t kq_least_squares_size_q31(void);
size_t kq_steady_size_f32(void);
size_t kq_steady_size_f64(void);
size_t kq_steady_size_q31(void);
size_t kq_settling_size_f32(void);
size_t kq_settling_size_f64(void);
size_t kq_settling_size_q31(void);
size_t kq_gate_size_f32(void);
size_t kq_gate_size_f64(void);
size_t kq_gate_size_q31(void);
size_t kq_em_size_f32(void);
size_t kq_em_size_f64(void);

#ifdef __cplusplus
}
#endif
#endif
