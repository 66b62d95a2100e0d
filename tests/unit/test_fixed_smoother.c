/* The smoother's step for compile-time sizes: the bits of kq_smooth_step, and what it hands on to it. */
#include <string.h>

#if defined(KQ_TEST_F32)
#include "fixed_size/kq_fixed_f32.h"
#define K(name) kq_##name##_f32
#define STEP_LEN KQ_PRIVATE_HISTORY_STEP_LEN_F32
#elif defined(KQ_TEST_F64)
#include "fixed_size/kq_fixed_f64.h"
#define K(name) kq_##name##_f64
#define STEP_LEN KQ_PRIVATE_HISTORY_STEP_LEN_F64
#else
#include "fixed_size/kq_fixed_q31.h"
#include "kalmanq/prepare.h"
#define K(name) kq_##name##_q31
#define STEP_LEN KQ_PRIVATE_HISTORY_STEP_LEN_Q31
#endif

#include "suite.h"

enum { MOST = 6, STEPS = 9, COMPONENTS = 2 };

#define ASSERT_OK(call) TEST_ASSERT_EQUAL_INT(KQ_OK, call)

/* ------------------------------------------------------------------ models */

/* What is left of its diagonal in A: nothing; everything; nothing, and no diagonal in half the rows */
enum { UPPER, DENSE, HOLES, SHAPES };

static double A_entry(int shape, int i, int j)
{
    if (shape == HOLES && i % 2 == 0) return j > i + 1 ? 0.5 : 0;
    if (i == j) return 0.9375;
    return j > i ? 0.25 / (j - i) : shape == DENSE ? -0.0625 * (i - j) : 0;
}

static double Q_entry(int i, int j) { return i == j ? 0.5 + 0.125 * i : 0.0625; }
static double H_entry(int c, int j) { return j == c ? 1 : j > c ? 0.25 * (j - c) : 0; }
static double z_of(int step, int c) { return (step * 7 + c * 5) % 11 - 4.5; }

#if defined(KQ_TEST_F32) || defined(KQ_TEST_F64)

typedef struct {
    num A[MOST * MOST], Q[MOST * MOST], memory[KQ_PROCESS_LEN(MOST)];
    process p;
} moving;

static num H[COMPONENTS * MOST], R[COMPONENTS], noise[COMPONENTS];
static sensor eye;

static void put_process(moving *m, int n, int shape)
{
    for (int k = 0; k < n * n; k++) {
        m->A[k] = (num)A_entry(shape, k / n, k % n);
        m->Q[k] = (num)Q_entry(k / n, k % n);
    }
    ASSERT_OK(K(process_assign)(&m->p, n, 0, m->memory, KQ_PROCESS_LEN(MOST)));
    ASSERT_OK(K(process_init)(&m->p, m->A, NULL, m->Q));
}

static int put_sensor(int n)
{
    const int m = n < COMPONENTS ? n : COMPONENTS;
    for (int k = 0; k < m * n; k++) H[k] = (num)H_entry(k / n, k % n);
    for (int c = 0; c < m; c++) R[c] = (num)0.5;
    ASSERT_OK(K(sensor_assign)(&eye, n, m, noise, COMPONENTS));
    ASSERT_OK(K(sensor_init_diagonal)(&eye, H, R));
    return m;
}

static void put_filter(filter *f, num *memory, int n)
{
    num x0[MOST], P0[MOST * MOST];
    for (int k = 0; k < n; k++) x0[k] = (num)k;
    for (int k = 0; k < n * n; k++) P0[k] = (num)(4 * Q_entry(k / n, k % n));
    ASSERT_OK(K(filter_assign)(f, n, memory, (size_t)FILTER_LEN(MOST)));
    ASSERT_OK(K(filter_init)(f, x0, P0));
}

static void put_measurement(num *z, int step, int m)
{
    for (int c = 0; c < m; c++) z[c] = (num)z_of(step, c);
}

#else

typedef struct {
    kq_scaled_q31 A[MOST * MOST];
    int32_t G[KQ_ROOT_LEN_Q31(MOST)];
    kq_process_table_q31 table;
    process p;
} moving;

static kq_format_q31 format[MOST], measured[COMPONENTS];
static kq_scaled_q31 H[COMPONENTS * MOST], R[KQ_TRIANGLE(COMPONENTS)];
static sensor eye;

static void put_process(moving *m, int n, int shape)
{
    double A[MOST * MOST], Q[MOST * MOST];
    for (int k = 0; k < n; k++) ASSERT_OK(kq_format_prepare_q31(&format[k], KQ_FRACTION_BEST_Q31, 100, NULL));
    for (int k = 0; k < n * n; k++) {
        A[k] = A_entry(shape, k / n, k % n);
        Q[k] = Q_entry(k / n, k % n);
    }
    ASSERT_OK(kq_matrix_prepare_q31(m->A, A, n, n, format, format));
    ASSERT_OK(kq_root_prepare_q31(m->G, Q, n, format));
    m->table = (kq_process_table_q31){
        .states = n, .state_format = format, .transition = m->A, .noise_root = m->G};
    ASSERT_OK(kq_process_init_q31(&m->p, &m->table, NULL));
}

static int put_sensor(int n)
{
    static kq_sensor_table_q31 table;
    double rows[COMPONENTS * MOST], covariance[COMPONENTS * COMPONENTS] = {0};
    const int m = n < COMPONENTS ? n : COMPONENTS;
    for (int k = 0; k < m * n; k++) rows[k] = H_entry(k / n, k % n);
    for (int c = 0; c < m; c++) {
        covariance[c * m + c] = 0.5;
        ASSERT_OK(kq_format_prepare_q31(&measured[c], KQ_FRACTION_BEST_Q31, 100, NULL));
    }
    ASSERT_OK(kq_matrix_prepare_q31(H, rows, m, n, measured, format));
    ASSERT_OK(kq_noise_prepare_q31(R, covariance, m, measured));
    table = (kq_sensor_table_q31){.states = n,
                                  .components = m,
                                  .correlated = 1,
                                  .state_format = format,
                                  .measurement_format = measured,
                                  .measurement = H,
                                  .noise = R};
    ASSERT_OK(kq_sensor_init_q31(&eye, &table, NULL));
    return m;
}

static void put_filter(filter *f, num *memory, int n)
{
    double x0[MOST], P0[MOST * MOST];
    int32_t mean[MOST], root[KQ_ROOT_LEN_Q31(MOST)];
    for (int k = 0; k < n; k++) x0[k] = k;
    for (int k = 0; k < n * n; k++) P0[k] = 4 * Q_entry(k / n, k % n);
    ASSERT_OK(kq_vector_prepare_q31(mean, x0, n, format, NULL));
    ASSERT_OK(kq_root_prepare_q31(root, P0, n, format));
    const kq_prior_table_q31 prior = {n, format, mean, root};
    ASSERT_OK(K(filter_assign)(f, n, memory, (size_t)FILTER_LEN(MOST)));
    ASSERT_OK(kq_filter_init_q31(f, &prior, NULL));
}

static void put_measurement(num *z, int step, int m)
{
    double values[COMPONENTS];
    for (int c = 0; c < m; c++) values[c] = z_of(step, c);
    ASSERT_OK(kq_vector_prepare_q31(z, values, m, measured, NULL));
}

#endif

/* ------------------------------------------------------------------ tapes */

enum { TAPE = 4096 };

static moving first, second;
static filter expected_filter, filter_now;
static num expected_state[512], state_now[512], expected_tape[TAPE], tape_now[TAPE];
static history expected, now;

static void record(history *h, num *tape, filter *f, num *state, int n, int m)
{
    num z[COMPONENTS];
    memset(tape, 0, TAPE * sizeof *tape);
    put_filter(f, state, n);
    ASSERT_OK(K(history_assign)(h, n, tape, TAPE));
    ASSERT_OK(K(attach)(f, &h->attached));
    for (int step = 0; step < STEPS; step++) {
        const process *p = step % 4 == 3 ? &second.p : &first.p;
        if (step) ASSERT_OK(K(predict)(f, p, NULL));
        put_measurement(z, step, m);
        if (step % 5 != 2) ASSERT_OK(K(update)(f, &eye, z));
        else ASSERT_OK(K(update_subset)(f, &eye, z, 1));
    }
}

/* Two tapes of one run */
static void put(int n, int shape, int other)
{
    put_process(&first, n, shape);
    put_process(&second, n, other);
    const int m = put_sensor(n);
    record(&expected, expected_tape, &expected_filter, expected_state, n, m);
    record(&now, tape_now, &filter_now, state_now, n, m);
}

/* All that the tapes hold but for the workspace, of which a step keeps a part only */
static void assert_same(int n)
{
    const size_t from = HISTORY_WORKSPACE_LEN(n);
    const size_t bytes = (TAPE - from) * sizeof(num);
    TEST_ASSERT_EQUAL_MEMORY(expected_tape + from, tape_now + from, bytes);
    TEST_ASSERT_EQUAL_UINT32(expected.step, now.step);
    TEST_ASSERT_EQUAL_UINT(expected.records, now.records);
    TEST_ASSERT_TRUE(expected.used == now.used && expected.process == now.process);
}

#define AT(n, call, options)                                                                       \
    case n: return call(h, p, extras, n, options);
#define AT_ANY(name, call, options)                                                                \
    static int name(history *h, const process *p, const smooth_extras *extras, int n)              \
    {                                                                                              \
        switch (n) {                                                                               \
            AT(1, call, options) AT(2, call, options) AT(3, call, options) AT(4, call, options)    \
            AT(5, call, options) AT(6, call, options)                                              \
        }                                                                                          \
        return -1;                                                                                 \
    }
AT_ANY(alone_upper, fixed_smooth_step, KQ_FIXED_UPPER)
AT_ANY(alone_dense, fixed_smooth_step, 0)

/* What is unrolled takes seconds to compile: beyond three states a step is alone's, handed on as the library does. */
#define AT_SMALL(name, alone, options)                                                             \
    static int name(history *h, const process *p, const smooth_extras *extras, int n)              \
    {                                                                                              \
        switch (n) {                                                                               \
            AT(1, K(fixed_smooth_step), options)                                                   \
            AT(2, K(fixed_smooth_step), options)                                                   \
            AT(3, K(fixed_smooth_step), options)                                                   \
        }                                                                                          \
        return alone(h, p, extras, n) == KQ_OK ? KQ_OK : (int)K(smooth_step)(h, p, extras);        \
    }
AT_SMALL(step_upper, alone_upper, KQ_FIXED_UPPER)
AT_SMALL(step_dense, alone_dense, 0)

typedef int step_function(history *h, const process *p, const smooth_extras *extras, int n);

static void same_bits(step_function *step, int n)
{
    for (int t = STEPS - 1; t >= 0; t--) {
        /* the process as recorded, or named */
        const process *p = t % 2 || t == STEPS - 1 ? NULL : (t + 1) % 4 == 3 ? &second.p : &first.p;
        ASSERT_OK(K(smooth_step)(&expected, p, NULL));
        ASSERT_OK(step(&now, p, NULL, n));
        assert_same(n);
    }
    const int done = K(smooth_step)(&expected, NULL, NULL);
    TEST_ASSERT_EQUAL_INT(done, step(&now, NULL, NULL, n));
    TEST_ASSERT_NOT_EQUAL(KQ_OK, done);
}

/* ------------------------------------------------------------------ tests */

TEST(test_the_bits_are_those_of_run_time_sizes)
{
    for (int n = 1; n <= MOST; n++) {
        for (int shape = 0; shape < SHAPES * SHAPES; shape++) {
            put(n, shape / SHAPES, shape % SHAPES);
            same_bits(step_upper, n);
            put(n, shape / SHAPES, shape % SHAPES);
            same_bits(step_dense, n);
        }
    }
}

TEST(test_an_ordinary_step_is_not_handed_on)
{
    for (int n = 1; n <= MOST; n++) {
        put(n, UPPER, HOLES);
        ASSERT_OK(K(smooth_step)(&now, NULL, NULL)); /* the beginning */
        for (int t = STEPS - 2; t >= 0; t--) ASSERT_OK(alone_upper(&now, NULL, NULL, n));
        put(n, DENSE, UPPER);
        ASSERT_OK(K(smooth_step)(&now, NULL, NULL));
        for (int t = STEPS - 2; t >= 0; t--) ASSERT_OK(alone_dense(&now, NULL, NULL, n));
    }
}

/* The answer is NOT_PLAIN, and nothing has changed. */
static void handed_on(step_function *step, const process *p, const smooth_extras *extras, int n)
{
    TEST_ASSERT_EQUAL_INT(NOT_PLAIN, step(&now, p, extras, n));
    TEST_ASSERT_EQUAL_MEMORY(expected_tape, tape_now, sizeof tape_now);
    assert_same(now.states);
}

TEST(test_what_is_not_ordinary_is_handed_on_untouched)
{
    static const smooth_extras extras;
    static process blank;
    put(3, DENSE, DENSE);
    handed_on(alone_dense, NULL, NULL, 3); /* the beginning */
    ASSERT_OK(K(smooth_step)(&expected, NULL, NULL));
    ASSERT_OK(K(smooth_step)(&now, NULL, NULL));
    handed_on(alone_dense, NULL, &extras, 3);
    handed_on(alone_dense, NULL, NULL, 2);
    handed_on(alone_upper, NULL, NULL, 3); /* A is dense */
    handed_on(alone_dense, &blank, NULL, 3);
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NOT_READY, step_dense(&now, &blank, NULL, 3));
    handed_on(alone_dense, &blank, NULL, 3);
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, step_dense(NULL, NULL, NULL, 3));
    while (now.step > 0) ASSERT_OK(K(smooth_step)(&now, NULL, NULL));
    TEST_ASSERT_EQUAL_INT(NOT_PLAIN, alone_dense(&now, NULL, NULL, 3));
}

SUITE(fixed_smoother, NULL)
#include "fixed_smoother.tests"
