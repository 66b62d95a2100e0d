/* The public functions of expectation maximisation. */
#ifndef KQ_SRC_EM_API_H
#define KQ_SRC_EM_API_H

#include "em.h"

#endif
