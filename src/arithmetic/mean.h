/* The mean, in more bits than a number has where that pays. */
#ifndef KQ_SRC_ARITHMETIC_MEAN_H
#define KQ_SRC_ARITHMETIC_MEAN_H

#include "arithmetic.h"
#if !KQ_FLOATING
#include "mean_q31.h"
#elif KQ_MEAN_IS_PAIR
#include "mean_pair.h"
#else
#include "mean_single.h"
#endif

#endif
