/*
 * Updates that an outlier does not move far, or that follow a jump of the state.
 *
 * Each chooses a number (the noise r of a scalar measurement, a factor of the root of P) from what
 * is known before the update, and then takes the ordinary step with it: the history records that
 * step, and the root is as sound as ever.  NIS and likelihood are those of the model as given.
 */
#ifndef KQ_SRC_ROBUST_ROBUST_H
#define KQ_SRC_ROBUST_ROBUST_H

#include <stdint.h>

#include "kalmanq/robust.h"
#include "kalmanq/size.h"
#include "kalmanq/status.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/compiler.h"
#include "../arithmetic/mean.h"
#include "../arithmetic/root.h"
#include "../arithmetic/rotor.h"
#include "../arithmetic/rows.h"
#include "../arithmetic/scaled.h"
#include "../arithmetic/triangle.h"
#include "../model/definitions.h"
#include "../model/sensor.h"
#include "../model/types.h"
#include "../model/units.h"
#include "../filter/attached.h"
#include "../filter/checks.h"
#include "../filter/filter.h"
#include "../filter/likelihood.h"
#include "../filter/sharp.h"
#include "../filter/update.h"
#include "../smoother/tape.h"
#include "parameters.h"

enum { ROBUST_HUBER, ROBUST_STUDENT, ROBUST_JUMP };

/* How an update is to be robust */
typedef struct {
    int kind;
    scaled parameter; /* k, nu or g */
    scaled *weights;  /* m, or NULL */
} robustness;

/* The noise with which e moves the mean as far as +-k sigma would with r: s / w - f'f,
   w = k sqrt(s) / |e|.  Nothing cancels. */
static scaled huber_noise(scaled r, scaled s, scaled e, scaled k)
{
    const scaled sigma = scaled_root(s), most = scaled_times(k, sigma);
    const scaled size = scaled_magnitude(e);
    if (!scaled_is_less(most, size)) return r;
    return scaled_plus(r, scaled_times(sigma, scaled_over(scaled_minus(size, most), k)));
}

/*
 * r over the expected weight of a Student-t noise of nu degrees of freedom, (nu + 1) / (nu +
 * E[v^2] / r), given e = v + f'(...): three steps of its fixed point, which settles by a factor of
 * nu + 1 a step.
 */
static scaled student_noise(scaled r, scaled square, scaled e, scaled nu)
{
    const scaled freedom = scaled_plus(nu, scaled_one);
    scaled heavy = r;
    for (int k = 0; k < 3; k++) {
        const scaled s = scaled_plus(heavy, square);
        if (scaled_is_zero(s)) return r;
        const scaled share = scaled_over(heavy, s), v = scaled_times(e, share);
        const scaled expected = scaled_plus(scaled_times(v, v), scaled_times(square, share));
        heavy = scaled_plus(r, scaled_over(scaled_minus(expected, r), freedom));
    }
    return heavy;
}

/* The factor of S that leaves no variance, `square` being one, above num_most_variance; or 1 */
static scaled largest_raise(const num *S, scaled square, int n)
{
    scaled largest = square;
    for (int i = 0; i < n; i++) {
        const scaled variance = root_product(S, n, i, i);
        if (scaled_is_less(largest, variance)) largest = variance;
    }
    if (!scaled_is_less(largest, num_most_variance)) return scaled_one;
    return scaled_over(scaled_root(num_most_variance), scaled_root(largest));
}

/* One scalar measurement as the arithmetic sees it before it is taken */
typedef struct {
    const scaled *h;
    int component, selected;
    scaled e;
    scaled *noise; /* its entry in the reading's noise */
} robust_scalar;

/* A scalar measurement as the careful update has it (filter/sharp.h), s the variance of its innovation */
static careful_scalar careful_of(const filter *f, const reading *z, const robust_scalar *m, scaled s,
                                 scaled *spare)
{
    const scaled least = project_with_floor(f, z, m->component, m->h, spare);
    return (careful_scalar){.z = z, .component = m->component, .h = m->h, .r = *m->noise, .e = m->e,
                            .floor = least, .s = s};
}

/* Would the plain update take it?  If not, the events are those of the plain update: a larger noise
   or a larger P would only hide why. */
KQ_NOINLINE static int plain_update_takes(filter *f, const reading *z, const robust_scalar *m, scaled s)
{
    scaled spare[FLOOR_PARTS * KQ_SIZE_MAX];
    const careful_scalar plain = careful_of(f, z, m, s, spare);
    return innovation_counts(f, &plain, spare);
}

/* Is there more of h'P h than rounding?  Then there is when P is raised, too: both grow alike, but
   for their last bits, which half of it allows for. */
KQ_NOINLINE static int may_be_raised(const filter *f, const reading *z, const robust_scalar *m,
                                     scaled square)
{
    scaled spare[FLOOR_PARTS * KQ_SIZE_MAX];
    const careful_scalar half = careful_of(f, z, m, scaled_shift(square, -1), spare);
    return !is_at_floor(f, &half, spare);
}

/* S is scaled so that s = r + `square` becomes e^2, or as far as that goes. */
static void raise_root(filter *f, scaled r, scaled square, scaled nis)
{
    const scaled s = scaled_plus(r, square);
    const scaled wanted = scaled_minus(scaled_times(nis, s), r);
    const scaled most = largest_raise(filter_root(f), square, f->states);
    scaled c = scaled_root(scaled_over(wanted, square));
    if (!scaled_is_less(c, most)) {
        f->events |= KQ_EVENT_OVERFLOW;
        c = most;
    }
    if (!scaled_is_less(scaled_one, c)) return;
    root_scale(filter_root(f), c, f->states);
    renormalise(filter_root(f), f->states);
    f->events |= KQ_EVENT_JUMP;
}

static void project_scalar(num *row, const filter *f, const robust_scalar *m)
{
    const num *S = filter_root(f);
    const int k = m->selected - 1;
    if (m->selected) project_selected(row, S, m->h[k], k, f->states);
    else project(row, S, m->h, f->states);
}

/* Answers whether it may be taken, noise or root made ready for it; its weight, 1 where it is taken
   as it is, and the innovation variance as given. */
static int robust_prepare(filter *f, const reading *z, const robust_scalar *m, const robustness *how,
                          scaled *weight, scaled *s)
{
    num row[ROW_LEN(KQ_SIZE_MAX)];
    const scaled r = *m->noise;
    project_scalar(row, f, m);
    const scaled square = row_product(row, row, f->states);
    *weight = scaled_one;
    *s = scaled_plus(r, square);
    const int is_plain = f->ready == FILTER_READY && is_ordinary(r, *s, m->e);
    if (!is_plain && !plain_update_takes(f, z, m, *s)) return 0;
    if (how->kind == ROBUST_JUMP) {
        const scaled nis = scaled_times(m->e, scaled_over(m->e, *s));
        if (scaled_is_less(how->parameter, nis) && may_be_raised(f, z, m, square)) {
            raise_root(f, r, square, nis);
        }
        return 1;
    }
    *m->noise = how->kind == ROBUST_HUBER ? huber_noise(r, *s, m->e, how->parameter)
                                          : student_noise(r, square, m->e, how->parameter);
    if (!scaled_is_zero(*m->noise)) *weight = scaled_over(r, *m->noise);
    if (!likelihood_overflows(m->e, scaled_plus(*m->noise, *s))) return 1;
    f->events |= KQ_EVENT_OVERFLOW;
    return 0;
}

/* What is told of one that was taken: that of noise r and variance s, as given.  What contradicts
   (filter/sharp.h) is no less one for being clipped. */
static void robust_tell(filter *f, const reading *z, const robust_scalar *m, scaled r, scaled s)
{
    const scaled nis = scaled_times(m->e, scaled_over(m->e, s));
    likelihood_add(&f->last, nis, physical_variance(z->sensor, m->component, s));
    if (scaled_is_less(num_tiny, r) || !scaled_is_less(num_most_sure, nis)) return;
    f->events |= KQ_EVENT_CONTRADICTION;
}

/* Takes it with a noise or a P of its own, and answers its weight. */
KQ_NOINLINE static scaled take_robust(filter *f, const reading *z, const robust_scalar *m,
                                      const robustness *how)
{
    static const scaled zero;
    scaled weight, s;
    const scaled r = *m->noise;
    if (!robust_prepare(f, z, m, how, &weight, &s)) {
        if (f->attached) f->attached->hooks->record_nothing(f);
        return zero;
    }
    const likelihood before = f->last;
    const unsigned others = f->events | ~(unsigned)KQ_EVENT_CONTRADICTION;
    if (!take_scalar(f, z, m->component, m->h, m->selected, *m->noise, m->e, f->states,
                     MODE_GENERAL)) {
        take_with_care(f, z, m->component, m->h, m->e);
    }
    /* an outlier may say as little as it likes */
    if (scaled_is_less(weight, scaled_one)) f->events = (uint16_t)(f->events & others);
    if (f->last.count == before.count) return zero;
    f->last = before;
    robust_tell(f, z, m, r, s);
    return weight;
}

static void robust_scalar_of(robust_scalar *m, const filter *f, const reading *z, scaled *noise, int c,
                             scaled *buffer)
{
    const int n = f->states, correlated = sensor_is_correlated(z->sensor);
    m->component = c;
    m->selected = correlated ? 0 : z->sensor->selects[c];
    m->noise = noise + (correlated ? column(c) + c : c);
    m->h = scalar_row(z, c, buffer);
    const int from = m->selected ? m->selected - 1 : 0, to = m->selected ? m->selected : n;
    m->e = correlated || filter_is_wide(f)
               ? scalar_innovation(f, z, c)
               : mean_residual(z->z[c], m->h, f->memory, n, from, to);
}

/* A copy of the sensor's noise, made anew where components are missing */
static void noise_of_reading(scaled *noise, const sensor *s, uint32_t present)
{
    const int m = s->components, length = sensor_is_correlated(s) ? KQ_TRIANGLE(m) : m;
    const int remade = noise_is_of_others(s, present);
    if (remade) noise_of_present(noise, s, present);
    for (int k = 0; !remade && k < length; k++) noise[k] = s->noise[k];
}

KQ_NOINLINE static void update_robust(filter *f, const sensor *s, const num *z, uint32_t present,
                                      const robustness *how)
{
    static const scaled zero;
    scaled noise[KQ_TRIANGLE(KQ_SIZE_MAX)], buffer[KQ_SIZE_MAX];
    const reading now = {s, noise, z, present};
    robust_scalar one;
    noise_of_reading(noise, s, present);
    likelihood_clear(&f->last);
    for (int c = 0; c < s->components; c++) {
        scaled weight = zero;
        if (present >> c & 1) {
            robust_scalar_of(&one, f, &now, noise, c, buffer);
            weight = take_robust(f, &now, &one, how);
        }
        if (how->weights) how->weights[c] = weight;
    }
    if (update_end(f) && s->kind->watch) s->kind->watch(f, &now);
}

/* nu / (nu + 1) of r is left in r' or more, which has to be more than rounding. */
static kq_status robustness_check(const robustness *how)
{
    const scaled least_freedom = scaled_shift(scaled_one, -20);
    const kq_status status = parameter_check(how->parameter);
    if (status || how->kind != ROBUST_STUDENT) return status;
    return scaled_is_less(how->parameter, least_freedom) ? KQ_ERR_RANGE : KQ_OK;
}

static kq_status filter_update_robust(filter *f, const sensor *s, const num *z, uint32_t present,
                                      robustness how)
{
    kq_status status = update_check(f, s, z, present);
    if (!status) status = robustness_check(&how);
    if (status) return status;
    update_robust(f, s, z, present, &how);
    return KQ_OK;
}

kq_status T(kq_update_huber)(filter *f, const sensor *s, const num *z, uint32_t present, scaled k,
                             scaled *weights)
{
    return filter_update_robust(f, s, z, present, (robustness){ROBUST_HUBER, k, weights});
}

kq_status T(kq_update_student)(filter *f, const sensor *s, const num *z, uint32_t present,
                               scaled nu, scaled *weights)
{
    return filter_update_robust(f, s, z, present, (robustness){ROBUST_STUDENT, nu, weights});
}

static int is_recording(const filter *f) { return is_recorded(f) && history_of(f)->filter == f; }

/* A raised P is no step that the history could undo. */
kq_status T(kq_update_jump)(filter *f, const sensor *s, const num *z, uint32_t present, scaled g)
{
    kq_status status = update_check(f, s, z, present);
    if (!status) status = parameter_check(g);
    if (status) return status;
    if (scaled_is_less(g, scaled_one)) return KQ_ERR_RANGE;
    if (is_recording(f)) return KQ_ERR_RECORDING;
    update_robust(f, s, z, present, &(robustness){ROBUST_JUMP, g, 0});
    return KQ_OK;
}

#endif
