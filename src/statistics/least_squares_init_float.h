/* Least squares, begun in floating point. */
#ifndef KQ_SRC_STATISTICS_LEAST_SQUARES_INIT_FLOAT_H
#define KQ_SRC_STATISTICS_LEAST_SQUARES_INIT_FLOAT_H

#include "kalmanq/least_squares.h"
#include "kalmanq/status.h"

#include "../arithmetic/arithmetic.h"
#include "../model/types.h"
#include "least_squares.h"
#include "statistics.h"

kq_status T(kq_least_squares_init)(least_squares *q, filter *f, num lambda)
{
    return least_squares_begin(q, f, lambda);
}

#endif
