/*
 * Sensors that take innovations.  An update takes an innovation where it takes a measurement if the mean is 0.  So the
 * mean is set aside, the update of a measurement finds where it moves, and that is added to what was set aside.
 */
#ifndef KQ_SRC_LINEARISED_INNOVATION_H
#define KQ_SRC_LINEARISED_INNOVATION_H

#include "linearised.h"

typedef struct {
    num words[MEAN_PLANES * KQ_SIZE_MAX];
} aside;

KQ_NOINLINE static void mean_set_aside(filter *f, aside *mean)
{
    num *x = f->memory;
    for (int k = 0; k < MEAN_PLANES * f->states; k++) {
        mean->words[k] = x[k];
        x[k] = 0;
    }
}

/* checked_update by the loss, or by what the sensor's kind is made of */
static kq_status around_innovations(filter *f, const sensor *s, const num *e, uint32_t present, checked_update *update,
                                    struct T(kq_loss) *loss)
{
    aside mean;
    const kq_status status = free_mean_check(f);
    if (status) return status;
    mean_set_aside(f, &mean);
    update(f, s, e, present, loss);
    move_by(f, mean.words, mean.words + f->states);
    return KQ_OK;
}

static void update_by_base(filter *f, const sensor *s, const num *e, uint32_t present, struct T(kq_loss) *loss)
{
    (void)loss;
    (void)base_kind(s)->take(f, s, e, present); /* KQ_OK: what may be refused was asked above */
}

static kq_status take_innovations(filter *f, const sensor *s, const num *e, uint32_t present)
{
    return around_innovations(f, s, e, present, update_by_base, 0);
}

static const innovation_kind independent_extended = {
    .kind = {.take = take_innovations, .takes_innovations = 1},
    .base = &T(kq_sensor_independent), .around = around_innovations};

static const innovation_kind lean_extended = {
    .kind = {.take = take_innovations, .takes_innovations = 1},
    .base = &T(kq_sensor_lean), .around = around_innovations};

const innovation_kind T(kq_sensor_correlated_extended) = {
    .kind = {.take = take_innovations, .takes_innovations = 1, .row = correlated_row,
             .row_sizes = correlated_row_sizes, .innovation = correlated_innovation},
    .base = &T(kq_sensor_correlated), .around = around_innovations};

/* The sensor that an init has prepared, where it has */
static kq_status sensor_extend(sensor *s, const innovation_kind *kind, kq_status status)
{
    if (status) return status;
    s->kind = &kind->kind;
    s->plain = 0;
    return KQ_OK;
}

#endif
