/*
 * Late measurements: random models, delays of 1 to 20 steps, several late ones at a time, some of the same step,
 * steps and components without a measurement.  Beside the run of the same arithmetic in which nothing was late:
 * the filter at its end, each state of the lag, and the likelihood.
 */
#include "models.h"
#include "unchanged.h"

enum { MODELS = KQ_TEST_IS_SLOW && sizeof(void *) != 4 ? 40 : 200, STEPS = 44, LATEST = 20, MOST = 4 };

typedef struct {
    int n, m;
    double sharp; /* the share of their noise that the late ones have */
    num A[MAX * MAX], Q[MAX * MAX], H[MAX * MAX], R[4], h[MAX], r[1], x0[MAX], P0[MAX * MAX];
} numbers;

/* A reading of the step `taken` that comes at the step `comes` */
typedef struct {
    int comes;
    uint32_t present;
    num z[2];
} late_reading;

static numbers drawn;
static late_reading late[STEPS];
static num early[STEPS];
static int is_early[STEPS];
static process_model motion;
static sensor_model radar, compass;
static prior_model prior;
static word track_words[S_FILTER_LEN(MAX)], twin_words[S_FILTER_LEN(MAX)];
static word past_words[S_LAG_LEN(MAX, MOST, LATEST)], tape_words[S_HISTORY_LEN(MAX, MOST, STEPS, STEPS)];
static S(filter) track, twin, shown;
static S(lag) past;
static S(history) tape;

static const num range[] = {100, 100, 100, 100}, measured_range[] = {200, 200};

/* ---------------------------------------------------------------------------- models */

static double drawn_number(uint32_t *seed) { return (double)noise(seed) / 2; }

/* M = G G' times `size`, G n x n; of its columns only the first `rank` are not 0 */
static void draw_covariance(num *M, int n, int rank, double size, double least, uint32_t *seed)
{
    num G[MAX * MAX];
    for (int k = 0; k < n * n; k++) G[k] = N(drawn_number(seed));
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            double sum = i == j ? least : 0;
            for (int k = 0; k < rank; k++) sum += (double)G[i * n + k] * (double)G[j * n + k];
            M[i * n + j] = N(size * sum);
        }
    }
}

/* Slow ones and fast ones, some with states that no noise moves, some with a noise that is far below the state's */
static void draw_model(int k, uint32_t *seed)
{
    numbers *d = &drawn;
    const int n = d->n = 1 + k % READING_STATES;
    const double pace = k % 4 ? 0.05 : 0.4;
    d->sharp = k % 11 == 5 ? 1e-8 : k % 7 ? 1 : 1e-3;
    d->m = 1 + k / 2 % 2;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) d->A[i * n + j] = N((i == j ? 1 - 0.5 * pace : 0) + pace * drawn_number(seed) / n);
        d->h[i] = N(drawn_number(seed));
        d->x0[i] = N(4 * drawn_number(seed));
    }
    for (int i = 0; i < d->m * n; i++) d->H[i] = N(drawn_number(seed));
    draw_covariance(d->Q, n, k % 5 ? n : n / 2, 0.2, 0, seed);
    draw_covariance(d->P0, n, n, 2, 0.5, seed);
    draw_covariance(d->R, d->m, d->m, d->sharp, 0.1, seed);
    d->r[0] = N(0.05 + 0.5 * (k % 4));
}

static double row_times(const num *row, const double *x, int n)
{
    double sum = 0;
    for (int i = 0; i < n; i++) sum += (double)row[i] * x[i];
    return sum;
}

/* Of a state that moves as the model says, without process noise */
static void draw_readings(uint32_t *seed)
{
    const numbers *d = &drawn;
    const int n = d->n;
    double x[MAX], moved[MAX];
    for (int i = 0; i < n; i++) x[i] = (double)d->x0[i] + 2 * drawn_number(seed);
    for (int t = 0; t < STEPS; t++) {
        late_reading *z = &late[t];
        const double chance = drawn_number(seed);
        is_early[t] = drawn_number(seed) > -0.25;
        z->comes = t + 1 + (int)((unsigned)(*seed >> 8) % LATEST);
        if (chance > 0.5) z->comes = STEPS; /* never */
        z->present = chance < -0.5 ? 1 : 3;
        early[t] = N(row_times(d->h, x, n) + sqrt((double)d->r[0]) * drawn_number(seed));
        for (int c = 0; c < d->m; c++) {
            z->z[c] = N(row_times(d->H + c * n, x, n) + sqrt((double)d->R[c * d->m + c]) * drawn_number(seed));
        }
        for (int i = 0; i < n; i++) moved[i] = row_times(d->A + i * n, x, n);
        memcpy(x, moved, sizeof x);
    }
}
static void put_model(void)
{
    const numbers *d = &drawn;
    put_process(&motion, d->n, 0, range, measured_range, d->A, NULL, d->Q);
    put_sensor(&radar, d->n, d->m, range, measured_range, d->H, d->R);
    put_sensor(&compass, d->n, 1, range, measured_range, d->h, d->r);
    put_prior(&prior, d->n, range, d->x0, d->P0);
}

static void begin(S(filter) *f, word *words)
{
    ASSERT_OK(S(filter_assign)(f, drawn.n, words, (size_t)S_FILTER_LEN(drawn.n)));
    ASSERT_OK(init_filter(f, &prior));
}

/* ------------------------------------------------------------------------------ runs */

static void advance(S(filter) *f, int t)
{
    if (t) ASSERT_OK(S(predict)(f, &motion.process, NULL));
    if (is_early[t]) ASSERT_OK(S(update)(f, &compass.sensor, measured(&compass.sensor, early + t)));
}

/* Nothing is late, but for what has not come by the end. */
static void run_in_time(void)
{
    begin(&twin, twin_words);
    ASSERT_OK(S(history_assign)(&tape, drawn.n, tape_words, COUNT(tape_words)));
    ASSERT_OK(S(attach)(&twin, &tape.attached));
    for (int t = 0; t < STEPS; t++) {
        advance(&twin, t);
        if (late[t].comes >= STEPS) continue;
        ASSERT_OK(S(update_subset)(&twin, &radar.sensor, measured(&radar.sensor, late[t].z), late[t].present));
    }
}

/* Answers how many were taken. */
static int run_late(void)
{
    int taken = 0;
    begin(&track, track_words);
    ASSERT_OK(S(delay_assign)(&past, drawn.n, MOST, LATEST, past_words, COUNT(past_words)));
    ASSERT_OK(S(attach)(&track, &past.attached));
    for (int t = 0; t < STEPS; t++) {
        advance(&track, t);
        for (int k = 1; k <= LATEST && k <= t; k++) {
            const late_reading *z = &late[t - k];
            if (z->comes != t) continue;
            ASSERT_OK(S(update_delayed)(&past, (size_t)k, &radar.sensor, measured(&radar.sensor, z->z), z->present));
            ASSERT_OK(S(filter_check)(&track));
            taken++;
        }
    }
    return taken;
}

/* What rounding may do to a mean, in sigmas, and to a covariance, in products of sigmas.  Of sharp measurements that
   of a gain is 1e4 sigma of what is left. */
static double late_rounding(void)
{
#if defined(KQ_TEST_Q31)
    return drawn.sharp < 1e-6 ? 1e-4 : 1e-5;
#elif defined(KQ_TEST_F32)
    return drawn.sharp < 1e-6 ? 3e-3 : 1e-4;
#else
    return 1e-10;
#endif
}

static void assert_near(double expected, double actual, double unit)
{
    ASSERT_WITHIN(late_rounding(), 0, (actual - expected) / unit);
}

static void assert_alike(const reading *expected, const reading *actual)
{
    const int n = drawn.n;
    double sigma[MAX];
    for (int i = 0; i < n; i++) {
        sigma[i] = sqrt((double)expected->P[i * n + i]) + sigma_step(range[i]);
        assert_near(whole(expected, i), whole(actual, i), sigma[i]);
    }
    for (int k = 0; k < n * n; k++) {
        assert_near((double)expected->P[k], (double)actual->P[k], sigma[k / n] * sigma[k % n]);
    }
}

/* -------------------------------------------------------------------------- the tests */

/* A model of two states and a run that is at its last step but one */
static void set_up(void)
{
    uint32_t seed = 7;
    draw_model(7, &seed);
    draw_readings(&seed);
    for (int t = 0; t < STEPS; t++) late[t].comes = STEPS;
    put_model();
    run_in_time();
    run_late();
}

static kq_status take_late(size_t k, const S(sensor) *s)
{
    return S(update_delayed)(&past, k, s, measured(s, late[STEPS - 1].z), UINT32_MAX);
}

static double log_likelihood_of(const S(filter) *f) { return score_number(S(log_likelihood)(f)); }

TEST(what_comes_late_is_as_if_it_had_come_in_time)
{
    reading expected, actual;
    uint32_t seed = 1;
    int taken = 0;
    for (int k = 0; k < MODELS; k++) {
        describe("model", "number", k, "states", 1 + k % READING_STATES);
        draw_model(k, &seed);
        draw_readings(&seed);
        put_model();
        run_in_time();
        taken += run_late();
        read_now(&expected, &twin, drawn.n);
        read_now(&actual, &track, drawn.n);
        assert_alike(&expected, &actual);
        assert_within(2 * STEPS * late_rounding(), log_likelihood_of(&twin), log_likelihood_of(&track), __LINE__);
        ASSERT_OK(S(smooth)(&tape));
        for (size_t age = 0; age <= LATEST; age++) {
            ASSERT_OK(S(lagged)(&past, age, &shown));
            read_shown(&actual, &shown, &prior, drawn.n);
            read_smoothed_at(&expected, &tape, STEPS - 1 - age, &prior, drawn.n);
            assert_alike(&expected, &actual);
        }
        TEST_ASSERT_EQUAL_HEX(0, S(events)(&track));
    }
    TEST_ASSERT_GREATER_THAN(5 * MODELS, taken);
}

/* If it were taken as one of the present, or not at all, the test above would see it. */
TEST(it_matters_that_it_was_late)
{
    reading expected, actual;
    double moved = 0;
    ASSERT_OK(take_late(5, &compass.sensor));
    ASSERT_OK(S(update)(&twin, &compass.sensor, measured(&compass.sensor, late[STEPS - 1].z)));
    read_now(&expected, &twin, drawn.n);
    read_now(&actual, &track, drawn.n);
    for (int i = 0; i < drawn.n; i++) moved += fabs(whole(&actual, i) - whole(&expected, i)) / (double)expected.sigma[i];
    TEST_ASSERT_TRUE(moved > 0.01);
}

TEST(of_the_present_it_is_an_update_bit_for_bit)
{
    const word *z = measured(&radar.sensor, late[STEPS - 1].z);
    for (uint32_t present = 0; present < 3; present++) {
        ASSERT_OK(S(update_delayed)(&past, 0, &radar.sensor, z, present));
        ASSERT_OK(S(update_subset)(&twin, &radar.sensor, z, present));
        ASSERT_SAME(&twin, &track, drawn.n);
    }
    ASSERT_OK(S(update_delayed)(&past, 3, &radar.sensor, z, 0)); /* nothing was measured */
    ASSERT_OK(S(update_subset)(&twin, &radar.sensor, z, 0));
    ASSERT_SAME(&twin, &track, drawn.n);
}

/* Then it is known: once more it tells nothing. */
TEST(one_without_noise)
{
    static const num none[1];
    reading before, after;
    num H[MAX] = {1};
    put_sensor(&compass, drawn.n, 1, range, measured_range, H, none);
    ASSERT_OK(take_late(2, &compass.sensor));
    TEST_ASSERT_EQUAL_HEX(0, S(events)(&track));
    ASSERT_OK(S(lagged)(&past, 2, &shown));
    read_shown(&after, &shown, &prior, drawn.n);
    ASSERT_WITHIN(ROUNDING * 100, late[STEPS - 1].z[0], whole(&after, 0));
    ASSERT_WITHIN(sigma_step(range[0]) + 1e-4, 0, after.sigma[0]);
    read_now(&before, &track, drawn.n);
    ASSERT_OK(take_late(2, &compass.sensor));
    read_now(&after, &track, drawn.n);
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_REDUNDANT, S(events)(&track));
    TEST_ASSERT_EQUAL_INT(0, S(taken)(&track));
    TEST_ASSERT_EQUAL_MEMORY(&before, &after, offsetof(reading, nis));
}

/* Two rows without noise and their sum, late: the sum is redundant, as in time, and moves nothing. */
TEST(what_repeats_without_noise_is_redundant_when_late)
{
    static const num none[3] = {0, 0, 0}, summed_range[3] = {400, 400, 800};
    for (uint32_t seed = 1; seed <= 200; seed++) {
        uint32_t state = seed;
        num H[3 * MAX], z[3] = {late[STEPS - 1].z[0], late[STEPS - 1].z[1]};
        set_up();
        const int n = drawn.n;
        z[2] = z[0] + z[1];
        for (int i = 0; i < 2 * n; i++) H[i] = N((double)(int)(16 * drawn_number(&state)) / 16);
        for (int i = 0; i < n; i++) H[2 * n + i] = H[i] + H[n + i];
        put_independent(&radar, n, 3, range, summed_range, H, none);
        ASSERT_OK(S(update_delayed)(&past, 2, &radar.sensor, measured(&radar.sensor, z), 7));
        describe("", "seed", (int)seed, "taken", S(taken)(&track));
        TEST_ASSERT_TRUE_MESSAGE(S(events)(&track) & KQ_EVENT_REDUNDANT, description());
        TEST_ASSERT_TRUE_MESSAGE(S(taken)(&track) <= 2, description());
    }
}

TEST(what_is_refused_changes_nothing)
{
    const S(sensor) *s = &radar.sensor;
    const word *z = measured(s, late[0].z);
    sensor_model of_three;
    S(lag) nothing;
    memset(&nothing, 0, sizeof nothing);
    put_sensor(&of_three, 3, 1, range, measured_range, drawn.H, drawn.r);
    watch_nothing();
    WATCH(track), WATCH(track_words), WATCH(past), WATCH(shown);
    ASSERT_REFUSED(KQ_ERR_NULL, S(update_delayed)(NULL, 1, s, z, 1));
    ASSERT_REFUSED(KQ_ERR_NULL, S(update_delayed)(&past, 1, NULL, z, 1));
    ASSERT_REFUSED(KQ_ERR_NULL, S(update_delayed)(&past, 1, s, NULL, 1));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, S(update_delayed)(&nothing, 1, s, z, 1));
    ASSERT_REFUSED(KQ_ERR_SIZE, S(update_delayed)(&past, LATEST + 1, s, z, 1));
    ASSERT_REFUSED(KQ_ERR_SIZE, S(update_delayed)(&past, SIZE_MAX, s, z, 1));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, S(update_delayed)(&past, 1, &of_three.sensor, z, 1));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, S(update_delayed)(&past, 1, of_innovations(&radar), z, 1));
    ASSERT_REFUSED(KQ_ERR_SIZE, S(delay_assign)(&past, 2, 1, 0, past_words, COUNT(past_words)));
    ASSERT_REFUSED(KQ_ERR_MEMORY, S(delay_assign)(&past, 2, 1, 2, past_words, (size_t)S_LAG_LEN(2, 1, 2) - 1));
    ASSERT_OK(S(lag_assign)(&past, drawn.n, MOST, LATEST, past_words, COUNT(past_words)));
    ASSERT_OK(S(attach)(&track, &past.attached));
    watch_nothing();
    WATCH(track), WATCH(track_words), WATCH(past);
    ASSERT_REFUSED(KQ_ERR_MISMATCH, S(update_delayed)(&past, 0, s, z, 1)); /* a lag whose maps are not apart */
}

/* The macro cannot refuse it. */
TEST(none_is_of_no_steps)
{
    ASSERT_OK(S(delay_assign)(&past, drawn.n, MOST, 1, past_words, COUNT(past_words)));
    past.most = 0;
    ASSERT_REFUSED(KQ_ERR_SIZE, S(attach)(&track, &past.attached));
}

/* More measurements of a step than there is room for end it, as they end a lag. */
TEST(it_ends_as_a_lag_does)
{
    for (int k = 0; k < MOST + 1; k++) {
        ASSERT_OK(S(update)(&track, &compass.sensor, measured(&compass.sensor, early)));
    }
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_HISTORY_FULL, S(events)(&track));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_HISTORY_FULL, take_late(1, &radar.sensor));
}

SUITE(delayed, set_up)
#include "delayed.tests"
