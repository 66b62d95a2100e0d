/* What library.inc needs once, for all sizes: the arithmetic. */
#ifndef KALMANQ_COST_LIBRARY_H
#define KALMANQ_COST_LIBRARY_H

#include "program.h"

#include <kalmanq/kalmanq.h>

#ifndef KQ_COST_MODULES
#define HAS_SMOOTHER
#endif

/* B and u of a user's own number of controls */
#if CONTROLS
#define OF_CONTROLS(name) SIZED(name)
#else
#define OF_CONTROLS(name) NULL
#endif

#if defined(KQ_COST_f32)
#define T f32
typedef float word;
#define KQ_COST_PROCESS KQ_PROCESS_F32
#define KQ_COST_SENSOR KQ_SENSOR_DIAGONAL_F32
#define KQ_COST_LEAN_TABLE KQ_SENSOR_LEAN_TABLE_F32
#define KQ_COST_FILTER KQ_FILTER_F32
#define KQ_COST_HISTORY KQ_HISTORY_F32
#define KQ_COST_STEADY KQ_STEADY_F32
#define KQ_COST_SWITCH KQ_SWITCH_F32
#define KQ_COST_LAG KQ_LAG_F32
#define KQ_COST_POINT KQ_POINT_F32
#define KQ_COST_ADAPTATION KQ_ADAPTATION_F32
#define KQ_COST_EM KQ_EM_F32
#elif defined(KQ_COST_f64)
#define T f64
typedef double word;
#define KQ_COST_PROCESS KQ_PROCESS_F64
#define KQ_COST_SENSOR KQ_SENSOR_DIAGONAL_F64
#define KQ_COST_LEAN_TABLE KQ_SENSOR_LEAN_TABLE_F64
#define KQ_COST_FILTER KQ_FILTER_F64
#define KQ_COST_HISTORY KQ_HISTORY_F64
#define KQ_COST_STEADY KQ_STEADY_F64
#define KQ_COST_SWITCH KQ_SWITCH_F64
#define KQ_COST_LAG KQ_LAG_F64
#define KQ_COST_POINT KQ_POINT_F64
#define KQ_COST_ADAPTATION KQ_ADAPTATION_F64
#define KQ_COST_EM KQ_EM_F64
#elif defined(KQ_COST_q31)
#define T q31
typedef int32_t word;
#define KQ_COST_FILTER KQ_FILTER_Q31
#define KQ_COST_HISTORY KQ_HISTORY_Q31
#define KQ_COST_STEADY KQ_STEADY_Q31
#define KQ_COST_SWITCH KQ_SWITCH_Q31
#define KQ_COST_LAG KQ_LAG_Q31
#define KQ_COST_POINT KQ_POINT_Q31
#define KQ_COST_ADAPTATION KQ_ADAPTATION_Q31
#endif

#endif
