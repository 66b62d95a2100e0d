/* Sigma points in float. */
#include "arithmetic/f32.h"
#include "nonlinear/sigma_points_float.h"
