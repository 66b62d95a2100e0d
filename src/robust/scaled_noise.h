/* The public functions with a process noise that is scaled. */
#ifndef KQ_SRC_ROBUST_SCALED_NOISE_H
#define KQ_SRC_ROBUST_SCALED_NOISE_H

#include "../arithmetic/arithmetic.h"
#if KQ_FLOATING
#include "scaled_noise_float.h"
#else
#include "scaled_noise_q31.h"
#endif

#endif
