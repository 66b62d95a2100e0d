/* Log-likelihoods and NIS, and sums of many of them. */
#ifndef KQ_SRC_ARITHMETIC_SCORES_H
#define KQ_SRC_ARITHMETIC_SCORES_H

#include "arithmetic.h"
#if KQ_FLOATING
#include "scores_float.h"
#else
#include "scores_q31.h"
#endif

#endif
