/* The public functions of the diffuse start. */
#ifndef KQ_SRC_DIFFUSE_API_H
#define KQ_SRC_DIFFUSE_API_H

#include "smooth.h"
#if KQ_FLOATING
#include "prior_float.h"
#else
#include "prior_q31.h"
#endif

#endif
