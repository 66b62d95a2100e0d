/* The public functions of the unknown start. */
#ifndef KQ_SRC_START_API_H
#define KQ_SRC_START_API_H

#include "prior.h"
#include "smooth.h"
#include "start.h"

#endif
