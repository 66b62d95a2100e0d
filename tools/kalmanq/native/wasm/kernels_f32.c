#include "fixed_size.h"

#include "kq_fixed_f32.h"

#undef KQ_UNROLL /* sizes are known at run time alone */
#define KQ_UNROLL
#include "calm.h"

#include "kernels.h"
