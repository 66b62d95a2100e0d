/*
 * The host's side of the tests on small parts: the model, the measurements, and the textbook's filter and smoother
 * (tests/unit/textbook.h).
 *   host voltages                     what lies at the ADC, in millivolts
 *   host tables f32|q31 N WHAT        the model and the measurements as C for program.c
 *   host check f32|q31 N WHAT LIMIT <LOG
 *                                     the log of program.c against the textbook; prints the
 *                                     stack that it says beside LIMIT bytes
 * A voltage that rises, in counts of a 10-bit ADC: its level (n = 1), or level and slope (n = 2).
 * The prior knows nothing, the first measurement is a reference without noise: that is where the
 * stack is deepest.  Where WHAT begins with "lean" the prior knows the supply, and there is no reference.
 */
#include <stdio.h>
#include <stdlib.h>

#include "kalmanq/prepare.h"
#define KQ_TEST_F64
#include "textbook.h"

enum { STATES = 2, STEPS = 45, FULL_SCALE = 1023, SUPPLY = 5000 };

static const double tolerance = 1e-4; /* of sigma, and of `least` */
static const double least = 0.01;     /* counts: where sigma is 0 */

typedef struct {
    int n, is_lean;
    double A[STATES * STATES], Q[STATES * STATES], P0[STATES * STATES], H[STATES], R;
    kq_format_q31 state[STATES], measured;
} model;

static void need(int is_so, const char *what)
{
    if (is_so) return;
    printf("parts: %s\n", what);
    exit(1);
}

static model model_of(int n, int is_lean)
{
    const model level = {.n = 1, .A = {1}, .Q = {0.09}, .P0 = {1e8}, .H = {1}, .R = 4};
    const model slope = {.n = 2,
                         .A = {1, 1, 0, 1},
                         .Q = {0.02, 0.005, 0.005, 0.01},
                         .P0 = {1e8, 0, 0, 1e4},
                         .H = {1, 0},
                         .R = 4};
    model M = n == 1 ? level : slope;
    need(n == 1 || n == 2, "n is 1 or 2");
    M.is_lean = is_lean;
    if (is_lean) M.P0[0] = 1e5;
    for (int i = 0; i < n; i++) {
        need(!kq_format_prepare_q31(M.state + i, KQ_FRACTION_BEST_Q31, i ? 100 : 2 * FULL_SCALE, NULL),
             "a state's format");
    }
    need(!kq_format_prepare_q31(&M.measured, 0, FULL_SCALE, NULL), "the ADC's format");
    return M;
}

static unsigned voltage(int t)
{
    unsigned noise = (unsigned)t * 2654435761u >> 26; /* 0 .. 63 */
    return 1500 + 30 * (unsigned)t + noise;
}

static int count_of(int t) { return (int)(voltage(t) * FULL_SCALE / SUPPLY); }

/* ------------------------------------------------------------------ tables */

static void print_floats(const char *name, const double *values, int count)
{
    printf("static const float %s[] = {", name);
    for (int k = 0; k < count; k++) printf("%.9g, ", values[k]);
    printf("};\n");
}

/* The root of P, upper triangle by columns */
static void print_float_root(const char *name, const double *P, int n)
{
    const double last = sqrt(P[n * n - 1]), across = n == 1 ? 0 : P[1] / last;
    const double roots[] = {sqrt(P[0] - across * across), across, last};
    print_floats(name, n == 1 ? &last : roots, n == 1 ? 1 : 3);
}

static void print_scaled(const char *name, const kq_scaled_q31 *values, int count)
{
    printf("static const kq_scaled_q31 %s[] = {", name);
    for (int k = 0; k < count; k++) {
        printf("{%ld, %ld}, ", (long)values[k].mantissa, (long)values[k].exponent);
    }
    printf("};\n");
}

static void print_root(const char *name, const double *P, const model *M)
{
    int32_t root[KQ_ROOT_LEN_Q31(STATES)];
    need(!kq_root_prepare_q31(root, P, M->n, M->state), name);
    printf("static const int32_t %s[] = {", name);
    for (int k = 0; k < KQ_ROOT_LEN_Q31(M->n); k++) printf("%ld, ", (long)root[k]);
    printf("};\n");
}

static void print_fixed_point(const model *M)
{
    const int n = M->n;
    kq_scaled_q31 table[STATES * STATES];
    printf("static const kq_format_q31 state[] = {");
    for (int i = 0; i < n; i++) {
        printf("{%ld, %ld}, ", (long)M->state[i].range, (long)M->state[i].fraction);
    }
    printf("};\nstatic const kq_format_q31 measured[] = {{%ld, %ld}};\n", (long)M->measured.range,
           (long)M->measured.fraction);
    need(!kq_matrix_prepare_q31(table, M->A, n, n, M->state, M->state), "A");
    print_scaled("A", table, n * n);
    need(!kq_matrix_prepare_q31(table, M->H, 1, n, &M->measured, M->state), "H");
    print_scaled("H", table, n);
    need(!kq_noise_prepare_diagonal_q31(table, &M->R, 1, &M->measured), "R");
    print_scaled("R", table, 1);
    print_root("G", M->Q, M);
    print_root("S0", M->P0, M);
}

static void print_tables(const model *M, int is_float)
{
    printf("enum { N = %d, STEPS = %d };\n", M->n, STEPS);
    printf("static const int16_t recorded[] = {");
    for (int t = 0; t < STEPS; t++) printf("%d, ", count_of(t));
    printf("};\n");
    if (!is_float) {
        print_fixed_point(M);
        return;
    }
    print_floats("A", M->A, M->n * M->n);
    if (M->is_lean) {
        print_float_root("G", M->Q, M->n);
        print_float_root("S0", M->P0, M->n);
    } else {
        print_floats("Q", M->Q, M->n * M->n);
        print_floats("P0", M->P0, M->n * M->n);
    }
    print_floats("H", M->H, M->n);
    print_floats("R", &M->R, 1);
}

/* ------------------------------------------------------------------ the log */

static double value_of(unsigned long word, const model *M, int i, int is_float)
{
    const uint32_t bits = (uint32_t)word;
    float number;
    int32_t whole;
    memcpy(&number, &bits, sizeof number);
    memcpy(&whole, &bits, sizeof whole);
    return is_float ? (double)number : ldexp(whole, -M->state[i].fraction);
}

/* The larger error of a line's means and sigmas, in sigma */
static double error_of(const textbook *e, const model *M, int is_float)
{
    double worst = 0;
    for (int i = 0; i < M->n; i++) {
        unsigned long mean, sigma;
        need(scanf("%lx %lx", &mean, &sigma) == 2, "a line is not complete");
        const double exact = sqrt(fabs(e->P[i * M->n + i]));
        const double of_mean = fabs(value_of(mean, M, i, is_float) - e->x[i]) / (exact + least);
        const double of_sigma = fabs(value_of(sigma, M, i, is_float) - exact) / (exact + least);
        worst = fmax(worst, fmax(of_mean, of_sigma));
        need(of_mean <= tolerance && of_sigma <= tolerance, "not what it is in double");
    }
    return worst;
}

static void check(const model *M, int is_float, unsigned long limit)
{
    static const double nothing[STATES];
    static textbook filtered[STEPS], ahead[STEPS], now;
    double filter_error = 0, smoother_error = 0;
    unsigned long stack = 0, word = 0;
    char kind[8];
    textbook_init(&now, M->n, nothing, M->P0);
    for (int t = 0; t < STEPS; t++) {
        need(scanf("%7s %lx", kind, &word) == 2 && !strcmp(kind, "step"), "a step is missing");
        need(word == (unsigned long)count_of(t), "the ADC has measured something else");
        const double measured = (double)word, variance = t || M->is_lean ? M->R : 0;
        if (t) textbook_predict(&now, M->A, NULL, NULL, 0, M->Q), ahead[t] = now;
        textbook_update(&now, M->H, &variance, &measured, 1);
        filtered[t] = now;
        filter_error = fmax(filter_error, error_of(&now, M, is_float));
    }
    need(scanf("%7s", kind) == 1, "the end is missing");
    for (int t = STEPS - 1; !strcmp(kind, "past"); t--) {
        need(t >= 0, "too much of the past");
        double lag_one[STATES * STATES];
        if (t < STEPS - 1) textbook_smooth(&filtered[t], &ahead[t + 1], &filtered[t + 1], M->A, lag_one);
        smoother_error = fmax(smoother_error, error_of(&filtered[t], M, is_float));
        need(scanf("%7s", kind) == 1 && (t > 0 || strcmp(kind, "past")), "the end is missing");
    }
    need(!strcmp(kind, "stack") && scanf("%lx", &stack) == 1, "the stack is missing");
    printf("error %.2g sigma, smoothed %.2g; stack %lu bytes, the card says %lu\n", filter_error,
           smoother_error, stack, limit);
}

int main(int count, char **arguments)
{
    const char *what = count > 1 ? arguments[1] : "";
    if (!strcmp(what, "voltages")) {
        for (int t = 0; t < STEPS; t++) printf("%u\n", voltage(t));
        return 0;
    }
    need(count >= 5, "host voltages | tables T N WHAT | check T N WHAT LIMIT");
    const model M = model_of(atoi(arguments[3]), !strncmp(arguments[4], "lean", 4));
    const int is_float = !strcmp(arguments[2], "f32");
    if (!strcmp(what, "tables")) print_tables(&M, is_float);
    else if (count == 6) check(&M, is_float, strtoul(arguments[5], NULL, 10));
    return 0;
}
