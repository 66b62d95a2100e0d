/* The unknown start: what is determined when, by hand; what it refuses. */
#include "losses.h"
#include "reading.h"
#include "sizes.h"
#include "unchanged.h"

#define STEPS 8
#define EARLY 4

PROCESS(trend, 2, 0);
PROCESS(still, 2, 0);
PROCESS(reset, 2, 0);
SENSOR(level, 2, 1);
SENSOR(both, 2, 2);
FILTER(track, 2);
FILTER(twin, 2);
static K(filter) view;
HISTORY(tape, 2, 2, STEPS, STEPS);
DIFFUSE(start, 2, EARLY);
DIFFUSE(plain, 2, 0);

enum { NINE = 9 };
FILTER(nine, NINE);
SENSOR(one_of_nine, NINE, 1);
PROCESS(adding, NINE, 0);
DIFFUSE(start_of_nine, NINE, 0);

/* never attached, and of another size */
HISTORY(blank_tape, 2, 1, 1, 0);
SENSOR(sensor3, 3, 1);

static const num A[] = {1, 1, 0, 1}, Q[] = {0.25, 0, 0, 0.5}, identity[] = {1, 0, 0, 1}, zero[4];
static const num H[] = {1, 0}, R[] = {2};
static const num H2[] = {1, 0, 1, 1}, R2[] = {0.5, 0.25, 0.25, 1}, sum[] = {1, 1, 2, 2};
static const num x0[] = {1, -2}, P0[] = {4, 0, 0, 9};
static const double log_2_pi = 1.8378770664093454836;

static void set_up(void)
{
    ASSERT_OK(K(process_init)(&trend, A, NULL, Q));
    ASSERT_OK(K(process_init)(&still, identity, NULL, zero));
    ASSERT_OK(K(process_init)(&reset, zero, NULL, Q));
    ASSERT_OK(K(sensor_init)(&level, H, R));
    ASSERT_OK(K(sensor_init)(&both, H2, R2));
    ASSERT_OK(K(sensor_init)(&sensor3, sum, R));
    ASSERT_OK(K(diffuse_assign)(&start, 2, EARLY, start_memory, COUNT(start_memory)));
    ASSERT_OK(K(diffuse_init)(&start, &track, x0, NULL, 3));
    ASSERT_OK(K(history_assign)(&tape, 2, tape_memory, COUNT(tape_memory)));
    watch_nothing();
    WATCH(start), WATCH(start_memory), WATCH(track), WATCH(track_memory), WATCH(tape);
    WATCH(blank_tape);
}

static void update(double z)
{
    const num word = N(z);
    ASSERT_OK(K(update)(&track, &level, &word));
}

static void predict(const K(process) * p) { ASSERT_OK(K(predict)(&track, p, NULL)); }

/* The first step that can be smoothed */
static size_t first_early(void)
{
    size_t first;
    (void)K(diffuse_steps)(&start, &first);
    return first;
}

/* Count and what is determined, as bits */
static void assert_open(int count, int bits, UNITY_LINE_TYPE line)
{
    UNITY_TEST_ASSERT_EQUAL_INT(count, K(diffuse_count)(&start), line, "count");
    for (int i = 0; i < 2; i++) {
        const int is = bits >> i & 1;
        UNITY_TEST_ASSERT(isnan(K(mean)(&track, i)) == !is, line, "mean");
        UNITY_TEST_ASSERT(isnan(K(mean_low)(&track, i)) == !is, line, "mean low");
        UNITY_TEST_ASSERT(isnan(K(sigma)(&track, i)) == !is, line, "sigma");
    }
    num P[4];
    const kq_status status = count > 0 ? KQ_ERR_NOT_READY : KQ_OK;
    UNITY_TEST_ASSERT_EQUAL_INT(status, K(covariance)(&track, P), line, "covariance");
    UNITY_TEST_ASSERT(!isnan(K(log_likelihood)(&track)), line, "likelihood");
    UNITY_TEST_ASSERT(!isnan(K(log_likelihood_last)(&track)), line, "likelihood, last");
    UNITY_TEST_ASSERT(!isnan(K(nis)(&track)), line, "NIS");
    UNITY_TEST_ASSERT(K(taken)(&track) >= 0, line, "taken");
}

#define ASSERT_OPEN(count, bits) assert_open(count, bits, __LINE__)

static void assert_state(const double *x, double p00, double p01, double p11, UNITY_LINE_TYPE line)
{
    num P[4];
    ASSERT_OK(K(covariance)(&track, P));
    const double size = p00 + p11 + fabs(x[0]) + fabs(x[1]);
    for (int i = 0; i < 2; i++) {
        assert_within(TOLERANCE * size, x[i], whole_mean(&track, i), line);
        assert_within(TOLERANCE * size, x[i], (double)K(mean)(&track, i), line);
    }
    assert_within(TOLERANCE * size, p00, (double)P[0], line);
    assert_within(TOLERANCE * size, p01, (double)P[1], line);
    assert_within(TOLERANCE * size, p11, (double)P[3], line);
    assert_within(TOLERANCE * size, sqrt(p11), (double)K(sigma)(&track, 1), line);
}

#define ASSERT_STATE(x0, x1, p00, p01, p11)                                                        \
    assert_state((const double[]){x0, x1}, p00, p01, p11, __LINE__)

/* ---------------------------------------------------------------------- what is determined */

TEST(two_measurements_determine_a_trend)
{
    ASSERT_OPEN(2, 0);
    update(10);
    ASSERT_OPEN(1, 1);
    ASSERT_CLOSE(10, K(mean)(&track, 0), 10);
    ASSERT_CLOSE(sqrt(2), K(sigma)(&track, 0), 1);
    ASSERT_CLOSE(-log_2_pi / 2, K(log_likelihood)(&track), 1);
    predict(&trend);
    ASSERT_OPEN(1, 0);
    update(13);
    ASSERT_OPEN(0, 3);
    /* slope at 1: z1 - z0 - w0 - v1 + v0 + w1 */
    ASSERT_STATE(13, 3, 2, 2, 2 + 2 + 0.25 + 0.5);
    ASSERT_CLOSE(-log_2_pi, K(log_likelihood)(&track), 1);
    ASSERT_CLOSE(-log_2_pi / 2, K(log_likelihood_last)(&track), 1);
    TEST_ASSERT_EQUAL_INT(1, K(taken)(&track));
    TEST_ASSERT_EQUAL_INT(0, K(events)(&track));
}

TEST(phi_counts_in_the_likelihood)
{
    static const num h[] = {3, 4}, z = 10;
    ASSERT_OK(K(sensor_change_measurement)(&level, h));
    ASSERT_OK(K(update)(&track, &level, &z));
    ASSERT_OPEN(1, 0);
    ASSERT_CLOSE(-(log_2_pi + log(25)) / 2, K(log_likelihood)(&track), 4);
    ASSERT_OK(K(update)(&track, &level, &z)); /* the same again: ordinary, S = 2 r */
    ASSERT_OPEN(1, 0);
    ASSERT_CLOSE(-(log_2_pi + log(4)) / 2, K(log_likelihood_last)(&track), 4);
}

TEST(the_known_rest_correlates_with_what_is_determined)
{
    static const num z[] = {5, 0};
    ASSERT_OK(K(diffuse_init)(&start, &track, x0, P0, 1));
    ASSERT_OPEN(1, 2);
    ASSERT_CLOSE(-2, K(mean)(&track, 1), 2);
    ASSERT_CLOSE(3, K(sigma)(&track, 1), 3);
    ASSERT_OK(K(update_subset)(&track, &both, z + 1, 0)); /* nothing */
    ASSERT_OPEN(1, 2);
    static const num h[] = {1, 1};
    ASSERT_OK(K(sensor_change_measurement)(&level, h));
    ASSERT_OK(K(update)(&track, &level, z)); /* x0 = z - x1 - v */
    ASSERT_OPEN(0, 3);
    ASSERT_STATE(7, -2, 9 + 2, -9, 9);
}

TEST(what_is_not_known_of_the_prior_is_not_looked_at)
{
    num P[] = {(num)NAN, 7, -3, 9};
    const num x[] = {1e6, -2}, z = 5;
    ASSERT_OK(K(diffuse_init)(&start, &track, x, P, 1 | 4));
    ASSERT_OPEN(1, 2);
    ASSERT_OK(K(update)(&track, &level, &z));
    ASSERT_STATE(5, -2, 2, 0, 9);
}

TEST(correlated_components_determine_at_once)
{
    static const num z[] = {4, 1};
    ASSERT_OK(K(update)(&track, &both, z));
    ASSERT_OPEN(0, 3);
    /* x = H^-1 z, P = H^-1 R H^-T, H^-1 = [1 0; -1 1], det H = 1 */
    ASSERT_STATE(4, -3, 0.5, -0.25, 1);
    ASSERT_CLOSE(-log_2_pi, K(log_likelihood)(&track), 1);
    TEST_ASSERT_EQUAL_INT(2, K(taken)(&track));
}

TEST(one_of_two_correlated_components)
{
    static const num z[] = {4, 1}, second[] = {(num)NAN, 1};
    ASSERT_OK(K(update_subset)(&track, &both, second, 2));
    ASSERT_OPEN(1, 0);
    ASSERT_OK(K(update_subset)(&track, &both, z, 1));
    ASSERT_STATE(4, -3, 0.5, -0.5, 1.5);
}

TEST(a_long_wait_costs_nothing)
{
    for (int t = 0; t < 2000; t++) predict(&still);
    ASSERT_OPEN(2, 0);
    update(5);
    ASSERT_OPEN(1, 1);
    ASSERT_CLOSE(5, K(mean)(&track, 0), 5);
}

TEST(a_turning_state_is_known_when_it_has_been_seen_twice)
{
    const num c = N(0.8), s = N(0.6), turn[] = {c, s, -s, c};
    ASSERT_OK(K(process_init)(&trend, turn, NULL, zero));
    for (int t = 0; t < 100; t++) predict(&trend);
    update(5);
    ASSERT_OPEN(1, 1);
    update(5);
    ASSERT_OPEN(1, 1);
    predict(&trend);
    ASSERT_OPEN(1, 0);
    update(5);
    ASSERT_OPEN(0, 3);
}

TEST(a_transition_may_forget_it)
{
    predict(&reset);
    ASSERT_OPEN(0, 3);
    ASSERT_STATE(0, 0, 0.25, 0, 0.5);
    ASSERT_WITHIN(0, 0, K(log_likelihood)(&track));
}

TEST(it_decays_into_nothing)
{
    static const num half[] = {1, 0, 0, 0.5};
    ASSERT_OK(K(process_init)(&trend, half, NULL, Q));
    for (int t = 0; t < 100; t++) predict(&trend);
    ASSERT_OPEN(2, 0);
    for (int t = 0; t < 400; t++) predict(&trend);
    ASSERT_OPEN(1, 2);
}

TEST(a_measurement_beyond_the_numbers_is_not_taken)
{
    static const num h[] = {(num)0x1p-60, 0}, z = NUM_MAX;
    ASSERT_OK(K(sensor_change_measurement)(&level, h));
    ASSERT_OK(K(update)(&track, &level, &z));
    ASSERT_OPEN(2, 0);
    TEST_ASSERT_EQUAL_INT(KQ_EVENT_OVERFLOW, K(events)(&track));
    ASSERT_WITHIN(0, 0, K(log_likelihood)(&track));
}

/* Its gain times its innovation is a number, and so is the mean before it: their sum is not. */
TEST(a_mean_beyond_the_numbers_is_not_taken)
{
    static const num h[] = {N(0.75), 0};
    const double most = MOST_SIGMA * MOST_SIGMA;
    const num far[] = {N(most), 0}, z = N(0.75 * ((double)NUM_MAX / 2 + most / 4) * 2);
    ASSERT_OK(K(diffuse_init)(&start, &track, far, NULL, 3));
    ASSERT_OK(K(sensor_change_measurement)(&level, h));
    ASSERT_OK(K(update)(&track, &level, &z));
    ASSERT_OPEN(2, 0);
    TEST_ASSERT_EQUAL_INT(KQ_EVENT_OVERFLOW, K(events)(&track));
}

/* Of two components the first is the second one's noise; what it makes of the mean, the second takes beyond the numbers. */
TEST(a_residual_beyond_the_numbers_moves_nothing)
{
    const num q = N(sqrt(sqrt(MOST_SIGMA))), large = q * q * q, far = 4 * large * large;
    const num h[] = {0, 0, large, 0}, C[] = {1 / large / large, 1 / large, 1 / large, 1}, z[] = {far, 0};
    ASSERT_OK(K(diffuse_init)(&start, &track, zero, P0, 1));
    ASSERT_OK(K(sensor_init)(&both, h, C));
    ASSERT_OK(K(update)(&track, &both, z));
    ASSERT_OPEN(0, 3);
    ASSERT_WITHIN(TOLERANCE, -1, (double)K(mean)(&track, 0) / (double)far);
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_PRECISION | KQ_EVENT_OVERFLOW, K(events)(&track));
    ASSERT_OK(K(filter_check)(&track));
}

/* A sigma up to the largest that predict holds, and not beyond it */
TEST(a_sigma_beyond_the_largest_is_held)
{
    const double most = EPS < 1e-9 ? 0x1p500 : 0x1p60;
    for (int e = -4; e < 20; e++) {
        const double h = ldexp(1 / most, -e);
        const num row[] = {N(h), 0}, z = N(0.5);
        set_up();
        ASSERT_OK(K(sensor_change_measurement)(&level, row));
        ASSERT_OK(K(update)(&track, &level, &z));
        ASSERT_OPEN(1, 1);
        const int is_held = sqrt(2) / h > most;
        TEST_ASSERT_EQUAL_HEX(is_held ? KQ_EVENT_OVERFLOW : 0, K(events)(&track));
        const double told = sqrt(2) / h / most;
        const double sigma = is_held ? told / sqrt(1 + told * told) : told;
        ASSERT_WITHIN(4 * EPS, sigma, (double)K(sigma)(&track, 0) / most);
        ASSERT_OK(K(filter_check)(&track));
    }
}

/* A predict puts all states into the last one; then each is seen as little as may be. */
TEST(directions_that_are_held_add_up)
{
    static const num origin[NINE], none[NINE * NINE], noise[] = {1}, z[] = {0};
    num into_last[NINE * NINE] = {0}, h[NINE] = {0};
    for (int i = 0; i < NINE; i++) into_last[i * (NINE + 1)] = into_last[(NINE - 1) * NINE + i] = 1;
    ASSERT_OK(K(process_init)(&adding, into_last, NULL, none));
    ASSERT_OK(K(sensor_init)(&one_of_nine, h, noise));
    ASSERT_OK(K(diffuse_init)(&start_of_nine, &nine, origin, NULL, (1 << NINE) - 1));
    ASSERT_OK(K(predict)(&nine, &adding, NULL));
    for (int i = 0; i < NINE; i++) {
        memset(h, 0, sizeof h);
        h[i] = N(1 / (double)MOST_SIGMA / 1024);
        ASSERT_OK(K(sensor_change_measurement)(&one_of_nine, h));
        ASSERT_OK(K(update)(&nine, &one_of_nine, z));
    }
    ASSERT_WITHIN(1e-4, 3, (double)K(sigma)(&nine, NINE - 1) / (double)MOST_SIGMA);
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_OVERFLOW, K(events)(&nine));
    ASSERT_OK(K(filter_check)(&nine));
}

TEST(the_filter_goes_on_as_it_would)
{
    static const num z[] = {4, 1}, more[] = {3, 2};
    ASSERT_OK(K(update)(&track, &both, z));
    memcpy(twin_memory, track_memory, sizeof twin_memory);
    twin = track;
    twin.memory = twin_memory;
    for (int t = 0; t < 3; t++) {
        ASSERT_OK(K(predict)(&track, &trend, NULL));
        ASSERT_OK(K(predict)(&twin, &trend, NULL));
        ASSERT_OK(K(update)(&track, &both, more));
        ASSERT_OK(K(update)(&twin, &both, more));
        ASSERT_OK(K(update_subset)(&track, &both, more, 2));
        ASSERT_OK(K(update_subset)(&twin, &both, more, 2));
    }
    ASSERT_SAME_FILTER(&twin, &track, 2);
}

TEST(sizes_from_1_to_16)
{
    static num P[256], z[16], big_memory[FILTER_LEN(16)], H16[256], r[16];
    static num work[DIFFUSE_LEN(16, 1)], process_memory[KQ_PROCESS_LEN(16)], sensor_memory[16];
    static num history_memory[HISTORY_LEN(16, 16, 2, 0)];
    static num x[16], I[256], Z[256];
    K(diffuse) s;
    K(filter) f;
    K(process) p;
    K(sensor) by;
    K(history) h;
    for (int n = 1; n <= 16; n += n < 3 ? 1 : 13) {
        for (int k = 0; k < n * n; k++) H16[k] = I[k] = k % (n + 1) ? 0 : 1;
        for (int i = 0; i < n; i++) {
            for (int j = i + 1; j < n; j++) H16[i * n + j] = N(0.125);
            z[i] = N(i - 3);
            r[i] = 1;
        }
        ASSERT_OK(K(filter_assign)(&f, n, big_memory, COUNT(big_memory)));
        ASSERT_OK(K(diffuse_assign)(&s, n, 1, work, (size_t)DIFFUSE_LEN((size_t)n, 1)));
        ASSERT_OK(K(history_assign)(&h, n, history_memory, COUNT(history_memory)));
        ASSERT_OK(K(process_assign)(&p, n, 0, process_memory, COUNT(process_memory)));
        ASSERT_OK(K(process_init)(&p, I, NULL, Z));
        ASSERT_OK(K(sensor_assign)(&by, n, n, sensor_memory, COUNT(sensor_memory)));
        ASSERT_OK(K(sensor_init_diagonal)(&by, H16, r));
        ASSERT_OK(K(diffuse_init)(&s, &f, x, NULL, UINT32_MAX));
        ASSERT_OK(K(attach)(&f, &h.attached));
        TEST_ASSERT_EQUAL_INT(n, K(diffuse_count)(&s));
        ASSERT_OK(K(predict)(&f, &p, NULL));
        ASSERT_OK(K(update)(&f, &by, z));
        TEST_ASSERT_EQUAL_INT(0, K(diffuse_count)(&s));
        ASSERT_OK(K(covariance)(&f, P));
        for (int i = 0; i < n; i++) { /* H x = z, H P H' = I */
            double back = 0;
            for (int j = 0; j < n; j++) back += (double)H16[i * n + j] * whole_mean(&f, j);
            ASSERT_CLOSE(i - 3, back, 40);
            double variance = 0;
            for (int j = 0; j < n; j++) {
                for (int k = 0; k < n; k++) {
                    variance += (double)(H16[i * n + j] * H16[i * n + k] * P[j * n + k]);
                }
            }
            ASSERT_CLOSE(1, variance, 20);
        }
        ASSERT_OK(K(diffuse_smooth)(&s));
        for (int i = 0; i < n; i++) {
            ASSERT_CLOSE(whole_mean(&f, i), K(mean)(START_SMOOTHED(&s, 0), i), 40);
            ASSERT_CLOSE(K(sigma)(&f, i), K(sigma)(START_SMOOTHED(&s, 0), i), 20);
        }
    }
}

/* -------------------------------------------------------------------------------- smoother */

/* A constant, seen k times with noise 2 and before that not at all */
TEST(smoothed_constant_is_the_mean_of_all)
{
    static const double z[] = {3, 8, -2, 5};
    num P[4];
    ASSERT_OK(K(attach)(&track, &tape.attached));
    for (int t = 0; t < 3; t++) predict(&still);
    static const num h[2][2] = {{1, 0}, {0, 1}};
    for (int t = 0; t < 4; t++) {
        ASSERT_OK(K(sensor_change_measurement)(&level, h[0]));
        update(z[t]);
        if (t > 0) ASSERT_OK(K(sensor_change_measurement)(&level, h[1]));
        if (t > 0) update(2 * z[t]);
        predict(&still);
    }
    TEST_ASSERT_EQUAL_UINT(4, K(diffuse_steps)(&start, NULL));
    TEST_ASSERT_EQUAL_UINT(0, first_early());
    ASSERT_NAN(K(mean)(START_SMOOTHED(&start, 0), 0));
    ASSERT_OK(K(diffuse_smooth)(&start));
    for (size_t t = 0; t < 8; t++) {
        ASSERT_CLOSE(3.5, K(mean)(START_SMOOTHED(&start, t), 0), 10);
        ASSERT_CLOSE(22 / 3.0,
                     (double)K(mean)(START_SMOOTHED(&start, t), 1) +
                         (double)K(mean_low)(START_SMOOTHED(&start, t), 1),
                     20);
        ASSERT_CLOSE(sqrt(0.5), K(sigma)(START_SMOOTHED(&start, t), 0), 1);
        ASSERT_OK(K(covariance)(START_SMOOTHED(&start, t), P));
        ASSERT_CLOSE(0.5, P[0], 2);
        ASSERT_CLOSE(0, P[1], 2);
        ASSERT_CLOSE(0, P[2], 2);
        ASSERT_CLOSE(2 / 3.0, P[3], 2);
    }
    ASSERT_NAN(K(mean)(START_SMOOTHED(&start, 8), 0));
    ASSERT_NAN(K(sigma)(START_SMOOTHED(&start, 0), 2));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(diffuse_smooth)(&start));
}

static const num trend_data[] = {10, 13, 14, 18};

static void run_trend(void)
{
    for (int t = 0; t < 4; t++) {
        update((double)trend_data[t]);
        predict(&trend);
    }
}

TEST(smoothed_in_slices_or_at_once)
{
    num all[4], sliced[4];
    ASSERT_OK(K(attach)(&track, &tape.attached));
    run_trend();
    ASSERT_OK(K(diffuse_smooth)(&start));
    const num mean = K(mean)(START_SMOOTHED(&start, 0), 1);
    ASSERT_OK(K(covariance)(START_SMOOTHED(&start, 0), all));
    ASSERT_OK(K(diffuse_init)(&start, &track, x0, NULL, 3));
    ASSERT_OK(K(attach)(&track, &tape.attached));
    run_trend();
    ASSERT_OK(K(smooth_step)(&tape, NULL, NULL));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(diffuse_smooth)(&start));
    for (size_t k = 1; k < K(history_steps)(&tape); k++) {
        ASSERT_OK(K(smooth_step)(&tape, NULL, NULL));
    }
    ASSERT_OK(K(diffuse_smooth)(&start));
    TEST_ASSERT_TRUE(mean == K(mean)(START_SMOOTHED(&start, 0), 1));
    ASSERT_OK(K(covariance)(START_SMOOTHED(&start, 0), sliced));
    ASSERT_SAME_BITS(all, sliced);
    TEST_ASSERT_TRUE(K(mean)(START_SMOOTHED(&start, 2), 0) == K(mean)(SMOOTHED(&tape, 1), 0));
}

TEST(means_alone)
{
    num P[4];
    ASSERT_OK(K(attach)(&track, &tape.attached));
    run_trend();
    ASSERT_OK(K(diffuse_smooth)(&start));
    const double mean = (double)K(mean)(START_SMOOTHED(&start, 0), 1);
    ASSERT_OK(K(diffuse_init)(&start, &track, x0, NULL, 3));
    ASSERT_OK(K(attach)(&track, &tape.attached));
    run_trend();
    ASSERT_OK(K(smooth_states)(&tape));
    ASSERT_OK(K(diffuse_smooth)(&start));
    ASSERT_CLOSE(mean, K(mean)(START_SMOOTHED(&start, 0), 1), 10);
    ASSERT_NAN(K(sigma)(START_SMOOTHED(&start, 0), 1));
    WATCH(P);
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(covariance)(START_SMOOTHED(&start, 0), P));
}

TEST(the_latest_steps_are_kept)
{
    num P[4];
    ASSERT_OK(K(attach)(&track, &tape.attached));
    for (int t = 0; t < 6; t++) predict(&still);
    update(1);
    ASSERT_OK(K(sensor_change_measurement)(&level, H2 + 2));
    update(4);
    TEST_ASSERT_EQUAL_UINT(6, K(diffuse_steps)(&start, NULL));
    TEST_ASSERT_EQUAL_UINT(2, first_early());
    ASSERT_OK(K(diffuse_smooth)(&start));
    WATCH(P);
    for (size_t t = 0; t < 2; t++) {
        ASSERT_NAN(K(mean)(START_SMOOTHED(&start, t), 0));
        ASSERT_REFUSED(KQ_ERR_NOT_READY, K(covariance)(START_SMOOTHED(&start, t), P));
    }
    for (size_t t = 2; t < 7; t++) {
        ASSERT_CLOSE(1, K(mean)(START_SMOOTHED(&start, t), 0), 4);
        ASSERT_CLOSE(3, K(mean)(START_SMOOTHED(&start, t), 1), 4);
        ASSERT_CLOSE(2, K(sigma)(START_SMOOTHED(&start, t), 1), 4);
    }
}

TEST(what_all_the_data_do_not_determine)
{
    num P[4];
    ASSERT_OK(K(attach)(&track, &tape.attached));
    update(3);
    predict(&still);
    update(5);
    ASSERT_OPEN(1, 1);
    ASSERT_OK(K(diffuse_smooth)(&start));
    TEST_ASSERT_EQUAL_UINT(2, K(diffuse_steps)(&start, NULL));
    WATCH(P);
    for (size_t t = 0; t < 2; t++) {
        ASSERT_CLOSE(4, K(mean)(START_SMOOTHED(&start, t), 0), 5);
        ASSERT_CLOSE(1, K(sigma)(START_SMOOTHED(&start, t), 0), 1);
        ASSERT_NAN(K(mean)(START_SMOOTHED(&start, t), 1));
        ASSERT_NAN(K(mean_low)(START_SMOOTHED(&start, t), 1));
        ASSERT_NAN(K(sigma)(START_SMOOTHED(&start, t), 1));
        ASSERT_REFUSED(KQ_ERR_NOT_READY, K(covariance)(START_SMOOTHED(&start, t), P));
    }
    ASSERT_NAN(K(mean)(START_SMOOTHED(&start, 2), 0));
    update(1); /* goes on, and is not recorded */
    ASSERT_CLOSE(4, K(mean)(START_SMOOTHED(&start, 0), 0), 5);
}

TEST(what_was_forgotten_stays_unknown)
{
    ASSERT_OK(K(attach)(&track, &tape.attached));
    update(3);
    predict(&reset);
    update(1);
    ASSERT_OK(K(diffuse_smooth)(&start));
    ASSERT_CLOSE(3, K(mean)(START_SMOOTHED(&start, 0), 0), 5);
    ASSERT_CLOSE(sqrt(2), K(sigma)(START_SMOOTHED(&start, 0), 0), 2);
    ASSERT_NAN(K(mean)(START_SMOOTHED(&start, 0), 1));
    ASSERT_CLOSE(1 / 9.0, K(mean)(START_SMOOTHED(&start, 1), 0), 1);
    ASSERT_CLOSE(0, K(mean)(START_SMOOTHED(&start, 1), 1), 1);
}

/* Then the start has nothing to do with it. */
TEST(a_determined_start_is_recorded_by_the_history)
{
    static const num z[] = {4, 1};
    ASSERT_OK(K(update)(&track, &both, z));
    ASSERT_OK(K(attach)(&track, &tape.attached));
    predict(&trend);
    update(4);
    TEST_ASSERT_EQUAL_UINT(0, K(diffuse_steps)(&start, NULL));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(diffuse_smooth)(&start));
    ASSERT_OK(K(smooth)(&tape));
    TEST_ASSERT_FALSE(isnan(K(mean)(SMOOTHED(&tape, 0), 1)));
    ASSERT_NAN(K(mean)(START_SMOOTHED(&start, 0), 1));
}

/* The early steps do not belong to what it records from there on. */
TEST(a_history_that_begins_anew_is_no_longer_the_starts)
{
    for (int smoothed = 0; smoothed < 2; smoothed++) {
        ASSERT_OK(K(diffuse_init)(&start, &track, x0, NULL, 3));
        ASSERT_OK(K(attach)(&track, &tape.attached));
        run_trend();
        if (smoothed) ASSERT_OK(K(diffuse_smooth)(&start));
        const num early = K(mean)(START_SMOOTHED(&start, 0), 0);
        ASSERT_OK(K(attach)(&track, &tape.attached));
        predict(&trend);
        update(20);
        ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(diffuse_smooth)(&start));
        ASSERT_OK(K(smooth)(&tape));
        ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(diffuse_smooth)(&start));
        for (size_t t = K(diffuse_steps)(&start, NULL); t < 8; t++) {
            ASSERT_NAN(K(mean)(START_SMOOTHED(&start, t), 0));
        }
        const num now = K(mean)(START_SMOOTHED(&start, 0), 0);
        TEST_ASSERT_TRUE(smoothed ? now == early : !!isnan(now));
    }
}

TEST(nothing_unknown_is_recorded_from_the_beginning)
{
    HISTORY(plain_tape, 2, 2, STEPS, STEPS);
    ASSERT_OK(K(diffuse_init)(&start, &track, x0, P0, 0));
    ASSERT_OK(K(filter_init)(&twin, x0, P0));
    ASSERT_OK(K(attach)(&track, &tape.attached));
    ASSERT_OK(K(attach)(&twin, &plain_tape.attached));
    run_trend();
    for (int t = 0; t < 4; t++) {
        const num z = trend_data[t];
        ASSERT_OK(K(update)(&twin, &level, &z));
        ASSERT_OK(K(predict)(&twin, &trend, NULL));
    }
    ASSERT_SAME_FILTER(&twin, &track, 2);
    ASSERT_OK(K(diffuse_smooth)(&start));
    ASSERT_OK(K(smooth)(&plain_tape));
    TEST_ASSERT_EQUAL_UINT(0, K(diffuse_steps)(&start, NULL));
    TEST_ASSERT_EQUAL_UINT(5, K(history_steps)(&tape));
    for (size_t t = 0; t < 5; t++) {
        reading expected, now;
        read_smoothed(&expected, &plain_tape, t, 2);
        read_smoothed(&now, &tape, t, 2);
        TEST_ASSERT_EQUAL_MEMORY(&expected, &now, sizeof now);
        TEST_ASSERT_TRUE(expected.mean[1] == K(mean)(START_SMOOTHED(&start, t), 1));
    }
}

TEST(a_history_that_has_gone_elsewhere)
{
    ASSERT_OK(K(attach)(&track, &tape.attached));
    update(1);
    predict(&trend);
    ASSERT_OK(K(filter_init)(&twin, x0, P0));
    ASSERT_REFUSED(KQ_ERR_RECORDING, K(attach)(&twin, &tape.attached));
    ASSERT_OK(K(detach)(&tape.attached));
    ASSERT_OK(K(attach)(&twin, &tape.attached));
    update(2);
    ASSERT_OPEN(0, 3);
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(diffuse_smooth)(&start));
    ASSERT_REFUSED(KQ_ERR_RECORDING, K(attach)(&track, &tape.attached));
    ASSERT_OK(K(smooth)(&tape));
}

/* Then it may be gone, too: nothing of it is looked at. */
TEST(a_history_that_was_detached)
{
    for (int measurements = 0; measurements <= 3; measurements++) {
        ASSERT_OK(K(diffuse_init)(&start, &track, x0, NULL, UINT32_MAX));
        ASSERT_OK(K(attach)(&track, &tape.attached));
        for (int k = 0; k < measurements; k++) {
            predict(&trend);
            update(1);
        }
        ASSERT_OK(K(detach)(&tape.attached));
        ASSERT_OK(K(detach)(&tape.attached));
        watch_nothing();
        memset(&tape, 0xa5, sizeof tape);
        WATCH(tape), WATCH(tape_memory);
        watched_store();
        predict(&trend);
        for (int k = 0; k < 3; k++) {
            update(1);
            predict(&trend);
        }
        ASSERT_OPEN(0, 3);
        TEST_ASSERT_EQUAL_INT(KQ_ERR_HISTORY_EMPTY, K(diffuse_smooth)(&start));
        ASSERT_OK(K(diffuse_init)(&start, &track, x0, NULL, UINT32_MAX));
        watched_assert_unchanged(__LINE__);
        ASSERT_OK(K(history_assign)(&tape, 2, tape_memory, COUNT(tape_memory)));
    }
    ASSERT_REFUSED(KQ_ERR_NULL, K(detach)(NULL));
    ASSERT_OK_UNCHANGED(K(detach)(&blank_tape.attached));
}

/* ---------------------------------------------------------------------------------- errors */

/* What needs all of the state */
TEST(what_is_not_ready)
{
    static const num z[] = {1};
    num P[4], weights[1];
    update(1);
    WATCH(P), WATCH(weights), WATCH(twin), WATCH(twin_memory);
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(covariance)(&track, P));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(measurement)(&track, &level, weights, NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(innovation)(&track, &level, z, weights));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(gain)(&track, &level, P));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(forecast)(&track, &trend, NULL, 1, &twin));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(filter_copy)(&twin, &track));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, update_huber(&track, &level, z, 1, 2, weights));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, update_student(&track, &level, z, 1, 4, weights));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, update_jump(&track, &level, z, 1, 9));
    ASSERT_OK(K(attach)(&track, &tape.attached));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(smooth)(&tape));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(smooth_step)(&tape, NULL, NULL));
}

TEST(assign_refuses)
{
    static num memory[DIFFUSE_LEN(2, 3)];
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(diffuse_assign)(&start, 2, UINT16_MAX - 1, memory, 1000));
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(diffuse_assign)(&start, 2, 3, memory, DIFFUSE_LEN(2, 3) - 1));
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(diffuse_assign)(&start, 2, 0, memory, DIFFUSE_LEN(2, 0) - 1));
    ASSERT_OK(K(diffuse_assign)(&start, 2, 3, memory, DIFFUSE_LEN(2, 3)));
    TEST_ASSERT_EQUAL_INT((int)DIFFUSE_LEN(2, EARLY), COUNT(start_memory));
    ASSERT_OK(K(diffuse_init)(&plain, &track, x0, NULL, 3));
}

TEST(init_refuses)
{
    static const num C[] = {1, 2, 3, -1};
    ASSERT_REFUSED(KQ_ERR_NOT_SEMIDEFINITE, K(diffuse_init)(&start, &track, x0, C, 1));
    K(diffuse) none;
    memset(&none, 0, sizeof none);
    ASSERT_REFUSED(KQ_ERR_SIZE, K(diffuse_init)(&none, &track, x0, P0, 1));
    none.states = 2;
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(diffuse_init)(&none, &track, x0, P0, 1));
    K(filter) no_filter;
    memset(&no_filter, 0, sizeof no_filter);
    no_filter.states = 2;
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(diffuse_init)(&start, &no_filter, x0, P0, 1));
}

/* Nothing being unknown, it is in nobody's way: of what is attached, or of a step that is refused. */
TEST(a_start_of_nothing_unknown_gives_way)
{
    static const num z[] = {3};
    LAG(lag, 2, 2, 2);
    ASSERT_OK(K(diffuse_init)(&start, &track, x0, P0, 0));
    ASSERT_REFUSED(KQ_ERR_NULL, K(predict)(&track, NULL, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, K(update)(&track, &level, NULL));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(step)(&track, &trend, NULL, &sensor3, z));
    ASSERT_OK(K(attach)(&track, &lag.attached));
    ASSERT_OK(K(step)(&track, &trend, NULL, &level, z));
    TEST_ASSERT_EQUAL_INT(1, K(lag_steps)(&lag));
    ASSERT_OK(K(lagged)(&lag, 1, &view));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(diffuse_smooth)(&start));
}

TEST(attach_and_smooth_refuse)
{
    num P[4];
    K(history) short_one = tape;
    short_one.states = 0;
    ASSERT_REFUSED(KQ_ERR_SIZE, K(attach)(&track, &short_one.attached));
    short_one = tape;
    short_one.memory = NULL;
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(attach)(&track, &short_one.attached));
    short_one.memory = tape_memory;
    short_one.length = HISTORY_LEN(2, 1, 1, 0) - 1;
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(attach)(&track, &short_one.attached));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(diffuse_smooth)(&start));
    WATCH(P);
    ASSERT_REFUSED(KQ_ERR_SIZE, K(diffuse_smoothed)(&start, 0, &view));
    ASSERT_OK(K(attach)(&track, &tape.attached));
    predict(&still);
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(covariance)(START_SMOOTHED(&start, 0), P));
    ASSERT_REFUSED(KQ_ERR_NULL, K(diffuse_smoothed)(&start, 0, NULL));
    /* without room an undetermined run has nothing to smooth */
    ASSERT_OK(K(diffuse_init)(&plain, &track, x0, NULL, 3));
    ASSERT_OK(K(attach)(&track, &tape.attached));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, K(diffuse_smooth)(&plain));
}

TEST(a_full_history_is_refused)
{
    static num memory[HISTORY_LEN(2, 1, 1, 0)];
    K(history) small;
    ASSERT_OK(K(history_assign)(&small, 2, memory, COUNT(memory)));
    ASSERT_OK(K(attach)(&track, &small.attached));
    run_trend();
    TEST_ASSERT_EQUAL_INT(KQ_EVENT_HISTORY_FULL, K(events)(&track));
    ASSERT_REFUSED(KQ_ERR_HISTORY_FULL, K(diffuse_smooth)(&start));
}

/* One that sees nothing unknown and has no variance, or one beyond the numbers: it says nothing of what is unknown, either. */
TEST(what_has_no_variance_leaves_the_unknown)
{
    SENSOR(other, 2, 1);
    static const num none[] = {0}, far[] = {N(0x1p-20 * (double)NUM_MAX), 0}, known[] = {4, 0, 0, 0}, x[] = {0, 0}, z[] = {0};
    ASSERT_OK(K(diffuse_init)(&start, &track, x, zero, 2));
    ASSERT_OK(K(sensor_init)(&other, H, none));
    ASSERT_OK(K(update)(&track, &other, z));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_REDUNDANT, K(events)(&track) & KQ_EVENT_REDUNDANT);
    ASSERT_OPEN(1, 1);
    ASSERT_OK(K(diffuse_init)(&start, &track, x, known, 2));
    ASSERT_OK(K(sensor_init)(&other, far, R));
    ASSERT_OK(K(update)(&track, &other, z));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_OVERFLOW, K(events)(&track) & KQ_EVENT_OVERFLOW);
    ASSERT_OPEN(1, 1);
}

SUITE(diffuse, set_up)
#include "diffuse.tests"
