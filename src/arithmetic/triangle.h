/* Upper triangular matrices packed by columns: column j is j + 1 contiguous numbers. */
#ifndef KQ_SRC_ARITHMETIC_TRIANGLE_H
#define KQ_SRC_ARITHMETIC_TRIANGLE_H

static inline int column(int j) { return j * (j + 1) / 2; }

#endif
