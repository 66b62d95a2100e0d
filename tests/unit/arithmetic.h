/*
 * kalmanq unit tests: one text for every arithmetic.
 *
 * Each test file is compiled once with KQ_TEST_F32 and once with KQ_TEST_F64.  This header maps
 * the names: `num` is the number type, K(predict) is kq_predict_f32 or kq_predict_f64, K(filter)
 * is the type kq_filter_f32 or kq_filter_f64, IN_T(KQ_FILTER) the macro, N(0.1) is a constant of that type.
 *
 * The tests also run on microcontrollers: no heap, no files, large arrays static, and output
 * through Unity only.  Unity and the tests need UNITY_INCLUDE_DOUBLE.
 */
#ifndef KALMANQ_TESTS_ARITHMETIC_H
#define KALMANQ_TESTS_ARITHMETIC_H

#include <float.h>
#include <limits.h>
#include <math.h>
#include <string.h>

#include "kalmanq/kalmanq.h"
#include "suite.h"
#include "views.h"

#if defined(KQ_TEST_F32) && !defined(KQ_TEST_F64)

typedef float num;

#define K(name) kq_##name##_f32
#define IN_T(name) name##_F32
#define EPS ((double)FLT_EPSILON)
#define NUM_MAX FLT_MAX

/* the smallest standard deviation that is not noise to the arithmetic (process.h) */
#define TINY_SIGMA 0x1p-60

/* where fading stops (least_squares.h) */
#define LARGE_SIGMA 0x1p48

/* the largest standard deviation of a state (filter.h) */
#define MOST_SIGMA 0x1p60

#elif defined(KQ_TEST_F64) && !defined(KQ_TEST_F32)

typedef double num;

#define K(name) kq_##name##_f64
#define IN_T(name) name##_F64
#define EPS DBL_EPSILON
#define NUM_MAX DBL_MAX

#define TINY_SIGMA 0x1p-200
#define LARGE_SIGMA 0x1p180
#define MOST_SIGMA 0x1p500

#else
#error "compile each test with one of -DKQ_TEST_F32 and -DKQ_TEST_F64"
#endif

/* Objects and lengths */
#define PROCESS IN_T(KQ_PROCESS)
#define SENSOR IN_T(KQ_SENSOR)
#define SENSOR_DIAGONAL IN_T(KQ_SENSOR_DIAGONAL)
#define SENSOR_TABLE IN_T(KQ_SENSOR_TABLE)
#define SENSOR_LEAN_TABLE IN_T(KQ_SENSOR_LEAN_TABLE)
#define FILTER IN_T(KQ_FILTER)
#define HISTORY IN_T(KQ_HISTORY)
#define JACOBIANS IN_T(KQ_JACOBIANS)
#define LAG IN_T(KQ_LAG)
#define INSTANT IN_T(KQ_INSTANT)
#define DIFFUSE IN_T(KQ_DIFFUSE)
#define ADAPTATION IN_T(KQ_ADAPTATION)
#define STEADY IN_T(KQ_STEADY)
#define FREEZE IN_T(KQ_FREEZE)
#define CONSISTENCY IN_T(KQ_CONSISTENCY)

#define SMOOTHED IN_T(SMOOTHED)
#define START_SMOOTHED IN_T(START_SMOOTHED)

#define FILTER_LEN IN_T(KQ_FILTER_LEN)
#define HISTORY_STEP_LEN IN_T(KQ_PRIVATE_HISTORY_STEP_LEN)
#define HISTORY_CHANGE_LEN IN_T(KQ_PRIVATE_HISTORY_CHANGE_LEN)
#define HISTORY_LEN IN_T(KQ_HISTORY_LEN)
#define JACOBIANS_LEN IN_T(KQ_JACOBIANS_LEN)
#define LAG_LEN IN_T(KQ_LAG_LEN)
#define INSTANT_LEN IN_T(KQ_INSTANT_LEN)
#define DIFFUSE_LEN IN_T(KQ_DIFFUSE_LEN)
#define ADAPTATION_LEN IN_T(KQ_ADAPTATION_LEN)
#define SOLVE_LEN IN_T(KQ_STEADY_SOLVE_LEN)
#define CONSISTENCY_LEN IN_T(KQ_CONSISTENCY_LEN)

/* A constant, rounded to the arithmetic.  Not needed for 0.5, 0.25, ..., which are exact. */
#define N(value) ((num)(value))

#define COUNT(array) ((int)(sizeof(array) / sizeof((array)[0])))

/* What the rounding of a few dozen operations may do, relative to the size of the numbers. */
#define TOLERANCE (64 * EPS)

/* |actual - expected| <= tolerance, in double whatever the arithmetic.  Unity itself would
   let NaN pass as equal to NaN. */
static inline void assert_within(double tolerance, double expected, double actual,
                                 UNITY_LINE_TYPE line)
{
    UNITY_TEST_ASSERT(expected - expected == 0, line, "expected value not finite");
    UNITY_TEST_ASSERT_DOUBLE_WITHIN(tolerance, expected, actual, line, description());
}

#define ASSERT_WITHIN(tolerance, expected, actual)                                                 \
    assert_within((double)(tolerance), (double)(expected), (double)(actual), __LINE__)

/* Equal but for rounding; size: the size of the numbers that it came from. */
#define ASSERT_CLOSE(expected, actual, size)                                                       \
    assert_within(TOLERANCE *(double)(size), (double)(expected), (double)(actual), __LINE__)

#define ASSERT_NAN(value) TEST_ASSERT_TRUE(isnan(value))

#define ASSERT_OK(call) TEST_ASSERT_EQUAL_INT_MESSAGE(KQ_OK, call, description())

/* Two objects (arrays, structures without padding, or cleared ones), bit for bit. */
#define ASSERT_SAME_BITS(expected, actual)                                                         \
    TEST_ASSERT_EQUAL_MEMORY_MESSAGE(&(expected), &(actual), sizeof(expected), description())

/* The mean with what its float could not hold. */
static inline double whole_mean(const K(filter) * f, int i)
{
    return (double)K(mean)(f, i) + (double)K(mean_low)(f, i);
}

static inline double whole_smoothed_mean(const K(history) * h, size_t t, int i)
{
    return (double)K(mean)(SMOOTHED(h, t), i) + (double)K(mean_low)(SMOOTHED(h, t), i);
}

/* On emulated cores, and under sanitizers, which set it, long runs are shorter. */
#ifndef KQ_TEST_IS_SLOW
#define KQ_TEST_IS_SLOW (sizeof(void *) < 8)
#endif

#endif
