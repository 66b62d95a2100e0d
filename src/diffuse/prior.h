#ifndef KQ_SRC_DIFFUSE_PRIOR_H
#define KQ_SRC_DIFFUSE_PRIOR_H

#include "../arithmetic/arithmetic.h"
#if KQ_FLOATING
#include "prior_float.h"
#else
#include "prior_q31.h"
#endif

#endif
