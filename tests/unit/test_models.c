/* Model builders: the matrices, the stationary covariances, and what is refused. */
#include "sizes.h"
#include "unchanged.h"

#ifdef KQ_TEST_F32
#define MODEL KQ_MODEL_F32
#else
#define MODEL KQ_MODEL_F64
#endif

MODEL(pair, 2, 1, 1); /* two states, one noise */
MODEL(two, 2, 2, 1);
MODEL(plane, 4, 4, 2);
MODEL(space, 9, 9, 3);
MODEL(large, 16, 1, 1);
MODEL(wrong, 3, 3, 3);
FILTER(track, 9);
PROCESS(motion, 9, 0);
SENSOR(radar, 9, 3);

static const num ones[16] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
static const num endless = (num)INFINITY;
static K(model) blank;

static void set_up(void)
{
    for (size_t k = 0; k < sizeof pair_memory / sizeof(num); k++) pair_memory[k] = 7;
    for (size_t k = 0; k < sizeof plane_memory / sizeof(num); k++) plane_memory[k] = 7;
    for (size_t k = 0; k < sizeof large_memory / sizeof(num); k++) large_memory[k] = 7;
    memset(&blank, 0, sizeof blank);
    watch_nothing();
    WATCH(pair), WATCH(pair_memory), WATCH(two_memory), WATCH(plane_memory), WATCH(wrong_memory);
}

static void assert_all(const double *expected, const num *actual, int count, UNITY_LINE_TYPE line)
{
    for (int k = 0; k < count; k++) {
        assert_within(16 * EPS * (1 + fabs(expected[k])), expected[k], (double)actual[k], line);
    }
}

#define ASSERT_ALL(expected, actual) assert_all(expected, actual, COUNT(expected), __LINE__)

/* ------------------------------------------------------------ ARMA */

/* AR(2): gamma_0 = (1 - b) / ((1 + b) ((1 - b)^2 - a^2)) */
static void an_autoregression_is_a_companion(void)
{
    static const num phi[] = {0.5, 0.25};
    static const double A[] = {0.5, 0.25, 1, 0}, F[] = {2, 0}, H[] = {1, 0}, R[] = {3};
    const double gamma = 4 * 0.75 / (1.25 * (0.5625 - 0.25)), lag = gamma * 0.5 / 0.75;
    const double P0[] = {gamma, lag, lag, gamma}, x0[] = {0, 0};
    ASSERT_OK(K(model_ar)(&pair, phi, 2, 4, 3));
    ASSERT_ALL(A, pair.A);
    ASSERT_ALL(F, pair.F);
    ASSERT_ALL(H, pair.H);
    ASSERT_ALL(R, pair.R);
    ASSERT_ALL(P0, pair.P0);
    ASSERT_ALL(x0, pair.x0);
}

static void a_moving_average_remembers_the_noises(void)
{
    static const num theta[] = {0.5};
    static const double A[] = {0, 1, 0, 0}, F[] = {0, 2}, H[] = {0.5, 1}, P0[] = {4, 0, 0, 4};
    ASSERT_OK(K(model_ma)(&pair, theta, 1, 4, 0));
    ASSERT_ALL(A, pair.A);
    ASSERT_ALL(F, pair.F);
    ASSERT_ALL(H, pair.H);
    ASSERT_ALL(P0, pair.P0);
}

static void an_arma_is_both(void)
{
    static const num phi[] = {0.5}, theta[] = {-0.25};
    static const double A[] = {0.5, 0, 1, 0}, F[] = {1, 0}, H[] = {1, -0.25};
    static const double P0[] = {4 / 3., 2 / 3., 2 / 3., 4 / 3.};
    ASSERT_OK(K(model_arma)(&pair, phi, 1, theta, 1, 1, 0));
    ASSERT_ALL(A, pair.A);
    ASSERT_ALL(F, pair.F);
    ASSERT_ALL(H, pair.H);
    ASSERT_ALL(P0, pair.P0);
}

static void no_order_is_white_noise(void)
{
    static const double zero[] = {0}, four[] = {4}, one[] = {1};
    MODEL(white, 1, 1, 1);
    ASSERT_OK(K(model_arma)(&white, NULL, 0, NULL, 0, 4, 0));
    ASSERT_ALL(zero, white.A), ASSERT_ALL(four, white.P0), ASSERT_ALL(one, white.H);
    ASSERT_OK(K(model_ma)(&white, NULL, 0, 4, 0));
    ASSERT_ALL(zero, white.A), ASSERT_ALL(four, white.P0), ASSERT_ALL(one, white.H);
}

static void assert_stationary(const K(model) * m, double tolerance)
{
    static num P[256];
    const int n = m->states;
    ASSERT_OK(K(stationary_covariance)(P, m->A, m->F, n, m->noises));
    for (int k = 0; k < n * n; k++) {
        ASSERT_WITHIN(tolerance * (double)m->P0[0], m->P0[k], P[k]);
        TEST_ASSERT_TRUE(m->P0[k] == m->P0[k % n * n + k / n]);
        TEST_ASSERT_TRUE(P[k] == P[k % n * n + k / n]);
    }
}

/* The recursion's covariance is the solution of the equation, of the largest order, too. */
static void the_covariance_is_stationary(void)
{
    static const num phi[] = {0.5, -0.25, 0.125, 0, 0, 0.25, 0, 0, 0, 0, 0, 0, 0, 0, 0, -0.125};
    static const num theta[] = {1, 0.5, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
    static const num longer[] = {0.5, 0.25};
    ASSERT_OK(K(model_ar)(&large, phi, 16, 2, 0));
    assert_stationary(&large, 64 * EPS);
    ASSERT_OK(K(model_arma)(&large, phi, 16, theta, 15, 2, 0));
    assert_stationary(&large, 64 * EPS);
    ASSERT_OK(K(model_arma)(&large, longer, 2, theta, 15, 2, 0));
    assert_stationary(&large, 64 * EPS);
    ASSERT_OK(K(model_ma)(&large, theta, 15, 2, 0));
    assert_stationary(&large, 64 * EPS);
}

static void what_is_not_stationary_is_refused(void)
{
    static const num bad[][2] = {{1, 0},     {-1, 0},       {0, 1},     {0, -1},
                                 {0.5, 0.5}, {-0.5, .5},    {2, -1},    {0, -2},
                                 {1.5, 0.5}, {0.25, 0.875}, {1, 0.125}, {0, 1e10f}};
    static num P[4];
    WATCH(P);
    for (int k = 0; k < COUNT(bad); k++) {
        const num A[] = {bad[k][0], bad[k][1], 1, 0};
        ASSERT_REFUSED(KQ_ERR_NO_CONVERGENCE, K(model_ar)(&pair, bad[k], 2, 1, 0));
        ASSERT_REFUSED(KQ_ERR_NO_CONVERGENCE, K(model_arma)(&pair, bad[k], 2, NULL, 0, 1, 0));
        ASSERT_REFUSED(KQ_ERR_NO_CONVERGENCE, K(stationary_covariance)(P, A, ones, 2, 1));
        ASSERT_REFUSED(KQ_ERR_NO_CONVERGENCE, K(model_factor)(&two, 2, 1, ones, A, ones, ones));
    }
}

static void a_covariance_may_be_in_the_place_of_its_model(void)
{
    num A[] = {0.5, 0.25, 0, 0.5}, F[] = {1, 0, 0, 1}, P[4];
    ASSERT_OK(K(stationary_covariance)(P, A, F, 2, 2));
    ASSERT_OK(K(stationary_covariance)(F, A, F, 2, 2));
    ASSERT_SAME_BITS(P, F);
    F[0] = 1, F[1] = 0, F[2] = 0, F[3] = 1;
    ASSERT_OK(K(stationary_covariance)(A, A, F, 2, 2));
    ASSERT_SAME_BITS(P, A);
    P[0] = 0.5;
    ASSERT_OK(K(stationary_covariance)(P, P, NULL, 1, 0));
    ASSERT_WITHIN(0, 0, P[0]);
}

/* ------------------------------------------------------------ structural models */

static void a_level_walks(void)
{
    static const double one[] = {1}, three[] = {3}, four[] = {4}, five[] = {5}, six[] = {6};
    MODEL(nile, 1, 1, 1);
    ASSERT_OK(K(model_level)(&nile, 9, 4, 5, 6));
    ASSERT_ALL(one, nile.A), ASSERT_ALL(three, nile.F), ASSERT_ALL(one, nile.H);
    ASSERT_ALL(four, nile.R), ASSERT_ALL(five, nile.x0), ASSERT_ALL(six, nile.P0);
}

static void a_trend_has_a_slope(void)
{
    static const num drift[] = {4, 9}, mean[] = {1, 2}, variance[] = {3, 5};
    static const double A[] = {1, 1, 0, 1}, F[] = {2, 0, 0, 3}, H[] = {1, 0};
    static const double x0[] = {1, 2}, P0[] = {3, 0, 0, 5}, none[] = {0, 0};
    ASSERT_OK(K(model_trend)(&two, drift, 7, mean, variance));
    ASSERT_ALL(A, two.A), ASSERT_ALL(F, two.F), ASSERT_ALL(H, two.H);
    ASSERT_ALL(x0, two.x0), ASSERT_ALL(P0, two.P0);
    ASSERT_OK(K(model_trend)(&two, drift, 7, NULL, variance));
    ASSERT_ALL(none, two.x0);
}

static void a_season_adds_up_to_its_noise(void)
{
    static const double A[] = {-1, -1, 1, 0}, F[] = {2, 0}, H[] = {1, 0};
    ASSERT_OK(K(model_season)(&pair, 3, 4, 1, NULL, ones));
    ASSERT_ALL(A, pair.A), ASSERT_ALL(F, pair.F), ASSERT_ALL(H, pair.H);
    ASSERT_OK(K(model_season)(&large, 17, 4, 1, NULL, ones));
    for (int k = 0; k < 16; k++) ASSERT_WITHIN(0, -1, large.A[k]);
    for (int i = 1; i < 16; i++) ASSERT_WITHIN(0, 1, large.A[i * 16 + i - 1]);
    MODEL(even, 1, 1, 1);
    ASSERT_OK(K(model_season)(&even, 2, 4, 1, NULL, ones));
    ASSERT_WITHIN(0, -1, even.A[0]);
}

static void a_trend_may_have_a_season(void)
{
    static const num drift[] = {4, 9, 16};
    static const double A[] = {1, 1, 0, 0, 0, 1, 0, 0, 0, 0, -1, -1, 0, 0, 1, 0};
    static const double F[] = {2, 0, 0, 0, 3, 0, 0, 0, 4, 0, 0, 0}, H[] = {1, 0, 1, 0};
    MODEL(basic, KQ_TREND_SEASON_STATES(3), 3, 1);
    ASSERT_OK(K(model_trend_season)(&basic, 3, drift, 1, NULL, ones));
    ASSERT_ALL(A, basic.A), ASSERT_ALL(F, basic.F), ASSERT_ALL(H, basic.H);
    MODEL(most, KQ_TREND_SEASON_STATES(15), 3, 1);
    ASSERT_OK(K(model_trend_season)(&most, 15, drift, 1, NULL, ones));
}

static void coefficients_of_a_regression_walk(void)
{
    static const num h[] = {2, 5}, drift[] = {4, 0}, mean[] = {1, 2}, variance[] = {3, 5};
    static const double A[] = {1, 0, 0, 1}, F[] = {2, 0, 0, 0}, H[] = {2, 5}, P0[] = {3, 0, 0, 5};
    ASSERT_OK(K(model_regression)(&two, h, 2, drift, 7, mean, variance));
    ASSERT_ALL(A, two.A), ASSERT_ALL(F, two.F), ASSERT_ALL(H, two.H), ASSERT_ALL(P0, two.P0);
    ASSERT_WITHIN(0, 7, two.R[0]);
}

static void factors_are_stationary(void)
{
    static const num loadings[] = {1, 0.5, 0, 1, 2, -1}, A[] = {0.5, 0.25, 0, 0.5};
    static const num drift[] = {1, 4}, noise[] = {1, 2, 3};
    static const double F[] = {1, 0, 0, 2};
    MODEL(index, 2, 2, 3);
    ASSERT_OK(K(model_factor)(&index, 2, 3, loadings, A, drift, noise));
    TEST_ASSERT_EQUAL_MEMORY(loadings, index.H, sizeof loadings);
    TEST_ASSERT_EQUAL_MEMORY(A, index.A, sizeof A);
    TEST_ASSERT_EQUAL_MEMORY(noise, index.R, sizeof noise);
    ASSERT_ALL(F, index.F);
    assert_stationary(&index, 16 * EPS);
    ASSERT_CLOSE(16 / 3., index.P0[3], 8);
}

/* ------------------------------------------------------------ motion */

/* (F F')_ij */
static double noise_covariance(const K(model) * m, int i, int j)
{
    const int r = m->noises;
    double sum = 0;
    for (int k = 0; k < r; k++) sum += (double)m->F[i * r + k] * (double)m->F[j * r + k];
    return sum;
}

static void velocity_is_that_of_white_acceleration(void)
{
    static const num density[] = {4, 9}, noise[] = {1, 2}, variance[] = {1, 2, 3, 4};
    static const double A[] = {1, 0.5, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0.5, 0, 0, 0, 1};
    static const double H[] = {1, 0, 0, 0, 0, 0, 1, 0}, R[] = {1, 2};
    const double Q[] = {0.125 / 3, 0.125, 0.125, 0.5};
    ASSERT_OK(K(model_velocity)(&plane, 2, 0.5, density, noise, NULL, variance));
    ASSERT_ALL(A, plane.A), ASSERT_ALL(H, plane.H), ASSERT_ALL(R, plane.R);
    for (int i = 0; i < 4; i++) {
        for (int j = 0; j < 4; j++) {
            const double q = i / 2 == j / 2 ? (double)density[i / 2] * Q[i % 2 * 2 + j % 2] : 0;
            ASSERT_CLOSE(q, noise_covariance(&plane, i, j), 1);
        }
        ASSERT_WITHIN(0, variance[i], plane.P0[5 * i]);
    }
}

static void acceleration_is_that_of_white_jerk(void)
{
    static const num density[] = {1, 4, 9}, noise[] = {1, 2, 3};
    const double h = 0.5, Q[] = {pow(h, 5) / 20, pow(h, 4) / 8, pow(h, 3) / 6,
                                 pow(h, 4) / 8,  pow(h, 3) / 3, h * h / 2,
                                 pow(h, 3) / 6,  h * h / 2,     h};
    ASSERT_OK(K(model_acceleration)(&space, 3, 0.5, density, noise, NULL, ones));
    for (int i = 0; i < 9; i++) {
        for (int j = 0; j < 9; j++) {
            const double q = i / 3 == j / 3 ? (double)density[i / 3] * Q[i % 3 * 3 + j % 3] : 0;
            ASSERT_CLOSE(q, noise_covariance(&space, i, j), 4);
            if (j < i) ASSERT_WITHIN(0, 0, space.A[i * 9 + j]); /* upper triangular */
        }
    }
    ASSERT_WITHIN(0, 0.125, space.A[2]);
    ASSERT_WITHIN(0, 0.5, space.A[1]);
    ASSERT_OK(K(process_init_factor)(&motion, space.A, NULL, space.F, space.noises));
    ASSERT_OK(K(sensor_init_diagonal)(&radar, space.H, space.R));
    ASSERT_OK(K(filter_init)(&track, space.x0, space.P0));
    ASSERT_OK(K(update)(&track, &radar, ones));
    ASSERT_CLOSE(0.5, K(mean)(&track, 0), 1);
    ASSERT_OK(K(predict)(&track, &motion, NULL));
}

static void one_axis_is_enough(void)
{
    static const double A[] = {1, 2, 0, 1};
    ASSERT_OK(K(model_velocity)(&two, 1, 2, ones, ones, NULL, ones));
    ASSERT_ALL(A, two.A);
    MODEL(line, 3, 3, 1);
    ASSERT_OK(K(model_acceleration)(&line, 1, 2, ones, ones, NULL, ones));
    ASSERT_WITHIN(0, 2, line.A[2]);
}

/* ------------------------------------------------------------ sizes and memory */

_Static_assert(KQ_AR_STATES(3) == 3 && KQ_MA_STATES(3) == 4, "sizes");
_Static_assert(KQ_ARMA_STATES(3, 1) == 3 && KQ_ARMA_STATES(1, 1) == 2, "sizes");
_Static_assert(KQ_ARMA_STATES(0, 0) == 1 && KQ_ARMA_STATES(2, 5) == 6, "sizes");
_Static_assert(KQ_SEASON_STATES(12) == 11 && KQ_TREND_SEASON_STATES(12) == 13, "sizes");
_Static_assert(KQ_VELOCITY_STATES(3) == 6 && KQ_ACCELERATION_NOISES(3) == 9, "sizes");
_Static_assert(KQ_MODEL_LEN(4, 3, 2) == 16 + 12 + 8 + 2 + 4 + 16, "length");

static void memory_may_be_given_at_run_time(void)
{
    static num room[GUARDED(KQ_MODEL_LEN(4, 4, 2))];
    num *memory = guard(room, COUNT(room));
    K(model) made;
    ASSERT_OK(K(model_assign)(&made, 4, 4, 2, memory, KQ_MODEL_LEN(4, 4, 2)));
    ASSERT_OK(K(model_velocity)(&made, 2, 0.5, ones, ones, NULL, ones));
    ASSERT_OK(K(model_velocity)(&plane, 2, 0.5, ones, ones, NULL, ones));
    TEST_ASSERT_EQUAL_MEMORY(plane_memory, memory, sizeof plane_memory);
    assert_guards(room, KQ_MODEL_LEN(4, 4, 2), COUNT(room));
    blank = made;
    WATCH(blank);
    const size_t length = KQ_MODEL_LEN(4, 4, 2);
    ASSERT_REFUSED(KQ_ERR_NULL, K(model_assign)(NULL, 4, 4, 2, memory, length));
    ASSERT_REFUSED(KQ_ERR_NULL, K(model_assign)(&blank, 4, 4, 2, NULL, length));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(model_assign)(&blank, 0, 4, 2, memory, length));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(model_assign)(&blank, 4, 17, 2, memory, length));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(model_assign)(&blank, 4, 4, 0, memory, length));
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(model_assign)(&blank, 4, 4, 2, memory, length - 1));
}

/* ------------------------------------------------------------ what is refused */

static void a_model_of_other_sizes_is_refused(void)
{
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(model_ar)(&wrong, ones, 2, 1, 1));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(model_ma)(&wrong, ones, 1, 1, 1));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(model_arma)(&wrong, ones, 1, ones, 1, 1, 1));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(model_regression)(&wrong, ones, 2, ones, 1, NULL, ones));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(model_level)(&wrong, 1, 1, 1, 1));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(model_trend)(&wrong, ones, 1, NULL, ones));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(model_season)(&wrong, 4, 1, 1, NULL, ones));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(model_trend_season)(&wrong, 2, ones, 1, NULL, ones));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(model_factor)(&wrong, 3, 2, ones, ones, ones, ones));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(model_velocity)(&wrong, 3, 1, ones, ones, NULL, ones));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(model_acceleration)(&wrong, 1, 1, ones, ones, NULL, ones));
}

static void a_model_without_memory_is_refused(void)
{
    ASSERT_REFUSED(KQ_ERR_NULL, K(model_ar)(NULL, ones, 2, 1, 1));
    ASSERT_REFUSED(KQ_ERR_NULL, K(model_velocity)(NULL, 2, 1, ones, ones, NULL, ones));
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(model_ar)(&blank, ones, 2, 1, 1));
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(model_ma)(&blank, ones, 2, 1, 1));
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(model_factor)(&blank, 2, 2, ones, ones, ones, ones));
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(model_velocity)(&blank, 2, 1, ones, ones, NULL, ones));
}

static void orders_out_of_range_are_refused(void)
{
    static num P[4];
    ASSERT_REFUSED(KQ_ERR_SIZE, K(model_ar)(&pair, ones, 0, 1, 1));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(model_ar)(&pair, ones, 17, 1, 1));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(model_ma)(&pair, ones, -1, 1, 1));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(model_ma)(&pair, ones, 16, 1, 1));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(model_arma)(&pair, ones, -1, ones, 1, 1, 1));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(model_arma)(&pair, ones, 1, ones, 16, 1, 1));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(model_regression)(&two, ones, 0, ones, 1, NULL, ones));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(model_season)(&pair, 1, 1, 1, NULL, ones));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(model_season)(&pair, 18, 1, 1, NULL, ones));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(model_trend_season)(&pair, 1, ones, 1, NULL, ones));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(model_trend_season)(&pair, 16, ones, 1, NULL, ones));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(model_factor)(&two, 0, 1, ones, ones, ones, ones));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(model_factor)(&two, 2, 17, ones, ones, ones, ones));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(model_velocity)(&plane, 0, 1, ones, ones, NULL, ones));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(model_velocity)(&plane, 4, 1, ones, ones, NULL, ones));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(stationary_covariance)(P, ones, ones, 0, 1));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(stationary_covariance)(P, ones, ones, 2, 17));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(stationary_covariance)(P, ones, ones, 2, -1));
}

static void pointers_are_needed(void)
{
    static num P[4];
    ASSERT_REFUSED(KQ_ERR_NULL, K(model_ar)(&pair, NULL, 2, 1, 1));
    ASSERT_REFUSED(KQ_ERR_NULL, K(model_ma)(&pair, NULL, 1, 1, 1));
    ASSERT_REFUSED(KQ_ERR_NULL, K(model_arma)(&pair, NULL, 1, ones, 1, 1, 1));
    ASSERT_REFUSED(KQ_ERR_NULL, K(model_arma)(&pair, ones, 1, NULL, 1, 1, 1));
    ASSERT_REFUSED(KQ_ERR_NULL, K(model_regression)(&two, NULL, 2, ones, 1, NULL, ones));
    ASSERT_REFUSED(KQ_ERR_NULL, K(model_regression)(&two, ones, 2, NULL, 1, NULL, ones));
    ASSERT_REFUSED(KQ_ERR_NULL, K(model_regression)(&two, ones, 2, ones, 1, NULL, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, K(model_trend)(&two, NULL, 1, NULL, ones));
    ASSERT_REFUSED(KQ_ERR_NULL, K(model_trend)(&two, ones, 1, NULL, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, K(model_season)(&pair, 3, 1, 1, NULL, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, K(model_factor)(&two, 2, 1, NULL, ones, ones, ones));
    ASSERT_REFUSED(KQ_ERR_NULL, K(model_factor)(&two, 2, 1, ones, NULL, ones, ones));
    ASSERT_REFUSED(KQ_ERR_NULL, K(model_factor)(&two, 2, 1, ones, ones, NULL, ones));
    ASSERT_REFUSED(KQ_ERR_NULL, K(model_factor)(&two, 2, 1, ones, ones, ones, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, K(model_velocity)(&plane, 2, 1, NULL, ones, NULL, ones));
    ASSERT_REFUSED(KQ_ERR_NULL, K(model_velocity)(&plane, 2, 1, ones, NULL, NULL, ones));
    ASSERT_REFUSED(KQ_ERR_NULL, K(model_velocity)(&plane, 2, 1, ones, ones, NULL, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, K(stationary_covariance)(NULL, ones, ones, 2, 1));
    ASSERT_REFUSED(KQ_ERR_NULL, K(stationary_covariance)(P, NULL, ones, 2, 1));
    ASSERT_REFUSED(KQ_ERR_NULL, K(stationary_covariance)(P, ones, NULL, 2, 1));
}

static num bad[16];

static kq_status ar_of_bad(void) { return K(model_ar)(&pair, bad, 2, 1, 0); }
static kq_status arma_of_bad(void) { return K(model_arma)(&pair, bad, 1, bad, 1, 1, 0); }
static kq_status trend_drift(void) { return K(model_trend)(&two, bad, 1, NULL, ones); }
static kq_status trend_mean(void) { return K(model_trend)(&two, ones, 1, bad, ones); }
static kq_status trend_variance(void) { return K(model_trend)(&two, ones, 1, NULL, bad); }
static kq_status regressors(void) { return K(model_regression)(&two, bad, 2, ones, 1, NULL, ones); }
static kq_status loadings(void) { return K(model_factor)(&two, 2, 1, bad, bad, ones, ones); }
static kq_status density(void) { return K(model_velocity)(&plane, 2, 1, bad, ones, NULL, ones); }
static kq_status measured(void) { return K(model_velocity)(&plane, 2, 1, ones, bad, NULL, ones); }

static void arguments_must_be_finite(void)
{
    for (int k = 0; k < 16; k++) bad[k] = 0.25;
    assert_entries_must_be_finite(bad, 2, ar_of_bad);
    assert_entries_must_be_finite(bad, 1, arma_of_bad);
    assert_entries_must_be_finite(bad, 2, trend_drift);
    assert_entries_must_be_finite(bad, 2, trend_mean);
    assert_entries_must_be_finite(bad, 2, trend_variance);
    assert_entries_must_be_finite(bad, 2, regressors);
    assert_entries_must_be_finite(bad, 2, loadings);
    assert_entries_must_be_finite(bad, 2, density);
    assert_entries_must_be_finite(bad, 2, measured);
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(model_ar)(&pair, bad, 2, endless, 0));
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(model_ma)(&pair, bad, 1, 1, endless));
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE,
                   K(model_velocity)(&plane, 2, endless, ones, ones, NULL, ones));
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE,
                   K(model_velocity)(&plane, 2, NUM_MAX, ones, ones, NULL, ones));
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(model_ar)(&pair, bad, 2, NUM_MAX, 0));
}

static void variances_must_not_be_negative(void)
{
    static const num negative[] = {1, -1, 1, 1};
    ASSERT_REFUSED(KQ_ERR_NOT_SEMIDEFINITE, K(model_ar)(&pair, bad, 2, -1, 0));
    ASSERT_REFUSED(KQ_ERR_NOT_SEMIDEFINITE, K(model_ma)(&pair, bad, 1, 1, -1));
    ASSERT_REFUSED(KQ_ERR_NOT_SEMIDEFINITE, K(model_trend)(&two, negative, 1, NULL, ones));
    ASSERT_REFUSED(KQ_ERR_NOT_SEMIDEFINITE, K(model_trend)(&two, ones, -1, NULL, ones));
    ASSERT_REFUSED(KQ_ERR_NOT_SEMIDEFINITE, K(model_trend)(&two, ones, 1, NULL, negative));
    ASSERT_REFUSED(KQ_ERR_NOT_SEMIDEFINITE, K(model_factor)(&two, 2, 1, ones, bad, negative, ones));
    ASSERT_REFUSED(KQ_ERR_NOT_SEMIDEFINITE,
                   K(model_velocity)(&plane, 2, 1, negative, ones, NULL, ones));
}

static void time_must_go_on(void)
{
    ASSERT_REFUSED(KQ_ERR_RANGE, K(model_velocity)(&plane, 2, 0, ones, ones, NULL, ones));
    ASSERT_REFUSED(KQ_ERR_RANGE, K(model_velocity)(&plane, 2, -1, ones, ones, NULL, ones));
}

SUITE(models, set_up)
{
    RUN_TEST(an_autoregression_is_a_companion);
    RUN_TEST(a_moving_average_remembers_the_noises);
    RUN_TEST(an_arma_is_both);
    RUN_TEST(no_order_is_white_noise);
    RUN_TEST(the_covariance_is_stationary);
    RUN_TEST(what_is_not_stationary_is_refused);
    RUN_TEST(a_covariance_may_be_in_the_place_of_its_model);
    RUN_TEST(a_level_walks);
    RUN_TEST(a_trend_has_a_slope);
    RUN_TEST(a_season_adds_up_to_its_noise);
    RUN_TEST(a_trend_may_have_a_season);
    RUN_TEST(coefficients_of_a_regression_walk);
    RUN_TEST(factors_are_stationary);
    RUN_TEST(velocity_is_that_of_white_acceleration);
    RUN_TEST(acceleration_is_that_of_white_jerk);
    RUN_TEST(one_axis_is_enough);
    RUN_TEST(memory_may_be_given_at_run_time);
    RUN_TEST(a_model_of_other_sizes_is_refused);
    RUN_TEST(a_model_without_memory_is_refused);
    RUN_TEST(orders_out_of_range_are_refused);
    RUN_TEST(pointers_are_needed);
    RUN_TEST(arguments_must_be_finite);
    RUN_TEST(variances_must_not_be_negative);
    RUN_TEST(time_must_go_on);
}
