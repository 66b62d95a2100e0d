/* Tables of fixed point, prepared from doubles: where there are any. */
#include "arithmetic/has_double.h"
#if KQ_HAS_DOUBLE
#include "model/prepare_q31.h"
#endif
