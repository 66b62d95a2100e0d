#include "../arithmetic/f32.h" /* installed beside kq_fixed_f32.h */

#include "calm_find.h"
