/*
 * One bit turned in a process, a sensor, a filter or their memory, each bit in turn: turned [seeds].
 * After 40 steps, between two calls, a bit is turned, and the three checks are called.  What they do not find
 * runs on for 50 steps beside a run without it.  Of each part:
 *   found        by a check
 *   answered     by the status of a step, or by an event
 *   harmless     mean within 0.1 sigma and sigma within 1 %, at each step
 *   forgotten    not at each step, but after 50
 *   likelihood   the same, but the log-likelihood of the run is off by more than 0.1
 *   misleads     wrong after 50 steps, and nothing says so
 *   crashes      or hangs
 * Compiled for an arithmetic by -DKQ_TURNED_F32, _F64 or _Q31, under the sanitizers, for the host alone.
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "kalmanq/kalmanq.h"
#include "kalmanq/prepare.h"

enum { N = 4, M = 2, L = 1, BEFORE = 40, STEPS = 50 };

#if defined(KQ_TURNED_Q31)
typedef int32_t num;
#define T(name) name##_q31
#define FILTER_LEN KQ_FILTER_LEN_Q31
#elif defined(KQ_TURNED_F64)
typedef double num;
#define T(name) name##_f64
#define FILTER_LEN KQ_FILTER_LEN_F64
#else
typedef float num;
#define T(name) name##_f32
#define FILTER_LEN KQ_FILTER_LEN_F32
#endif

/* ------------------------------------------------------------------ models and what is measured */

typedef struct {
    int n, m, l;
    double A[N * N], B[N * L], F[N * N]; /* Q = F F' */
    double H[M * N], R[M * M];
} model;

static const model models[] = {
    {2, 1, 0, {1, 0.1, 0, 1}, {0}, {0.005, 0.003, 0, 0.1}, {1, 0}, {0.04}},
    {4, 2, 0,
     {1, 0, 0.1, 0, 0, 1, 0, 0.1, 0, 0, 1, 0, 0, 0, 0, 1},
     {0},
     {0.005, 0, 0.003, 0, 0, 0.005, 0, 0.003, 0, 0, 0.1, 0, 0, 0, 0, 0.1},
     {1, 0, 0, 0, 0, 1, 0, 0},
     {0.04, 0, 0, 0.04}},
    {3, 2, 1,
     {0.9, 0.1, 0.05, -0.1, 0.95, 0.1, 0, -0.05, 0.8},
     {0.1, 0.2, 0.5},
     {0.1, 0, 0, 0.05, 0.1, 0, 0, 0.05, 0.2},
     {1, 0.5, 0, 0, 1, -1},
     {0.09, 0.03, 0.03, 0.04}},
};
enum { MODELS = sizeof models / sizeof models[0] };

static uint64_t state;

static double normal(void)
{
    double sum = -6;
    for (int k = 0; k < 12; k++) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        sum += (double)(state >> 11) * 0x1p-53;
    }
    return sum;
}

static double z_at[BEFORE + STEPS][M], u_at[BEFORE + STEPS][L];

static void measure(const model *p, uint64_t seed)
{
    double x[N] = {0};
    state = seed * 0x9E3779B97F4A7C15u;
    for (int t = 0; t < BEFORE + STEPS; t++) {
        double next[N], w[N], v[M];
        for (int i = 0; i < N; i++) w[i] = normal();
        for (int c = 0; c < M; c++) v[c] = normal();
        u_at[t][0] = normal();
        for (int i = 0; i < p->n; i++) {
            next[i] = p->l ? p->B[i] * u_at[t][0] : 0;
            for (int k = 0; k < p->n; k++) next[i] += p->A[i * p->n + k] * x[k] + p->F[i * p->n + k] * w[k];
        }
        memcpy(x, next, sizeof x);
        for (int c = 0; c < p->m; c++) {
            z_at[t][c] = sqrt(p->R[c * p->m + c]) * v[c];
            for (int k = 0; k < p->n; k++) z_at[t][c] += p->H[c * p->n + k] * x[k];
        }
    }
}

/* ------------------------------------------------------------------ the objects */

typedef struct {
    T(kq_process) process;
    T(kq_sensor) sensor;
    T(kq_filter) filter;
    num filter_memory[FILTER_LEN(N)];
#if defined(KQ_TURNED_Q31)
    kq_format_q31 x[N], z[M], u[L];
    kq_scaled_q31 A[N * N], B[N * L], H[M * N], noise[KQ_TRIANGLE(M)];
    num G[KQ_ROOT_LEN_Q31(N)];
#else
    num A[N * N], B[N * L], H[M * N], R[M * M];
    num G[KQ_PROCESS_LEN(N)], noise[KQ_SENSOR_LEN(M)];
#endif
} world;

static world now, kept;

static void need(kq_status status, const char *what)
{
    if (!status) return;
    fprintf(stderr, "turned: %s answers %d\n", what, status);
    exit(1);
}

static void square(double *Q, const double *F, int n)
{
    for (int k = 0; k < n * n; k++) {
        Q[k] = 0;
        for (int j = 0; j < n; j++) Q[k] += F[k / n * n + j] * F[k % n * n + j];
    }
}

#if defined(KQ_TURNED_Q31)

static double value(int i, double raw) { return ldexp(raw, -now.x[i].fraction); }
static double mean(int i)
{
    return value(i, kq_mean_q31(&now.filter, i) + kq_mean_low_q31(&now.filter, i) * 0x1p-24);
}
static double sigma(int i)
{
    kq_scaled_q31 P[N * N];
    need(kq_covariance_q31(&now.filter, P), "covariance");
    const kq_scaled_q31 p = P[i * (now.filter.states + 1)];
    return value(i, sqrt(ldexp(p.mantissa, p.exponent)));
}
static double likelihood(void) { return (double)kq_log_likelihood_q31(&now.filter) * 0x1p-24; }
static num measured(int t, int c) { return (num)lrint(ldexp(z_at[t][c], kept.z[c].fraction)); }
static num driven(int t) { return (num)lrint(ldexp(u_at[t][0], kept.u[0].fraction)); }

static void make(const model *p)
{
    static num x0[N], P0[KQ_ROOT_LEN_Q31(N)];
    double Q[N * N], I[N * N] = {0};
    const int n = p->n, m = p->m, is_correlated = p->R[1] != 0 && m > 1;
    square(Q, p->F, n);
    memset(&now, 0, sizeof now);
    const int best = KQ_FRACTION_BEST_Q31;
    for (int i = 0; i < n; i++) need(kq_format_prepare_q31(&now.x[i], best, 200, NULL), "format"), I[i * (n + 1)] = 1;
    for (int c = 0; c < m; c++) need(kq_format_prepare_q31(&now.z[c], best, 200, NULL), "format");
    need(kq_format_prepare_q31(&now.u[0], best, 20, NULL), "format");
    need(kq_matrix_prepare_q31(now.A, p->A, n, n, now.x, now.x), "A");
    if (p->l) need(kq_matrix_prepare_q31(now.B, p->B, n, p->l, now.x, now.u), "B");
    need(kq_matrix_prepare_q31(now.H, p->H, m, n, now.z, now.x), "H");
    need(kq_root_prepare_q31(now.G, Q, n, now.x), "Q");
    need(kq_root_prepare_q31(P0, I, n, now.x), "P0");
    if (is_correlated) need(kq_noise_prepare_q31(now.noise, p->R, m, now.z), "R");
    const double r[] = {p->R[0], p->R[m * m - 1]};
    if (!is_correlated) need(kq_noise_prepare_diagonal_q31(now.noise, r, m, now.z), "r");
    const kq_process_table_q31 moves = {n, p->l, now.x, now.u, now.A, now.B, now.G};
    const kq_sensor_table_q31 sees = {n, m, is_correlated, now.x, now.z, now.H, now.noise};
    const kq_prior_table_q31 prior = {n, now.x, x0, P0};
    need(kq_process_init_q31(&now.process, &moves, NULL), "process");
    need(kq_sensor_init_q31(&now.sensor, &sees, NULL), "sensor");
    need(kq_filter_assign_q31(&now.filter, n, now.filter_memory, FILTER_LEN((size_t)n)), "filter");
    need(kq_filter_init_q31(&now.filter, &prior, NULL), "filter");
}

#else

static double mean(int i) { return (double)T(kq_mean)(&now.filter, i) + (double)T(kq_mean_low)(&now.filter, i); }
static double sigma(int i) { return (double)T(kq_sigma)(&now.filter, i); }
static double likelihood(void) { return (double)T(kq_log_likelihood)(&now.filter); }
static num measured(int t, int c) { return (num)z_at[t][c]; }
static num driven(int t) { return (num)u_at[t][0]; }

static void make(const model *p)
{
    double Q[N * N];
    num q[N * N], I[N * N] = {0}, x0[N] = {0};
    const int n = p->n, m = p->m;
    square(Q, p->F, n);
    memset(&now, 0, sizeof now);
    for (int k = 0; k < n * n; k++) now.A[k] = (num)p->A[k], q[k] = (num)Q[k];
    for (int k = 0; k < n; k++) now.B[k] = (num)p->B[k], I[k * (n + 1)] = 1;
    for (int k = 0; k < m * n; k++) now.H[k] = (num)p->H[k];
    for (int k = 0; k < m * m; k++) now.R[k] = (num)p->R[k];
    need(T(kq_process_assign)(&now.process, n, p->l, now.G, (size_t)KQ_PROCESS_LEN(n)), "process");
    need(T(kq_process_init)(&now.process, now.A, now.B, q), "process");
    need(T(kq_sensor_assign)(&now.sensor, n, m, now.noise, (size_t)KQ_SENSOR_LEN(m)), "sensor");
    need(T(kq_sensor_init)(&now.sensor, now.H, now.R), "sensor");
    need(T(kq_filter_assign)(&now.filter, n, now.filter_memory, (size_t)FILTER_LEN(n)), "filter");
    need(T(kq_filter_init)(&now.filter, x0, I), "filter");
}

#endif

/* Answers whether a status was bad. */
static int step(const model *p, int t)
{
    num z[M], u[L] = {driven(t)};
    for (int c = 0; c < p->m; c++) z[c] = measured(t, c);
    const kq_status moved = T(kq_predict)(&now.filter, &now.process, p->l ? u : NULL);
    return (T(kq_update)(&now.filter, &now.sensor, z) != KQ_OK) | (moved != KQ_OK);
}

static int check(void)
{
    return T(kq_process_check)(&now.process) < 0 || T(kq_sensor_check)(&now.sensor) < 0 ||
           T(kq_filter_check)(&now.filter) < 0;
}

/* ------------------------------------------------------------------ the parts */

typedef struct {
    const char *name;
    size_t at, size; /* in the world */
    int is_checked;  /* nothing of it may mislead or crash */
} part;

enum { PARTS = 10 };

static size_t place(const void *p) { return (size_t)((const char *)p - (const char *)&now); }

static void parts_of(part *out, const model *p)
{
    const size_t n = (size_t)p->n, m = (size_t)p->m, word = sizeof(num);
    const size_t root = n * (n + 1) / 2 * word, all = (size_t)FILTER_LEN(p->n) * word;
    const int is_correlated = p->R[1] != 0 && m > 1;
    const size_t noises = is_correlated ? (size_t)KQ_TRIANGLE(m) : m;
#if defined(KQ_TURNED_Q31)
    const size_t exponents = n * word;
#else
    const size_t exponents = 0;
#endif
    const size_t mean_size = all - root - exponents, likelihood_at = offsetof(T(kq_filter), last);
    const part list[PARTS] = {
        {"process", place(&now.process), sizeof now.process, 1},
        {"process, G", place(now.G), root + exponents, 1},
        {"process, A", place(now.A), n * n * sizeof *now.A, 1},
        {"sensor", place(&now.sensor), sizeof now.sensor, 1},
        {"sensor, noise", place(now.noise), noises * sizeof *now.noise, 1},
        {"sensor, H", place(now.H), m * n * sizeof *now.H, 1},
        {"filter", place(&now.filter), likelihood_at, 1},
        {"filter, likelihood", place(&now.filter) + likelihood_at, sizeof now.filter - likelihood_at, 1},
        {"filter, mean", place(now.filter_memory), mean_size, 0},
        {"filter, root", place(now.filter_memory) + mean_size, root + exponents, 0},
    };
    memcpy(out, list, sizeof list);
}

/* ------------------------------------------------------------------ a bit and what comes of it */

enum { FOUND, ANSWERED, HARMLESS, FORGOTTEN, LIKELIHOOD, MISLEADS, CRASHES, CLASSES };

typedef struct {
    double mean[N], sigma[N];
} reading;

static reading twin[STEPS];
static double twin_likelihood;
static unsigned twin_events;

static void read_state(reading *r, int n)
{
    for (int i = 0; i < n; i++) r->mean[i] = mean(i), r->sigma[i] = sigma(i);
}

static int is_near(const reading *a, const reading *b, int n)
{
    for (int i = 0; i < n; i++) {
        if (!(fabs(a->mean[i] - b->mean[i]) <= 0.1 * b->sigma[i])) return 0;
        if (!(fabs(a->sigma[i] - b->sigma[i]) <= 0.01 * b->sigma[i])) return 0;
    }
    return 1;
}

static int class_of(const model *p)
{
    int far = 0, far_now = 0;
    if (check()) return FOUND;
    for (int t = 0; t < STEPS; t++) {
        reading r;
        if (step(p, BEFORE + t) || (T(kq_events)(&now.filter) & ~twin_events)) return ANSWERED;
        read_state(&r, p->n);
        far_now = !is_near(&r, &twin[t], p->n);
        far |= far_now;
    }
    if (far_now) return MISLEADS;
    if (!(fabs(likelihood() - twin_likelihood) <= 0.1) && !far) return LIKELIHOOD;
    return far ? FORGOTTEN : HARMLESS;
}

/* A child takes bits in turn until one crashes it; the classes are in memory that both see. */
static void turn_all(const model *p, const part *of, unsigned char *classes)
{
    const size_t bits = 8 * of->size;
    memset(classes, CLASSES, bits);
    for (size_t next = 0; next < bits; next++) {
        fflush(stdout);
        const pid_t child = fork();
        if (child < 0) need(KQ_ERR_SIZE, "fork");
        if (child == 0) {
            if (!freopen("/dev/null", "w", stderr)) _exit(1);
            for (size_t k = next; k < bits; k++) {
                memcpy(&now, &kept, sizeof now);
                ((unsigned char *)&now)[of->at + k / 8] ^= (unsigned char)(1u << k % 8);
                alarm(10);
                classes[k] = (unsigned char)class_of(p);
            }
            _exit(0);
        }
        if (waitpid(child, NULL, 0) != child) need(KQ_ERR_SIZE, "waitpid");
        while (next < bits && classes[next] != CLASSES) next++;
        if (next < bits) classes[next] = CRASHES;
    }
}

/* ------------------------------------------------------------------ the table */

static const char *const class_name[] = {"found", "answered", "harmless", "forgotten", "likelihood", "misleads", "crashes"};

static long tally[PARTS][CLASSES];

static void run(const model *p, uint64_t seed, unsigned char *classes)
{
    part parts[PARTS];
    measure(p, seed);
    make(p);
    for (int t = 0; t < BEFORE; t++) need(step(p, t) ? KQ_ERR_RANGE : KQ_OK, "a step");
    need(check() ? KQ_ERR_TABLE : KQ_OK, "a check of what is right"); /* and it keeps its seals */
    memcpy(&kept, &now, sizeof kept);
    for (int t = 0; t < STEPS; t++) {
        need(step(p, BEFORE + t) ? KQ_ERR_RANGE : KQ_OK, "a step");
        read_state(&twin[t], p->n);
    }
    twin_events = T(kq_events)(&now.filter);
    twin_likelihood = likelihood();
    parts_of(parts, p);
    for (int k = 0; k < PARTS; k++) {
        turn_all(p, &parts[k], classes);
        for (size_t bit = 0; bit < 8 * parts[k].size; bit++) tally[k][classes[bit]]++;
    }
}

/* Answers whether all that is checked is found where it does harm. */
static int report(const model *p)
{
    part parts[PARTS];
    int good = 1;
    parts_of(parts, p);
    printf("%-20s%8s", "of 100 bits of", "bits");
    for (int c = 0; c < CLASSES; c++) printf("%12s", class_name[c]);
    printf("\n");
    for (int k = 0; k < PARTS; k++) {
        long all = 0;
        for (int c = 0; c < CLASSES; c++) all += tally[k][c];
        printf("%-20s%8ld", parts[k].name, all);
        for (int c = 0; c < CLASSES; c++) printf("%12.1f", 100 * (double)tally[k][c] / (double)all);
        printf("\n");
        if (tally[k][CRASHES] || (parts[k].is_checked && tally[k][MISLEADS])) good = 0;
    }
    return good;
}

int main(int count, char **arguments)
{
    const int seeds = count > 1 ? atoi(arguments[1]) : 1;
    unsigned char *classes =
        mmap(NULL, 8 * sizeof(world), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (classes == MAP_FAILED) need(KQ_ERR_MEMORY, "mmap");
    for (int k = 0; k < MODELS; k++) {
        for (int seed = 1; seed <= seeds; seed++) run(&models[k], (uint64_t)seed, classes);
    }
    return report(&models[0]) ? 0 : 1;
}
