#ifndef KQ_SRC_ARITHMETIC_REFLECTOR_H
#define KQ_SRC_ARITHMETIC_REFLECTOR_H

#include "arithmetic.h"
#if KQ_FLOATING
#include "reflector_float.h"
#else
#include "reflector_q31.h"
#endif

#endif
