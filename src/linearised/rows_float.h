/* The root of rows side by side, in floating point: one copy of it for sigma points and their processes. */
#ifndef KQ_SRC_LINEARISED_ROWS_FLOAT_H
#define KQ_SRC_LINEARISED_ROWS_FLOAT_H

#include "../arithmetic/arithmetic.h"
#include "../model/advance.h"
#include "../model/process.h"
#include "../model/types.h"
#include "../filter/checks.h"
#include "rows.h"

kq_status T(kq_update_check)(const filter *f, const sensor *s) { return sensor_check_for(f, s); }

extent T(kq_root_of_rows)(num *root, num *rows, const process *p, num *pq)
{
    return triangularise(root, rows, p->states, p, p->states, pq, SHAPE_DENSE);
}

#endif
