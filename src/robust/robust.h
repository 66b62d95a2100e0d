/* Parameters of losses, and scaled roots: the door of robust/. */
#ifndef KQ_SRC_ROBUST_ROBUST_H
#define KQ_SRC_ROBUST_ROBUST_H

#include "../smoother/smoother.h"
#if KQ_FLOATING
#include "robust_float.h"
#else
#include "robust_q31.h"
#endif

#endif
