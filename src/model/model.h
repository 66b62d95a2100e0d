/* What moves, and what is measured: the door of model/. */
#ifndef KQ_SRC_MODEL_MODEL_H
#define KQ_SRC_MODEL_MODEL_H

#include "advance.h"
#include "sensor.h"
#if KQ_FLOATING
#include "matrices_float.h"
#else
#include "tables_q31.h"
#endif

#endif
