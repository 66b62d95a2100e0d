/* The unknown start's calls in every order, in fixed point. */
#include "q31.h"

typedef int32_t word;
typedef kq_scaled_q31 kq_covariance_word_q31;

#define S(name) kq_##name##_q31
#define ORDER_START_LEN KQ_DIFFUSE_LEN_Q31(2, ORDER_EARLY)
#define ORDER_FILTER_LEN KQ_FILTER_LEN_Q31(2)
#define ORDER_TAPE_LEN KQ_HISTORY_LEN_Q31(2, 1, ORDER_STEPS, 0)

static process_model trend;
static sensor_model level;
static prior_model prior;
static const double range[] = {100, 100};

static int is_nothing(int32_t a) { return a == KQ_NOT_A_VALUE_Q31; }
static int is_no_score(int64_t a) { return a == KQ_NOT_A_SCORE_Q31; }
static double line(int32_t a) { return ldexp(a, -prior.state_format[0].fraction); }

static void begin(kq_diffuse_q31 *s, kq_filter_q31 *f)
{
    ASSERT_OK(kq_diffuse_init_q31(s, f, &prior.table, 3, NULL));
}

static void take(kq_filter_q31 *f, double z)
{
    ASSERT_OK(kq_update_q31(f, &level.sensor, words_of(&z, 1, level.measurement_format)));
}

static void advance(kq_filter_q31 *f)
{
    ASSERT_OK(kq_predict_q31(f, &trend.process, NULL));
}

#include "diffuse_orders.h"

static void set_up(void)
{
    static const double A[] = {1, 1, 0, 1}, Q[] = {0.25, 0, 0, 0.5}, H[] = {1, 0}, R[] = {2};
    static const double x0[] = {1, -2}, P0[] = {1, 0, 0, 1};
    put_process(&trend, 2, 0, range, NULL, A, NULL, Q);
    put_sensor(&level, 2, 1, range, range, H, R);
    put_prior(&prior, 2, range, x0, P0);
}

SUITE(diffuse_orders, set_up)
{
    RUN_TEST(calls_in_every_order);
}
