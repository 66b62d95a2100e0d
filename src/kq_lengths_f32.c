/* kalmanq in float: sizes and lengths as functions. */
#include "arithmetic/f32.h"
#include "lengths/lengths.h"
