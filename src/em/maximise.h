/* EM: new parameters of the sums, and the likelihood's gradient. */
#ifndef KQ_SRC_EM_MAXIMISE_H
#define KQ_SRC_EM_MAXIMISE_H

#include "model.h"

/* One of the three regressions: of the process noise on the state, of the measurement noise on the
   state, of the start on 1.  Coefficients are A, H and x0, covariances Q, R and P0. */
typedef struct {
    sums sum;
    const num *root; /* of the noises' covariance, in whose units they are */
    int size;        /* of the covariance that is estimated, r with F */
    unsigned free_covariance;
    num *coefficients, *covariance; /* the caller's */
    num *new_coefficients, *new_covariance;
    const uint8_t *held;
    kq_em_form form;
} em_part;

static em_part em_process_part(const estimation *e, const em_places *w)
{
    const parameters *p = e->model;
    return (em_part){.root = e->process.noise_root,
                     .size = em_noises(e),
                     .free_covariance = KQ_EM_Q,
                     .coefficients = p->A,
                     .covariance = p->Q,
                     .new_coefficients = w->A,
                     .new_covariance = w->Q,
                     .held = held_of(em_choice(e)->A_held, e->states * e->states),
                     .form = em_choice(e)->Q_form};
}

static em_part em_sensor_part(const estimation *e, const em_places *w)
{
    const parameters *p = e->model;
    return (em_part){.root = w->of_R,
                     .size = e->components,
                     .free_covariance = KQ_EM_R,
                     .coefficients = p->H,
                     .covariance = p->R,
                     .new_coefficients = w->H,
                     .new_covariance = w->R,
                     .held = held_of(em_choice(e)->H_held, e->components * e->states),
                     .form = em_choice(e)->R_form};
}

static em_part em_start_part(const estimation *e, const em_places *w)
{
    const parameters *p = e->model;
    return (em_part){.root = w->of_P0,
                     .size = e->states,
                     .free_covariance = KQ_EM_P0,
                     .coefficients = p->x0,
                     .covariance = p->P0,
                     .new_coefficients = w->x0,
                     .new_covariance = w->P0,
                     .form = KQ_EM_FULL};
}

/* Steps of a recording that have a measurement */
static num measured_steps(const estimation *e, const recording *r)
{
    int32_t measured = 0;
    for (size_t t = 0; t < r->steps; t++) measured += present_at(e, r, t) != 0;
    return (num)measured;
}

static em_part em_part_of(const estimation *e, const em_places *w, int which)
{
    em_part part = which == EM_PROCESS  ? em_process_part(e, w)
                   : which == EM_SENSOR ? em_sensor_part(e, w)
                                        : em_start_part(e, w);
    sums *s = &part.sum;
    s->noises = which == EM_SENSOR ? e->components : e->states;
    s->regressors = em_regressors(e, which);
    s->root = w->sums[which];
    for (size_t k = 0; k < e->count; k++) {
        const recording *r = e->recordings + k;
        s->count += which == EM_START    ? 1
                    : which == EM_SENSOR ? measured_steps(e, r)
                                         : (num)(r->steps - 1);
    }
    return part;
}

/* The noises E (n rows of `width`) in the units of the covariance's own coordinates: F^+ G E,
   behind E, with F; otherwise L E, in place */
static num *em_own_noises(const estimation *e, const em_places *w, const em_part *part, num *E,
                          int width)
{
    const int k = part->sum.noises;
    if (part->root != e->process.noise_root || !e->model->F) {
        root_times_rows(part->root, E, k, width);
        return E;
    }
    num *own = E + k * width;
    for (int i = 0; i < part->size; i++) {
        for (int c = 0; c < width; c++) {
            num total = 0;
            for (int j = 0; j < k; j++) total += w->map[i * k + j] * E[j * width + c];
            own[i * width + c] = total;
        }
    }
    return own;
}

static void em_note_change(estimation *e, num change)
{
    if (!(e->change >= change)) e->change = change;
}

/* The largest change of an entry, in sigma_i sigma_j as they were */
static void em_note_covariance(estimation *e, const em_part *part)
{
    const num *now = part->new_covariance, *old = part->covariance;
    const int n = part->size;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            const num scale = num_root(old[i * n + i]) * num_root(old[j * n + j]);
            const num change = num_magnitude(now[i * n + j] - old[i * n + j]);
            if (scale > 0) em_note_change(e, change / scale);
        }
    }
}

static num square_of_rows(const num *E, int rows, int stride, int width)
{
    num total = 0;
    for (int i = 0; i < rows; i++) total += dot(0, E + i * stride, E + i * stride, width);
    return total;
}

/* New coefficients; E <- [U11 Y] */
static void em_explain(estimation *e, const em_part *part, num *E)
{
    const sums *s = &part->sum;
    const int k = s->noises, p = s->regressors, width = k + p;
    const num before = square_of_rows(E + k, k, width, p);
    copy(part->new_coefficients, part->coefficients, k * p);
    explain(part->new_coefficients, E, s, part->root, part->held);
    const num moved = before - square_of_rows(E + k, k, width, p);
    em_note_change(e, num_root(moved > 0 ? moved / (s->count * (num)k) : 0));
}

/* A new covariance of what is not explained */
static void em_spread(estimation *e, const em_places *w, const em_part *part, num *E)
{
    const int n = part->size, width = part->sum.noises + part->sum.regressors;
    num *now = part->new_covariance;
    if (part->form == KQ_EM_MULTIPLE) {
        const num multiple = noise_multiple(E, &part->sum, part->root);
        for (int k = 0; k < n * n; k++) now[k] = multiple * part->covariance[k];
    } else {
        covariance_of(now, em_own_noises(e, w, part, E, width), n, width, part->sum.count);
    }
    if (part->form == KQ_EM_DIAGONAL) keep_diagonal(now, n);
    em_note_covariance(e, part);
}

/* New parameters of one part, not yet the caller's; refused where they are not representable */
KQ_NOINLINE static kq_status em_maximise_part(estimation *e, const em_places *w, int which)
{
    const em_part part = em_part_of(e, w, which);
    const int n = part.size, entries = part.sum.noises * part.sum.regressors;
    num *E = w->work.rows;
    if (part.sum.count == 0) { /* one step only: nothing is known of the process */
        copy(part.new_coefficients, part.coefficients, entries);
        copy(part.new_covariance, part.covariance, n * n);
        return KQ_OK;
    }
    root_rows(E, part.sum.root, part.sum.noises, part.sum.noises + part.sum.regressors);
    if (entries) em_explain(e, &part, E);
    if (em_is_free(e, part.free_covariance)) em_spread(e, w, &part, E);
    if (entries && !all_finite(part.new_coefficients, entries)) return KQ_ERR_LIKELIHOOD;
    if (!em_is_free(e, part.free_covariance)) return KQ_OK;
    return all_finite(part.new_covariance, n * n) ? KQ_OK : KQ_ERR_LIKELIHOOD;
}

static int live_count(const num *L, int n)
{
    int live = 0;
    for (int i = 0; i < n; i++) live += is_live(L, i);
    return live;
}

/* Is what has been made a covariance, to rounding?  R has to be as regular as it was: a direction
   in which it leaves rounding alone would be taken for free of noise. */
KQ_NOINLINE static kq_status em_check_spread(const estimation *e, const em_places *w, int which)
{
    const em_part part = em_part_of(e, w, which);
    const int n = part.size;
    num *root = w->work.spare;
    if (!em_is_free(e, part.free_covariance)) return KQ_OK;
    kq_status status = covariance_check(part.new_covariance, n);
    if (!status) status = root_of(root, part.new_covariance, n);
    if (status) return KQ_ERR_LIKELIHOOD;
    if (which != EM_SENSOR) return KQ_OK;
    return live_count(root, n) < live_count(part.root, n) ? KQ_ERR_LIKELIHOOD : KQ_OK;
}

/* ------------------------------------------------------------------ gradient */

static void em_covariance_gradient(const estimation *e, const em_places *w, const em_part *part,
                                   num *out)
{
    const int width = part->sum.noises + part->sum.regressors;
    const int is_of_factor = e->model->F && part->root == e->process.noise_root;
    const num *L = is_of_factor ? w->of_Q : part->root;
    num *E = w->work.rows;
    root_rows(E, part->sum.root, part->sum.noises, width);
    if (is_of_factor) {
        E = em_own_noises(e, w, part, E, width);
        rows_over_root(L, E, part->size, width);
    }
    covariance_gradient(out, E, L, part->size, width, part->sum.count);
}

static void em_part_gradient(const estimation *e, const em_places *w, int which,
                             num *of_coefficients, num *of_covariance)
{
    const em_part part = em_part_of(e, w, which);
    if (of_coefficients) coefficient_gradient(of_coefficients, &part.sum, part.root);
    if (of_covariance) em_covariance_gradient(e, w, &part, of_covariance);
}

#endif
