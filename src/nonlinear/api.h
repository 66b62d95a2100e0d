/* The public functions of nonlinear updates. */
#ifndef KQ_SRC_NONLINEAR_API_H
#define KQ_SRC_NONLINEAR_API_H

#include "innovation.h"

#endif
