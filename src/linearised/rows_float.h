/* What sigma points need of the filter, in floating point: one copy for them and for their processes. */
#ifndef KQ_SRC_LINEARISED_ROWS_FLOAT_H
#define KQ_SRC_LINEARISED_ROWS_FLOAT_H

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/coordinates.h"
#include "../arithmetic/mean.h"
#include "../model/advance.h"
#include "../model/process.h"
#include "../model/types.h"
#include "../filter/checks.h"
#include "../filter/filter.h"
#include "../filter/sharp.h"
#include "../smoother/whitened.h"
#include "mean.h"
#include "rows.h"

kq_status T(kq_update_check)(const filter *f, const sensor *s) { return sensor_check_for(f, s); }

void T(kq_root_of_rows)(num *root, num *rows, const process *p, num *pq)
{
    triangularise(root, rows, p->states, p, p->states, pq, SHAPE_DENSE);
}

kq_status T(kq_update_by_rows)(filter *f, const sensor *s, const num *e, num *own)
{
    kq_status status = free_mean_check(f);
    if (status) return status;
    const int n = f->states;
    num *state = f->memory, *root = own + MEAN_PLANES * n;
    for (int k = 0; k < FILTER_LEN(n); k++) own[k] = 0;
    for (int k = 0; k < n; k++) root_set_unit(root, n, k);
    f->memory = own;
    status = T(kq_update)(f, s, e);
    f->memory = state;
    if (status < KQ_OK) return status;
    for (int k = 0; k < n; k++) own[k] = mean_get(own, n, k);
    filter_note(f, smoothed_state(state, own, root, n));
    if (!mean_is_finite(state, n)) refuse_overflow(f);
    return status;
}

#endif
