/* The public functions of the diffuse start. */
#ifndef KQ_SRC_DIFFUSE_API_H
#define KQ_SRC_DIFFUSE_API_H

#include "prior.h"
#include "smooth.h"
#include "diffuse.h"

#endif
