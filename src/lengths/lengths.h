/* Of what only floating point has, or only fixed point */
#ifndef KQ_SRC_LENGTHS_LENGTHS_H
#define KQ_SRC_LENGTHS_LENGTHS_H

#include "../arithmetic/arithmetic.h"

#if KQ_FLOATING
#include "lengths_float.h"
#else
#include "lengths_q31.h"
#endif

#endif
