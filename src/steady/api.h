/* The public functions of steady states. */
#ifndef KQ_SRC_STEADY_API_H
#define KQ_SRC_STEADY_API_H

#include "riccati.h"
#include "freeze.h"
#include "steady.h"

#endif
