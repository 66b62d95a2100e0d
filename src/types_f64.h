/* What the algorithm's names mean in double. */
#ifndef KALMANQ_TYPES_F64_H
#define KALMANQ_TYPES_F64_H

#include "kalmanq/kalmanq.h"

#include "compiler.h"
#include "num_f64.h"

typedef kq_process_f64 process;
typedef kq_sensor_f64 sensor;
typedef kq_filter_f64 filter;
typedef kq_likelihood_f64 likelihood;
typedef kq_likelihood_run_f64 likelihood_run;
typedef kq_history_f64 history;
typedef struct kq_recorder_f64 recorder;
typedef struct kq_sensor_kind_f64 sensor_kind;
typedef kq_smooth_extras_f64 smooth_extras;
typedef kq_tally_f64 tally;
typedef kq_least_squares_f64 least_squares;
typedef kq_consistency_f64 consistency;
typedef kq_gate_f64 gate;
typedef kq_steady_f64 steady;
typedef kq_steady_solution_f64 steady_solution;
typedef kq_steady_smoother_f64 steady_smoother;
typedef kq_switch_f64 settling;
typedef kq_lag_f64 lag_smoother;
typedef kq_point_f64 point_smoother;
typedef kq_start_f64 unknown_start;
typedef kq_em_f64 estimation;
typedef kq_parameters_f64 parameters;
typedef kq_recording_f64 recording;
typedef kq_gradient_f64 gradient;
typedef kq_adaptation_f64 adaptation;
typedef kq_adaptation_rule_f64 adaptation_rule;

typedef num score;

#define RECORDER kq_recorder_f64
#define SENSOR_KIND kq_sensor_kind_f64
#define SENSOR_INDEPENDENT kq_sensor_independent_f64
#define SENSOR_CORRELATED kq_sensor_correlated_f64
#define SENSOR_LEAN kq_sensor_lean_f64

#define FILTER_LEN KQ_FILTER_LEN_F64
#define CONSISTENCY_LEN KQ_CONSISTENCY_LEN_F64
#define HISTORY_LEN KQ_HISTORY_LEN_F64
#define HISTORY_CHANGE_LEN KQ_HISTORY_CHANGE_LEN_F64
#define HISTORY_WORKSPACE_LEN KQ_HISTORY_WORKSPACE_LEN
#define STEADY_LEN KQ_STEADY_LEN_F64
#define STEADY_WORK_LEN KQ_STEADY_WORK_LEN_F64
#define STEADY_SOLVE_LEN KQ_STEADY_SOLVE_LEN_F64
#define SWITCH_LEN KQ_SWITCH_LEN_F64
#define MAP_LEN KQ_MAP_LEN_F64
#define ON_LINE_LEN KQ_ON_LINE_LEN_F64
#define LAG_COLUMNS_LEN KQ_LAG_COLUMNS_LEN
#define LAG_LEN KQ_LAG_LEN_F64
#define POINT_COLUMNS_LEN KQ_POINT_COLUMNS_LEN
#define POINT_LEN KQ_POINT_LEN_F64
#define START_LEN KQ_START_LEN_F64
#define HISTORY_STEP_LEN KQ_HISTORY_STEP_LEN_F64
#define EM_LEN KQ_EM_LEN_F64
#define ADAPTATION_LEN KQ_ADAPTATION_LEN_F64
#define START_PAST_LEN KQ_START_PAST_LEN_F64

#endif
