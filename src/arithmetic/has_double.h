/* Where double has fewer than 64 bits, as with older versions of avr-gcc, there is no f64, and tables of
   q31 are prepared on the host: those files compile to nothing. */
#ifndef KQ_SRC_ARITHMETIC_HAS_DOUBLE_H
#define KQ_SRC_ARITHMETIC_HAS_DOUBLE_H

#include "language.h"
#include <float.h>
#include <stdint.h>

#define KQ_HAS_DOUBLE (DBL_MANT_DIG == 53)

#endif
