#include "arithmetic/f64.h"

#include "calm_find.h"
