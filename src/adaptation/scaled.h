#ifndef KQ_SRC_ADAPTATION_SCALED_H
#define KQ_SRC_ADAPTATION_SCALED_H

#include "../arithmetic/arithmetic.h"
#if KQ_FLOATING
#include "adaptation_float.h"
#else
#include "adaptation_q31.h"
#endif

#endif
