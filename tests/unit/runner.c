/*
 * All suites of one arithmetic: `unit_f32 [SUITE...]` runs these, or all; with KQ_RUN_ALL all.  suites.inc,
 * which the build writes, has a line SUITE(name) for each.  The last line is "OK" if no test has failed.
 */
#include "suite.h"

#include <stdio.h>
#include <string.h>

void (*before_each_test)(void);

static char described[120];

static char *put(char *to, const char *text)
{
    while (*text && to < described + sizeof described - 1) *to++ = *text++;
    *to = 0;
    return to;
}

static char *put_number(char *to, const char *name, int a)
{
    char digits[] = "            ", *digit = digits + sizeof digits - 1;
    unsigned rest = a < 0 ? 0u - (unsigned)a : (unsigned)a;
    do *--digit = (char)('0' + rest % 10); while (rest /= 10);
    if (a < 0) *--digit = '-';
    return put(put(put(put(to, ", "), name), " "), digit);
}

void describe(const char *what, const char *first, int a, const char *second, int b)
{
    (void)put_number(put_number(put(described, what), first, a), second, b);
}

const char *description(void) { return *described ? described : NULL; }

void setUp(void)
{
    *described = 0;
    if (before_each_test) before_each_test();
}

void tearDown(void) {}

#undef SUITE
#define SUITE(name) int suite_##name(void);
#include "suites.inc"

typedef struct {
    const char *name;
    int (*run)(void);
} suite;

#undef SUITE
#define SUITE(name) {#name, suite_##name},
static const suite suites[] = {
#include "suites.inc"
};

enum { COUNT_OF_SUITES = sizeof suites / sizeof suites[0] };

static int run(const suite *s)
{
    const int failed = s->run();
    printf("%s: %d tests, %d failed\n", s->name, (int)Unity.NumberOfTests, failed);
    return failed != 0 || Unity.NumberOfTests == 0;
}

static int run_all(void)
{
    int failed = 0;
    for (int k = 0; k < COUNT_OF_SUITES; k++) failed |= run(&suites[k]);
    return failed;
}

static int report(int failed)
{
    puts(failed ? "FAIL" : "OK");
    return failed;
}

#ifdef KQ_RUN_ALL /* a core's start-up hands over no arguments */

int main(void) { return report(run_all()); }

#else

static int run_named(const char *name)
{
    for (int k = 0; k < COUNT_OF_SUITES; k++) {
        if (strcmp(name, suites[k].name) == 0) return run(&suites[k]);
    }
    printf("no suite %s\n", name);
    return 1;
}

int main(int count, char **names)
{
    int failed = count > 1 ? 0 : run_all();
    for (int k = 1; k < count; k++) failed |= run_named(names[k]);
    return report(failed);
}

#endif
