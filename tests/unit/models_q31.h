/* Models in fixed point (models.h). */
#ifndef KALMANQ_TESTS_MODELS_Q31_H
#define KALMANQ_TESTS_MODELS_Q31_H

#include "q31.h"

#include "reading.h"

typedef int32_t word;
typedef kq_scaled_q31 entry;
typedef int64_t score;

#define S(name) kq_##name##_q31
#define S_IN_T(name) name##_Q31

/* What filter.h says of one call, (2n + 4) 2^-29 for n = 2.  The gain of three runs is the same
   in laws: their means are products of mantissas of 31 bits.  And the mean is summed up whole. */
#define ROUNDING 0x1p-26
#define ROUNDING_OF_MEANS 0x1p-29
#define ROUNDING_IN_TURN 0.0

#define S_FREEZE_LEN KQ_FREEZE_LEN_Q31
#define S_STEADY_LEN KQ_STEADY_LEN_Q31
#define S_ROOT_LEN KQ_ROOT_LEN_Q31
#define ASSIGN_ADAPTATION(a, n, m) kq_adaptation_assign_q31(&a, n, m, a##_memory, COUNT(a##_memory), a##_root)

/* What is refused as a measurement, and how */
#define NOT_A_NUMBER KQ_ERR_RANGE
static inline int32_t bad_word(const kq_sensor_q31 *s, int k)
{
    const int32_t end = s->measurement_format[0].range;
    const int32_t bad[] = {end + 1, -end - 1, INT32_MAX, INT32_MIN};
    return bad[k];
}

/* What is refused as a parameter or a factor, and how */
#define NOT_AN_ENTRY KQ_ERR_COEFFICIENT
#define NO_VARIANCE KQ_ERR_TABLE
static inline kq_scaled_q31 bad_entry(int k)
{
    static const kq_scaled_q31 bad[] = {{1, 0}, {INT32_MIN, -31}, {(1 << 30) - 1, -30}, {0, 1}};
    return bad[k];
}

static inline kq_scaled_q31 just_above_1(void) { return (kq_scaled_q31){(1 << 30) + 1, -30}; }

static inline int is_nothing(int32_t a) { return a == KQ_NOT_A_VALUE_Q31; }
static inline int is_no_score(int64_t a) { return a == KQ_NOT_A_SCORE_Q31; }

#define ASSERT_SAME(a, b, n) ASSERT_SAME_Q31(a, b)

static inline void put_independent(sensor_model *s, int n, int m, const double *range,
                                   const double *measured_range, const double *H, const double *r)
{
    static double identity[MAX * MAX];
    for (int k = 0; k < m * m; k++) identity[k] = k % (m + 1) ? 0 : 1;
    put_sensor(s, n, m, range, measured_range, H, identity);
    s->table.correlated = 0;
    ASSERT_OK(kq_noise_prepare_diagonal_q31(s->noise, r, m, s->measurement_format));
    ASSERT_OK(kq_sensor_init_diagonal_q31(&s->sensor, &s->table, NULL));
}

/* Of the variances that the model was made of */
static inline kq_status init_lean(sensor_model *s, const double *r)
{
    (void)r;
    return kq_sensor_init_lean_q31(&s->sensor, &s->table, NULL);
}

/* The model's process becomes that of `source` with its noise times q. */
static inline kq_status scale_noise(process_model *m, process_model *source, kq_scaled_q31 q)
{
    return kq_process_scale_noise_q31(&m->process, &source->process, m->noise_root, q);
}

/* Smoothed with the noise of `source` times q[t], through `target` */
static inline kq_status smooth_reweighted(kq_history_q31 *h, process_model *target, process_model *source,
                                          kq_scaled_q31 nu, kq_scaled_q31 *q)
{
    return kq_smooth_reweighted_q31(h, &target->process, &source->process, target->noise_root, nu, q);
}

/* Another A, in the model's own table; another H, in another one */
static inline kq_status change_transition(process_model *m, int n, const double *A)
{
    ASSERT_OK(kq_matrix_prepare_q31(m->transition, A, n, n, m->state_format, m->state_format));
    return kq_process_change_transition_q31(&m->process, m->transition, NULL);
}

static inline kq_status change_measurement(sensor_model *s, int n, int m, const double *H)
{
    static kq_scaled_q31 other[MAX * MAX]; /* new numbers in the same array are not noticed (steady.h) */
    ASSERT_OK(kq_matrix_prepare_q31(other, H, m, n, s->measurement_format, s->state_format));
    return kq_sensor_change_measurement_q31(&s->sensor, other, NULL);
}

/* Like the model's sensor, which stays; the last one that was made */
static inline const kq_sensor_q31 *of_innovations(sensor_model *s)
{
    static kq_sensor_q31 made;
    if (s->table.correlated) ASSERT_OK(kq_sensor_init_extended_q31(&made, &s->table, NULL));
    else ASSERT_OK(kq_sensor_init_diagonal_extended_q31(&made, &s->table, NULL));
    return &made;
}

/* A lean one of the same rows and variances */
static inline const kq_sensor_q31 *lean_of_innovations(sensor_model *s, const double *r)
{
    static kq_sensor_q31 made;
    (void)r;
    ASSERT_OK(kq_sensor_init_lean_extended_q31(&made, &s->table, NULL));
    return &made;
}

static inline kq_status init_filter(kq_filter_q31 *f, const prior_model *p)
{
    return kq_filter_init_q31(f, &p->table, NULL);
}

static inline kq_status init_start(kq_diffuse_q31 *s, kq_filter_q31 *f, const prior_model *p, uint32_t unknown)
{
    return kq_diffuse_init_q31(s, f, &p->table, unknown, NULL);
}

/* The number that a mean's or a sigma's word stands for */
static inline double word_value(const prior_model *p, int32_t a, int i)
{
    return ldexp(a, -p->state_format[i].fraction);
}

/* P_ij of an entry */
static inline double entry_value(const prior_model *p, kq_scaled_q31 a, int i, int j)
{
    return value_of(a, p->state_format[i].fraction + p->state_format[j].fraction);
}

static inline const int32_t *measured(const kq_sensor_q31 *s, const double *z)
{
    static int32_t words[MAX];
    memcpy(words, words_of(z, s->components, s->measurement_format), sizeof(int32_t) * s->components);
    return words;
}

/* An increment of the mean */
static inline const int32_t *moved_by(const process_model *m, const double *d)
{
    return words_of(d, m->process.states, m->state_format);
}

/* The number of a component's word */
static inline double measured_value(const kq_sensor_q31 *s, int32_t a, int c)
{
    return ldexp(a, -s->measurement_format[c].fraction);
}

/* All controls of each step; at most DRIVEN of them */
static inline const int32_t *driven(const kq_process_q31 *p, const double *u, int steps)
{
    enum { DRIVEN = 16 };
    static int32_t words[DRIVEN];
    for (int k = 0; u && k < steps * p->controls; k++) words[k] = *words_of(u + k, 1, p->control_format + k % p->controls);
    return u ? words : NULL;
}

static inline int64_t score_of(double a) { return (int64_t)ldexp(a, 24); }
static inline double score_number(int64_t a) { return score_value(a); }

static inline kq_scaled_q31 number(double a)
{
    int exponent = 0;
    const double m = frexp(a, &exponent);
    return a == 0 ? (kq_scaled_q31){0, 0} : (kq_scaled_q31){(int32_t)(m * 0x1p30) * 2, exponent - 31};
}

static inline double number_of(kq_scaled_q31 a) { return ldexp(a.mantissa, a.exponent); }

static inline double read_word(int32_t a, int more, const kq_format_q31 *format)
{
    return ldexp(a, -format->fraction - more);
}

/* r x c numbers, of the fractions of their rows and `sign` times those of their columns */
static inline void read_matrix(double *to, const kq_scaled_q31 *a, int r, int c, const kq_format_q31 *row,
                               const kq_format_q31 *column, int sign)
{
    for (int k = 0; k < r * c; k++) {
        to[k] = value_of(a[k], row[k / c].fraction + sign * column[k % c].fraction);
    }
}

static inline void read_state(reading *r, const kq_filter_q31 *f, const kq_format_q31 *format, int n)
{
    kq_scaled_q31 P[MAX * MAX];
    memset(r, 0, sizeof *r);
    for (int k = 0; k < n; k++) {
        r->mean[k] = read_word(kq_mean_q31(f, k), 0, format + k);
        r->low[k] = read_word(kq_mean_low_q31(f, k), 24, format + k);
        r->sigma[k] = read_word(kq_sigma_q31(f, k), 0, format + k);
    }
    ASSERT_OK(kq_covariance_q31(f, P));
    read_matrix(r->P, P, n, n, format, format, 1);
}

static inline void read_now(reading *r, const kq_filter_q31 *f, int n)
{
    read_state(r, f, f->state_format, n);
    r->nis = score_value(kq_nis_q31(f));
    r->last = score_value(kq_log_likelihood_last_q31(f));
    r->run = score_value(kq_log_likelihood_q31(f));
    r->taken = kq_taken_q31(f);
    r->events = kq_events_q31(f);
}

static inline void read_shown(reading *r, const kq_filter_q31 *view, const prior_model *p, int n)
{
    read_state(r, view, p->state_format, n);
}

/* Where there may be no covariance */
static inline double shown_mean(const kq_filter_q31 *view, const prior_model *p, int i)
{
    return read_word(kq_mean_q31(view, i), 0, p->state_format + i) +
           read_word(kq_mean_low_q31(view, i), 24, p->state_format + i);
}

/* what NIS and log-likelihoods are rounded to */
static inline double score_step(void) { return score_value(1); }

static inline double score_rounding(double score, int terms)
{
    (void)score;
    return terms * score_step();
}

/* the last bit of a smoothed mean's coordinates, in standard deviations */
static inline double smoother_step(void) { return 0x1p-40; }

/* what sigma is rounded to */
static inline double sigma_step(double range)
{
    kq_format_q31 format;
    put_formats(&format, &range, 1);
    return read_word(1, 0, &format);
}

static inline kq_status read_gain(const kq_filter_q31 *f, const kq_sensor_q31 *s, double *gain)
{
    kq_scaled_q31 K[MAX * MAX];
    const kq_status status = kq_gain_q31(f, s, K);
    if (status) return status;
    read_matrix(gain, K, f->states, s->components, f->state_format, s->measurement_format, -1);
    return KQ_OK;
}

static inline kq_status read_measurement(const kq_filter_q31 *f, const kq_sensor_q31 *s, double *z,
                                  double *covariance)
{
    int32_t words[MAX];
    kq_scaled_q31 scaled[MAX * MAX];
    const kq_format_q31 *format = s->measurement_format;
    const int m = s->components;
    const kq_status status = kq_measurement_q31(f, s, words, scaled);
    if (status) return status;
    for (int c = 0; c < m; c++) z[c] = read_word(words[c], 0, format + c);
    read_matrix(covariance, scaled, m, m, format, format, 1);
    return KQ_OK;
}

static inline kq_status read_innovation(const kq_filter_q31 *f, const kq_sensor_q31 *s, const int32_t *z,
                                 double *e)
{
    int32_t words[MAX];
    const kq_status status = kq_innovation_q31(f, s, z, words);
    if (status) return status;
    for (int c = 0; c < s->components; c++) {
        e[c] = read_word(words[c], 0, s->measurement_format + c);
    }
    return KQ_OK;
}

/* The last step writes no extras: they are read as 0. */
static inline kq_status step_back(kq_history_q31 *h, kq_process_q31 *by, const prior_model *p, double *lag_one,
                                  double *mean, double *covariance)
{
    kq_scaled_q31 lag[MAX * MAX] = {{0, 0}}, noise[MAX] = {{0, 0}}, spread[MAX * MAX] = {{0, 0}};
    const kq_smooth_extras_q31 extras = {lag, noise, spread};
    const kq_format_q31 *format = p->state_format;
    const int n = h->states;
    const kq_status status = kq_smooth_step_q31(h, by, &extras);
    if (status) return status;
    read_matrix(lag_one, lag, n, n, format, format, 1);
    read_matrix(mean, noise, n, 1, format, format, 0);
    read_matrix(covariance, spread, n, n, format, format, 1);
    return KQ_OK;
}

static inline kq_status read_noise(const kq_history_q31 *h, int k, double *mean, double *variance)
{
    kq_scaled_q31 pair[2];
    const kq_status status = kq_smoothed_measurement_noise_q31(h, k, pair, pair + 1);
    if (status) return status;
    *mean = value_of(pair[0], 0);
    *variance = value_of(pair[1], 0);
    return KQ_OK;
}

#endif
