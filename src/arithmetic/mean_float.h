/* The mean, in more bits than a number has where that pays. */
#ifndef KQ_SRC_ARITHMETIC_MEAN_FLOAT_H
#define KQ_SRC_ARITHMETIC_MEAN_FLOAT_H

#include "scaled_float.h"
#if KQ_MEAN_IS_PAIR
#include "mean_pair.h"
#else
#include "mean_single.h"
#endif

#endif
