/* The mean, in more bits than a number has where that pays. */
#ifndef KQ_SRC_ARITHMETIC_MEAN_FLOAT_H
#define KQ_SRC_ARITHMETIC_MEAN_FLOAT_H

#include "scaled_float.h"
#if KQ_MEAN_IS_PAIR
#include "mean_pair.h"
#else
#include "mean_single.h"
#endif

static inline num control_drive(const num *row, const num *u, int count)
{
    return dot(0, row, u, count);
}

static inline scaled mean_residual_carried(num z, const num *h, const num *x, int n)
{
    return mean_residual(z, h, x, n, 0, n);
}

#endif
