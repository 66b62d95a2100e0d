/* The public functions of robust updates. */
#ifndef KQ_SRC_ROBUST_API_H
#define KQ_SRC_ROBUST_API_H

#include "gate.h"
#include "scaled_noise.h"

#endif
