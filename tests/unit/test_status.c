/* Status codes, event bits, sizes and length constants. */
#include "arithmetic.h"

/* ------------------------------------------------------- what must hold at compile time */

_Static_assert(KQ_SIZE_MAX == 16, "largest n, m and l");
_Static_assert(KQ_OK == 0, "no error");
_Static_assert(KQ_TRIANGLE(1) == 1 && KQ_TRIANGLE(4) == 10 && KQ_TRIANGLE(16) == 136, "triangle");

_Static_assert(KQ_PROCESS_LEN(3) == 6, "process");
_Static_assert(KQ_SENSOR_LEN(3) == 6 && KQ_SENSOR_DIAGONAL_LEN(3) == 3, "sensor");
_Static_assert(KQ_FILTER_LEN_F32(2) == 7 && KQ_FILTER_LEN_F64(2) == 5, "filter");

#define STEP_BYTES(n, m) (sizeof(float) * KQ_PRIVATE_HISTORY_STEP_LEN_F32(n, m))
_Static_assert(STEP_BYTES(2, 1) == 44, "bytes of one step of history, n = 2, m = 1");
_Static_assert(STEP_BYTES(4, 2) == 116, "bytes of one step of history, n = 4, m = 2");
_Static_assert(STEP_BYTES(9, 3) == 376, "bytes of one step of history, n = 9, m = 3");

_Static_assert(KQ_PRIVATE_HISTORY_CHANGE_LEN_F32 * sizeof(float) >= sizeof(void *) + 4, "change, f32");
_Static_assert(KQ_PRIVATE_HISTORY_CHANGE_LEN_F64 * sizeof(double) >= sizeof(void *) + 4, "change, f64");

_Static_assert(KQ_VERSION == KQ_VERSION_MAJOR * 10000 + KQ_VERSION_MINOR * 100 + KQ_VERSION_PATCH,
               "version");

/* An expression as a size is taken as a whole. */
_Static_assert(KQ_TRIANGLE(1 + 1) == 3 && FILTER_LEN(1 + 1) == FILTER_LEN(2), "parentheses");
_Static_assert(HISTORY_STEP_LEN(1 + 1, 0 + 1) == HISTORY_STEP_LEN(2, 1), "parentheses");
_Static_assert(KQ_PRIVATE_HISTORY_WORKSPACE_LEN(1 + 1) == KQ_PRIVATE_HISTORY_WORKSPACE_LEN(2), "parentheses");
_Static_assert(HISTORY_LEN(1 + 1, 0 + 1, 1 + 2, 0 + 1) == HISTORY_LEN(2, 1, 3, 1), "parentheses");

/* No length wraps, whatever the bits of a size_t: an array of it does not compile. */
#define MOST 0x7fffffff
_Static_assert(HISTORY_LEN(16, 16, MOST, 0) > 400 * (kq_length)MOST, "history");
_Static_assert(HISTORY_LEN(1, MOST, 1, 0) > MOST, "measurements of a step");
_Static_assert(HISTORY_LEN(1, 1, 1, MOST) > MOST, "changes");
_Static_assert(KQ_HISTORY_LEN_Q31(16, 16, MOST, 0) > 400 * (kq_length)MOST, "q31");
_Static_assert(LAG_LEN(1, 1, MOST) > 4 * (kq_length)MOST, "lag");
_Static_assert(LAG_LEN(1, MOST, 1) > MOST && INSTANT_LEN(1, MOST) > MOST, "on line");
_Static_assert(KQ_LAG_LEN_Q31(1, 1, MOST) > MOST && KQ_INSTANT_LEN_Q31(1, MOST) > MOST, "on line");
_Static_assert(DIFFUSE_LEN(16, MOST) > MOST && KQ_DIFFUSE_LEN_Q31(16, MOST) > MOST, "start");
_Static_assert(KQ_EM_LEN_F32(1, 1, MOST) > MOST && KQ_EM_LEN_F64(1, 1, MOST) > MOST, "EM");
_Static_assert(KQ_CONSISTENCY_LEN_F32(16, MOST) > MOST, "consistency");
_Static_assert(KQ_CONSISTENCY_LEN_Q31(16, MOST) > MOST, "consistency");

/* The others at their largest sizes fit into 16 bits, in an int of 16 bits, too, where they are
   counted in one. */
_Static_assert(KQ_ADAPTATION_LEN_F32(16, 16) <= 0x7fff, "16 bits");
_Static_assert(KQ_STEADY_SOLVE_LEN_F32(16, 16) <= 0xffff, "16 bits");
_Static_assert(KQ_EM_LEN_F32(16, 16, 1) <= 0xffff, "16 bits");

/* Figures of the manual: size.h, and the headers of the objects */
#define F32_BYTES(length, a, b, c) (4 * length(2, 1) == a && 4 * length(4, 2) == b && 4 * length(9, 3) == c)
#define LAG_OF_10(n, m) KQ_LAG_LEN_F32(n, m, 10)
#define START_OF_0(n, m) KQ_DIFFUSE_LEN_F32(n, 0)
#define FILTER_OF(n, m) KQ_FILTER_LEN_F32(n)
#define HISTORY_STEP_OF(n, m) KQ_PRIVATE_HISTORY_STEP_LEN_F32(n, m)
#define HISTORY_WORKSPACE_OF(n, m) KQ_PRIVATE_HISTORY_WORKSPACE_LEN(n)
_Static_assert(F32_BYTES(FILTER_OF, 28, 72, 252), "size.h");
_Static_assert(F32_BYTES(HISTORY_STEP_OF, 44, 116, 376), "size.h, smoother.h");
_Static_assert(F32_BYTES(HISTORY_WORKSPACE_OF, 104, 336, 1476), "size.h");
_Static_assert(F32_BYTES(LAG_OF_10, 912, 2912, 12600), "size.h, lag.h");
_Static_assert(F32_BYTES(KQ_INSTANT_LEN_F32, 260, 824, 3492), "size.h");
_Static_assert(F32_BYTES(START_OF_0, 76, 244, 1084), "size.h, diffuse.h");
_Static_assert(F32_BYTES(KQ_ADAPTATION_LEN_F32, 56, 188, 720), "size.h, adaptation.h");
_Static_assert(KQ_STEADY_SOLVE_LEN_F32(4, 2) == 200, "steady.h");

/* ------------------------------------------------------------------------------- tests */

static const kq_status all[] = {
    KQ_OK,
    KQ_ERR_NULL,
    KQ_ERR_SIZE,
    KQ_ERR_MEMORY,
    KQ_ERR_NOT_FINITE,
    KQ_ERR_NOT_SYMMETRIC,
    KQ_ERR_NOT_SEMIDEFINITE,
    KQ_ERR_NOT_READY,
    KQ_ERR_MISMATCH,
    KQ_ERR_HISTORY_EMPTY,
    KQ_ERR_HISTORY_FULL,
    KQ_ERR_RANGE,
    KQ_ERR_COEFFICIENT,
    KQ_ERR_TABLE,
    KQ_ERR_RECORDING,
    KQ_ERR_NOT_DETECTABLE,
    KQ_ERR_NOT_STABILISABLE,
    KQ_ERR_NO_CONVERGENCE,
    KQ_ERR_NO_DATA,
    KQ_ERR_FEW_DATA,
    KQ_ERR_LIKELIHOOD,
    KQ_ERR_FORM,
    KQ_ERR_CHANGED,
};

TEST(errors_are_negative_and_different)
{
    for (int a = 1; a < COUNT(all); a++) {
        TEST_ASSERT_LESS_THAN_INT(0, (int)all[a]);
        for (int b = 0; b < a; b++) TEST_ASSERT_TRUE(all[a] != all[b]);
    }
}

TEST(every_status_has_a_text_of_its_own)
{
    for (int a = 0; a < COUNT(all); a++) {
        const char *text = kq_status_text(all[a]);
        TEST_ASSERT_NOT_NULL(text);
        TEST_ASSERT_GREATER_THAN_INT(1, (int)strlen(text));
        for (int b = 0; b < a; b++) {
            TEST_ASSERT_TRUE(strcmp(text, kq_status_text(all[b])) != 0);
        }
    }
}

TEST(the_text_stays_where_it_is)
{
    const char *text = kq_status_text(KQ_ERR_MEMORY);
    for (int a = 0; a < COUNT(all); a++) (void)kq_status_text(all[a]);
    TEST_ASSERT_EQUAL_STRING(text, kq_status_text(KQ_ERR_MEMORY));
    TEST_ASSERT_TRUE(text == kq_status_text(KQ_ERR_MEMORY));
}

TEST(a_number_that_is_no_status_has_a_text_too)
{
    static const int unknown[] = {1, 2, 100, -18, -19, -100, INT_MAX, INT_MIN};
    for (int k = 0; k < COUNT(unknown); k++) {
        const char *text = kq_status_text((kq_status)unknown[k]);
        TEST_ASSERT_NOT_NULL(text);
        TEST_ASSERT_GREATER_THAN_INT(0, (int)strlen(text));
    }
}

TEST(events_are_separate_bits)
{
    static const unsigned bits[] = {KQ_EVENT_REDUNDANT,     KQ_EVENT_OVERFLOW, KQ_EVENT_HISTORY_FULL,
                                    KQ_EVENT_SATURATED, KQ_EVENT_GATED,    KQ_EVENT_REJECTIONS,
                                    KQ_EVENT_JUMP};
    unsigned seen = 0;
    for (int k = 0; k < COUNT(bits); k++) {
        TEST_ASSERT_TRUE(bits[k] != 0 && (bits[k] & (bits[k] - 1)) == 0);
        TEST_ASSERT_EQUAL_HEX(0, seen & bits[k]);
        seen |= bits[k];
    }
}

TEST(a_history_is_its_steps_changes_and_workspace)
{
    const size_t step = (size_t)HISTORY_STEP_LEN(2, 1);
    TEST_ASSERT_EQUAL_UINT(3 * step + HISTORY_CHANGE_LEN + KQ_PRIVATE_HISTORY_WORKSPACE_LEN(2),
                           (size_t)HISTORY_LEN(2, 1, 3, 1));
}

TEST(the_version_is_written_the_same_twice)
{
    char text[] = "0.0.0";
    text[0] = (char)('0' + KQ_VERSION_MAJOR % 10);
    text[2] = (char)('0' + KQ_VERSION_MINOR % 10);
    text[4] = (char)('0' + KQ_VERSION_PATCH % 10);
    TEST_ASSERT_EQUAL_STRING(text, KQ_VERSION_STRING);
}

SUITE(status, NULL)
#include "status.tests"
