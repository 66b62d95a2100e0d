/* The public functions with a process noise that is scaled. */
#ifndef KQ_SRC_ROBUST_STUDENT_H
#define KQ_SRC_ROBUST_STUDENT_H

#include "../arithmetic/arithmetic.h"
#if KQ_FLOATING
#include "student_float.h"
#else
#include "student_q31.h"
#endif

#endif
