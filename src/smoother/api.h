/* The public functions of the smoothers: fixed-interval, fixed-lag, fixed-point. */
#ifndef KQ_SRC_SMOOTHER_API_H
#define KQ_SRC_SMOOTHER_API_H

#include "history.h"
#include "instant.h"
#include "lag.h"
#include "smooth.h"

#endif
