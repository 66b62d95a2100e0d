/* A range_error of formats in words. */
#include "messages/range_error_q31.h"
