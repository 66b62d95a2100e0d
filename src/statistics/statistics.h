#ifndef KQ_SRC_STATISTICS_STATISTICS_H
#define KQ_SRC_STATISTICS_STATISTICS_H

#include "../arithmetic/arithmetic.h"
#if KQ_FLOATING
#include "statistics_float.h"
#else
#include "statistics_q31.h"
#endif

#endif
