/* The steady state: the equation, the filter and the freeze filter. */
#include "unchanged.h"

enum { N = 2, M = 2, MOST = KQ_SIZE_MAX, GAINS = 30, RUN = 200 };

#ifdef KQ_TEST_F32
#define STEADY KQ_STEADY_F32
#define SETTLING KQ_FREEZE_F32
#define SOLVE_LEN KQ_STEADY_SOLVE_LEN_F32
#define STEADY_LEN KQ_STEADY_LEN_F32
#define FREEZE_LEN KQ_FREEZE_LEN_F32
#define BITS_MAX KQ_FREEZE_BITS_MAX_F32
#define PRINTED 5e-7 /* six digits */
#define OVERFLOWING {12487.4f, 0, 28289.1f, 0, 780514, 0, 0, 1645020, 0, -1.12088e-10f, 9.67304e18f}
#else
#define STEADY KQ_STEADY_F64
#define SETTLING KQ_FREEZE_F64
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
HISTORY(tape, N, M, RUN, 0);
STEADY(steady, N, M);
SETTLING(lazy, N, M);

/* never initialised, and of other sizes */
PROCESS(blank_process, N, 1);
SENSOR(blank_sensor, N, M);
FILTER(blank, N);
STEADY(blank_steady, N, M);
SETTLING(blank_lazy, N, M);
PROCESS(motion1, 1, 0);
SENSOR(radar1, 1, 1);
SENSOR(single, N, 1);
FILTER(track1, 1);
SETTLING(lazy1, 1, 1);

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
    ASSERT_OK(K(sensor_init)(&single, H, R));
    ASSERT_OK(K(process_init)(&motion1, one, NULL, one));
    ASSERT_OK(K(sensor_init)(&radar1, one, one));
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    make_gains();
    ASSERT_OK(K(filter_init)(&other, x0, P0));
    ASSERT_OK(K(filter_init)(&track1, one, one));
    ASSERT_OK(K(steady_assign)(&steady, N, M, steady_memory, COUNT(steady_memory)));
    ASSERT_OK(K(steady_init)(&steady, &motion, &radar, x0, gains, GAINS));
    ASSERT_OK(K(freeze_assign)(&lazy, N, M, lazy_memory, COUNT(lazy_memory), lazy_gain));
    ASSERT_OK(K(freeze_init)(&lazy, 12));
    ASSERT_OK(K(freeze_init)(&lazy1, 12));
    ASSERT_OK(K(attach)(&track, &lazy.attached));
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

static void the_covariances_are_those_known(void)
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
static void the_filter_leads_to_it(void)
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
static void the_smoothers_gain_is_that_of_the_textbook(void)
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
static void a_random_walk_has_a_formula(void)
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

static void an_unstable_state_that_is_measured_is_no_obstacle(void)
{
    static const num a[] = {2}, q[] = {1};
    ASSERT_OK(solve_of(1, 1, a, one, q, one));
    ASSERT_CLOSE(2 + sqrt(5.0), P[0], 5); /* P = 4 P / (P + 1) + 1 */
}

static void noise_free_components_are_taken(void)
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

static void states_that_decay_need_neither_sensor_nor_noise(void)
{
    static const num a[] = {0.5, 0, 0, 0.875}, h[] = {0, 1}, q[] = {3, 0, 0, 0}, r[] = {1};
    ASSERT_OK(solve_of(2, 1, a, h, q, r));
    ASSERT_CLOSE(4, P[0], 4);
    ASSERT_WITHIN(0, 0, P[3]);
    ASSERT_WITHIN(0, 0, K[0]);
    ASSERT_WITHIN(0, 0, K[1]);
}

static void a_lasting_state_must_be_moved_and_measured(void)
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

static void the_largest_sizes(void)
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
static void nothing_is_read_of_memory_that_nobody_wrote(void)
{
    static const num model[] = OVERFLOWING;
    num memory[SOLVE_LEN(2, 1)];
    const kq_status status = solve_in(memory, 2, 1, model, model + 8, model + 4, model + 10);
    TEST_ASSERT_TRUE(status == KQ_ERR_NO_CONVERGENCE || status == KQ_ERR_NOT_DETECTABLE);
}

static void solve_gives_what_it_is_asked_for(void)
{
    K(steady_solution) some = {NULL, NULL, K, NULL};
    ASSERT_OK(K(steady_solve)(&motion, &radar, work, COUNT(work), &some));
    some = (K(steady_solution)){NULL, NULL, NULL, NULL};
    ASSERT_OK(K(steady_solve)(&motion, &radar, work, COUNT(work), &some));
}

static void solve_refuses_what_is_wrong(void)
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

static void the_gains_lead_to_the_steady_one(void)
{
    ASSERT_OK(solve()); /* |rho| is below 0.7 */
    for (int k = 0; k < N * M; k++) {
        ASSERT_WITHIN(0x1p-12 / (1 - 0.5), K[k], gains[(GAINS - 1) * N * M + k]);
    }
}

/* ------------------------------------------------------------------ the filter */

/* The mean is that of the full filter, up to the gain that has settled to 2^-12 and to rounding */
static void the_scheduled_filter_is_the_full_one(void)
{
    for (int t = 0; t < RUN; t++) {
        draw_step();
        if (t > 0) {
            ASSERT_OK(K(predict)(&track, &motion, u));
            ASSERT_OK(K(steady_predict)(&steady, u));
        }
        ASSERT_OK(K(update)(&track, &radar, z));
        ASSERT_OK(K(steady_update)(&steady, z));
        const double gain_left = t < GAINS ? 0 : 0x1p-12 / (1 - 0.7);
        for (int i = 0; i < N; i++) {
            ASSERT_WITHIN(6 * gain_left + 256 * EPS, whole_mean(&track, i),
                          K(steady_mean)(&steady, i));
        }
    }
}

static void a_step_is_a_predict_and_an_update(void)
{
    static num memory[N];
    static K(steady) second;
    ASSERT_OK(K(steady_assign)(&second, N, M, memory, N));
    ASSERT_OK(K(steady_init)(&second, &motion, &radar, x0, gains, GAINS));
    for (int t = 0; t < RUN; t++) {
        draw_step();
        const num *const drive_of = t % 2 ? u : NULL;
        ASSERT_OK(K(steady_step)(&steady, drive_of, z));
        ASSERT_OK(K(steady_predict)(&second, drive_of));
        ASSERT_OK(K(steady_update)(&second, z));
        ASSERT_SAME_BITS(steady_memory, memory);
    }
}

static void one_gain_is_the_steady_filter(void)
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

static void the_innovation_is_that_of_the_mean(void)
{
    num e[M], same[M];
    draw_step();
    WATCH(steady), WATCH(steady_memory), WATCH(z);
    ASSERT_OK_UNCHANGED(K(steady_innovation)(&steady, z, e));
    for (int c = 0; c < M; c++) ASSERT_CLOSE(z[c] - x0[c], e[c], 4);
    memcpy(same, z, sizeof z);
    ASSERT_OK(K(steady_innovation)(&steady, same, same));
    ASSERT_SAME_BITS(e, same);
}

static void what_is_read_of_nothing_is_no_number(void)
{
    ASSERT_NAN(K(steady_mean)(NULL, 0));
    ASSERT_NAN(K(steady_mean)(&blank_steady, 0));
    ASSERT_NAN(K(steady_mean)(&steady, -1));
    ASSERT_NAN(K(steady_mean)(&steady, N));
}

static void the_filter_refuses_what_is_wrong(void)
{
    num e[M] = {0};
    draw_step();
    WATCH(steady), WATCH(steady_memory), WATCH(blank_steady), WATCH(blank_steady_memory);
    WATCH(e), WATCH(z), WATCH(u);
    ASSERT_REFUSED(KQ_ERR_NULL, K(steady_predict)(NULL, u));
    ASSERT_REFUSED(KQ_ERR_NULL, K(steady_update)(NULL, z));
    ASSERT_REFUSED(KQ_ERR_NULL, K(steady_update)(&steady, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, K(steady_step)(NULL, u, z));
    ASSERT_REFUSED(KQ_ERR_NULL, K(steady_step)(&steady, u, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, K(steady_innovation)(&steady, z, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, K(steady_innovation)(&steady, NULL, e));
    ASSERT_REFUSED(KQ_ERR_NULL, K(steady_innovation)(NULL, z, e));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(steady_predict)(&blank_steady, u));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(steady_update)(&blank_steady, z));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(steady_step)(&blank_steady, u, z));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(steady_innovation)(&blank_steady, z, e));
    ASSERT_REFUSED(KQ_ERR_NULL, K(steady_init)(NULL, &motion, &radar, x0, gains, 1));
    ASSERT_REFUSED(KQ_ERR_NULL, K(steady_init)(&steady, NULL, &radar, x0, gains, 1));
    ASSERT_REFUSED(KQ_ERR_NULL, K(steady_init)(&steady, &motion, NULL, x0, gains, 1));
    ASSERT_REFUSED(KQ_ERR_NULL, K(steady_init)(&steady, &motion, &radar, NULL, gains, 1));
    ASSERT_REFUSED(KQ_ERR_NULL, K(steady_init)(&steady, &motion, &radar, x0, NULL, 1));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(steady_init)(&steady, &motion, &radar, x0, gains, 0));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(steady_init)(&steady, &motion, &radar, x0, gains, KQ_COUNT_MAX + 1));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(steady_init)(&steady, &motion, &radar, x0, gains, SIZE_MAX));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(steady_init)(&steady, &blank_process, &radar, x0, gains, 1));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(steady_init)(&steady, &motion, &blank_sensor, x0, gains, 1));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(steady_init)(&steady, &motion1, &radar, x0, gains, 1));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(steady_init)(&steady, &motion, &radar1, x0, gains, 1));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(steady_init)(&steady, &motion, &single, x0, gains, 1));
    ASSERT_REFUSED(KQ_ERR_NULL, K(steady_assign)(NULL, N, M, steady_memory, N));
    ASSERT_REFUSED(KQ_ERR_NULL, K(steady_assign)(&steady, N, M, NULL, N));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(steady_assign)(&steady, 0, M, steady_memory, N));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(steady_assign)(&steady, N, 17, steady_memory, N));
    ASSERT_REFUSED(KQ_ERR_MEMORY, K(steady_assign)(&steady, N, M, steady_memory, N - 1));
    K(steady) empty;
    memset(&empty, 0, sizeof empty);
    ASSERT_REFUSED_SIZE_OR_MEMORY(K(steady_init)(&empty, &motion, &radar, x0, gains, 1));
}

static kq_status begin(void) { return K(steady_init)(&steady, &motion, &radar, x0, gains, GAINS); }

static kq_status step(void) { return K(steady_step)(&steady, u, z); }

static void numbers_must_be_finite(void)
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

/* One diverges: the step that would take its mean not representable is refused, as each after it, with all its
   forms; so is one whose unmeasured state is there already. */
static void a_mean_beyond_the_numbers_is_refused(void)
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

/* ------------------------------------------------------------------ settling */

static void freeze_steps(int count)
{
    for (int t = 0; t < count; t++) {
        draw_step();
        ASSERT_OK(K(step)(&track, &motion, u, &radar, z));
        ASSERT_OK(K(step)(&other, &motion, u, &radar, z));
    }
}

static void assert_near(double tolerance, int line)
{
    num p[N * N], q[N * N];
    ASSERT_OK(K(covariance)(&track, p));
    ASSERT_OK(K(covariance)(&other, q));
    for (int i = 0; i < N; i++) {
        assert_within(tolerance, whole_mean(&other, i), whole_mean(&track, i), (unsigned)line);
        assert_within(tolerance, (double)q[i * N + i], (double)p[i * N + i], (unsigned)line);
    }
}

#define ASSERT_NEAR(tolerance) assert_near(tolerance, __LINE__)

static void it_settles_and_stays_near_the_full_filter(void)
{
    int began = 0;
    for (int t = 0; t < RUN; t++) {
        freeze_steps(1);
        if (!K(freeze_is_active)(&lazy)) TEST_ASSERT_EQUAL_INT(0, began);
        else if (!began) began = t;
        ASSERT_NEAR(8 * 0x1p-12 / (1 - 0.5));
    }
    TEST_ASSERT_TRUE(began > 2 && began < 30);
}

/* Until it has settled it is the full filter, bit for bit. */
static void before_that_it_is_the_full_filter(void)
{
    while (!K(freeze_is_active)(&lazy)) {
        ASSERT_SAME_BITS(track_memory, other_memory);
        freeze_steps(1);
    }
}

static void the_root_rests_while_it_is_settled(void)
{
    freeze_steps(40);
    TEST_ASSERT_EQUAL_INT(1, K(freeze_is_active)(&lazy));
    watch(track_memory + FILTER_LEN(N) - KQ_TRIANGLE(N), KQ_TRIANGLE(N) * sizeof(num));
    WATCH(track.last), WATCH(track.run);
    draw_step();
    ASSERT_OK_UNCHANGED(K(step)(&track, &motion, u, &radar, z));
}

static void a_missing_measurement_unsettles_it(void)
{
    freeze_steps(40);
    for (int t = 0; t < 3; t++) {
        draw_step();
        ASSERT_OK(K(predict)(&track, &motion, u));
        ASSERT_OK(K(predict)(&other, &motion, u));
        TEST_ASSERT_EQUAL_INT(0, K(freeze_is_active)(&lazy));
        ASSERT_NEAR(8 * 0x1p-12 / (1 - 0.5));
    }
    freeze_steps(2);
    TEST_ASSERT_EQUAL_INT(0, K(freeze_is_active)(&lazy));
    ASSERT_NEAR(8 * 0x1p-12 / (1 - 0.5));
    freeze_steps(40);
    TEST_ASSERT_EQUAL_INT(1, K(freeze_is_active)(&lazy));
}

static void another_model_unsettles_it(void)
{
    static const num slow[] = {0.75, 0, 0, 0.5};
    freeze_steps(40);
    ASSERT_OK(K(process_change_transition)(&motion, slow));
    freeze_steps(1);
    TEST_ASSERT_EQUAL_INT(0, K(freeze_is_active)(&lazy));
    freeze_steps(40);
    TEST_ASSERT_EQUAL_INT(1, K(freeze_is_active)(&lazy));
    ASSERT_NEAR(8 * 0x1p-12 / (1 - 0.5));
    ASSERT_OK(K(sensor_change_measurement)(&radar, slow));
    freeze_steps(1);
    TEST_ASSERT_EQUAL_INT(0, K(freeze_is_active)(&lazy));
    freeze_steps(40);
    ASSERT_NEAR(8 * 0x1p-12 / (1 - 0.5));
}

/* Another Q in the same object, another A in the same array: the process says so (its fingerprint). */
static void new_numbers_of_the_process_unsettle_it(void)
{
    static const num noisy[] = {3, 0, 0, 3};
    freeze_steps(40);
    TEST_ASSERT_EQUAL_INT(1, K(freeze_is_active)(&lazy));
    ASSERT_OK(K(process_init)(&motion, A, B, noisy));
    freeze_steps(1);
    TEST_ASSERT_EQUAL_INT(0, K(freeze_is_active)(&lazy));
    freeze_steps(40);
    TEST_ASSERT_EQUAL_INT(1, K(freeze_is_active)(&lazy));
    ASSERT_NEAR(8 * 0x1p-12 / (1 - 0.5));
    A[0] = 0.75;
    ASSERT_OK(K(process_change_transition)(&motion, A));
    freeze_steps(1);
    TEST_ASSERT_EQUAL_INT(0, K(freeze_is_active)(&lazy));
    freeze_steps(40);
    TEST_ASSERT_EQUAL_INT(1, K(freeze_is_active)(&lazy));
    ASSERT_OK(K(process_init)(&motion, A, B, noisy)); /* as it was */
    freeze_steps(1);
    TEST_ASSERT_EQUAL_INT(1, K(freeze_is_active)(&lazy));
    ASSERT_NEAR(8 * 0x1p-12 / (1 - 0.5));
}

/* A sensor has no fingerprint: new numbers in the same object and array are to be told. */
static void new_numbers_of_the_sensor_are_told_by_a_release(void)
{
    static const num noisy[] = {5, 0, 0, 5};
    freeze_steps(40);
    ASSERT_OK(K(sensor_init)(&radar, H, noisy));
    freeze_steps(1);
    TEST_ASSERT_EQUAL_INT(1, K(freeze_is_active)(&lazy));
    ASSERT_OK(K(freeze_release)(&lazy));
    freeze_steps(1);
    TEST_ASSERT_EQUAL_INT(0, K(freeze_is_active)(&lazy));
    freeze_steps(60);
    TEST_ASSERT_EQUAL_INT(1, K(freeze_is_active)(&lazy));
    ASSERT_NEAR(8 * 0x1p-12 / (1 - 0.5));
}

static void the_full_filter_may_go_on_at_any_time(void)
{
    freeze_steps(40);
    draw_step();
    ASSERT_OK(K(update)(&track, &radar, z)); /* one more measurement at the same instant */
    ASSERT_OK(K(update)(&other, &radar, z));
    ASSERT_NEAR(8 * 0x1p-12 / (1 - 0.5));
    freeze_steps(1);
    TEST_ASSERT_EQUAL_INT(0, K(freeze_is_active)(&lazy));
    ASSERT_NEAR(8 * 0x1p-12 / (1 - 0.5));
    freeze_steps(40);
    TEST_ASSERT_EQUAL_INT(1, K(freeze_is_active)(&lazy));
    ASSERT_OK(K(freeze_release)(&lazy));
    freeze_steps(1);
    TEST_ASSERT_EQUAL_INT(0, K(freeze_is_active)(&lazy));
}

/* It gets every step; then the freeze begins anew. */
static void a_history_takes_its_place(void)
{
    freeze_steps(40);
    WATCH(tape);
    ASSERT_REFUSED(KQ_ERR_RECORDING, K(attach)(&track, &tape.attached));
    ASSERT_OK(K(detach)(&lazy.attached));
    ASSERT_OK(K(attach)(&track, &tape.attached));
    ASSERT_REFUSED(KQ_ERR_RECORDING, K(attach)(&track, &lazy.attached));
    freeze_steps(40);
    TEST_ASSERT_EQUAL_UINT(41, K(history_steps)(&tape));
    ASSERT_OK(K(smooth)(&tape));
    ASSERT_OK(K(detach)(&tape.attached));
    ASSERT_OK(K(attach)(&track, &lazy.attached));
    TEST_ASSERT_EQUAL_INT(0, K(freeze_is_active)(&lazy));
    freeze_steps(40);
    TEST_ASSERT_EQUAL_INT(1, K(freeze_is_active)(&lazy));
    ASSERT_NEAR(8 * 0x1p-12 / (1 - 0.5));
}

/* The last step before it settles is a step of the full filter, and so is a predict and an update. */
static void a_step_of_the_full_filter_is_a_predict_and_an_update(void)
{
    for (int t = 0; t < 4; t++) {
        draw_step();
        ASSERT_OK(K(step)(&track, &motion, u, &radar, z));
        ASSERT_OK(K(predict)(&other, &motion, u));
        ASSERT_OK(K(update)(&other, &radar, z));
        TEST_ASSERT_EQUAL_INT(0, K(freeze_is_active)(&lazy));
        ASSERT_SAME_BITS(other_memory, track_memory);
        TEST_ASSERT_TRUE(K(log_likelihood)(&other) == K(log_likelihood)(&track));
    }
    for (int t = 0; t < 40; t++) { /* called apart they are the full filter's, and it never settles */
        draw_step();
        ASSERT_OK(K(predict)(&track, &motion, u));
        ASSERT_OK(K(update)(&track, &radar, z));
        ASSERT_OK(K(step)(&other, &motion, u, &radar, z));
        TEST_ASSERT_EQUAL_INT(0, K(freeze_is_active)(&lazy));
        ASSERT_SAME_BITS(other_memory, track_memory);
    }
}

/* By kq_filter_copy or by assignment: the full filter, while its original stays settled. */
static void a_copied_filter_goes_on_by_itself(void)
{
    FILTER(copy, N);
    for (int assigned = 0; assigned < 2; assigned++) {
        freeze_steps(40);
        ASSERT_OK(K(filter_copy)(&other, &track));
        ASSERT_OK(K(filter_copy)(&copy, &track));
        if (assigned) {
            copy = track;
            copy.memory = copy_memory;
        }
        const K(freeze) before = lazy;
        for (int t = 0; t < 5; t++) {
            draw_step();
            if (t % 2) ASSERT_OK(K(step)(&copy, &motion, u, &radar, z));
            if (t % 2 == 0) ASSERT_OK(K(predict)(&copy, &motion, u));
            if (t % 2 == 0) ASSERT_OK(K(update)(&copy, &radar, z));
            ASSERT_OK(K(step)(&other, &motion, u, &radar, z));
            ASSERT_SAME_BITS(other_memory, copy_memory);
        }
        TEST_ASSERT_EQUAL_INT(before.phase, lazy.phase);
        TEST_ASSERT_EQUAL_PTR(before.process, lazy.process);
        TEST_ASSERT_EQUAL_HEX32(before.fingerprint, lazy.fingerprint);
        TEST_ASSERT_EQUAL_PTR(before.filter, lazy.filter);
        freeze_steps(1);
        TEST_ASSERT_EQUAL_INT(1, K(freeze_is_active)(&lazy));
    }
}

static void a_detached_filter_is_the_full_filter(void)
{
    freeze_steps(40);
    ASSERT_OK(K(detach)(&lazy.attached));
    ASSERT_OK(K(detach)(&lazy.attached));
    ASSERT_OK(K(filter_copy)(&other, &track));
    for (int t = 0; t < 5; t++) {
        freeze_steps(1);
        ASSERT_SAME_BITS(other_memory, track_memory);
    }
    /* one that was initialised anew, too: nothing is looked at that may be gone */
    ASSERT_OK(K(attach)(&track, &lazy.attached));
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    ASSERT_OK(K(filter_init)(&other, x0, P0));
    const K(freeze) kept = lazy;
    memset(&lazy, 0xa5, sizeof lazy);
    freeze_steps(5);
    ASSERT_SAME_BITS(other_memory, track_memory);
    lazy = kept;
    /* and where the freeze was assigned anew */
    ASSERT_OK(K(attach)(&track, &lazy.attached));
    ASSERT_OK(
        K(freeze_assign)(&lazy, N, M, lazy_memory, (size_t)COUNT(lazy_memory), lazy_gain));
    freeze_steps(40);
    ASSERT_SAME_BITS(other_memory, track_memory);
}

/* It has a filter until it is detached or assigned anew; f may have been initialised meanwhile. */
static void a_settling_has_one_filter(void)
{
    WATCH(lazy), WATCH(lazy_memory), WATCH(other);
    freeze_steps(40);
    ASSERT_REFUSED(KQ_ERR_RECORDING, K(attach)(&other, &lazy.attached));
    TEST_ASSERT_EQUAL_INT(1, K(freeze_is_active)(&lazy));
    ASSERT_OK(K(attach)(&track, &lazy.attached)); /* to its own once more: it begins again */
    TEST_ASSERT_EQUAL_INT(0, K(freeze_is_active)(&lazy));
    ASSERT_OK(K(filter_init)(&track, x0, P0));
    ASSERT_REFUSED(KQ_ERR_RECORDING, K(attach)(&other, &lazy.attached));
    ASSERT_OK(K(attach)(&track, &lazy.attached));
    ASSERT_OK(K(detach)(&lazy.attached));
    ASSERT_OK(K(attach)(&other, &lazy.attached));
    ASSERT_OK(K(freeze_assign)(&lazy, N, M, lazy_memory, COUNT(lazy_memory), lazy_gain));
    ASSERT_OK(K(freeze_init)(&lazy, 12));
    ASSERT_OK(K(attach)(&track, &lazy.attached));
}

static void attach_refuses_what_is_wrong(void)
{
    SETTLING(second, N, M);
    START(start, N, 0);
    ASSERT_OK(K(freeze_init)(&second, 12));
    WATCH(lazy), WATCH(lazy_memory), WATCH(lazy_gain), WATCH(track), WATCH(track_memory);
    WATCH(blank_lazy), WATCH(lazy1), WATCH(second), WATCH(other), WATCH(blank), WATCH(track1);
    ASSERT_REFUSED(KQ_ERR_NULL, K(attach)(&track, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, K(attach)(NULL, &lazy.attached));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(attach)(&track, &blank_lazy.attached));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(attach)(&blank, &lazy.attached));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(attach)(&track1, &lazy.attached));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(attach)(&other, &lazy1.attached));
    ASSERT_REFUSED(KQ_ERR_RECORDING, K(attach)(&track, &second.attached));
    ASSERT_REFUSED(KQ_ERR_NULL, K(detach)(NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(detach)(&blank_lazy.attached));
    ASSERT_OK(K(diffuse_init)(&start, &other, x0, P0, 1));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(attach)(&other, &second.attached));
    ASSERT_OK(K(diffuse_init)(&start, &other, x0, P0, 0));
    ASSERT_OK(K(attach)(&other, &second.attached)); /* nothing was unknown */
}

static void assert_steps_are_refused(void)
{
    ASSERT_REFUSED(KQ_ERR_NULL, K(step)(NULL, &motion, u, &radar, z));
    ASSERT_REFUSED(KQ_ERR_NULL, K(step)(&track, NULL, u, &radar, z));
    ASSERT_REFUSED(KQ_ERR_NULL, K(step)(&track, &motion, u, NULL, z));
    ASSERT_REFUSED(KQ_ERR_NULL, K(step)(&track, &motion, u, &radar, NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(step)(&blank, &motion, u, &radar, z));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(step)(&track, &blank_process, u, &radar, z));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(step)(&track, &motion, u, &blank_sensor, z));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(step)(&track1, &motion, u, &radar, z));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(step)(&track, &motion1, NULL, &radar, z));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(step)(&track, &motion, u, &radar1, z));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(step)(&track, &motion, u, &single, z));
    ASSERT_REFUSED(KQ_ERR_NULL, K(predict)(NULL, &motion, u));
    ASSERT_REFUSED(KQ_ERR_NULL, K(predict)(&track, NULL, u));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(predict)(&track, &blank_process, u));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, K(predict)(&track, &motion1, NULL));
    const num good_z = z[0], good_u = u[0];
    z[0] = (num)NAN;
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(step)(&track, &motion, u, &radar, z));
    z[0] = good_z;
    u[0] = (num)NAN;
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(step)(&track, &motion, u, &radar, z));
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, K(predict)(&track, &motion, u));
    u[0] = good_u;
}

/* Nor does it leave what it has settled to. */
static void a_bad_step_is_refused(void)
{
    draw_step();
    WATCH(lazy), WATCH(lazy_memory), WATCH(lazy_gain), WATCH(track), WATCH(track_memory);
    WATCH(blank), WATCH(track1);
    assert_steps_are_refused();
    freeze_steps(40);
    TEST_ASSERT_EQUAL_INT(1, K(freeze_is_active)(&lazy));
    assert_steps_are_refused();
    freeze_steps(1);
    TEST_ASSERT_EQUAL_INT(1, K(freeze_is_active)(&lazy));
}

static void the_settling_refuses_what_is_wrong(void)
{
    num gain[N * M];
    WATCH(lazy), WATCH(lazy_memory), WATCH(lazy_gain), WATCH(track), WATCH(track_memory);
    WATCH(blank_lazy);
    ASSERT_REFUSED(KQ_ERR_NULL, K(freeze_init)(NULL, 12));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(freeze_init)(&lazy, 0));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(freeze_init)(&lazy, BITS_MAX + 1));
    ASSERT_REFUSED(KQ_ERR_NULL, K(freeze_release)(NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, K(freeze_release)(&blank_lazy));
    ASSERT_REFUSED(KQ_ERR_NULL, K(freeze_assign)(NULL, N, M, lazy_memory, 3, gain));
    ASSERT_REFUSED(KQ_ERR_NULL, K(freeze_assign)(&lazy, N, M, NULL, 3, gain));
    ASSERT_REFUSED(KQ_ERR_NULL, K(freeze_assign)(&lazy, N, M, lazy_memory, 3, NULL));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(freeze_assign)(&lazy, 17, M, lazy_memory, 3, gain));
    ASSERT_REFUSED(KQ_ERR_SIZE, K(freeze_assign)(&lazy, N, 0, lazy_memory, 3, gain));
    ASSERT_REFUSED(KQ_ERR_MEMORY,
                   K(freeze_assign)(&lazy, N, M, lazy_memory, FREEZE_LEN(N) - 1, gain));
    K(freeze) empty;
    memset(&empty, 0, sizeof empty);
    ASSERT_REFUSED_SIZE_OR_MEMORY(K(freeze_init)(&empty, 12));
    TEST_ASSERT_EQUAL_INT(0, K(freeze_is_active)(NULL));
    TEST_ASSERT_EQUAL_INT(0, K(freeze_is_active)(&blank_lazy));
}

SUITE(steady, set_up)
{
    RUN_TEST(the_covariances_are_those_known);
    RUN_TEST(the_filter_leads_to_it);
    RUN_TEST(the_smoothers_gain_is_that_of_the_textbook);
    RUN_TEST(a_random_walk_has_a_formula);
    RUN_TEST(an_unstable_state_that_is_measured_is_no_obstacle);
    RUN_TEST(noise_free_components_are_taken);
    RUN_TEST(states_that_decay_need_neither_sensor_nor_noise);
    RUN_TEST(a_lasting_state_must_be_moved_and_measured);
    RUN_TEST(the_largest_sizes);
    RUN_TEST(nothing_is_read_of_memory_that_nobody_wrote);
    RUN_TEST(solve_gives_what_it_is_asked_for);
    RUN_TEST(solve_refuses_what_is_wrong);
    RUN_TEST(the_scheduled_filter_is_the_full_one);
    RUN_TEST(the_gains_lead_to_the_steady_one);
    RUN_TEST(a_step_is_a_predict_and_an_update);
    RUN_TEST(one_gain_is_the_steady_filter);
    RUN_TEST(the_innovation_is_that_of_the_mean);
    RUN_TEST(what_is_read_of_nothing_is_no_number);
    RUN_TEST(the_filter_refuses_what_is_wrong);
    RUN_TEST(numbers_must_be_finite);
    RUN_TEST(a_mean_beyond_the_numbers_is_refused);
    RUN_TEST(it_settles_and_stays_near_the_full_filter);
    RUN_TEST(before_that_it_is_the_full_filter);
    RUN_TEST(the_root_rests_while_it_is_settled);
    RUN_TEST(a_missing_measurement_unsettles_it);
    RUN_TEST(another_model_unsettles_it);
    RUN_TEST(new_numbers_of_the_process_unsettle_it);
    RUN_TEST(new_numbers_of_the_sensor_are_told_by_a_release);
    RUN_TEST(the_full_filter_may_go_on_at_any_time);
    RUN_TEST(a_history_takes_its_place);
    RUN_TEST(a_step_of_the_full_filter_is_a_predict_and_an_update);
    RUN_TEST(a_copied_filter_goes_on_by_itself);
    RUN_TEST(a_detached_filter_is_the_full_filter);
    RUN_TEST(a_settling_has_one_filter);
    RUN_TEST(attach_refuses_what_is_wrong);
    RUN_TEST(a_bad_step_is_refused);
    RUN_TEST(the_settling_refuses_what_is_wrong);
}
