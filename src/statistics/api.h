/* The public functions of least squares and of consistency. */
#ifndef KQ_SRC_STATISTICS_API_H
#define KQ_SRC_STATISTICS_API_H

#include "consistency.h"
#include "least_squares_init.h"

#endif
