/* kalmanq in fixed point: sizes and lengths as functions. */
#include "arithmetic/q31.h"
#include "lengths/lengths.h"
