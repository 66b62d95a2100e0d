/* The fixed-lag and the fixed-point smoother in q31: against those in double, and what they
   refuse. */
#include "q31.h"
#include "unchanged.h"

#define STEPS 20
#define LONGEST (STEPS + 2)

static process_model motion, other, three;
static sensor_model radar;
static prior_model start, start3;
static kq_process_q31 blank_process;
KQ_FILTER_Q31(track, 2);
KQ_FILTER_Q31(twin, 2);
KQ_FILTER_Q31(blank, 2);
KQ_FILTER_Q31(track3, 3);
KQ_LAG_Q31(past, 2, 2, LONGEST);
KQ_LAG_Q31(unused, 2, 2, 2);
KQ_LAG_Q31(past3, 3, 2, 2);
KQ_INSTANT_Q31(instant, 2, 2);
KQ_INSTANT_Q31(unused_point, 2, 2);
KQ_INSTANT_Q31(instant3, 3, 2);
static kq_filter_q31 past_view, instant_view, no_view;
KQ_HISTORY_Q31(tape, 2, 2, STEPS, STEPS);

/* the same in double */
PROCESS(motion_f64, 2, 1);
PROCESS(other_f64, 2, 1);
SENSOR(radar_f64, 2, 2);
FILTER(track_f64, 2);
LAG(past_f64, 2, 2, LONGEST);
INSTANT(instant_f64, 2, 2);
static K(filter) past_f64_view, instant_f64_view;

static const double range[] = {100, 10, 10}, drive_range[] = {5}, measured_range[] = {100, 100};
static const double A[] = {1, 0.5, -0.25, 0.75}, B[] = {0.125, 0.5};
static const double A2[] = {0.5, 0.25, 0, 1}, Q2[] = {1, 0, 0, 0};
static const double Q[] = {0.25, 0.125, 0.125, 0.5};
static const double H[] = {1, 0, 0.5, 1}, R[] = {0.5, 0.25, 0.25, 1};
static const double x0[] = {1, -2, 0}, P0[] = {2, 0.5, 0.5, 1};
static const double identity3[] = {1, 0, 0, 0, 1, 0, 0, 0, 1};

#define LIKE 0x1p-22

static kq_scaled_q31 out[4];

static void attach_lag(int longest)
{
    ASSERT_OK(kq_filter_init_q31(&track, &start.table, NULL));
    ASSERT_OK(kq_lag_assign_q31(&past, 2, 2, (size_t)longest, past_memory, COUNT(past_memory)));
    ASSERT_OK(kq_attach_q31(&track, &past.attached));
    ASSERT_OK(K(filter_init)(&track_f64, x0, P0));
    ASSERT_OK(K(lag_assign)(&past_f64, 2, 2, (size_t)longest, past_f64_memory, COUNT(past_f64_memory)));
    ASSERT_OK(K(attach)(&track_f64, &past_f64.attached));
}

static void attach_point(void)
{
    ASSERT_OK(kq_filter_init_q31(&track, &start.table, NULL));
    ASSERT_OK(kq_instant_assign_q31(&instant, 2, 2, instant_memory, COUNT(instant_memory)));
    ASSERT_OK(kq_attach_q31(&track, &instant.attached));
    ASSERT_OK(K(filter_init)(&track_f64, x0, P0));
    ASSERT_OK(K(attach)(&track_f64, &instant_f64.attached));
}

static void set_up(void)
{
    put_process(&motion, 2, 1, range, drive_range, A, B, Q);
    put_process(&other, 2, 1, range, drive_range, A2, B, Q2);
    put_process(&three, 3, 0, range, drive_range, identity3, NULL, identity3);
    put_sensor(&radar, 2, 2, range, measured_range, H, R);
    put_prior(&start, 2, range, x0, P0);
    put_prior(&start3, 3, range, x0, identity3);
    ASSERT_OK(kq_filter_init_q31(&twin, &start.table, NULL));
    ASSERT_OK(kq_filter_init_q31(&track3, &start3.table, NULL));
    ASSERT_OK(K(process_init)(&motion_f64, A, B, Q));
    ASSERT_OK(K(process_init)(&other_f64, A2, B, Q2));
    ASSERT_OK(K(sensor_init)(&radar_f64, H, R));
    attach_lag(5);
    watch_nothing();
    WATCH(track), WATCH(track_memory), WATCH(blank), WATCH(blank_memory), WATCH(past);
    WATCH(instant), WATCH(instant_memory), WATCH(out);
}

/* ------------------------------------------------------------------------------- a run */

static void measure(kq_filter_q31 *f, int step, int in_double)
{
    const double z[] = {3 * sin(step), 0.5 - 0.25 * step};
    const uint32_t present = (uint32_t)(step + 1) % 4;
    const int32_t *words = words_of(z, 2, radar.measurement_format);
    ASSERT_OK(kq_update_subset_q31(f, &radar.sensor, words, present));
    if (in_double) ASSERT_OK(K(update_subset)(&track_f64, &radar_f64, z, present));
}

static const kq_process_q31 *process_of(int step)
{
    return step % 3 ? &motion.process : &other.process;
}

static const int32_t *control_of(int step, double *u)
{
    *u = cos(step);
    return words_of(u, 1, motion.control_format);
}

/* The step with the number `step`, but for its last predict, in both arithmetics */
static void drive_lag(int step)
{
    double u;
    const int32_t *words = control_of(step, &u);
    if (step) {
        ASSERT_OK(kq_predict_q31(&track, process_of(step), words));
        ASSERT_OK(K(predict)(&track_f64, step % 3 ? &motion_f64 : &other_f64, &u));
    }
    measure(&track, step, 1);
}

static void drive_point(int step)
{
    double u;
    const int32_t *words = control_of(step, &u);
    if (step) {
        ASSERT_OK(kq_predict_q31(&track, process_of(step), words));
        ASSERT_OK(K(predict)(&track_f64, step % 3 ? &motion_f64 : &other_f64, &u));
    }
    measure(&track, step, 1);
}

static int both_fractions(int k)
{
    return start.state_format[k / 2].fraction + start.state_format[k % 2].fraction;
}

static double value_of_words(int32_t mean, int32_t low, int i)
{
    return ldexp(mean + ldexp(low, -24), -start.state_format[i].fraction);
}

static void assert_mean(double expected, int32_t mean, int32_t low, int i)
{
    ASSERT_WITHIN(LIKE * (1 + fabs(expected)), expected, value_of_words(mean, low, i));
}

static void assert_covariance(const double *P)
{
    for (int k = 0; k < 4; k++) {
        ASSERT_WITHIN(2 * LIKE, P[k], value_of(out[k], both_fractions(k)));
    }
}

static void assert_sigma(double expected, int32_t sigma, int i)
{
    const double words = ldexp(expected, start.state_format[i].fraction);
    ASSERT_WITHIN(1 + words * LIKE, words, sigma);
}

static void assert_lag(int with_covariance)
{
    double P[4];
    for (int i = 0; i < 2; i++) {
        assert_mean(K(mean)(&past_f64_view, i), kq_mean_q31(&past_view, i),
                    kq_mean_low_q31(&past_view, i), i);
        if (!with_covariance) continue;
        assert_sigma(K(sigma)(&past_f64_view, i), kq_sigma_q31(&past_view, i), i);
    }
    if (!with_covariance) return;
    ASSERT_OK(K(covariance)(&past_f64_view, P));
    ASSERT_OK(kq_covariance_q31(&past_view, out));
    assert_covariance(P);
}

/* --------------------------------------------------------------------------- fixed lag */

static void every_lag_is_that_in_double(void)
{
    static const int longest[] = {0, 1, 2, 3, 4, 5, 10, LONGEST};
    for (int l = 0; l < COUNT(longest); l++) {
        attach_lag(longest[l]);
        for (int step = 0; step < STEPS; step++) {
            drive_lag(step);
            TEST_ASSERT_EQUAL_INT(step < longest[l] ? step : longest[l], kq_lag_steps_q31(&past));
            for (size_t k = 0; k <= kq_lag_steps_q31(&past); k++) {
                ASSERT_OK(kq_lagged_q31(&past, k, &past_view));
                ASSERT_OK(K(lagged)(&past_f64, k, &past_f64_view));
                assert_lag(1);
                ASSERT_OK(kq_lagged_states_q31(&past, k, &past_view));
                assert_lag(0);
                TEST_ASSERT_EQUAL_INT32(KQ_NOT_A_VALUE_Q31, kq_sigma_q31(&past_view, 0));
                ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_covariance_q31(&past_view, out));
            }
        }
        TEST_ASSERT_EQUAL_HEX(0, kq_events_q31(&track));
    }
}

/* Up to the last bits of the maps; the tape has exponents for its rows */
static void the_longest_lag_is_that_of_the_tape(void)
{
    kq_scaled_q31 P[4];
    ASSERT_OK(kq_attach_q31(&twin, &tape.attached));
    attach_lag(LONGEST);
    for (int step = 0; step < STEPS; step++) {
        double u;
        drive_lag(step);
        const int32_t *words = control_of(step, &u);
        if (step) ASSERT_OK(kq_predict_q31(&twin, process_of(step), words));
        measure(&twin, step, 0);
    }
    ASSERT_OK(kq_smooth_q31(&tape));
    for (size_t k = 0; k < STEPS; k++) {
        const size_t t = STEPS - 1 - k;
        ASSERT_OK(kq_lagged_q31(&past, k, &past_view));
        ASSERT_OK(kq_covariance_q31(&past_view, out));
        ASSERT_OK(kq_covariance_q31(SMOOTHED_Q31(&tape, t), P));
        for (int i = 0; i < 2; i++) {
            ASSERT_WITHIN(
                0x1p-26 * 8,
                value_of_words(kq_mean_q31(SMOOTHED_Q31(&tape, t), i),
                               kq_mean_low_q31(SMOOTHED_Q31(&tape, t), i), i),
                value_of_words(kq_mean_q31(&past_view, i), kq_mean_low_q31(&past_view, i), i));
        }
        for (int j = 0; j < 4; j++) {
            ASSERT_WITHIN(0x1p-26 * 2, value_of(P[j], both_fractions(j)),
                          value_of(out[j], both_fractions(j)));
        }
    }
}

static void none_is_the_filter_bit_for_bit(void)
{
    kq_scaled_q31 P[4];
    for (int longest = 0; longest <= 3; longest += 3) {
        attach_lag(longest);
        for (int step = 0; step < STEPS; step++) {
            drive_lag(step);
            ASSERT_OK(kq_lagged_q31(&past, 0, &past_view));
            ASSERT_OK(kq_covariance_q31(&past_view, out));
            ASSERT_OK(kq_covariance_q31(&track, P));
            ASSERT_SAME_BITS(P, out);
            for (int i = 0; i < 2; i++) {
                TEST_ASSERT_EQUAL_INT32(kq_mean_q31(&track, i), kq_mean_q31(&past_view, i));
                TEST_ASSERT_EQUAL_INT32(kq_mean_low_q31(&track, i), kq_mean_low_q31(&past_view, i));
                TEST_ASSERT_EQUAL_INT32(kq_sigma_q31(&track, i), kq_sigma_q31(&past_view, i));
            }
        }
    }
}

static void the_filter_is_the_same(void)
{
    for (int with_point = 0; with_point < 2; with_point++) {
        ASSERT_OK(kq_filter_init_q31(&twin, &start.table, NULL));
        if (with_point) attach_point();
        for (int step = 0; step < STEPS; step++) {
            double u;
            if (with_point) drive_point(step);
            else drive_lag(step);
            const int32_t *words = control_of(step, &u);
            if (step) ASSERT_OK(kq_predict_q31(&twin, process_of(step), words));
            measure(&twin, step, 0);
            if (with_point) ASSERT_OK(kq_instant_smooth_q31(&instant, &instant_view));
            else ASSERT_OK(kq_lagged_q31(&past, kq_lag_steps_q31(&past), &past_view));
            ASSERT_SAME_Q31(&twin, &track);
        }
    }
}

/* The same constant, seen through no process noise: known as now, however far back */
static void a_constant_is_known_as_now(void)
{
    static const double still[] = {1, 0, 0, 1}, none[4], z[] = {3, -1};
    put_process(&motion, 2, 0, range, drive_range, still, NULL, none);
    for (int step = 0; step < STEPS; step++) {
        if (step) ASSERT_OK(kq_predict_q31(&track, &motion.process, NULL));
        const int32_t *words = words_of(z, 2, radar.measurement_format);
        ASSERT_OK(kq_update_q31(&track, &radar.sensor, words));
        for (size_t k = 0; k <= kq_lag_steps_q31(&past); k++) {
            ASSERT_OK(kq_lagged_q31(&past, k, &past_view));
            for (int i = 0; i < 2; i++) {
                assert_mean(mean_value(&track, i), kq_mean_q31(&past_view, i),
                            kq_mean_low_q31(&past_view, i), i);
                ASSERT_WITHIN(2 + ldexp(LIKE, start.state_format[i].fraction),
                              kq_sigma_q31(&track, i), kq_sigma_q31(&past_view, i));
            }
        }
    }
}

/* ------------------------------------------------------------------------- fixed point */

static void assert_point(void)
{
    double P[4];
    ASSERT_OK(kq_instant_smooth_q31(&instant, &instant_view));
    ASSERT_OK(K(instant_smooth)(&instant_f64, &instant_f64_view));
    ASSERT_OK(K(covariance)(&instant_f64_view, P));
    ASSERT_OK(kq_covariance_q31(&instant_view, out));
    assert_covariance(P);
    for (int i = 0; i < 2; i++) {
        assert_mean(K(mean)(&instant_f64_view, i), kq_mean_q31(&instant_view, i),
                    kq_mean_low_q31(&instant_view, i), i);
        assert_sigma(K(sigma)(&instant_f64_view, i), kq_sigma_q31(&instant_view, i), i);
    }
}

static void an_instant_is_that_in_double(void)
{
    for (int s = 0; s < STEPS; s += 4) {
        attach_point();
        for (int step = 0; step < STEPS; step++) {
            drive_point(step);
            if (step == s) {
                ASSERT_OK(kq_attach_q31(&track, &instant.attached));
                ASSERT_OK(K(attach)(&track_f64, &instant_f64.attached));
            }
            assert_point();
        }
    }
}

static void a_long_run_changes_nothing_any_more(void)
{
    kq_scaled_q31 early[4];
    int32_t mean[2];
    attach_point();
    for (int step = 0; step < 3000; step++) {
        double u;
        const int32_t *words = control_of(step, &u);
        if (step) ASSERT_OK(kq_predict_q31(&track, process_of(step), words));
        measure(&track, step % STEPS, 0);
        if (step != 100) continue;
        ASSERT_OK(kq_instant_smooth_q31(&instant, &instant_view));
        ASSERT_OK(kq_covariance_q31(&instant_view, early));
        for (int i = 0; i < 2; i++) mean[i] = kq_mean_q31(&instant_view, i);
    }
    ASSERT_OK(kq_instant_smooth_q31(&instant, &instant_view));
    ASSERT_OK(kq_covariance_q31(&instant_view, out));
    for (int k = 0; k < 4; k++) {
        ASSERT_WITHIN(LIKE, value_of(early[k], both_fractions(k)),
                      value_of(out[k], both_fractions(k)));
    }
    for (int i = 0; i < 2; i++)
        TEST_ASSERT_INT32_WITHIN(1, mean[i], kq_mean_q31(&instant_view, i));
}

/* Known a million times better than at first, and better still with each measurement, by less than
   the last bit of a word of the map: the instant is known as now. */
static void a_constant_is_refined_for_long(void)
{
    static const double still[] = {1, 0, 0, 1}, none[4], wide[] = {1e6, 0, 0, 1e6};
    static const double wide_range[] = {10000, 10000}, look[] = {1, 0, 0, 1};
    static const double sharp[] = {1e-4, 0, 0, 1e-4}, z[] = {3, -1};
    put_process(&motion, 2, 0, wide_range, drive_range, still, NULL, none);
    put_sensor(&radar, 2, 2, wide_range, wide_range, look, sharp);
    put_prior(&start, 2, wide_range, x0, wide);
    ASSERT_OK(kq_filter_init_q31(&track, &start.table, NULL));
    ASSERT_OK(kq_attach_q31(&track, &instant.attached));
    const int32_t *words = words_of(z, 2, radar.measurement_format);
    for (int step = 0; step < 3000; step++) {
        if (step) ASSERT_OK(kq_predict_q31(&track, &motion.process, NULL));
        ASSERT_OK(kq_update_q31(&track, &radar.sensor, words));
    }
    ASSERT_OK(kq_instant_smooth_q31(&instant, &instant_view));
    ASSERT_OK(kq_covariance_q31(&instant_view, out));
    for (int i = 0; i < 2; i++) {
        const int fraction = start.state_format[i].fraction;
        const double sigma = sqrt(value_of(out[3 * i], 2 * fraction));
        ASSERT_WITHIN(1e-3 * 0.01 / sqrt(3000), 0.01 / sqrt(3000), sigma);
        ASSERT_WITHIN(2, kq_mean_q31(&track, i), kq_mean_q31(&instant_view, i));
    }
}

/* ------------------------------------------------------------------------------- limits */

#define WIDE 16
#define WIDE_LAG 7

/* 16 scalars side by side are what one of them is alone. */
static void sixteen_states_are_sixteen_scalars(void)
{
    static kq_format_q31 format[WIDE];
    static kq_scaled_q31 transition[WIDE * WIDE], look[WIDE * WIDE], noise[WIDE];
    static kq_scaled_q31 P[WIDE * WIDE];
    static int32_t root[KQ_ROOT_LEN_Q31(WIDE)], prior_root[KQ_ROOT_LEN_Q31(WIDE)];
    static int32_t memory[KQ_FILTER_LEN_Q31(WIDE)], zero[WIDE], z[WIDE];
    static int32_t lag_memory[KQ_LAG_LEN_Q31(WIDE, WIDE, WIDE_LAG)];
    static double M[WIDE * WIDE], one[WIDE], a_half[WIDE * WIDE];
    int32_t mean[WIDE_LAG + 1][WIDE], sigma[WIDE_LAG + 1][WIDE];
    for (int n = WIDE; n >= 1; n -= WIDE - 1) { /* 16, then 1: state 5 of them */
        kq_filter_q31 f;
        kq_process_q31 p;
        kq_sensor_q31 s;
        kq_lag_q31 lag;
        kq_filter_q31 lag_view;
        for (int i = 0; i < n * n; i++) {
            M[i] = i % (n + 1) ? 0 : 1;
            a_half[i] = M[i] / 2;
        }
        for (int i = 0; i < n; i++) {
            one[i] = 1;
            ASSERT_OK(kq_format_prepare_q31(format + i, KQ_FRACTION_BEST_Q31, 100, NULL));
        }
        ASSERT_OK(kq_matrix_prepare_q31(transition, a_half, n, n, format, format));
        ASSERT_OK(kq_matrix_prepare_q31(look, M, n, n, format, format));
        ASSERT_OK(kq_noise_prepare_diagonal_q31(noise, one, n, format));
        ASSERT_OK(kq_root_prepare_q31(root, M, n, format));
        ASSERT_OK(kq_root_prepare_q31(prior_root, M, n, format));
        const kq_process_table_q31 process_table = {
            .states = n, .state_format = format, .transition = transition, .noise_root = root};
        const kq_sensor_table_q31 sensor_table = {.states = n,
                                                  .components = n,
                                                  .state_format = format,
                                                  .measurement_format = format,
                                                  .measurement = look,
                                                  .noise = noise};
        const kq_prior_table_q31 prior = {n, format, zero, prior_root};
        ASSERT_OK(kq_process_init_q31(&p, &process_table, NULL));
        ASSERT_OK(kq_sensor_init_q31(&s, &sensor_table, NULL));
        ASSERT_OK(kq_filter_assign_q31(&f, n, memory, COUNT(memory)));
        ASSERT_OK(kq_filter_init_q31(&f, &prior, NULL));
        ASSERT_OK(kq_lag_assign_q31(&lag, n, n, WIDE_LAG, lag_memory,
                                    (size_t)KQ_LAG_LEN_Q31((size_t)n, n, WIDE_LAG)));
        ASSERT_OK(kq_attach_q31(&f, &lag.attached));
        for (int step = 0; step < 12; step++) {
            if (step) ASSERT_OK(kq_predict_q31(&f, &p, NULL));
            for (int i = 0; i < n; i++) {
                z[i] = (((n == 1 ? 5 : i) * 5 + step * 3) % 11 - 5) * (format[0].range / 100);
            }
            ASSERT_OK(kq_update_q31(&f, &s, z));
        }
        for (size_t k = 0; k <= WIDE_LAG; k++) {
            ASSERT_OK(kq_lagged_q31(&lag, k, &lag_view));
            for (int i = 0; i < n; i++) {
                if (n == 1) {
                    TEST_ASSERT_INT32_WITHIN(8, mean[k][5], kq_mean_q31(&lag_view, 0));
                    TEST_ASSERT_INT32_WITHIN(8, sigma[k][5], kq_sigma_q31(&lag_view, 0));
                }
                if (n > 1) mean[k][i] = kq_mean_q31(&lag_view, i);
                if (n > 1) sigma[k][i] = kq_sigma_q31(&lag_view, i);
            }
        }
        ASSERT_OK(kq_covariance_q31(&lag_view, P));
        for (int i = 1; i < n; i++) TEST_ASSERT_EQUAL_INT32(0, P[i].mantissa);
    }
}

/* ---------------------------------------------------------------------------- refusals */

static void assign_refuses(void)
{
    static const int bad[] = {0, -1, 17, 258, -254, INT_MAX, INT_MIN};
    const size_t least = KQ_LAG_LEN_Q31(2, 1, 3), least_point = KQ_INSTANT_LEN_Q31(2, 1);
    ASSERT_REFUSED(KQ_ERR_NULL, kq_lag_assign_q31(NULL, 2, 1, 3, past_memory, 1000));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_lag_assign_q31(&past, 2, 1, 3, NULL, 1000));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_instant_assign_q31(NULL, 2, 1, instant_memory, 1000));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_instant_assign_q31(&instant, 2, 1, NULL, 1000));
    for (int k = 0; k < COUNT(bad); k++) {
        ASSERT_REFUSED(KQ_ERR_SIZE, kq_lag_assign_q31(&past, bad[k], 1, 3, past_memory, SIZE_MAX));
        ASSERT_REFUSED(KQ_ERR_SIZE,
                       kq_instant_assign_q31(&instant, bad[k], 1, instant_memory, SIZE_MAX));
    }
    ASSERT_REFUSED(KQ_ERR_SIZE, kq_lag_assign_q31(&past, 2, 0, 3, past_memory, SIZE_MAX));
    ASSERT_REFUSED(KQ_ERR_SIZE, kq_lag_assign_q31(&past, 2, 1, KQ_COUNT_MAX + 1, past_memory, SIZE_MAX));
    ASSERT_REFUSED(KQ_ERR_SIZE, kq_instant_assign_q31(&instant, 2, 0, instant_memory, SIZE_MAX));
    ASSERT_REFUSED(KQ_ERR_MEMORY, kq_lag_assign_q31(&past, 2, 1, 3, past_memory, least - 1));
    ASSERT_REFUSED(KQ_ERR_MEMORY,
                   kq_instant_assign_q31(&instant, 2, 1, instant_memory, least_point - 1));
    ASSERT_OK(kq_lag_assign_q31(&past, 2, 1, 3, past_memory, least));
    ASSERT_OK(kq_instant_assign_q31(&instant, 2, 1, instant_memory, least_point));
}

static void attach_refuses(void)
{
    kq_lag_q31 bare;
    kq_instant_q31 bare_point;
    memset(&bare, 0, sizeof bare);
    memset(&bare_point, 0, sizeof bare_point);
    WATCH(bare), WATCH(bare_point);
    ASSERT_REFUSED(KQ_ERR_NULL, kq_attach_q31(&track, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_attach_q31(NULL, &past.attached));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_attach_q31(&blank, &past.attached));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_attach_q31(&track, &bare.attached));
    bare.attached.hooks = past.attached.hooks; /* without sizes */
    ASSERT_REFUSED_SIZE_OR_MEMORY(kq_attach_q31(&track, &bare.attached));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, kq_attach_q31(&track, &past3.attached));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_attach_q31(&track, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_attach_q31(NULL, &instant.attached));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_attach_q31(&blank, &instant.attached));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_attach_q31(&track, &bare_point.attached));
    bare_point.attached.hooks = instant.attached.hooks; /* without sizes */
    ASSERT_REFUSED_SIZE_OR_MEMORY(kq_attach_q31(&track, &bare_point.attached));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, kq_attach_q31(&track, &instant3.attached));
    TEST_ASSERT_EQUAL_INT(0, kq_lag_steps_q31(NULL));
    TEST_ASSERT_EQUAL_INT(0, kq_lag_steps_q31(&unused));
}

/* By the plain functions, and nothing has changed */
static void assert_predict_and_step_refuse(void)
{
    static const int32_t beyond[] = {INT32_MAX, INT32_MAX}, z[] = {0, 0};
    const kq_process_q31 *p = &motion.process;
    const kq_sensor_q31 *s = &radar.sensor;
    ASSERT_REFUSED(KQ_ERR_NULL, kq_predict_q31(NULL, p, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_predict_q31(&track, NULL, NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_predict_q31(&track, &blank_process, NULL));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, kq_predict_q31(&track, &three.process, NULL));
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_predict_q31(&track, p, beyond));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_step_q31(&track, NULL, NULL, s, z));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_step_q31(&track, p, NULL, NULL, z));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_step_q31(&track, p, NULL, s, NULL));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_step_q31(&track, &blank_process, NULL, s, z));
    ASSERT_REFUSED(KQ_ERR_MISMATCH, kq_step_q31(&track, &three.process, NULL, s, z));
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_step_q31(&track, p, beyond, s, z));
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_step_q31(&track, p, NULL, s, beyond));
}

/* Two measurements each, and there is room for two: the bits of the filter are those of the twin, which has
   nothing attached. */
static void assert_full_and_going_on(void)
{
    for (int k = 0; k < 3; k++) measure(&track, 2, 0);
    TEST_ASSERT_EQUAL_HEX(KQ_EVENT_HISTORY_FULL, kq_events_q31(&track));
    ASSERT_OK(kq_filter_copy_q31(&twin, &track));
    for (int step = 1; step < 5; step++) {
        const int32_t z[] = {step * 1000, -step * 1000};
        ASSERT_OK(kq_predict_q31(&track, process_of(step), NULL));
        ASSERT_OK(kq_predict_q31(&twin, process_of(step), NULL));
        ASSERT_OK(kq_step_q31(&track, process_of(step), NULL, &radar.sensor, z));
        ASSERT_OK(kq_step_q31(&twin, process_of(step), NULL, &radar.sensor, z));
        ASSERT_SAME_Q31(&twin, &track);
    }
}

static void lag_refuses(void)
{
    static const size_t bad[] = {3, SIZE_MAX, KQ_COUNT_MAX, SIZE_MAX / 2 + 1};
    for (int step = 0; step < 3; step++) drive_lag(step);
    watch(past_memory, 2048);
    assert_predict_and_step_refuse();
    ASSERT_REFUSED(KQ_ERR_NULL, kq_lagged_q31(NULL, 0, &no_view));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, kq_lagged_q31(&unused, 0, &no_view));
    for (int k = 0; k < COUNT(bad); k++) {
        ASSERT_REFUSED(KQ_ERR_SIZE, kq_lagged_q31(&past, bad[k], &no_view));
        ASSERT_REFUSED(KQ_ERR_SIZE, kq_lagged_states_q31(&past, bad[k], &no_view));
    }
    ASSERT_OK(kq_lagged_q31(&past, 2, &past_view));
    assert_full_and_going_on();
    ASSERT_REFUSED(KQ_ERR_HISTORY_FULL, kq_lagged_q31(&past, 0, &no_view));
}

static void point_refuses(void)
{
    attach_point();
    for (int step = 0; step < 3; step++) drive_point(step);
    assert_predict_and_step_refuse();
    ASSERT_REFUSED(KQ_ERR_NULL, kq_instant_smooth_q31(NULL, &no_view));
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, kq_instant_smooth_q31(&unused_point, &no_view));
    ASSERT_OK(kq_instant_smooth_q31(&instant, &instant_view));
    assert_full_and_going_on();
    ASSERT_REFUSED(KQ_ERR_HISTORY_FULL, kq_instant_smooth_q31(&instant, &no_view));
}

/* The struct alone: the twin is a copy of the filter as it should be. */
static void assert_copy_goes_on_alone(void)
{
    static int32_t memory[KQ_FILTER_LEN_Q31(2)];
    static const int32_t z[] = {1000, -1000};
    kq_filter_q31 copied = track;
    memcpy(memory, track_memory, sizeof memory);
    copied.memory = memory;
    ASSERT_OK(kq_filter_copy_q31(&twin, &track));
    for (int step = 1; step < 4; step++) {
        ASSERT_OK_UNCHANGED(kq_step_q31(&copied, process_of(step), NULL, &radar.sensor, z));
        TEST_ASSERT_EQUAL_HEX(step == 1 ? KQ_EVENT_HISTORY_FULL : 0, kq_events_q31(&copied));
        kq_events_clear_q31(&copied);
        ASSERT_OK(kq_step_q31(&twin, process_of(step), NULL, &radar.sensor, z));
        ASSERT_SAME_Q31(&twin, &copied);
    }
}

static void an_assigned_copy_goes_on_alone(void)
{
    for (int step = 0; step < 3; step++) drive_lag(step);
    assert_copy_goes_on_alone();
    drive_lag(3);
    ASSERT_OK(kq_lagged_q31(&past, 3, &past_view));
    attach_point();
    for (int step = 0; step < 3; step++) drive_point(step);
    assert_copy_goes_on_alone();
    drive_point(3);
    ASSERT_OK(kq_instant_smooth_q31(&instant, &instant_view));
}

static void a_step_is_predict_and_update(void)
{
    KQ_LAG_Q31(beside, 2, 2, 5);
    kq_filter_q31 beside_view;
    kq_scaled_q31 P[4];
    ASSERT_OK(kq_attach_q31(&twin, &beside.attached));
    for (int step = 0; step < STEPS; step++) {
        const int32_t z[] = {step * 1000, 50000 - step * 3000};
        ASSERT_OK(kq_step_q31(&track, process_of(step), NULL, &radar.sensor, z));
        ASSERT_OK(kq_predict_q31(&twin, process_of(step), NULL));
        ASSERT_OK(kq_update_q31(&twin, &radar.sensor, z));
        ASSERT_SAME_Q31(&twin, &track);
        ASSERT_OK(kq_lagged_q31(&beside, kq_lag_steps_q31(&beside), &beside_view));
        ASSERT_OK(kq_covariance_q31(&beside_view, P));
        ASSERT_OK(kq_lagged_q31(&past, kq_lag_steps_q31(&past), &past_view));
        ASSERT_OK(kq_covariance_q31(&past_view, out));
        ASSERT_SAME_BITS(P, out);
        TEST_ASSERT_EQUAL_INT32(kq_mean_q31(&beside_view, 1), kq_mean_q31(&past_view, 1));
    }
    TEST_ASSERT_EQUAL_HEX(0, kq_events_q31(&track));
}

static void assert_no_word(const kq_filter_q31 *view, int i)
{
    TEST_ASSERT_EQUAL_INT32(KQ_NOT_A_VALUE_Q31, kq_mean_q31(view, i));
    TEST_ASSERT_EQUAL_INT32(KQ_NOT_A_VALUE_Q31, kq_mean_low_q31(view, i));
    TEST_ASSERT_EQUAL_INT32(KQ_NOT_A_VALUE_Q31, kq_sigma_q31(view, i));
}

static void what_is_not_shown_is_no_word(void)
{
    static const int bad[] = {-1, 2, INT_MAX, INT_MIN};
    ASSERT_OK(kq_lagged_q31(&past, 0, &past_view));
    for (int k = 0; k < COUNT(bad); k++) assert_no_word(&past_view, bad[k]);
    ASSERT_REFUSED(KQ_ERR_NULL, kq_covariance_q31(&past_view, NULL));
    ASSERT_REFUSED(KQ_ERR_SIZE, kq_lagged_q31(&past, 1, &past_view));
    assert_no_word(&past_view, 0);
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_covariance_q31(&past_view, out));
    attach_point();
    ASSERT_OK(kq_instant_smooth_q31(&instant, &instant_view));
    for (int k = 0; k < COUNT(bad); k++) assert_no_word(&instant_view, bad[k]);
    ASSERT_REFUSED(KQ_ERR_HISTORY_EMPTY, kq_instant_smooth_q31(&unused_point, &instant_view));
    assert_no_word(&instant_view, 0);
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_covariance_q31(&instant_view, out));
}

SUITE(on_line, set_up)
{
    RUN_TEST(every_lag_is_that_in_double);
    RUN_TEST(the_longest_lag_is_that_of_the_tape);
    RUN_TEST(none_is_the_filter_bit_for_bit);
    RUN_TEST(the_filter_is_the_same);
    RUN_TEST(a_constant_is_known_as_now);
    RUN_TEST(an_instant_is_that_in_double);
    RUN_TEST(a_long_run_changes_nothing_any_more);
    RUN_TEST(a_constant_is_refined_for_long);
    RUN_TEST(sixteen_states_are_sixteen_scalars);
    RUN_TEST(assign_refuses);
    RUN_TEST(attach_refuses);
    RUN_TEST(lag_refuses);
    RUN_TEST(point_refuses);
    RUN_TEST(an_assigned_copy_goes_on_alone);
    RUN_TEST(a_step_is_predict_and_update);
    RUN_TEST(what_is_not_shown_is_no_word);
}
