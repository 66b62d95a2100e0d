/* The steady-state filter: the mean alone, by gains that are known beforehand. */
#ifndef KQ_SRC_STEADY_KERNEL_H
#define KQ_SRC_STEADY_KERNEL_H

#include "../model/model.h"

typedef T(kq_steady) steady;

/* ------------------------------------------------------------------ the mean */

/* t <- A x + B u */
KQ_KERNEL unsigned steady_move(steady_word *t, const num *x, const process *p, const num *u, int n,
                               int l, int shape)
{
    const scaled *row = p->transition, *control = p->control;
    unsigned events = 0;
    KQ_UNROLL
    for (int i = 0; i < n; i++) {
        const int first = first_column(p, i, shape);
        if (u) {
            events |= steady_drive(t + i, n, row, first, x, control_drive(control, u, l));
            control += l;
        } else {
            events |= steady_row(t + i, n, row, first, x);
        }
        row += n;
    }
    return events;
}

/* e = z - H t.  Answers whether they are numbers. */
KQ_KERNEL int steady_residuals(steady_number *e, const steady_word *t, const sensor *s, const num *z,
                               int n, int m)
{
    const scaled *h = s->measurement;
    KQ_UNROLL
    for (int c = 0; c < m; c++) {
        e[c] = steady_residual(z[c], h, s->selects[c], t, n);
        h += n;
    }
    return innovations_are_finite(e, m);
}

/* x <- t + K e */
KQ_KERNEL unsigned steady_correct(num *x, const steady_word *t, const scaled *gain, const steady_number *e,
                                  int n, int m)
{
    unsigned events = 0;
    KQ_UNROLL
    for (int i = 0; i < n; i++) events |= steady_add(x, t[i], n, i, gain + i * m, e, m);
    return events;
}

/* The filter's gain after this update.  The steps of compile-time sizes wait for the last one. */
static void steady_next_gain(steady *st)
{
    if (st->left > 0) {
        st->left--;
        st->gain += st->states * st->components;
    }
    st->plain = (uint16_t)(st->left > 0 ? 0 : process_shape(st->process) | st->components << 8);
}

static inline int steady_has(const steady *st, int i)
{
    return st && st->gain && i >= 0 && i < st->states;
}

KQ_KERNEL void steady_note(steady *st, unsigned events)
{
    if (events) st->events = (uint8_t)(st->events | events);
}

/* Answers whether the innovations are numbers; if not, nothing has changed. */
KQ_KERNEL int steady_step_now(steady *st, const num *u, const num *z, int n, int m, int l,
                              int shape)
{
    steady_word t[KQ_SIZE_MAX];
    steady_number e[KQ_SIZE_MAX];
    const unsigned moved = steady_move(t, st->memory, st->process, u, n, l, shape);
    if (!KQ_MOSTLY(steady_residuals(e, t, st->sensor, z, n, m))) return 0;
    steady_note(st, moved | steady_correct(st->memory, t, st->gain, e, n, m));
    return 1;
}

#endif
