#ifndef KQ_SRC_MODEL_DEFINITIONS_H
#define KQ_SRC_MODEL_DEFINITIONS_H

#include "../arithmetic/arithmetic.h"
#if KQ_FLOATING
#include "matrices_float.h"
#else
#include "tables_q31.h"
#endif

#endif
