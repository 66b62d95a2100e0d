/* The update by components of independent noise: what a sensor of them refers to. */
#ifndef KQ_SRC_FILTER_INDEPENDENT_H
#define KQ_SRC_FILTER_INDEPENDENT_H

#include "low_noise.h"
#include "update.h"

/* The components present from c on, as long as there is nothing unusual about them.  Answers the first
   one that has not been taken. */
KQ_NOINLINE static int take_ordinary(filter *f, const reading *z, int c)
{
    const int n = z->sensor->states, m = z->sensor->components;
    for (; c < m; c++) {
        if (z->present >> c & 1 && !take_component(f, z, c, n, MODE_GENERAL)) return c;
    }
    return m;
}

/* A look after a step of compile-time sizes, which has none on its way */
KQ_COLD KQ_NOINLINE static void watch_independent(filter *f, const sensor *s)
{
    const int c = watched_column(f->run.count, s->components);
    watch_row(f, s->measurement + c * s->states, s->noise[c], WATCH_PERIOD_FIXED);
}

static void update_independent(filter *f, const reading *z)
{
    const scaled *H = z->sensor->measurement;
    const int n = z->sensor->states, m = z->sensor->components;
    likelihood_clear(&f->last);
    for (int c = 0; (c = take_ordinary(f, z, c)) < m; c++) {
        take_with_care(f, z, c, H + c * n, component_innovation(f, z, c));
    }
    update_end(f);
}

static kq_status take_independent(filter *f, const sensor *s, const num *z, uint32_t present)
{
    const reading now = {s, s->noise, z, present};
    update_independent(f, &now);
    return KQ_OK;
}

#endif
