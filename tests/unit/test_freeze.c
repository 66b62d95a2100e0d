/* The filter of gains that are given, and the one that freezes its gain once it is steady; the equation of the steady
   state is test_steady.c's. */
#include "models.h"
#include "unchanged.h"

enum { N = 2, M = 2, GAINS = 30, RUN = 200 };

#ifdef KQ_TEST_Q31
#define BITS 14
#define BITS_MAX KQ_FREEZE_BITS_MAX_Q31
#define SETTLES_WITHIN 60
#define ROUNDING_OF_STEPS 2e-6 /* half a word of z and of u, and coefficients of 31 bits */
#else
#define BITS 12
#define BITS_MAX (sizeof(num) == sizeof(float) ? KQ_FREEZE_BITS_MAX_F32 : KQ_FREEZE_BITS_MAX_F64)
#define SETTLES_WITHIN 30
#define ROUNDING_OF_STEPS (256 * EPS)
#endif
#define SETTLED ldexp(1, -BITS)

static process_model motion;
static sensor_model radar;
static prior_model prior;
S_FILTER(track, N);
S_FILTER(other, N);
S_HISTORY(tape, N, M, RUN, 0);
S_STEADY(steady, N, M);
S_STEADY(blank_steady, N, M);
PROCESS(exact_motion, N, 1); /* what the equation is solved for */
SENSOR(exact_radar, N, M);
S_FREEZE(lazy, N, M);
S_FREEZE(blank_lazy, N, M);

static num A[] = {0.5, N(0.4), N(0.6), N(0.3)};
static const num B[] = {1, 0.5}, H[] = {1, 0, 0.5, 1}, x0[] = {1, -2};
static const num P0[] = {4, 1, 1, 3}, Q[] = {N(0.3), 0, 0, N(0.3)}, R[] = {0.5, 0.25, 0.25, 0.75};
static const num range[] = {100, 10, 100}, drive_range[] = {10}, measured_range[] = {200, 200};

static entry gains[GAINS * N * M], one_gain[N * M];
static word u[1], z[M];
static num exact_u[1], exact_z[M];
static uint32_t seed;

/* -1 .. 1 in steps that no rounding changes */
static num draw(void)
{
    seed = seed * 1664525 + 1013904223;
    return (num)((int)(seed >> 20) - 2048) / 2048;
}

static void draw_step(void)
{
    exact_u[0] = draw();
    memcpy(u, driven(&motion.process, exact_u, 1), sizeof u);
    for (int c = 0; c < M; c++) exact_z[c] = 3 * draw();
    memcpy(z, measured(&radar.sensor, exact_z), sizeof z);
}

static void put_motion(const num *noise_of) { put_process(&motion, N, 1, range, drive_range, A, B, noise_of); }

/* The gains of the first updates behind the prior */
static void make_gains(void)
{
    ASSERT_OK(init_filter(&other, &prior));
    for (int t = 0; t < GAINS; t++) {
        ASSERT_OK(S(gain)(&other, &radar.sensor, gains + t * N * M));
        ASSERT_OK(S(update)(&other, &radar.sensor, measured(&radar.sensor, x0)));
        ASSERT_OK(S(predict)(&other, &motion.process, NULL));
    }
}

static void set_up(void)
{
    A[0] = 0.5;
    seed = 1;
    put_motion(Q);
    put_sensor(&radar, N, M, range, measured_range, H, R);
    put_prior(&prior, N, range, x0, P0);
    ASSERT_OK(init_filter(&track, &prior));
    make_gains();
    ASSERT_OK(init_filter(&other, &prior));
    ASSERT_OK(S(steady_assign)(&steady, N, M, steady_memory, COUNT(steady_memory)));
    ASSERT_OK(S(steady_init)(&steady, &motion.process, &radar.sensor, prior.mean, gains, GAINS));
    ASSERT_OK(S(freeze_assign)(&lazy, N, M, lazy_memory, COUNT(lazy_memory), lazy_gain));
    ASSERT_OK(S(freeze_init)(&lazy, BITS));
    ASSERT_OK(S(attach)(&track, &lazy.attached));
    watch_nothing();
}

#ifdef KQ_TEST_Q31
static double mean_of_steady(int i)
{
    return word_value(&prior, kq_steady_mean_q31(&steady, i), i) +
           ldexp(word_value(&prior, kq_steady_mean_low_q31(&steady, i), i), -24);
}

static void put_gain(entry *to, const num *gain)
{
    ASSERT_OK(kq_matrix_prepare_q31(to, gain, N, M, motion.state_format, radar.measurement_format));
}

static void read_entries(num *to, const entry *gain)
{
    read_matrix(to, gain, N, M, motion.state_format, radar.measurement_format, -1);
}
#else
static double mean_of_steady(int i) { return (double)K(steady_mean)(&steady, i); }

static void put_gain(entry *to, const num *gain) { memcpy(to, gain, N * M * sizeof(num)); }

static void read_entries(num *to, const entry *gain) { memcpy(to, gain, N * M * sizeof(num)); }
#endif

/* The equation's gain */
static void solve(num *gain)
{
    static num work[SOLVE_LEN(N, M)];
    const K(steady_solution) out = {NULL, NULL, gain, NULL};
    ASSERT_OK(K(process_init)(&exact_motion, A, B, Q));
    ASSERT_OK(K(sensor_init)(&exact_radar, H, R));
    ASSERT_OK(K(steady_solve)(&exact_motion, &exact_radar, work, COUNT(work), &out));
}

/* ------------------------------------------------------------------ the filter */

TEST(the_gains_lead_to_the_steady_one)
{
    num gain[N * M], last[N * M];
    solve(gain);
    read_entries(last, gains + (GAINS - 1) * N * M);
    for (int k = 0; k < N * M; k++) ASSERT_WITHIN(0x1p-12, gain[k], last[k]);
}

/* The steady gain: the textbook with it */
TEST(one_gain_is_the_steady_filter)
{
    num gain[N * M];
    double x[] = {(double)x0[0], (double)x0[1]}, a[N * N], k[N * M];
    solve(gain);
    put_gain(one_gain, gain);
    ASSERT_OK(S(steady_init)(&steady, &motion.process, &radar.sensor, prior.mean, one_gain, 1));
    for (int i = 0; i < N * N; i++) a[i] = (double)A[i], k[i] = (double)gain[i];
    for (int t = 0; t < RUN; t++) {
        draw_step();
        const double push = (double)exact_u[0], first = (double)exact_z[0], second = (double)exact_z[1];
        const double b = a[0] * x[0] + a[1] * x[1] + push;
        const double c = a[2] * x[0] + a[3] * x[1] + push / 2;
        const double e[] = {first - b, second - b / 2 - c};
        x[0] = b + k[0] * e[0] + k[1] * e[1];
        x[1] = c + k[2] * e[0] + k[3] * e[1];
        ASSERT_OK(S(steady_step)(&steady, u, z));
        for (int i = 0; i < N; i++) ASSERT_WITHIN(ROUNDING_OF_STEPS, x[i], mean_of_steady(i));
    }
}

/* The mean is that of the full filter, up to the gain that has settled to 2^-BITS and to rounding */
TEST(the_scheduled_filter_is_the_full_one)
{
    for (int t = 0; t < RUN; t++) {
        draw_step();
        if (t > 0) {
            ASSERT_OK(S(predict)(&track, &motion.process, u));
            ASSERT_OK(S(steady_predict)(&steady, u));
        }
        ASSERT_OK(S(update)(&track, &radar.sensor, z));
        ASSERT_OK(S(steady_update)(&steady, z));
        const double gain_left = t < GAINS ? 0 : SETTLED / (1 - 0.7);
        for (int i = 0; i < N; i++) {
            ASSERT_WITHIN(6 * gain_left + ROUNDING_OF_STEPS, shown_mean(&track, &prior, i), mean_of_steady(i));
        }
    }
}

TEST(a_step_is_a_predict_and_an_update)
{
    static word memory[COUNT(steady_memory)];
    static S(steady) second;
    ASSERT_OK(S(steady_assign)(&second, N, M, memory, COUNT(memory)));
    ASSERT_OK(S(steady_init)(&second, &motion.process, &radar.sensor, prior.mean, gains, GAINS));
    for (int t = 0; t < RUN; t++) {
        draw_step();
        const word *const drive_of = t % 2 ? u : NULL;
        ASSERT_OK(S(steady_step)(&steady, drive_of, z));
        ASSERT_OK(S(steady_predict)(&second, drive_of));
        ASSERT_OK(S(steady_update)(&second, z));
        ASSERT_SAME_BITS(steady_memory, memory);
    }
}

TEST(the_innovation_is_that_of_the_mean)
{
    word e[M], same[M];
    draw_step();
    WATCH(steady), WATCH(steady_memory), WATCH(z);
    ASSERT_OK_UNCHANGED(S(steady_innovation)(&steady, z, e));
    for (int c = 0; c < M; c++) {
        const num *h = H + c * N;
        const double expected = (double)exact_z[c] - (double)h[0] * (double)x0[0] - (double)h[1] * (double)x0[1];
        ASSERT_WITHIN(ROUNDING_OF_STEPS, expected, measured_value(&radar.sensor, e[c], c));
    }
    memcpy(same, z, sizeof z);
    ASSERT_OK(S(steady_innovation)(&steady, same, same));
    ASSERT_SAME_BITS(e, same);
}

static kq_status begin(const entry *of, size_t count)
{
    return S(steady_init)(&steady, &motion.process, &radar.sensor, prior.mean, of, count);
}

#ifdef KQ_TEST_Q31
/* The mean is held at the ends of its word, and comes back. */
TEST_Q31(a_mean_that_leaves_its_word_is_held)
{
    static const double moving[] = {1, 0.125, 0, 1}, most[] = {10};
    ASSERT_OK(change_transition(&motion, N, moving));
    ASSERT_OK(begin(gains, GAINS));
    memcpy(u, driven(&motion.process, most, 1), sizeof u);
    for (int t = 0; t < 3000; t++) {
        ASSERT_OK(kq_steady_predict_q31(&steady, u));
        const int is_held = kq_steady_mean_q31(&steady, 0) == INT32_MAX || kq_steady_mean_q31(&steady, 1) == INT32_MAX;
        if (!is_held) TEST_ASSERT_EQUAL_HEX(0, kq_steady_events_q31(&steady));
    }
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_SATURATED, kq_steady_events_q31(&steady));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, kq_steady_mean_q31(&steady, 0));
    kq_steady_events_clear_q31(&steady);
    TEST_ASSERT_EQUAL_HEX(0, kq_steady_events_q31(&steady));
    for (int t = 0; t < 300; t++) {
        draw_step();
        ASSERT_OK(kq_steady_step_q31(&steady, NULL, z));
    }
    TEST_ASSERT_TRUE(fabs(mean_of_steady(0)) < 5);
    kq_steady_events_clear_q31(NULL);
    TEST_ASSERT_EQUAL_HEX(0, kq_steady_events_q31(NULL));
}

/* Nothing overflows. */
TEST_Q31(gains_of_any_size_are_taken)
{
    static const int32_t exponents[] = {-1000, -80, -31, -10, 0, 30, 60, 1000};
    for (int k = 0; k < COUNT(exponents); k++) {
        for (int i = 0; i < N * M; i++) one_gain[i] = (kq_scaled_q31){-INT32_MAX, exponents[k]};
        ASSERT_OK(begin(one_gain, 1));
        for (int t = 0; t < 20; t++) {
            draw_step();
            z[0] = t % 2 ? radar.measurement_format[0].range : -radar.measurement_format[0].range;
            ASSERT_OK(kq_steady_step_q31(&steady, u, z));
        }
    }
}

TEST_Q31(tables_that_are_wrong_are_refused)
{
    kq_scaled_q31 bad[N * M] = {{0, 0}, {0, 0}, {0, 0}, {1, 0}};
    WATCH(steady), WATCH(steady_memory);
    ASSERT_REFUSED(KQ_ERR_COEFFICIENT, begin(bad, 1));
    bad[3] = (kq_scaled_q31){INT32_MAX, 1001};
    ASSERT_REFUSED(KQ_ERR_COEFFICIENT, begin(bad, 1));
    ASSERT_REFUSED_WITH(prior.mean[0], prior.state_format[0].range + 1, KQ_ERR_RANGE, begin(gains, 1));
    ASSERT_REFUSED_WITH(radar.state_format[0].fraction, radar.state_format[0].fraction - 1, KQ_ERR_MISMATCH,
                        begin(gains, 1));
    ASSERT_OK(begin(gains, 1));
}
#else
static num first_mean[N];

static kq_status begin_at_first_mean(void)
{
    prior.mean = first_mean;
    return begin(gains, GAINS);
}

TEST_FLOAT(numbers_must_be_finite)
{
    memcpy(first_mean, x0, sizeof x0);
    assert_entries_must_be_finite(first_mean, N, begin_at_first_mean);
    assert_entries_must_be_finite(gains, GAINS * N * M, begin_at_first_mean);
}

static kq_status step(void) { return K(steady_step)(&steady, u, z); }

static kq_status predict(void) { return K(steady_predict)(&steady, u); }

static kq_status update(void) { return K(steady_update)(&steady, z); }

static num innovation[M];

static kq_status innovate(void) { return K(steady_innovation)(&steady, z, innovation); }

/* One diverges: the step that would take its mean beyond the numbers is refused, as each after it, with all its
   forms; so is one whose unmeasured state is there already. */
TEST_FLOAT(a_mean_beyond_the_numbers_is_refused)
{
    static const num growing[] = {4, 0, 0, 1}, no_gain[N * M] = {0}, far[] = {NUM_MAX, 1}, opposite[] = {-1, 0, 0, 1};
    draw_step();
    ASSERT_OK(change_transition(&motion, N, growing));
    ASSERT_OK(begin(no_gain, 1));
    kq_status status = KQ_OK;
    for (int k = 0; k < 2000 && !status; k++) {
        TEST_ASSERT_TRUE(isfinite(K(steady_mean)(&steady, 0)) && isfinite(K(steady_mean)(&steady, 1)));
        status = k % 2 ? step() : predict();
    }
    WATCH(steady), WATCH(steady_memory), WATCH(innovation);
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, step());
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, predict());
    prior.mean = far;
    ASSERT_OK(change_measurement(&radar, N, M, opposite));
    ASSERT_OK(begin(no_gain, 1));
    z[0] = NUM_MAX;
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, update());
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, innovate());
    steady_memory[0] = 0, steady_memory[1] = (num)NAN, z[0] = 1;
    ASSERT_OK(change_measurement(&radar, N, M, H));
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, step());
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, update());
    ASSERT_REFUSED(KQ_ERR_NOT_FINITE, innovate());
}
#endif

/* ------------------------------------------------------------------ a gain that is frozen */

static void freeze_steps(int count)
{
    for (int t = 0; t < count; t++) {
        draw_step();
        ASSERT_OK(S(step)(&track, &motion.process, u, &radar.sensor, z));
        ASSERT_OK(S(step)(&other, &motion.process, u, &radar.sensor, z));
    }
}

static void settle(void)
{
    freeze_steps(60);
    TEST_ASSERT_EQUAL_INT(1, S(freeze_is_active)(&lazy));
}

static void assert_next_step(int is_frozen, UNITY_LINE_TYPE line)
{
    freeze_steps(1);
    UNITY_TEST_ASSERT_EQUAL_INT(is_frozen, S(freeze_is_active)(&lazy), line, NULL);
}

#define ASSERT_NEXT_STEP(is_frozen) assert_next_step(is_frozen, __LINE__)

static void assert_near(UNITY_LINE_TYPE line)
{
    reading now, full;
    read_now(&now, &track, N);
    read_now(&full, &other, N);
    for (int i = 0; i < N; i++) {
        assert_within(8 * SETTLED / (1 - 0.5), whole(&full, i), whole(&now, i), line);
        assert_within(8 * SETTLED / (1 - 0.5), (double)full.P[3 * i], (double)now.P[3 * i], line);
    }
}

#define ASSERT_NEAR() assert_near(__LINE__)

TEST(it_settles_and_stays_near_the_full_filter)
{
    int began = 0;
    for (int t = 0; t < RUN; t++) {
        freeze_steps(1);
        if (!S(freeze_is_active)(&lazy)) TEST_ASSERT_EQUAL_INT(0, began);
        else if (!began) began = t;
        ASSERT_NEAR();
    }
    TEST_ASSERT_TRUE(began > 2 && began < SETTLES_WITHIN);
}

/* Until it has settled it is the full filter, bit for bit. */
TEST(before_that_it_is_the_full_filter)
{
    while (!S(freeze_is_active)(&lazy)) {
        ASSERT_SAME_BITS(track_memory, other_memory);
        freeze_steps(1);
    }
}

/* However far sigma is below the rounding of the state */
TEST(a_frozen_filter_that_is_sound_passes_its_check)
{
    static const double noises[] = {0, 1e-14, 1e-12, 1e-10, 1e-6};
    for (int k = 0; k < COUNT(noises); k++) {
        const num r[] = {(num)noises[k], (num)noises[k]};
        put_independent(&radar, N, M, range, measured_range, H, r);
        settle();
        for (int t = 0; t < RUN; t++) {
            ASSERT_NEXT_STEP(1);
            ASSERT_OK(S(filter_check)(&track));
        }
    }
}

TEST(the_root_rests_while_it_is_settled)
{
    settle();
    watch(track_memory + S_FILTER_LEN(N) - S_ROOT_LEN(N), S_ROOT_LEN(N) * sizeof(word));
    WATCH(track.last), WATCH(track.run);
    draw_step();
    ASSERT_OK_UNCHANGED(S(step)(&track, &motion.process, u, &radar.sensor, z));
}

TEST(a_missing_measurement_unsettles_it)
{
    settle();
    for (int t = 0; t < 3; t++) {
        draw_step();
        ASSERT_OK(S(predict)(&track, &motion.process, u));
        ASSERT_OK(S(predict)(&other, &motion.process, u));
        TEST_ASSERT_EQUAL_INT(0, S(freeze_is_active)(&lazy));
        ASSERT_NEAR();
    }
    freeze_steps(2);
    TEST_ASSERT_EQUAL_INT(0, S(freeze_is_active)(&lazy));
    ASSERT_NEAR();
    settle();
}

TEST(another_model_unsettles_it)
{
    static const num slow[] = {0.75, 0, 0, 0.5};
    settle();
    ASSERT_OK(change_transition(&motion, N, slow));
    ASSERT_NEXT_STEP(0);
    settle();
    ASSERT_NEAR();
    ASSERT_OK(change_measurement(&radar, N, M, slow));
    ASSERT_NEXT_STEP(0);
    settle();
    ASSERT_NEAR();
}

/* Another Q in the same object, another A in the same array: the process says so (its fingerprint). */
TEST(new_numbers_of_the_process_unsettle_it)
{
    static const num noisy[] = {3, 0, 0, 3};
    settle();
    put_motion(noisy);
    ASSERT_NEXT_STEP(0);
    settle();
    ASSERT_NEAR();
    A[0] = 0.75;
    ASSERT_OK(change_transition(&motion, N, A));
    ASSERT_NEXT_STEP(0);
    settle();
    put_motion(noisy); /* as it was */
    ASSERT_NEXT_STEP(1);
    ASSERT_NEAR();
}

/* A sensor has no fingerprint: new numbers in the same object and array are to be told. */
TEST(new_numbers_of_the_sensor_are_told_by_a_release)
{
    static const num noisy[] = {5, 0, 0, 5};
    settle();
    put_sensor(&radar, N, M, range, measured_range, H, noisy);
    ASSERT_NEXT_STEP(1);
    ASSERT_OK(S(freeze_release)(&lazy));
    ASSERT_NEXT_STEP(0);
    settle();
    ASSERT_NEAR();
}

TEST(the_full_filter_may_go_on_at_any_time)
{
    settle();
    draw_step();
    ASSERT_OK(S(update)(&track, &radar.sensor, z)); /* one more measurement at the same instant */
    ASSERT_OK(S(update)(&other, &radar.sensor, z));
    ASSERT_NEAR();
    ASSERT_NEXT_STEP(0);
    ASSERT_NEAR();
    settle();
    ASSERT_OK(S(freeze_release)(&lazy));
    ASSERT_NEXT_STEP(0);
}

/* It gets every step; then the settling begins anew. */
TEST(a_history_takes_its_place)
{
    settle();
    ASSERT_OK(S(detach)(&lazy.attached));
    ASSERT_OK(S(attach)(&track, &tape.attached));
    freeze_steps(60);
    TEST_ASSERT_EQUAL_UINT(61, S(history_steps)(&tape));
    ASSERT_OK(S(smooth)(&tape));
    ASSERT_OK(S(detach)(&tape.attached));
    ASSERT_OK(S(attach)(&track, &lazy.attached));
    TEST_ASSERT_EQUAL_INT(0, S(freeze_is_active)(&lazy));
    settle();
    ASSERT_NEAR();
}

/* The last step before it settles is a step of the full filter, and so is a predict and an update. */
TEST(a_step_of_the_full_filter_is_a_predict_and_an_update)
{
    for (int t = 0; t < 4; t++) {
        draw_step();
        ASSERT_OK(S(step)(&track, &motion.process, u, &radar.sensor, z));
        ASSERT_OK(S(predict)(&other, &motion.process, u));
        ASSERT_OK(S(update)(&other, &radar.sensor, z));
        TEST_ASSERT_EQUAL_INT(0, S(freeze_is_active)(&lazy));
        ASSERT_SAME_BITS(other_memory, track_memory);
        TEST_ASSERT_TRUE(S(log_likelihood)(&other) == S(log_likelihood)(&track));
    }
    for (int t = 0; t < 40; t++) { /* called apart they are the full filter's, and it never settles */
        draw_step();
        ASSERT_OK(S(predict)(&track, &motion.process, u));
        ASSERT_OK(S(update)(&track, &radar.sensor, z));
        ASSERT_OK(S(step)(&other, &motion.process, u, &radar.sensor, z));
        TEST_ASSERT_EQUAL_INT(0, S(freeze_is_active)(&lazy));
        ASSERT_SAME_BITS(other_memory, track_memory);
    }
}

#ifdef KQ_TEST_Q31
/* An update that leaves the word in between does not take the filter for a plain one. */
TEST_Q31(a_mean_that_comes_back_leaves_the_freeze_attached)
{
    static const double far[] = {200, 200};
    memcpy(z, measured(&radar.sensor, far), sizeof z);
    ASSERT_OK(kq_step_q31(&track, &motion.process, NULL, &radar.sensor, z));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_SATURATED, kq_events_q31(&track));
    ASSERT_OK(kq_filter_check_q31(&track));
}

/* A frozen mean that its word does not hold */
TEST_Q31(a_frozen_mean_that_leaves_its_word_is_held)
{
    static const double most[] = {10}, far[] = {200, 200};
    settle();
    kq_events_clear_q31(&track);
    memcpy(u, driven(&motion.process, most, 1), sizeof u);
    memcpy(z, measured(&radar.sensor, far), sizeof z);
    for (int t = 0; t < 20; t++) ASSERT_OK(kq_step_q31(&track, &motion.process, u, &radar.sensor, z));
    TEST_ASSERT_EQUAL_INT(1, kq_freeze_is_active_q31(&lazy));
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_SATURATED, kq_events_q31(&track));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, kq_mean_q31(&track, 0));
}
#endif

/* From 1 bit to the most; a freeze that begins anew is not frozen. */
TEST(init_takes_each_number_of_bits_and_begins_anew)
{
    settle();
    ASSERT_OK(S(freeze_init)(&lazy, BITS_MAX));
    TEST_ASSERT_EQUAL_INT(0, S(freeze_is_active)(&lazy));
    ASSERT_OK(S(freeze_init)(&lazy, 1));
}

TEST(other_sizes_are_refused)
{
    S_FREEZE(wide, N + 1, M);
    S_FREEZE(tall, N, M + 1);
    ASSERT_OK(S(freeze_init)(&wide, BITS));
    ASSERT_OK(S(freeze_init)(&tall, BITS));
    ASSERT_OK(S(detach)(&lazy.attached));
    WATCH(track), WATCH(track_memory), WATCH(wide), WATCH(tall);
    ASSERT_REFUSED(KQ_ERR_MISMATCH, S(attach)(&track, &wide.attached));
    ASSERT_OK(S(attach)(&track, &tall.attached)); /* for sensors of other components */
    draw_step();
    ASSERT_REFUSED(KQ_ERR_MISMATCH, S(step)(&track, &motion.process, u, &radar.sensor, z));
}

TEST(what_is_read_of_nothing_is_no_number)
{
    ASSERT_NOTHING(S(steady_mean)(NULL, 0));
    ASSERT_NOTHING(S(steady_mean)(&blank_steady, 0));
    ASSERT_NOTHING(S(steady_mean)(&steady, -1));
    ASSERT_NOTHING(S(steady_mean)(&steady, N));
    TEST_ASSERT_EQUAL_INT(0, S(freeze_is_active)(NULL));
    TEST_ASSERT_EQUAL_INT(0, S(freeze_is_active)(&blank_lazy));
}

/* Beside the table of test_refusals.c */
TEST(what_is_wrong_is_refused)
{
    S(steady) empty_steady;
    S(freeze) empty;
    memset(&empty_steady, 0, sizeof empty_steady);
    memset(&empty, 0, sizeof empty);
    WATCH(lazy), WATCH(lazy_memory), WATCH(lazy_gain);
    ASSERT_REFUSED_SIZE_OR_MEMORY(S(steady_init)(&empty_steady, &motion.process, &radar.sensor, prior.mean, gains, 1));
    ASSERT_REFUSED_SIZE_OR_MEMORY(S(freeze_init)(&empty, BITS));
    ASSERT_REFUSED(KQ_ERR_SIZE, S(freeze_init)(&lazy, BITS_MAX + 1));
    ASSERT_REFUSED(KQ_ERR_MISMATCH,
                   S(steady_init)(&steady, &motion.process, of_innovations(&radar), prior.mean, gains, 1));
    ASSERT_OK(S(detach)(&lazy.attached));
    ASSERT_OK(S(freeze_assign)(&lazy, N, M, lazy_memory, COUNT(lazy_memory), lazy_gain));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, S(freeze_release)(&lazy));
}

SUITE(freeze, set_up)
#include "freeze.tests"
