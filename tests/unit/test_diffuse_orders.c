/* The unknown start's calls in every order, in floating point. */
#include "arithmetic.h"

typedef num word, K(covariance_word);

#define S(name) K(name)
#define ORDER_START_LEN START_LEN(2, ORDER_EARLY)
#define ORDER_FILTER_LEN FILTER_LEN(2)
#define ORDER_TAPE_LEN HISTORY_LEN(2, 1, ORDER_STEPS, 0)

PROCESS(trend, 2, 0);
SENSOR(level, 2, 1);

static int is_nothing(num a) { return isnan(a); }
static int is_no_score(num a) { return isnan(a); }
static double line(num a) { return (double)a; }

static void begin(K(diffuse) * s, K(filter) * f)
{
    static const num x0[] = {1, -2};
    ASSERT_OK(K(diffuse_init)(s, f, x0, NULL, 3));
}

static void take(K(filter) * f, double z)
{
    const num word = N(z);
    ASSERT_OK(K(update)(f, &level, &word));
}

static void advance(K(filter) * f) { ASSERT_OK(K(predict)(f, &trend, NULL)); }

#include "diffuse_orders.h"

static void set_up(void)
{
    static const num A[] = {1, 1, 0, 1}, Q[] = {0.25, 0, 0, 0.5}, H[] = {1, 0}, R[] = {2};
    ASSERT_OK(K(process_init)(&trend, A, NULL, Q));
    ASSERT_OK(K(sensor_init)(&level, H, R));
}

SUITE(diffuse_orders, set_up)
{
    RUN_TEST(calls_in_every_order);
}
