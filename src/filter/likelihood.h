#ifndef KQ_SRC_FILTER_LIKELIHOOD_H
#define KQ_SRC_FILTER_LIKELIHOOD_H

#include "../arithmetic/arithmetic.h"
#if KQ_FLOATING
#include "likelihood_float.h"
#else
#include "likelihood_q31.h"
#endif

#endif
