/* Nonlinear models in fixed point. */
#include "arithmetic/q31.h"
#include "nonlinear/api.h"
