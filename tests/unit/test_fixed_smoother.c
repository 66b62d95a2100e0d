/* The smoother's step for compile-time sizes: the bits of kq_smooth_step, and what it hands on to it. */
#define MAX 6
#include "fixed.h"

enum { STEPS = 9, COMPONENTS = 2 };

/* ------------------------------------------------------------------ models */

/* What is left of its diagonal in A: nothing; everything; nothing, and no diagonal in half the rows */
enum { UPPER, DENSE, HOLES, SHAPES };

static num A_entry(int shape, int i, int j)
{
    if (shape == HOLES && i % 2 == 0) return j > i + 1 ? N(0.5) : 0;
    if (i == j) return N(0.9375);
    return j > i ? N(0.25) / N(j - i) : shape == DENSE ? N(-0.0625) * N(i - j) : 0;
}

static num Q_entry(int i, int j) { return i == j ? N(0.5 + 0.125 * i) : N(0.0625); }
static num z_of(int step, int c) { return N((step * 7 + c * 5) % 11 - 4.5); }

static process_model first, second;
static sensor_model eye;
static prior_model prior;
static const num range[] = {100, 100, 100, 100, 100, 100};

static void put_moving(process_model *m, int n, int shape)
{
    static num A[2][MAX * MAX], Q[MAX * MAX];
    num *a = A[m == &second];
    for (int k = 0; k < n * n; k++) a[k] = A_entry(shape, k / n, k % n), Q[k] = Q_entry(k / n, k % n);
    put_process(m, n, 0, range, NULL, a, NULL, Q);
}

static void put_eye(int n, int m)
{
    static const num r[] = {0.5, 0.5};
    static num H[COMPONENTS * MAX];
    for (int k = 0; k < m * n; k++) {
        const int c = k / n, j = k % n;
        H[k] = j == c ? 1 : j > c ? N(0.25) * N(j - c) : 0;
    }
    put_independent(&eye, n, m, range, range, H, r);
}

static void put_start(int n)
{
    static num x0[MAX], P0[MAX * MAX];
    for (int k = 0; k < n; k++) x0[k] = N(k);
    for (int k = 0; k < n * n; k++) P0[k] = 4 * Q_entry(k / n, k % n);
    put_prior(&prior, n, range, x0, P0);
}

/* ------------------------------------------------------------------ tapes */

enum { TAPE = 4096 };

/* A filter and what it is recorded on */
typedef struct {
    S(filter) filter;
    S(history) history;
    word state[S_FILTER_LEN(MAX)], tape[TAPE];
} recording;

static recording expected, now;

static void record(recording *r, int n)
{
    memset(r->tape, 0, sizeof r->tape);
    ASSERT_OK(S(filter_assign)(&r->filter, n, r->state, COUNT(r->state)));
    ASSERT_OK(init_filter(&r->filter, &prior));
    ASSERT_OK(S(history_assign)(&r->history, n, r->tape, TAPE));
    ASSERT_OK(S(attach)(&r->filter, &r->history.attached));
    for (int step = 0; step < STEPS; step++) {
        const num values[] = {z_of(step, 0), z_of(step, 1)};
        const word *z = measured(&eye.sensor, values);
        if (step) ASSERT_OK(S(predict)(&r->filter, step % 4 == 3 ? &second.process : &first.process, NULL));
        if (step % 5 != 2) ASSERT_OK(S(update)(&r->filter, &eye.sensor, z));
        else ASSERT_OK(S(update_subset)(&r->filter, &eye.sensor, z, 1));
    }
}

/* Two tapes of one run */
static void put(int n, int shape, int other)
{
    put_moving(&first, n, shape);
    put_moving(&second, n, other);
    put_eye(n, n < COMPONENTS ? n : COMPONENTS);
    put_start(n);
    record(&expected, n);
    record(&now, n);
}

/* All that the tapes hold but for the workspace, of which a step keeps a part only */
static void assert_same(int n)
{
    const size_t from = HISTORY_WORKSPACE_LEN(n);
    TEST_ASSERT_EQUAL_MEMORY(expected.tape + from, now.tape + from, (TAPE - from) * sizeof(word));
    TEST_ASSERT_EQUAL_UINT32(expected.history.step, now.history.step);
    TEST_ASSERT_EQUAL_UINT(expected.history.records, now.history.records);
    TEST_ASSERT_TRUE(expected.history.used == now.history.used && expected.history.process == now.history.process);
}

#define AT(n, call, options)                                                                       \
    case n: return call(h, p, extras, n, options);
#define AT_ANY(name, call, options)                                                                \
    static int name(S(history) *h, const S(process) *p, const S(smooth_extras) *extras, int n)     \
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
    static int name(S(history) *h, const S(process) *p, const S(smooth_extras) *extras, int n)     \
    {                                                                                              \
        switch (n) {                                                                               \
            AT(1, S(fixed_smooth_step), options)                                                   \
            AT(2, S(fixed_smooth_step), options)                                                   \
            AT(3, S(fixed_smooth_step), options)                                                   \
        }                                                                                          \
        return alone(h, p, extras, n) == KQ_OK ? KQ_OK : (int)S(smooth_step)(h, p, extras);        \
    }
AT_SMALL(step_upper, alone_upper, KQ_FIXED_UPPER)
AT_SMALL(step_dense, alone_dense, 0)

typedef int step_function(S(history) *h, const S(process) *p, const S(smooth_extras) *extras, int n);

static void same_bits(step_function *step, int n)
{
    for (int t = STEPS - 1; t >= 0; t--) {
        /* the process as recorded, or named */
        const S(process) *p = t % 2 || t == STEPS - 1 ? NULL : (t + 1) % 4 == 3 ? &second.process : &first.process;
        ASSERT_OK(S(smooth_step)(&expected.history, p, NULL));
        ASSERT_OK(step(&now.history, p, NULL, n));
        assert_same(n);
    }
    const int done = S(smooth_step)(&expected.history, NULL, NULL);
    TEST_ASSERT_EQUAL_INT(done, step(&now.history, NULL, NULL, n));
    TEST_ASSERT_NOT_EQUAL(KQ_OK, done);
}

/* ------------------------------------------------------------------ tests */

TEST(test_the_bits_are_those_of_run_time_sizes)
{
    for (int n = 1; n <= MAX; n++) {
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
    for (int n = 1; n <= MAX; n++) {
        put(n, UPPER, HOLES);
        ASSERT_OK(S(smooth_step)(&now.history, NULL, NULL)); /* the beginning */
        for (int t = STEPS - 2; t >= 0; t--) ASSERT_OK(alone_upper(&now.history, NULL, NULL, n));
        put(n, DENSE, UPPER);
        ASSERT_OK(S(smooth_step)(&now.history, NULL, NULL));
        for (int t = STEPS - 2; t >= 0; t--) ASSERT_OK(alone_dense(&now.history, NULL, NULL, n));
    }
}

/* The answer is NOT_PLAIN, and nothing has changed. */
static void handed_on(step_function *step, const S(process) *p, const S(smooth_extras) *extras, int n)
{
    TEST_ASSERT_EQUAL_INT(NOT_PLAIN, step(&now.history, p, extras, n));
    TEST_ASSERT_EQUAL_MEMORY(expected.tape, now.tape, sizeof now.tape);
    assert_same(now.history.states);
}

TEST(test_what_is_not_ordinary_is_handed_on_untouched)
{
    static const S(smooth_extras) extras;
    static S(process) blank;
    put(3, DENSE, DENSE);
    handed_on(alone_dense, NULL, NULL, 3); /* the beginning */
    ASSERT_OK(S(smooth_step)(&expected.history, NULL, NULL));
    ASSERT_OK(S(smooth_step)(&now.history, NULL, NULL));
    handed_on(alone_dense, NULL, &extras, 3);
    handed_on(alone_dense, NULL, NULL, 2);
    handed_on(alone_upper, NULL, NULL, 3); /* A is dense */
    handed_on(alone_dense, &blank, NULL, 3);
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NOT_READY, step_dense(&now.history, &blank, NULL, 3));
    handed_on(alone_dense, &blank, NULL, 3);
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, step_dense(NULL, NULL, NULL, 3));
    while (now.history.step > 0) ASSERT_OK(S(smooth_step)(&now.history, NULL, NULL));
    TEST_ASSERT_EQUAL_INT(NOT_PLAIN, alone_dense(&now.history, NULL, NULL, 3));
}

SUITE(fixed_smoother, NULL)
#include "fixed_smoother.tests"
