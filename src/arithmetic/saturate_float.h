/*
 * A state that nothing measures and nothing damps grows until predict leaves the number range.  Here
 * no sigma grows beyond num_most_sigma: squares and products of two of them are numbers, and an
 * update can still bring the state back.  A mean that grows beyond num_most_sigma squared is lost.
 * saturate_q31.h is the twin.
 */
#ifndef KQ_SRC_ARITHMETIC_SATURATE_FLOAT_H
#define KQ_SRC_ARITHMETIC_SATURATE_FLOAT_H

#include "mean_float.h"
#include "sizes.h"

/* sigma_i in units of num_saturation_unit, so that no square of a finite entry leaves the numbers; not finite
   where an entry is not */
static inline num row_norm(const num *S, int n, int i)
{
    num total = 0;
    for (int j = i; j < n; j++) {
        const num entry = S[column(j) + i] / num_saturation_unit;
        total += entry * entry;
    }
    return num_root(total);
}

/* Row i below its limit, without correlations: a shorter row would say of the other states what is not so.  So far below
   that it grows for some predicts before it is held again: by then a measurement of another state may tell of it. */
static inline void row_saturate(num *S, int n, int i, num most)
{
    for (int j = i; j < n; j++) S[column(j) + i] = j == i ? most * (num)0x1p-16f : 0;
}

/* The largest sigma of a state for which h'P h is a number, h being a row of H or NULL: 1/8 of the limit over its largest
   entry, of which there are 16.  Of an H beyond 2^29 there may be none: it is no less than 2^-32 of the limit. */
static inline num largest_sigma(const num *h, int n)
{
    const num most = (num)0x1p32f;
    num size = 1;
    for (int i = 0; h && i < n; i++) {
        if (8 * num_magnitude(h[i]) > size) size = 8 * num_magnitude(h[i]);
    }
    return num_most_sigma / (size < most ? size : most);
}

/* What column `from` holds of row k, the rows below counting no more, becomes part of the pivot of column `to`. */
KQ_COLD KQ_NOINLINE static void join_pivot(num *restrict to, num *restrict from, int k)
{
    const num length = num_root(to[k] * to[k] + from[k] * from[k]);
    if (length == 0) return;
    const num c = to[k] / length, s = from[k] / length;
    for (int i = 0; i <= k; i++) {
        const num entry = to[i];
        to[i] = c * entry + s * from[i];
        from[i] = c * from[i] - s * entry;
    }
    from[k] = 0;
}

/* Is x_i within its limit?  If not, nothing is known of it any more, and it is 0: from a number as
   large a measurement would not lead back to its own digits. */
static inline int mean_is_kept(num *x, int n, int i)
{
    const num share = x[i] / num_most_sigma;
    if (share * share <= num_most_sigma * num_most_sigma) return 1;
    mean_set(x, n, i, 0);
    return 0;
}

/* h: a row of H for which the state is to be held, or NULL.  The rows above one that is held have been looked at by then.
   What they have in its column goes into their own. */
KQ_COLD KQ_NOINLINE static unsigned state_saturate(num *x, num *S, const num *h, int n)
{
    const num most = largest_sigma(h, n);
    unsigned events = 0;
    for (int i = 0; i < n; i++) {
        const int is_kept = mean_is_kept(x, n, i);
        if (is_kept && row_norm(S, n, i) <= most / num_saturation_unit) continue;
        for (int k = i; k-- > 0;) join_pivot(S + column(k), S + column(i), k);
        row_saturate(S, n, i, most);
        events = KQ_EVENT_OVERFLOW;
    }
    return events;
}

/* The state, of which the mean has been moved, held within the numbers */
KQ_INLINE unsigned mean_saturated(num *x, num *S, int n, extent far)
{
    return KQ_MOSTLY(extent_is_within(far)) ? 0 : state_saturate(x, S, 0, n);
}

/* The state, all means of which a smoother has moved, held within the numbers */
KQ_INLINE unsigned means_saturated(num *x, num *S, int n)
{
    extent far = mean_extent(x, n, 0);
    KQ_UNROLL
    for (int i = 1; i < n; i++) far = extent_join(far, mean_extent(x, n, i));
    return mean_saturated(x, S, n, far);
}

/* Is there nothing to hold in what predict made of the state? */
KQ_INLINE int state_is_within(const num *S, int n, extent far)
{
    (void)S, (void)n;
    return extent_is_within(far);
}

/* What predict made of the state, held within the numbers */
KQ_INLINE unsigned state_saturated(num *x, num *S, int n, extent far) { return mean_saturated(x, S, n, far); }

#endif
