/* kalmanq in float: the self test, compiled as the library is. */
/* Of these files a part is used. */
#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-function"
#endif

#include "types_f32.h"

#include "kalmanq/self_test.h"

#define T(name) kq_##name##_f32

#include "self_test_float.inc"

kq_status kq_self_test_f32(void) { return self_test(); }
