/* Lengths as functions are those of the macros, and 0 for a size that is none: one text for all arithmetics. */
#include <limits.h>
#include <stdint.h>

#include "kalmanq/lengths.h"
#include "suite.h"

#if defined(KQ_TEST_F32)
typedef float word;
#define S(name) kq_##name##_f32
#define LEN(object) KQ_##object##_LEN_F32
#elif defined(KQ_TEST_F64)
typedef double word;
#define S(name) kq_##name##_f64
#define LEN(object) KQ_##object##_LEN_F64
#else
typedef int32_t word;
#define S(name) kq_##name##_q31
#define LEN(object) KQ_##object##_LEN_Q31
#endif

#define OF(object, n, m, k, l) S(length)(KQ_OBJECT_##object, n, m, k, l)

#define COUNT(array) ((int)(sizeof(array) / sizeof((array)[0])))
#define ASSERT_LENGTH(expected, actual) TEST_ASSERT_TRUE((kq_length)(expected) == (actual))
#define ASSERT_NONE(actual) ASSERT_LENGTH(0, actual)

/* Of one step, of all sensors together: more than one sensor has */
static const int measurements[] = {1, 2, 16, 17, 18, 33, 1000, 32767};
static const size_t counts[] = {0, 1, 2, 3, 100, 32767, KQ_COUNT_MAX};
static const int no_size[] = {0, -1, 17, 258, -254, INT_MAX, INT_MIN};
static const size_t no_count[] = {KQ_COUNT_MAX + 1, SIZE_MAX};

TEST(those_of_a_step_are_the_macros)
{
    for (int n = 1; n <= KQ_SIZE_MAX; n++) {
        for (int k = 0; k < COUNT(measurements); k++) {
            const int m = measurements[k];
            ASSERT_LENGTH(LEN(INSTANT)(n, m), OF(INSTANT, n, m, 0, 0));
            for (int c = 0; c < COUNT(counts); c++) {
                const size_t steps = counts[c];
                ASSERT_LENGTH(LEN(HISTORY)(n, m, steps, 2), OF(HISTORY, n, m, steps, 2));
                ASSERT_LENGTH(LEN(HISTORY)(n, m, 3, steps), OF(HISTORY, n, m, 3, steps));
                ASSERT_LENGTH(LEN(LAG)(n, m, steps), OF(LAG, n, m, steps, 0));
            }
        }
    }
}

TEST(those_of_sizes_are_the_macros)
{
    for (int n = 1; n <= KQ_SIZE_MAX; n++) {
        ASSERT_LENGTH(LEN(FILTER)(n), OF(FILTER, n, 0, 0, 0));
        ASSERT_LENGTH(LEN(STEADY)(n), OF(STEADY, n, 0, 0, 0));
        ASSERT_LENGTH(LEN(FREEZE)(n), OF(FREEZE, n, 0, 0, 0));
        ASSERT_LENGTH(LEN(DIFFUSE)(n, 0), OF(DIFFUSE, n, 0, 0, 0));
        ASSERT_LENGTH(LEN(DIFFUSE)(n, (size_t)65534), OF(DIFFUSE, n, 0, 65534, 0));
        ASSERT_LENGTH(LEN(CONSISTENCY)(n, KQ_WINDOW_MAX), OF(CONSISTENCY, 0, n, KQ_WINDOW_MAX, 0));
        for (int m = 1; m <= KQ_SIZE_MAX; m++) {
            ASSERT_LENGTH(LEN(ADAPTATION)(n, m), OF(ADAPTATION, n, m, 0, 0));
        }
    }
}

/* With it assign is content, and not with a word less, nor with none. */
#define ASSERT_ASKED(asked, call)                                                                  \
    for (size_t less = 0; less < 3; less++) {                                                      \
        const size_t length = less == 2 ? 0 : (asked)-less;                                        \
        TEST_ASSERT_EQUAL_INT(less ? KQ_ERR_MEMORY : KQ_OK, call);                                 \
    }

TEST(it_is_what_assign_asks_for)
{
    static word memory[1]; /* assign does not look at it */
    static S(lag) lag;
    static S(instant) point;
    static S(filter) filter;
#ifndef KQ_TEST_Q31
    static S(process) process;
    static S(sensor) sensor;
#endif
    for (int n = 1; n <= KQ_SIZE_MAX; n++) {
        ASSERT_ASKED((size_t)LEN(FILTER)(n), S(filter_assign)(&filter, n, memory, length));
#ifndef KQ_TEST_Q31
        ASSERT_ASKED((size_t)KQ_PROCESS_LEN(n), S(process_assign)(&process, n, 0, memory, length));
        ASSERT_ASKED((size_t)KQ_SENSOR_DIAGONAL_LEN(n), S(sensor_assign)(&sensor, 2, n, memory, length));
#endif
    }
    for (int k = 0; k < COUNT(measurements); k++) {
        const int m = measurements[k];
        const kq_length past = OF(LAG, 2, m, 3, 0), instant = OF(INSTANT, 2, m, 0, 0);
        if (past > SIZE_MAX || instant > SIZE_MAX) continue;
        ASSERT_ASKED((size_t)past, S(lag_assign)(&lag, 2, m, 3, memory, length));
        ASSERT_ASKED((size_t)instant, S(instant_assign)(&point, 2, m, memory, length));
    }
}

TEST(a_size_that_is_none_has_no_length)
{
    for (int k = 0; k < COUNT(no_size); k++) {
        const int n = no_size[k];
        ASSERT_NONE(OF(FILTER, n, 0, 0, 0));
        ASSERT_NONE(OF(HISTORY, n, 1, 1, 0));
        ASSERT_NONE(OF(LAG, n, 1, 1, 0));
        ASSERT_NONE(OF(INSTANT, n, 1, 0, 0));
        ASSERT_NONE(OF(DIFFUSE, n, 0, 0, 0));
        ASSERT_NONE(OF(STEADY, n, 0, 0, 0));
        ASSERT_NONE(OF(FREEZE, n, 0, 0, 0));
        ASSERT_NONE(OF(ADAPTATION, n, 1, 0, 0));
        ASSERT_NONE(OF(ADAPTATION, 1, n, 0, 0));
        ASSERT_NONE(OF(CONSISTENCY, 0, n, 1, 0));
    }
    for (int m = -1; m <= 0; m++) {
        ASSERT_NONE(OF(HISTORY, 1, m, 1, 0));
        ASSERT_NONE(OF(LAG, 1, m, 1, 0));
        ASSERT_NONE(OF(INSTANT, 1, m, 0, 0));
    }
    ASSERT_NONE(OF(HISTORY, 1, INT_MIN, 1, 0));
    ASSERT_NONE(OF(INSTANT, 1, INT_MIN, 0, 0));
}

TEST(nor_has_a_count)
{
    for (int k = 0; k < COUNT(no_count); k++) {
        ASSERT_NONE(OF(HISTORY, 1, 1, no_count[k], 0));
        ASSERT_NONE(OF(HISTORY, 1, 1, 1, no_count[k]));
        ASSERT_NONE(OF(LAG, 1, 1, no_count[k], 0));
        /* these have bounds of their own, which may be above all counts of a small part */
        if (no_count[k] >= UINT16_MAX) {
            ASSERT_NONE(OF(DIFFUSE, 1, 0, no_count[k], 0));
        }
        if (no_count[k] > KQ_WINDOW_MAX) {
            ASSERT_NONE(OF(CONSISTENCY, 0, 1, no_count[k], 0));
        }
    }
    ASSERT_NONE(OF(DIFFUSE, 1, 0, UINT16_MAX, 0));
    ASSERT_NONE(OF(CONSISTENCY, 0, 1, 0, 0));
    ASSERT_NONE(OF(CONSISTENCY, 0, 1, KQ_WINDOW_MAX + 1, 0));
#if INT_MAX > 65535 /* a step records no more: with all steps that there may be the length would wrap */
    ASSERT_NONE(OF(HISTORY, 1, 65536, 1, 0));
    ASSERT_LENGTH(LEN(HISTORY)(1, 65535, 1, 0), OF(HISTORY, 1, 65535, 1, 0));
#endif
}

/* What an arithmetic has no memory for, or no object of */
TEST(what_is_not_there_has_none)
{
#ifdef KQ_TEST_Q31
    ASSERT_LENGTH(KQ_ROOT_LEN_Q31(5), OF(ROOT, 5, 0, 0, 0));
    ASSERT_NONE(OF(PROCESS, 5, 0, 0, 0));
    ASSERT_NONE(OF(SENSOR, 0, 5, 0, 0));
    ASSERT_NONE(OF(EM, 5, 2, 100, 0));
    ASSERT_NONE(OF(STEADY_SOLVE, 5, 2, 0, 0));
    TEST_ASSERT_TRUE(S(object_size)(KQ_OBJECT_EM) == 0);
#else
    for (int k = 0; k < COUNT(no_size); k++) {
        ASSERT_NONE(OF(PROCESS, no_size[k], 0, 0, 0));
        ASSERT_NONE(OF(SENSOR, 0, no_size[k], 0, 0));
        ASSERT_NONE(OF(EM, no_size[k], 1, 1, 0));
        ASSERT_NONE(OF(EM, 1, no_size[k], 1, 0));
        ASSERT_NONE(OF(STEADY_SOLVE, no_size[k], 1, 0, 0));
        ASSERT_NONE(OF(STEADY_SOLVE, 1, no_size[k], 0, 0));
    }
    for (int n = 1; n <= KQ_SIZE_MAX; n++) {
        ASSERT_LENGTH(KQ_PROCESS_LEN(n), OF(PROCESS, n, 0, 0, 0));
        ASSERT_LENGTH(KQ_SENSOR_LEN(n), OF(SENSOR, 0, n, 0, 0));
        ASSERT_LENGTH(LEN(EM)(n, 2, 100), OF(EM, n, 2, 100, 0));
        ASSERT_LENGTH(KQ_CONTINUOUS_LEN(n, 16), OF(CONTINUOUS, n, 0, 16, 0));
        ASSERT_LENGTH(KQ_CORRELATED_LEN(n, 16 - n, n), OF(CORRELATED, n, n, (size_t)(16 - n), 0));
        ASSERT_LENGTH(LEN(STEADY_SOLVE)((size_t)n, (size_t)2), OF(STEADY_SOLVE, n, 2, 0, 0));
    }
    ASSERT_NONE(OF(EM, 1, 1, SIZE_MAX, 0));
    ASSERT_NONE(OF(CONTINUOUS, 1, 1, 17, 0));
    ASSERT_NONE(OF(CORRELATED, 1, 1, 16, 0));
    ASSERT_NONE(OF(ROOT, 5, 0, 0, 0));
    TEST_ASSERT_TRUE(S(object_size)(KQ_OBJECT_EM) == sizeof(S(em)));
#endif
    ASSERT_NONE(OF(LOSS, 1, 1, 1, 1));
    ASSERT_NONE(OF(LEAST_SQUARES, 1, 1, 1, 1));
    ASSERT_NONE(S(length)((kq_object)99, 1, 1, 1, 1));
    TEST_ASSERT_TRUE(S(object_size)((kq_object)99) == 0);
    TEST_ASSERT_TRUE(S(object_size)(KQ_OBJECT_ROOT) == 0);
    TEST_ASSERT_TRUE(S(object_size)(KQ_OBJECT_STEADY_SOLVE) == 0);
    TEST_ASSERT_TRUE(S(object_size)(KQ_OBJECT_CONTINUOUS) == 0);
}

TEST(an_object_has_its_size)
{
#define ASSERT_SIZE(object, name) TEST_ASSERT_TRUE(S(object_size)(KQ_OBJECT_##object) == sizeof(S(name)))
    ASSERT_SIZE(PROCESS, process); ASSERT_SIZE(SENSOR, sensor); ASSERT_SIZE(FILTER, filter);
    ASSERT_SIZE(HISTORY, history); ASSERT_SIZE(LAG, lag); ASSERT_SIZE(INSTANT, instant); ASSERT_SIZE(DIFFUSE, diffuse);
    ASSERT_SIZE(ADAPTATION, adaptation); ASSERT_SIZE(CONSISTENCY, consistency);
    ASSERT_SIZE(LEAST_SQUARES, least_squares); ASSERT_SIZE(STEADY, steady);
    ASSERT_SIZE(FREEZE, freeze); ASSERT_SIZE(LOSS, loss);
}

SUITE(lengths, NULL)
#include "lengths.tests"
