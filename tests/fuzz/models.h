/*
 * Random models of the q31 arithmetic: entries of A, G, H, R and P0 spread over tens of decades,
 * in formats of any kind, brought to what the overflow check allows and through prepare.h.
 */
#ifndef KALMANQ_FUZZ_MODELS_H
#define KALMANQ_FUZZ_MODELS_H

#include <string.h>

#include "kalmanq/kalmanq.h"
#include "kalmanq/prepare.h"
#include "random.h"

#define SENSORS 3
#define PROCESSES 2

/* The arrays of the tables are the model's own, to be written to by who corrupts them. */
typedef struct {
    int n, sensors;
    kq_format_q31 *state_format;
    kq_process_table_q31 process_table[PROCESSES];
    kq_sensor_table_q31 sensor_table[SENSORS];
    kq_prior_table_q31 prior;
    kq_process_q31 process[PROCESSES];
    kq_sensor_q31 sensor[SENSORS];
} model;

/* Room for arrays: exact, or (to be corrupted in its sizes too) of the largest model */
static int room_is_largest;

static inline int room(int size) { return room_is_largest ? KQ_SIZE_MAX : size; }

static void must(kq_status status, const char *what)
{
    if (status == KQ_OK) return;
    fflush(stdout);
    fprintf(stderr, "%s: refused with %d\n", what, (int)status);
    abort();
}

static kq_format_q31 *random_formats(int count)
{
    kq_format_q31 *format = TAKE(kq_format_q31, room(count));
    for (int i = 0; i < room(count); i++) {
        const int32_t size = (int32_t)(INT32_MAX * (chance(0.3) ? pow(2, -20 * uniform()) : 1));
        format[i].range = size < 1 ? 1 : size;
        format[i].fraction =
            chance(0.2) ? between(KQ_FRACTION_MIN_Q31, KQ_FRACTION_MAX_Q31) : between(0, 31);
    }
    return format;
}

/* Every row's sum of magnitudes below 16, often just below: row i of `count` entries M and of
   `more` entries B. */
static void limit_row(double *M, int count, double *B, int more)
{
    double total = 0;
    for (int k = 0; k < count; k++) total += fabs(M[k]);
    for (int k = 0; k < more; k++) total += fabs(B[k]);
    const double most = chance(0.4) ? uniform() : chance(0.6) ? 1 + uniform() : 15.9999 * uniform();
    if (total <= most) return;
    for (int k = 0; k < count; k++) M[k] *= most / total;
    for (int k = 0; k < more; k++) B[k] *= most / total;
}

/* M in words -> M in physical units: exact */
static void to_units(double *M, int rows, int columns, const kq_format_q31 *row,
                     const kq_format_q31 *column)
{
    for (int k = 0; k < rows * columns; k++) {
        M[k] = ldexp(M[k], column[k % columns].fraction - row[k / columns].fraction);
    }
}

static void random_transition(double *A, double *B, int n, int l)
{
    const double density = uniform(), spread = chance(0.5) ? 3 : 20;
    const int unit = chance(0.5), triangular = chance(0.3);
    for (int k = 0; k < n * n; k++) {
        A[k] = chance(density) ? normal() * decades(spread) : 0;
        if (triangular && k / n > k % n) A[k] = 0;
    }
    for (int i = 0; unit && i < n; i++) A[i * n + i] = 1;
    for (int k = 0; k < n * l; k++) B[k] = chance(0.5) ? normal() * decades(4) : 0;
    for (int i = 0; i < n; i++) limit_row(A + i * n, n, B + i * l, l);
}

/* F, n x r, in physical units of rows of the formats */
static void random_factor(double *F, int n, int r, double row_spread, double spread, double size,
                          const kq_format_q31 *format)
{
    for (int i = 0; i < n; i++) {
        const double row = chance(0.1) ? 0 : size * decades(row_spread);
        for (int k = 0; k < r; k++) {
            F[i * r + k] = chance(0.6) ? normal() * row * decades(spread) : 0;
            F[i * r + k] = ldexp(F[i * r + k], -format[i].fraction);
        }
    }
}

static void square_of(double *P, const double *F, int n, int r)
{
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            double sum = 0;
            for (int k = 0; k < r; k++) sum += F[i * r + k] * F[j * r + k];
            P[i * n + j] = sum;
        }
    }
}

/* The root of a random covariance, by its factor or by itself.  `size`: words of its sigmas */
static int32_t *random_root(int n, double size, const kq_format_q31 *format)
{
    double F[KQ_SIZE_MAX * KQ_SIZE_MAX], P[KQ_SIZE_MAX * KQ_SIZE_MAX];
    int32_t *root = TAKE(int32_t, KQ_ROOT_LEN_Q31(room(n)));
    const int r = chance(0.1) ? 0 : chance(0.5) ? n : between(1, n);
    random_factor(F, n, r, 16, chance(0.5) ? 2 : 12, size, format);
    square_of(P, F, n, r);
    if (chance(0.3) && kq_root_prepare_q31(root, P, n, format) == KQ_OK) return root;
    must(kq_root_prepare_factor_q31(root, F, n, r, format), "kq_root_prepare_factor_q31");
    return root;
}

static void random_process(model *m, int which)
{
    double A[KQ_SIZE_MAX * KQ_SIZE_MAX], B[KQ_SIZE_MAX * KQ_SIZE_MAX];
    const int n = m->n, l = chance(0.5) ? 0 : chance(0.1) ? between(1, 16) : between(1, 3);
    kq_format_q31 *controls = random_formats(l);
    kq_scaled_q31 *a = TAKE(kq_scaled_q31, room(n) * room(n));
    kq_scaled_q31 *b = TAKE(kq_scaled_q31, room(n) * room(l));
    random_transition(A, B, n, l);
    to_units(A, n, n, m->state_format, m->state_format);
    if (l) to_units(B, n, l, m->state_format, controls);
    must(kq_matrix_prepare_q31(a, A, n, n, m->state_format, m->state_format), "A");
    if (l) must(kq_matrix_prepare_q31(b, B, n, l, m->state_format, controls), "B");
    m->process_table[which] = (kq_process_table_q31){
        .states = n,
        .controls = l,
        .state_format = m->state_format,
        .control_format = l || room_is_largest ? controls : NULL,
        .transition = a,
        .control = l || room_is_largest ? b : NULL,
        .noise_root = random_root(n, chance(0.1) ? 0 : decades(6), m->state_format)};
    must(kq_process_init_q31(&m->process[which], &m->process_table[which], NULL), "process");
}

static int random_noise(kq_scaled_q31 *noise, int c, const kq_format_q31 *format)
{
    double R[KQ_SIZE_MAX * KQ_SIZE_MAX], L[KQ_SIZE_MAX * KQ_SIZE_MAX];
    if (chance(0.6)) {
        for (int k = 0; k < c; k++) {
            R[k] = chance(0.1) ? 0 : ldexp(decades(30), -2 * format[k].fraction);
        }
        must(kq_noise_prepare_diagonal_q31(noise, R, c, format), "r");
        return 0;
    }
    const int rank = chance(0.7) ? c : between(1, c);
    random_factor(L, c, rank, chance(0.5) ? 1 : 6, chance(0.5) ? 0 : 4, decades(10), format);
    square_of(R, L, c, rank);
    if (kq_noise_prepare_q31(noise, R, c, format) == KQ_OK) return 1;
    memset(noise, 0, sizeof *noise * (size_t)KQ_TRIANGLE(c)); /* beyond rounding: noise-free */
    return 1;
}

static void random_sensor(model *m, int which)
{
    double H[KQ_SIZE_MAX * KQ_SIZE_MAX];
    const int n = m->n, c = chance(0.05) ? between(5, 16) : between(1, 4);
    kq_format_q31 *format = random_formats(c);
    kq_scaled_q31 *h = TAKE(kq_scaled_q31, room(c) * room(n));
    kq_scaled_q31 *noise = TAKE(kq_scaled_q31, KQ_TRIANGLE(room(c)));
    const double spread = chance(0.5) ? 4 : 20;
    for (int k = 0; k < c * n; k++) H[k] = chance(0.5) ? normal() * decades(spread) : 0;
    for (int i = 0; i < c; i++) limit_row(H + i * n, n, NULL, 0);
    if (chance(0.1)) memcpy(H + (c - 1) * n, H, sizeof *H * (size_t)n); /* redundant */
    to_units(H, c, n, format, m->state_format);
    must(kq_matrix_prepare_q31(h, H, c, n, format, m->state_format), "H");
    const int correlated = random_noise(noise, c, format);
    m->sensor_table[which] = (kq_sensor_table_q31){.states = n,
                                                   .components = c,
                                                   .correlated = correlated,
                                                   .state_format = m->state_format,
                                                   .measurement_format = format,
                                                   .measurement = h,
                                                   .noise = noise};
    must(kq_sensor_init_q31(&m->sensor[which], &m->sensor_table[which], NULL), "sensor");
}

static void random_prior(model *m)
{
    int32_t *mean = TAKE(int32_t, room(m->n));
    for (int i = 0; i < m->n; i++) mean[i] = random_word(m->state_format[i].range);
    m->prior = (kq_prior_table_q31){.states = m->n,
                                    .state_format = m->state_format,
                                    .mean = mean,
                                    .root = random_root(m->n, decades(16), m->state_format)};
}

static void random_model(model *m)
{
    m->n = chance(0.05) ? between(10, 16) : between(1, 9);
    m->sensors = between(1, SENSORS);
    m->state_format = random_formats(m->n);
    for (int k = 0; k < PROCESSES; k++) random_process(m, k);
    for (int k = 0; k < m->sensors; k++) random_sensor(m, k);
    random_prior(m);
}

#endif
