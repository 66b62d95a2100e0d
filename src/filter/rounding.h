/*
 * What rounding does to the root, looked at: of one measurement in WATCH_PERIOD one column, so that no update costs much
 * more than another.
 */
#ifndef KQ_SRC_FILTER_ROUNDING_H
#define KQ_SRC_FILTER_ROUNDING_H

#include "state.h"

/* Scalar measurements between looks, as powers of 2: an update, and a step of compile-time sizes */
enum { WATCH_PERIOD = 3, WATCH_PERIOD_FIXED = 6 };

/* Where f_j^2 is 2^SEEN of its rounding or more, the direction is measured, and its variance right to 2 2^(-SEEN / 2). */
enum { SEEN = 12 };

/* An update that takes 1/56 of a variance, 0.9 % of a sigma, has the event.  What is below is rounded down, by 1.4. */
enum { LOSSES = 80 };

/* An entry makes a sigma wrong by 3 % where it is 2^-SHARE_OF_ROW of the rest of its row. */
enum { SHARE_OF_ROW = 2 };

/* What is added to an entry is right to an eighth where it is 2^SURELY_ADDED of its rounding or more. */
enum { SURELY_ADDED = 2 };

/* What predicts lose of a row's part that is known, in as many steps as the losses take: a sixteenth has the event. */
enum { LOSSES_OF_PREDICTS = 16 };

/* Is a look due?  At another place of each 8, so that each component of a sensor is looked at. */
KQ_KERNEL int is_watched(const filter *f)
{
    const int32_t count = f->run.count + f->last.count;
    return ((count + (count >> WATCH_PERIOD)) & ((1 << WATCH_PERIOD) - 1)) == 0;
}

/* Which of n: all of them as often, at each component, too (multiples of the golden ratio) */
KQ_COLD static int watched_column(int32_t look, int n)
{
    return (int)((((uint32_t)look * UINT32_C(40503) & 0xffff) * (uint32_t)n) >> 16);
}

/* Nothing is left of a weight below 2^17 by more. */
enum { LEAST_LOSS = num_loss_bits + 17 };

/* Adds weight 2^-down to the losses.  They are `losses` times 2^-32: more than 1 is too much, has the event, and begins anew. */
KQ_COLD static void add_losses(filter *f, uint32_t weight, int32_t down)
{
    if (down > LEAST_LOSS) return;
    const int32_t up = num_loss_bits - down;
    const int is_whole = down < 32 && weight >> down;
    const uint32_t units = is_whole ? 0 : up >= 0 ? weight << up : weight >> -up;
    const uint32_t share = units << (31 - num_loss_bits) << 1;
    if (is_whole || f->losses + share < share) f->events |= KQ_EVENT_PRECISION;
    f->losses += share;
}

/*
 * An update takes f'f / s from the variance of a direction, f being S'h.  Where f is rounding, nothing has been
 * measured, and the sigma becomes too small.  S is rounded at each update: f_j by a part of the sizes of its terms.
 * This adds up over as many updates as P remembers, about s / f'f.  Up to that f_j counts.  Where all of f is less than
 * the rounding of one update, that counts instead.  All as powers of 2, rounded down.
 */
KQ_COLD KQ_NOINLINE static void watch_rounding(filter *f, const scaled *h, const num *row, scaled r, scaled s, int period)
{
    enum { MOST_REMEMBERED = 22 }; /* s - r is rounded */
    const int n = f->states, j = watched_column((f->run.count + f->last.count) >> period, n);
    const int32_t all = scaled_log(s), square = scaled_log(scaled_minus(s, r));
    const int32_t remembered = all - square < MOST_REMEMBERED ? all - square : MOST_REMEMBERED;
    const int32_t rounding = num_watched + project_log(filter_root(f), h, n, j);
    int32_t taken = rounding + (is_weak(r, s) ? 1 : 2) * remembered; /* what a weak one rounds (weak.h) goes up and down */
    if (all - taken > LEAST_LOSS) return;
    const int32_t own = 2 * scaled_log(row_entry(row, n, j));
    if (own - taken > SEEN) return;
    if (own < taken) taken = own;
    if (square < rounding) taken = rounding;
    add_losses(f, (uint32_t)(LOSSES * n) << period, all < taken ? 0 : all - taken);
}

/* The same of a measurement that is not on the ordinary path.  What has no noise has a floor. */
KQ_COLD KQ_NOINLINE static void watch_row(filter *f, const scaled *h, scaled r, int period)
{
    num row[ROW_LEN(KQ_SIZE_MAX)];
    if (!scaled_is_less(num_tiny, r)) return;
    project(row, filter_root(f), h, f->states);
    watch_rounding(f, h, row, r, add_square(r, row, f->states), period);
}

/* ------------------------------------------------------------------ predicts */

/* Of the rows but k in which column j is as large as in i, log2 of the least sigma given the states behind it */
KQ_COLD KQ_NOINLINE static int32_t log_known(const num *S, int n, int i, int j, int k)
{
    int32_t least = root_log(S, n, i, i);
    for (int r = 0; r <= j; r++) {
        const int32_t sigma = root_log(S, n, r, r);
        if (r != k && sigma < least && root_log(S, n, r, j) + SHARE_OF_ROW >= root_log(S, n, i, j)) least = sigma;
    }
    return least;
}

/*
 * A predict adds A_ik S_kj to S_ij, A_ii being 1.  Where that is less than S_ij is rounded by, it is lost at each step, the
 * same way: S_kj stays as it is, though measurements of what is known of row i would take it away.  It is wrong where it counts
 * beside S_kk, and after as many steps as bring what was lost to what is known.  So it is with a rate beside a position and
 * its offset, all without process noise.  Looked at is one entry; `taken`: measurements of a step.
 */
KQ_NOINLINE static void watch_transition(filter *f, const process *p, int32_t taken)
{
    const int32_t look = f->run.count >> WATCH_PERIOD_FIXED;
    const int n = f->states, j = watched_column(look, n), i = (int)((uint32_t)look % (uint32_t)(j + 1));
    const num *S = filter_root(f);
    const scaled *a = p->transition + i * n;
    int32_t lost = INT32_MIN / 2;
    int from = i;
    if (!scaled_is_unit(a[i])) return;
    for (int k = p->first[i]; k <= j; k++) {
        if (k == i || scaled_is_zero(a[k]) || S[column(j) + k] == 0) continue;
        const int32_t term = scaled_log(a[k]) + root_log(S, n, k, j);
        if (term > lost) lost = term, from = k;
    }
    if (from == i || lost > entry_rounding(S, n, i, j) + SURELY_ADDED) return;
    if (root_log(S, n, from, from) - root_log(S, n, from, j) > SHARE_OF_ROW) return;
    const int32_t known = log_known(S, n, i, j, from);
    const uint32_t weight = ((uint32_t)(LOSSES_OF_PREDICTS * n * (j + 1)) << WATCH_PERIOD_FIXED) / (uint32_t)taken;
    add_losses(f, weight, known < lost ? 0 : known - lost);
}

/* A look at a predict, where the last update has brought the count, which lean sensors leave at 0, to another period: not
   in a step in which one at an update is due */
KQ_KERNEL void watch_predict(filter *f, const process *p)
{
    const int32_t taken = f->last.count, within = (f->run.count + 4) & ((1 << WATCH_PERIOD_FIXED) - 1);
    if (within < taken) watch_transition(f, p, taken);
}

#endif
