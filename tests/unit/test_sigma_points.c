/* Sigma points and iteration: exact where that can be said in closed form, whatever is attached. */
#include "drive.h"
#include "sizes.h"
#include "unchanged.h"

#define WORK KQ_SIGMA_POINTS_LEN(2, 2)

FILTER(trial, 2);
PROCESS(found, 2, 0);
SENSOR(at, 2, 2);
SENSOR(single, 2, 1);
HISTORY(record, 2, MOST, STEPS, STEPS);
JACOBIANS(jacobians, record, 2, STEPS, STEPS);
LAG(past, 2, MOST, STEPS);
static K(filter) past_view;

static num work[GUARDED(WORK)], y[16], J[32], E[32], noise_of[4];
static const kq_sigma_points rules[] = {KQ_SIGMA_POINTS_CUBATURE, KQ_SIGMA_POINTS_CENTRAL};

static void set_up(void)
{
    begin_drive();
    ASSERT_OK(K(sensor_init)(&single, direction, variance));
    watch_nothing();
    WATCH(track), WATCH(track_memory), WATCH(motion), WATCH(radar);
    WATCH(found), WATCH(found_memory), WATCH(at), WATCH(at_memory), WATCH(trial), WATCH(trial_memory);
}

/* ------------------------------------------------------------------ functions */

typedef struct {
    int calls, rows;
    num first[2];
    const num *z, *u;
    int bad; /* the call whose value is not finite, from 1 */
} log_of_calls;

static void count(void *context, const num *x)
{
    log_of_calls *log = context;
    if (log->calls++ == 0) log->first[0] = x[0], log->first[1] = x[1];
}

/* (A - I) x + B u */
static void linear_increment(void *context, const num *x, num *d)
{
    const log_of_calls *log = context;
    count(context, x);
    for (int i = 0; i < 2; i++) {
        d[i] = log->u ? B[i] * *log->u : 0;
        for (int k = 0; k < 2; k++) d[i] += (A[2 * i + k] - (i == k)) * x[k];
    }
}

/* z - H x */
static void linear_innovation(void *context, const num *x, num *e)
{
    const log_of_calls *log = context;
    count(context, x);
    for (int c = 0; c < 2; c++) e[c] = log->z[c] - H[2 * c] * x[0] - H[2 * c + 1] * x[1];
}

/* x_0^2 and x_0 x_1 */
static void squares(void *context, const num *x, num *g)
{
    log_of_calls *log = context;
    count(context, x);
    g[0] = x[0] * x[0];
    g[1] = log->calls == log->bad ? N(NAN) : x[0] * x[1];
}

static void sixteen(void *context, const num *x, num *g)
{
    count(context, x);
    for (int c = 0; c < 16; c++) g[c] = x[0] * N(c) + x[1];
}

/* Row 0 always, row 1 until the call `bad` */
static void forgetful(void *context, const num *x, num *g)
{
    const log_of_calls *log = context;
    count(context, x);
    g[0] = x[0];
    if (log->calls < log->bad) g[1] = x[1];
}

static void spread(void *context, const num *x, num *g)
{
    const num far = *(const num *)context;
    g[0] = far * x[0] * x[0];
    g[1] = far * x[0] * (x[0] + x[1]);
}

/* ------------------------------------------------------------------ kq_linearise */

TEST(the_centre_is_called_first_and_all_points_are_called)
{
    for (int r = 0; r < COUNT(rules); r++) {
        log_of_calls log = {0};
        ASSERT_OK_UNCHANGED(K(linearise)(&track, sixteen, &log, 16, rules[r], y, J, E));
        TEST_ASSERT_EQUAL_INT(5, log.calls);
        for (int i = 0; i < 2; i++) TEST_ASSERT_TRUE(log.first[i] == x0[i]);
        for (int c = 0; c < 16; c++) {
            ASSERT_CLOSE(x0[0] * N(c) + x0[1], y[c], 16);
            ASSERT_CLOSE(c, J[2 * c], 64);
            ASSERT_CLOSE(1, J[2 * c + 1], 64);
            for (int i = 0; i < 2; i++) ASSERT_CLOSE(0, E[2 * c + i], 64);
        }
    }
}

/* E[x0^2] = x0^2 + P00, E[x0 x1] = x0 x1 + P01; the nearest linear function is that at the mean. */
TEST(the_mean_of_a_square_has_the_variance_in_it)
{
    const double expected[] = {2 * 1.0, 0, -2, 1};
    for (int r = 0; r < COUNT(rules); r++) {
        log_of_calls log = {0};
        ASSERT_OK(K(linearise)(&track, squares, &log, 2, rules[r], y, J, E));
        ASSERT_CLOSE(1 + 2, y[0], 16);
        ASSERT_CLOSE(-2 + 0.5, y[1], 16);
        for (int k = 0; k < 4; k++) ASSERT_CLOSE(expected[k], J[k], 32);
    }
}

/* Central differences of x^2, one state: Cov = 4 x^2 P + 2 P^2, as a Gaussian has it.  The cubature rule has
   nothing of the second for n = 1. */
FILTER(one, 1);
static void square_of_one(void *context, const num *x, num *g) { (void)context, *g = *x * *x; }

TEST(what_a_linear_function_leaves_is_the_bend)
{
    const num mean[] = {3}, variance_of[] = {4};
    ASSERT_OK(K(filter_init)(&one, mean, variance_of));
    ASSERT_OK(K(linearise)(&one, square_of_one, NULL, 1, KQ_SIGMA_POINTS_CENTRAL, y, J, E));
    ASSERT_CLOSE(13, y[0], 32);
    ASSERT_CLOSE(6, J[0], 32);
    ASSERT_CLOSE(32, E[0] * E[0], 128);
    ASSERT_OK(K(linearise)(&one, square_of_one, NULL, 1, KQ_SIGMA_POINTS_CUBATURE, y, J, E));
    ASSERT_CLOSE(13, y[0], 32);
    ASSERT_CLOSE(0, E[0], 32);
}

/* What both rules are by their own weights: Cov = sum w (g - mean)(g - mean)' */
TEST(the_covariance_is_that_of_the_points)
{
    log_of_calls log = {0};
    double g[5][2], mean[2] = {0, 0}, cov[4] = {0, 0, 0, 0}, S[] = {0, 0, 0, 1};
    S[1] = 0.5, S[0] = sqrt(2 - 0.25); /* P0 = S S', upper */
    for (int k = 0; k < 4; k++) {
        const double h = k & 1 ? -sqrt(2) : sqrt(2);
        const double a = (double)x0[0] + h * S[k / 2], b = (double)x0[1] + h * S[2 + k / 2];
        g[k][0] = a * a, g[k][1] = a * b;
        for (int c = 0; c < 2; c++) mean[c] += g[k][c] / 4;
    }
    for (int k = 0; k < 4; k++) {
        for (int c = 0; c < 4; c++) cov[c] += (g[k][c / 2] - mean[c / 2]) * (g[k][c % 2] - mean[c % 2]) / 4;
    }
    ASSERT_OK(K(linearise)(&track, squares, &log, 2, KQ_SIGMA_POINTS_CUBATURE, y, J, E));
    for (int c = 0; c < 2; c++) {
        ASSERT_CLOSE(mean[c], y[c], 32);
        for (int d = 0; d < 2; d++) {
            double total = 0;
            for (int i = 0; i < 2; i++) {
                total += (double)E[2 * c + i] * (double)E[2 * d + i];
                for (int k = 0; k < 2; k++) {
                    total += (double)J[2 * c + i] * (double)P0[2 * i + k] * (double)J[2 * d + k];
                }
            }
            ASSERT_CLOSE(cov[2 * c + d], total, 256);
        }
    }
}

/* ------------------------------------------------------------------ steps */

/* But for the log-likelihood, which has a component's unit in it */
static void assert_state_like(const K(filter) * expected, const K(filter) * actual)
{
    reading a, b;
    read_filter(&a, expected, 2);
    read_filter(&b, actual, 2);
    for (int i = 0; i < 2; i++) {
        ASSERT_CLOSE((double)a.mean[i] + (double)a.low[i], (double)b.mean[i] + (double)b.low[i], 64);
    }
    for (int k = 0; k < 4; k++) ASSERT_CLOSE(a.P[k], b.P[k], 64);
    ASSERT_CLOSE(a.nis, b.nis, 64);
}

static void assert_like(const K(filter) * expected, const K(filter) * actual)
{
    reading a, b;
    assert_state_like(expected, actual);
    read_filter(&a, expected, 2);
    read_filter(&b, actual, 2);
    ASSERT_CLOSE(a.run, b.run, 400);
}

static void drive_by_points(int step, kq_sigma_points rule)
{
    const num z[] = {N(3 * ((step * 7) % 5 - 2)), N(0.5 * ((step * 11) % 7 - 3))};
    log_of_calls log = {.z = z, .u = control_of(step)};
    num *inside = guard(work, COUNT(work));
    ASSERT_OK(K(predict)(&twin, &motion.process, control_of(step)));
    ASSERT_OK(K(predict_sigma_points)(&track, &motion.process, linear_increment, &log, rule, inside));
    assert_guards(work, WORK, COUNT(work));
    ASSERT_OK(K(update)(&twin, &radar.sensor, z));
    ASSERT_OK(K(update_sigma_points)(&track, &radar.sensor, linear_innovation, &log, rule, inside));
    assert_guards(work, WORK, COUNT(work));
    assert_like(&twin, &track);
}

TEST(linear_functions_give_the_plain_filter_and_its_smoothers)
{
    for (int r = 0; r < COUNT(rules); r++) {
        begin_drive();
        for (int step = 1; step < STEPS; step++) drive_by_points(step, rules[r]);
        begin_drive();
        ASSERT_OK(K(attach)(&twin, &tape.attached));
        ASSERT_OK(K(attach)(&track, &jacobians.attached));
        for (int step = 1; step < STEPS; step++) drive_by_points(step, rules[r]);
        ASSERT_OK(K(smooth)(&tape));
        ASSERT_OK(K(smooth)(&record));
        for (size_t t = 0; t < STEPS; t++) {
            ASSERT_OK(K(filter_copy)(&twin, SMOOTHED(&tape, t)));
            ASSERT_OK(K(filter_copy)(&track, SMOOTHED(&record, t)));
            assert_like(&twin, &track);
        }
        begin_drive();
        ASSERT_OK(K(attach)(&track, &past.attached));
        for (int step = 1; step < STEPS; step++) drive_by_points(step, rules[r]);
        ASSERT_OK(K(lagged)(&past, STEPS - 1, &past_view));
        for (int i = 0; i < 2; i++) ASSERT_CLOSE(K(mean)(SMOOTHED(&tape, 0), i), K(mean)(&past_view, i), 64);
    }
}

/* kq_predict_sigma_points and kq_update_sigma_points are kq_linearise and what follows it. */
TEST(the_steps_in_one_call_are_their_parts)
{
    const num z[] = {1, 2};
    num H_found[4];
    log_of_calls log = {.z = z};
    for (int recorded = 0; recorded < 2; recorded++) {
        begin_drive();
        if (recorded) ASSERT_OK(K(attach)(&track, &jacobians.attached));
        ASSERT_OK(K(predict_sigma_points)(&track, &motion.process, squares, &log, KQ_SIGMA_POINTS_CENTRAL, work));
        ASSERT_OK(K(linearise)(&twin, squares, &log, 2, KQ_SIGMA_POINTS_CENTRAL, y, J, E));
        J[0] += 1, J[3] += 1;
        ASSERT_OK(K(process_linearise)(&found, &motion.process, J, E));
        ASSERT_OK(K(predict_extended)(&twin, &found, y));
        assert_like(&twin, &track);
        ASSERT_OK(K(update_sigma_points)(&track, &radar.sensor, squares, &log, KQ_SIGMA_POINTS_CENTRAL, work));
        ASSERT_OK(K(linearise)(&twin, squares, &log, 2, KQ_SIGMA_POINTS_CENTRAL, y, J, E));
        for (int k = 0; k < 4; k++) H_found[k] = -J[k];
        ASSERT_OK(K(sensor_linearise)(&at, &radar.sensor, H_found, E, noise_of));
        ASSERT_OK(K(update)(&twin, &at, y));
        assert_like(&twin, &track);
    }
}

/* A sensor of R + E E' takes a part of its components as one that was initialised with that sum. */
TEST(a_linearised_sensor_is_one_of_its_noises_sum)
{
    const num left[] = {1, 0.5, -0.25, 2}, e[] = {1, -1};
    num sum[4];
    for (int k = 0; k < 4; k++) sum[k] = R[k] + left[k / 2 * 2] * left[k % 2 * 2] + left[k / 2 * 2 + 1] * left[k % 2 * 2 + 1];
    for (uint32_t present = 1; present < 4; present++) {
        begin_drive();
        ASSERT_OK(K(sensor_linearise)(&at, &radar.sensor, H, left, noise_of));
        ASSERT_OK(K(update_subset)(&track, &at, e, present));
        ASSERT_OK(K(sensor_init_extended)(&at, H, sum));
        ASSERT_OK(K(update_subset)(&twin, &at, e, present));
        assert_like(&twin, &track);
    }
}

/* Of noises that are one, a combination has none: it is measured as well as one without noise can be. */
TEST(what_bends_as_one_leaves_a_combination_without_noise)
{
    const num none[] = {0, 0, 0, 0}, left[] = {1, 0, 2, 0}, sum[] = {1, 2, 2, 4}, z[] = {1, -1};
    SENSOR(exact, 2, 2);
    ASSERT_OK(K(sensor_init)(&exact, H, none));
    ASSERT_OK(K(sensor_linearise)(&at, &exact, H, left, noise_of));
    ASSERT_OK(K(update)(&track, &at, z));
    ASSERT_OK(K(sensor_init_extended)(&at, H, sum));
    ASSERT_OK(K(update)(&twin, &at, z));
    TEST_ASSERT_EQUAL_UINT(K(events)(&twin), K(events)(&track));
    assert_like(&twin, &track);
    TEST_ASSERT_TRUE(K(sigma)(&track, 0) * K(sigma)(&track, 0) < P0[0]);
}

/* A component, and `scale` of it once more, its noise too: R is singular */
typedef struct {
    int rows;
    num z, scale;
} echo;

static void heard_twice(void *context, const num *x, num *e)
{
    const echo *of = context;
    e[0] = of->z - (N(0.3) * x[0] + N(0.7) * x[1]);
    if (of->rows > 1) e[1] = of->scale * e[0];
}

/* What is left of the first component is rounding, and says nothing. */
TEST(an_echo_of_the_same_noise_says_nothing)
{
    const num scales[] = {1, 3, N(-0.7)};
    for (int k = 0; k < COUNT(scales); k++) {
        const num a = scales[k], both[] = {1, a, a, a * a}, of_one[] = {1};
        echo of = {1, 2, a};
        begin_drive();
        ASSERT_OK(K(sensor_init)(&single, direction, of_one));
        ASSERT_OK(K(sensor_init)(&at, H, both));
        ASSERT_OK(K(update_sigma_points)(&twin, &single, heard_twice, &of, KQ_SIGMA_POINTS_CUBATURE, work));
        of.rows = 2;
        ASSERT_OK(K(update_sigma_points)(&track, &at, heard_twice, &of, KQ_SIGMA_POINTS_CUBATURE, work));
        assert_state_like(&twin, &track);
        TEST_ASSERT_EQUAL_UINT(KQ_EVENT_REDUNDANT, K(events)(&track));
    }
}

/* P = 0 in one state: no column, no coefficient, no NaN. */
TEST(a_state_that_is_known_exactly_stays_so)
{
    const num singular[] = {2, 0, 0, 0}, none[] = {0, 0, 0, 0};
    log_of_calls log = {.z = x0};
    ASSERT_OK(K(filter_init)(&track, x0, singular));
    ASSERT_OK(K(process_init)(&motion.process, A, B, none));
    ASSERT_OK(K(linearise)(&track, squares, &log, 2, KQ_SIGMA_POINTS_CUBATURE, y, J, E));
    for (int k = 0; k < 4; k++) TEST_ASSERT_TRUE(J[k] - J[k] == 0);
    ASSERT_OK(K(predict_sigma_points)(&track, &motion.process, linear_increment, &log, KQ_SIGMA_POINTS_CUBATURE, work));
    ASSERT_OK(K(update_sigma_points)(&track, &radar.sensor, linear_innovation, &log, KQ_SIGMA_POINTS_CUBATURE, work));
    TEST_ASSERT_TRUE(K(sigma)(&track, 0) > 0);
    ASSERT_CLOSE(0.5, K(sigma)(&track, 1) / K(sigma)(&track, 0) * 2, 4); /* A's column: 1, -1/4 */
}

/* ------------------------------------------------------------------ iteration */

/* A range far sharper than the prior bends: z = |x| */
static void range_of(void *context, const num *x, num *e)
{
    const num *z = context;
    e[0] = *z - (num)sqrt((double)(x[0] * x[0] + x[1] * x[1]));
}

/* By the loop of sigma_points.h */
static void update_iterated(int iterations, num z)
{
    num H_found[2], e[1];
    ASSERT_OK(K(filter_copy)(&trial, &track));
    for (int k = 0; k < iterations; k++) {
        ASSERT_OK(K(linearise)(&trial, range_of, &z, 1, KQ_SIGMA_POINTS_CENTRAL, e, J, E));
        for (int i = 0; i < 2; i++) {
            H_found[i] = -J[i];
            e[0] += J[i] * (K(mean)(&track, i) - K(mean)(&trial, i));
        }
        SENSOR(of_range, 2, 1);
        ASSERT_OK(K(sensor_linearise)(&of_range, &single, H_found, E, noise_of));
        ASSERT_OK(K(filter_copy)(&trial, &track));
        ASSERT_OK(K(update)(&trial, &of_range, e));
    }
    ASSERT_OK(K(filter_copy)(&track, &trial));
}

/* z - (x_0 + x_1 + x_2) */
static void sum_of_three(void *context, const num *x, num *e)
{
    (void)context;
    e[0] = 150 - x[0] - x[1] - x[2];
}

/* P of rank 2 but for rounding: its root cannot be divided by, as the pivots of the first two rows are rounding of
   the points, and of its row. */
TEST(a_root_of_little_rank_is_as_good)
{
    static const num x[] = {N(100.3), N(30.7), N(18.1)}, h[] = {1, 1, 1}, r[] = {N(0.1)}, z[] = {150};
    static const num S[] = {64 * (num)EPS, N(0.5), (num)EPS / 4, N(0.01), 1, 1};
    static num words[KQ_SIGMA_POINTS_LEN(3, 1)];
    FILTER(plain, 3);
    FILTER(by_points, 3);
    SENSOR(total, 3, 1);
    ASSERT_OK(K(sensor_init)(&total, h, r));
    for (int rule = 0; rule < 2; rule++) {
        ASSERT_OK(K(filter_init_root)(&plain, x, S));
        ASSERT_OK(K(filter_init_root)(&by_points, x, S));
        ASSERT_OK(K(update)(&plain, &total, z));
        ASSERT_OK(K(update_sigma_points)(&by_points, &total, sum_of_three, NULL, (kq_sigma_points)rule, words));
        for (int i = 0; i < 3; i++) {
            const double sigma = (double)K(sigma)(&plain, i);
            ASSERT_WITHIN(1e-3 * sigma, (double)K(mean)(&plain, i), K(mean)(&by_points, i));
            ASSERT_WITHIN(1e-3 * sigma, sigma, K(sigma)(&by_points, i));
        }
    }
}

TEST(iterating_finds_where_a_sharp_range_leads)
{
    const num sharp_noise[] = {N(1e-4)}, start[] = {3, 1}, wide[] = {0.25, 0, 0, 4};
    double off[2];
    for (int k = 0; k < 2; k++) {
        ASSERT_OK(K(sensor_init)(&single, direction, sharp_noise));
        ASSERT_OK(K(filter_init)(&track, start, wide));
        update_iterated(k ? 6 : 1, 5);
        const double a = (double)K(mean)(&track, 0), b = (double)K(mean)(&track, 1);
        off[k] = fabs(sqrt(a * a + b * b) - 5);
    }
    ASSERT_WITHIN(1e-3, 0.9269, off[0]); /* the textbook's, in NumPy: upper roots, h^2 = 3 */
    ASSERT_WITHIN(1e-3, 0.0435, off[1]);
}

/* ------------------------------------------------------------------ refusals */

TEST(a_history_that_keeps_no_jacobians_refuses_points)
{
    log_of_calls log = {.z = x0};
    ASSERT_OK(K(attach)(&track, &tape.attached));
    ASSERT_REFUSED(KQ_ERR_RECORDING, K(predict_sigma_points)(&track, &motion.process, squares, &log, KQ_SIGMA_POINTS_CUBATURE, work));
    TEST_ASSERT_EQUAL_INT(0, log.calls);
}

/* One call after the other is bad, or writes nothing. */
static void assert_bad_values_are_refused(void (*function)(void *, const num *, num *), kq_sigma_points rule)
{
    for (int bad = 1; bad <= 5; bad++) {
        log_of_calls log = {.bad = bad};
        describe("", "bad call", bad, "", 0);
        ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(linearise)(&track, function, &log, 2, rule, y, J, E));
        log.calls = 0;
        ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(predict_sigma_points)(&track, &motion.process, function, &log, KQ_SIGMA_POINTS_CUBATURE, work));
        log.calls = 0;
        ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(update_sigma_points)(&track, &radar.sensor, function, &log, KQ_SIGMA_POINTS_CENTRAL, work));
    }
}

TEST(values_that_are_not_finite_change_nothing) { assert_bad_values_are_refused(squares, KQ_SIGMA_POINTS_CUBATURE); }

TEST(what_is_not_written_is_no_number) { assert_bad_values_are_refused(forgetful, KQ_SIGMA_POINTS_CENTRAL); }

/* A bend whose square is no number makes no noise; one of 2^40 does. */
TEST(what_bends_beyond_the_numbers_is_refused)
{
    const num most = MOST_SIGMA, still = N(0x1p40);
    num far = 32 * most, beyond[] = {1, 0, most, 0};
    ASSERT_REFUSED(KQ_ERR_RANGE, K(update_sigma_points)(&track, &radar.sensor, spread, &far, KQ_SIGMA_POINTS_CENTRAL, work));
    for (int k = 0; k < 4; k++) E[k] = beyond[k];
    ASSERT_OK(K(sensor_linearise)(&at, &radar.sensor, H, E, noise_of));
    ASSERT_OK(K(process_linearise)(&found, &motion.process, A, E));
    for (int k = 0; k < 4; k++) E[k] = 2 * beyond[k];
    ASSERT_REFUSED(KQ_ERR_RANGE, K(sensor_linearise)(&at, &radar.sensor, H, E, noise_of));
    ASSERT_REFUSED(KQ_ERR_RANGE, K(process_linearise)(&found, &motion.process, A, E));
    const num wide[] = {still, 0, still, still}, e[] = {still, -still};
    ASSERT_OK(K(sensor_linearise)(&at, &radar.sensor, H, wide, noise_of));
    ASSERT_OK(K(update)(&track, &at, e));
    TEST_ASSERT_EQUAL_INT(2, K(taken)(&track));
    ASSERT_CLOSE(5, K(nis)(&track), 64); /* e' (wide wide')^-1 e: wide^-1 e / still is (1, -2) */
    ASSERT_CLOSE(P0[0], K(sigma)(&track, 0) * K(sigma)(&track, 0), 64);
}

static num given[4];
static kq_status give_transition(void)
{
    E[0] = 1, E[1] = E[2] = E[3] = 0;
    return K(process_linearise)(&found, &motion.process, given, E);
}
static kq_status give_measurement(void) { return K(sensor_linearise)(&at, &radar.sensor, given, E, noise_of); }
static kq_status give_root(void) { return K(sensor_linearise)(&at, &radar.sensor, H, given, noise_of); }

TEST(models_are_checked)
{
    for (int k = 0; k < 4; k++) given[k] = A[k];
    assert_entries_must_be_finite(given, 4, give_transition);
    assert_entries_must_be_finite(given, 4, give_measurement);
    assert_entries_must_be_finite(given, 4, give_root);
}

/* A view is a density to linearise at, and so is a copy of it. */
TEST(what_is_smoothed_can_be_linearised_at)
{
    num y[2], J[4], E[4], of_copy[4];
    log_of_calls log = {0};
    K(filter) view;
    ASSERT_OK(K(attach)(&track, &jacobians.attached));
    ASSERT_OK(K(smooth)(&record));
    ASSERT_OK(K(smoothed)(&record, 0, &view));
    ASSERT_OK(K(linearise)(&view, squares, &log, 2, KQ_SIGMA_POINTS_CUBATURE, y, J, E));
    ASSERT_OK(K(filter_copy)(&trial, &view));
    ASSERT_OK(K(linearise)(&trial, squares, &log, 2, KQ_SIGMA_POINTS_CUBATURE, y, of_copy, E));
    ASSERT_SAME_BITS(J, of_copy);
    ASSERT_OK(K(attach)(&track, &jacobians.attached));
    ASSERT_OK(K(smooth_states)(&record));
    ASSERT_OK(K(smoothed)(&record, 0, &view));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(linearise)(&view, squares, &log, 2, KQ_SIGMA_POINTS_CUBATURE, y, J, E));
}

SUITE(sigma_points, set_up)
#include "sigma_points.tests"
