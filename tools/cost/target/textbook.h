/* Once, for all sizes: the textbook filters, in float or Q16.16. */
#ifndef KALMANQ_COST_TEXTBOOK_H
#define KALMANQ_COST_TEXTBOOK_H

#include "program.h"

#include <string.h>

#ifdef KQ_COST_q16
#include "q16_filter.h"
#define CALL(name) q16_##name
typedef int32_t word;
#else
#include "textbook_filter.h"
#define CALL(name) textbook_##name
typedef float word;
#endif

#endif
