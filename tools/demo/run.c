/*
 * kq_demo_f32, kq_demo_f64: filter, forecast and smooth one sequence with kalmanq.
 *
 *     kq_demo_f32 < problem > results
 *
 * The problem is text: words and numbers between white space, `#` starts a comment.
 *
 *     sizes n m steps ahead       1..16, 1..16, 1..10000000, 0..1000000
 *     A     n x n numbers         row by row, like all matrices
 *     Q     n x n
 *     H     m x n
 *     R     m x m
 *     x0    n                     the state before the first measurement
 *     P0    n x n
 *     z     steps x m             `nan`: this component was not measured
 *     end
 *
 * The results are text too, one record a line:
 *
 *     log_likelihood NUMBER
 *     events BITS                 KQ_EVENT_... of status.h
 *     memory model B process B sensor B filter B history B           bytes on this host
 *     step T      mean[n] sigma[n] smoothed_mean[n] smoothed_sigma[n]      T = 0 .. steps - 1
 *     forecast K  mean[n] sigma[n] z[m] z_sigma[m]                         K = 1 .. ahead
 *     end
 *
 * Bad input: one line on stderr, nothing on stdout, exit status 1.
 */
#include "arithmetic.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { STEPS_MAX = 10000000, AHEAD_MAX = 1000000 };

typedef struct {
    int n, m, ahead;
    size_t steps;
    real *A, *Q, *H, *R, *x0, *P0;
    real *z;                           /* steps x m */
    uint32_t *present;                 /* steps: bit c: component c was measured */
} problem;

/* What is read off the filter, row by row: mean and sigma of what there are `width` of. */
typedef struct {
    double *mean, *sigma;
    int width;
} estimates;

typedef struct {
    estimates filtered;                /* steps rows, n wide */
    estimates forecast;                /* ahead rows, n wide */
    estimates forecast_z;              /* ahead rows, m wide */
    double log_likelihood;
    unsigned events;
} results;

/* The library's objects, with their memory from malloc. */
typedef struct {
    process motion;
    sensor gauge;
    filter track, future;
    history tape;
} objects;

#if defined(__GNUC__)
__attribute__((format(printf, 1, 2), noreturn))
#endif
static void fail(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fputs(PROGRAM ": ", stderr);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
    exit(EXIT_FAILURE);
}

static void check(kq_status status, const char *what)
{
    if (status != KQ_OK) {
        fail("%s: %s", what, kq_status_text(status));
    }
}

static void *allocate(size_t count, size_t size)
{
    void *memory = calloc(count > 0 ? count : 1, size);
    if (memory == NULL) {
        fail("no memory for %lu items of %lu bytes", (unsigned long)count, (unsigned long)size);
    }
    return memory;
}

static real *numbers(size_t count)
{
    return allocate(count, sizeof(real));
}

static estimates estimates_of(size_t rows, int width)
{
    estimates e = {NULL, NULL, width};
    e.mean = allocate(rows * (size_t)width, sizeof(double));
    e.sigma = allocate(rows * (size_t)width, sizeof(double));
    return e;
}

/* ---- reading ----------------------------------------------------------------------------- */

typedef struct {
    FILE *stream;
    unsigned long line;
    char text[64];                     /* the word read last */
} reader;

/* The first character of the next word, past white space and comments. */
static int skip_blank(reader *in)
{
    int comment = 0;
    for (;;) {
        int c = getc(in->stream);
        comment = (comment || c == '#') && c != '\n';
        in->line += c == '\n';
        if (c == EOF || (!comment && !isspace(c))) {
            return c;
        }
    }
}

static void read_word(reader *in, const char *expected)
{
    size_t length = 0;
    int c = skip_blank(in);
    for (; c != EOF && !isspace(c) && c != '#'; c = getc(in->stream)) {
        if (length + 1 == sizeof in->text) {
            fail("line %lu: a word of more than %lu characters where %s should be", in->line,
                 (unsigned long)length, expected);
        }
        in->text[length++] = isprint(c) ? (char)c : '?';
    }
    in->text[length] = '\0';
    if (length == 0) {
        fail("line %lu: the input ends where %s should be", in->line, expected);
    }
    ungetc(c, in->stream);
}

static void read_name(reader *in, const char *name)
{
    read_word(in, name);
    if (strcmp(in->text, name) != 0) {
        fail("line %lu: '%s' where %s should be", in->line, in->text, name);
    }
}

static long read_size(reader *in, const char *name, long least, long most)
{
    char *end;
    errno = 0;
    read_word(in, name);
    long value = strtol(in->text, &end, 10);
    if (*end != '\0' || errno != 0 || value < least || value > most) {
        fail("line %lu: %s is '%s', not a whole number from %ld to %ld", in->line, name, in->text,
             least, most);
    }
    return value;
}

static real read_number(reader *in, const char *name, int may_be_missing)
{
    char *end;
    read_word(in, name);
    double value = strtod(in->text, &end);
    if (*end != '\0' || (isnan(value) && !may_be_missing)) {
        fail("line %lu: '%s' in %s is not a number", in->line, in->text, name);
    }
    if (fabs(value) > (double)REAL_MAX) {
        fail("line %lu: '%s' in %s is out of range", in->line, in->text, name);
    }
    return (real)value;
}

static real *read_matrix(reader *in, const char *name, int rows, int columns)
{
    size_t count = (size_t)rows * (size_t)columns;
    real *matrix = numbers(count);
    read_name(in, name);
    for (size_t k = 0; k < count; k++) {
        matrix[k] = read_number(in, name, 0);
    }
    return matrix;
}

static void read_measurements(reader *in, problem *given)
{
    size_t m = (size_t)given->m;
    given->z = numbers(given->steps * m);
    given->present = allocate(given->steps, sizeof(uint32_t));
    read_name(in, "z");
    for (size_t t = 0; t < given->steps; t++) {
        for (size_t c = 0; c < m; c++) {
            real z = read_number(in, "z", 1);
            given->z[t * m + c] = z;
            given->present[t] |= (uint32_t)!isnan(z) << c;
        }
    }
}

static problem read_problem(FILE *stream)
{
    reader in = {stream, 1, ""};
    problem given = {0};
    read_name(&in, "sizes");
    given.n = (int)read_size(&in, "n", 1, KQ_SIZE_MAX);
    given.m = (int)read_size(&in, "m", 1, KQ_SIZE_MAX);
    given.steps = (size_t)read_size(&in, "steps", 1, STEPS_MAX);
    given.ahead = (int)read_size(&in, "ahead", 0, AHEAD_MAX);
    given.A = read_matrix(&in, "A", given.n, given.n);
    given.Q = read_matrix(&in, "Q", given.n, given.n);
    given.H = read_matrix(&in, "H", given.m, given.n);
    given.R = read_matrix(&in, "R", given.m, given.m);
    given.x0 = read_matrix(&in, "x0", given.n, 1);
    given.P0 = read_matrix(&in, "P0", given.n, given.n);
    read_measurements(&in, &given);
    read_name(&in, "end");
    return given;
}

/* ---- the library at work ----------------------------------------------------------------- */

static void prepare_filter(filter *f, int n)
{
    size_t length = (size_t)FILTER_LEN(n);
    check(KQ(filter_assign)(f, n, numbers(length), length), "filter");
}

static objects prepare(const problem *given)
{
    objects o = {0};
    int n = given->n, m = given->m;
    size_t process_length = KQ_PROCESS_LEN((size_t)n);
    size_t sensor_length = KQ_SENSOR_LEN((size_t)m);
    size_t tape_length = HISTORY_LEN((size_t)n, (size_t)m, given->steps);

    check(KQ(process_assign)(&o.motion, n, 0, numbers(process_length), process_length), "process");
    check(KQ(process_init)(&o.motion, given->A, NULL, given->Q), "A, Q");
    check(KQ(sensor_assign)(&o.gauge, n, m, numbers(sensor_length), sensor_length), "sensor");
    check(KQ(sensor_init)(&o.gauge, given->H, given->R), "H, R");
    prepare_filter(&o.track, n);
    prepare_filter(&o.future, n);
    check(KQ(filter_init)(&o.track, given->x0, given->P0), "x0, P0");
    check(KQ(history_assign)(&o.tape, n, numbers(tape_length), tape_length), "history");
    return o;
}

static void note_state(const estimates *e, size_t row, const filter *f)
{
    for (int i = 0; i < e->width; i++) {
        size_t k = row * (size_t)e->width + (size_t)i;
        e->mean[k] = (double)KQ(mean)(f, i) + (double)KQ(mean_low)(f, i);
        e->sigma[k] = (double)KQ(sigma)(f, i);
    }
}

static void note_measurement(const estimates *e, size_t row, const filter *f, const sensor *s)
{
    real z[KQ_SIZE_MAX], S[KQ_SIZE_MAX * KQ_SIZE_MAX];
    int m = e->width;
    check(KQ(measurement)(f, s, z, S), "measurement");
    for (int c = 0; c < m; c++) {
        size_t k = row * (size_t)m + (size_t)c;
        e->mean[k] = (double)z[c];
        e->sigma[k] = sqrt((double)S[c * m + c]);
    }
}

/* Update, predict, update, ..., update: no predict after the last measurement. */
static void run_filter(objects *o, const problem *given, results *found)
{
    found->filtered = estimates_of(given->steps, given->n);
    check(KQ(history_attach)(&o->tape, &o->track), "history");
    for (size_t t = 0; t < given->steps; t++) {
        const real *z = given->z + t * (size_t)given->m;
        if (t > 0) {
            check(KQ(predict)(&o->track, &o->motion, NULL), "predict");
        }
        check(KQ(update_subset)(&o->track, &o->gauge, z, given->present[t]), "update");
        note_state(&found->filtered, t, &o->track);
    }
    found->log_likelihood = (double)KQ(log_likelihood)(&o->track);
    found->events = KQ(events)(&o->track);
}

/* One forecast a line: the first from the filter, each later one a step further. */
static void run_forecast(objects *o, const problem *given, results *found)
{
    found->forecast = estimates_of((size_t)given->ahead, given->n);
    found->forecast_z = estimates_of((size_t)given->ahead, given->m);
    check(KQ(forecast)(&o->track, &o->motion, NULL, 0, &o->future), "forecast");
    for (int k = 0; k < given->ahead; k++) {
        check(KQ(predict)(&o->future, &o->motion, NULL), "forecast");
        note_state(&found->forecast, (size_t)k, &o->future);
        note_measurement(&found->forecast_z, (size_t)k, &o->future, &o->gauge);
    }
}

static void run_smoother(objects *o, const problem *given)
{
    check(KQ(smooth)(&o->tape), "smoother");
    if (KQ(history_steps)(&o->tape) != given->steps) {
        fail("the history holds %lu steps, not %lu",
             (unsigned long)KQ(history_steps)(&o->tape), (unsigned long)given->steps);
    }
}

/* ---- writing ----------------------------------------------------------------------------- */

/* What a target would need for the same work; the model is the caller's A, H and R. */
static void write_memory(const problem *given)
{
    size_t n = (size_t)given->n, m = (size_t)given->m, word = sizeof(real);
    printf("memory model %lu process %lu sensor %lu filter %lu history %lu\n",
           (unsigned long)((n * n + m * n + m * m) * word),
           (unsigned long)(sizeof(process) + KQ_PROCESS_LEN(n) * word),
           (unsigned long)(sizeof(sensor) + KQ_SENSOR_LEN(m) * word),
           (unsigned long)(sizeof(filter) + FILTER_LEN(n) * word),
           (unsigned long)(sizeof(history) + HISTORY_LEN(n, m, given->steps) * word));
}

static void write_row(const double *values, size_t row, int width)
{
    for (int i = 0; i < width; i++) {
        printf(" %.17g", values[row * (size_t)width + (size_t)i]);
    }
}

static void write_smoothed(const history *tape, size_t t, int n)
{
    for (int i = 0; i < n; i++) {
        printf(" %.17g", (double)KQ(smoothed_mean)(tape, t, i) +
                         (double)KQ(smoothed_mean_low)(tape, t, i));
    }
    for (int i = 0; i < n; i++) {
        printf(" %.17g", (double)KQ(smoothed_sigma)(tape, t, i));
    }
}

static void write_results(const objects *o, const problem *given, const results *found)
{
    printf("log_likelihood %.17g\n", found->log_likelihood);
    printf("events %u\n", found->events);
    write_memory(given);
    for (size_t t = 0; t < given->steps; t++) {
        printf("step %lu", (unsigned long)t);
        write_row(found->filtered.mean, t, given->n);
        write_row(found->filtered.sigma, t, given->n);
        write_smoothed(&o->tape, t, given->n);
        putchar('\n');
    }
    for (size_t k = 0; k < (size_t)given->ahead; k++) {
        printf("forecast %lu", (unsigned long)k + 1);
        write_row(found->forecast.mean, k, given->n);
        write_row(found->forecast.sigma, k, given->n);
        write_row(found->forecast_z.mean, k, given->m);
        write_row(found->forecast_z.sigma, k, given->m);
        putchar('\n');
    }
    puts("end");
    if (fflush(stdout) != 0 || ferror(stdout)) {
        fail("the results could not be written");
    }
}

/* All memory lives as long as the program: the system takes it back. */
int main(void)
{
    results found = {0};
    problem given = read_problem(stdin);
    objects o = prepare(&given);
    run_filter(&o, &given, &found);
    run_forecast(&o, &given, &found);
    run_smoother(&o, &given);
    write_results(&o, &given, &found);
    return EXIT_SUCCESS;
}
