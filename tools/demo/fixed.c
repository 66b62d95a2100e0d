/*
 * q31: every component in the format of its range, whatever has no range as mantissa and
 * exponent (fixed_point.h).  Here the tables are made at start-up; firmware may have them in
 * flash.
 */
#include "demo.h"

#include <math.h>

/* As check; a range that does not fit is said in the library's words. */
static void check_fit(kq_status status, const kq_misfit_q31 *misfit, const char *what)
{
    char text[80];
    if (status == KQ_ERR_RANGE && misfit->bits > 0) {
        kq_misfit_text_q31(misfit, text, sizeof text);
        fail("%s: %s", what, text);
    }
    check(status, what);
}

static kq_format_q31 *formats(const double *range, int count, const char *what)
{
    kq_format_q31 *made = allocate((size_t)count, sizeof *made);
    for (int i = 0; i < count; i++) {
        kq_status status = kq_format_prepare_q31(&made[i], range[i]);
        if (status != KQ_OK) {
            fail("%s %d, %g: %s", what, i, range[i], kq_status_text(status));
        }
    }
    return made;
}

static void prepare_process(objects *o, const problem *given)
{
    size_t n = (size_t)given->n, root_length = KQ_ROOT_LEN_Q31(n);
    const kq_format_q31 *x = o->state_format;
    kq_scaled_q31 *A = allocate(n * n, sizeof *A);
    int32_t *G = allocate(root_length, sizeof *G);
    kq_misfit_q31 misfit = {KQ_STATE, 0, 0};

    check(kq_matrix_prepare_q31(A, given->A, given->n, given->n, x, x), "A");
    check(kq_root_prepare_q31(G, given->Q, given->n, x), "Q");
    kq_process_table_q31 table = {
        .states = given->n, .state_format = x, .transition = A, .noise_root = G};
    check_fit(kq_process_init_q31(&o->motion, &table, &misfit), &misfit, "A, Q");
    o->process_bytes = sizeof(process);
    o->model_bytes += n * (sizeof *x + n * sizeof *A) + root_length * sizeof *G;
}

static int is_diagonal(const double *R, int m)
{
    for (int k = 0; k < m * m; k++) {
        if (R[k] != 0 && k / m != k % m) {
            return 0;
        }
    }
    return 1;
}

static void prepare_sensor(objects *o, const problem *given)
{
    int n = given->n, m = given->m, correlated = !is_diagonal(given->R, m);
    const kq_format_q31 *x = o->state_format, *z = o->measurement_format;
    size_t noise_length = correlated ? KQ_TRIANGLE((size_t)m) : (size_t)m;
    kq_scaled_q31 *H = allocate((size_t)(m * n), sizeof *H);
    kq_scaled_q31 *noise = allocate(noise_length, sizeof *noise);
    kq_misfit_q31 misfit = {KQ_MEASUREMENT, 0, 0};
    double variance[KQ_SIZE_MAX];

    for (int c = 0; c < m; c++) {
        variance[c] = given->R[c * m + c];
    }
    check(kq_matrix_prepare_q31(H, given->H, m, n, z, x), "H");
    check(correlated ? kq_noise_prepare_q31(noise, given->R, m, z)
                     : kq_noise_prepare_diagonal_q31(noise, variance, m, z),
          "R");
    kq_sensor_table_q31 table = {.states = n,
                                 .components = m,
                                 .correlated = correlated,
                                 .state_format = x,
                                 .measurement_format = z,
                                 .measurement = H,
                                 .noise = noise};
    check_fit(kq_sensor_init_q31(&o->gauge, &table, &misfit), &misfit, "H, R");
    o->sensor_bytes = sizeof(sensor);
    o->model_bytes += (size_t)m * sizeof *z + ((size_t)(m * n) + noise_length) * sizeof *H;
}

static void prepare_state(objects *o, const problem *given)
{
    int32_t mean[KQ_SIZE_MAX], root[KQ_ROOT_LEN_Q31(KQ_SIZE_MAX)];
    kq_misfit_q31 misfit = {KQ_STATE, 0, 0};

    kq_status status =
        kq_vector_prepare_q31(mean, given->x0, given->n, o->state_format, &misfit);
    misfit.quantity = KQ_STATE;
    check_fit(status, &misfit, "x0");
    check(kq_root_prepare_q31(root, given->P0, given->n, o->state_format), "P0");
    kq_prior_table_q31 table = {given->n, o->state_format, mean, root};
    check_fit(kq_filter_init_q31(&o->track, &table, &misfit), &misfit, "x0, P0");
}

/* A measurement on the grid of its format. */
static int32_t measured_word(const objects *o, const problem *given, size_t t, int c)
{
    double z = given->z[t * (size_t)given->m + (size_t)c];
    int32_t word = 0;
    kq_misfit_q31 misfit = {KQ_MEASUREMENT, 0, 0};
    kq_status status = kq_vector_prepare_q31(&word, &z, 1, &o->measurement_format[c], &misfit);
    if (status != KQ_OK) {
        char what[80];
        misfit.quantity = KQ_MEASUREMENT; /* the call knows one number, not which it is */
        misfit.component = c;
        snprintf(what, sizeof what, "z of step %lu is %g, its range %g", (unsigned long)t, z,
                 given->z_range[c]);
        check_fit(status, &misfit, what);
    }
    return word;
}

static void prepare_measurements(objects *o, const problem *given)
{
    size_t m = (size_t)given->m;
    o->z = allocate(given->steps * m, sizeof *o->z);
    for (size_t t = 0; t < given->steps; t++) {
        for (int c = 0; c < given->m; c++) {
            if (given->present[t] >> c & 1u) {
                o->z[t * m + (size_t)c] = measured_word(o, given, t, c);
            }
        }
    }
}

void prepare_model(objects *o, const problem *given)
{
    o->state_format = formats(given->x_range, given->n, "x_range");
    o->measurement_format = formats(given->z_range, given->m, "z_range");
    prepare_process(o, given);
    prepare_sensor(o, given);
    prepare_state(o, given);
    prepare_measurements(o, given);
}

/* Word and low part, 2^-24 word, in the component's unit. */
static double value_of(int32_t high, int32_t low, const kq_format_q31 *format)
{
    return ldexp((double)high + ldexp(low, -24), -format->fraction);
}

/* Sigmas from a covariance: finer than whole words, and not bounded by them. */
static void read_sigmas(double *sigma, const kq_scaled_q31 *P, int n, const kq_format_q31 *format)
{
    for (int i = 0; i < n; i++) {
        kq_scaled_q31 variance = P[i * n + i];
        sigma[i] = sqrt(ldexp(variance.mantissa, variance.exponent - 2 * format[i].fraction));
    }
}

void state_of(const objects *o, const filter *f, double *mean, double *sigma)
{
    kq_scaled_q31 P[KQ_SIZE_MAX * KQ_SIZE_MAX];
    for (int i = 0; i < o->n; i++) {
        mean[i] = value_of(kq_mean_q31(f, i), kq_mean_low_q31(f, i), &o->state_format[i]);
    }
    check(kq_covariance_q31(f, P), "covariance");
    read_sigmas(sigma, P, o->n, o->state_format);
}

void smoothed_of(const objects *o, size_t t, double *mean, double *sigma)
{
    kq_scaled_q31 P[KQ_SIZE_MAX * KQ_SIZE_MAX];
    for (int i = 0; i < o->n; i++) {
        mean[i] = value_of(kq_smoothed_mean_q31(&o->tape, t, i),
                           kq_smoothed_mean_low_q31(&o->tape, t, i), &o->state_format[i]);
    }
    check(kq_smoothed_covariance_q31(&o->tape, t, P), "smoothed covariance");
    read_sigmas(sigma, P, o->n, o->state_format);
}

void measurement_of(const objects *o, const filter *f, double *mean, double *sigma)
{
    int32_t z[KQ_SIZE_MAX];
    kq_scaled_q31 S[KQ_SIZE_MAX * KQ_SIZE_MAX];
    check(kq_measurement_q31(f, &o->gauge, z, S), "measurement");
    for (int c = 0; c < o->m; c++) {
        mean[c] = value_of(z[c], 0, &o->measurement_format[c]);
    }
    read_sigmas(sigma, S, o->m, o->measurement_format);
}

double log_likelihood_of(const filter *f)
{
    return ldexp((double)kq_log_likelihood_q31(f), -24);
}

void write_formats(const objects *o)
{
    printf("formats state");
    for (int i = 0; i < o->n; i++) {
        printf(" %ld", (long)o->state_format[i].fraction);
    }
    printf(" measurement");
    for (int c = 0; c < o->m; c++) {
        printf(" %ld", (long)o->measurement_format[c].fraction);
    }
    putchar('\n');
}
