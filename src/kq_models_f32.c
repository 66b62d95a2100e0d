/* kalmanq in float: models from the textbook. */
#include "arithmetic/f32.h"
#include "statistics/models_float.h"
