#include "fixed_size.h"

#include "kq_fixed_f32.h"

#include "kernels.h"
