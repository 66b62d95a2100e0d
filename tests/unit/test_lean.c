/* A lean sensor, in all arithmetics: what it takes as any other, what it takes in
   stages, and what is beyond these. */
#include "models.h"
#include "unchanged.h"

enum { STEPS = 12, LAST = 4, CHAIN_MAX = 4, AFTER = 120 };

static process_model motion;
static sensor_model full, lean, sharp;
static prior_model prior, known;
S_FILTER(track, 2);
S_FILTER(twin, 2);
S_HISTORY(tape, 2, 6, STEPS + 1, 0);
S_HISTORY(other, 2, 6, STEPS + 1, 0);
S_ADAPTATION(taught, 2, 3);
S_ADAPTATION(taught_lean, 2, 3);
S_LAG(past, 2, 6, LAST);
S_LAG(past_lean, 2, 6, LAST);
S_INSTANT(instant, 2, 6);
S_INSTANT(instant_lean, 2, 6);
S_FREEZE(lazy, 2, 3);
S_FREEZE(lazy_lean, 2, 3);
S_DIFFUSE(start, 2, 2);
S_DIFFUSE(start_lean, 2, 2);

static const num range[] = {100, 10, 10, 10}, measured_range[] = {100, 100, 100};
static const num A[] = {1, 0.5, 0, 1}, Q[] = {0.25, 0.125, 0.125, 0.5};
static const num H[] = {1, 0, 0.5, 1, -1, 0.25}, first_row[] = {1, 0}, none[] = {0, 0, 0, 0};
static const num x0[] = {1, -2}, P0[] = {2, 0.5, 0.5, 1};
static num r[3], z_value[3];
static const word *z;

/* How near to the full sensor's an ordinary measurement is, and one that is taken in stages; the share of S below which
   there are stages; a noise far below; measurements that a lean filter is behind after an outage */
#ifdef KQ_TEST_Q31
#define LITTLE 0x1p-20
#define IN_STAGES 0x1p-14
#define SHARE 0x1p-16
#define SHARP 0x1p-40
#else
#define LITTLE 0
#define IN_STAGES (EPS > 1e-10 ? 0x1p-10 : 0x1p-26)
#define SHARE (EPS > 1e-10 ? 0x1p-16 : 0x1p-48)
#define SHARP (EPS * EPS)
#endif

/* The event of a sharp one that takes a state as it is: a mean of two floats or in words has the digits, a double has not. */
#if defined(KQ_TEST_F64) && !defined(KQ_TEST_Q31)
#define ROUNDED KQ_EVENT_PRECISION
#else
#define ROUNDED 0
#endif

static void put_sensors(const num *rows)
{
    put_independent(&full, 2, 3, range, measured_range, rows, r);
    put_independent(&lean, 2, 3, range, measured_range, rows, r);
    ASSERT_OK(init_lean(&lean, r));
}

static void begin(void)
{
    ASSERT_OK(init_filter(&track, &prior));
    ASSERT_OK(init_filter(&twin, &prior));
}

static void see(double a, double b, double c)
{
    z_value[0] = N(a), z_value[1] = N(b), z_value[2] = N(c);
    z = measured(&lean.sensor, z_value);
}

static void draw(uint32_t *seed)
{
    const num a = noise(seed), b = noise(seed), c = noise(seed);
    see((double)a, (double)b, (double)c);
}

static void set_up(void)
{
    r[0] = N(0.5), r[1] = 1, r[2] = 2;
    put_process(&motion, 2, 0, range, NULL, A, NULL, Q);
    put_prior(&prior, 2, range, x0, P0);
    put_prior(&known, 2, range, x0, none);
    put_sensors(H);
    see(3, 1, -1);
    begin();
    ASSERT_OK(S(history_assign)(&tape, 2, tape_memory, COUNT(tape_memory)));
    ASSERT_OK(S(history_assign)(&other, 2, other_memory, COUNT(other_memory)));
    watch_nothing();
    WATCH(lean), WATCH(track), WATCH(track_memory);
}

/* Component 0 without noise, or as good as without */
static void sharpen(double noise_now)
{
    r[0] = N(noise_now);
    put_sensors(H);
}

/* H_0 P H_0' of the prior */
static double variance_of_first(void) { return (double)P0[0]; }

static void predict_both(void)
{
    ASSERT_OK(S(predict)(&track, &motion.process, NULL));
    ASSERT_OK(S(predict)(&twin, &motion.process, NULL));
}

static void update_both(uint32_t present)
{
    ASSERT_OK(S(update_subset)(&track, &full.sensor, z, present));
    ASSERT_OK(S(update_subset)(&twin, &lean.sensor, z, present));
}

/* Alike up to so much of sigma and mean */
static void assert_near(double tolerance, const reading *a, const reading *b)
{
    for (int i = 0; i < 2; i++) {
        const double sigma = sqrt((double)a->P[3 * i]);
        ASSERT_WITHIN(tolerance * (sigma + fabs(whole(a, i))), whole(a, i), whole(b, i));
        for (int j = 0; j < 2; j++) {
            ASSERT_WITHIN(tolerance * sigma * sqrt((double)a->P[3 * j]), a->P[2 * i + j], b->P[2 * i + j]);
        }
    }
}

/* The filter of the lean sensor is that of the full one, up to so much; 0: bit for bit. */
static void assert_as_full(double tolerance)
{
    reading a, b;
    read_now(&a, &track, 2);
    read_now(&b, &twin, 2);
    assert_near(tolerance, &a, &b);
    if (tolerance == 0) TEST_ASSERT_EQUAL_MEMORY(track_memory, twin_memory, sizeof track_memory);
}

static void assert_same_smoothed(double tolerance)
{
    reading a, b;
    ASSERT_OK(S(smooth)(&tape));
    ASSERT_OK(S(smooth)(&other));
    for (size_t t = 0; t < S(history_steps)(&tape); t++) {
        read_smoothed_at(&a, &tape, t, &prior, 2);
        read_smoothed_at(&b, &other, t, &prior, 2);
        for (int i = 0; i < 2; i++) {
            ASSERT_WITHIN(tolerance * (double)a.sigma[i], a.mean[i], b.mean[i]);
            ASSERT_WITHIN(tolerance * (double)a.sigma[i], a.sigma[i], b.sigma[i]);
        }
    }
}

TEST(what_is_not_sharp_is_taken_as_ever)
{
    for (uint32_t seed = 1; seed <= 20; seed++) {
        uint32_t state = seed;
        set_up();
        ASSERT_OK(S(attach)(&track, &tape.attached));
        ASSERT_OK(S(attach)(&twin, &other.attached));
        for (int t = 0; t < STEPS; t++) {
            draw(&state);
            ASSERT_OK(S(step)(&track, &motion.process, NULL, &full.sensor, z));
            ASSERT_OK(S(step)(&twin, &motion.process, NULL, &lean.sensor, z));
            assert_as_full(0);
            TEST_ASSERT_TRUE(S(nis)(&track) == S(nis)(&twin));
            TEST_ASSERT_EQUAL_INT(3, S(taken)(&twin));
            TEST_ASSERT_TRUE(S(log_likelihood_last)(&track) == S(log_likelihood_last)(&twin));
            update_both(1 + seed % 7);
            assert_as_full(0);
        }
        TEST_ASSERT_EQUAL_UINT(0, S(events)(&twin));
        TEST_ASSERT_TRUE(S(log_likelihood)(&twin) == 0);
        assert_same_smoothed(0);
    }
}

/* At every step, up to 2^-14 of S */
TEST(what_is_a_little_sharp_is_taken)
{
    for (int k = 8; k <= 14; k++) {
        for (int c = 0; c < 3; c++) r[c] = N(ldexp(1, -k));
        put_sensors(H);
        for (uint32_t seed = 1; seed <= 20; seed++) {
            uint32_t state = seed;
            begin();
            for (int t = 0; t < STEPS; t++) {
                draw(&state);
                update_both(3);
                assert_as_full(LITTLE);
                predict_both();
            }
            TEST_ASSERT_EQUAL_UINT(0, S(events)(&twin));
        }
    }
}

/* One that is sharp is taken whole, and so are the others; without any noise it is taken as far as stages go. */
TEST(what_is_sharp_is_taken_in_stages)
{
    static const double noises[] = {0.5 * SHARE, SHARE * SHARE, SHARP, 0};
    for (int k = 0; k < COUNT(noises); k++) {
        describe("noise", "", k, "", 0);
        begin();
        sharpen(noises[k] * variance_of_first());
        update_both(7);
        if (noises[k] > 0) assert_as_full(IN_STAGES);
        ASSERT_WITHIN(IN_STAGES * 64, score_number(S(nis)(&track)), score_number(S(nis)(&twin)));
        TEST_ASSERT_EQUAL_INT(3, S(taken)(&twin));
        const unsigned rounded = k > 0 ? ROUNDED : 0; /* SHARE^2 asks for more digits than a double has */
        TEST_ASSERT_EQUAL_UINT_MESSAGE(noises[k] > 0 ? rounded : KQ_EVENT_LOW_NOISE, S(events)(&twin), description());
        TEST_ASSERT_TRUE(word_value(&prior, S(sigma)(&twin, 0), 0) <= sqrt(noises[k] * variance_of_first()) * 1.01 + sigma_step(range[0]) + 8 * SHARE * SHARE);
    }
}

/* Nothing is known, and nothing is left to know. */
TEST(a_variance_of_0)
{
    sharpen(0);
    ASSERT_OK(init_filter(&track, &known));
    ASSERT_OK(init_filter(&twin, &known));
    ASSERT_OK(S(update)(&twin, &lean.sensor, z));
    TEST_ASSERT_EQUAL_UINT(KQ_EVENT_LOW_NOISE, S(events)(&twin));
    for (int i = 0; i < 2; i++) TEST_ASSERT_TRUE(S(mean)(&track, i) == S(mean)(&twin, i));
}

/* At the same instant, and at every one: another sensor's noise-free measurement shuts nothing out. */
TEST(after_a_sharp_one)
{
    static const num one[] = {1};
    put_independent(&sharp, 2, 1, range, measured_range, first_row, none);
    for (int t = 0; t < STEPS; t++) {
        const word *at_one = measured(&sharp.sensor, one);
        ASSERT_OK(S(update)(&track, &sharp.sensor, at_one));
        ASSERT_OK(S(update)(&twin, &sharp.sensor, at_one));
        see(3, 1, -1);
        update_both(7);
        TEST_ASSERT_EQUAL_INT(3, S(taken)(&twin));
        reading a, b;
        read_now(&a, &track, 2);
        read_now(&b, &twin, 2);
        for (int i = 0; i < 2; i++) {
            ASSERT_ALIKE(whole(&a, i), whole(&b, i), 1);
            ASSERT_ALIKE(a.sigma[i], b.sigma[i], 1);
        }
        predict_both();
    }
    TEST_ASSERT_EQUAL_UINT(0, S(events)(&twin));
}

/* The history has the noise that was given, once. */
TEST(the_given_noise_is_recorded)
{
    ASSERT_OK(S(attach)(&track, &tape.attached));
    ASSERT_OK(S(attach)(&twin, &other.attached));
    for (int t = 0; t < STEPS; t++) {
        sharpen(t % 4 ? 1 : SHARE / 64 * variance_of_first());
        update_both(7);
        predict_both();
    }
    TEST_ASSERT_EQUAL_UINT(0, S(events)(&twin));
    assert_same_smoothed(64 * IN_STAGES);
}

/* ------------------------------------------------------------------ with all that goes with a filter */

/* One component of low noise at every fourth step */
static void take_both(int t, uint32_t *seed)
{
    sharpen(t % 4 ? 1 : SHARE / 64 * variance_of_first());
    draw(seed);
    update_both(7);
}

static void assert_shown_near(const S(filter) *a, const S(filter) *b)
{
    reading of_full, of_lean;
    read_shown(&of_full, a, &prior, 2);
    read_shown(&of_lean, b, &prior, 2);
    assert_near(64 * IN_STAGES, &of_full, &of_lean);
}

/* NIS and likelihood are those of the noise as given. */
TEST(the_given_noise_is_scored)
{
    static const double noises[] = {1, 0.5 * SHARE, SHARE / 64, SHARE * SHARE, SHARP};
    uint32_t seed = 1;
    for (int k = 0; k < COUNT(noises); k++) {
        for (int both = 0; both < 2; both++) {
            describe("noise", "", k, "", 0);
            begin();
            r[both] = N(noises[k] * variance_of_first());
            sharpen(noises[k] * variance_of_first());
            draw(&seed);
            update_both(7);
            const double nis = score_number(S(nis)(&track)), log_likelihood = score_number(S(log_likelihood_last)(&track));
            ASSERT_WITHIN(1e-3 * (1 + nis), nis, score_number(S(nis)(&twin)));
            ASSERT_WITHIN(1e-3 * (1 + fabs(log_likelihood)), log_likelihood, score_number(S(log_likelihood_last)(&twin)));
            r[both] = 1;
        }
    }
}

TEST(on_line_they_are_smoothed_alike)
{
    static S(filter) shown, shown_lean;
    uint32_t seed = 1;
    for (int is_lag = 0; is_lag < 2; is_lag++) {
        begin();
        ASSERT_OK(S(lag_assign)(&past, 2, 6, LAST, past_memory, COUNT(past_memory)));
        ASSERT_OK(S(lag_assign)(&past_lean, 2, 6, LAST, past_lean_memory, COUNT(past_lean_memory)));
        ASSERT_OK(S(attach)(&track, is_lag ? &past.attached : &instant.attached));
        ASSERT_OK(S(attach)(&twin, is_lag ? &past_lean.attached : &instant_lean.attached));
        for (int t = 0; t < STEPS; t++) {
            take_both(t, &seed);
            for (size_t k = 0; is_lag && k <= S(lag_steps)(&past); k++) {
                ASSERT_OK(S(lagged)(&past, k, &shown));
                ASSERT_OK(S(lagged)(&past_lean, k, &shown_lean));
                assert_shown_near(&shown, &shown_lean);
            }
            if (!is_lag) ASSERT_OK(S(instant_smooth)(&instant, &shown));
            if (!is_lag) ASSERT_OK(S(instant_smooth)(&instant_lean, &shown_lean));
            assert_shown_near(&shown, &shown_lean);
            predict_both();
        }
        TEST_ASSERT_EQUAL_UINT(0, S(events)(&twin));
    }
}

/* Component 0 comes late. */
TEST(late_measurements_are_taken)
{
    uint32_t seed = 1;
    ASSERT_OK(S(delay_assign)(&past, 2, 6, LAST, past_memory, COUNT(past_memory)));
    ASSERT_OK(S(delay_assign)(&past_lean, 2, 6, LAST, past_lean_memory, COUNT(past_lean_memory)));
    ASSERT_OK(S(attach)(&track, &past.attached));
    ASSERT_OK(S(attach)(&twin, &past_lean.attached));
    for (int t = 0; t < STEPS; t++) {
        sharpen(t % 4 ? 1 : SHARE / 64 * variance_of_first());
        draw(&seed);
        update_both(6);
        const size_t late = S(lag_steps)(&past) / 2;
        ASSERT_OK(S(update_delayed)(&past, late, &full.sensor, z, 1));
        ASSERT_OK(S(update_delayed)(&past_lean, late, &lean.sensor, z, 1));
        assert_as_full(64 * IN_STAGES);
        predict_both();
    }
    TEST_ASSERT_EQUAL_UINT(0, S(events)(&twin));
}

/* With other noises of the process */
TEST(they_are_smoothed_alike_with_weights)
{
    static process_model scaled;
    static entry q[2][STEPS];
    uint32_t seed = 1;
    put_process(&scaled, 2, 0, range, NULL, A, NULL, Q);
    ASSERT_OK(S(attach)(&track, &tape.attached));
    ASSERT_OK(S(attach)(&twin, &other.attached));
    for (int t = 0; t < STEPS; t++) {
        take_both(t, &seed);
        predict_both();
        q[0][t] = q[1][t] = number(1 + 0.25 * (t % 3));
    }
    ASSERT_OK(smooth_reweighted(&tape, &scaled, &motion, number(4), q[0]));
    ASSERT_OK(smooth_reweighted(&other, &scaled, &motion, number(4), q[1]));
    for (size_t t = 0; t < STEPS; t++) {
        reading a, b;
        read_smoothed_at(&a, &tape, t, &prior, 2);
        read_smoothed_at(&b, &other, t, &prior, 2);
        assert_near(64 * IN_STAGES, &a, &b);
        ASSERT_WITHIN(64 * IN_STAGES * number_of(q[0][t]), number_of(q[0][t]), number_of(q[1][t]));
    }
}

/* A gain is that of an ordinary sensor, and so is a frozen step. */
TEST(gains_are_those_of_a_full_sensor)
{
    static const double noises[] = {1, SHARE / 64, 0};
    num gain[6], gain_of_lean[6];
    for (int k = 0; k < COUNT(noises); k++) {
        sharpen(noises[k]);
        begin();
        ASSERT_OK(read_gain(&track, &full.sensor, gain));
        ASSERT_OK(read_gain(&twin, &lean.sensor, gain_of_lean));
        TEST_ASSERT_EQUAL_MEMORY(gain, gain_of_lean, sizeof gain);
    }
}

TEST(a_frozen_filter_takes_it)
{
    uint32_t seed = 1;
    sharpen(SHARE / 64);
    ASSERT_OK(S(freeze_init)(&lazy, 8));
    ASSERT_OK(S(freeze_init)(&lazy_lean, 8));
    ASSERT_OK(S(attach)(&track, &lazy.attached));
    ASSERT_OK(S(attach)(&twin, &lazy_lean.attached));
    for (int t = 0; t < AFTER; t++) {
        reading a, b;
        draw(&seed);
        ASSERT_OK(S(step)(&track, &motion.process, NULL, &full.sensor, z));
        ASSERT_OK(S(step)(&twin, &motion.process, NULL, &lean.sensor, z));
        read_now(&a, &track, 2);
        read_now(&b, &twin, 2);
        for (int i = 0; i < 2; i++) {
            const double frozen_apart = 0.01 * (double)a.sigma[i]; /* not at the same step */
            ASSERT_WITHIN(64 * IN_STAGES * (fabs(whole(&a, i)) + (double)a.sigma[i]) + frozen_apart, whole(&a, i), whole(&b, i));
        }
    }
    TEST_ASSERT_EQUAL_INT(1, S(freeze_is_active)(&lazy_lean));
}

/* While a state is unknown it is an ordinary sensor. */
TEST(an_unknown_start_takes_it)
{
    uint32_t seed = 1;
    for (uint32_t unknown = 1; unknown < 4; unknown++) {
        ASSERT_OK(init_start(&start, &track, &prior, unknown));
        ASSERT_OK(init_start(&start_lean, &twin, &prior, unknown));
        for (int t = 0; t < STEPS; t++) {
            take_both(t, &seed);
            assert_as_full(64 * IN_STAGES);
            predict_both();
        }
    }
}

/* Sensors that take innovations */
TEST(innovations_are_taken)
{
    uint32_t seed = 1;
    for (int t = 0; t < STEPS; t++) {
        sharpen(t % 4 ? 1 : SHARE / 64 * variance_of_first());
        draw(&seed);
        ASSERT_OK(S(update)(&track, of_innovations(&full), z));
        ASSERT_OK(S(update)(&twin, lean_of_innovations(&lean, r), z));
        assert_as_full(64 * IN_STAGES);
        predict_both();
    }
    TEST_ASSERT_EQUAL_UINT(0, S(events)(&twin));
}

/* The robust updates bring the careful path along. */
TEST(robust_updates_take_it)
{
    const S(loss) losses[] = {{.kind = &S(loss_gate)}, {.kind = &S(loss_huber)}, {.kind = &S(loss_student)}, {.kind = &S(loss_jump)}};
    static const double noises[] = {SHARE / 64, SHARP, 0};
    for (int k = 0; k < COUNT(losses) * COUNT(noises); k++) {
        S(loss) loss = losses[k / COUNT(noises)];
        loss.parameter = number(2), loss.limit = score_of(1000);
        S(loss) same = loss;
        sharpen(noises[k % COUNT(noises)]);
        begin();
        ASSERT_OK(S(update_robust)(&track, &full.sensor, z, 7, &loss));
        ASSERT_OK(S(update_robust)(&twin, &lean.sensor, z, 7, &same));
        ASSERT_SAME(&track, &twin, 2);
    }
}

/* What is learnt from is taken: by a lean sensor, too. */
TEST(an_adaptation_takes_it)
{
    const S(adaptation_rule) rule = usual_rule();
    uint32_t seed = 1;
    r[1] = N(SHARP);
    put_sensors(H);
    ASSERT_OK(S(adaptation_init)(&taught, &motion.process, &full.sensor, &rule));
    ASSERT_OK(S(attach)(&track, &taught.attached));
    ASSERT_OK(S(adaptation_init)(&taught_lean, &motion.process, &lean.sensor, &rule));
    ASSERT_OK(S(attach)(&twin, &taught_lean.attached));
    for (int t = 0; t < STEPS; t++) {
        draw(&seed);
        predict_both();
        update_both(7);
        ASSERT_SAME(&track, &twin, 2);
    }
}

/*
 * The law: after an outage of any length a lean filter is no more than n measurements behind the full one: what it knows
 * so many later is within 2 %.  Chains of n integrators, of which the last sum is measured.
 */
static double sigma_of_full[AFTER][CHAIN_MAX], sigma_of_lean[AFTER][CHAIN_MAX];

static int is_late_by(int late, int n)
{
    for (int t = late; t < AFTER; t++) {
        for (int i = 0; i < n; i++) {
            if (!(sigma_of_lean[t][i] <= 1.02 * sigma_of_full[t - late][i] + 2 * sigma_step(100))) return 0;
        }
    }
    return 1;
}

static void assert_comes_back(int n, int32_t outage, double noise_now)
{
    static const num wide[] = {100, 100, 100, 100}, mean[CHAIN_MAX] = {0}, row[CHAIN_MAX] = {1}, one[] = {1};
    static word full_memory[S_FILTER_LEN(CHAIN_MAX)], lean_memory[S_FILTER_LEN(CHAIN_MAX)];
    S(filter) full_track, lean_track;
    num A_n[CHAIN_MAX * CHAIN_MAX] = {0}, Q_n[CHAIN_MAX * CHAIN_MAX] = {0}, P_n[CHAIN_MAX * CHAIN_MAX] = {0};
    prior_model start;
    for (int i = 0; i < n; i++) {
        A_n[i * n + i] = P_n[i * n + i] = 1;
        Q_n[i * n + i] = N(0.01);
        if (i + 1 < n) A_n[i * n + i + 1] = N(0.5);
    }
    r[0] = N(noise_now);
    put_process(&motion, n, 0, wide, NULL, A_n, NULL, Q_n);
    put_independent(&full, n, 1, wide, wide, row, r);
    put_independent(&lean, n, 1, wide, wide, row, r);
    ASSERT_OK(init_lean(&lean, r));
    put_prior(&start, n, wide, mean, P_n);
    ASSERT_OK(S(filter_assign)(&full_track, n, full_memory, COUNT(full_memory)));
    ASSERT_OK(S(filter_assign)(&lean_track, n, lean_memory, COUNT(lean_memory)));
    ASSERT_OK(init_filter(&full_track, &start));
    ASSERT_OK(init_filter(&lean_track, &start));
    for (int32_t t = 0; t < outage; t++) {
        ASSERT_OK(S(predict)(&full_track, &motion.process, NULL));
        ASSERT_OK(S(predict)(&lean_track, &motion.process, NULL));
    }
    const word *seen = measured(&full.sensor, one);
    for (int t = 0; t < AFTER; t++) {
        ASSERT_OK(S(step)(&full_track, &motion.process, NULL, &full.sensor, seen));
        ASSERT_OK(S(step)(&lean_track, &motion.process, NULL, &lean.sensor, seen));
        if (t + 1 == AFTER) TEST_ASSERT_EQUAL_INT(1, S(taken)(&lean_track));
        for (int i = 0; i < n; i++) {
            sigma_of_full[t][i] = word_value(&start, S(sigma)(&full_track, i), i);
            sigma_of_lean[t][i] = word_value(&start, S(sigma)(&lean_track, i), i);
        }
    }
    int late = 0;
    while (late < AFTER && !is_late_by(late, n)) late++;
    TEST_ASSERT_TRUE(late <= n);
    S(events_clear)(&lean_track);
    ASSERT_OK(S(step)(&lean_track, &motion.process, NULL, &lean.sensor, seen));
    TEST_ASSERT_EQUAL_UINT(0, S(events)(&lean_track)); /* it is no longer raised */
}

TEST(after_any_outage_it_comes_back)
{
    static const double noises[] = {1, 0.01, 1e-4};
    for (int n = 1; n <= CHAIN_MAX; n++) {
        const int32_t outages[] = {10, 100, n == 2 ? 10000 : 3000};
        for (int k = 0; k < COUNT(outages); k++) {
            for (int j = 0; j < COUNT(noises); j++) assert_comes_back(n, outages[k], noises[j]);
        }
    }
}

#ifdef KQ_TEST_Q31
TEST_Q31(a_correlated_noise_is_refused)
{
    static const num R[] = {1, 0.5, 0.25, 0.5, 1, 0, 0.25, 0, 1};
    put_sensor(&full, 2, 3, range, measured_range, H, R);
    ASSERT_REFUSED(KQ_ERR_TABLE, kq_sensor_init_lean_q31(&lean.sensor, &full.table, NULL));
}

/* The second component brings back what the first one moves beyond the word: nothing is saturated between them, nor
   between stages. */
TEST_Q31(no_mean_is_held_within_an_update)
{
    static const num rows[] = {1, 1, 1, -1, 0, 1}, wide_P0[] = {400, 0, 0, 400}, far[] = {80, 0}, wide[] = {200, 200, 200};
    static const double noises[] = {1, 0.01, SHARE};
    for (int k = 0; k < COUNT(noises); k++) {
        for (int c = 0; c < 3; c++) r[c] = noises[k];
        put_prior(&prior, 2, range, far, wide_P0);
        put_independent(&full, 2, 3, range, wide, rows, r);
        put_independent(&lean, 2, 3, range, wide, rows, r);
        ASSERT_OK(init_lean(&lean, r));
        begin();
        see(116, 96, 1); /* the state is 106, 10: after the first component 98, 18, beyond 16 */
        update_both(3);
        TEST_ASSERT_EQUAL_UINT(0, S(events)(&track));
        TEST_ASSERT_EQUAL_UINT(0, S(events)(&twin));
        assert_as_full(IN_STAGES);
    }
}

/* Of sigmas far beyond the words, too */
TEST_Q31(twelve_measurements_after_an_outage_they_agree)
{
    static const int32_t outages[] = {10, 100, 10000};
    static const double noises[] = {1, 0.01, 1e-4};
    for (int k = 0; k < COUNT(outages); k++) {
        for (int j = 0; j < COUNT(noises); j++) {
            for (int c = 0; c < 3; c++) r[c] = noises[j];
            put_sensors(H);
            begin();
            for (int32_t t = 0; t < outages[k]; t++) predict_both();
            for (int t = 0; t < 12; t++) {
                ASSERT_OK(S(step)(&twin, &motion.process, NULL, &lean.sensor, z));
                ASSERT_OK(S(step)(&track, &motion.process, NULL, &full.sensor, z));
            }
            for (int i = 0; i < 2; i++) {
                ASSERT_WITHIN(0.02 * S(sigma)(&track, i) + 2, S(sigma)(&track, i), S(sigma)(&twin, i));
            }
        }
    }
}
#endif

/* ------------------------------------------------------------------ constant tables */

/* The root of Q by columns */
static const num table_A[] = {1, 0.5, 0, 1}, table_Q[] = {0.3125, 0.125, 0.125, 0.25};
static const num table_H[] = {1, 0, 0.5, 1, 0, 1};

#ifdef KQ_TEST_Q31
#define PROCESS_OF(...) KQ_PROCESS_TABLE_Q31(2, 0, motion.state_format, NULL, motion.transition, NULL, __VA_ARGS__)
#define SENSOR_OF(T, s, ...) \
    KQ_SENSOR_##T##TABLE_Q31(2, 3, s.state_format, s.measurement_format, s.measurement, __VA_ARGS__)
#define ROOT motion.noise_root
#define NOISE lean.noise
#define CONST_LIKE 0x1p-24
#else
#define PROCESS_OF(...) KQ_PROCESS_TABLE(2, 0, table_A, NULL, __VA_ARGS__)
#define SENSOR_OF(T, s, ...) SENSOR_##T##TABLE(2, 3, table_H, __VA_ARGS__)
static const num table_G[] = {0.5, 0.25, 0.5};
#define ROOT table_G
#define NOISE r
#define CONST_LIKE TOLERANCE
#endif

static void run_tables(const S(process) *p, const S(sensor) *s)
{
    uint32_t seed = 1;
    begin();
    for (int t = 0; t < STEPS; t++) {
        draw(&seed);
        ASSERT_OK(S(step)(&track, &motion.process, NULL, &full.sensor, z));
        ASSERT_OK(S(step)(&twin, p, NULL, s, z));
        assert_as_full(CONST_LIKE);
    }
    TEST_ASSERT_EQUAL_UINT(0, S(events)(&twin));
}

/* As constants' initialisers: A and H are taken for dense, or with what is known of their zeros */
TEST(const_tables)
{
    put_process(&motion, 2, 0, range, NULL, table_A, NULL, table_Q);
    put_sensors(table_H);
    const S(process) table = PROCESS_OF(ROOT), table_of_zeros = PROCESS_OF(ROOT, (0, 1));
    const S(sensor) lean_table = SENSOR_OF(LEAN_, lean, NOISE), full_table = SENSOR_OF(, full, NOISE);
    const S(sensor) lean_of_zeros = SENSOR_OF(LEAN_, lean, NOISE, (1, 0, 2)),
                    full_of_zeros = SENSOR_OF(, full, NOISE, (1, 0, 2));
    TEST_ASSERT_EQUAL_MEMORY(motion.process.first, table_of_zeros.first, sizeof table_of_zeros.first);
    TEST_ASSERT_EQUAL_MEMORY(lean.sensor.selects, lean_of_zeros.selects, sizeof lean_of_zeros.selects);
    TEST_ASSERT_EQUAL_MEMORY(lean.sensor.selects, full_of_zeros.selects, sizeof full_of_zeros.selects);
    run_tables(&table, &full_table);
    TEST_ASSERT_TRUE(S(log_likelihood)(&twin) != 0);
    run_tables(&table_of_zeros, &full_of_zeros);
    run_tables(&table, &lean_table);
    TEST_ASSERT_TRUE(S(log_likelihood)(&twin) == 0);
    run_tables(&table_of_zeros, &lean_of_zeros);
}

#ifndef KQ_TEST_Q31

/* Where what rounding makes of h'P h is no number any more, too */
TEST_FLOAT(a_component_is_scored_once)
{
    const num tiny = N(EPS > 1e-10 ? 1e-36 : 1e-300), little[] = {tiny, 0, 0, tiny};
    put_prior(&known, 2, range, x0, little);
    sharpen(0);
    ASSERT_OK(init_filter(&twin, &known));
    ASSERT_OK(S(update)(&twin, &lean.sensor, z));
    TEST_ASSERT_EQUAL_INT(3, S(taken)(&twin));
    ASSERT_OK(S(filter_check)(&twin));
}

/* A stage's noise is a ratio: no product of S and R needs to be a number. */
TEST_FLOAT(no_product_is_beyond_the_numbers)
{
    static const num two_gauges[] = {1, N(0.5)};
    const int high = EPS > 1e-10 ? 50 : 400;
    for (int noise = high - 30; noise <= high + 20; noise += 10) {
        const num wide = N(ldexp(1, 2 * high)), far_away[] = {wide, 0, 0, wide}, noise_now[] = {N(ldexp(1, noise))};
        z_value[0] = N(ldexp(1, high - 1));
        put_prior(&known, 2, range, none, far_away);
        put_independent(&sharp, 2, 1, range, measured_range, two_gauges, noise_now);
        ASSERT_OK(init_filter(&track, &known));
        ASSERT_OK(S(update)(&track, &sharp.sensor, z_value));
        ASSERT_OK(init_lean(&sharp, noise_now));
        ASSERT_OK(init_filter(&twin, &known));
        ASSERT_OK(S(update)(&twin, &sharp.sensor, z_value));
        ASSERT_OK(S(filter_check)(&twin));
        assert_as_full(IN_STAGES);
    }
}

/* H x has fewer digits than R asks for: the first update says so. */
TEST_FLOAT(what_rounds_more_than_its_noise_is_told)
{
    static const num dense[] = {N(1.1), N(0.3)};
    for (int is_lean = 0; is_lean < 2; is_lean++) {
        for (int is_little = 0; is_little < 2; is_little++) {
            const double digits = is_little ? 64 : 1 / 64.0;
            const num noise_now[] = {N(4 * digits * EPS * digits * EPS)};
            z_value[0] = 1;
            put_independent(&sharp, 2, 1, range, measured_range, dense, noise_now);
            if (is_lean) ASSERT_OK(init_lean(&sharp, noise_now));
            ASSERT_OK(init_filter(&track, &prior));
            ASSERT_OK(S(update)(&track, &sharp.sensor, z_value));
            TEST_ASSERT_EQUAL_UINT(is_little ? 0 : KQ_EVENT_PRECISION, S(events)(&track) & KQ_EVENT_PRECISION);
        }
    }
}

TEST_FLOAT(beyond_the_numbers)
{
    z_value[1] = NUM_MAX;
    ASSERT_OK(S(update)(&twin, &lean.sensor, z_value));
    TEST_ASSERT_EQUAL_UINT(KQ_EVENT_OVERFLOW, S(events)(&twin));
    z_value[1] = 0;
    ASSERT_OK(S(update_subset)(&track, &full.sensor, z_value, 5));
    assert_as_full(0);
}

/* Far more bits from the prediction than a number has */
TEST_FLOAT(what_is_far_off_is_found_again)
{
    static const num noise_now[] = {0.0625};
    static const num correlated_P0[] = {1, 0.5, 0.5, 1};
    for (int power = 20; power < 100; power += 8) {
        num wide_P0[4], start[2];
        for (int k = 0; k < 4; k++) wide_P0[k] = correlated_P0[k] * N(ldexp(1, power));
        for (int k = 0; k < 2; k++) start[k] = N(ldexp(1.2345678, power / 2));
        const num near_by[] = {7};
        put_independent(&sharp, 2, 1, range, measured_range, first_row, noise_now);
        ASSERT_OK(S(filter_init)(&track, start, wide_P0));
        ASSERT_OK(S(update)(&track, &sharp.sensor, near_by));
        ASSERT_WITHIN(0.01, 7, S(mean)(&track, 0));
        TEST_ASSERT_EQUAL_UINT(0, S(events)(&track));
        /* 2^13 sigma off */
        for (int k = 0; k < 2; k++) start[k] *= 8192;
        ASSERT_OK(S(filter_init)(&track, start, wide_P0));
        const double rest = (double)start[0] * 0.0625 / ((double)wide_P0[0] + 0.0625);
        ASSERT_OK(S(update)(&track, &sharp.sensor, near_by));
        ASSERT_WITHIN(0.01, 7 + rest, S(mean)(&track, 0));
    }
}

TEST_FLOAT(what_contradicts_is_told)
{
    static const num noise_now[] = {SHARP};
    const num away[] = {EPS > 1e-10 ? N(1e5) : N(1e9)};
    put_independent(&sharp, 2, 1, range, measured_range, first_row, noise_now);
    ASSERT_OK(S(update)(&track, &sharp.sensor, away));
    TEST_ASSERT_EQUAL_UINT(KQ_EVENT_CONTRADICTION | ROUNDED, S(events)(&track));
}
#endif

SUITE(lean, set_up)
#include "lean.tests"
