/* Steps with a process noise that is scaled. */
#ifndef KQ_SRC_ROBUST_STUDENT_STEP_H
#define KQ_SRC_ROBUST_STUDENT_STEP_H

#include <stdint.h>

#include "kalmanq/size.h"
#include "kalmanq/status.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/compiler.h"
#include "../arithmetic/coordinates.h"
#include "../arithmetic/root.h"
#include "../arithmetic/rows.h"
#include "../arithmetic/scaled.h"
#include "../model/advance.h"
#include "../model/process.h"
#include "../model/sensor.h"
#include "../model/types.h"
#include "../filter/checks.h"
#include "../filter/filter.h"
#include "../filter/likelihood.h"
#include "../filter/sharp.h"
#include "../filter/step.h"
#include "../filter/update.h"
#include "../smoother/smoother.h"
#include "../smoother/whitened.h"
#include "gate.h"
#include "parameters.h"
#include "robust.h"
#include "student_scale.h"

static kq_status process_scale_check(const process *target, const process *source, scaled q,
                                     num *root)
{
    if (!target) return KQ_ERR_NULL;
    kq_status status = process_check(source);
    if (!status) status = noise_weight_check(q);
    if (status) return status;
    if (target == source) return KQ_ERR_MISMATCH;
    return scaled_noise_check(target, source, root, scaled_root(q));
}

static kq_status process_scale_noise(process *target, const process *source, num *root, scaled q)
{
    const kq_status status = process_scale_check(target, source, q, root);
    if (status) return status;
    set_scaled_noise(target, source, root, scaled_root(q));
    return KQ_OK;
}

/* What a step is made of */
typedef struct {
    const process *process;
    const num *u;
    const sensor *sensor;
    const num *z;
    uint32_t present;
    scaled nu;
    process *target;
    num *root; /* q31: the target's noise */
} student_step;

/* Room for trials on the stack of who calls */
typedef struct {
    num *memory;     /* of a filter */
    num *reflectors; /* of a predict */
    scaled *along;   /* M, n x n: the noise's coordinates along those of the state, x = .. + S xi */
} student_room;

/* predict_now, of a copy that is not held: the step itself holds; and M, which are Theta's rows of the noise
   (smoother/whitened.h) */
static void student_predict(filter *f, const student_step *t, const student_room *room)
{
    num row[ROW_LEN(2 * KQ_SIZE_MAX)], *S = filter_root(f);
    const process *m = t->target;
    const int n = f->states;
    const workspace v = {.W = room->reflectors, .pq = room->reflectors + n * ROW_LEN(n)};
    predict_mean(f->memory, m, m->controls ? t->u : 0, v.W, n, SHAPE_AS_FOUND);
    predict_root(S, S, m, v.W, v.pq);
    renormalise(S, n);
    if (f->ready == FILTER_SHARP) filter_set_ready(f, FILTER_READY);
    for (int k = 0; k < n; k++) {
        theta_noise_row(row, m, &v, k);
        for (int j = 0; j < n; j++) {
            room->along[k * n + j] = scaled_normal(unit_entry(row[j]));
        }
    }
}

/* The rotations of an update (filter/rotate.h), for rows along the coordinates of the state */
typedef struct {
    scaled f[KQ_SIZE_MAX], c[KQ_SIZE_MAX], share[KQ_SIZE_MAX]; /* share: f_j / a_{j-1} */
} student_turns;

static void student_find_turns(student_turns *turns, const num *row, scaled r, int n)
{
    scaled variance = r;
    for (int j = 0; j < n; j++) {
        const scaled before = variance, f = row_entry(row, n, j);
        variance = scaled_plus(variance, scaled_times(f, f));
        turns->f[j] = f;
        turns->c[j] = scaled_root(scaled_over(before, variance));
        turns->share[j] = scaled_over(f, before);
    }
}

/* Turns a row of M, as they turn a row of S; answers what its product with f was. */
static scaled student_turn(scaled *row, const student_turns *turns, int n)
{
    scaled b = {0};
    for (int j = 0; j < n; j++) {
        const scaled old = row[j], part = scaled_times(turns->share[j], b);
        row[j] = scaled_times(turns->c[j], scaled_minus(old, part));
        b = scaled_plus(b, scaled_times(turns->f[j], old));
    }
    return b;
}

/* The update of a trial by a scalar measurement, as the plain one; the mean of the noise moves by
   M f e / s.  There, a measurement noise below 2^-40 s is one of 2^-40 s. */
static void student_try_scalar(filter *f, const reading *z, const robust_scalar *m,
                               const student_room *room, scale_trial *now)
{
    num row[ROW_LEN(KQ_SIZE_MAX)];
    student_turns turns;
    const int n = f->states;
    const int32_t before = f->last.count;
    project_scalar(row, f, m);
    const scaled s = scaled_plus(*m->noise, row_product(row, row, n)), least = scaled_shift(s, -40);
    const scaled r = scaled_is_less(*m->noise, least) ? least : *m->noise;
    if (!take_scalar(f, z, m->component, m->h, m->selected, *m->noise, m->e, n, MODE_GENERAL)) {
        take_with_care(f, z, m->component, m->h, m->e);
    }
    if (f->last.count == before) return;
    const scaled weight = scaled_over(m->e, s);
    student_find_turns(&turns, row, r, n);
    for (int k = 0; k < n; k++) {
        const scaled along = student_turn(room->along + k * n, &turns, n);
        now->noise[k] = scaled_plus(now->noise[k], scaled_times(along, weight));
    }
}

KQ_NOINLINE static void student_try_update(filter *f, const student_step *t,
                                           const student_room *room, scale_trial *now)
{
    scaled noise[KQ_TRIANGLE(KQ_SIZE_MAX)], buffer[KQ_SIZE_MAX];
    const reading z = {t->sensor, noise, t->z, t->present};
    robust_scalar one;
    noise_of_reading(noise, t->sensor, t->present);
    likelihood_clear(&f->last);
    for (int c = 0; c < t->sensor->components; c++) {
        if (!(t->present >> c & 1)) continue;
        robust_scalar_of(&one, f, &z, noise, c, buffer);
        student_try_scalar(f, &z, &one, room, now);
    }
}

/* The step with scale k on a copy of the filter */
static void student_trial(const filter *f, const student_step *t, int k, const student_room *room,
                          scale_trial *now)
{
    filter trial = *f;
    trial.memory = room->memory;
    filter_set_attached(&trial, 0);
    copy(room->memory, f->memory, FILTER_LEN(f->states));
    for (int j = 0; j < f->states; j++) now->noise[j] = (scaled){0};
    set_scaled_noise(t->target, t->process, t->root, scaled_root(scaled_of_count(scale_at(k))));
    student_predict(&trial, t, room);
    student_try_update(&trial, t, room, now);
    now->given = trial.last;
}

/* The scale q of a step.  `given`: what the model as given says of the measurement.  Where not
   every scale takes as much of it, their likelihoods cannot be compared. */
static scaled student_scale(const filter *f, const student_step *t, const student_room *room,
                            likelihood *given, int *jump)
{
    scaled gains[SCALES_MOST] = {0};
    scale_trial trials[2];
    int k = 0;
    *jump = 0;
    for (int going_on = 1; going_on && k < SCALES_MOST; k++) {
        scale_trial *now = trials + k % 2;
        student_trial(f, t, k, room, now);
        if (k == 0) *given = now->given;
        if (now->given.count == 0 || now->given.count != given->count) return scaled_one;
        if (k) gains[k] = scale_gain(trials + (k + 1) % 2, now, t->nu, k, f->states);
        going_on = k + 1 < SCALES_LEAST || is_positive(gains[k]);
    }
    gains_to_deficits(gains, k);
    const scaled root = mean_scale(gains, k, jump);
    return scaled_times(root, root);
}

/* What is told of the step is that of Q as given; a NIS beyond the numbers is not summed. */
static void student_tell(filter *f, const likelihood *given, const likelihood_run *run)
{
    f->run = *run;
    f->last = *given;
    if (scaled_is_finite(scaled_of_score(likelihood_nis(given))))
        likelihood_run_add(&f->run, given);
    else f->events |= KQ_EVENT_OVERFLOW;
}

static scaled student_with(filter *f, const student_step *t, const student_room *room)
{
    likelihood given;
    int jump;
    const scaled q = student_scale(f, t, room, &given, &jump);
    const likelihood_run run = f->run;
    set_scaled_noise(t->target, t->process, t->root, scaled_root(q));
    predict_recorded(f, t->target, t->u);
    update_reading(f, &(reading){t->sensor, t->sensor->noise, t->z, t->present});
    student_tell(f, &given, &run);
    if (jump) f->events |= KQ_EVENT_JUMP;
    return q;
}

KQ_NOINLINE static scaled student_to_4(filter *f, const student_step *t)
{
    num memory[FILTER_LEN(4)], reflectors[PREDICT_SCRATCH(4)];
    scaled along[4 * 4];
    return student_with(f, t, &(student_room){memory, reflectors, along});
}

KQ_NOINLINE static scaled student_to_9(filter *f, const student_step *t)
{
    num memory[FILTER_LEN(9)], reflectors[PREDICT_SCRATCH(9)];
    scaled along[9 * 9];
    return student_with(f, t, &(student_room){memory, reflectors, along});
}

KQ_NOINLINE static scaled student_to_16(filter *f, const student_step *t)
{
    num memory[FILTER_LEN(16)], reflectors[PREDICT_SCRATCH(16)];
    scaled along[16 * 16];
    return student_with(f, t, &(student_room){memory, reflectors, along});
}

static kq_status filter_step_student(filter *f, const student_step *t, scaled *q)
{
    kq_status status = predict_check(f, t->process, t->u);
    if (!status) status = update_check(f, t->sensor, t->z, t->present);
    if (!status) status = parameter_check(t->nu);
    if (status) return status;
    const scaled most = scaled_of_count(scale_at(SCALES_MOST - 1));
    status = process_scale_check(t->target, t->process, scaled_one, t->root);
    if (!status) status = process_scale_check(t->target, t->process, most, t->root);
    if (status) return status;
    scaled scale;
    if (f->states <= 4) scale = student_to_4(f, t);
    else if (f->states <= 9) scale = student_to_9(f, t);
    else scale = student_to_16(f, t);
    if (q) *q = scale;
    return KQ_OK;
}

#endif
