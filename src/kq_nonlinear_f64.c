/* Sigma points in double. */
#include "arithmetic/has_double.h"
#if KQ_HAS_DOUBLE
#include "arithmetic/f64.h"
#include "nonlinear/sigma_points_float.h"
#endif
