/* What the algorithm's names mean in float. */
#ifndef KALMANQ_TYPES_F32_H
#define KALMANQ_TYPES_F32_H

#include "kalmanq/kalmanq.h"

#include "compiler.h"
#include "num_f32.h"

typedef kq_process_f32 process;
typedef kq_sensor_f32 sensor;
typedef kq_filter_f32 filter;
typedef kq_likelihood_f32 likelihood;
typedef kq_history_f32 history;
typedef kq_smooth_extras_f32 smooth_extras;
typedef kq_start_f32 unknown_start;

typedef num score;

#define FILTER_LEN KQ_FILTER_LEN_F32
#define HISTORY_LEN KQ_HISTORY_LEN_F32
#define HISTORY_CHANGE_LEN KQ_HISTORY_CHANGE_LEN_F32
#define HISTORY_WORKSPACE_LEN KQ_HISTORY_WORKSPACE_LEN
#define START_LEN KQ_START_LEN_F32
#define START_PAST_LEN KQ_START_PAST_LEN_F32

#endif
