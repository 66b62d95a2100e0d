/* kalmanq in fixed point: steady states. */
#include "arithmetic/q31.h"
#include "steady/api.h"
