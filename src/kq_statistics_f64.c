/* kalmanq in double: least squares and consistency. */
#include "arithmetic/has_double.h"
#if KQ_HAS_DOUBLE
#include "arithmetic/f64.h"
#include "statistics/api.h"
#endif
