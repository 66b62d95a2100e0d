/* The public functions of linearised predicts. */
#ifndef KQ_SRC_LINEARISED_API_H
#define KQ_SRC_LINEARISED_API_H

#include "history.h"
#include "predict.h"

#endif
