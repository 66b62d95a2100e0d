/* The kernel of the steady filter, and what it checks: the door of steady/. */
#ifndef KQ_SRC_STEADY_STEADY_H
#define KQ_SRC_STEADY_STEADY_H

#include "kernel.h"
#if KQ_FLOATING
#include "checks_float.h"
#else
#include "checks_q31.h"
#endif

#endif
