/* The twins that an arithmetic chooses: scores, and a row as a sensor. */
#ifndef KQ_SRC_STATISTICS_TWINS_H
#define KQ_SRC_STATISTICS_TWINS_H

#include "../filter/filter.h"
#if KQ_FLOATING
#include "statistics_float.h"
#else
#include "statistics_q31.h"
#endif

#endif
