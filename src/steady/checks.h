#ifndef KQ_SRC_STEADY_CHECKS_H
#define KQ_SRC_STEADY_CHECKS_H

#include "../arithmetic/arithmetic.h"
#if KQ_FLOATING
#include "checks_float.h"
#else
#include "checks_q31.h"
#endif

#endif
