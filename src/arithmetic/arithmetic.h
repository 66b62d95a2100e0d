/* What a number is, and what is calculated with it: the door of arithmetic/. */
#ifndef KQ_SRC_ARITHMETIC_ARITHMETIC_H
#define KQ_SRC_ARITHMETIC_ARITHMETIC_H

#include "root.h"
#if KQ_FLOATING
#include "matrix_float.h"
#include "pair_float.h"
#endif

#endif
