#ifndef KQ_SRC_ARITHMETIC_ROWS_H
#define KQ_SRC_ARITHMETIC_ROWS_H

#include "arithmetic.h"
#if KQ_FLOATING
#include "rows_float.h"
#else
#include "rows_q31.h"
#endif

#endif
