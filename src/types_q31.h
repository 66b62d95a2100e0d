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
typedef kq_history_q31 history;
typedef kq_smooth_extras_q31 smooth_extras;
typedef kq_lag_q31 lag_smoother;
typedef kq_point_q31 point_smoother;
typedef int64_t score;

#define FILTER_LEN KQ_FILTER_LEN_Q31
#define HISTORY_LEN KQ_HISTORY_LEN_Q31
#define HISTORY_CHANGE_LEN KQ_HISTORY_CHANGE_LEN_Q31
#define HISTORY_WORKSPACE_LEN KQ_HISTORY_WORKSPACE_LEN_Q31
#define MAP_LEN KQ_MAP_LEN_Q31
#define ON_LINE_LEN KQ_ON_LINE_LEN_Q31
#define LAG_COLUMNS_LEN KQ_LAG_COLUMNS_LEN
#define LAG_LEN KQ_LAG_LEN_Q31
#define POINT_COLUMNS_LEN KQ_POINT_COLUMNS_LEN
#define POINT_LEN KQ_POINT_LEN_Q31

#endif
