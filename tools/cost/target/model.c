/*
 * Prints one model as C arrays for a program on a target, which may have no double to prepare it
 * with.
 *   model ARITHMETIC N M L   f32, f64 (also for the textbook filter), q31 or q16; L controls
 *
 * The model: m axes of position, velocity, acceleration at 10 Hz, as many as n says; dense Q.  D:
 * a dense H.
 */
#include <kalmanq/kalmanq.h>
#include <kalmanq/prepare.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { STATES = KQ_SIZE_MAX };

typedef struct {
    int n, m, l;
    double A[STATES * STATES], Q[STATES * STATES], P0[STATES * STATES], x0[STATES];
    double H[STATES * STATES], R[STATES], z[STATES];
    double D[STATES * STATES], B[STATES * STATES], u[STATES];
    double K[STATES * STATES]; /* the steady gain */
} model;

static void need(kq_status status, const char *what)
{
    if (!status) return;
    fprintf(stderr, "model: %s: %s\n", what, kq_status_text(status));
    exit(1);
}

/* Within -1 and 1, the same at every run */
static double draw(void)
{
    static uint32_t seed = 1;
    seed = seed * UINT32_C(1664525) + UINT32_C(1013904223);
    return (seed >> 8) / (double)(1 << 23) - 1;
}

static void make(model *M, int n, int m, int l)
{
    const double dt = 0.1;
    memset(M, 0, sizeof *M);
    M->n = n;
    M->m = m;
    M->l = l;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            M->A[i * n + j] = j == i ? 1 : j == i + m ? dt : j == i + 2 * m ? dt * dt / 2 : 0;
            M->Q[i * n + j] = j == i ? 0.02 : 0.001;
            M->P0[i * n + j] = j == i ? 10 : 0;
        }
    }
    for (int c = 0; c < m; c++) {
        M->H[c * n + c] = 1;
        M->R[c] = 0.5;
        M->z[c] = c + 1;
        for (int i = 0; i < n; i++) M->D[c * n + i] = draw() / n;
    }
    for (int k = 0; k < l; k++) {
        M->u[k] = k + 1;
        for (int i = 0; i < n; i++) M->B[i * l + k] = draw() / l;
    }
}

enum { SOLVE_LEN = KQ_STEADY_SOLVE_LEN_F64(STATES, STATES) };

static void make_gain(model *M)
{
    static double p_memory[KQ_PROCESS_LEN(STATES)], s_memory[STATES], memory[SOLVE_LEN];
    const kq_steady_solution_f64 wanted = {.gain = M->K};
    kq_process_f64 p;
    kq_sensor_f64 s;
    need(kq_process_assign_f64(&p, M->n, 0, p_memory, KQ_PROCESS_LEN(STATES)), "process");
    need(kq_process_init_f64(&p, M->A, NULL, M->Q), "process");
    need(kq_sensor_assign_f64(&s, M->n, M->m, s_memory, STATES), "sensor");
    need(kq_sensor_init_diagonal_f64(&s, M->H, M->R), "sensor");
    need(kq_steady_solve_f64(&p, &s, memory, SOLVE_LEN, &wanted), "steady gain");
}

/* ------------------------------------------------------------------ floating point */

static void print_numbers(const model *M, const char *type, const char *name, const double *values,
                          int count)
{
    printf("static const %s %s_%d_%d[] = {", type, name, M->n, M->m);
    for (int k = 0; k < count; k++) printf("%s%.9g", k ? ", " : "", values[k]);
    printf("};\n");
}

/* The upper triangle U of P = U U', packed by columns; P is positive definite. */
static void print_root(const model *M, const char *type, const char *name, const double *P)
{
    const int n = M->n;
    double U[KQ_TRIANGLE(STATES)];
    for (int j = n - 1; j >= 0; j--) {
        for (int i = j; i >= 0; i--) {
            double rest = P[i * n + j];
            for (int k = j + 1; k < n; k++) {
                rest -= U[KQ_TRIANGLE(k) + i] * U[KQ_TRIANGLE(k) + j];
            }
            U[KQ_TRIANGLE(j) + i] = i == j ? sqrt(rest) : rest / U[KQ_TRIANGLE(j) + j];
        }
    }
    print_numbers(M, type, name, U, KQ_TRIANGLE(n));
}

static void print_floating(const model *M, const char *type)
{
    const int n = M->n, m = M->m;
    print_numbers(M, type, "A", M->A, n * n);
    print_numbers(M, type, "Q", M->Q, n * n);
    print_numbers(M, type, "P0", M->P0, n * n);
    print_root(M, type, "G", M->Q);
    print_root(M, type, "S0", M->P0);
    print_numbers(M, type, "x0", M->x0, n);
    print_numbers(M, type, "H", M->H, m * n);
    print_numbers(M, type, "R", M->R, m);
    print_numbers(M, type, "z", M->z, m);
    print_numbers(M, type, "K", M->K, n * m);
    print_numbers(M, type, "D", M->D, m * n);
    if (M->l) print_numbers(M, type, "B", M->B, n * M->l);
    if (M->l) print_numbers(M, type, "u", M->u, M->l);
}

/* ------------------------------------------------------------------ fixed point */

static void print_words(const model *M, const char *name, const int32_t *words, int count)
{
    printf("static const int32_t %s_%d_%d[] = {", name, M->n, M->m);
    for (int k = 0; k < count; k++) printf("%s%ld", k ? ", " : "", (long)words[k]);
    printf("};\n");
}

static void print_q16(const model *M, const char *name, const double *values, int count)
{
    int32_t words[STATES * STATES];
    for (int k = 0; k < count; k++) words[k] = (int32_t)(values[k] * 65536 + 0.5);
    print_words(M, name, words, count);
}

static void print_narrow(const model *M)
{
    const int n = M->n, m = M->m;
    print_q16(M, "A", M->A, n * n);
    print_q16(M, "Q", M->Q, n * n);
    print_q16(M, "P0", M->P0, n * n);
    print_q16(M, "H", M->H, m * n);
    print_q16(M, "R", M->R, m);
    print_q16(M, "x0", M->x0, n);
    print_q16(M, "z", M->z, m);
}

static void print_scaled(const model *M, const char *name, const kq_scaled_q31 *table, int count)
{
    printf("static const kq_scaled_q31 %s_%d_%d[] = {", name, M->n, M->m);
    for (int k = 0; k < count; k++) {
        printf("%s{%ld, %ld}", k ? ", " : "", (long)table[k].mantissa, (long)table[k].exponent);
    }
    printf("};\n");
}

static void print_formats(const model *M, const char *name, const kq_format_q31 *format, int count)
{
    printf("static const kq_format_q31 %s_%d_%d[] = {", name, M->n, M->m);
    for (int k = 0; k < count; k++) {
        printf("%s{%ld, %ld}", k ? ", " : "", (long)format[k].range, (long)format[k].fraction);
    }
    printf("};\n");
}

/* rows x columns, from the units of what it multiplies to those of what comes out */
static void print_matrix(const model *M, const char *name, const double *values, int rows,
                         int columns, const kq_format_q31 *to, const kq_format_q31 *from)
{
    kq_scaled_q31 table[STATES * STATES];
    need(kq_matrix_prepare_q31(table, values, rows, columns, to, from), name);
    print_scaled(M, name, table, rows * columns);
}

static void print_controls(const model *M, const kq_format_q31 *state)
{
    kq_format_q31 controlled[STATES];
    int32_t words[STATES];
    for (int k = 0; k < M->l; k++) need(kq_format_prepare_q31(controlled + k, KQ_FRACTION_BEST_Q31, 100, NULL), "u");
    print_formats(M, "controlled", controlled, M->l);
    print_matrix(M, "B", M->B, M->n, M->l, state, controlled);
    need(kq_vector_prepare_q31(words, M->u, M->l, controlled, NULL), "u");
    print_words(M, "u", words, M->l);
}

/* Positions to 1000, velocities and accelerations to 100 */
static void print_wide(const model *M)
{
    const int n = M->n, m = M->m;
    kq_format_q31 state[STATES], measured[STATES];
    kq_scaled_q31 table[STATES];
    int32_t words[KQ_ROOT_LEN_Q31(STATES)];
    for (int i = 0; i < n; i++) {
        need(kq_format_prepare_q31(state + i, KQ_FRACTION_BEST_Q31, i < m ? 1000 : 100, NULL), "x");
    }
    for (int c = 0; c < m; c++) need(kq_format_prepare_q31(measured + c, KQ_FRACTION_BEST_Q31, 1000, NULL), "z");
    print_formats(M, "state", state, n);
    print_formats(M, "measured", measured, m);
    print_matrix(M, "A", M->A, n, n, state, state);
    print_matrix(M, "H", M->H, m, n, measured, state);
    need(kq_noise_prepare_diagonal_q31(table, M->R, m, measured), "R");
    print_scaled(M, "R", table, m);
    print_matrix(M, "D", M->D, m, n, measured, state);
    print_matrix(M, "K", M->K, n, m, state, measured);
    need(kq_root_prepare_q31(words, M->Q, n, state), "Q");
    print_words(M, "G", words, KQ_ROOT_LEN_Q31(n));
    need(kq_root_prepare_q31(words, M->P0, n, state), "P0");
    print_words(M, "S0", words, KQ_ROOT_LEN_Q31(n));
    need(kq_vector_prepare_q31(words, M->x0, n, state, NULL), "x0");
    print_words(M, "x0", words, n);
    need(kq_vector_prepare_q31(words, M->z, m, measured, NULL), "z");
    print_words(M, "z", words, m);
    if (M->l) print_controls(M, state);
}

int main(int count, char **arguments)
{
    if (count != 5) return 2;
    const char *arithmetic = arguments[1];
    model M;
    make(&M, atoi(arguments[2]), atoi(arguments[3]), atoi(arguments[4]));
    make_gain(&M);
    if (!strcmp(arithmetic, "f32")) print_floating(&M, "float");
    else if (!strcmp(arithmetic, "f64")) print_floating(&M, "double");
    else if (!strcmp(arithmetic, "q31")) print_wide(&M);
    else if (!strcmp(arithmetic, "q16")) print_narrow(&M);
    else return 2;
    return 0;
}
