/* kalmanq in double: steady states. */
#include "arithmetic/has_double.h"
#if KQ_HAS_DOUBLE
#include "arithmetic/f64.h"
#include "steady/api.h"
#endif
