/* The inits of sensors that take innovations. */
#ifndef KQ_SRC_LINEARISED_SENSOR_H
#define KQ_SRC_LINEARISED_SENSOR_H

#include "../arithmetic/arithmetic.h"
#if KQ_FLOATING
#include "sensor_float.h"
#else
#include "sensor_q31.h"
#endif

#endif
