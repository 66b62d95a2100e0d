/*
 * Updates of a nonlinear model.  An update takes an innovation where it takes a measurement if the mean is 0.  So the
 * mean is set aside, the plain update finds where it moves, and that is added to what was set aside.
 */
#ifndef KQ_SRC_LINEARISED_INNOVATION_H
#define KQ_SRC_LINEARISED_INNOVATION_H

#include <stdint.h>

#include "kalmanq/extended.h"
#include "kalmanq/filter.h"
#include "kalmanq/robust.h"
#include "kalmanq/size.h"
#include "kalmanq/status.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/compiler.h"
#include "../arithmetic/mean.h"
#include "../arithmetic/root.h"
#include "../arithmetic/scaled.h"
#include "../model/types.h"
#include "../filter/filter.h"
#include "../filter/prior.h"
#include "jacobian.h"
#include "mean.h"

typedef struct {
    num words[MEAN_PLANES * KQ_SIZE_MAX];
} aside;

KQ_NOINLINE static kq_status mean_take(filter *f, aside *mean)
{
    const kq_status status = free_mean_check(f);
    if (status) return status;
    num *x = f->memory;
    for (int k = 0; k < MEAN_PLANES * f->states; k++) {
        mean->words[k] = x[k];
        x[k] = 0;
    }
    return KQ_OK;
}

/* The mean is what it was, and moves as the update has moved 0; not at all where that was refused. */
KQ_NOINLINE static kq_status mean_give_back(filter *f, const aside *mean, kq_status status)
{
    const int n = f->states;
    if (status < KQ_OK) {
        copy(f->memory, mean->words, MEAN_PLANES * n);
        return status;
    }
    move_by(f, mean->words, mean->words + n);
    return status;
}

kq_status T(kq_update_extended)(filter *f, const sensor *s, const num *e)
{
    aside mean;
    const kq_status status = mean_take(f, &mean);
    return status ? status : mean_give_back(f, &mean, T(kq_update)(f, s, e));
}

kq_status T(kq_update_subset_extended)(filter *f, const sensor *s, const num *e, uint32_t present)
{
    aside mean;
    const kq_status status = mean_take(f, &mean);
    return status ? status : mean_give_back(f, &mean, T(kq_update_subset)(f, s, e, present));
}

kq_status T(kq_update_gated_extended)(filter *f, T(kq_gate) *g, const sensor *s, const num *e, uint32_t present)
{
    aside mean;
    const kq_status status = mean_take(f, &mean);
    return status ? status : mean_give_back(f, &mean, T(kq_update_gated)(f, g, s, e, present));
}

kq_status T(kq_update_huber_extended)(filter *f, const sensor *s, const num *e, uint32_t present, scaled k,
                                      scaled *weights)
{
    aside mean;
    const kq_status status = mean_take(f, &mean);
    return status ? status : mean_give_back(f, &mean, T(kq_update_huber)(f, s, e, present, k, weights));
}

kq_status T(kq_update_student_extended)(filter *f, const sensor *s, const num *e, uint32_t present, scaled nu,
                                        scaled *weights)
{
    aside mean;
    const kq_status status = mean_take(f, &mean);
    return status ? status : mean_give_back(f, &mean, T(kq_update_student)(f, s, e, present, nu, weights));
}

kq_status T(kq_update_jump_extended)(filter *f, const sensor *s, const num *e, uint32_t present, scaled g)
{
    aside mean;
    const kq_status status = mean_take(f, &mean);
    return status ? status : mean_give_back(f, &mean, T(kq_update_jump)(f, s, e, present, g));
}

#endif
