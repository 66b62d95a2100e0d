/* Digests of what is built on the filter: on-line smoothers, steady states, robust steps, least
   squares, statistics; and of the model builders. */
#ifndef KALMANQ_BITS_BEYOND_H
#define KALMANQ_BITS_BEYOND_H

#include "model.h"

enum { BEYOND_STATES = 9, BEYOND_COMPONENTS = 3 }; /* the largest model */

void run_beyond(const model_case *c);

#endif
