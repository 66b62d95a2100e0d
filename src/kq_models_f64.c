/* kalmanq in double: models from the textbook. */
#include "arithmetic/has_double.h"
#if KQ_HAS_DOUBLE
#include "arithmetic/f64.h"
#include "statistics/models_float.h"
#endif
