/* Reads a problem; gives up, or ends. */
#include "demo.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

enum { STEPS_MAX = 10000000, AHEAD_MAX = 1000000 };

void fail(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fputs(PROGRAM ": ", stderr);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
    exit(EXIT_FAILURE);
}

void check(kq_status status, const char *what)
{
    if (status != KQ_OK) {
        fail("%s: %s", what, kq_status_text(status));
    }
}

void finish_output(void)
{
    puts("end");
    if (fflush(stdout) != 0 || ferror(stdout)) {
        fail("the results could not be written");
    }
}

void *allocate(size_t count, size_t size)
{
    void *memory = calloc(count > 0 ? count : 1, size);
    if (memory == NULL) {
        fail("no memory for %lu items of %lu bytes", (unsigned long)count, (unsigned long)size);
    }
    return memory;
}

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

static double read_number(reader *in, const char *name, double largest, int may_be_missing)
{
    char *end;
    read_word(in, name);
    double value = strtod(in->text, &end);
    if (*end != '\0' || (isnan(value) && !may_be_missing)) {
        fail("line %lu: '%s' in %s is not a number", in->line, in->text, name);
    }
    if (fabs(value) > largest) {
        fail("line %lu: '%s' in %s is out of range", in->line, in->text, name);
    }
    return value;
}

static double *read_matrix(reader *in, const char *name, int rows, int columns, double largest)
{
    size_t count = (size_t)rows * (size_t)columns;
    double *matrix = allocate(count, sizeof(double));
    read_name(in, name);
    for (size_t k = 0; k < count; k++) {
        matrix[k] = read_number(in, name, largest, 0);
    }
    return matrix;
}

static void read_measurements(reader *in, problem *given)
{
    size_t m = (size_t)given->m;
    given->z = allocate(given->steps * m, sizeof(double));
    given->present = allocate(given->steps, sizeof(uint32_t));
    read_name(in, "z");
    for (size_t t = 0; t < given->steps; t++) {
        for (size_t c = 0; c < m; c++) {
            double z = read_number(in, "z", (double)NUMBER_MAX, 1);
            given->z[t * m + c] = z;
            given->present[t] |= (uint32_t)!isnan(z) << c;
        }
    }
}

problem read_problem(FILE *stream)
{
    reader in = {stream, 1, ""};
    const double most = (double)NUMBER_MAX;
    problem given = {0};
    read_name(&in, "sizes");
    given.n = (int)read_size(&in, "n", 1, KQ_SIZE_MAX);
    given.m = (int)read_size(&in, "m", 1, KQ_SIZE_MAX);
    given.steps = (size_t)read_size(&in, "steps", 1, STEPS_MAX);
    given.ahead = (int)read_size(&in, "ahead", 0, AHEAD_MAX);
    given.A = read_matrix(&in, "A", given.n, given.n, most);
    given.Q = read_matrix(&in, "Q", given.n, given.n, most);
    given.H = read_matrix(&in, "H", given.m, given.n, most);
    given.R = read_matrix(&in, "R", given.m, given.m, most);
    given.x0 = read_matrix(&in, "x0", given.n, 1, most);
    given.P0 = read_matrix(&in, "P0", given.n, given.n, most);
    given.x_range = read_matrix(&in, "x_range", given.n, 1, DBL_MAX);
    given.z_range = read_matrix(&in, "z_range", given.m, 1, DBL_MAX);
    read_measurements(&in, &given);
    read_name(&in, "end");
    return given;
}
