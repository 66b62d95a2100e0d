/* Least squares, begun.  In fixed point what is measured has a format. */
#ifndef KQ_SRC_STATISTICS_LEAST_SQUARES_INIT_H
#define KQ_SRC_STATISTICS_LEAST_SQUARES_INIT_H

#include "least_squares.h"

#if KQ_FLOATING

kq_status T(kq_least_squares_init)(least_squares *q, filter *f, num lambda)
{
    return least_squares_begin(q, f, lambda);
}

#else

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

#endif
