/* Scaled noise in fixed point: which exponents it has (test_robust.c: what it does). */
#include "q31.h"

static const double range[] = {100000, 1000}, drive_range[] = {100};
static const double A[] = {1, 0.5, 0, 1}, B[] = {0.125, 0.5}, Q[] = {0.25, 0.125, 0.125, 0.5};
static const double x0[] = {1, -2}, P0[] = {2, 0.5, 0.5, 1};

static const kq_scaled_q31 one = {INT32_C(1) << 30, -30};

static process_model motion;
static prior_model prior;
static kq_process_q31 scaled;
static int32_t root[KQ_ROOT_LEN_Q31(2)];
KQ_FILTER_Q31(track, 2);

static void set_up(void)
{
    put_process(&motion, 2, 1, range, drive_range, A, B, Q);
    put_prior(&prior, 2, range, x0, P0);
    ASSERT_OK(kq_filter_init_q31(&track, &prior.table, NULL));
}

/* It is written as a whole: nothing of it is looked at. */
TEST(a_target_needs_nothing_before)
{
    kq_process_q31 fresh;
    memset(&fresh, 0xa5, sizeof fresh);
    ASSERT_OK(kq_process_scale_noise_q31(&fresh, &motion.process, root, one));
    TEST_ASSERT_EQUAL_UINT8(motion.process.states, fresh.states);
    TEST_ASSERT_TRUE(fresh.noise_root == root && fresh.transition == motion.transition);
}

TEST(powers_of_4_move_the_exponents_alone)
{
    static const kq_scaled_q31 zero = {0, 0};
    for (int k = -3; k < 8; k++) {
        const kq_scaled_q31 factor = {one.mantissa, one.exponent + 2 * k};
        ASSERT_OK(kq_process_scale_noise_q31(&scaled, &motion.process, root, factor));
        for (int i = 0; i < 3; i++) TEST_ASSERT_EQUAL_INT32(motion.noise_root[i], root[i]);
        for (int i = 3; i < 5; i++) TEST_ASSERT_EQUAL_INT32(motion.noise_root[i] + k, root[i]);
    }
    ASSERT_OK(kq_process_scale_noise_q31(&scaled, &motion.process, root, zero));
    for (int i = 0; i < 3; i++) TEST_ASSERT_EQUAL_INT32(0, root[i]);
    ASSERT_OK(kq_predict_q31(&track, &scaled, NULL));
}

TEST(a_noise_too_small_to_be_held_is_refused)
{
    for (int32_t exponent = -1000; exponent < -960; exponent++) {
        motion.noise_root[3] = exponent;
        ASSERT_OK(kq_process_init_q31(&motion.process, &motion.table, NULL));
        const kq_status status = kq_process_scale_noise_q31(&scaled, &motion.process, root, one);
        TEST_ASSERT_EQUAL_INT(exponent < 32 - 1000 ? KQ_ERR_COEFFICIENT : KQ_OK, status);
    }
}

/* A factor of the root that would take its exponents beyond those of a table */
TEST(exponents_stay_within_their_limits)
{
    for (int exponent = -1000; exponent <= 1000; exponent += 2000) {
        const kq_scaled_q31 factor = {one.mantissa, exponent};
        kq_process_q31 again;
        int32_t other[KQ_ROOT_LEN_Q31(2)];
        ASSERT_OK(kq_process_scale_noise_q31(&scaled, &motion.process, root, factor));
        kq_status status = KQ_OK;
        for (int k = 0; k < 4 && !status; k++) {
            status = kq_process_scale_noise_q31(&again, &scaled, other, factor);
            if (!status) status = kq_process_scale_noise_q31(&scaled, &again, root, factor);
        }
        TEST_ASSERT_EQUAL_INT(KQ_ERR_COEFFICIENT, status);
        ASSERT_OK(kq_predict_q31(&track, &scaled, NULL));
    }
}

SUITE(robust_q31, set_up)
#include "robust_q31.tests"
