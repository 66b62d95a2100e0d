/*
 * f32 and f64: a number is a number.
 */
#include "demo.h"

#include <math.h>

word *words(const double *values, size_t count)
{
    word *made = allocate(count, sizeof(word));
    for (size_t k = 0; k < count; k++) {
        made[k] = (word)values[k];
    }
    return made;
}

static void prepare_process(objects *o, const problem *given)
{
    size_t n = (size_t)given->n, length = KQ_PROCESS_LEN(n);
    word *memory = allocate(length, sizeof(word));
    check(T(kq_process_assign)(&o->motion, given->n, 0, memory, length), "process");
    check(T(kq_process_init)(&o->motion, words(given->A, n * n), NULL, words(given->Q, n * n)),
          "A, Q");
    o->process_bytes = sizeof(process) + length * sizeof(word);
}

static void prepare_sensor(objects *o, const problem *given)
{
    size_t n = (size_t)given->n, m = (size_t)given->m, length = KQ_SENSOR_LEN(m);
    word *memory = allocate(length, sizeof(word));
    check(T(kq_sensor_assign)(&o->gauge, given->n, given->m, memory, length), "sensor");
    check(T(kq_sensor_init)(&o->gauge, words(given->H, m * n), words(given->R, m * m)), "H, R");
    o->sensor_bytes = sizeof(sensor) + length * sizeof(word);
}

void prepare_model(objects *o, const problem *given)
{
    size_t n = (size_t)given->n, m = (size_t)given->m;
    prepare_process(o, given);
    prepare_sensor(o, given);
    check(T(kq_filter_init)(&o->track, words(given->x0, n), words(given->P0, n * n)), "x0, P0");
    o->z = words(given->z, given->steps * m);
    o->model_bytes = (n * n + m * n + m * m) * sizeof(word);
}

void state_of(const objects *o, const filter *f, double *mean, double *sigma)
{
    for (int i = 0; i < o->n; i++) {
        mean[i] = (double)T(kq_mean)(f, i) + (double)T(kq_mean_low)(f, i);
        sigma[i] = (double)T(kq_sigma)(f, i);
    }
}

void smoothed_of(const objects *o, size_t t, double *mean, double *sigma)
{
    for (int i = 0; i < o->n; i++) {
        mean[i] = (double)T(kq_smoothed_mean)(&o->tape, t, i) +
                  (double)T(kq_smoothed_mean_low)(&o->tape, t, i);
        sigma[i] = (double)T(kq_smoothed_sigma)(&o->tape, t, i);
    }
}

void measurement_of(const objects *o, const filter *f, double *mean, double *sigma)
{
    word z[KQ_SIZE_MAX], S[KQ_SIZE_MAX * KQ_SIZE_MAX];
    int m = o->m;
    check(T(kq_measurement)(f, &o->gauge, z, S), "measurement");
    for (int c = 0; c < m; c++) {
        mean[c] = (double)z[c];
        sigma[c] = sqrt((double)S[c * m + c]);
    }
}

double log_likelihood_of(const filter *f)
{
    return (double)T(kq_log_likelihood)(f);
}

void write_formats(const objects *o)
{
    (void)o;
}
