/* kalmanq in double: noise levels that are learnt. */
#include "arithmetic/has_double.h"
#if KQ_HAS_DOUBLE
#include "arithmetic/f64.h"
#include "adaptation/adaptation.h"
#endif
