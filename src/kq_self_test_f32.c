/* kalmanq in float: the self test, compiled as the library is. */
/* Of these files a part is used. */
#include "arithmetic/f32.h"

#include "kalmanq/self_test.h"

#include "self_test/self_test_float.h"

kq_status kq_self_test_f32(void) { return self_test(); }
