#ifndef KQ_SRC_MODEL_TYPES_H
#define KQ_SRC_MODEL_TYPES_H

#include "kalmanq/filter.h"
#include "kalmanq/process.h"
#include "kalmanq/sensor.h"
#include "kalmanq/smoother.h"

#include "../arithmetic/arithmetic.h"

typedef T(kq_process) process;
typedef T(kq_sensor) sensor;
typedef T(kq_filter) filter;
typedef T(kq_history) history;

#endif
