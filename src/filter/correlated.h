/* The update by components of correlated noise: what a sensor of them refers to. */
#ifndef KQ_SRC_FILTER_CORRELATED_H
#define KQ_SRC_FILTER_CORRELATED_H

#include "low_noise.h"
#include "update.h"

KQ_COLD KQ_NOINLINE static void take_correlated(filter *f, const reading *z)
{
    scaled buffer[KQ_SIZE_MAX];
    const int n = f->states;
    for (int c = 0; c < z->sensor->components; c++) {
        if (!(z->present >> c & 1)) continue;
        const scaled *h = scalar_row(z, c, buffer), e = scalar_innovation(f, z, c);
        if (take_scalar(f, z, c, h, 0, scalar_noise(z, c), e, n, MODE_GENERAL)) continue;
        take_with_care(f, z, c, h, e);
    }
}

/* With components missing the others' noise is made anew. */
KQ_COLD KQ_NOINLINE static void take_present(filter *f, const reading *z)
{
    scaled noise[KQ_TRIANGLE(KQ_SIZE_MAX)];
    noise_of_present(noise, z->sensor, z->present);
    const reading some = {z->sensor, noise, z->z, z->present};
    take_correlated(f, &some);
}

static void update_correlated(filter *f, const reading *z)
{
    likelihood_clear(&f->last);
    if (noise_is_of_others(z->sensor, z->present)) take_present(f, z);
    else take_correlated(f, z);
    update_end(f);
}

static kq_status take_correlated_reading(filter *f, const sensor *s, const num *z, uint32_t present)
{
    const reading now = {s, s->noise, z, present};
    update_correlated(f, &now);
    return KQ_OK;
}

#endif
