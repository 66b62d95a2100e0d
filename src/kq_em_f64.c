/* kalmanq in double: parameters that are estimated. */
#include "arithmetic/has_double.h"
#if KQ_HAS_DOUBLE
#include "arithmetic/f64.h"
#include "em/em.h"
#endif
