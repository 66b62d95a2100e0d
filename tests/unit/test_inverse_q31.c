/* The numbers of the q31 arithmetic: inverses, roots and numbers of any size, against double. */
#include "q31.h"
#include "arithmetic/scaled_q31.h"

/* A step through 32-bit numbers that meets all their bits: about 2 million of them */
#define STRIDE 2111u

#define RELATIVE (0x1p-30 * 0.70710678118654752) /* 2^-30.5 */

static double worst;

static void note(double expected, double actual)
{
    const double error = fabs(actual / expected - 1);
    if (error > worst) worst = error;
}

static void note_inverse_root(uint32_t v)
{
    note(1 / sqrt(v * 0x1p-32), inverse_root(v) * 0x1p-31);
}

/* From a power of 2 to 2^32, and all at both ends and around each 64th part */
static void assert_accurate(void (*note_one)(uint32_t), int power)
{
    const uint64_t least = UINT64_C(1) << power;
    worst = 0;
    for (uint64_t v = least; v < UINT64_C(1) << 32; v += STRIDE) note_one((uint32_t)v);
    for (uint32_t k = 0; k < 4096; k++) {
        note_one((uint32_t)least + k);
        note_one(UINT32_MAX - k);
        for (uint32_t top = (UINT32_C(1) << (power - 26)) + 1; top < 64; top++) note_one((top << 26) + k - 2048);
    }
    TEST_ASSERT_TRUE(worst <= RELATIVE);
}

TEST(inverse_root_is_accurate) { assert_accurate(note_inverse_root, 30); }

TEST(inverse_root_is_within_its_range)
{
    for (uint64_t v = UINT64_C(1) << 30; v < UINT64_C(1) << 32; v += 65521) {
        TEST_ASSERT_TRUE(inverse_root((uint32_t)v) >> 31);
    }
    TEST_ASSERT_TRUE(inverse_root(UINT32_MAX) >> 31);
}

static void note_reciprocal(uint32_t d) { note(0x1p63 / d, reciprocal(d)); }

TEST(reciprocal_is_accurate) { assert_accurate(note_reciprocal, 31); }

/* ---------------------------------------------------------------------- of any size */

static uint32_t seed;

static uint32_t bits_of_seed(void)
{
    seed = seed * UINT32_C(1664525) + UINT32_C(1013904223);
    return seed;
}

/* Any mantissa, often at an end, and a small exponent */
static scaled any(void)
{
    static const int32_t ends[] = {INT32_C(1) << 30, INT32_MAX, (INT32_C(1) << 30) + 1,
                                   INT32_MAX - 1};
    const uint32_t bits = bits_of_seed();
    int32_t mantissa = (int32_t)(bits >> 2 | UINT32_C(1) << 30);
    if (bits % 5 == 0) mantissa = ends[bits >> 8 & 3];
    if (bits_of_seed() >> 31) mantissa = -mantissa;
    return (scaled){mantissa, (int32_t)(bits_of_seed() >> 26) - 32};
}

static double value(scaled a) { return ldexp(a.mantissa, a.exponent); }

static scaled absolute(scaled a) { return (scaled){(int32_t)magnitude(a.mantissa), a.exponent}; }

static void assert_normal(scaled a)
{
    const uint32_t size = magnitude(a.mantissa);
    TEST_ASSERT_TRUE(size == 0 ? a.exponent == 0 : size >> 30 == 1);
}

static void note_scaled(double expected, scaled actual)
{
    assert_normal(actual);
    if (expected == 0) TEST_ASSERT_EQUAL_INT(0, actual.mantissa);
    else note(expected, value(actual));
}

TEST(scaled_operations_are_accurate)
{
    worst = 0;
    seed = 1;
    for (int k = 0; k < 500000; k++) {
        const scaled a = any(), b = any(), c = absolute(a), d = absolute(b);
        note_scaled(value(a) * value(b), scaled_times(a, b));
        note_scaled(value(a) / value(b), scaled_over(a, b));
        note_scaled(sqrt(value(c)), scaled_root(c));
        TEST_ASSERT_EQUAL_INT(value(c) < value(d), scaled_is_less(c, d));
    }
    TEST_ASSERT_TRUE(worst <= 2 * RELATIVE);
}

/* A sum is exact to 2^-30 of the larger term. */
TEST(scaled_sums_are_accurate)
{
    seed = 2;
    for (int k = 0; k < 500000; k++) {
        const scaled a = any(), b = any(), sum = scaled_plus(a, b);
        const double size = fabs(value(a)) + fabs(value(b)), expected = value(a) + value(b);
        assert_normal(sum);
        TEST_ASSERT_TRUE(fabs(value(sum) - expected) <= RELATIVE * size);
        TEST_ASSERT_EQUAL_DOUBLE(0, value(scaled_minus(a, a)));
        TEST_ASSERT_EQUAL_DOUBLE(value(a), value(scaled_plus(a, (scaled){0, 0})));
    }
}

TEST(scaled_of_rounds_to_nearest)
{
    seed = 3;
    for (int k = 0; k < 500000; k++) {
        const uint64_t bits = (uint64_t)bits_of_seed() << 32 | bits_of_seed();
        const int64_t a = (int64_t)(bits >> 1 >> (bits_of_seed() >> 26));
        const scaled up = scaled_of(a, 3), down = scaled_of(-a, 3);
        assert_normal(up);
        TEST_ASSERT_EQUAL_INT(up.mantissa, -down.mantissa);
        TEST_ASSERT_TRUE(fabs(value(up) - ldexp((double)a, 3)) <= 0x1p-31 * value(up) * 1.0001);
    }
    TEST_ASSERT_EQUAL_INT(1 << 30, scaled_of(INT64_MAX, 0).mantissa);
    TEST_ASSERT_EQUAL_INT(33, scaled_of(INT64_MAX, 0).exponent);
    TEST_ASSERT_EQUAL_INT(-(1 << 30), scaled_of(INT64_MIN, 0).mantissa);
}

/* To the nearest word, and never out of it: the largest mantissa is rounded up to half of 2^31. */
TEST(a_word_is_rounded_and_held)
{
    TEST_ASSERT_EQUAL_INT32(1 << 30, word_of((scaled){INT32_MAX, -1}));
    TEST_ASSERT_EQUAL_INT32(-(1 << 30) + 1, word_of((scaled){-INT32_MAX, -1}));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, word_of((scaled){INT32_MAX, 0}));
    TEST_ASSERT_EQUAL_INT32(-INT32_MAX, word_of((scaled){-INT32_MAX, 0}));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, word_of((scaled){1 << 30, 1}));
    TEST_ASSERT_EQUAL_INT32(-INT32_MAX, word_of((scaled){-(1 << 30), 1000}));
    TEST_ASSERT_EQUAL_INT32(0, word_of((scaled){0, 0}));
    TEST_ASSERT_EQUAL_INT32(1, word_of((scaled){1 << 30, -30}));
    TEST_ASSERT_EQUAL_INT32(1, word_of((scaled){1 << 30, -31}));
    TEST_ASSERT_EQUAL_INT32(0, word_of((scaled){1 << 30, -32}));
    TEST_ASSERT_EQUAL_INT32(0, word_of((scaled){INT32_MAX, -1000}));
}

SUITE(inverse_q31, NULL)
#include "inverse_q31.tests"
