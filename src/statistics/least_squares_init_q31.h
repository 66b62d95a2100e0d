/* Least squares, begun in fixed point: what is measured has a format. */
#ifndef KQ_SRC_STATISTICS_LEAST_SQUARES_INIT_Q31_H
#define KQ_SRC_STATISTICS_LEAST_SQUARES_INIT_Q31_H

#include "kalmanq/fixed_point.h"
#include "kalmanq/least_squares.h"
#include "kalmanq/status.h"

#include "../arithmetic/q31.h"
#include "../arithmetic/scaled.h"
#include "../model/definitions.h"
#include "../model/types.h"
#include "least_squares.h"
#include "statistics.h"

kq_status T(kq_least_squares_init)(least_squares *q, filter *f, scaled lambda,
                                   const kq_format_q31 *measurement_format)
{
    if (!measurement_format) return KQ_ERR_NULL;
    kq_status status = formats_check(measurement_format, 1);
    if (!status) status = least_squares_begin(q, f, lambda);
    if (!status) q->measurement_format = measurement_format;
    return status;
}

#endif
