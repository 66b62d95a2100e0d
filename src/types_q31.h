/* What the algorithm's names mean in fixed point. */
#ifndef KALMANQ_TYPES_Q31_H
#define KALMANQ_TYPES_Q31_H

#include "kalmanq/kalmanq.h"

#include "compiler.h"
#include "num_q31.h"

typedef kq_process_q31 process;
typedef kq_sensor_q31 sensor;
typedef kq_filter_q31 filter;
typedef kq_likelihood_q31 likelihood;
typedef kq_likelihood_run_q31 likelihood_run;
typedef kq_history_q31 history;
typedef struct kq_recorder_q31 recorder;
typedef struct kq_sensor_kind_q31 sensor_kind;
typedef kq_smooth_extras_q31 smooth_extras;
typedef kq_tally_q31 tally;
typedef kq_least_squares_q31 least_squares;
typedef kq_consistency_q31 consistency;
typedef kq_gate_q31 gate;
typedef kq_steady_q31 steady;
typedef kq_steady_smoother_q31 steady_smoother;
typedef kq_switch_q31 settling;
typedef kq_lag_q31 lag_smoother;
typedef kq_point_q31 point_smoother;
typedef kq_start_q31 unknown_start;
typedef kq_adaptation_q31 adaptation;
typedef kq_adaptation_rule_q31 adaptation_rule;
typedef int64_t score;

#define RECORDER kq_recorder_q31
#define SENSOR_KIND kq_sensor_kind_q31
#define SENSOR_INDEPENDENT kq_sensor_independent_q31
#define SENSOR_CORRELATED kq_sensor_correlated_q31
#define SENSOR_LEAN kq_sensor_lean_q31

#define FILTER_LEN KQ_FILTER_LEN_Q31
#define CONSISTENCY_LEN KQ_CONSISTENCY_LEN_Q31
#define HISTORY_LEN KQ_HISTORY_LEN_Q31
#define HISTORY_CHANGE_LEN KQ_HISTORY_CHANGE_LEN_Q31
#define HISTORY_WORKSPACE_LEN KQ_HISTORY_WORKSPACE_LEN_Q31
#define STEADY_LEN KQ_STEADY_LEN_Q31
#define STEADY_WORK_LEN KQ_STEADY_WORK_LEN_Q31
#define SWITCH_LEN KQ_SWITCH_LEN_Q31
#define MAP_LEN KQ_MAP_LEN_Q31
#define ON_LINE_LEN KQ_ON_LINE_LEN_Q31
#define LAG_COLUMNS_LEN KQ_LAG_COLUMNS_LEN
#define LAG_LEN KQ_LAG_LEN_Q31
#define POINT_COLUMNS_LEN KQ_POINT_COLUMNS_LEN
#define POINT_LEN KQ_POINT_LEN_Q31
#define START_LEN KQ_START_LEN_Q31
#define ADAPTATION_LEN KQ_ADAPTATION_LEN_Q31
#define START_PAST_LEN KQ_START_PAST_LEN_Q31

#endif
