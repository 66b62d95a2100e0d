/* Models in floating point (models.h). */
#ifndef KALMANQ_TESTS_MODELS_FLOAT_H
#define KALMANQ_TESTS_MODELS_FLOAT_H

#include "reading.h"

#ifndef MAX /* states, components, controls */
#define MAX 4
#endif

typedef num word, entry, score;

#define S(name) K(name)
#define S_IN_T IN_T
#define ROUNDING TOLERANCE
#define ROUNDING_OF_MEANS TOLERANCE
#define ROUNDING_IN_TURN TOLERANCE

#define S_FREEZE_LEN(n) KQ_TRIANGLE((size_t)(n))
#define S_STEADY_LEN(n) ((size_t)(n))
#define S_ROOT_LEN KQ_TRIANGLE
#define ASSIGN_ADAPTATION(a, n, m) K(adaptation_assign)(&a, n, m, a##_memory, COUNT(a##_memory))

/* What is refused as a measurement, and how */
#define NOT_A_NUMBER KQ_ERR_NOT_FINITE
static inline num bad_word(const K(sensor) *s, int k)
{
    static const num bad[] = {(num)NAN, (num)INFINITY, -(num)INFINITY, (num)NAN};
    (void)s;
    return bad[k];
}

/* What is refused as a parameter or a factor, and how */
#define NOT_AN_ENTRY KQ_ERR_NOT_FINITE
#define NO_VARIANCE KQ_ERR_NOT_SEMIDEFINITE
static inline num bad_entry(int k) { return k == 0 ? (num)NAN : k == 1 ? (num)INFINITY : -(num)INFINITY; }
static inline num just_above_1(void) { return 1 + (num)EPS; }

static inline int is_nothing(num a) { return isnan(a); }
static inline int is_no_score(num a) { return isnan(a); }

#define ASSERT_SAME ASSERT_SAME_FILTER

typedef struct {
    num words[KQ_PROCESS_LEN(MAX)];
    K(process) process;
} process_model;

typedef struct {
    num words[KQ_SENSOR_LEN(MAX)];
    K(sensor) sensor;
} sensor_model;

typedef struct {
    const num *mean, *covariance;
} prior_model;

static inline void put_process(process_model *m, int n, int l, const num *range, const num *drive_range,
                               const num *A, const num *B, const num *Q)
{
    (void)range, (void)drive_range;
    ASSERT_OK(K(process_assign)(&m->process, n, l, m->words, COUNT(m->words)));
    CALL(K(process_init)(&m->process, A, B, Q));
}

static inline void put_sensor(sensor_model *s, int n, int m, const num *range, const num *measured_range,
                              const num *H, const num *R)
{
    (void)range, (void)measured_range;
    ASSERT_OK(K(sensor_assign)(&s->sensor, n, m, s->words, COUNT(s->words)));
    CALL(K(sensor_init)(&s->sensor, H, R));
}

static inline void put_independent(sensor_model *s, int n, int m, const num *range, const num *measured_range,
                                   const num *H, const num *r)
{
    (void)range, (void)measured_range;
    ASSERT_OK(K(sensor_assign)(&s->sensor, n, m, s->words, COUNT(s->words)));
    CALL(K(sensor_init_diagonal)(&s->sensor, H, r));
}

/* r: the variances that the model was made of */
static inline kq_status init_lean(sensor_model *s, const num *r)
{
    return K(sensor_init_lean)(&s->sensor, s->sensor.measurement, r);
}

/* The model's process becomes that of `source` with its noise times q. */
static inline kq_status scale_noise(process_model *m, process_model *source, num q)
{
    return K(process_scale_noise)(&m->process, &source->process, q);
}

/* Smoothed with the noise of `source` times q[t], through `target` */
static inline kq_status smooth_reweighted(K(history) *h, process_model *target, process_model *source, num nu, num *q)
{
    return K(smooth_reweighted)(h, &target->process, &source->process, nu, q);
}

/* Another A, another H: the arrays given */
static inline kq_status change_transition(process_model *m, int n, const num *A)
{
    (void)n;
    return K(process_change_transition)(&m->process, A);
}

static inline kq_status change_measurement(sensor_model *s, int n, int m, const num *H)
{
    (void)n, (void)m;
    return K(sensor_change_measurement)(&s->sensor, H);
}

static inline void put_prior(prior_model *p, int n, const num *range, const num *x, const num *P)
{
    (void)n, (void)range;
    *p = (prior_model){x, P};
}

/* Like the model's sensor, which stays; the last one that was made */
static inline const K(sensor) *of_innovations(sensor_model *s)
{
    static K(sensor) made;
    static num words[KQ_SENSOR_LEN(MAX)];
    ASSERT_OK(K(sensor_assign)(&made, s->sensor.states, s->sensor.components, words, COUNT(words)));
    if (s->sensor.covariance) ASSERT_OK(K(sensor_init_extended)(&made, s->sensor.measurement, s->sensor.covariance));
    else ASSERT_OK(K(sensor_init_diagonal_extended)(&made, s->sensor.measurement, s->sensor.noise));
    return &made;
}

/* A lean one of the same rows; r: the variances that the model was made of */
static inline const K(sensor) *lean_of_innovations(sensor_model *s, const num *r)
{
    static K(sensor) made;
    static num words[KQ_SENSOR_DIAGONAL_LEN(MAX)];
    ASSERT_OK(K(sensor_assign)(&made, s->sensor.states, s->sensor.components, words, COUNT(words)));
    ASSERT_OK(K(sensor_init_lean_extended)(&made, s->sensor.measurement, r));
    return &made;
}

static inline kq_status init_filter(K(filter) *f, const prior_model *p)
{
    return K(filter_init)(f, p->mean, p->covariance);
}

static inline kq_status init_start(K(diffuse) *s, K(filter) *f, const prior_model *p, uint32_t unknown)
{
    return K(diffuse_init)(s, f, p->mean, p->covariance, unknown);
}

/* The number that a mean's or a sigma's word stands for */
static inline double word_value(const prior_model *p, num a, int i)
{
    (void)p, (void)i;
    return (double)a;
}

/* P_ij of an entry */
static inline double entry_value(const prior_model *p, num a, int i, int j)
{
    (void)p, (void)i, (void)j;
    return (double)a;
}

static inline const num *measured(const K(sensor) *s, const num *z)
{
    (void)s;
    return z;
}

/* An increment of the mean */
static inline const num *moved_by(const process_model *m, const num *d)
{
    (void)m;
    return d;
}

/* The number of a component's word */
static inline double measured_value(const K(sensor) *s, num a, int c)
{
    (void)s, (void)c;
    return (double)a;
}

static inline const num *driven(const K(process) *p, const num *u, int steps)
{
    (void)p, (void)steps;
    return u;
}

static inline num score_of(double a) { return N(a); }
static inline double score_number(num a) { return (double)a; }
static inline num number(double a) { return N(a); }
static inline double number_of(num a) { return (double)a; }

static inline void read_now(reading *r, const K(filter) *f, int n) { read_filter(r, f, n); }

static inline void read_shown(reading *r, const K(filter) *view, const prior_model *p, int n)
{
    (void)p;
    read_view(r, view, n);
}

/* Where there may be no covariance */
static inline double shown_mean(const K(filter) *view, const prior_model *p, int i)
{
    (void)p;
    return (double)K(mean)(view, i) + (double)K(mean_low)(view, i);
}

/* Beside its own last bit nothing is rounded. */
static inline double score_step(void) { return 0; }
static inline double smoother_step(void) { return 0; }

static inline double sigma_step(num range)
{
    (void)range;
    return 0;
}

static inline double score_rounding(double score, int terms)
{
    (void)terms;
    return TOLERANCE * (4 + fabs(score));
}

static inline kq_status read_gain(const K(filter) * f, const K(sensor) * s, num *gain)
{
    return K(gain)(f, s, gain);
}

static inline kq_status read_measurement(const K(filter) * f, const K(sensor) * s, num *z, num *S)
{
    return K(measurement)(f, s, z, S);
}

static inline kq_status read_innovation(const K(filter) * f, const K(sensor) * s, const num *z, num *e)
{
    return K(innovation)(f, s, z, e);
}

static inline kq_status step_back(K(history) *h, K(process) *by, const prior_model *p, num *lag_one, num *mean,
                                  num *covariance)
{
    const K(smooth_extras) extras = {lag_one, mean, covariance};
    (void)p;
    return K(smooth_step)(h, by, &extras);
}

static inline kq_status read_noise(const K(history) *h, int k, num *mean, num *variance)
{
    return K(smoothed_measurement_noise)(h, k, mean, variance);
}

#endif
