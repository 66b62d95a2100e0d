#ifndef KQ_SRC_ARITHMETIC_SATURATE_H
#define KQ_SRC_ARITHMETIC_SATURATE_H

#include "arithmetic.h"
#if KQ_FLOATING
#include "saturate_float.h"
#else
#include "saturate_q31.h"
#endif

#endif
