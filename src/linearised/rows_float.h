/* The root of rows side by side, in floating point: one copy of it for sigma points and their processes. */
#ifndef KQ_SRC_LINEARISED_ROWS_FLOAT_H
#define KQ_SRC_LINEARISED_ROWS_FLOAT_H

#include "../arithmetic/arithmetic.h"
#include "../model/advance.h"
#include "../model/process.h"
#include "../model/types.h"
#include "rows.h"

void T(kq_root_of_rows)(num *root, num *rows, int width, const process *p, num *pq)
{
    triangularise(root, rows, width, p, p->states, pq, SHAPE_DENSE);
}

#endif
