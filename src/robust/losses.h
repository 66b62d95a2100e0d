/*
 * The losses: one function and one row each.  A loss of a noise answers the r to take a scalar measurement with.  The
 * gate, which takes or rejects a measurement as a whole, is in gate.h.
 */
#ifndef KQ_SRC_ROBUST_LOSSES_H
#define KQ_SRC_ROBUST_LOSSES_H

#include "update.h"

static kq_status loss_check(const filter *f, const loss *how)
{
    (void)f;
    return parameter_check(how->parameter);
}

/* ------------------------------------------------------------------ outliers */

/* The noise with which e moves the mean as far as +-k sigma would with r: s / w - f'f,
   w = k sqrt(s) / |e|.  Nothing cancels. */
static scaled huber_noise(scaled r, scaled square, scaled e, scaled k)
{
    const scaled sigma = scaled_root(scaled_plus(r, square)), most = scaled_times(k, sigma);
    const scaled size = scaled_magnitude(e);
    if (!scaled_is_less(most, size)) return r;
    return scaled_plus(r, scaled_times(sigma, scaled_over(scaled_minus(size, most), k)));
}

const loss_kind T(kq_loss_huber) = {.check = loss_check, .update = update_robust, .noise = huber_noise};

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

/* nu / (nu + 1) of r is left in r' or more, which has to be more than rounding. */
static kq_status student_check(const filter *f, const loss *how)
{
    const kq_status status = loss_check(f, how);
    if (status) return status;
    return scaled_is_less(how->parameter, scaled_shift(scaled_one, -20)) ? KQ_ERR_RANGE : KQ_OK;
}

const loss_kind T(kq_loss_student) = {.check = student_check, .update = update_robust, .noise = student_noise};

/* ------------------------------------------------------------------ jumps */

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

/* Is there more of h'P h than rounding?  Then there is when P is raised, too: both grow alike, but
   for their last bits, which half of it allows for. */
KQ_NOINLINE static int may_be_raised(const filter *f, const reading *z, const robust_scalar *m,
                                     scaled square)
{
    scaled spare[FLOOR_PARTS * KQ_SIZE_MAX];
    const low_noise_scalar half = low_noise_of(f, z, m, scaled_shift(square, -1), spare);
    return !is_redundant(f, &half, spare);
}

/* Where the raised h'P h / r is above 2^-10 of num_most_condition, the next predict may round off what the measurement
   says. */
enum { RAISE_SHIFT = -10 };

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
    const scaled least = scaled_times(scaled_shift(num_most_condition, RAISE_SHIFT), r);
    if (scaled_is_less(num_tiny, r) && scaled_is_less(least, scaled_times(square, scaled_times(c, c)))) f->events |= KQ_EVENT_PRECISION;
}

/* If e^2 > g s: s becomes e^2.  Rounding in the place of h'P h does not say how the state has jumped; a state that is
   known does not jump. */
static void raise_for_jump(filter *f, const reading *z, const robust_scalar *m, scaled square, scaled g)
{
    const scaled r = *m->noise, s = scaled_plus(r, square);
    const scaled nis = scaled_times(m->e, scaled_over(m->e, s));
    if (!scaled_is_less(g, nis)) return;
    if (may_be_raised(f, z, m, square)) raise_root(f, r, square, nis);
    else if (scaled_is_less(num_zero_variance, square)) f->events |= KQ_EVENT_PRECISION;
}

static int is_recording(const filter *f) { return is_recorded(f) && history_of(f)->filter == f; }

/* A raised P is no step that the history could undo. */
static kq_status jump_check(const filter *f, const loss *how)
{
    const kq_status status = parameter_check(how->parameter);
    if (status) return status;
    if (scaled_is_less(how->parameter, scaled_one)) return KQ_ERR_RANGE;
    return is_recording(f) ? KQ_ERR_RECORDING : KQ_OK;
}

const loss_kind T(kq_loss_jump) = {.check = jump_check, .update = update_robust, .raise = raise_for_jump};

#endif
