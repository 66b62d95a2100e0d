/*
 * The words of fixed point on random models whose exact states all stay within 2/3 of the declared
 * ranges: no result may be wrong without an event, and none has a reason for KQ_EVENT_SATURATED.
 *     test_words [first seed] [models]
 */
#include <stdio.h>
#include <stdlib.h>

#include "word_run.h"

KQ_FILTER_Q31(track, 8);
KQ_FILTER_Q31(watched, 8);
KQ_FILTER_Q31(marked, 8);
KQ_HISTORY_Q31(tape, 8, 3, MOST_STEPS, 0);
KQ_HISTORY_Q31(quick, 8, 3, MOST_STEPS, 0);
KQ_LAG_Q31(lag, 8, 3, 6);
KQ_INSTANT_Q31(point, 8, 3);

static word_model model;
static quad_model exact;
static quad_step steps[MOST_STEPS];

/* What is read of a run, in sigmas, and whether a word had to be held */
enum { FILTER, SMOOTHER, STATES, LAG, POINT, KINDS };

typedef struct {
    double error[KINDS];
    unsigned held[KINDS];
} verdict;

typedef struct {
    const char *name;
    double worst;
    unsigned long silent, held, beyond;
} tally;

static tally tallies[KINDS] = {{.name = "filter"},
                               {.name = "smoother"},
                               {.name = "smoother, states only"},
                               {.name = "fixed lag"},
                               {.name = "fixed point"}};

static quad word_error(int32_t mean, int32_t low, quad exactly, quad variance)
{
    const quad value = mean + (quad)low * 0x1p-24;
    return absolute(value - exactly) / sqrtq(variance + 0x1p-28);
}

/* sigma of a smoothed state, to which comes 2^-25 of the filtered one */
static quad smoothed_variance(const quad_step *s, int i)
{
    return larger(s->variance[i], 0x1p-26 * s->P[i * exact.n + i]);
}

static int run_filter(kq_filter_q31 *f, int t)
{
    if (t == 0) return 0;
    return kq_predict_q31(f, &motion, exact.l ? controls[t - 1] : NULL);
}

static int measure(kq_filter_q31 *f, int t)
{
    return kq_update_subset_q31(f, &sensor, measured[t], exact.present[t] & ((1U << exact.m) - 1));
}

static int assign_all(int n)
{
    int status = kq_filter_assign_q31(&track, n, track_memory, KQ_FILTER_LEN_Q31(8));
    status |= kq_filter_assign_q31(&watched, n, watched_memory, KQ_FILTER_LEN_Q31(8));
    status |= kq_filter_assign_q31(&marked, n, marked_memory, KQ_FILTER_LEN_Q31(8));
    status |= kq_history_assign_q31(&tape, n, tape_memory, tape.length);
    status |= kq_history_assign_q31(&quick, n, quick_memory, quick.length);
    status |= kq_lag_assign_q31(&lag, n, 3, 6, lag_memory, sizeof lag_memory / sizeof *lag_memory);
    status |= kq_instant_assign_q31(&point, n, 3, point_memory, sizeof point_memory / sizeof *point_memory);
    status |= kq_filter_init_q31(&track, &prior, NULL);
    status |= kq_filter_init_q31(&watched, &prior, NULL);
    status |= kq_filter_init_q31(&marked, &prior, NULL);
    status |= kq_attach_q31(&track, &tape.attached);
    status |= kq_attach_q31(&watched, &lag.attached);
    return status | kq_attach_q31(&marked, &point.attached);
}

/* The filter on a tape; the worst error of it */
static quad filter_error(void)
{
    quad worst = 0;
    int status = 0;
    for (int t = 0; t < exact.steps; t++) {
        status |= run_filter(&track, t) | measure(&track, t);
        for (int i = 0; i < exact.n; i++) {
            const quad variance = steps[t].P[i * exact.n + i];
            worst = larger(worst, word_error(kq_mean_q31(&track, i), kq_mean_low_q31(&track, i),
                                             steps[t].x[i], variance));
        }
    }
    return status ? 1e30 : worst;
}

static unsigned smoothing_events(const kq_history_q31 *h)
{
    kq_filter_q31 view;
    const kq_status shown = kq_smoothed_q31(h, 0, &view); /* refused: it reads NaN */
    (void)shown;
    return kq_events_q31(&view);
}

static quad smoother_error(const kq_history_q31 *h)
{
    quad worst = 0;
    for (int t = 0; t < exact.steps; t++) {
        kq_filter_q31 view;
        const kq_status shown = kq_smoothed_q31(h, (size_t)t, &view); /* refused: it reads NaN */
        (void)shown;
        for (int i = 0; i < exact.n; i++) {
            worst = larger(worst, word_error(kq_mean_q31(&view, i), kq_mean_low_q31(&view, i),
                                             steps[t].smoothed[i],
                                             smoothed_variance(steps + t, i)));
        }
    }
    return worst;
}

/* At the end of the run, where what the smoothers on line know is what the textbook does */
static quad lag_error(void)
{
    quad worst = 0;
    int status = 0;
    kq_filter_q31 view;
    for (int t = 0; t < exact.steps; t++) {
        if (t) status |= kq_predict_q31(&watched, &motion, exact.l ? controls[t - 1] : NULL);
        status |= measure(&watched, t);
    }
    for (size_t k = 0; k <= 6; k++) {
        const int t = exact.steps - 1 - (int)k;
        status |= kq_lagged_q31(&lag, k, &view);
        for (int i = 0; i < exact.n; i++) {
            worst = larger(worst, word_error(kq_mean_q31(&view, i), kq_mean_low_q31(&view, i),
                                             steps[t].smoothed[i],
                                             smoothed_variance(steps + t, i)));
        }
    }
    return status ? 1e30 : worst;
}

static quad point_error(void)
{
    quad worst = 0;
    int status = 0;
    kq_filter_q31 view;
    for (int t = 0; t < exact.steps; t++) {
        if (t) status |= kq_predict_q31(&marked, &motion, exact.l ? controls[t - 1] : NULL);
        status |= measure(&marked, t);
    }
    status |= kq_instant_smooth_q31(&point, &view);
    for (int i = 0; i < exact.n; i++) {
        worst = larger(worst, word_error(kq_mean_q31(&view, i), kq_mean_low_q31(&view, i),
                                         steps[0].smoothed[i],
                                         smoothed_variance(steps, i)));
    }
    return status ? 1e30 : worst;
}

static void keep(verdict *v, int kind, quad error, unsigned events)
{
    v->error[kind] = (double)error;
    v->held[kind] = events & KQ_EVENT_SATURATED;
}

static int run_library(verdict *v)
{
    const quad filtered = filter_error();
    const unsigned events = kq_events_q31(&track);
    keep(v, FILTER, filtered, events);
    if (kq_smooth_q31(&tape)) return 0;
    keep(v, SMOOTHER, smoother_error(&tape), events | smoothing_events(&tape));
    if (kq_filter_init_q31(&track, &prior, NULL) || kq_attach_q31(&track, &quick.attached)) return 0;
    filter_error();
    if (kq_smooth_states_q31(&quick)) return 0;
    keep(v, STATES, smoother_error(&quick), events | smoothing_events(&quick));
    const quad lagged = lag_error(), first = point_error();
    keep(v, LAG, lagged, kq_events_q31(&watched));
    keep(v, POINT, first, kq_events_q31(&marked));
    return 1;
}

/* Answers whether the library has taken the model. */
static int try_model(uint64_t seed, double room, verdict *v)
{
    draw_model(&model, seed);
    quad_of_model(&exact, &model);
    quad_filter(steps, &exact);
    quad_smooth(steps, &exact);
    if (choose_formats(&model, steps, &exact, room) || prepare_tables(&model)) return 0;
    if (init_objects(&model) || assign_all(model.n)) return 0;
    quad_of_words(&exact, &model);
    quad_filter(steps, &exact);
    quad_smooth(steps, &exact);
    return run_library(v);
}

/* What a word explains is worse than in words with 64 times the room.  Where these do not do it
   either, the model is beyond the arithmetic, not beyond the words. */
static void judge(unsigned long seed, const verdict *narrow, const verdict *wide)
{
    for (int k = 0; k < KINDS; k++) {
        tally *now = tallies + k;
        const double error = narrow->error[k];
        const int wrong = !(error < 1e-3 || error < 4 * wide->error[k]);
        const int beyond = wide->held[k] || !(wide->error[k] < 1e-2);
        if (!wrong && !narrow->held[k]) continue;
        if (beyond) now->beyond++;
        else if (narrow->held[k]) now->held++;
        else now->silent++;
        if (error > now->worst) now->worst = error;
        printf("seed %lu, n = %d: %s %.2g sigma%s, with room %.2g\n", seed, model.n, now->name, error,
               narrow->held[k] ? ", held" : "", wide->error[k]);
    }
}

int main(int argc, char **argv)
{
    const unsigned long first = argc > 1 ? strtoul(argv[1], NULL, 0) : 1;
    const unsigned long models = argc > 2 ? strtoul(argv[2], NULL, 0) : 100;
    unsigned long taken = 0, wrong = 0;
    for (unsigned long seed = first; seed < first + models; seed++) {
        verdict narrow, wide;
        if (!try_model(seed, 1, &narrow) || !try_model(seed, 64, &wide)) continue;
        judge(seed, &narrow, &wide);
        taken++;
    }
    printf("%lu of %lu models taken\n", taken, models);
    for (int k = 0; k < KINDS; k++) {
        const tally *now = tallies + k;
        printf("%-22s worst %.2g sigma, %lu silent, %lu held, %lu beyond the arithmetic\n",
               now->name, now->worst, now->silent, now->held, now->beyond);
        wrong += now->silent + now->held;
    }
    return wrong || taken < models / 2;
}
