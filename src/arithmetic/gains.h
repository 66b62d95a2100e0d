#ifndef KQ_SRC_ARITHMETIC_GAINS_H
#define KQ_SRC_ARITHMETIC_GAINS_H

#include "arithmetic.h"
#if KQ_FLOATING
#include "gains_float.h"
#else
#include "gains_q31.h"
#endif

#endif
