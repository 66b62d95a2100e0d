/* The public functions of updates against outliers and jumps, and of a process noise that is scaled. */
#ifndef KQ_SRC_ROBUST_API_H
#define KQ_SRC_ROBUST_API_H

#include "gate.h"
#include "losses.h"
#include "robust.h"
#include "scaled_noise.h"

#endif
