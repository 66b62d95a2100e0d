#ifndef KQ_SRC_ROBUST_PARAMETERS_H
#define KQ_SRC_ROBUST_PARAMETERS_H

#include "../arithmetic/arithmetic.h"
#if KQ_FLOATING
#include "robust_float.h"
#else
#include "robust_q31.h"
#endif

#endif
