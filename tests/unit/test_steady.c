/* The equation of the steady state; test_freeze.c runs its filters. */
#include "unchanged.h"

enum { N = 2, M = 2, MOST = KQ_SIZE_MAX };

#ifdef KQ_TEST_F32
#define PRINTED 5e-7 /* six digits */
#define OVERFLOWING {12487.4f, 0, 28289.1f, 0, 780514, 0, 0, 1645020, 0, -1.12088e-10f, 9.67304e18f}
#else
#define PRINTED 5e-9 /* all that are printed */
#define OVERFLOWING {0, 6.12291e47, 0, -5.06977e47, 1.10758e14, 0, 0, 4.8999e13, 3.7256e33, 8.57553e33, 4.96585e177}
#endif

PROCESS(motion, N, 1);
SENSOR(radar, N, M);
FILTER(track, N);

static const num A[] = {0.5, N(0.4), N(0.6), N(0.3)};
static const num B[] = {1, 0.5}, H[] = {1, 0, 0, 1}, one[] = {1};
static const num x0[] = {1, -2};
static const num P0[] = {4, 1, 1, 3}, Q[] = {N(0.3), 0, 0, N(0.3)};
static const num R[] = {0.5, 0.25, 0.25, 0.75};

static num work[SOLVE_LEN(MOST, MOST)];
static num P[MOST * MOST], F[MOST * MOST], K[MOST * MOST], G[MOST * MOST];
static const K(steady_solution) solution = {P, F, K, G};
static uint32_t seed;

/* -1 .. 1 in steps that no rounding changes */
static num draw(void)
{
    seed = seed * 1664525 + 1013904223;
    return (num)((int)(seed >> 20) - 2048) / 2048;
}

static void set_up(void)
{
    seed = 1;
    ASSERT_OK(K(process_init)(&motion, A, B, Q));
    ASSERT_OK(K(sensor_init)(&radar, H, R));
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    watch_nothing();
}

static kq_status solve(void)
{
    return K(steady_solve)(&motion, &radar, work, COUNT(work), &solution);
}

static kq_status solve_in(num *memory, int n, int m, const num *a, const num *h, const num *q, const num *r)
{
    static num process_memory[KQ_PROCESS_LEN(MOST)], sensor_memory[KQ_SENSOR_LEN(MOST)];
    static K(process) p;
    static K(sensor) s;
    ASSERT_OK(K(process_assign)(&p, n, 0, process_memory, COUNT(process_memory)));
    ASSERT_OK(K(process_init)(&p, a, NULL, q));
    ASSERT_OK(K(sensor_assign)(&s, n, m, sensor_memory, COUNT(sensor_memory)));
    ASSERT_OK(K(sensor_init)(&s, h, r));
    return K(steady_solve)(&p, &s, memory, SOLVE_LEN((size_t)n, (size_t)m), &solution);
}

static kq_status solve_of(int n, int m, const num *a, const num *h, const num *q, const num *r)
{
    return solve_in(work, n, m, a, h, q, r);
}

/* ------------------------------------------------------------------ the equation */

TEST(the_covariances_are_those_known)
{
    static const double noise[] = {0.3, 0.5, 0.1};
    static const double known[][3] = {{0.40329108, 0.1050718, 0.41061709},
                                      {0.62286148, 0.12527948, 0.63270989},
                                      {0.16433113, 0.06508848, 0.16752408}};
    static const num r[] = {0.5, 0, 0, 0.5};
    for (int k = 0; k < 3; k++) {
        const num q[] = {N(noise[k]), 0, 0, N(noise[k])};
        ASSERT_OK(solve_of(2, 2, A, H, q, r));
        ASSERT_WITHIN(PRINTED, known[k][0], P[0]);
        ASSERT_WITHIN(PRINTED, known[k][1], P[1]);
        ASSERT_WITHIN(0, P[1], P[2]);
        ASSERT_WITHIN(PRINTED, known[k][2], P[3]);
    }
}

/* The filter itself, run until it has settled, with a correlated R */
TEST(the_filter_leads_to_it)
{
    num gain[N * M], covariance[N * N];
    ASSERT_OK(solve());
    for (int t = 0; t < 60; t++) {
        ASSERT_OK(K(predict)(&track, &motion, NULL));
        if (t < 59) ASSERT_OK(K(update)(&track, &radar, x0));
    }
    ASSERT_OK(K(covariance)(&track, covariance));
    for (int k = 0; k < N * N; k++) ASSERT_CLOSE(covariance[k], P[k], 1);
    ASSERT_OK(K(gain)(&track, &radar, gain));
    for (int k = 0; k < N * M; k++) ASSERT_CLOSE(gain[k], K[k], 1);
    ASSERT_OK(K(update)(&track, &radar, x0));
    ASSERT_OK(K(covariance)(&track, covariance));
    for (int k = 0; k < N * N; k++) ASSERT_CLOSE(covariance[k], F[k], 1);
}

/* G P- = P A' */
TEST(the_smoothers_gain_is_that_of_the_textbook)
{
    ASSERT_OK(solve());
    for (int i = 0; i < N; i++) {
        for (int j = 0; j < N; j++) {
            double left = 0, right = 0;
            for (int k = 0; k < N; k++) {
                left += (double)G[i * N + k] * (double)P[k * N + j];
                right += (double)F[i * N + k] * (double)A[j * N + k];
            }
            ASSERT_CLOSE(right, left, 1);
        }
    }
}

/* P = (q + sqrt(q^2 + 4 q r)) / 2 */
TEST(a_random_walk_has_a_formula)
{
    static const double noise[] = {1e-6, 1e-3, 1, 1e6};
    for (int k = 0; k < COUNT(noise); k++) {
        const num q[] = {N(noise[k])};
        const double rho = 1 / (1 + sqrt(noise[k]));
        ASSERT_OK(solve_of(1, 1, one, one, q, one));
        const double r = (double)q[0], known = (r + sqrt(r * r + 4 * r)) / 2;
        ASSERT_WITHIN(8 * EPS * known / (1 - rho), known, P[0]);
        ASSERT_WITHIN(8 * EPS / (1 - rho), known / (known + 1), K[0]);
    }
}

TEST(an_unstable_state_that_is_measured_is_no_obstacle)
{
    static const num a[] = {2}, q[] = {1};
    ASSERT_OK(solve_of(1, 1, a, one, q, one));
    ASSERT_CLOSE(2 + sqrt(5.0), P[0], 5); /* P = 4 P / (P + 1) + 1 */
}

TEST(noise_free_components_are_taken)
{
    static const num a[] = {1, 0.5, 0, 1}, q[] = {1, 0, 0, 1}, h[] = {1, 0}, zero[] = {0, 0, 0, 0};
    ASSERT_OK(solve_of(2, 1, a, h, q, zero));
    ASSERT_WITHIN(0, 1, K[0]);
    ASSERT_WITHIN(1e-30, 0, F[0]);
    ASSERT_OK(solve_of(2, 2, a, H, q, zero)); /* everything is known: P- = Q */
    for (int k = 0; k < 4; k++) ASSERT_CLOSE(q[k], P[k], 1);
    static const num r[] = {1, 1, 1, 1}, twice[] = {1, 0, 1, 0}; /* the same sensor twice */
    ASSERT_OK(solve_of(2, 1, a, h, q, one));
    const num p = P[0], v = P[3];
    ASSERT_OK(solve_of(2, 2, a, twice, q, r));
    ASSERT_CLOSE(p, P[0], 16);
    ASSERT_CLOSE(v, P[3], 16);
}

TEST(states_that_decay_need_neither_sensor_nor_noise)
{
    static const num a[] = {0.5, 0, 0, 0.875}, h[] = {0, 1}, q[] = {3, 0, 0, 0}, r[] = {1};
    ASSERT_OK(solve_of(2, 1, a, h, q, r));
    ASSERT_CLOSE(4, P[0], 4);
    ASSERT_WITHIN(0, 0, P[3]);
    ASSERT_WITHIN(0, 0, K[0]);
    ASSERT_WITHIN(0, 0, K[1]);
}

TEST(a_lasting_state_must_be_moved_and_measured)
{
    static const num walk[] = {1}, growing[] = {1.5}, zero[] = {0};
    static const num turn[] = {N(0.6), N(0.8), N(-0.8), N(0.6)}, nothing[] = {0, 0, 0, 0};
    static const num a[] = {1, 0.125, 0, 1}, unit[] = {1, 0, 0, 1}, first[] = {1, 0};
    static const num second[] = {0, 1}, sum[] = {1, 1}, bias[] = {1, 0, 0, 0};
    WATCH(P), WATCH(F), WATCH(K), WATCH(G);
    watched_count = 0; /* 16 x 16 of them are more than is watched: the corners */
    watch(P, 64), watch(F, 64), watch(K, 64), watch(G, 64);
    ASSERT_REFUSED(KQ_ERR_NOT_STABILISABLE, solve_of(1, 1, walk, one, zero, one));
    ASSERT_REFUSED(KQ_ERR_NOT_STABILISABLE, solve_of(1, 1, growing, one, zero, one));
    ASSERT_REFUSED(KQ_ERR_NOT_DETECTABLE, solve_of(1, 1, walk, zero, one, one));
    ASSERT_REFUSED(KQ_ERR_NOT_DETECTABLE, solve_of(1, 1, growing, zero, one, one));
    ASSERT_REFUSED(KQ_ERR_NOT_STABILISABLE, solve_of(2, 1, turn, first, nothing, one));
    ASSERT_REFUSED(KQ_ERR_NOT_DETECTABLE, solve_of(2, 1, a, second, unit, one));
    ASSERT_REFUSED(KQ_ERR_NOT_DETECTABLE, solve_of(2, 1, unit, sum, unit, one));
    ASSERT_REFUSED(KQ_ERR_NOT_STABILISABLE, solve_of(2, 2, unit, unit, bias, unit));
    ASSERT_OK(solve_of(2, 1, a, first, unit, one));
}

TEST(the_largest_sizes)
{
    static num a[MOST * MOST], h[MOST * MOST], q[MOST * MOST], r[MOST * MOST], left[MOST * MOST];
    for (int i = 0; i < MOST; i++) {
        for (int j = 0; j < MOST; j++) {
            a[i * MOST + j] = (num)(i == j) + draw() / 16;
            h[i * MOST + j] = draw();
            q[i * MOST + j] = i == j ? (num)0.5 : (num)0.125;
            r[i * MOST + j] = i == j ? (num)2 : (num)0.25;
        }
    }
    ASSERT_OK(solve_of(MOST, MOST, a, h, q, r));
    for (int i = 0; i < MOST; i++) { /* A P A' + Q */
        for (int j = 0; j < MOST; j++) {
            left[i * MOST + j] = 0;
            for (int k = 0; k < MOST; k++) left[i * MOST + j] += a[i * MOST + k] * F[k * MOST + j];
        }
    }
    for (int i = 0; i < MOST; i++) {
        for (int j = 0; j < MOST; j++) {
            double total = (double)q[i * MOST + j];
            for (int k = 0; k < MOST; k++)
                total += (double)left[i * MOST + k] * (double)a[j * MOST + k];
            const double size = sqrt((double)P[i * 17]) * sqrt((double)P[j * 17]);
            ASSERT_WITHIN(64 * EPS * size, total, P[i * MOST + j]);
        }
    }
    ASSERT_OK(solve_of(1, MOST, one, h, one, r));
}

/* A root that leaves the numbers is held, as a filter's; but there is no mean to look at: a word that nobody
   wrote is seen by a memory sanitizer. */
TEST(nothing_is_read_of_memory_that_nobody_wrote)
{
    static const num model[] = OVERFLOWING;
    num memory[SOLVE_LEN(2, 1)];
    const kq_status status = solve_in(memory, 2, 1, model, model + 8, model + 4, model + 10);
    TEST_ASSERT_TRUE(status == KQ_ERR_NO_CONVERGENCE || status == KQ_ERR_NOT_DETECTABLE);
}

TEST(solve_gives_what_it_is_asked_for)
{
    K(steady_solution) some = {NULL, NULL, K, NULL};
    ASSERT_OK(K(steady_solve)(&motion, &radar, work, COUNT(work), &some));
    some = (K(steady_solution)){NULL, NULL, NULL, NULL};
    ASSERT_OK(K(steady_solve)(&motion, &radar, work, COUNT(work), &some));
}

SUITE(steady, set_up)
#include "steady.tests"
