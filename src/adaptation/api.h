/* The public functions of noise adaptation. */
#ifndef KQ_SRC_ADAPTATION_API_H
#define KQ_SRC_ADAPTATION_API_H

#include "adaptation.h"

#endif
