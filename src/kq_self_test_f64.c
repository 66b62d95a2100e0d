/* kalmanq in double: the self test, compiled as the library is. */
#include "arithmetic/has_double.h"

#if KQ_HAS_DOUBLE
/* Of these files a part is used. */
#include "arithmetic/f64.h"

#include "kalmanq/self_test.h"

#include "self_test/self_test_float.h"

kq_status kq_self_test_f64(void) { return self_test(); }
#endif
