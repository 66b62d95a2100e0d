/* What sigma points need of the filter, in floating point: one copy for them and for their processes. */
#ifndef KQ_SRC_LINEARISED_ROWS_FLOAT_H
#define KQ_SRC_LINEARISED_ROWS_FLOAT_H

#include "linearised_float.h"

kq_status T(kq_update_check)(const filter *f, const sensor *s) { return sensor_check_for(f, s); }

extent T(kq_root_of_rows)(num *root, num *rows, const process *p, num *pq)
{
    return triangularise(root, rows, p->states, p, p->states, pq, SHAPE_DENSE);
}

/* S <- S U and a <- S a, row by row */
static void root_by_root(num *S, const num *U, num *a, int n)
{
    num row[KQ_SIZE_MAX];
    for (int i = 0; i < n; i++) {
        num moved = 0, *s = S;
        for (int k = i; k < n; s += ++k) {
            row[k] = *s;
            moved += *s * a[k];
        }
        a[i] = moved;
        const num *u = U;
        s = S;
        for (int j = i; j < n; u += j) {
            *s = dot(row[i] * u[0], row + i + 1, u + 1, j - i);
            s += ++j;
        }
        S += i + 2;
        U += i + 2;
    }
}

kq_status T(kq_update_by_rows)(filter *f, const sensor *s, const num *e, num *own)
{
    kq_status status = free_mean_check(f);
    if (status) return status;
    const int n = f->states;
    num *x = f->memory, *U = own + MEAN_PLANES * n;
    for (int k = 0; k < FILTER_LEN(n); k++) own[k] = 0;
    for (int k = 0; k < n; k++) U[column(k) + k] = 1;
    f->memory = own;
    status = T(kq_update)(f, s, e);
    f->memory = x;
    if (status < KQ_OK) return status;
    for (int k = 0; k < n; k++) own[k] = mean_get(own, n, k);
    root_by_root(x + MEAN_PLANES * n, U, own, n);
    move_by(f, own, 0);
    return status;
}

#endif
