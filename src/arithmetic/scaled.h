#ifndef KQ_SRC_ARITHMETIC_SCALED_H
#define KQ_SRC_ARITHMETIC_SCALED_H

#include "arithmetic.h"
#if KQ_FLOATING
#include "scaled_float.h"
#else
#include "scaled_q31.h"
#endif

#endif
