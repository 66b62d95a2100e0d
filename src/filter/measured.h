#ifndef KQ_SRC_FILTER_MEASURED_H
#define KQ_SRC_FILTER_MEASURED_H

#include "../arithmetic/arithmetic.h"
#if KQ_FLOATING
#include "measured_float.h"
#else
#include "measured_q31.h"
#endif

#endif
