/* The steady state by doubling: in floating point alone. */
#ifndef KQ_SRC_STEADY_RICCATI_H
#define KQ_SRC_STEADY_RICCATI_H

#include "../arithmetic/arithmetic.h"
#if KQ_FLOATING
#include "riccati_float.h"
#endif

#endif
