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
typedef kq_start_q31 unknown_start;
typedef int64_t score;

#define FILTER_LEN KQ_FILTER_LEN_Q31
#define HISTORY_LEN KQ_HISTORY_LEN_Q31
#define HISTORY_CHANGE_LEN KQ_HISTORY_CHANGE_LEN_Q31
#define HISTORY_WORKSPACE_LEN KQ_HISTORY_WORKSPACE_LEN_Q31
#define START_LEN KQ_START_LEN_Q31
#define START_PAST_LEN KQ_START_PAST_LEN_Q31

#endif
