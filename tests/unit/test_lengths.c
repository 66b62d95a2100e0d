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

#define COUNT(array) ((int)(sizeof(array) / sizeof((array)[0])))
#define ASSERT_LENGTH(expected, actual) TEST_ASSERT_TRUE((kq_length)(expected) == (actual))
#define ASSERT_NONE(actual) ASSERT_LENGTH(0, actual)

/* Of one step, of all sensors together: more than one sensor has */
static const int measurements[] = {1, 2, 16, 17, 18, 33, 1000, 32767};
static const size_t counts[] = {0, 1, 2, 3, 100, 32767, KQ_COUNT_MAX};
static const int no_size[] = {0, -1, 17, 258, -254, INT_MAX, INT_MIN};
static const size_t no_count[] = {KQ_COUNT_MAX + 1, SIZE_MAX};

static void those_of_a_step_are_the_macros(void)
{
    for (int n = 1; n <= KQ_SIZE_MAX; n++) {
        for (int k = 0; k < COUNT(measurements); k++) {
            const int m = measurements[k];
            ASSERT_LENGTH(LEN(INSTANT)(n, m), S(instant_length)(n, m));
            for (int c = 0; c < COUNT(counts); c++) {
                const size_t steps = counts[c];
                ASSERT_LENGTH(LEN(HISTORY)(n, m, steps, 2), S(history_length)(n, m, steps, 2));
                ASSERT_LENGTH(LEN(HISTORY)(n, m, 3, steps), S(history_length)(n, m, 3, steps));
                ASSERT_LENGTH(LEN(LAG)(n, m, steps), S(lag_length)(n, m, steps));
            }
        }
    }
}

static void those_of_sizes_are_the_macros(void)
{
    for (int n = 1; n <= KQ_SIZE_MAX; n++) {
        ASSERT_LENGTH(LEN(FILTER)(n), S(filter_length)(n));
        ASSERT_LENGTH(LEN(STEADY)(n), S(steady_length)(n));
        ASSERT_LENGTH(LEN(SETTLING)(n), S(settling_length)(n));
        ASSERT_LENGTH(LEN(START)(n, 0), S(start_length)(n, 0));
        ASSERT_LENGTH(LEN(START)(n, (size_t)65534), S(start_length)(n, 65534));
        ASSERT_LENGTH(LEN(CONSISTENCY)(n, KQ_WINDOW_MAX), S(consistency_length)(n, KQ_WINDOW_MAX));
        for (int m = 1; m <= KQ_SIZE_MAX; m++) {
            ASSERT_LENGTH(LEN(ADAPTATION)(n, m), S(adaptation_length)(n, m));
            ASSERT_LENGTH(LEN(STEADY_WORK)(n, m), S(steady_work_length)(n, m));
        }
    }
}

/* With it assign is content, and not with a word less. */
static void it_is_what_assign_asks_for(void)
{
    static word memory[1]; /* assign does not look at it */
    static S(lag) lag;
    static S(instant) point;
    for (int k = 0; k < COUNT(measurements); k++) {
        const int m = measurements[k];
        const kq_length past = S(lag_length)(2, m, 3), instant = S(instant_length)(2, m);
        if (past > SIZE_MAX || instant > SIZE_MAX) continue;
        TEST_ASSERT_EQUAL_INT(KQ_OK, S(lag_assign)(&lag, 2, m, 3, memory, (size_t)past));
        TEST_ASSERT_EQUAL_INT(KQ_ERR_MEMORY, S(lag_assign)(&lag, 2, m, 3, memory, (size_t)past - 1));
        TEST_ASSERT_EQUAL_INT(KQ_OK, S(instant_assign)(&point, 2, m, memory, (size_t)instant));
        TEST_ASSERT_EQUAL_INT(KQ_ERR_MEMORY, S(instant_assign)(&point, 2, m, memory, (size_t)instant - 1));
    }
}

static void a_size_that_is_none_has_no_length(void)
{
    for (int k = 0; k < COUNT(no_size); k++) {
        const int n = no_size[k];
        ASSERT_NONE(S(filter_length)(n));
        ASSERT_NONE(S(history_length)(n, 1, 1, 0));
        ASSERT_NONE(S(lag_length)(n, 1, 1));
        ASSERT_NONE(S(instant_length)(n, 1));
        ASSERT_NONE(S(start_length)(n, 0));
        ASSERT_NONE(S(steady_length)(n));
        ASSERT_NONE(S(settling_length)(n));
        ASSERT_NONE(S(adaptation_length)(n, 1));
        ASSERT_NONE(S(adaptation_length)(1, n));
        ASSERT_NONE(S(steady_work_length)(n, 1));
        ASSERT_NONE(S(steady_work_length)(1, n));
        ASSERT_NONE(S(consistency_length)(n, 1));
    }
    for (int m = -1; m <= 0; m++) {
        ASSERT_NONE(S(history_length)(1, m, 1, 0));
        ASSERT_NONE(S(lag_length)(1, m, 1));
        ASSERT_NONE(S(instant_length)(1, m));
    }
    ASSERT_NONE(S(history_length)(1, INT_MIN, 1, 0));
    ASSERT_NONE(S(instant_length)(1, INT_MIN));
}

static void nor_has_a_count(void)
{
    for (int k = 0; k < COUNT(no_count); k++) {
        ASSERT_NONE(S(history_length)(1, 1, no_count[k], 0));
        ASSERT_NONE(S(history_length)(1, 1, 1, no_count[k]));
        ASSERT_NONE(S(lag_length)(1, 1, no_count[k]));
        /* these have bounds of their own, which may be above all counts of a small part */
        if (no_count[k] >= UINT16_MAX) {
            ASSERT_NONE(S(start_length)(1, no_count[k]));
        }
        if (no_count[k] > KQ_WINDOW_MAX) {
            ASSERT_NONE(S(consistency_length)(1, no_count[k]));
        }
    }
    ASSERT_NONE(S(start_length)(1, UINT16_MAX));
    ASSERT_NONE(S(consistency_length)(1, 0));
    ASSERT_NONE(S(consistency_length)(1, KQ_WINDOW_MAX + 1));
#if INT_MAX > 65535 /* a step records no more: with all steps that there may be the length would wrap */
    ASSERT_NONE(S(history_length)(1, 65536, 1, 0));
    ASSERT_LENGTH(LEN(HISTORY)(1, 65535, 1, 0), S(history_length)(1, 65535, 1, 0));
#endif
}

SUITE(lengths, NULL)
{
    RUN_TEST(those_of_a_step_are_the_macros);
    RUN_TEST(those_of_sizes_are_the_macros);
    RUN_TEST(it_is_what_assign_asks_for);
    RUN_TEST(a_size_that_is_none_has_no_length);
    RUN_TEST(nor_has_a_count);
}
