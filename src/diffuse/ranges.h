#ifndef KQ_SRC_DIFFUSE_RANGES_H
#define KQ_SRC_DIFFUSE_RANGES_H

#include "../arithmetic/arithmetic.h"
#if KQ_FLOATING
#include "ranges_float.h"
#else
#include "ranges_q31.h"
#endif

#endif
