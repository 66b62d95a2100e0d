/*
 * Every public function at 16 states and 16 components, with every kind of sensor and all that can be attached: there
 * a function needs most for itself, and sanitizers see each array of it.  tests/house/parity.py finds a function that is
 * left out.  Results are compared, too: what is smoothed on line with the history, what came late with the run in time.
 */
#define MAX 16
#include "models.h"
#include "sizes.h"

enum { FULL = 16, STEPS = 6, ROWS = 3 * FULL };

static process_model motion, wider;
static sensor_model radar;
static prior_model prior;
S_FILTER(track, FULL);
S_FILTER(twin, FULL);
S_FILTER(aside, FULL);
S_HISTORY(tape, FULL, ROWS, STEPS, STEPS);
S_HISTORY(twin_tape, FULL, ROWS, STEPS, STEPS);
S_HISTORY(course, FULL, ROWS, STEPS, STEPS);
S_JACOBIANS(kept, course, FULL, STEPS, STEPS);
S_LAG(past, FULL, ROWS, STEPS - 1);
S_INSTANT(instant, FULL, ROWS);
S_ADAPTATION(tuner, FULL, FULL);
S_FREEZE(lazy, FULL, FULL);
S_DIFFUSE(start, FULL, 3);
S_STEADY(steady, FULL, FULL);
S_CONSISTENCY(recent, FULL, 2);
static S(filter) view;
static entry square[FULL * FULL], other_square[FULL * FULL];
static num range[FULL], measured_range[FULL], A[FULL * FULL], Q[FULL * FULL], H[FULL * FULL], R[FULL * FULL], r[FULL];
static num x0[FULL], P0[FULL * FULL];
static uint32_t seed;
static int without_losses; /* a loss weighs by what is known by then */

#ifdef KQ_TEST_Q31
static kq_status change_jacobian(void) { return kq_process_change_jacobian_q31(&wider.process, wider.transition, NULL); }

static kq_status init_fit(kq_least_squares_q31 *fit)
{
    return kq_least_squares_init_q31(fit, &track, number(0.5), radar.measurement_format);
}

#define NOISE_ENTRY(c) (radar.noise + (c))
#else
static kq_status change_jacobian(void) { return K(process_change_transition)(&wider.process, A); }

static kq_status init_fit(K(least_squares) *fit) { return K(least_squares_init)(fit, &track, 0.5); }

#define NOISE_ENTRY(c) (r + (c))
#endif

/* ----------------------------------------------------------------------------- sensors */

/* M = size G G', G 16 x rank, of normal numbers */
static void draw_covariance(num *M, int rank, double size)
{
    static double G[FULL * FULL];
    for (int k = 0; k < FULL * FULL; k++) G[k] = (double)noise(&seed);
    for (int i = 0; i < FULL; i++) {
        for (int j = 0; j < FULL; j++) {
            double sum = 0;
            for (int k = 0; k < rank; k++) sum += G[i * FULL + k] * G[j * FULL + k];
            M[i * FULL + j] = N(size * sum / (double)FULL);
        }
    }
}

/* rank of a correlated R, 0: independent; the variances' size; their kind */
typedef struct {
    const char *name;
    int rank;
    double size;
    int is_lean, takes_innovations;
} sensor_kind;

static const sensor_kind sensors[] = {
    {"independent", 0, 1, 0, 0},
    {"correlated", FULL, 1, 0, 0},
    {"of low noise", 0, 1e-10, 0, 0},
    {"correlated, of low noise", FULL, 1e-10, 0, 0},
    {"without noise", 0, 0, 0, 0},
    {"of singular R", FULL / 2, 1, 0, 0},
    {"lean", 0, 1, 1, 0},
    {"lean, of low noise", 0, 1e-10, 1, 0},
    {"lean, without noise", 0, 0, 1, 0},
    {"of innovations", 0, 1, 0, 1},
    {"of innovations, correlated", FULL, 1, 0, 1},
    {"of innovations, singular", FULL / 2, 1e-4, 0, 1},
    {"of innovations, lean", 0, 1, 1, 1},
    {"of innovations, lean, of low noise", 0, 1e-10, 1, 1},
};

static double sigma_of_noise; /* of what is measured */

static double row_times(const num *row, const double *x)
{
    double sum = 0;
    for (int i = 0; i < FULL; i++) sum += (double)row[i] * x[i];
    return sum;
}

static const S(sensor) *put_sensor_kind(const sensor_kind *k)
{
    seed = 5;
    sigma_of_noise = sqrt(k->size);
    draw_covariance(R, k->rank ? k->rank : FULL, k->size);
    for (int c = 0; c < FULL; c++) r[c] = N(k->size * (1 + 0.125 * c));
    if (k->rank) put_sensor(&radar, FULL, FULL, range, measured_range, H, R);
    else put_independent(&radar, FULL, FULL, range, measured_range, H, r);
    if (k->is_lean && k->takes_innovations) return lean_of_innovations(&radar, r);
    if (k->is_lean) ASSERT_OK(init_lean(&radar, r));
    return k->takes_innovations ? of_innovations(&radar) : &radar.sensor;
}

static void set_up(void)
{
    seed = 3, without_losses = 0;
    for (int i = 0; i < FULL; i++) {
        range[i] = 100, measured_range[i] = 2000;
        x0[i] = N(0.5 * i - 4);
        for (int j = 0; j < FULL; j++) {
            A[i * FULL + j] = N(i == j ? 0.9 : 0.02 * (double)noise(&seed));
            H[i * FULL + j] = N(i == j ? 1 : 0.2 * (double)noise(&seed));
        }
    }
    draw_covariance(Q, FULL, 0.25);
    draw_covariance(P0, FULL, 2);
    put_process(&motion, FULL, 0, range, range, A, NULL, Q);
    put_process(&wider, FULL, 0, range, range, A, NULL, Q);
    put_prior(&prior, FULL, range, x0, P0);
    put_sensor_kind(sensors);
}

/* What a sensor of z, or of innovations, could read at step t of a state that no noise moves */
static const word *seen(const S(sensor) *s, int t)
{
    static num z[FULL];
    double x[FULL], moved[FULL];
    uint32_t of_step = (uint32_t)t + 11;
    for (int i = 0; i < FULL; i++) x[i] = s == &radar.sensor ? (double)x0[i] + 0.5 * (i % 3) : 0;
    for (int k = 0; k < t % 20; k++) {
        for (int i = 0; i < FULL; i++) moved[i] = row_times(A + i * FULL, x);
        memcpy(x, moved, sizeof x);
    }
    for (int c = 0; c < FULL; c++) z[c] = N(row_times(H + c * FULL, x) + sigma_of_noise * (double)noise(&of_step));
    return measured(s, z);
}

/* ----------------------------------------------------------------------------- steps */

static void begin(S(filter) *f, word *words, size_t length)
{
    ASSERT_OK(S(filter_assign)(f, FULL, words, length));
    ASSERT_OK(init_filter(f, &prior));
}

/* Some calls are refused with what is attached: what else happens stands in the tests of them. */
static void call(kq_status status, kq_status refusal)
{
    if (status != refusal) ASSERT_OK(status);
}

/* A predict and all of z, some of it, or all with a loss, in turn */
static void move(S(filter) *f, const S(sensor) *s, int t)
{
    S(loss) huber = {.kind = &S(loss_huber), .parameter = number(2)};
    const int how = t % 3 == 2 && without_losses ? 0 : t % 3;
    if (t) ASSERT_OK(S(predict)(f, &motion.process, NULL));
    if (how == 0) call(S(update)(f, s, seen(s, t)), KQ_ERR_RECORDING);
    if (how == 1) call(S(update_subset)(f, s, seen(s, t), 0xA5F3), KQ_ERR_RECORDING);
    if (how == 2) call(S(update_robust)(f, s, seen(s, t), UINT32_MAX, &huber), KQ_ERR_RECORDING);
}

/* What is read is a number, and no sigma is negative. */
static void assert_sound(const S(filter) *f)
{
    for (int i = 0; i < FULL; i++) {
        TEST_ASSERT_FALSE_MESSAGE(is_nothing(S(mean)(f, i)) || is_nothing(S(sigma)(f, i)), description());
        TEST_ASSERT_TRUE_MESSAGE(S(sigma)(f, i) >= 0, description());
    }
}

/* As `expected`, to what the arithmetic leaves of a low-noise measurement in a wide prior */
static void assert_near(const S(filter) *expected, const S(filter) *actual)
{
    assert_sound(actual);
    for (int i = 0; i < FULL; i++) {
        const double sigma = word_value(&prior, S(sigma)(expected, i), i);
        const double least = 8 * sigma_step(range[i]) + 2e-3 * sigma + 1e3 * EPS;
        ASSERT_WITHIN(least, shown_mean(expected, &prior, i), shown_mean(actual, &prior, i));
        ASSERT_WITHIN(least, sigma, word_value(&prior, S(sigma)(actual, i), i));
    }
}

/* twin: the same steps, with a history */
static void run_twin(const S(sensor) *s)
{
    begin(&twin, twin_memory, COUNT(twin_memory));
    ASSERT_OK(S(history_assign)(&twin_tape, FULL, twin_tape_memory, COUNT(twin_tape_memory)));
    ASSERT_OK(S(attach)(&twin, &twin_tape.attached));
    for (int t = 0; t < STEPS; t++) move(&twin, s, t);
    ASSERT_OK(S(smooth)(&twin_tape));
}

/* For each kind of sensor: `attach`, the steps, `end` */
static void for_each_sensor(kq_status (*attach)(const S(sensor) *s), void (*end)(const S(sensor) *s))
{
    for (const sensor_kind *k = sensors; k < sensors + COUNT(sensors); k++) {
        describe(k->name, "", 0, "", 0);
        const S(sensor) *s = put_sensor_kind(k);
        run_twin(s);
        begin(&track, track_memory, COUNT(track_memory));
        if (attach) ASSERT_OK(attach(s));
        for (int t = 0; t < STEPS; t++) move(&track, s, t);
        assert_sound(&track);
        end(s);
    }
}

/* ----------------------------------------------------------------------------- tests */

static void read_all(const S(sensor) *s)
{
    word readings[FULL];
    S(loss) losses[] = {{.kind = &S(loss_student), .parameter = number(4)},
                        {.kind = &S(loss_jump), .parameter = number(2)},
                        {.kind = &S(loss_gate), .limit = S(chi_square_limit)(FULL, KQ_LEVEL_99), .run = 1}};
    ASSERT_OK(S(covariance)(&track, square));
    ASSERT_OK(S(gain)(&track, s, square));
    ASSERT_OK(S(measurement)(&track, s, readings, square));
    ASSERT_OK(S(innovation)(&track, s, seen(s, 1), readings));
    TEST_ASSERT_TRUE(S(taken)(&track) >= 0);
    TEST_ASSERT_FALSE(is_no_score(S(nis)(&track)) || is_no_score(S(log_likelihood)(&track)));
    TEST_ASSERT_FALSE(is_no_score(S(log_likelihood_last)(&track)));
    for (int k = 0; k < COUNT(losses); k++) {
        ASSERT_OK(S(predict)(&track, &motion.process, NULL));
        ASSERT_OK(S(update_robust)(&track, s, seen(s, 3), UINT32_MAX, losses + k));
        ASSERT_OK(S(update_robust)(&track, s, seen(s, 4), 0x5A5A, losses + k));
        assert_sound(&track);
    }
    ASSERT_OK(S(filter_assign)(&aside, FULL, aside_memory, COUNT(aside_memory)));
    ASSERT_OK(S(forecast)(&track, &motion.process, NULL, 3, &aside));
    ASSERT_OK(S(filter_copy)(&aside, &track));
    ASSERT_OK(S(step)(&track, &motion.process, NULL, s, seen(s, 5)));
    ASSERT_OK(S(step)(&aside, &motion.process, NULL, s, seen(s, 5)));
    assert_near(&aside, &track);
    ASSERT_OK(S(forget)(&track, number(0.5)));
    ASSERT_OK(S(move)(&track, moved_by(&motion, x0)));
    ASSERT_OK(S(filter_check)(&track));
    S(events_clear)(&track);
    TEST_ASSERT_EQUAL_HEX(0, S(events)(&track));
    assert_sound(&track);
}

TEST(a_filter_at_full_size) { for_each_sensor(NULL, read_all); }

static kq_status attach_tape(const S(sensor) *s)
{
    (void)s;
    ASSERT_OK(S(history_assign)(&tape, FULL, tape_memory, COUNT(tape_memory)));
    return S(attach)(&track, &tape.attached);
}

/* Step by step with all that can be asked for, as at one time */
static void smooth_by_steps(const S(sensor) *s)
{
    entry mean[FULL], variance;
    const S(smooth_extras) extras = {square, mean, other_square};
    (void)s;
    TEST_ASSERT_EQUAL_INT(STEPS, (int)S(history_steps)(&tape));
    for (int t = STEPS; t-- > 0;) {
        ASSERT_OK(S(smooth_step)(&tape, NULL, &extras));
        call(S(smoothed_measurement_noise)(&tape, 0, mean, &variance), KQ_ERR_SIZE);
        ASSERT_OK(S(smoothed)(&tape, (size_t)t, &view));
        assert_near(S_SMOOTHED(&twin_tape, (size_t)t), &view);
    }
}

static void smooth_means(const S(sensor) *s)
{
    (void)s;
    ASSERT_OK(S(smooth_states)(&tape));
    TEST_ASSERT_FALSE(is_nothing(S(mean)(S_SMOOTHED(&tape, 0), FULL - 1)));
}

static void smooth_with_weights(const S(sensor) *s)
{
    entry q[STEPS - 1];
    (void)s;
    for (int t = 0; t < STEPS - 1; t++) q[t] = number(1);
    ASSERT_OK(smooth_reweighted(&tape, &wider, &motion, number(2), q));
    assert_near(S_SMOOTHED(&twin_tape, 0), S_SMOOTHED(&tape, 0));
}

TEST(a_history_at_full_size)
{
    for_each_sensor(attach_tape, smooth_by_steps);
    for_each_sensor(attach_tape, smooth_means);
    for_each_sensor(attach_tape, smooth_with_weights);
}

static kq_status attach_past(const S(sensor) *s)
{
    (void)s;
    ASSERT_OK(S(lag_assign)(&past, FULL, ROWS, STEPS - 1, past_memory, COUNT(past_memory)));
    return S(attach)(&track, &past.attached);
}

static void look_back(const S(sensor) *s)
{
    (void)s;
    TEST_ASSERT_EQUAL_INT(STEPS - 1, (int)S(lag_steps)(&past));
    for (size_t k = 0; k < STEPS; k++) {
        ASSERT_OK(S(lagged)(&past, k, &view));
        assert_near(S_SMOOTHED(&twin_tape, STEPS - 1 - k), &view);
        ASSERT_OK(S(lagged_states)(&past, k, &view));
    }
}

TEST(a_lag_at_full_size) { for_each_sensor(attach_past, look_back); }

static kq_status attach_instant(const S(sensor) *s)
{
    (void)s;
    ASSERT_OK(S(instant_assign)(&instant, FULL, ROWS, instant_memory, COUNT(instant_memory)));
    return S(attach)(&track, &instant.attached);
}

static void look_at_the_first(const S(sensor) *s)
{
    (void)s;
    ASSERT_OK(S(instant_smooth)(&instant, &view));
    assert_sound(&view);
    if (sigma_of_noise > 1e-3) assert_near(S_SMOOTHED(&twin_tape, 0), &view);
}

TEST(an_instant_at_full_size) { for_each_sensor(attach_instant, look_at_the_first); }

static kq_status attach_delay(const S(sensor) *s)
{
    (void)s;
    ASSERT_OK(S(delay_assign)(&past, FULL, ROWS, STEPS - 1, past_memory, COUNT(past_memory)));
    return S(attach)(&track, &past.attached);
}

/* One more at each of the last steps, beside the run in which all of them came in time */
static void take_late(const S(sensor) *s)
{
    begin(&twin, twin_memory, COUNT(twin_memory));
    for (int t = 0; t < STEPS; t++) {
        move(&twin, s, t);
        if (t > 2 && s == &radar.sensor) ASSERT_OK(S(update_subset)(&twin, s, seen(s, t + 20), 0x3FFF));
    }
    for (int t = STEPS - 1; t > 2; t--) {
        const kq_status status = S(update_delayed)(&past, (size_t)(STEPS - 1 - t), s, seen(s, t + 20), 0x3FFF);
        TEST_ASSERT_EQUAL_INT(s == &radar.sensor ? KQ_OK : KQ_ERR_MISMATCH, status);
    }
    assert_sound(&track);
    if (s == &radar.sensor && sigma_of_noise > 1e-3) assert_near(&twin, &track);
}

TEST(late_measurements_at_full_size)
{
    without_losses = 1;
    for_each_sensor(attach_delay, take_late);
}

/* ------------------------------------------------------------------- what learns, rests, begins */

static kq_status attach_tuner(const S(sensor) *s)
{
    const S(adaptation_rule) rule = usual_rule();
    ASSERT_OK(ASSIGN_ADAPTATION(tuner, FULL, FULL));
    ASSERT_OK(S(adaptation_init)(&tuner, &motion.process, &radar.sensor, &rule));
    (void)s;
    return S(attach)(&track, &tuner.attached);
}

static void read_scales(const S(sensor) *s)
{
    entry q, noise_scale;
    (void)s;
    ASSERT_OK(S(adaptation_scales)(&tuner, &q, &noise_scale));
    TEST_ASSERT_TRUE(number_of(q) > 0 && number_of(noise_scale) > 0);
    ASSERT_OK(S(predict)(&track, S(adaptation_process)(&tuner), NULL));
    ASSERT_OK(S(update)(&track, S(adaptation_sensor)(&tuner), seen(&radar.sensor, 7)));
    assert_sound(&track);
}

TEST(an_adaptation_at_full_size) { for_each_sensor(attach_tuner, read_scales); }

static kq_status attach_freeze(const S(sensor) *s)
{
    (void)s;
    ASSERT_OK(S(freeze_assign)(&lazy, FULL, FULL, lazy_memory, COUNT(lazy_memory), lazy_gain));
    ASSERT_OK(S(freeze_init)(&lazy, 4));
    return S(attach)(&track, &lazy.attached);
}

/* Until its gain is frozen; a constant one is this gain, too */
static void rest(const S(sensor) *s)
{
    word readings[FULL];
    if (s != &radar.sensor) return; /* innovations are refused */
    for (int t = 0; t < 60; t++) ASSERT_OK(S(step)(&track, &motion.process, NULL, s, seen(s, t)));
    TEST_ASSERT_EQUAL_INT_MESSAGE(1, S(freeze_is_active)(&lazy), description());
    ASSERT_OK(S(gain)(&track, s, square));
    ASSERT_OK(S(freeze_release)(&lazy));
    assert_sound(&track);
    ASSERT_OK(S(steady_assign)(&steady, FULL, FULL, steady_memory, COUNT(steady_memory)));
    ASSERT_OK(S(steady_init)(&steady, &motion.process, s, prior.mean, square, 1));
    ASSERT_OK(S(steady_update)(&steady, seen(s, 0)));
    ASSERT_OK(S(steady_predict)(&steady, NULL));
    ASSERT_OK(S(steady_step)(&steady, NULL, seen(s, 1)));
    ASSERT_OK(S(steady_innovation)(&steady, seen(s, 2), readings));
    for (int i = 0; i < FULL; i++) TEST_ASSERT_FALSE(is_nothing(S(steady_mean)(&steady, i)));
}

TEST(a_freeze_and_a_constant_gain_at_full_size) { for_each_sensor(attach_freeze, rest); }

static kq_status attach_start(const S(sensor) *s)
{
    if (s != &radar.sensor) return KQ_OK; /* innovations are refused */
    ASSERT_OK(S(history_assign)(&tape, FULL, tape_memory, COUNT(tape_memory)));
    ASSERT_OK(S(diffuse_assign)(&start, FULL, 3, start_memory, COUNT(start_memory)));
    ASSERT_OK(init_start(&start, &track, &prior, 0xFFFF));
    ASSERT_OK(S(attach)(&track, &tape.attached));
    /* early steps: half of what is unknown is measured before the first predict, the rest after the second */
    for (int t = 0; t < 3; t++) {
        if (t) ASSERT_OK(S(predict)(&track, &motion.process, NULL));
        if (t != 1) ASSERT_OK(S(update_subset)(&track, s, seen(s, t), t ? 0xFF00 : 0x00FF));
    }
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, S(diffuse_count)(&start), description());
    return KQ_OK;
}

static void smooth_the_start(const S(sensor) *s)
{
    size_t first;
    if (s != &radar.sensor) return;
    TEST_ASSERT_EQUAL_INT(2, (int)S(diffuse_steps)(&start, &first));
    TEST_ASSERT_EQUAL_INT(0, (int)first);
    call(S(diffuse_smooth)(&start), KQ_SATURATED);
    for (size_t t = 0; t < 5; t++) {
        ASSERT_OK(S(diffuse_smoothed)(&start, t, &view));
        assert_sound(&view);
    }
}

TEST(a_start_at_full_size) { for_each_sensor(attach_start, smooth_the_start); }

/* --------------------------------------------------------------------- what steps by Jacobians */

static kq_status attach_jacobians(const S(sensor) *s)
{
    (void)s;
    ASSERT_OK(S(jacobians_assign)(&kept, &course, FULL, kept_processes, COUNT(kept_processes), kept_memory,
                                  COUNT(kept_memory)));
    ASSERT_OK(S(history_assign)(&course, FULL, course_memory, COUNT(course_memory)));
    return S(attach)(&track, &kept.attached);
}

static void smooth_linearised(const S(sensor) *s)
{
    for (int t = 1; t < 3; t++) {
        ASSERT_OK(change_jacobian());
        ASSERT_OK(S(predict_extended)(&track, &wider.process, moved_by(&wider, x0)));
        ASSERT_OK(S(update)(&track, s, seen(s, t)));
    }
    ASSERT_OK(S(smooth)(&course));
    for (size_t t = 0; t < 3; t++) assert_sound(S_SMOOTHED(&course, t));
}

static void begin_linearised(const S(sensor) *s)
{
    begin(&track, track_memory, COUNT(track_memory));
    ASSERT_OK(attach_jacobians(s));
    ASSERT_OK(S(update)(&track, s, seen(s, 0)));
    smooth_linearised(s);
}

TEST(linearised_steps_at_full_size) { for_each_sensor(NULL, begin_linearised); }

/* ------------------------------------------------------------------------ what overflows, and ends */

/* All that takes the past apart, of what may have none any more.  Each call answers; sanitizers look on. */
static void take_apart(void)
{
    const word *z = seen(&radar.sensor, 1);
    const S(smooth_extras) extras = {square, NULL, other_square};
    kq_status answers[] = {
        S(smooth_step)(&tape, NULL, &extras), S(smooth)(&tape), S(lagged)(&past, 1, &view),
        S(lagged_states)(&past, STEPS - 1, &view), S(update_delayed)(&past, 1, &radar.sensor, z, UINT32_MAX),
        S(instant_smooth)(&instant, &view), S(diffuse_smooth)(&start), S(diffuse_smoothed)(&start, 0, &view),
        S(smooth)(&course), S(smoothed)(&tape, 0, &view)};
    for (int k = 0; k < COUNT(answers); k++) TEST_ASSERT_TRUE_MESSAGE(answers[k] <= KQ_SATURATED, description());
}

/* States that a predict multiplies by 8, while nothing is measured; then measurements; and once more */
TEST(what_overflows_at_full_size)
{
    static kq_status (*const attach[])(const S(sensor) *) = {attach_tape,   attach_past,  attach_instant,  attach_delay,
                                                             attach_freeze, attach_tuner, attach_jacobians, attach_start};
    static const int outages[] = {3, 20, 45, 400};
    put_identity(A, FULL, 8);
    put_process(&motion, FULL, 0, range, range, A, NULL, Q);
    for (int k = 0; k < COUNT(attach) * COUNT(outages); k++) {
        describe("attached", "which", k % COUNT(attach), "outage", outages[k / COUNT(attach)]);
        begin(&track, track_memory, COUNT(track_memory));
        ASSERT_OK(attach[k % COUNT(attach)](&radar.sensor));
        for (int round = 0; round < 2; round++) {
            for (int t = 0; t < outages[k / COUNT(attach)]; t++) ASSERT_OK(S(predict)(&track, &motion.process, NULL));
            for (int t = 0; t < 2; t++) call(S(update)(&track, &radar.sensor, seen(&radar.sensor, t)), KQ_ERR_NOT_READY);
            take_apart();
        }
        if (track.attached) (void)!S(detach)(track.attached);
    }
}

/* ----------------------------------------------------------------------------- models, windows */

TEST(models_at_full_size)
{
    ASSERT_OK(change_transition(&motion, FULL, A));
    ASSERT_OK(change_measurement(&radar, FULL, FULL, H));
    ASSERT_OK(scale_noise(&wider, &motion, number(2)));
    ASSERT_OK(S(process_check)(&motion.process));
    ASSERT_OK(S(process_check)(&wider.process));
    ASSERT_OK(S(sensor_check)(&radar.sensor));
    TEST_ASSERT_TRUE(S(object_size)(KQ_OBJECT_FILTER) >= sizeof(S(filter)) / 2);
    TEST_ASSERT_EQUAL_INT((int)S_FILTER_LEN(FULL), (int)S(length)(KQ_OBJECT_FILTER, FULL, 0, 0, 0));
    ASSERT_OK(S(self_test)());
}

TEST(a_window_at_full_size)
{
    score a, b, c, d;
    begin(&track, track_memory, COUNT(track_memory));
    ASSERT_OK(S(consistency_assign)(&recent, FULL, 2, recent_memory, COUNT(recent_memory)));
    for (int t = 0; t < 5; t++) {
        ASSERT_OK(S(consistency_watch)(&recent, &track, &radar.sensor, seen(&radar.sensor, t), UINT32_MAX));
        ASSERT_OK(S(update)(&track, &radar.sensor, seen(&radar.sensor, t)));
        ASSERT_OK(S(consistency_record)(&recent, &track));
    }
    TEST_ASSERT_EQUAL_INT(2, (int)S(consistency_count)(&recent));
    ASSERT_OK(S(consistency_nis)(&recent, score_of(2), &a, &b, &c));
    ASSERT_OK(S(consistency_innovation)(&recent, FULL - 1, score_of(2), &a, &b, &c, &d));
    ASSERT_OK(S(consistency_clear)(&recent));
    TEST_ASSERT_EQUAL_INT(0, (int)S(consistency_count)(&recent));
}

TEST(least_squares_at_full_size)
{
    S(least_squares) fit;
    begin(&track, track_memory, COUNT(track_memory));
    ASSERT_OK(init_fit(&fit));
    for (int c = 0; c < FULL; c++) {
        const entry *row = radar.sensor.measurement + c * FULL;
        ASSERT_OK(S(least_squares_add)(&fit, row, seen(&radar.sensor, 1) + c, NOISE_ENTRY(c), 1));
    }
    TEST_ASSERT_FALSE(is_no_score(S(least_squares_residual)(&fit)) || is_no_score(S(least_squares_weight)(&fit)));
    assert_sound(&track);
}

#ifdef KQ_TEST_Q31
TEST_Q31(a_constant_gain_reads_at_full_size)
{
    for_each_sensor(attach_freeze, rest);
    kq_steady_events_clear_q31(&steady);
    TEST_ASSERT_EQUAL_HEX(0, kq_steady_events_q31(&steady));
    TEST_ASSERT_TRUE(kq_steady_mean_low_q31(&steady, FULL - 1) != KQ_NOT_A_VALUE_Q31);
}

TEST_Q31(tables_at_full_size)
{
    static int32_t root[KQ_ROOT_LEN_Q31(FULL)];
    kq_range_error_q31 error = {0};
    char text[200];
    ASSERT_OK(kq_root_prepare_factor_q31(root, P0, FULL, FULL, prior.state_format));
    prior.mean[FULL - 1] = prior.state_format[FULL - 1].range + 1;
    TEST_ASSERT_TRUE(kq_filter_init_q31(&track, &prior.table, &error) < 0);
    TEST_ASSERT_TRUE(kq_range_error_text_q31(&error, text, sizeof text) > 0);
}
#else
static void put_sum(void *context, const num *x, num *y)
{
    (void)context;
    for (int c = 0; c < FULL; c++) y[c] = N(0.1) * x[c] + N(0.01) * x[(c + 1) % FULL] * x[c];
}

TEST_FLOAT(other_inits_at_full_size)
{
    static num memory[KQ_CONTINUOUS_LEN(FULL, 0)], root[KQ_TRIANGLE(FULL)], corner[FULL * FULL];
    static num correlated[KQ_CORRELATED_LEN(FULL, FULL, FULL)];
    PROCESS(driven_by_z, FULL, FULL);
    begin(&track, track_memory, COUNT(track_memory));
    for (int k = 0; k < KQ_TRIANGLE(FULL); k++) root[k] = N(0.1);
    ASSERT_OK(K(filter_init_root)(&track, x0, root));
    ASSERT_OK(K(process_init_root)(&motion.process, A, NULL, root));
    ASSERT_OK(K(process_init_factor)(&motion.process, A, NULL, P0, FULL));
    ASSERT_OK(K(process_init_continuous)(&motion.process, A, NULL, Q, N(0.1), memory, COUNT(memory)));
    ASSERT_OK(K(predict)(&track, &motion.process, NULL));
    put_sensor_kind(sensors + 1);
    for (int k = 0; k < FULL * FULL; k++) corner[k] = N(0.001) * Q[k];
    ASSERT_OK(K(process_assign)(&driven_by_z, FULL, FULL, correlated, COUNT(correlated)));
    ASSERT_OK(K(process_init_correlated)(&driven_by_z, A, NULL, Q, &radar.sensor, corner, 0xFFFF));
    ASSERT_OK(K(predict)(&track, &driven_by_z, seen(&radar.sensor, 1)));
    assert_sound(&track);
}

TEST_FLOAT(a_steady_state_at_full_size)
{
    static num memory[SOLVE_LEN(FULL, FULL)], P[FULL * FULL], G[FULL * FULL];
    const K(steady_solution) all = {P, square, other_square, G};
    for (const sensor_kind *k = sensors; k < sensors + COUNT(sensors); k++) {
        const K(sensor) *s = put_sensor_kind(k);
        ASSERT_OK(K(steady_solve)(&motion.process, s, memory, COUNT(memory), &all));
        TEST_ASSERT_TRUE(P[0] >= square[0] && square[0] >= 0);
    }
}

TEST_FLOAT(sigma_points_at_full_size)
{
    static num y[FULL], J[FULL * FULL], E[FULL * FULL], work[KQ_SIGMA_POINTS_LEN(FULL, FULL)];
    static num words[KQ_SENSOR_LEN(FULL)], noise_words[FULL * FULL], process_words[KQ_PROCESS_LEN(FULL)];
    static const kq_sigma_points rules[] = {KQ_SIGMA_POINTS_CUBATURE, KQ_SIGMA_POINTS_CENTRAL};
    K(process) found;
    K(sensor) at;
    ASSERT_OK(K(process_assign)(&found, FULL, 0, process_words, COUNT(process_words)));
    ASSERT_OK(K(sensor_assign)(&at, FULL, FULL, words, COUNT(words)));
    for (const sensor_kind *k = sensors; k < sensors + COUNT(sensors); k++) {
        put_sensor_kind(k);
        for (int rule = 0; rule < 2 && !k->takes_innovations && !k->is_lean; rule++) {
            begin(&track, track_memory, COUNT(track_memory));
            ASSERT_OK(attach_jacobians(&radar.sensor));
            ASSERT_OK(K(predict_sigma_points)(&track, &motion.process, put_sum, NULL, rules[rule], work));
            ASSERT_OK(K(update_sigma_points)(&track, &radar.sensor, put_sum, NULL, rules[rule], work));
            ASSERT_OK(K(linearise)(&track, put_sum, NULL, FULL, rules[rule], y, J, E));
            ASSERT_OK(K(process_linearise)(&found, &motion.process, J, E));
            ASSERT_OK(K(sensor_linearise)(&at, &radar.sensor, J, E, noise_words));
            ASSERT_OK(K(predict_extended)(&track, &found, y));
            ASSERT_OK(K(update)(&track, &at, y));
            ASSERT_OK(K(smooth)(&course));
            assert_sound(S_SMOOTHED(&course, 0));
        }
    }
}

/* ------------------------------------------------------------------------------ EM */

#ifdef KQ_TEST_F32
#define EM_LEN KQ_EM_LEN_F32
#else
#define EM_LEN KQ_EM_LEN_F64
#endif

enum { RECORDED = 80 };

TEST_FLOAT(em_at_full_size)
{
    static K(em) em;
    static num memory[EM_LEN(FULL, FULL, RECORDED)], z[RECORDED * FULL], F[FULL * FULL];
    static uint16_t present[RECORDED];
    const K(recording) recording = {RECORDED, z, present, NULL};
    const kq_em_choice all = {KQ_EM_ALL, KQ_EM_FULL, KQ_EM_FULL, NULL, NULL};
    static num x_slope[FULL];
    K(parameters) model = {0, 0, A, NULL, NULL, Q, H, R, x0, P0};
    const K(gradient) gradient = {F, F, F, F, x_slope, F};
    draw_covariance(R, FULL, 1);
    for (int t = 0; t < RECORDED; t++) {
        memcpy(z + t * FULL, seen(&radar.sensor, t), FULL * sizeof(num));
        present[t] = (uint16_t)(t % 4 == 1 ? 0xA5F3 : t % 11 == 7 ? 0 : 0xFFFF);
    }
    ASSERT_OK(K(em_assign)(&em, FULL, FULL, memory, COUNT(memory)));
    TEST_ASSERT_TRUE(K(em_init)(&em, &model, &all, &recording, 1) >= 0);
    do ASSERT_OK(K(em_advance)(&em));
    while (K(em_remaining)(&em));
    ASSERT_OK(K(em_gradient)(&em, &gradient));
    ASSERT_OK(K(em_maximise)(&em));
    TEST_ASSERT_TRUE(K(em_change)(&em) > 0);
    ASSERT_OK(K(em_iterate)(&em));
    TEST_ASSERT_FALSE(isnan(K(em_log_likelihood)(&em)));
    (void)K(em_distance)(&em);
}
#endif

SUITE(full_size, set_up)
#include "full_size.tests"
