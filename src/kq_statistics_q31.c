/* kalmanq in fixed point: least squares and consistency. */
#include "arithmetic/q31.h"
#include "statistics/api.h"
