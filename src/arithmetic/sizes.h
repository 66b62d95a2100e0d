/* The sizes that there are, and upper triangular matrices packed by columns: column j is j + 1 contiguous numbers. */
#ifndef KQ_SRC_ARITHMETIC_SIZES_H
#define KQ_SRC_ARITHMETIC_SIZES_H

#include "kalmanq/size.h"

static inline int size_is_valid(int size) { return size >= 1 && size <= KQ_SIZE_MAX; }

static inline int column(int j) { return j * (j + 1) / 2; }

/* What the reflections of n rows keep, two numbers each (triangularise) */
#define REFLECTOR_LEN(n) (2 * (n))

#endif
