/* The sizes that there are */
#ifndef KQ_SRC_ARITHMETIC_SIZE_H
#define KQ_SRC_ARITHMETIC_SIZE_H

#include "kalmanq/size.h"

static inline int size_is_valid(int size) { return size >= 1 && size <= KQ_SIZE_MAX; }

#endif
