/* kalmanq in double: sizes and lengths as functions. */
#include "arithmetic/has_double.h"
#if KQ_HAS_DOUBLE
#include "arithmetic/f64.h"
#include "lengths/lengths.h"
#endif
