/*
 * The q31 filter beside one in Q16.16 on the same data.
 *   cost accuracy               a line for each model and filter: model n m filter, the largest
 *                               error of x (in sigma) and of P (in sigma_i sigma_j) against a
 *                               textbook filter in long double, steps whose P is semi-definite
 *   cost run FILTER MODEL STEPS the steps and nothing else, to have their instructions counted
 */
#include "models.h"
#include "q16_filter.h"

#include <kalmanq/kalmanq.h>
#include <kalmanq/prepare.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef long double real;

/* What a filter knows: the mean and the covariance */
typedef struct {
    real x[STATES], P[STATES * STATES];
} estimate;

static void need(int status, const char *what)
{
    if (status == 0) return;
    fprintf(stderr, "cost: %s: %d\n", what, status);
    exit(2);
}

/* Q = F F' */
static void process_noise(const model *M, double *Q)
{
    for (int i = 0; i < M->n; i++) {
        for (int j = 0; j < M->n; j++) {
            double total = 0;
            for (int k = 0; k < M->r; k++) total += M->F[i * M->r + k] * M->F[j * M->r + k];
            Q[i * M->n + j] = total;
        }
    }
}

/* ------------------------------------------------------------------ the reference */

static void reference_begin(estimate *e, const model *M)
{
    memset(e, 0, sizeof *e);
    for (int i = 0; i < M->n; i++) e->P[i * M->n + i] = M->P0[i];
}

static void reference_predict(estimate *e, const model *M, const double *Q)
{
    const int n = M->n;
    estimate next = {{0}, {0}};
    real T[STATES * STATES] = {0};
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < n; k++) {
            next.x[i] += (real)M->A[i * n + k] * e->x[k];
            for (int j = 0; j < n; j++) T[i * n + j] += (real)M->A[i * n + k] * e->P[k * n + j];
        }
    }
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            next.P[i * n + j] = Q[i * n + j];
            for (int k = 0; k < n; k++) next.P[i * n + j] += T[i * n + k] * (real)M->A[j * n + k];
        }
    }
    *e = next;
}

static void reference_update(estimate *e, const model *M, const double *z)
{
    const int n = M->n;
    for (int c = 0; c < M->m; c++) {
        real F[STATES] = {0}, s = M->R[c], innovation = z[c];
        for (int k = 0; k < n; k++) {
            for (int i = 0; i < n; i++) F[i] += e->P[i * n + k] * (real)M->H[c * n + k];
        }
        for (int k = 0; k < n; k++) {
            s += (real)M->H[c * n + k] * F[k];
            innovation -= (real)M->H[c * n + k] * e->x[k];
        }
        for (int i = 0; i < n; i++) {
            e->x[i] += F[i] / s * innovation;
            for (int j = 0; j < n; j++) e->P[i * n + j] -= F[i] * F[j] / s;
        }
    }
}

/* ------------------------------------------------------------------ Q16.16 */

static q16_filter narrow_filter;
static q16_process narrow_process;
static q16_sensor narrow_sensor;
static int32_t narrow_z[STEPS][COMPONENTS];

static int32_t q16_of(double a) { return (int32_t)floor(a * 65536 + 0.5); }

static void q16_begin(const model *M, double (*z)[COMPONENTS])
{
    const int n = M->n;
    double Q[STATES * STATES];
    process_noise(M, Q);
    narrow_filter = (q16_filter){.n = n};
    narrow_process = (q16_process){.n = n};
    narrow_sensor = (q16_sensor){.n = n, .m = M->m};
    for (int i = 0; i < n; i++) narrow_filter.P[i * n + i] = q16_of(M->P0[i]);
    for (int k = 0; k < n * n; k++) {
        narrow_process.A[k] = q16_of(M->A[k]);
        narrow_process.Q[k] = q16_of(Q[k]);
    }
    for (int k = 0; k < M->m * n; k++) narrow_sensor.H[k] = q16_of(M->H[k]);
    for (int c = 0; c < M->m; c++) narrow_sensor.R[c] = q16_of(M->R[c]);
    for (int t = 0; t < STEPS; t++) {
        for (int c = 0; c < M->m; c++) narrow_z[t][c] = q16_of(z[t][c]);
    }
}

static void q16_take(int t)
{
    q16_predict(&narrow_filter, &narrow_process);
    q16_update(&narrow_filter, &narrow_sensor, narrow_z[t]);
}

static void q16_read(estimate *e, int n)
{
    for (int i = 0; i < n; i++) e->x[i] = ldexpl(narrow_filter.x[i], -16);
    for (int k = 0; k < n * n; k++) e->P[k] = ldexpl(narrow_filter.P[k], -16);
}

/* ------------------------------------------------------------------ q31 */

static kq_format_q31 state_format[STATES], measurement_format[COMPONENTS];
static kq_scaled_q31 transition[STATES * STATES], measurement[COMPONENTS * STATES];
static kq_scaled_q31 noise[COMPONENTS];
static int32_t noise_root[KQ_ROOT_LEN_Q31(STATES)];
static kq_process_q31 process;
static kq_sensor_q31 sensor;
static kq_filter_q31 filter;
static int32_t filter_memory[KQ_FILTER_LEN_Q31(STATES)];
static int32_t wide_z[STEPS][COMPONENTS];

static void q31_begin_process(const model *M)
{
    const int n = M->n;
    need(kq_matrix_prepare_q31(transition, M->A, n, n, state_format, state_format), "A");
    need(kq_root_prepare_factor_q31(noise_root, M->F, n, M->r, state_format), "Q");
    const kq_process_table_q31 table = {.states = n,
                                        .state_format = state_format,
                                        .transition = transition,
                                        .noise_root = noise_root};
    need(kq_process_init_q31(&process, &table, NULL), "the process");
}

static void q31_begin_sensor(const model *M)
{
    const int n = M->n, m = M->m;
    need(kq_matrix_prepare_q31(measurement, M->H, m, n, measurement_format, state_format), "H");
    need(kq_noise_prepare_diagonal_q31(noise, M->R, m, measurement_format), "R");
    const kq_sensor_table_q31 table = {.states = n,
                                       .components = m,
                                       .state_format = state_format,
                                       .measurement_format = measurement_format,
                                       .measurement = measurement,
                                       .noise = noise};
    need(kq_sensor_init_q31(&sensor, &table, NULL), "the sensor");
}

static void q31_begin_filter(const model *M)
{
    const int n = M->n;
    const int32_t mean[STATES] = {0};
    double P0[STATES * STATES] = {0};
    int32_t root[KQ_ROOT_LEN_Q31(STATES)];
    for (int i = 0; i < n; i++) P0[i * n + i] = M->P0[i];
    need(kq_root_prepare_q31(root, P0, n, state_format), "P0");
    need(kq_filter_assign_q31(&filter, n, filter_memory, KQ_FILTER_LEN_Q31(STATES)), "memory");
    const kq_prior_table_q31 table = {
        .states = n, .state_format = state_format, .mean = mean, .root = root};
    need(kq_filter_init_q31(&filter, &table, NULL), "the filter");
}

static void q31_begin(const model *M, double (*z)[COMPONENTS])
{
    for (int i = 0; i < M->n; i++) {
        need(kq_format_prepare_q31(&state_format[i], KQ_FRACTION_BEST_Q31, M->state_range[i], NULL), "a state's range");
    }
    for (int c = 0; c < M->m; c++) {
        need(kq_format_prepare_q31(&measurement_format[c], KQ_FRACTION_BEST_Q31, M->measurement_range, NULL),
             "a range");
    }
    q31_begin_process(M);
    q31_begin_sensor(M);
    q31_begin_filter(M);
    for (int t = 0; t < STEPS; t++) {
        need(kq_vector_prepare_q31(wide_z[t], z[t], M->m, measurement_format, NULL), "z");
    }
}

static void q31_take(int t)
{
    need(kq_predict_q31(&filter, &process, NULL), "predict");
    need(kq_update_q31(&filter, &sensor, wide_z[t]), "update");
}

static void q31_read(estimate *e, int n)
{
    kq_scaled_q31 P[STATES * STATES];
    need(kq_covariance_q31(&filter, P), "covariance");
    for (int i = 0; i < n; i++) {
        const real low = ldexpl(kq_mean_low_q31(&filter, i), -24);
        e->x[i] = ldexpl(kq_mean_q31(&filter, i) + low, -state_format[i].fraction);
        for (int j = 0; j < n; j++) {
            const int unit = state_format[i].fraction + state_format[j].fraction;
            e->P[i * n + j] = ldexpl(P[i * n + j].mantissa, P[i * n + j].exponent - unit);
        }
    }
}

/* ------------------------------------------------------------------ accuracy */

static const struct {
    const char *name;
    void (*begin)(const model *M, double (*z)[COMPONENTS]);
    void (*step)(int t);
    void (*read)(estimate *e, int n);
} filters[] = {{"q16", q16_begin, q16_take, q16_read}, {"q31", q31_begin, q31_take, q31_read}};

enum { FILTERS = sizeof filters / sizeof filters[0] };

/* Does a symmetric matrix of unit size have no eigenvalue below -1e-6?  By Cholesky. */
static int is_semidefinite(const real *matrix, int n)
{
    real L[STATES * STATES];
    for (int i = 0; i < n; i++) {
        for (int j = 0; j <= i; j++) {
            real left = matrix[i * n + j] + (i == j ? 1e-6L : 0);
            for (int k = 0; k < j; k++) left -= L[i * n + k] * L[j * n + k];
            if (i == j && left <= 0) return 0;
            L[i * n + j] = i == j ? sqrtl(left) : left / L[j * n + j];
        }
    }
    return 1;
}

typedef struct {
    real x, P;
    int semidefinite; /* steps */
} verdict;

/* In units of the reference's sigmas */
static void judge(verdict *v, const estimate *e, const estimate *reference, int n)
{
    real unit[STATES * STATES];
    for (int i = 0; i < n; i++) {
        const real sigma = sqrtl(reference->P[i * n + i]);
        v->x = fmaxl(v->x, fabsl(e->x[i] - reference->x[i]) / sigma);
        for (int j = 0; j < n; j++) {
            const real scale = sigma * sqrtl(reference->P[j * n + j]);
            unit[i * n + j] = e->P[i * n + j] / scale;
            v->P = fmaxl(v->P, fabsl(e->P[i * n + j] - reference->P[i * n + j]) / scale);
        }
    }
    v->semidefinite += is_semidefinite(unit, n);
}

static verdict accuracy_of(int which, const model *M, double (*z)[COMPONENTS])
{
    verdict v = {0, 0, 0};
    estimate reference, e;
    double Q[STATES * STATES];
    process_noise(M, Q);
    reference_begin(&reference, M);
    filters[which].begin(M, z);
    for (int t = 0; t < STEPS; t++) {
        reference_predict(&reference, M, Q);
        reference_update(&reference, M, z[t]);
        filters[which].step(t);
        filters[which].read(&e, M->n);
        judge(&v, &e, &reference, M->n);
    }
    return v;
}

static void print_accuracy(void)
{
    static double z[STEPS][COMPONENTS];
    for (int k = 0; k < MODELS; k++) {
        model M;
        model_make(&M, k);
        model_simulate(&M, z);
        for (int which = 0; which < FILTERS; which++) {
            const verdict v = accuracy_of(which, &M, z);
            printf("%d %d %d %s %.2Le %.2Le %d %d\n", k, M.n, M.m, filters[which].name, v.x, v.P,
                   v.semidefinite, STEPS);
        }
    }
}

/* ------------------------------------------------------------------ instructions */

static int run_steps(const char *name, int which, int steps)
{
    static double z[STEPS][COMPONENTS];
    model M;
    if (which < 0 || which >= MODELS || steps < 0 || steps > STEPS) return 2;
    model_make(&M, which);
    model_simulate(&M, z);
    for (int k = 0; k < FILTERS; k++) {
        if (strcmp(name, filters[k].name) != 0) continue;
        filters[k].begin(&M, z);
        for (int t = 0; t < steps; t++) filters[k].step(t);
        return 0;
    }
    return 2;
}

int main(int argc, char **argv)
{
    if (argc == 2 && strcmp(argv[1], "accuracy") == 0) {
        print_accuracy();
        return 0;
    }
    if (argc == 5) return run_steps(argv[2], atoi(argv[3]), atoi(argv[4]));
    fprintf(stderr, "usage: cost accuracy | cost run FILTER MODEL STEPS\n");
    return 2;
}
