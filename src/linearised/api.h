/* The public functions of linearised steps. */
#ifndef KQ_SRC_LINEARISED_API_H
#define KQ_SRC_LINEARISED_API_H

#include "history.h"
#include "innovation.h"
#include "predict.h"
#include "sensor.h"

#endif
