/* The public functions of processes and sensors. */
#ifndef KQ_SRC_MODEL_API_H
#define KQ_SRC_MODEL_API_H

#include "../arithmetic/arithmetic.h"
#if KQ_FLOATING
#include "api_float.h"
#else
#include "api_q31.h"
#endif

#endif
