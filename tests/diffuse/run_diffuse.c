/*
 * A run from an unknown start, for test_diffuse.py: the model and the data from standard input, what
 * the library makes of them to standard output.
 *
 *   in    n m steps early unknown, x0, P0, A, Q, R, then for each step H and z (nan: missing)
 *   out   "filtered" t count llf mean sigma, then "smoothed" t mean P, a step a line
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "kalmanq/kalmanq.h"

#if defined(KQ_RUN_F32)
typedef float num;
#define K(name) kq_##name##_f32
#define SENSOR_LEN KQ_SENSOR_LEN
#define FILTER_LEN KQ_FILTER_LEN_F32
#define HISTORY_LEN KQ_HISTORY_LEN_F32
#define START_LEN KQ_DIFFUSE_LEN_F32
#else
typedef double num;
#define K(name) kq_##name##_f64
#define SENSOR_LEN KQ_SENSOR_LEN
#define FILTER_LEN KQ_FILTER_LEN_F64
#define HISTORY_LEN KQ_HISTORY_LEN_F64
#define START_LEN KQ_DIFFUSE_LEN_F64
#endif

enum { MAX = KQ_SIZE_MAX, STEPS = 400 };

static num process_memory[KQ_PROCESS_LEN(MAX)], sensor_memory[KQ_SENSOR_LEN(MAX)];
static num filter_memory[FILTER_LEN(MAX)], tape_memory[HISTORY_LEN(MAX, MAX, STEPS, 0)];
static num start_memory[START_LEN(MAX, STEPS)];
static num x0[MAX], P0[MAX * MAX], A[MAX * MAX], Q[MAX * MAX], R[MAX * MAX], P[MAX * MAX];
static num H[STEPS][MAX * MAX], z[STEPS][MAX];

static K(process) process;
static K(sensor) sensor;
static K(filter) filter;
static K(history) tape;
static K(diffuse) start;

static double read_number(void)
{
    double number;
    if (scanf("%lf", &number) != 1) {
        fprintf(stderr, "run_start: a number is missing\n");
        exit(2);
    }
    return number;
}

static int read_size(int most)
{
    const double size = read_number();
    if (!(size >= 0 && size <= most)) {
        fprintf(stderr, "run_start: %g is no size\n", size);
        exit(2);
    }
    return (int)size;
}

static void read_array(num *to, int count)
{
    for (int k = 0; k < count; k++) to[k] = (num)read_number();
}

static void require(kq_status status, const char *what)
{
    if (status == KQ_OK) return;
    fprintf(stderr, "run_start: %s: %s\n", what, kq_status_text(status));
    exit(1);
}

static void print_array(const num *numbers, int count)
{
    for (int k = 0; k < count; k++) printf(" %.17g", (double)numbers[k]);
}

static void print_filtered(int t, int n)
{
    num mean[MAX], sigma[MAX];
    const num llf = K(log_likelihood_last)(&filter);
    for (int i = 0; i < n; i++) mean[i] = K(mean)(&filter, i);
    for (int i = 0; i < n; i++) sigma[i] = K(sigma)(&filter, i);
    printf("filtered %d %d %.17g", t, K(diffuse_count)(&start), (double)llf);
    print_array(mean, n);
    print_array(sigma, n);
    printf("\n");
}

static void print_smoothed(int t, int n)
{
    num mean[MAX], sigma[MAX];
    const size_t step = (size_t)t;
    K(filter) view;
    const kq_status shown = K(diffuse_smoothed)(&start, step, &view); /* refused: it reads NaN */
    (void)shown;
    for (int i = 0; i < n; i++) mean[i] = K(mean)(&view, i);
    for (int i = 0; i < n; i++) sigma[i] = K(sigma)(&view, i);
    const kq_status status = K(covariance)(&view, P);
    for (int k = 0; status && k < n * n; k++) P[k] = (num)NAN;
    printf("smoothed %d", t);
    print_array(mean, n);
    print_array(sigma, n);
    print_array(P, n * n);
    printf("\n");
}

static void update(int t, int n, int m)
{
    uint32_t present = 0;
    for (int c = 0; c < m; c++) {
        if (!isnan(z[t][c])) present |= UINT32_C(1) << c;
    }
    (void)n;
    require(K(sensor_change_measurement)(&sensor, H[t]), "sensor");
    require(K(update_subset)(&filter, &sensor, z[t], present), "update");
}

int main(void)
{
    const int n = read_size(MAX), m = read_size(MAX), steps = read_size(STEPS);
    const int early = read_size(STEPS);
    const uint32_t unknown = (uint32_t)read_size(0xffff);
    read_array(x0, n);
    read_array(P0, n * n);
    read_array(A, n * n);
    read_array(Q, n * n);
    read_array(R, m * m);
    for (int t = 0; t < steps; t++) {
        read_array(H[t], m * n);
        read_array(z[t], m);
    }
    require(K(process_assign)(&process, n, 0, process_memory, KQ_PROCESS_LEN(MAX)), "process");
    require(K(process_init)(&process, A, NULL, Q), "process");
    require(K(sensor_assign)(&sensor, n, m, sensor_memory, KQ_SENSOR_LEN(MAX)), "sensor");
    require(K(sensor_init)(&sensor, H[0], R), "sensor");
    require(K(filter_assign)(&filter, n, filter_memory, FILTER_LEN(MAX)), "filter");
    require(K(history_assign)(&tape, n, tape_memory, HISTORY_LEN(MAX, MAX, STEPS, 0)), "history");
    require(K(diffuse_assign)(&start, n, (size_t)early, start_memory, START_LEN(MAX, STEPS)),
            "start");
    require(K(diffuse_init)(&start, &filter, x0, P0, unknown), "start");
    require(K(attach)(&filter, &tape.attached), "attach");
    for (int t = 0; t < steps; t++) {
        if (t > 0) require(K(predict)(&filter, &process, NULL), "predict");
        update(t, n, m);
        print_filtered(t, n);
    }
    require(K(diffuse_smooth)(&start), "smooth");
    size_t first;
    const size_t early_steps = K(diffuse_steps)(&start, &first);
    printf("steps %d %d %d\n", (int)early_steps, (int)first, (int)K(history_steps)(&tape));
    for (int t = 0; t < steps; t++) print_smoothed(t, n);
    return 0;
}
