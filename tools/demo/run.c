/*
 * kq_demo_f32, kq_demo_f64, kq_demo_q31: filter, forecast and smooth one sequence with kalmanq.
 *
 *     kq_demo_f32 < problem > results
 *
 * The problem is text: words and numbers between white space, `#` starts a comment.
 *
 *     sizes n m steps ahead       1..16, 1..16, 1..10000000, 0..1000000
 *     A     n x n numbers         row by row, like all matrices
 *     Q     n x n
 *     H     m x n
 *     R     m x m
 *     x0    n                     the state before the first measurement
 *     P0    n x n
 *     x_range  n                  > 0: q31 chooses the formats of states and measurements so
 *     z_range  m                  that these fit; f32 and f64 do not look at them
 *     z     steps x m             `nan`: this component was not measured
 *     end
 *
 * The results are text too, one record a line:
 *
 *     log_likelihood NUMBER
 *     events BITS                 KQ_EVENT_... of status.h
 *     memory model B process B sensor B filter B history B           bytes on this host
 *     formats state F[n] measurement F[m]        q31: the fraction bits n of Qm.n, m = 31 - n
 *     step T      mean[n] sigma[n] smoothed_mean[n] smoothed_sigma[n]      T = 0 .. steps - 1
 *     forecast K  mean[n] sigma[n] z[m] z_sigma[m]                         K = 1 .. ahead
 *     end
 *
 * Bad input, or for q31 a model or data that do not fit the ranges: one line on stderr, nothing
 * on stdout, exit status 1.
 */
#include "demo.h"

#include <stdlib.h>

/* What is read off the filter, row by row: mean and sigma of what there are `width` of. */
typedef struct {
    double *mean, *sigma;
    int width;
} estimates;

typedef struct {
    estimates filtered;                /* steps rows, n wide */
    estimates smoothed;                /* steps rows, n wide */
    estimates forecast;                /* ahead rows, n wide */
    estimates forecast_z;              /* ahead rows, m wide */
    double log_likelihood;
    unsigned events;
} results;

static estimates estimates_of(size_t rows, int width)
{
    estimates e = {NULL, NULL, width};
    e.mean = allocate(rows * (size_t)width, sizeof(double));
    e.sigma = allocate(rows * (size_t)width, sizeof(double));
    return e;
}

/* ---- the library at work ----------------------------------------------------------------- */

static void give_memory(filter *f, int n)
{
    size_t length = (size_t)LENGTH(KQ_FILTER_LEN)(n);
    check(T(kq_filter_assign)(f, n, allocate(length, sizeof(word)), length), "filter");
}

static objects prepare(const problem *given)
{
    objects o = {.n = given->n, .m = given->m};
    size_t tape_length = LENGTH(KQ_HISTORY_LEN)((size_t)o.n, (size_t)o.m, given->steps, 0);
    word *tape = allocate(tape_length, sizeof(word));

    give_memory(&o.track, o.n);
    give_memory(&o.future, o.n);
    check(T(kq_history_assign)(&o.tape, o.n, tape, tape_length), "history");
    prepare_model(&o, given);
    return o;
}

static double *row_of(double *values, const estimates *e, size_t row)
{
    return values + row * (size_t)e->width;
}

static void note_state(const estimates *e, size_t row, const objects *o, const filter *f)
{
    state_of(o, f, row_of(e->mean, e, row), row_of(e->sigma, e, row));
}

static void note_measurement(const estimates *e, size_t row, const objects *o, const filter *f)
{
    measurement_of(o, f, row_of(e->mean, e, row), row_of(e->sigma, e, row));
}

/* Update, predict, update, ..., update: no predict after the last measurement. */
static void run_filter(objects *o, const problem *given, results *found)
{
    found->filtered = estimates_of(given->steps, given->n);
    check(T(kq_history_attach)(&o->tape, &o->track), "history");
    for (size_t t = 0; t < given->steps; t++) {
        const word *z = o->z + t * (size_t)given->m;
        if (t > 0) {
            check(T(kq_predict)(&o->track, &o->motion, NULL), "predict");
        }
        check(T(kq_update_subset)(&o->track, &o->gauge, z, given->present[t]), "update");
        note_state(&found->filtered, t, o, &o->track);
    }
    found->log_likelihood = log_likelihood_of(&o->track);
    found->events = T(kq_events)(&o->track);
}

/* One forecast a line: the first from the filter, each later one a step further. */
static void run_forecast(objects *o, const problem *given, results *found)
{
    found->forecast = estimates_of((size_t)given->ahead, given->n);
    found->forecast_z = estimates_of((size_t)given->ahead, given->m);
    check(T(kq_forecast)(&o->track, &o->motion, NULL, 0, &o->future), "forecast");
    for (int k = 0; k < given->ahead; k++) {
        check(T(kq_predict)(&o->future, &o->motion, NULL), "forecast");
        note_state(&found->forecast, (size_t)k, o, &o->future);
        note_measurement(&found->forecast_z, (size_t)k, o, &o->future);
    }
    found->events |= T(kq_events)(&o->future);
}

static void run_smoother(objects *o, const problem *given, results *found)
{
    const estimates *e = &found->smoothed;
    found->smoothed = estimates_of(given->steps, given->n);
    check(T(kq_smooth)(&o->tape), "smoother");
    if (T(kq_history_steps)(&o->tape) != given->steps) {
        fail("the history holds %lu steps, not %lu",
             (unsigned long)T(kq_history_steps)(&o->tape), (unsigned long)given->steps);
    }
    for (size_t t = 0; t < given->steps; t++) {
        smoothed_of(o, t, row_of(e->mean, e, t), row_of(e->sigma, e, t));
    }
}

/* ---- writing ----------------------------------------------------------------------------- */

/* What a target would need for the same work. */
static void write_memory(const objects *o, const problem *given)
{
    size_t n = (size_t)o->n, m = (size_t)o->m;
    size_t filter_words = LENGTH(KQ_FILTER_LEN)(n);
    size_t history_words = LENGTH(KQ_HISTORY_LEN)(n, m, given->steps, 0);
    printf("memory model %lu process %lu sensor %lu filter %lu history %lu\n",
           (unsigned long)o->model_bytes, (unsigned long)o->process_bytes,
           (unsigned long)o->sensor_bytes,
           (unsigned long)(sizeof(filter) + filter_words * sizeof(word)),
           (unsigned long)(sizeof(history) + history_words * sizeof(word)));
}

static void write_row(const estimates *e, size_t row)
{
    for (int i = 0; i < e->width; i++) {
        printf(" %.17g", row_of(e->mean, e, row)[i]);
    }
    for (int i = 0; i < e->width; i++) {
        printf(" %.17g", row_of(e->sigma, e, row)[i]);
    }
}

static void write_results(const objects *o, const problem *given, const results *found)
{
    printf("log_likelihood %.17g\n", found->log_likelihood);
    printf("events %u\n", found->events);
    write_memory(o, given);
    write_formats(o);
    for (size_t t = 0; t < given->steps; t++) {
        printf("step %lu", (unsigned long)t);
        write_row(&found->filtered, t);
        write_row(&found->smoothed, t);
        putchar('\n');
    }
    for (size_t k = 0; k < (size_t)given->ahead; k++) {
        printf("forecast %lu", (unsigned long)k + 1);
        write_row(&found->forecast, k);
        write_row(&found->forecast_z, k);
        putchar('\n');
    }
    finish_output();
}

/* All memory lives as long as the program: the system takes it back. */
int main(void)
{
    results found = {0};
    problem given = read_problem(stdin);
    objects o = prepare(&given);
    run_filter(&o, &given, &found);
    run_forecast(&o, &given, &found);
    run_smoother(&o, &given, &found);
    write_results(&o, &given, &found);
    return EXIT_SUCCESS;
}
