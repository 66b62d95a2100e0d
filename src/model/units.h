#ifndef KQ_SRC_MODEL_UNITS_H
#define KQ_SRC_MODEL_UNITS_H

#include "../arithmetic/arithmetic.h"
#if KQ_FLOATING
#include "units_float.h"
#else
#include "units_q31.h"
#endif

#endif
