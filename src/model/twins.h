/* The twins that an arithmetic chooses: does it fit together?. */
#ifndef KQ_SRC_MODEL_TWINS_H
#define KQ_SRC_MODEL_TWINS_H

#include "../arithmetic/arithmetic.h"
#if KQ_FLOATING
#include "units_float.h"
#else
#include "units_q31.h"
#endif

#endif
