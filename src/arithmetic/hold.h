#ifndef KQ_SRC_ARITHMETIC_HOLD_H
#define KQ_SRC_ARITHMETIC_HOLD_H

#include "arithmetic.h"
#if KQ_FLOATING
#include "hold_float.h"
#else
#include "hold_q31.h"
#endif

#endif
