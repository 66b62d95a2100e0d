/*
 * Laws of calls that mean the same, of tame models: what comes late is as if in time, a smoother run in slices is the run, the
 * last step of a view is the filter, linearised steps of a linear model are its steps.
 */
#ifndef KALMANQ_FUZZ_LAWS_H
#define KALMANQ_FUZZ_LAWS_H

#include "tame.h"
#ifndef KQ_FUZZ_Q31
#include "laws_float.h"
#endif

/* A measurement taken `late` steps later is as in time; an on-line view of the present is the filter. */
static void late_is_in_time(void)
{
    const size_t length = LENGTH(LAG)(law.n, law.m, LATE);
    const int late = (int)below(LATE) + 1;
    word z[RUN + 1][MOST];
    K(filter) view;
    for (int t = 0; t <= RUN; t++) tame_words(z[t], law.m);
    DEMAND(K(delay_assign)(&law.lag, law.n, law.m, LATE, words(length), length) == KQ_OK);
    DEMAND(K(attach)(&law.one, &law.lag.attached) == KQ_OK);
    for (int t = 0; t < RUN; t++) {
        DEMAND(K(predict)(&law.one, &law.process, NULL) == KQ_OK && K(predict)(&law.other, &law.process, NULL) == KQ_OK);
        DEMAND(K(update)(&law.one, &law.sensor, z[t]) == KQ_OK && K(update)(&law.other, &law.sensor, z[t]) == KQ_OK);
        if (t == RUN - 1 - late) DEMAND(K(update)(&law.other, &law.sensor, z[RUN]) == KQ_OK);
    }
    DEMAND(K(update_delayed)(&law.lag, (size_t)late, &law.sensor, z[RUN], UINT32_MAX) == KQ_OK);
    if (!K(events)(&law.one) && !K(events)(&law.other)) check_alike(&law.one, &law.other);
    DEMAND(K(lagged)(&law.lag, 0, &view) == KQ_OK);
    check_same(&view, &law.one);
    DEMAND(K(predict)(&view, &law.process, NULL) == KQ_ERR_NOT_READY && K(update)(&view, &law.sensor, z[0]) == KQ_ERR_NOT_READY);
}

/* A run smoothed step by step is the run smoothed at once, bit for bit; what a view says of the last step is the filter's. */
static void slices_are_the_whole(void)
{
    const size_t length = LENGTH(HISTORY)(law.n, law.m, RUN + 1, 1);
    word z[MOST];
    K(filter) view, same;
    DEMAND(K(history_assign)(&law.first, law.n, words(length), length) == KQ_OK && K(attach)(&law.one, &law.first.attached) == KQ_OK);
    DEMAND(K(history_assign)(&law.second, law.n, words(length), length) == KQ_OK && K(attach)(&law.other, &law.second.attached) == KQ_OK);
    for (int t = 0; t < RUN; t++) {
        tame_words(z, law.m);
        DEMAND(K(step)(&law.one, &law.process, NULL, &law.sensor, z) == KQ_OK);
        DEMAND(K(predict)(&law.other, &law.process, NULL) == KQ_OK && K(update)(&law.other, &law.sensor, z) == KQ_OK);
    }
    check_same(&law.one, &law.other);
    DEMAND(K(smooth)(&law.first) == KQ_OK);
    for (size_t t = RUN + 1; t-- > 0;) {
        DEMAND(K(smooth_step)(&law.second, NULL, NULL) == KQ_OK);
        DEMAND(K(smoothed)(&law.first, t, &view) == KQ_OK && K(smoothed)(&law.second, t, &same) == KQ_OK);
        check_same(&view, &same);
        if (t == RUN) check_same(&view, &law.one);
    }
}

/* (A - I) x */
static void increment_of(const K(filter) *f, word *d)
{
    for (int i = 0; i < law.n; i++) {
        double sum = 0;
        for (int k = 0; k < law.n; k++) sum += ((double)law.A[i * law.n + k] - (i == k)) * (double)K(mean)(f, k);
        d[i] = (word)(IS_WHOLE ? nearbyint(sum) : sum);
    }
}

/* z - H x */
static void innovation_of(const K(filter) *f, const word *z, word *e)
{
    for (int c = 0; c < law.m; c++) {
        double sum = (double)z[c];
        for (int k = 0; k < law.n; k++) sum -= (double)law.H[c * law.n + k] * (double)K(mean)(f, k);
        e[c] = (word)(IS_WHOLE ? nearbyint(sum) : sum);
    }
}

/* A history that takes linearised predicts */
static void attach_jacobians(void)
{
    const size_t length = LENGTH(HISTORY)(law.n, law.m, RUN + 1, RUN), room = (size_t)LENGTH(JACOBIANS)(law.n, RUN, RUN);
    DEMAND(K(history_assign)(&law.first, law.n, words(length), length) == KQ_OK);
    DEMAND(K(jacobians_assign)(&law.jacobians, &law.first, law.n, KEEP(K(process), RUN), RUN, words(room), room) == KQ_OK);
    DEMAND(K(attach)(&law.one, &law.jacobians.attached) == KQ_OK);
}

/* A linear model's increments and innovations are its linear steps, filtered and smoothed. */
static void extended_is_linear(void)
{
    const size_t length = LENGTH(HISTORY)(law.n, law.m, RUN + 1, 1);
    const unsigned kind = below(3);
    const int steps = (int)below(2) + 1;
    word z[MOST], d[MOST];
    K(sensor) extended;
    K(filter) view, linear;
    DEMAND(put_sensor(&law.sensor, kind, law.n, law.m, law.H, law.R) == KQ_OK);
    DEMAND(put_sensor(&extended, kind + 3, law.n, law.m, law.H, law.R) == KQ_OK);
    attach_jacobians();
    DEMAND(K(history_assign)(&law.second, law.n, words(length), length) == KQ_OK && K(attach)(&law.other, &law.second.attached) == KQ_OK);
    for (int t = 0; t < steps; t++) {
        increment_of(&law.one, d), tame_words(z, law.m);
        DEMAND(K(predict_extended)(&law.one, &law.process, d) == KQ_OK && K(predict)(&law.other, &law.process, NULL) == KQ_OK);
        innovation_of(&law.one, z, d);
        DEMAND(K(update)(&law.one, &extended, d) == KQ_OK && K(update)(&law.other, &law.sensor, z) == KQ_OK);
    }
    if (K(events)(&law.one) || K(events)(&law.other)) return;
    check_alike(&law.one, &law.other);
    DEMAND(K(smooth)(&law.first) == KQ_OK && K(smooth)(&law.second) == KQ_OK);
    for (size_t t = 0; t <= (size_t)steps; t++) {
        DEMAND(K(smoothed)(&law.first, t, &view) == KQ_OK && K(smoothed)(&law.second, t, &linear) == KQ_OK);
        check_alike(&view, &linear);
    }
}

static void check_a_law(void)
{
    tame_model();
    tame_filter(&law.one), tame_filter(&law.other);
    switch (below(9)) {
    case 0: late_is_in_time(); break;
    case 1: extended_is_linear(); break;
#ifndef KQ_FUZZ_Q31
    case 2: halves_are_a_step(); break;
    case 3: correlated_is_its_formula(); break;
    case 4: sigma_points_are_linear(); break;
    case 5: parts_are_the_step(); break;
    case 6: controls_are_taken_away(); break;
    case 7: factor_of_one_is_none(); break;
#endif
    default: slices_are_the_whole();
    }
}

#endif
