/* kalmanq in double: the self test, compiled as the library is. */
#include "has_double.h"

#if KQ_HAS_DOUBLE
/* Of these files a part is used. */
#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-function"
#endif

#include "types_f64.h"

#include "kalmanq/self_test.h"

#define T(name) kq_##name##_f64

#include "self_test_float.inc"

kq_status kq_self_test_f64(void) { return self_test(); }
#endif
