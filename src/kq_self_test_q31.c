/* kalmanq in fixed point: the self test, compiled as the library is. */
#include "self_test/self_test_q31.h"
