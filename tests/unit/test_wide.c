/*
 * Sixteen states: independent scalars y = T x, driven and seen through the rotation T, are what each of them is alone by
 * the formulas of one state: the filter, the smoother and both smoothers on line, in all arithmetics, between guards.
 */
#define MAX 16

#include "models.h"
#include "sizes.h"

enum { STEPS = 5, LAST = STEPS - 1, KEPT = 3 };

static process_model motion;
static sensor_model sensor;
static prior_model prior;
S_FILTER(wide, 16);
static S(lag) lag;
static S(instant) instant;
static S(history) tape;

enum { GUARD = 4, TAPE = S_HISTORY_LEN(16, 16, STEPS, 0), LAG_WORDS = S_LAG_LEN(16, 16, KEPT) };

static word room[(TAPE > LAG_WORDS ? TAPE : LAG_WORDS) + 2 * GUARD];

static word *guarded(void) { return guarded_in(room, sizeof room, GUARD * sizeof(word)); }

static void assert_guarded(kq_length length)
{
    assert_guard_bytes(room, sizeof room, GUARD * sizeof(word), (size_t)length * sizeof(word));
}

static void attach_lag(void)
{
    ASSERT_OK(S(lag_assign)(&lag, 16, 16, KEPT, guarded(), LAG_WORDS));
    ASSERT_OK(S(attach)(&wide, &lag.attached));
}

/* One of them: its mean and variance at each step, filtered, predicted, smoothed */
typedef struct {
    double a, q, p, r, drive;
    double filtered[STEPS], predicted[STEPS], mean[STEPS], variance[STEPS], before[STEPS];
} scalar;

static scalar y[16];

static double z_of(int i, int step) { return (i * 5 + step * 3) % 11 - 5; }

static void filter_scalar(scalar *s, int i)
{
    double x = 0, p = s->p;
    for (int t = 0; t < STEPS; t++) {
        s->predicted[t] = x, s->before[t] = p;
        x += p / (p + s->r) * (z_of(i, t) - x);
        p *= s->r / (p + s->r);
        s->filtered[t] = s->mean[t] = x, s->variance[t] = p;
        x = s->a * x + s->drive, p = s->a * s->a * p + s->q;
    }
}

static void smooth_scalar(scalar *s)
{
    for (int t = LAST - 1; t >= 0; t--) {
        const double gain = s->variance[t] * s->a / s->before[t + 1];
        s->mean[t] += gain * (s->mean[t + 1] - s->predicted[t + 1]);
        s->variance[t] += gain * gain * (s->variance[t + 1] - s->before[t + 1]);
    }
}

/* Side by side; rotated and seen so, with independent noises; rotated and seen as they are, their noises correlated */
enum { APART, ROTATED, CORRELATED };
static int seen_as;

static void begin(int how)
{
    static num range[16], A[256], B[256], Q[256], P[256], H[256], R[256], r[16], x0[16];
    double a[16], q[16], p[16], variances[16];
    for (int i = 0; i < 16; i++) {
        a[i] = 0.25 * (i % 5) - 0.5, q[i] = 0.5 + 0.125 * i, p[i] = 1 + 0.5 * i, variances[i] = 1 + 0.25 * i;
        y[i] = (scalar){.a = a[i], .q = q[i], .p = p[i], .r = variances[i], .drive = 0.25 * (i % 7) - 0.75};
        range[i] = 100, r[i] = N(variances[i]);
    }
    put_rotated(A, a), put_rotated(Q, q), put_rotated(P, p), put_rotated(R, variances);
    for (int k = 0; k < 256; k++) B[k] = H[k] = hadamard(k / 16, k % 16);
    if (how == CORRELATED) put_identity(H, 16, 1);
    for (int k = 0; k < 256 && how == APART; k++) {
        const int i = k / 16, is_diagonal = k % 17 == 0;
        A[k] = is_diagonal ? N(a[i]) : 0, Q[k] = is_diagonal ? N(q[i]) : 0;
        P[k] = is_diagonal ? N(p[i]) : 0, B[k] = H[k] = is_diagonal ? 1 : 0;
    }
    put_process(&motion, 16, 16, range, range, A, B, Q);
    if (how == CORRELATED) put_sensor(&sensor, 16, 16, range, range, H, R);
    else put_independent(&sensor, 16, 16, range, range, H, r);
    put_prior(&prior, 16, range, x0, P);
    seen_as = how;
    ASSERT_OK(init_filter(&wide, &prior));
    for (int i = 0; i < 16; i++) filter_scalar(&y[i], i);
}

static void set_up(void) { begin(ROTATED); }

static void run(void)
{
    for (int t = 0; t < STEPS; t++) {
        num z[16], u[16];
        double values[16];
        for (int i = 0; i < 16; i++) values[i] = z_of(i, t), u[i] = N(y[i].drive);
        for (int i = 0; i < 16; i++) z[i] = N(seen_as == CORRELATED ? rotated(values, i) : values[i]);
        if (t) ASSERT_OK(S(predict)(&wide, &motion.process, driven(&motion.process, u, 1)));
        ASSERT_OK(S(update)(&wide, &sensor.sensor, measured(&sensor.sensor, z)));
    }
    TEST_ASSERT_EQUAL_HEX(0, S(events)(&wide));
}

/* In q31 ROUNDING is that of two states, and grows with 2n + 4 (filter.h). */
#ifdef KQ_TEST_Q31
enum { SIZE_OF_MEANS = 7 * 36 / 8, SIZE_OF_COVARIANCES = 4 };
#else
enum { SIZE_OF_MEANS = 4, SIZE_OF_COVARIANCES = 2 };
#endif

/* x = T y, P = T diag(variance) T */
static void assert_rotated(const S(filter) *view, int t)
{
    static entry P[256];
    static num expected[256];
    double mean[16], variance[16];
    for (int i = 0; i < 16; i++) mean[i] = y[i].mean[t], variance[i] = y[i].variance[t];
    put_rotated(expected, variance);
    ASSERT_OK(S(covariance)(view, P));
    for (int i = 0; i < 16; i++) ASSERT_ALIKE(rotated(mean, i), shown_mean(view, &prior, i), SIZE_OF_MEANS);
    for (int k = 0; k < 256; k++) ASSERT_ALIKE(expected[k], entry_value(&prior, P[k], k / 16, k % 16), SIZE_OF_COVARIANCES);
}

TEST(the_filter_and_its_smoother)
{
    for (int how = ROTATED; how <= CORRELATED; how++) {
        begin(how);
        ASSERT_OK(S(history_assign)(&tape, 16, guarded(), TAPE));
        ASSERT_OK(S(attach)(&wide, &tape.attached));
        run();
        TEST_ASSERT_EQUAL_INT(16, S(taken)(&wide));
        assert_rotated(&wide, LAST);
        ASSERT_OK(S(smooth)(&tape));
        for (int i = 0; i < 16; i++) smooth_scalar(&y[i]);
        for (int t = 0; t < STEPS; t++) assert_rotated(S_SMOOTHED(&tape, (size_t)t), t);
        assert_guarded(TAPE);
    }
}

TEST(the_smoothers_on_line)
{
    S(filter) view;
    for (int i = 0; i < 16; i++) smooth_scalar(&y[i]);
    attach_lag();
    run();
    for (int k = 0; k <= KEPT; k++) {
        ASSERT_OK(S(lagged)(&lag, (size_t)k, &view));
        assert_rotated(&view, LAST - k);
    }
    assert_guarded(LAG_WORDS);
    ASSERT_OK(init_filter(&wide, &prior));
    ASSERT_OK(S(instant_assign)(&instant, 16, 16, guarded(), S_INSTANT_LEN(16, 16)));
    ASSERT_OK(S(attach)(&wide, &instant.attached));
    run();
    ASSERT_OK(S(instant_smooth)(&instant, &view));
    assert_rotated(&view, 0);
    assert_guarded(S_INSTANT_LEN(16, 16));
}

TEST(what_is_independent_stays_so_bit_for_bit)
{
    S(filter) view;
    entry P[256];
    begin(APART);
    attach_lag();
    run();
    ASSERT_OK(S(lagged)(&lag, KEPT, &view));
    ASSERT_OK(S(covariance)(&view, P));
    for (int i = 0; i < 16; i++) smooth_scalar(&y[i]);
    for (int k = 0; k < 256; k++) {
        const double expected = k % 17 ? 0 : y[k / 16].variance[LAST - KEPT];
        ASSERT_WITHIN(ROUNDING * 4 * (k % 17 == 0), expected, entry_value(&prior, P[k], k / 16, k % 16));
    }
    for (int i = 0; i < 16; i++) ASSERT_ALIKE(y[i].mean[LAST - KEPT], shown_mean(&view, &prior, i), 4);
}

SUITE(wide, set_up)
#include "wide.tests"
