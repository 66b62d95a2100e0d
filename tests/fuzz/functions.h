/*
 * Functions of the user, made of bytes, for sigma points (f32, f64): linear, bent, bounded, with jumps, or not finite at one
 * of the points.  What must hold of every call: all points or none, the mean first; a value that is not finite is refused.
 */
#ifndef KALMANQ_FUZZ_FUNCTIONS_H
#define KALMANQ_FUZZ_FUNCTIONS_H

#include "judge.h"

enum { LINEAR, BENT, BOUNDED, JUMPS, LEFT_OUT, INFINITE, FUNCTIONS };

typedef struct {
    const K(filter) *where; /* it is linearised */
    int n, rows, calls, bad; /* bad: the call whose last value is none */
    unsigned kind;
    num M[SQUARE], c[MOST];
    int is_spoiled; /* a value was not finite */
} function;

static num bent(unsigned kind, num a)
{
    if (kind == BENT) return a + a * a / 16;
    if (kind == BOUNDED) return a / (1 + (num)fabs((double)a));
    return kind == JUMPS ? (num)(a < 0 ? -1 : 1) : a;
}

static void call_function(void *context, const num *x, num *y)
{
    function *g = context;
    for (int i = 0; g->calls == 0 && i < g->n; i++) DEMAND(x[i] == K(mean)(g->where, i));
    g->calls++;
    for (int c = 0; c < g->rows; c++) {
        const int is_bad = g->calls == g->bad && c == g->rows - 1;
        num sum = g->c[c];
        for (int i = 0; i < g->n; i++) sum += g->M[c * g->n + i] * x[i];
        if (is_bad && g->kind == LEFT_OUT) {
            g->is_spoiled = 1;
            continue;
        }
        y[c] = is_bad && g->kind == INFINITE ? (num)INFINITY : bent(g->kind, sum);
        g->is_spoiled |= !isfinite(y[c]);
    }
}

static void make_function(function *g, const K(filter) *where, int rows)
{
    memset(g, 0, sizeof *g);
    g->where = where, g->n = where->states, g->rows = rows;
    g->kind = below(FUNCTIONS);
    g->bad = (int)below(2 * MOST + 1) + 1;
    numbers(g->M, rows * g->n), numbers(g->c, rows);
}

static kq_sigma_points a_rule(void) { return byte() < 250 ? (kq_sigma_points)below(2) : (kq_sigma_points)2; }

/* After a call that was given g */
static void check_function(const function *g, kq_status status)
{
    DEMAND(g->calls == 0 || g->calls == 2 * g->n + 1);
    DEMAND(!g->is_spoiled || status == KQ_ERR_NOT_FINITE);
}

static void check_finite(const num *a, int count)
{
    for (int k = 0; k < count; k++) DEMAND(isfinite(a[k]));
}

/* What the cubature rule makes of points within -1 .. 1: a mean within, a spread of at most 1 */
static void check_bounded(const num *y, const num *E, int rows, int n)
{
    for (int c = 0; c < rows; c++) {
        double square = 0;
        for (int i = 0; i < n; i++) square += (double)E[c * n + i] * (double)E[c * n + i];
        DEMAND(fabs((double)y[c]) <= 1 + ROUNDING && square <= 1 + ROUNDING);
    }
}

/* y, J and E, of exactly so many numbers */
typedef struct {
    num *y, *J, *E;
} linearised;

static kq_status linearise(const K(filter) *where, int rows, linearised *to)
{
    const int n = where->states, count = rows * n;
    const kq_sigma_points rule = a_rule();
    function g;
    make_function(&g, where, rows);
    *to = (linearised){KEEP(num, rows), KEEP(num, count), KEEP(num, count)};
    const kq_status status = K(linearise)(where, call_function, &g, rows, rule, to->y, to->J, to->E);
    check_function(&g, status);
    if (status != KQ_OK) return status;
    check_finite(to->y, rows), check_finite(to->E, count);
    if ((g.kind == BOUNDED || g.kind == JUMPS) && rule == KQ_SIGMA_POINTS_CUBATURE) check_bounded(to->y, to->E, rows, n);
    return status;
}

#endif
