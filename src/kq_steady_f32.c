/* kalmanq in float: steady states. */
#include "arithmetic/f32.h"
#include "steady/api.h"
