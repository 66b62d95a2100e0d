/* Is a smoothed sigma beyond what the filter's, of which it is what later measurements leave, can tell? */
#ifndef KQ_SRC_SMOOTHER_RESOLUTION_H
#define KQ_SRC_SMOOTHER_RESOLUTION_H

#include "tape.h"

/* Have later measurements left a 32nd of some coordinate, or less, T being the root of all data? */
KQ_KERNEL int root_is_short(const num *T, int n)
{
    const scaled least = scaled_shift(scaled_of_count(1), -5);
    for (int k = 0; k < n; k++) {
        if (scaled_is_less(scaled_magnitude(root_number(T, n, k, k)), least)) return 1;
    }
    return 0;
}

/* Is a sigma, its square being `after`, less than 8 roundings of the filter's mean, which had the sigma of `before`: of
   what the predict from x by row i of A adds to it, and of what an update has moved it?  A: NULL where it is not known */
KQ_COLD static int is_below_mean(scaled before, scaled after, const scaled *A, const num *x, int n, int i)
{
    const scaled terms = A ? mean_terms(A + i * n, x, n, i) : mean_size(x, n, i);
    const scaled moved = scaled_plus(scaled_root(before), terms);
    return scaled_is_less(scaled_root(after), scaled_shift(scaled_times(scaled_rounding(), moved), -2));
}

/*
 * Where later measurements leave little of a sigma, smoothed means and covariances are not as good as their sigmas say:
 * less than the coordinates' errors (history_add_rounding) make of the sigma without them, or than the mean's roundings.
 * `root` is the one without those measurements: predicted, of the step that A leads to from x, or filtered, of the step
 * that it leads from.  A state that is known exactly has a sigma at rounding: it is left out.
 */
KQ_COLD KQ_NOINLINE static unsigned smoothing_events(const scaled *A, const num *x, const num *root, const num *smoothed,
                                                     uint32_t rounding, int n)
{
    const scaled share = scaled_times(num_tape_rounding, scaled_of_count((int32_t)rounding));
    for (int i = 0; i < n; i++) {
        const scaled before = root_product(root, n, i, i), after = root_product(smoothed, n, i, i);
        if (!scaled_is_less(after, scaled_shift(before, -12))) continue;
        if (!scaled_is_less(scaled_times(num_known_exactly, before), after)) continue;
        if (scaled_is_less(after, scaled_times(share, before))) return KQ_EVENT_PRECISION;
        if (is_below_mean(before, after, A, x, n, i)) return KQ_EVENT_PRECISION;
    }
    return 0;
}

/*
 * Is the smoothed sigma of state i, of the step that A leads to from x, between 1/2 and 4 roundings of what A x is the sum
 * of?  Each predict rounds the mean so.  Below, the sigma cannot be told from 0.
 */
KQ_COLD KQ_NOINLINE static unsigned rounded_mean_events(const scaled *A, const num *x, const num *predicted, const num *smoothed,
                                                        int i, int n)
{
    const scaled after = root_product(smoothed, n, i, i), rounding = mean_rounding(A + i * n, x, n, i);
    if (!scaled_is_less(after, scaled_times(scaled_of_count(16), rounding))) return 0;
    if (scaled_is_less(scaled_times(scaled_of_count(4), after), rounding)) return 0;
    const scaled least = scaled_times(num_known_exactly, root_product(predicted, n, i, i));
    return scaled_is_less(least, after) ? KQ_EVENT_PRECISION : 0;
}

#endif
