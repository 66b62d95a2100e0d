#include "../arithmetic/f64.h" /* installed beside kq_fixed_f64.h */

#include "calm_find.h"
