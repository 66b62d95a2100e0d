/* The state, and what moves it: the door of filter/. */
#ifndef KQ_SRC_FILTER_FILTER_H
#define KQ_SRC_FILTER_FILTER_H

#include "copies.h"
#include "correlated.h"
#include "gain.h"
#include "independent.h"
#include "step.h"

#endif
