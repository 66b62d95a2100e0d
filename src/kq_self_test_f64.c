/* kalmanq in double: the self test, compiled as the library is. */
#include "arithmetic/has_double.h"
#if KQ_HAS_DOUBLE
#include "arithmetic/f64.h"
#include "self_test/self_test_float.h"
#endif
