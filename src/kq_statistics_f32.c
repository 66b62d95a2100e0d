/* kalmanq in float: least squares and consistency. */
#include "arithmetic/f32.h"
#include "statistics/api.h"
