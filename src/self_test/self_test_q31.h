/*
 * kalmanq in fixed point: the self test.  A cart is followed for four steps; the words that come out are
 * the same with every compiler, on every core and with every port.
 */
#ifndef KQ_SRC_SELF_TEST_SELF_TEST_Q31_H
#define KQ_SRC_SELF_TEST_SELF_TEST_Q31_H

#include "kalmanq/filter.h"
#include "kalmanq/self_test.h"

#define ONE (INT32_C(1) << 30)

/* Position and velocity in Q11.20, a range finder in millimetres, a step of 0.1 s */
static const kq_format_q31 state[] = {{1048576000, 20}, {52428800, 20}};
static const kq_format_q31 millimetres[] = {{1000000, 0}};
static const kq_scaled_q31 A[] = {{ONE, -30}, {1717986918, -34}, {0, 0}, {ONE, -30}};
static const kq_scaled_q31 H[] = {{2097152000, -41}, {0, 0}};
static const kq_scaled_q31 R[] = {{1310720000, -15}};
static const int32_t G[] = {0, 343597384, 858993459, -16, -13};
static const int32_t sigma0[] = {671088640, 0, 805306368, -6, -8};
static const int32_t x0[] = {0, 0};

/* The tables are automatic: a constant that holds addresses is writable data in code that can be moved. */
static kq_status run(kq_filter_q31 *cart)
{
    const kq_process_table_q31 motion_table = {2, 0, state, 0, A, 0, G};
    const kq_sensor_table_q31 ranger_table = {2, 1, 0, state, millimetres, H, R};
    const kq_prior_table_q31 prior = {2, state, x0, sigma0};
    static const int32_t range[] = {1140, 1020, -1370, 158000};
    kq_process_q31 motion;
    kq_sensor_q31 ranger;
    kq_status status = kq_process_init_q31(&motion, &motion_table, 0);
    if (!status) status = kq_sensor_init_q31(&ranger, &ranger_table, 0);
    if (!status) status = kq_filter_init_q31(cart, &prior, 0);
    for (int t = 0; t < 4 && !status; t++) {
        status = kq_step_q31(cart, &motion, 0, &ranger, &range[t]);
    }
    return status;
}

kq_status kq_self_test_q31(void)
{
    static const int32_t expected[KQ_FILTER_LEN_Q31(2)] = {109317272, 452258513, 15981787,
                                                           11026308,  432704624, 549953054,
                                                           926941422, -12,       -10};
    static const int64_t likelihood = INT64_C(-1801907858522);
    int32_t words[KQ_FILTER_LEN_Q31(2)];
    kq_filter_q31 cart;
    if (kq_filter_assign_q31(&cart, 2, words, KQ_FILTER_LEN_Q31(2)) || run(&cart)) {
        return KQ_ERR_ARITHMETIC;
    }
    int differs = kq_log_likelihood_q31(&cart) != likelihood;
    for (int k = 0; k < KQ_FILTER_LEN_Q31(2); k++) differs |= words[k] != expected[k];
    return differs ? KQ_ERR_ARITHMETIC : KQ_OK;
}

#endif
