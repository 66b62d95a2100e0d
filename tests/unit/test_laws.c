/* The laws in floating point. */
#include "laws_model.h"

typedef num word;

#define S(name) K(name)
#define ROUNDING TOLERANCE
#define ROUNDING_OF_MEANS TOLERANCE
#define ROUNDING_IN_TURN TOLERANCE
#define ASSERT_SAME ASSERT_SAME_FILTER

typedef struct {
    num words[KQ_PROCESS_LEN(3)];
    K(process) process;
} process_model;

typedef struct {
    num words[KQ_SENSOR_LEN(3)];
    K(sensor) sensor;
} sensor_model;

typedef struct {
    num filter_words[FILTER_LEN(3)], tape_words[HISTORY_LEN(3, 3, STEPS, 0)];
    K(filter) filter;
    K(history) tape;
} instance;

static void make_process(process_model *m, int n, int l, const num *range, const num *A,
                         const num *B, const num *Q)
{
    (void)range;
    ASSERT_OK(K(process_assign)(&m->process, n, l, m->words, COUNT(m->words)));
    CALL(K(process_init)(&m->process, A, B, Q));
}

static void make_sensor(sensor_model *s, int n, int m, const num *range, const num *measured_range,
                        const num *H, const num *R)
{
    (void)range, (void)measured_range;
    ASSERT_OK(K(sensor_assign)(&s->sensor, n, m, s->words, COUNT(s->words)));
    CALL(K(sensor_init)(&s->sensor, H, R));
}

static void make_independent(sensor_model *s, int n, int m, const num *range,
                             const num *measured_range, const num *H, const num *r)
{
    (void)range, (void)measured_range;
    ASSERT_OK(K(sensor_assign)(&s->sensor, n, m, s->words, COUNT(s->words)));
    CALL(K(sensor_init_diagonal)(&s->sensor, H, r));
}

static void make_filter(instance *i, int n, const num *range, const num *x0, const num *P0)
{
    (void)range;
    ASSERT_OK(K(filter_assign)(&i->filter, n, i->filter_words, COUNT(i->filter_words)));
    CALL(K(filter_init)(&i->filter, x0, P0));
}

static const num *measured(const K(sensor) * s, const num *z)
{
    (void)s;
    return z;
}

static const num *driven(const K(process) * p, const num *u, int steps)
{
    (void)p, (void)steps;
    return u;
}

static void read_now(reading *r, const instance *i, int n) { read_filter(r, &i->filter, n); }

/* Beside its own last bit nothing is rounded. */
static double score_step(void) { return 0; }
static double smoother_step(void) { return 0; }

static double sigma_step(num range)
{
    (void)range;
    return 0;
}

static double score_rounding(double score, int terms)
{
    (void)terms;
    return TOLERANCE * (4 + fabs(score));
}

static kq_status read_gain(const K(filter) * f, const K(sensor) * s, num *gain)
{
    return K(gain)(f, s, gain);
}

static kq_status read_measurement(const K(filter) * f, const K(sensor) * s, num *z, num *S)
{
    return K(measurement)(f, s, z, S);
}

static kq_status read_innovation(const K(filter) * f, const K(sensor) * s, const num *z, num *e)
{
    return K(innovation)(f, s, z, e);
}

static kq_status step_back(instance *i, num *lag_one, num *mean, num *covariance)
{
    const K(smooth_extras) extras = {lag_one, mean, covariance};
    return K(smooth_step)(&i->tape, NULL, &extras);
}

static kq_status read_noise(const instance *i, num *mean, num *variance)
{
    return K(smoothed_measurement_noise)(&i->tape, 0, mean, variance);
}

static void read_past(reading *r, const instance *i, size_t t, int n)
{
    read_smoothed(r, &i->tape, t, n);
}

static double smoothed_value(const instance *i, size_t t, int k)
{
    return whole_smoothed_mean(&i->tape, t, k);
}

#include "laws.h"

SUITE(laws, set_up)
{
    run_laws();
}
