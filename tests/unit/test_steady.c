/* The steady state: the equation, and what a filter of constant gain refuses; test_settling.c runs the filters. */
#include "unchanged.h"

enum { N = 2, M = 2, MOST = KQ_SIZE_MAX, GAINS = 30, RUN = 200 };

#ifdef KQ_TEST_F32
#define SOLVE_LEN KQ_STEADY_SOLVE_LEN_F32
#define STEADY_LEN KQ_STEADY_LEN_F32
#define FREEZE_LEN KQ_FREEZE_LEN_F32
#define BITS_MAX KQ_FREEZE_BITS_MAX_F32
#define PRINTED 5e-7 /* six digits */
#define OVERFLOWING {12487.4f, 0, 28289.1f, 0, 780514, 0, 0, 1645020, 0, -1.12088e-10f, 9.67304e18f}
#else
#define SOLVE_LEN KQ_STEADY_SOLVE_LEN_F64
#define STEADY_LEN KQ_STEADY_LEN_F64
#define FREEZE_LEN KQ_FREEZE_LEN_F64
#define BITS_MAX KQ_FREEZE_BITS_MAX_F64
#define PRINTED 5e-9 /* all that are printed */
#define OVERFLOWING {0, 6.12291e47, 0, -5.06977e47, 1.10758e14, 0, 0, 4.8999e13, 3.7256e33, 8.57553e33, 4.96585e177}
#endif

PROCESS(motion, N, 1);
SENSOR(radar, N, M);
FILTER(track, N);
FILTER(other, N);
STEADY(steady, N, M);

/* never initialised, and of other sizes */
PROCESS(blank_process, N, 1);
SENSOR(blank_sensor, N, M);
SENSOR(radar1, 1, 1);

static num A[] = {0.5, N(0.4), N(0.6), N(0.3)};
static const num B[] = {1, 0.5}, H[] = {1, 0, 0, 1}, one[] = {1};
static num x0[] = {1, -2};
static const num P0[] = {4, 1, 1, 3}, Q[] = {N(0.3), 0, 0, N(0.3)};
static const num R[] = {0.5, 0.25, 0.25, 0.75};

static num work[SOLVE_LEN(MOST, MOST)];
static num P[MOST * MOST], F[MOST * MOST], K[MOST * MOST], G[MOST * MOST];
static const K(steady_solution) solution = {P, F, K, G};
static num gains[GAINS * N * M], u[1], z[M], innovation[M];
static uint32_t seed;

/* -1 .. 1 in steps that no rounding changes */
static num draw(void)
{
    seed = seed * 1664525 + 1013904223;
    return (num)((int)(seed >> 20) - 2048) / 2048;
}

static void draw_step(void)
{
    u[0] = draw();
    for (int c = 0; c < M; c++) z[c] = 3 * draw();
}

/* The gains of the first updates behind the prior */
static void make_gains(void)
{
    ASSERT_OK(K(filter_init)(&other, x0, P0));
    for (int t = 0; t < GAINS; t++) {
        ASSERT_OK(K(gain)(&other, &radar, gains + t * N * M));
        ASSERT_OK(K(update)(&other, &radar, x0));
        ASSERT_OK(K(predict)(&other, &motion, NULL));
    }
}

static void set_up(void)
{
    A[0] = 0.5;
    seed = 1;
    ASSERT_OK(K(process_init)(&motion, A, B, Q));
    ASSERT_OK(K(sensor_init)(&radar, H, R));
    ASSERT_OK(K(sensor_init)(&radar1, one, one));
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    make_gains();
    ASSERT_OK(K(filter_init)(&other, x0, P0));
    ASSERT_OK(K(steady_assign)(&steady, N, M, steady_memory, COUNT(steady_memory)));
    ASSERT_OK(K(steady_init)(&steady, &motion, &radar, x0, gains, GAINS));
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
        const double r = q[0], known = (r + sqrt(r * r + 4 * r)) / 2;
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

TEST(solve_refuses_what_is_wrong)
{
    const size_t least = SOLVE_LEN(2, 2);
    watch(P, 64), watch(F, 64), watch(K, 64), watch(G, 64);
    WATCH(motion), WATCH(radar);
    watch(work, 256);
    ASSERT_REFUSED(KQ_ERR_NULL, K(steady_solve)(NULL, &radar, work, least, &solution));
    ASSERT_REFUSED(KQ_ERR_NULL, K(steady_solve)(&motion, NULL, work, least, &solution));
    ASSERT_REFUSED(KQ_ERR_NULL, K(steady_solve)(&motion, &radar, NULL, least, &solution));
    ASSERT_REFUSED(KQ_ERR_NULL, K(steady_solve)(&motion, &radar, work, least, NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY,
                   K(steady_solve)(&blank_process, &radar, work, least, &solution));
    ASSERT_REFUSED(KQ_ERR_NOT_READY,
                   K(steady_solve)(&motion, &blank_sensor, work, least, &solution));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(steady_solve)(&motion, &radar1, work, least, &solution));
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(steady_solve)(&motion, &radar, work, least - 1, &solution));
    ASSERT_OK(K(steady_solve)(&motion, &radar, work, least, &solution));
}

/* ------------------------------------------------------------------ the filter's gains */

TEST(the_gains_lead_to_the_steady_one)
{
    ASSERT_OK(solve()); /* |rho| is below 0.7 */
    for (int k = 0; k < N * M; k++) {
        ASSERT_WITHIN(0x1p-12 / (1 - 0.5), K[k], gains[(GAINS - 1) * N * M + k]);
    }
}

/* ------------------------------------------------------------------ the filter */

TEST(one_gain_is_the_steady_filter)
{
    ASSERT_OK(solve());
    ASSERT_OK(K(steady_init)(&steady, &motion, &radar, x0, K, 1));
    double x[] = {(double)x0[0], (double)x0[1]}, a[N * N], k[N * M];
    for (int i = 0; i < N * N; i++) a[i] = (double)A[i], k[i] = (double)K[i];
    for (int t = 0; t < RUN; t++) {
        draw_step();
        const double drive_of = (double)u[0], first = (double)z[0], second = (double)z[1];
        const double b = a[0] * x[0] + a[1] * x[1] + drive_of;
        const double c = a[2] * x[0] + a[3] * x[1] + drive_of / 2;
        x[0] = b + k[0] * (first - b) + k[1] * (second - c);
        x[1] = c + k[2] * (first - b) + k[3] * (second - c);
        ASSERT_OK(K(steady_step)(&steady, u, z));
        for (int i = 0; i < N; i++) ASSERT_CLOSE(x[i], K(steady_mean)(&steady, i), 4);
    }
}

static kq_status begin(void) { return K(steady_init)(&steady, &motion, &radar, x0, gains, GAINS); }

static kq_status step(void) { return K(steady_step)(&steady, u, z); }

TEST(numbers_must_be_finite)
{
    draw_step();
    assert_entries_must_be_finite(x0, N, begin);
    x0[0] = 1, x0[1] = -2;
    assert_entries_must_be_finite(gains, GAINS * N * M, begin);
    WATCH(steady), WATCH(steady_memory);
    assert_entries_must_be_finite(z, M, step);
    assert_entries_must_be_finite(u, 1, step);
}

static kq_status predict(void) { return K(steady_predict)(&steady, u); }

static kq_status update(void) { return K(steady_update)(&steady, z); }

static kq_status innovate(void) { return K(steady_innovation)(&steady, z, innovation); }

/* One diverges: the step that would take its mean beyond the numbers is refused, as each after it, with all its
   forms; so is one whose unmeasured state is there already. */
TEST(a_mean_beyond_the_numbers_is_refused)
{
    static const num growing[] = {4, 0, 0, 1}, no_gain[N * M] = {0}, far[] = {NUM_MAX, 1};
    draw_step();
    ASSERT_OK(K(process_init)(&motion, growing, B, Q));
    ASSERT_OK(K(steady_init)(&steady, &motion, &radar, x0, no_gain, 1));
    kq_status status = KQ_OK;
    for (int k = 0; k < 2000 && !status; k++) {
        TEST_ASSERT_TRUE(isfinite(K(steady_mean)(&steady, 0)) && isfinite(K(steady_mean)(&steady, 1)));
        status = k % 2 ? step() : predict();
    }
    WATCH(steady), WATCH(steady_memory), WATCH(innovation);
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, step());
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, predict());
    watch_nothing();
    static const num opposite[] = {-1, 0, 0, 1};
    ASSERT_OK(K(sensor_init)(&radar, opposite, R));
    ASSERT_OK(K(steady_init)(&steady, &motion, &radar, far, no_gain, 1));
    z[0] = NUM_MAX;
    WATCH(steady), WATCH(steady_memory), WATCH(innovation);
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, update());
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, innovate());
    watch_nothing();
    steady_memory[0] = 0, steady_memory[1] = (num)NAN, z[0] = 1;
    ASSERT_OK(K(sensor_init)(&radar, H, R));
    WATCH(steady), WATCH(innovation);
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, step());
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, update());
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, innovate());
}

SUITE(steady, set_up)
#include "steady.tests"
