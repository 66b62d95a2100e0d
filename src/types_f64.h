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
typedef kq_history_f64 history;
typedef kq_smooth_extras_f64 smooth_extras;
typedef kq_start_f64 unknown_start;

typedef num score;

#define FILTER_LEN KQ_FILTER_LEN_F64
#define HISTORY_LEN KQ_HISTORY_LEN_F64
#define HISTORY_CHANGE_LEN KQ_HISTORY_CHANGE_LEN_F64
#define HISTORY_WORKSPACE_LEN KQ_HISTORY_WORKSPACE_LEN
#define START_LEN KQ_START_LEN_F64
#define START_PAST_LEN KQ_START_PAST_LEN_F64

#endif
