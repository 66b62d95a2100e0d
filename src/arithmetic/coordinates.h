#ifndef KQ_SRC_ARITHMETIC_COORDINATES_H
#define KQ_SRC_ARITHMETIC_COORDINATES_H

#include "arithmetic.h"
#if KQ_FLOATING
#include "coordinates_float.h"
#else
#include "coordinates_q31.h"
#endif

#endif
