#include "script.h"

#include "vector.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ROOM = 1 << 16, WIDTH = 96 };

static int32_t inputs[ROOM], outputs[ROOM];
static int32_t mean_words[16]; /* of the filter, when it came out last */
static int input_count, output_count, input_column;
static FILE *file;

/* ------------------------------------------------------------------ the file */

static void stop(const char *why)
{
    fprintf(stderr, "generate: %s\n", why);
    exit(1);
}

void script_begin(const char *directory, const char *name, const char *title)
{
    char path[4096];
    if (snprintf(path, sizeof path, "%s/%s.inc", directory, name) >= (int)sizeof path) stop(name);
    file = fopen(path, "wb");
    if (!file) stop(path);
    fprintf(file, "/* %s. */\n%d,\n", title, VECTOR_LAYOUT);
}

void script_end(void)
{
    fprintf(file, "%d\n", VECTOR_END);
    if (fclose(file)) stop("a file cannot be written");
}

static void print_word(int32_t word)
{
    char text[16];
    const int length = snprintf(text, sizeof text, "%ld,", (long)word);
    if (input_column && input_column + length > WIDTH) {
        fputc('\n', file);
        input_column = 0;
    }
    input_column += length;
    fputs(text, file);
}

static void print_words(const int32_t *words, int count)
{
    print_word(count);
    for (int k = 0; k < count; k++) print_word(words[k]);
    fputc('\n', file);
    input_column = 0;
}

/* ------------------------------------------------------------------ one operation */

void script_words(const int32_t *words, int count)
{
    if (input_count + count > ROOM) stop("an operation is too long");
    for (int k = 0; k < count; k++) inputs[input_count++] = words[k];
}

void script_word(int32_t word) { script_words(&word, 1); }

static void keep(void *to, const char *quantity, int index, int32_t word)
{
    (void)to;
    if (output_count == ROOM) stop("too much comes out");
    if (strcmp(quantity, "mean") == 0) mean_words[index] = word;
    outputs[output_count++] = word;
}

void script_act(int32_t operation)
{
    output_count = 0;
    if (vector_operate(operation, inputs, (size_t)input_count, &(vector_sink){keep, NULL})) {
        stop(vector_name(operation));
    }
    fprintf(file, "/* %s */\n", vector_name(operation));
    print_word(operation);
    print_words(inputs, input_count);
    print_words(outputs, output_count);
    input_count = 0;
}

void script_number(double value)
{
    int32_t exponent = 0;
    double size = value < 0 ? -value : value;
    for (; size >= 0x1p31; size /= 2) exponent++;
    for (; size > 0 && size < 0x1p30; size *= 2) exponent--;
    script_word(value < 0 ? -(int32_t)size : (int32_t)size);
    script_word(exponent);
}

/* ------------------------------------------------------------------ models into words */

static kq_format_q31 state_format[16], control_format[16], measurement_format[16];
static kq_scaled_q31 numbers[16 * 16];
static int32_t root[KQ_ROOT_LEN_Q31(16)];

static void need(kq_status status, const char *what)
{
    if (status) {
        fprintf(stderr, "generate: %s: %s\n", what, kq_status_text(status));
        exit(1);
    }
}

static void put_formats(const kq_format_q31 *format, int count)
{
    for (int i = 0; i < count; i++) {
        script_word(format[i].range);
        script_word(format[i].fraction);
    }
}

static void make_formats(kq_format_q31 *format, const double *range, int count)
{
    for (int i = 0; i < count; i++) need(kq_format_prepare_q31(&format[i], range[i]), "a range");
}

static void put_numbers(int count)
{
    for (int k = 0; k < count; k++) {
        script_word(numbers[k].mantissa);
        script_word(numbers[k].exponent);
    }
}

static void put_matrix(const double *M, int rows, int columns, const kq_format_q31 *row_format,
                       const kq_format_q31 *column_format)
{
    need(kq_matrix_prepare_q31(numbers, M, rows, columns, row_format, column_format), "a matrix");
    put_numbers(rows * columns);
}

static void put_vector(const double *x, int count, const kq_format_q31 *format)
{
    int32_t words[16];
    need(kq_vector_prepare_q31(words, x, count, format, NULL), "a vector");
    script_words(words, count);
}

static void put_controls(const double *u, int steps, int l)
{
    script_word(u != NULL);
    for (int k = 0; u && l && k < steps; k++) put_vector(u + k * l, l, control_format);
}

void script_controls(const model *M, const double *u) { put_controls(u, 1, M->l); }

void script_states(const model *M)
{
    make_formats(state_format, M->state_range, M->n);
    script_word(M->n);
    put_formats(state_format, M->n);
    script_act(VECTOR_STATES);
}

void script_process(const model *M, int slot)
{
    make_formats(control_format, M->control_range, M->l);
    script_word(slot);
    script_word(M->l);
    put_formats(control_format, M->l);
    put_matrix(M->A, M->n, M->n, state_format, state_format);
    if (M->l) put_matrix(M->B, M->n, M->l, state_format, control_format);
    need(kq_root_prepare_factor_q31(root, M->F, M->n, M->r, state_format), "Q");
    script_words(root, KQ_ROOT_LEN_Q31(M->n));
    script_act(VECTOR_PROCESS);
}

static int is_correlated(const model *M)
{
    for (int c = 0; c < M->m; c++) {
        for (int k = 0; k < c; k++) {
            if (M->C[c * M->m + k] != 0) return 1;
        }
    }
    return 0;
}

/* R = C C', C lower triangular */
static void put_noise(const model *M, int correlated)
{
    double R[16 * 16], variance[16];
    const int m = M->m;
    for (int c = 0; c < m; c++) {
        for (int j = 0; j < m; j++) {
            double total = 0;
            for (int k = 0; k < m; k++) total += M->C[c * m + k] * M->C[j * m + k];
            R[c * m + j] = total;
        }
        variance[c] = R[c * m + c];
    }
    need(correlated ? kq_noise_prepare_q31(numbers, R, m, measurement_format)
                    : kq_noise_prepare_diagonal_q31(numbers, variance, m, measurement_format),
         "R");
    put_numbers(correlated ? KQ_TRIANGLE(m) : m);
}

void script_sensor(const model *M, int slot)
{
    const int correlated = is_correlated(M);
    make_formats(measurement_format, M->measurement_range, M->m);
    script_word(slot);
    script_word(M->m);
    script_word(correlated);
    put_formats(measurement_format, M->m);
    put_matrix(M->H, M->m, M->n, measurement_format, state_format);
    put_noise(M, correlated);
    script_act(VECTOR_SENSOR);
}

void script_state(const model *M, const double *x) { put_vector(x, M->n, state_format); }

void script_mean(const model *M, double *x)
{
    for (int i = 0; i < M->n; i++) x[i] = ldexp((double)mean_words[i], -(int)state_format[i].fraction);
}

void script_distribution(const model *M)
{
    double P0[16 * 16] = {0};
    for (int i = 0; i < M->n; i++) P0[i * M->n + i] = M->P0[i];
    put_vector(M->x0, M->n, state_format);
    need(kq_root_prepare_q31(root, P0, M->n, state_format), "P0");
    script_words(root, KQ_ROOT_LEN_Q31(M->n));
}

void script_prior(const model *M)
{
    script_distribution(M);
    script_act(VECTOR_PRIOR);
}

void script_transition_by(const model *M, int slot, int32_t operation)
{
    script_word(slot);
    put_matrix(M->A, M->n, M->n, state_format, state_format);
    script_act(operation);
}

void script_transition(const model *M, int slot) { script_transition_by(M, slot, VECTOR_TRANSITION); }

void script_measurement_by(const model *M, int slot, int32_t operation)
{
    script_word(slot);
    make_formats(measurement_format, M->measurement_range, M->m);
    put_matrix(M->H, M->m, M->n, measurement_format, state_format);
    script_act(operation);
}

void script_measurement(const model *M, int slot) { script_measurement_by(M, slot, VECTOR_MEASUREMENT); }

/* ------------------------------------------------------------------ what a filter does */

void script_history(int words)
{
    script_word(words);
    script_act(VECTOR_HISTORY);
}

void script_predict(const model *M, int slot, const double *u)
{
    script_word(slot);
    script_controls(M, u);
    script_act(VECTOR_PREDICT);
}

void script_reading(const model *M, const double *z)
{
    make_formats(measurement_format, M->measurement_range, M->m);
    put_vector(z, M->m, measurement_format);
}

void script_update(const model *M, int slot, const double *z, int present)
{
    script_word(slot);
    script_word(present);
    script_reading(M, z);
    script_act(VECTOR_UPDATE);
}

void script_step(const model *M, const double *u, const double *z)
{
    script_word(0);
    script_word(0);
    script_controls(M, u);
    script_reading(M, z);
    script_act(VECTOR_STEP);
}

void script_read(void) { script_act(VECTOR_READ); }

void script_look(const model *M, int slot, const double *z)
{
    script_word(slot);
    script_reading(M, z);
    script_act(VECTOR_LOOK);
}

void script_forecast(const model *M, int steps, const double *u)
{
    script_word(0);
    script_word(0);
    script_word(steps);
    put_controls(u, steps, M->l);
    script_act(VECTOR_FORECAST);
}

void script_smooth(int process, int what)
{
    script_word(process);
    script_word(what);
    script_act(VECTOR_SMOOTH);
}

void script_smooth_all(int states_only)
{
    script_word(states_only);
    script_act(VECTOR_SMOOTH_ALL);
}

void script_run(int process, int sensor, int steps, int32_t seed, int shift)
{
    script_word(process);
    script_word(sensor);
    script_word(steps);
    script_word(seed);
    script_word(shift);
    script_act(VECTOR_RUN);
}

/* ------------------------------------------------------------------ simulation */

static double uniform(uint64_t *seed)
{
    *seed ^= *seed << 13;
    *seed ^= *seed >> 7;
    *seed ^= *seed << 17;
    return (double)(*seed >> 11) * 0x1p-53;
}

/* Twelve uniforms: near enough to normal, and the same bits on every machine */
static double normal(uint64_t *seed)
{
    double total = -6;
    for (int k = 0; k < 12; k++) total += uniform(seed);
    return total;
}

/* out += M x */
static void add_product(double *out, const double *M, const double *x, int rows, int columns)
{
    for (int i = 0; i < rows; i++) {
        for (int k = 0; k < columns; k++) out[i] += M[i * columns + k] * x[k];
    }
}

static void draw_normals(double *w, int count, uint64_t *seed)
{
    for (int k = 0; k < count; k++) w[k] = normal(seed);
}

/* The truth begins half a sigma beside the prior's mean. */
void truth_begin(truth *t, const model *M, uint64_t seed)
{
    t->seed = seed;
    for (int i = 0; i < M->n; i++) {
        double sigma = M->P0[i] > 1 ? M->P0[i] : 1; /* Newton's root, alike everywhere */
        for (int k = 0; k < 60; k++) sigma = 0.5 * (sigma + M->P0[i] / sigma);
        t->x[i] = M->x0[i] + 0.5 * sigma * (i % 2 ? -1 : 1);
    }
}

void truth_advance(truth *t, const model *M, const double *u)
{
    double next[16] = {0}, w[16];
    draw_normals(w, M->r, &t->seed);
    add_product(next, M->A, t->x, M->n, M->n);
    if (u) add_product(next, M->B, u, M->n, M->l);
    add_product(next, M->F, w, M->n, M->r);
    for (int i = 0; i < M->n; i++) t->x[i] = next[i];
}

void truth_measure(truth *t, const model *M, double *z)
{
    double v[16];
    draw_normals(v, M->m, &t->seed);
    for (int c = 0; c < M->m; c++) z[c] = 0;
    add_product(z, M->H, t->x, M->m, M->n);
    add_product(z, M->C, v, M->m, M->m);
}
