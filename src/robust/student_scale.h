/*
 * A Student-t noise is a Gaussian one of covariance q Q, q being random: nu / q is chi-square with
 * nu degrees of freedom.  Its posterior is taken on the grid q = 1, 16, 256, ...: the filter is run
 * for each, and says how likely the measurement was.  The mean of sqrt(q) is then the scale of
 * the step.  After five scales the grid ends where they become less likely.
 *
 * NIS may be large at every scale (sensors that contradict each other), so scales are compared by
 * what it falls from one to the next, which is formed without a difference of the two: with y(q)
 * the mean of the noise in units of sqrt(q) G,
 *     NIS(p) - NIS(q) = (q - p) / sqrt(p q) y(p)'y(q)
 */
#ifndef KQ_SRC_ROBUST_STUDENT_SCALE_H
#define KQ_SRC_ROBUST_STUDENT_SCALE_H

#include <stdint.h>

#include "kalmanq/size.h"

#include "../arithmetic/rows.h"
#include "../arithmetic/scaled.h"
#include "../filter/likelihood.h"
#include "parameters.h"

enum { SCALES_LEAST = 5, SCALES_MOST = 8 };

static int32_t scale_at(int k) { return INT32_C(1) << 4 * k; }

/* e^-x, x >= 0: the inverse of the series of e^(x/64), squared six times.  Below e^-40 it is 0. */
static scaled exponential_of_minus(scaled x)
{
    static const scaled zero;
    if (scaled_is_less(scaled_of_count(40), x)) return zero;
    const scaled y = scaled_over(x, scaled_of_count(64));
    scaled e = scaled_one;
    for (int32_t k = 12; k > 0; k--) {
        e = scaled_plus(scaled_one, scaled_over(scaled_times(y, e), scaled_of_count(k)));
    }
    e = scaled_over(scaled_one, e);
    for (int k = 0; k < 6; k++) e = scaled_times(e, e);
    return e;
}

/* log of the prior of scale k: -nu (k log 4 + 16^-k / 2) */
static scaled log_prior(scaled nu, int k)
{
    const scaled log_4 =
        scaled_over(scaled_of_count(INT32_C(1386294361)), scaled_of_count(INT32_C(1000000000)));
    scaled part = scaled_over(scaled_one, scaled_of_count(INT32_C(2) << 4 * k));
    part = scaled_plus(part, scaled_times(scaled_of_count(k), log_4));
    return scaled_negative(scaled_times(nu, part));
}

/* What a trial of a scale says of it */
typedef struct {
    likelihood given;          /* of the measurement */
    scaled noise[KQ_SIZE_MAX]; /* y */
} scale_trial;

/* Half of what NIS falls from one scale (`before`) to the next, 15 / 8 y'y, up to 2^20.  y is taken
   in sixteenths: NIS is within 16 times the numbers, so no product of two leaves them. */
static scaled fall_of_nis(const scale_trial *before, const scale_trial *now, int n)
{
    static const scaled zero;
    const scaled most = scaled_of_count(INT32_C(1) << 20);
    scaled fall = zero;
    for (int i = 0; i < n; i++) {
        const scaled a = scaled_shift(before->noise[i], -4), b = scaled_shift(now->noise[i], -4);
        fall = scaled_plus(fall, scaled_times(a, b));
    }
    if (scaled_is_negative(fall)) return zero; /* rounding */
    fall = scaled_times(fall, scaled_of_count(256 / 8 * 15));
    return scaled_is_less(fall, most) ? fall : most;
}

/* -(log det S + count log 2 pi) / 2 */
static scaled log_volume(likelihood p)
{
    p.nis = 0;
    return scaled_of_score(likelihood_log(&p));
}

/* What the log of the probability rises by from scale k - 1 to scale k */
static scaled scale_gain(const scale_trial *before, const scale_trial *now, scaled nu, int k, int n)
{
    const scaled volume = scaled_minus(log_volume(now->given), log_volume(before->given));
    const scaled prior = scaled_minus(log_prior(nu, k), log_prior(nu, k - 1));
    return scaled_plus(fall_of_nis(before, now, n), scaled_plus(volume, prior));
}

static int is_positive(scaled a) { return !scaled_is_negative(a) && !scaled_is_zero(a); }

/* gains[k], from scale k - 1 to k, become what the log of the probability of scale k is below that
   of the likeliest.  They are summed from there, so that what is compared is small. */
static void gains_to_deficits(scaled *gains, int count)
{
    static const scaled zero;
    scaled rise = zero;
    int best = 0;
    for (int k = 1; k < count; k++) {
        rise = scaled_plus(rise, gains[k]);
        if (!is_positive(rise)) continue;
        best = k;
        rise = zero;
    }
    scaled below = zero, gain = zero;
    for (int k = best; k >= 0; k--) {
        below = scaled_plus(below, gain);
        gain = gains[k];
        gains[k] = is_positive(below) ? below : zero;
    }
    below = zero;
    for (int k = best + 1; k < count; k++) {
        below = scaled_minus(below, gains[k]);
        gains[k] = is_positive(below) ? below : zero;
    }
}

/* The mean of sqrt(q) over `count` scales; *jump: more than half of their probability is above 1 */
static scaled mean_scale(const scaled *deficits, int count, int *jump)
{
    static const scaled zero;
    scaled total = zero, sum = zero, first = zero;
    for (int k = 0; k < count; k++) {
        const scaled share = exponential_of_minus(deficits[k]);
        if (k == 0) first = share;
        total = scaled_plus(total, share);
        sum = scaled_plus(sum, scaled_times(share, scaled_of_count(INT32_C(1) << 2 * k)));
    }
    *jump = scaled_is_less(scaled_plus(first, first), total);
    return scaled_over(sum, total);
}

#endif
