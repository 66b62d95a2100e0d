/* kalmanq in float: the self test, compiled as the library is. */
#include "arithmetic/f32.h"
#include "self_test/self_test_float.h"
