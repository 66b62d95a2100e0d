#include "fixed_size.h"

#include "kq_fixed_f64.h"

#include "kernels.h"
