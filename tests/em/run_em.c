/*
 * Iterations of EM, for test_em.py: the problem from standard input, what the library makes of it
 * to standard output.
 *
 *   in    n m l r (0: no F), free (0: no choice) Q_form R_form, A_held H_held (are they given?),
 *         iterations tolerance (-1: never settled), slices (advance and maximise, not iterate),
 *         final (the E-step of the last parameters, and the gradient), the number of snapshots and
 *         the iterations they are of (-1 of them: all), recordings;
 *         A B F Q H R x0 P0, A_held, H_held;
 *         for each recording steps, controlled, z (nan: missing) and, if controlled, u
 *   out   "init" status, for each iteration "iteration" k likelihood change distance,
 *         "parameters" k A H Q R x0 P0, at last "final" likelihood, "gradient" of the free ones and
 *         of Q, R and P0 in the same order
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "kalmanq/kalmanq.h"

#if defined(KQ_RUN_F32)
typedef float num;
typedef kq_recording_f32 recording;
#define K(name) kq_##name##_f32
#define EM_LEN KQ_EM_LEN_F32
#else
typedef double num;
typedef kq_recording_f64 recording;
#define K(name) kq_##name##_f64
#define EM_LEN KQ_EM_LEN_F64
#endif

enum { STEPS_MAX = 100000, RECORDINGS_MAX = 100, ITERATIONS_MAX = 100000 };

static int n, m, l, r, count;
static int iterations, slices, final, snapshots;
static num tolerance;
static int *snapshot;
static num *A, *B, *F, *Q, *H, *R, *x0, *P0;
static recording *recordings;
static K(parameters) model;
static kq_em_choice choice;
static K(em) em;

static double read_number(void)
{
    double number;
    if (scanf("%lf", &number) != 1) {
        fprintf(stderr, "run_em: a number is missing\n");
        exit(2);
    }
    return number;
}

static int read_integer(const char *what, int least, int most)
{
    const double size = read_number();
    if (!(size >= least && size <= most && size == floor(size))) {
        fprintf(stderr, "run_em: %s is %g, not %d to %d\n", what, size, least, most);
        exit(2);
    }
    return (int)size;
}

/* Memory of exactly that size, so that a sanitizer sees what is beyond it. */
static void *allocate(size_t items, size_t size)
{
    void *memory = items ? malloc(items * size) : NULL;
    if (items && !memory) {
        fprintf(stderr, "run_em: out of memory\n");
        exit(2);
    }
    return memory;
}

static num *read_array(int rows, int columns)
{
    const size_t items = (size_t)rows * (size_t)columns;
    num *array = allocate(items, sizeof *array);
    for (size_t k = 0; k < items; k++) array[k] = (num)read_number();
    return array;
}

static const uint8_t *read_held(int given, int rows, int columns)
{
    const size_t items = given ? (size_t)rows * (size_t)columns : 0;
    uint8_t *held = allocate(items, 1);
    for (size_t k = 0; k < items; k++) held[k] = (uint8_t)read_integer("held", 0, 1);
    return held;
}

static const uint16_t *read_presence(const num *z, int steps)
{
    uint16_t *present = allocate((size_t)steps, sizeof *present);
    int missing = 0;
    for (int t = 0; t < steps; t++) {
        present[t] = 0;
        for (int c = 0; c < m; c++) {
            if (isnan(z[t * m + c])) missing = 1;
            else present[t] = (uint16_t)(present[t] | UINT32_C(1) << c);
        }
    }
    if (missing) return present;
    free(present);
    return NULL;
}

static int read_recordings(void)
{
    int longest = 0;
    recordings = allocate((size_t)count, sizeof *recordings);
    for (int k = 0; k < count; k++) {
        const int steps = read_integer("steps", 1, STEPS_MAX);
        const int controlled = read_integer("controlled", 0, l > 0);
        const num *z = read_array(steps, m);
        const uint16_t *present = read_presence(z, steps);
        const num *u = controlled ? read_array(steps - 1, l) : NULL;
        recordings[k] = (recording){(size_t)steps, z, present, u};
        if (steps > longest) longest = steps;
    }
    return longest;
}

static void read_model(void)
{
    A = read_array(n, n);
    B = read_array(n, l);
    F = read_array(n, r);
    const int q = r ? r : n;
    Q = read_array(q, q);
    H = read_array(m, n);
    R = read_array(m, m);
    x0 = read_array(n, 1);
    P0 = read_array(n, n);
    model = (K(parameters)){l, r, A, B, F, Q, H, R, x0, P0};
}

/* The whole problem; answers the steps of the longest recording. */
static int read_problem(void)
{
    n = read_integer("n", 1, KQ_SIZE_MAX);
    m = read_integer("m", 1, KQ_SIZE_MAX);
    l = read_integer("l", 0, KQ_SIZE_MAX);
    r = read_integer("r", 0, n);
    choice.free = (unsigned)read_integer("free", 0, KQ_EM_ALL);
    choice.Q_form = (kq_em_form)read_integer("Q_form", KQ_EM_FULL, KQ_EM_MULTIPLE);
    choice.R_form = (kq_em_form)read_integer("R_form", KQ_EM_FULL, KQ_EM_MULTIPLE);
    const int A_held = read_integer("A_held", 0, 1), H_held = read_integer("H_held", 0, 1);
    iterations = read_integer("iterations", 0, ITERATIONS_MAX);
    tolerance = (num)read_number();
    slices = read_integer("slices", 0, 1);
    final = read_integer("final", 0, 1);
    snapshots = read_integer("snapshots", -1, ITERATIONS_MAX);
    snapshot = allocate(snapshots > 0 ? (size_t)snapshots : 0, sizeof *snapshot);
    for (int k = 0; k < snapshots; k++) snapshot[k] = read_integer("snapshot", 1, ITERATIONS_MAX);
    count = read_integer("recordings", 1, RECORDINGS_MAX);
    read_model();
    choice.A_held = read_held(A_held, n, n);
    choice.H_held = read_held(H_held, m, n);
    return read_recordings();
}

static void require(kq_status status, const char *what)
{
    if (status >= KQ_OK) return;
    fprintf(stderr, "run_em: %s: %s\n", what, kq_status_text(status));
    exit(1);
}

static void print_array(const num *numbers, int items)
{
    for (int k = 0; k < items; k++) printf(" %.17g", (double)numbers[k]);
}

static void print_parameters(int k)
{
    const int q = r ? r : n;
    printf("parameters %d", k);
    print_array(A, n * n);
    print_array(H, m * n);
    print_array(Q, q * q);
    print_array(R, m * m);
    print_array(x0, n);
    print_array(P0, n * n);
    printf("\n");
}

static int is_asked_for(int k)
{
    int asked = snapshots < 0;
    for (int i = 0; i < snapshots; i++) asked |= snapshot[i] == k;
    return asked;
}

static void expect(void)
{
    do {
        require(K(em_advance)(&em), "advance");
    } while (K(em_remaining)(&em) > 0);
}

/* Answers 0 where the likelihood has no maximum that the arithmetic can go to. */
static int iterate(void)
{
    if (!slices) {
        const kq_status status = K(em_iterate)(&em);
        if (status == KQ_ERR_LIKELIHOOD) return 0;
        require(status, "iterate");
        return 1;
    }
    expect();
    require(K(em_maximise)(&em), "maximise");
    return 1;
}

static void print_gradient(void)
{
    const int q = r ? r : n;
    const unsigned free_ones = choice.free ? choice.free : (unsigned)KQ_EM_Q | (unsigned)KQ_EM_R;
    num gA[KQ_SIZE_MAX * KQ_SIZE_MAX], gH[KQ_SIZE_MAX * KQ_SIZE_MAX];
    num gQ[KQ_SIZE_MAX * KQ_SIZE_MAX], gR[KQ_SIZE_MAX * KQ_SIZE_MAX];
    num gx0[KQ_SIZE_MAX], gP0[KQ_SIZE_MAX * KQ_SIZE_MAX];
    K(gradient) gradient = {NULL, NULL, gQ, gR, NULL, gP0};
    if (free_ones & KQ_EM_A) gradient.A = gA;
    if (free_ones & KQ_EM_H) gradient.H = gH;
    if (free_ones & KQ_EM_X0) gradient.x0 = gx0;
    require(K(em_gradient)(&em, &gradient), "gradient");
    printf("gradient");
    if (gradient.A) print_array(gA, n * n);
    if (gradient.H) print_array(gH, m * n);
    print_array(gQ, q * q);
    print_array(gR, m * m);
    if (gradient.x0) print_array(gx0, n);
    print_array(gP0, n * n);
    printf("\n");
}

int main(void)
{
    const int longest = read_problem();
    const size_t length = EM_LEN(n, m, longest);
    num *memory = allocate(length, sizeof *memory);
    require(K(em_assign)(&em, n, m, memory, length), "assign");
    const kq_status status =
        K(em_init)(&em, &model, choice.free ? &choice : NULL, recordings, (size_t)count);
    require(status, "init");
    printf("init %d\n", status);
    for (int k = 1; k <= iterations && !(K(em_change)(&em) <= tolerance); k++) {
        if (!iterate()) break;
        printf("iteration %d %.17g %.17g %.17g\n", k, (double)K(em_log_likelihood)(&em),
               (double)K(em_change)(&em), (double)K(em_distance)(&em));
        if (is_asked_for(k)) print_parameters(k);
    }
    if (final) {
        expect();
        printf("final %.17g\n", (double)K(em_log_likelihood)(&em));
        print_gradient();
    }
    return 0;
}
