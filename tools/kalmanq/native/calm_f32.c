#include "arithmetic/f32.h"

#include "calm_find.h"
