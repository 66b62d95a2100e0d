/*
 * A file of tests is a suite, named as the file: test_laws.c.  A test of it begins with
 *
 *     TEST(smoothing_does_not_change_the_filter)
 *
 * and it ends with
 *
 *     SUITE(laws, set_up)
 *     #include "laws.tests"
 *
 * where set_up, or NULL, is called before each test, and laws.tests, which the build writes (suites.cmake), runs
 * every TEST of the file.  All suites of an arithmetic are one program, and runner.c calls them by their names;
 * so what a file defines is static.
 */
#ifndef KALMANQ_TESTS_SUITE_H
#define KALMANQ_TESTS_SUITE_H

#include <stddef.h>

#include "unity.h"

extern void (*before_each_test)(void);

#define TEST(name) static void name(void)

/* Where KQ_TEST_Q31 is not defined, or is: the lists have these tests of such an arithmetic alone. */
#define TEST_FLOAT TEST
#define TEST_Q31 TEST

/* suite_<name> answers how many of the tests have failed */
#define SUITE(name, set_up)                                                                        \
    static void run_suite_##name(void);                                                            \
    int suite_##name(void);                                                                        \
    int suite_##name(void)                                                                         \
    {                                                                                              \
        UNITY_BEGIN();                                                                             \
        before_each_test = set_up;                                                                 \
        run_suite_##name();                                                                        \
        return UNITY_END();                                                                        \
    }                                                                                              \
    static void run_suite_##name(void)

/* What a failure is told with, until the next test: describe("plain", "seed", 3, "step", 5).  NULL if nothing */
void describe(const char *what, const char *first, int a, const char *second, int b);
const char *description(void);

#endif
