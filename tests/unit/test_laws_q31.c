/*
 * The laws in fixed point.  All is read in the states' units, in doubles that hold each word
 * exactly, so that two readings are the same bits where the words are.
 */
#include "q31.h"

#include "laws_model.h"

typedef int32_t word;

#define S(name) kq_##name##_q31
/* What filter.h says of one call, (2n + 4) 2^-29 for n = 2.  The gain of three runs is the same
   here: their means are products of mantissas of 31 bits.  And the mean is summed up whole. */
#define ROUNDING 0x1p-26
#define ROUNDING_OF_MEANS 0x1p-29
#define ROUNDING_IN_TURN 0.0
#define ASSERT_SAME(a, b, n) ASSERT_SAME_Q31(a, b)

static const double drive_range[] = {15};

typedef struct {
    int32_t filter_words[KQ_FILTER_LEN_Q31(3)], tape_words[KQ_HISTORY_LEN_Q31(3, 3, STEPS, 0)];
    prior_model prior; /* whose formats the filter refers to */
    kq_filter_q31 filter;
    kq_history_q31 tape;
} instance;

static void make_process(process_model *m, int n, int l, const double *range, const double *A,
                         const double *B, const double *Q)
{
    before_call();
    put_process(m, n, l, range, drive_range, A, B, Q);
    CALL(kq_process_init_q31(&m->process, &m->table, NULL));
}

static void make_sensor(sensor_model *s, int n, int m, const double *range,
                        const double *measured_range, const double *H, const double *R)
{
    before_call();
    put_sensor(s, n, m, range, measured_range, H, R);
    CALL(kq_sensor_init_q31(&s->sensor, &s->table, NULL));
}

static void make_independent(sensor_model *s, int n, int m, const double *range,
                             const double *measured_range, const double *H, const double *r)
{
    static const double identity[] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    put_sensor(s, n, m, range, measured_range, H, identity);
    s->table.correlated = 0;
    CALL(kq_noise_prepare_diagonal_q31(s->noise, r, m, s->measurement_format));
    CALL(kq_sensor_init_diagonal_q31(&s->sensor, &s->table, NULL));
}

static void make_filter(instance *i, int n, const double *range, const double *x0,
                        const double *P0)
{
    ASSERT_OK(kq_filter_assign_q31(&i->filter, n, i->filter_words, COUNT(i->filter_words)));
    before_call();
    put_prior(&i->prior, n, range, x0, P0);
    CALL(kq_filter_init_q31(&i->filter, &i->prior.table, NULL));
}

static const int32_t *measured(const kq_sensor_q31 *s, const double *z)
{
    return words_of(z, s->components, s->measurement_format);
}

/* One control a step */
static const int32_t *driven(const kq_process_q31 *p, const double *u, int steps)
{
    static int32_t words[STEPS];
    for (int t = 0; u && t < steps; t++) words[t] = *words_of(u + t, 1, p->control_format);
    return u ? words : NULL;
}

/* r x c numbers, of the fractions of their rows and `sign` times those of their columns */
static void read_matrix(double *to, const kq_scaled_q31 *a, int r, int c, const kq_format_q31 *row,
                        const kq_format_q31 *column, int sign)
{
    for (int k = 0; k < r * c; k++) {
        to[k] = value_of(a[k], row[k / c].fraction + sign * column[k % c].fraction);
    }
}

static double read_word(int32_t a, int more, const kq_format_q31 *format)
{
    return ldexp(a, -format->fraction - more);
}

static void read_now(reading *r, const instance *i, int n)
{
    const kq_filter_q31 *f = &i->filter;
    const kq_format_q31 *format = f->state_format;
    memset(r, 0, sizeof *r);
    for (int k = 0; k < n; k++) {
        r->mean[k] = read_word(kq_mean_q31(f, k), 0, format + k);
        r->low[k] = read_word(kq_mean_low_q31(f, k), 24, format + k);
        r->sigma[k] = read_word(kq_sigma_q31(f, k), 0, format + k);
    }
    covariance_values(f, format, r->P);
    r->nis = score_value(kq_nis_q31(f));
    r->last = score_value(kq_log_likelihood_last_q31(f));
    r->run = score_value(kq_log_likelihood_q31(f));
    r->taken = kq_taken_q31(f);
    r->events = kq_events_q31(f);
}

static void read_past(reading *r, const instance *i, size_t t, int n)
{
    kq_scaled_q31 P[MAX * MAX];
    const kq_format_q31 *format = i->prior.state_format;
    memset(r, 0, sizeof *r);
    for (int k = 0; k < n; k++) {
        r->mean[k] = read_word(kq_mean_q31(SMOOTHED_Q31(&i->tape, t), k), 0, format + k);
        r->low[k] = read_word(kq_mean_low_q31(SMOOTHED_Q31(&i->tape, t), k), 24, format + k);
        r->sigma[k] = read_word(kq_sigma_q31(SMOOTHED_Q31(&i->tape, t), k), 0, format + k);
    }
    ASSERT_OK(kq_covariance_q31(SMOOTHED_Q31(&i->tape, t), P));
    read_matrix(r->P, P, n, n, format, format, 1);
}

static double smoothed_value(const instance *i, size_t t, int k)
{
    const kq_format_q31 *format = i->prior.state_format + k;
    return read_word(kq_mean_q31(SMOOTHED_Q31(&i->tape, t), k), 0, format) +
           read_word(kq_mean_low_q31(SMOOTHED_Q31(&i->tape, t), k), 24, format);
}

/* what NIS and log-likelihoods are rounded to */
static double score_step(void) { return score_value(1); }

static double score_rounding(double score, int terms)
{
    (void)score;
    return terms * score_step();
}

/* the last bit of a smoothed mean's coordinates, in standard deviations */
static double smoother_step(void) { return 0x1p-40; }

/* what sigma is rounded to */
static double sigma_step(double range)
{
    kq_format_q31 format;
    put_formats(&format, &range, 1);
    return read_word(1, 0, &format);
}

static kq_status read_gain(const kq_filter_q31 *f, const kq_sensor_q31 *s, double *gain)
{
    kq_scaled_q31 K[MAX * MAX];
    const kq_status status = kq_gain_q31(f, s, K);
    if (status) return status;
    read_matrix(gain, K, f->states, s->components, f->state_format, s->measurement_format, -1);
    return KQ_OK;
}

static kq_status read_measurement(const kq_filter_q31 *f, const kq_sensor_q31 *s, double *z,
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

static kq_status read_innovation(const kq_filter_q31 *f, const kq_sensor_q31 *s, const int32_t *z,
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
static kq_status step_back(instance *i, double *lag_one, double *mean, double *covariance)
{
    kq_scaled_q31 lag[MAX * MAX] = {{0, 0}}, noise[MAX] = {{0, 0}}, spread[MAX * MAX] = {{0, 0}};
    const kq_smooth_extras_q31 extras = {lag, noise, spread};
    const kq_format_q31 *format = i->prior.state_format;
    const int n = i->tape.states;
    const kq_status status = kq_smooth_step_q31(&i->tape, NULL, &extras);
    if (status) return status;
    read_matrix(lag_one, lag, n, n, format, format, 1);
    read_matrix(mean, noise, n, 1, format, format, 0);
    read_matrix(covariance, spread, n, n, format, format, 1);
    return KQ_OK;
}

static kq_status read_noise(const instance *i, double *mean, double *variance)
{
    kq_scaled_q31 pair[2];
    const kq_status status = kq_smoothed_measurement_noise_q31(&i->tape, 0, pair, pair + 1);
    if (status) return status;
    *mean = value_of(pair[0], 0);
    *variance = value_of(pair[1], 0);
    return KQ_OK;
}

#include "laws.h"

/* Data that are words in both formats */
static void round_data(numbers *s)
{
    for (int t = 0; t < STEPS; t++) {
        for (int c = 0; c < 3; c++) s->z[t][c] = ldexp(rint(ldexp(s->z[t][c], 12)), -12);
    }
}

/* more: what the mean is rounded by beside 2^-24 of a word at each call */
static void assert_as_in_finer_format(const reading *fine, const reading *coarse,
                                      const double *range, double more)
{
    /* what the coarser state is rounded by moves the other one */
    const double word = fmax(sigma_step(range[0]), sigma_step(range[1]));
    const double rounding = ldexp(2 * STEPS * word, -24);
    ASSERT_SAME_BITS(fine->P, coarse->P);
    for (int i = 0; i < 2; i++) {
        ASSERT_WITHIN(sigma_step(range[i]), fine->sigma[i], coarse->sigma[i]);
        ASSERT_WITHIN(rounding + more * fine->sigma[i], whole(fine, i), whole(coarse, i));
    }
}

/* A word is what the mean is rounded by, 2^-24 of it at each call: no bit of a covariance or of a
   gain knows the formats. */
static void formats_round_the_mean_alone(void)
{
    static const int x[] = {3, 6}, z[] = {6, 6, 6}, none[] = {0};
    numbers coarse;
    round_data(&plain);
    coarse = plain;
    scale(coarse.range, x, none, 2, 1);
    scale(coarse.measured_range, z, none, 3, 1);
    run(&one, &motion, &plain, &first);
    run(&two, &motion2, &coarse, &second);
    for (int t = 0; t < STEPS; t++) {
        const reading *fine = &first.smoothed[t], *wide = &second.smoothed[t];
        assert_as_in_finer_format(&first.filtered[t], &second.filtered[t], coarse.range, 0);
        assert_as_in_finer_format(fine, wide, coarse.range, STEPS * smoother_step());
        TEST_ASSERT_EQUAL_HEX(0, first.filtered[t].events | second.filtered[t].events);
    }
    ASSERT_SAME_BITS(first.lag_one, second.lag_one);
    ASSERT_SAME_BITS(first.noise_covariance, second.noise_covariance);
    ASSERT_SAME_BITS(first.gain, second.gain);
    ASSERT_SAME_BITS(first.S, second.S);
}

SUITE(laws, set_up)
{
    run_laws();
    Unity.TestFile = __FILE__;
    RUN_TEST(formats_round_the_mean_alone);
}
