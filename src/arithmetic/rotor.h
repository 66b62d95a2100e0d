#ifndef KQ_SRC_ARITHMETIC_ROTOR_H
#define KQ_SRC_ARITHMETIC_ROTOR_H

#include "arithmetic.h"
#if KQ_FLOATING
#include "rotor_float.h"
#else
#include "rotor_q31.h"
#endif

#endif
