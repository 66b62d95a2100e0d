/*
 * A state that nothing measures and nothing damps grows until predict leaves the number range.  Here
 * no sigma grows beyond num_most_sigma: squares and products of two of them are numbers, and an
 * update can still bring the state back.  A mean that grows beyond num_most_sigma squared is lost.
 * hold_q31.h is the twin.
 */
#ifndef KQ_SRC_ARITHMETIC_HOLD_FLOAT_H
#define KQ_SRC_ARITHMETIC_HOLD_FLOAT_H

#include "kalmanq/status.h"

#include "arithmetic.h"
#include "compiler.h"
#include "mean.h"
#include "triangle.h"

/* sigma_i in units of num_hold_unit, so that no square of a finite entry leaves the numbers; not finite
   where an entry is not */
static inline num row_norm(const num *S, int n, int i)
{
    num total = 0;
    for (int j = i; j < n; j++) {
        const num entry = S[column(j) + i] / num_hold_unit;
        total += entry * entry;
    }
    return num_root(total);
}

/* Row i at the limit: shorter by a factor, with the correlations that it has, or of its own where they
   are lost (0) */
static inline void row_hold(num *S, int n, int i, num factor)
{
    for (int j = i; j < n; j++) {
        num *entry = S + column(j) + i;
        *entry = factor > 0 ? *entry * factor : j == i ? num_most_sigma : 0;
    }
}

/* Is x_i within its limit?  If not, nothing is known of it any more, and it is 0: from a number as
   large a measurement would not lead back to its own digits. */
static inline int mean_is_kept(num *x, int n, int i)
{
    if (num_magnitude(x[i]) <= num_most_sigma * num_most_sigma) return 1;
    mean_set(x, n, i, 0);
    return 0;
}

KQ_COLD KQ_NOINLINE static unsigned state_hold(num *x, num *S, int n)
{
    const num most = num_most_sigma / num_hold_unit;
    unsigned events = 0;
    for (int i = 0; i < n; i++) {
        const num norm = row_norm(S, n, i);
        const int is_known = mean_is_kept(x, n, i) && num_is_finite(norm);
        if (is_known && norm <= most) continue;
        row_hold(S, n, i, is_known ? most / norm : 0);
        events = KQ_EVENT_OVERFLOW;
    }
    return events;
}

static inline int state_is_finite(const num *x, const num *S, int n)
{
    num total = 0;
    for (int i = 0; i < n; i++) total += 0 * x[i] + 0 * S[column(i) + i];
    return total == 0;
}

/* Is there nothing to hold in what predict made of the root?  One sum tells it: an infinity or a NaN
   of a row is one of its diagonal too, as the row's norm. */
KQ_INLINE int root_is_within(const num *S, int n)
{
    num total = *S;
    KQ_UNROLL
    for (int i = 1; i < n; i++) {
        S += i + 1;
        total += *S;
    }
    return !num_exceeds(total, num_most_sigma);
}

/* What predict made of the state, held within the numbers.  A mean that leaves the numbers alone,
   driven out of them by a control, is met at the next update. */
KQ_INLINE unsigned state_held(num *x, num *S, int n)
{
    return KQ_MOSTLY(root_is_within(S, n)) ? 0 : state_hold(x, S, n);
}

#endif
