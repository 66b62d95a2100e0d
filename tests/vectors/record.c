/*
 * record <CASE >NEW: the case with its outputs made anew.  Host only; regenerate.sh runs it for every case.
 *
 * A case that you write or change needs its operations and their inputs only.  Write a 0 for what comes
 * out: no outputs (layout 1), or any digest (layout 2).
 */
#include "vector.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ROOM = 1 << 14, WIDTH = 110, MOST_TEXT = 1 << 17 };

static char text[MOST_TEXT];
static long words[ROOM];
static size_t count;
static int32_t in[VECTOR_INPUTS], out[ROOM];
static int out_count;

static void stop(const char *why)
{
    fprintf(stderr, "record: %s\n", why);
    exit(1);
}

/* ------------------------------------------------------------------ the case as it is */

/* The text behind a comment's end, or behind what separates words */
static char *skip(char *at)
{
    for (;;) {
        at += strspn(at, ", \n");
        if (strncmp(at, "/*", 2) != 0) return at;
        at = strstr(at, "*/");
        if (!at) stop("a comment has no end");
        at += 2;
    }
}

static void read_words(void)
{
    for (char *at = skip(text), *end; *at; at = skip(end)) {
        if (count == ROOM) stop("too many words");
        words[count++] = strtol(at, &end, 10);
        if (end == at) stop("this is no word");
    }
}

static void read_case(void)
{
    const size_t length = fread(text, 1, sizeof text - 1, stdin);
    const char *title_end = strstr(text, "*/");
    if (length == sizeof text - 1 || !title_end) stop("this is no case");
    printf("%.*s\n", (int)(title_end + 2 - text), text);
    read_words();
}

/* ------------------------------------------------------------------ the new one */

static int column;

static void new_line(void)
{
    if (column) putchar('\n');
    column = 0;
}

/* A space before the word where a group begins; another line where this one is full */
static void print_word(long word, int begins)
{
    const int length = snprintf(NULL, 0, "%s%ld,", begins && column ? " " : "", word);
    if (column + length > WIDTH) new_line();
    column += printf("%s%ld,", begins && column ? " " : "", word);
}

static void print_group(const int32_t *values, int number)
{
    print_word(number, 1);
    for (int k = 0; k < number; k++) print_word(values[k], 0);
}

/* Operations without their outputs share lines; one that would be broken begins another line. */
static int is_longer_than_line(int32_t code, int inputs)
{
    int length = column + snprintf(NULL, 0, "%ld, %d, -2147483648, ", (long)code, inputs);
    for (int k = 0; k < inputs; k++) length += snprintf(NULL, 0, "%ld,", (long)in[k]);
    return length > WIDTH;
}

static void keep(void *to, const char *quantity, int index, int32_t word)
{
    (void)to;
    (void)quantity;
    (void)index;
    if (out_count == ROOM) stop("too much comes out");
    out[out_count++] = word;
}

static void print_operation(int32_t code, int inputs, int is_full)
{
    uint32_t digest = VECTOR_DIGEST_OF_NOTHING;
    for (int k = 0; k < out_count; k++) digest = vector_digest(digest, out[k]);
    if (is_full || is_longer_than_line(code, inputs)) new_line();
    if (is_full) column += printf("/* %s */", vector_name(code));
    print_word(code, 1);
    print_group(in, inputs);
    if (is_full) print_group(out, out_count);
    else print_word(vector_word_of(digest), 1);
}

/* Answers the position behind the operation. */
static size_t record_operation(size_t at, int is_full)
{
    if (at + 3 > count || words[at + 1] < 0 || words[at + 1] > VECTOR_INPUTS) stop("an operation is cut short");
    const int32_t code = (int32_t)words[at];
    const int inputs = (int)words[at + 1];
    at += 2;
    if (at + (size_t)inputs + 1 > count) stop("inputs are missing");
    for (int k = 0; k < inputs; k++) in[k] = (int32_t)words[at++];
    out_count = 0;
    if (vector_operate(code, in, (size_t)inputs, &(vector_sink){keep, NULL})) stop(vector_name(code));
    print_operation(code, inputs, is_full);
    return at + 1 + (is_full ? (size_t)words[at] : 0);
}

int main(void)
{
    read_case();
    const int is_full = count && words[0] == VECTOR_FULL;
    if (count < 2 || (!is_full && words[0] != VECTOR_DIGESTS)) stop("a case begins with its layout");
    printf("%ld,\n", words[0]);
    size_t at = 1;
    while (at < count && words[at] != VECTOR_END) at = record_operation(at, is_full);
    if (at + 1 != count) stop("a case ends with 0");
    new_line();
    printf("%d\n", VECTOR_END);
    return 0;
}
