/* Sigma points in float. */
#include "arithmetic/f32.h"
#include "nonlinear/points_float.h"
