/* Least squares, begun. */
#ifndef KQ_SRC_STATISTICS_LEAST_SQUARES_INIT_H
#define KQ_SRC_STATISTICS_LEAST_SQUARES_INIT_H

#include "../arithmetic/arithmetic.h"
#if KQ_FLOATING
#include "least_squares_init_float.h"
#else
#include "least_squares_init_q31.h"
#endif

#endif
