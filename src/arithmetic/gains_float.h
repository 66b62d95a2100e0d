/* The mean of a steady-state filter in floating point: one number a state. */
#ifndef KQ_SRC_ARITHMETIC_GAINS_FLOAT_H
#define KQ_SRC_ARITHMETIC_GAINS_FLOAT_H

#include "rows_float.h"

/* A state between predict and update */
typedef num steady_word;

/* An innovation */
typedef num steady_number;

static inline num steady_get(const num *x, int n, int i)
{
    (void)n;
    return x[i];
}

static inline void steady_set(num *x, int n, int i, num value)
{
    (void)n;
    x[i] = value;
}

static inline void steady_keep(num *x, int n, int i, steady_word value)
{
    (void)n;
    x[i] = value;
}

static inline steady_word steady_whole(const num *x, int n, int i) { return steady_get(x, n, i); }

/* *t <- row'x, where the row is zero left of `first`; and with a drive */
KQ_KERNEL unsigned steady_row(steady_word *t, int n, const num *row, int first, const num *x)
{
    *t = dot(row[n - 1] * x[n - 1], row + first, x + first, n - 1 - first);
    return 0;
}

KQ_KERNEL unsigned steady_drive(steady_word *t, int n, const num *row, int first, const num *x,
                                num drive)
{
    *t = dot(drive, row + first, x + first, n - first);
    return 0;
}

/* z - h't; a row that takes one state alone is not looked for */
KQ_KERNEL num steady_residual(num z, const num *h, int selected, const steady_word *t, int n)
{
    (void)selected;
    KQ_UNROLL
    for (int k = 0; k < n; k++) z -= h[k] * t[k];
    return z;
}

/* Are they numbers, as they are where z and all of the mean are? */
KQ_KERNEL int innovations_are_finite(const steady_number *e, int m)
{
    num rests = 0;
    KQ_UNROLL
    for (int c = 0; c < m; c++) rests = c ? rests + (e[c] - e[c]) : e[c] - e[c];
    return rests == 0;
}

static inline num steady_word_of(steady_number e) { return e; }

/* x_i <- t + row'e */
KQ_KERNEL unsigned steady_add(num *x, steady_word t, int n, int i, const num *row, const num *e,
                              int m)
{
    (void)n;
    x[i] = dot(t, row, e, m);
    return 0;
}

#endif
