/* kalmanq in float: parameters that are estimated. */
#include "arithmetic/f32.h"
#include "em/em.h"
