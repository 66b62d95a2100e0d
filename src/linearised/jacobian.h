#ifndef KQ_SRC_LINEARISED_JACOBIAN_H
#define KQ_SRC_LINEARISED_JACOBIAN_H

#include "../arithmetic/arithmetic.h"
#if KQ_FLOATING
#include "jacobian_float.h"
#else
#include "jacobian_q31.h"
#endif

#endif
