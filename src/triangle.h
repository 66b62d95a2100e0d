/* Upper triangular matrices packed by columns: column j is j + 1 contiguous numbers. */
#ifndef KALMANQ_TRIANGLE_H
#define KALMANQ_TRIANGLE_H

static inline int column(int j) { return j * (j + 1) / 2; }

#endif
