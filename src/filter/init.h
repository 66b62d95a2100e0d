/* The state before the first measurement: by matrices or by a table. */
#ifndef KQ_SRC_FILTER_INIT_H
#define KQ_SRC_FILTER_INIT_H

#include "../arithmetic/arithmetic.h"
#if KQ_FLOATING
#include "init_float.h"
#else
#include "init_q31.h"
#endif

#endif
