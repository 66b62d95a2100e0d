/* Nonlinear models in float. */
#include "arithmetic/f32.h"
#include "nonlinear/api.h"
#include "nonlinear/points_float.h"
