/* Steps of a nonlinear model whose f and h are linear: they are the plain ones, in every smoother. */
#include "drive.h"
#include "unchanged.h"

#ifdef KQ_TEST_Q31
#define LIKE 0x1p-22 /* increments and innovations are words */
#define LIKE_SCORES (8 * LIKE)
#else
#define LIKE (8 * TOLERANCE)
#define LIKE_SCORES LIKE
#endif

/* The drive by one process that changes at every step */
static process_model changing;
S_HISTORY(record, 2, MOST, STEPS, STEPS);
S_JACOBIANS(jacobians, record, 2, STEPS, STEPS);
S_LAG(past, 2, MOST, STEPS);
S_LAG(past_twin, 2, MOST, STEPS);
S_INSTANT(instant, 2, MOST);
S_INSTANT(instant_twin, 2, MOST);
static S(filter) shown, twin_shown;

static const num identity[] = {1, 0, 0, 1};

static void set_up(void) { begin_drive(); }

/* (A - I) x + B u, x the mean of f */
static const word *increment_of(const S(filter) *f, const num *a, int step)
{
    static num d[2];
    const num u = step % 6 ? N(0.5 * (step % 4) - 1) : 0; /* control_of */
    for (int i = 0; i < 2; i++) {
        double sum = (double)B[i] * (double)u;
        for (int k = 0; k < 2; k++) sum += ((double)a[2 * i + k] - (i == k)) * shown_mean(f, &prior, k);
        d[i] = N(sum);
    }
    return moved_by(&changing, d);
}

static void change(const num *a, const num *noise_of)
{
    put_process(&changing, 2, 0, range, NULL, a, NULL, noise_of);
}

static void predict_linearised(int step)
{
    const int is_motion = step % 3 != 0;
    change(is_motion ? A : A2, is_motion ? Q : Q2);
    ASSERT_OK(S(predict_extended)(&track, &changing.process, increment_of(&track, is_motion ? A : A2, step)));
    change(identity, Q); /* nobody needs it any more */
}

static void update_linearised(sensor_model *s, const num *z, uint32_t present)
{
    word e[2];
    ASSERT_OK(S(innovation)(&track, &s->sensor, measured(&s->sensor, z), e));
    if (present == UINT32_MAX) ASSERT_OK(S(update)(&track, of_innovations(s), e));
    else ASSERT_OK(S(update_subset)(&track, of_innovations(s), e, present));
}

/* As `measure` */
static void measure_linearised(int step)
{
    const num z[] = {N(3 * ((step * 7) % 5 - 2)), N(0.5 * ((step * 11) % 7 - 3))};
    const int turn = step % 5;
    if (turn == 0 || turn == 3) update_linearised(&radar, z, UINT32_MAX);
    if (turn == 2) update_linearised(&radar, z, 2);
    for (int k = 0; k < (turn == 4 ? 2 : turn == 3); k++) update_linearised(&compass, z + k, UINT32_MAX);
}

static void drive_both(int step)
{
    drive(&twin, step);
    if (step) predict_linearised(step);
    measure_linearised(step);
}

/* The same covariance bit for bit, and the same mean but for rounding */
static void assert_alike(const reading *expected, const reading *actual)
{
    for (int i = 0; i < 2; i++) ASSERT_WITHIN(LIKE, whole(expected, i), whole(actual, i));
    TEST_ASSERT_EQUAL_MEMORY(expected->P, actual->P, sizeof actual->P);
}

static void assert_shown_alike(const S(filter) *expected, const S(filter) *actual)
{
    reading a, b;
    read_shown(&a, expected, &prior, 2);
    read_shown(&b, actual, &prior, 2);
    assert_alike(&a, &b);
}

static void assert_tapes_alike(void)
{
    for (size_t t = 0; t < STEPS; t++) {
        ASSERT_OK(S(smoothed)(&tape, t, &twin_shown));
        ASSERT_OK(S(smoothed)(&record, t, &shown));
        assert_shown_alike(&twin_shown, &shown);
    }
}

TEST(linear_steps_are_the_plain_ones)
{
    reading expected, actual;
    for (int step = 0; step < STEPS; step++) {
        drive_both(step);
        read_now(&expected, &twin, 2);
        read_now(&actual, &track, 2);
        assert_alike(&expected, &actual);
        ASSERT_WITHIN(LIKE_SCORES, expected.nis, actual.nis);
        ASSERT_WITHIN(LIKE_SCORES, expected.run, actual.run);
        TEST_ASSERT_EQUAL_INT(expected.taken, actual.taken);
        TEST_ASSERT_EQUAL_UINT(expected.events, actual.events);
    }
}

static void attach_both(void)
{
    ASSERT_OK(S(attach)(&twin, &tape.attached));
    ASSERT_OK(S(attach)(&track, &jacobians.attached));
}

static void record_both(void)
{
    attach_both();
    for (int step = 0; step < STEPS; step++) drive_both(step);
}

TEST(a_history_is_smoothed_though_its_process_has_changed)
{
    for (int run = 0; run < 2; run++) { /* the second time all begins anew */
        begin_drive();
        record_both();
        TEST_ASSERT_EQUAL_UINT(0, S(events)(&track));
        ASSERT_OK(S(smooth)(&tape));
        ASSERT_OK(S(smooth)(&record));
        assert_tapes_alike();
    }
}

TEST(a_history_is_smoothed_step_by_step_and_without_covariances)
{
    num lag_one[4], w[2], cov[4], lag_twin[4], w_twin[2], cov_twin[4];
    record_both();
    for (size_t t = STEPS; t-- > 0;) {
        ASSERT_OK(step_back(&tape, NULL, &prior, lag_twin, w_twin, cov_twin));
        ASSERT_OK(step_back(&record, NULL, &prior, lag_one, w, cov));
        if (t + 1 == STEPS) continue;
        TEST_ASSERT_EQUAL_MEMORY(lag_twin, lag_one, sizeof lag_one);
        TEST_ASSERT_EQUAL_MEMORY(cov_twin, cov, sizeof cov);
        for (int i = 0; i < 2; i++) ASSERT_WITHIN(LIKE, w_twin[i], w[i]);
    }
    begin_drive();
    record_both();
    ASSERT_OK(S(smooth)(&tape));
    ASSERT_OK(S(smooth_states)(&record));
    for (size_t t = 0; t < STEPS; t++) {
        ASSERT_OK(S(smoothed)(&tape, t, &twin_shown));
        ASSERT_OK(S(smoothed)(&record, t, &shown));
        for (int i = 0; i < 2; i++) {
            ASSERT_WITHIN(LIKE, shown_mean(&twin_shown, &prior, i), shown_mean(&shown, &prior, i));
        }
    }
}

TEST(plain_and_linearised_predicts_take_turns_on_a_tape)
{
    attach_both();
    for (int step = 0; step < STEPS; step++) {
        drive(&twin, step);
        if (step && step % 2) predict_linearised(step);
        else if (step) ASSERT_OK(S(predict)(&track, process_of(step), control_of(step)));
        measure_linearised(step);
    }
    ASSERT_OK(S(smooth)(&tape));
    ASSERT_OK(S(smooth)(&record));
    assert_tapes_alike();
}

TEST(the_smoothers_on_line_take_linearised_steps)
{
    ASSERT_OK(S(attach)(&track, &past.attached));
    ASSERT_OK(S(attach)(&twin, &past_twin.attached));
    for (int step = 0; step < STEPS; step++) {
        drive_both(step);
        for (size_t k = 0; k <= (size_t)step; k++) {
            ASSERT_OK(S(lagged)(&past, k, &shown));
            ASSERT_OK(S(lagged)(&past_twin, k, &twin_shown));
            assert_shown_alike(&twin_shown, &shown);
        }
    }
    begin_drive();
    ASSERT_OK(S(attach)(&track, &instant.attached));
    ASSERT_OK(S(attach)(&twin, &instant_twin.attached));
    for (int step = 0; step < STEPS; step++) {
        drive_both(step);
        ASSERT_OK(S(instant_smooth)(&instant, &shown));
        ASSERT_OK(S(instant_smooth)(&instant_twin, &twin_shown));
        assert_shown_alike(&twin_shown, &shown);
    }
}

SUITE(linearised, set_up)
#include "linearised.tests"
