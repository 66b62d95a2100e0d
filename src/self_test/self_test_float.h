/*
 * The self test in floating point: small runs whose results are known exactly, and which are lost
 * where sums are taken in another order, rounded otherwise, or numbers thought to be finite.
 */
#ifndef KQ_SRC_SELF_TEST_SELF_TEST_FLOAT_H
#define KQ_SRC_SELF_TEST_SELF_TEST_FLOAT_H

#include "../model/model.h"

/* What the compiler cannot know */
static num opaque(num a)
{
    volatile num value = a;
    return value;
}

static int is_about(num expected, num actual, num tolerance)
{
    return num_magnitude(actual - expected) <= tolerance;
}

static int rounds_to_nearest(void)
{
    const num one = opaque(1), third = opaque(num_epsilon / 3), most = opaque(num_epsilon * 2 / 3);
    const num above = one + most, below = one + third, negative = -one - most;
    return above == one + opaque(num_epsilon) && below == one && negative == -above;
}

/* The numbers of n states and one measurement, in memory of the stack */
typedef struct {
    num words[FILTER_LEN(2)], noise[KQ_SENSOR_DIAGONAL_LEN(1)], root[KQ_PROCESS_LEN(2)];
    filter state;
    sensor gauge;
    process motion;
} self_test_run;

static kq_status begin_run(self_test_run *t, int n, const num *H, const num *x0, const num *P0)
{
    static const num r = 1;
    kq_status status = T(kq_filter_assign)(&t->state, n, t->words, FILTER_LEN(2));
    if (!status) status = T(kq_sensor_assign)(&t->gauge, n, 1, t->noise, KQ_SENSOR_DIAGONAL_LEN(1));
    if (!status) status = T(kq_sensor_init_diagonal)(&t->gauge, H, &r);
    return status ? status : T(kq_filter_init)(&t->state, x0, P0);
}

/* A known state of 0, measured far off once and then 32 times by one sigma: 32 is lost in the sum of NIS
   unless it is a pair.  33 measurements have log 2 pi. */
static int long_sums_hold(void)
{
    static const num H = 1, nothing = 0, near = 1;
    self_test_run t;
    const num far = (num)(UINT32_C(1) << (num_digits + 2) / 2);
    if (begin_run(&t, 1, &H, &nothing, &nothing)) return 0;
    if (T(kq_update)(&t.state, &t.gauge, &far)) return 0;
    for (int k = 0; k < 32; k++) {
        if (T(kq_update)(&t.state, &t.gauge, &near)) return 0;
    }
    const num small = T(kq_log_likelihood)(&t.state) + far * far / 2;
    return is_about(-(16 + 33 * num_log_2_pi / 2), small, 6);
}

/* x_i - 2^24 */
static num fraction_of_mean(const filter *f, int i)
{
    return (T(kq_mean)(f, i) - 16777216) + T(kq_mean_low)(f, i);
}

/* Three measurements of 2^24 + 2 against a prior of 2^24, all of variance 1: 2^24 + 3/2 */
static int an_update_keeps_small_parts(void)
{
    static const num H = 1, x0 = 16777216, P0 = 1, z = 16777218;
    self_test_run t;
    if (begin_run(&t, 1, &H, &x0, &P0)) return 0;
    for (int k = 0; k < 3; k++) {
        if (T(kq_update)(&t.state, &t.gauge, &z)) return 0;
    }
    return is_about((num)1.5, fraction_of_mean(&t.state, 0), 16 * num_epsilon);
}

/* A position of 2^24 moves by 1/4 three times. */
static int a_predict_keeps_small_parts(void)
{
    static const num A[] = {1, 1, 0, 1}, H[] = {1, 0}, x0[] = {16777216, (num)0.25}, zero[4];
    self_test_run t;
    if (begin_run(&t, 2, H, x0, zero)) return 0;
    if (T(kq_process_assign)(&t.motion, 2, 0, t.root, KQ_PROCESS_LEN(2))) return 0;
    if (T(kq_process_init)(&t.motion, A, 0, zero)) return 0;
    for (int k = 0; k < 3; k++) {
        if (T(kq_predict)(&t.state, &t.motion, 0)) return 0;
    }
    return fraction_of_mean(&t.state, 0) == (num)0.75;
}

static int what_is_no_number_is_refused(void)
{
    static const num H = 1, x0 = 0, P0 = 1;
    const num zero = opaque(0), infinity = 1 / zero, no_number = zero / zero;
    self_test_run t;
    if (begin_run(&t, 1, &H, &x0, &P0)) return 0;
    return T(kq_update)(&t.state, &t.gauge, &infinity) == KQ_ERR_NOT_FINITE &&
           T(kq_update)(&t.state, &t.gauge, &no_number) == KQ_ERR_NOT_FINITE;
}

kq_status T(kq_self_test)(void)
{
    const int holds = rounds_to_nearest() && what_is_no_number_is_refused() &&
                      an_update_keeps_small_parts() && a_predict_keeps_small_parts() &&
                      long_sums_hold();
    return holds ? KQ_OK : KQ_ERR_ARITHMETIC;
}

#endif
