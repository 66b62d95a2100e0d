/*
 * A model in doubles and the same one in q31, for up to 3 states, controls and components, so that
 * the q31 arithmetic can be held against the textbook and against the library in double.
 *
 * `num` and K(...) are those of f64 here (arithmetic.h).
 */
#ifndef KALMANQ_TESTS_Q31_H
#define KALMANQ_TESTS_Q31_H

#define KQ_TEST_F64
#include "arithmetic.h"
#include "kalmanq/prepare.h"

#define MAX 4

typedef struct {
    kq_format_q31 state_format[MAX], control_format[MAX];
    kq_scaled_q31 transition[MAX * MAX], control[MAX * MAX];
    int32_t noise_root[KQ_ROOT_LEN_Q31(MAX)];
    kq_process_table_q31 table;
    kq_process_q31 process;
} process_model;

typedef struct {
    kq_format_q31 state_format[MAX], measurement_format[MAX];
    kq_scaled_q31 measurement[MAX * MAX], noise[KQ_TRIANGLE(MAX)];
    kq_sensor_table_q31 table;
    kq_sensor_q31 sensor;
} sensor_model;

typedef struct {
    kq_format_q31 state_format[MAX];
    int32_t mean[MAX], root[KQ_ROOT_LEN_Q31(MAX)];
    kq_prior_table_q31 table;
} prior_model;

static inline void put_formats(kq_format_q31 *format, const double *range, int count)
{
    for (int i = 0; i < count; i++) ASSERT_OK(kq_format_prepare_q31(&format[i], KQ_FRACTION_BEST_Q31, range[i], NULL));
}

/* B may be NULL */
static inline void put_process(process_model *m, int n, int l, const double *range,
                               const double *drive_range, const double *A, const double *B,
                               const double *Q)
{
    put_formats(m->state_format, range, n);
    put_formats(m->control_format, drive_range, l);
    ASSERT_OK(kq_matrix_prepare_q31(m->transition, A, n, n, m->state_format, m->state_format));
    if (l) {
        ASSERT_OK(kq_matrix_prepare_q31(m->control, B, n, l, m->state_format, m->control_format));
    }
    ASSERT_OK(kq_root_prepare_q31(m->noise_root, Q, n, m->state_format));
    m->table = (kq_process_table_q31){.states = n,
                                      .controls = l,
                                      .state_format = m->state_format,
                                      .control_format = m->control_format,
                                      .transition = m->transition,
                                      .control = m->control,
                                      .noise_root = m->noise_root};
    ASSERT_OK(kq_process_init_q31(&m->process, &m->table, NULL));
}

/* R: m x m */
static inline void put_sensor(sensor_model *s, int n, int m, const double *range,
                              const double *measured_range, const double *H, const double *R)
{
    put_formats(s->state_format, range, n);
    put_formats(s->measurement_format, measured_range, m);
    ASSERT_OK(
        kq_matrix_prepare_q31(s->measurement, H, m, n, s->measurement_format, s->state_format));
    ASSERT_OK(kq_noise_prepare_q31(s->noise, R, m, s->measurement_format));
    s->table = (kq_sensor_table_q31){.states = n,
                                     .components = m,
                                     .correlated = 1,
                                     .state_format = s->state_format,
                                     .measurement_format = s->measurement_format,
                                     .measurement = s->measurement,
                                     .noise = s->noise};
    ASSERT_OK(kq_sensor_init_q31(&s->sensor, &s->table, NULL));
}

static inline void put_prior(prior_model *p, int n, const double *range, const double *x,
                             const double *P)
{
    put_formats(p->state_format, range, n);
    ASSERT_OK(kq_vector_prepare_q31(p->mean, x, n, p->state_format, NULL));
    ASSERT_OK(kq_root_prepare_q31(p->root, P, n, p->state_format));
    p->table = (kq_prior_table_q31){
        .states = n, .state_format = p->state_format, .mean = p->mean, .root = p->root};
}

/* Words of doubles in the formats, for a measurement or a control */
static inline const int32_t *words_of(const double *z, int count, const kq_format_q31 *format)
{
    static int32_t words[MAX];
    ASSERT_OK(kq_vector_prepare_q31(words, z, count, format, NULL));
    return words;
}

/* a 2^-fraction */
static inline double value_of(kq_scaled_q31 a, int fraction)
{
    return ldexp(a.mantissa, a.exponent - fraction);
}

static inline double score_value(int64_t score) { return ldexp((double)score, -24); }

/* x_i of f, in its unit, and P_ij */
static inline double mean_value(const kq_filter_q31 *f, int i)
{
    const double words = kq_mean_q31(f, i) + ldexp(kq_mean_low_q31(f, i), -24);
    return ldexp(words, -f->state_format[i].fraction);
}

static inline void covariance_values(const kq_filter_q31 *f, const kq_format_q31 *format, double *P)
{
    kq_scaled_q31 words[MAX * MAX];
    const int n = f->states;
    ASSERT_OK(kq_covariance_q31(f, words));
    for (int k = 0; k < n * n; k++) {
        P[k] = value_of(words[k], format[k / n].fraction + format[k % n].fraction);
    }
}

/* As the filter in double, up to `tolerance` of the numbers' sizes */
static inline void assert_like(const K(filter) * expected, const kq_filter_q31 *actual,
                               double tolerance, UNITY_LINE_TYPE line)
{
    double P[MAX * MAX], Q[MAX * MAX];
    const int n = actual->states;
    ASSERT_OK(K(covariance)(expected, P));
    covariance_values(actual, actual->state_format, Q);
    for (int i = 0; i < n; i++) {
        const double mean = K(mean)(expected, i), sigma = sqrt(P[i * n + i]);
        assert_within(tolerance * (sigma + fabs(mean)), mean, mean_value(actual, i), line);
        for (int j = 0; j < n; j++) {
            const double size = sigma * sqrt(P[j * n + j]);
            assert_within(tolerance * size, P[i * n + j], Q[i * n + j], line);
        }
    }
}

#define ASSERT_LIKE(expected, actual, tolerance) assert_like(expected, actual, tolerance, __LINE__)

/* All of a filter's memory and what the last update told, bit for bit */
static inline void assert_same_q31(const kq_filter_q31 *a, const kq_filter_q31 *b,
                                   UNITY_LINE_TYPE line)
{
    const size_t bytes = sizeof(int32_t) * (size_t)KQ_FILTER_LEN_Q31(a->states);
    UNITY_TEST_ASSERT(memcmp(a->memory, b->memory, bytes) == 0, line, "the two states differ");
    UNITY_TEST_ASSERT(a->events == b->events, line, "the two events differ");
    UNITY_TEST_ASSERT(memcmp(&a->last, &b->last, sizeof a->last) == 0 &&
                          memcmp(&a->run, &b->run, sizeof a->run) == 0,
                      line, "what the two filters tell differs");
}

#define ASSERT_SAME_Q31(a, b) assert_same_q31(a, b, __LINE__)

#endif
