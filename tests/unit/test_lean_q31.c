/* A q31 sensor without the careful path: what it takes, how well, and what it takes coarsely. */
#include "q31.h"
#include "losses_q31.h"
#include "reading.h"
#include "unchanged.h"

static process_model motion;
static sensor_model full, lean, correlated;
static prior_model start;
KQ_FILTER_Q31(track, 2);
KQ_FILTER_Q31(twin, 2);

/* the same in double */
PROCESS(motion_f64, 2, 0);
SENSOR(radar_f64, 2, 2);
FILTER(track_f64, 2);

static const double range[] = {100, 10}, measured_range[] = {100, 100};
static const double A[] = {1, 0.5, 0, 1}, Q[] = {0.25, 0.125, 0.125, 0.5};
static const double H[] = {1, 0, 0.5, 1};
static const double x0[] = {1, -2}, P0[] = {64, 0.5, 0.5, 16}, z[] = {3, 1};
static const double correlated_R[] = {0.5, 0.25, 0.25, 1};
static double R[] = {0.5, 0, 0, 1};

static void put_sensors(double r0, double r1)
{
    R[0] = r0;
    R[3] = r1;
    put_sensor(&full, 2, 2, range, measured_range, H, R);
    put_sensor(&lean, 2, 2, range, measured_range, H, R);
    full.table.correlated = lean.table.correlated = 0;
    for (int c = 0; c < 2; c++) full.noise[c] = lean.noise[c] = full.noise[KQ_TRIANGLE(c) + c];
    ASSERT_OK(kq_sensor_init_diagonal_q31(&full.sensor, &full.table, NULL));
    ASSERT_OK(kq_sensor_init_lean_q31(&lean.sensor, &lean.table, NULL));
    ASSERT_OK(K(sensor_init)(&radar_f64, H, R));
}

static void begin(void)
{
    ASSERT_OK(kq_filter_init_q31(&track, &start.table, NULL));
    ASSERT_OK(kq_filter_init_q31(&twin, &start.table, NULL));
    ASSERT_OK(K(filter_init)(&track_f64, x0, P0));
}

static void set_up(void)
{
    put_process(&motion, 2, 0, range, NULL, A, NULL, Q);
    put_prior(&start, 2, range, x0, P0);
    ASSERT_OK(K(process_init)(&motion_f64, A, NULL, Q));
    put_sensors(0.5, 1);
    begin();
    watch_nothing();
    WATCH(lean), WATCH(track), WATCH(track_memory);
}

static const int32_t *measured(const double *values)
{
    return words_of(values, 2, lean.measurement_format);
}

static void random_values(double *values, uint32_t *seed)
{
    for (int c = 0; c < 2; c++) values[c] = 3 * noise(seed);
}

/* Down to 2^-8 of S: bit for bit */
TEST(what_is_not_sharp_is_taken_as_ever)
{
    for (uint32_t seed = 1; seed <= 20; seed++) {
        uint32_t state = seed;
        begin();
        for (int t = 0; t < 12; t++) {
            double values[2];
            random_values(values, &state);
            ASSERT_OK(kq_step_q31(&track, &motion.process, NULL, &full.sensor, measured(values)));
            ASSERT_OK(kq_step_q31(&twin, &motion.process, NULL, &lean.sensor, measured(values)));
            TEST_ASSERT_EQUAL_MEMORY(track_memory, twin_memory, sizeof track_memory);
            TEST_ASSERT_EQUAL_MEMORY(&track.last, &twin.last, sizeof track.last);
        }
        TEST_ASSERT_TRUE(kq_log_likelihood_q31(&twin) == 0);
        TEST_ASSERT_EQUAL_UINT(0, kq_events_q31(&twin));
    }
}

/* Values that are words: both filters are given the same. */
static void random_words(double *values, uint32_t *seed)
{
    random_values(values, seed);
    for (int c = 0; c < 2; c++) values[c] = ldexp(rint(ldexp(values[c], 16)), -16);
}

/* From there to 2^-16 of S, at every step: as the filter in double */
TEST(what_is_a_little_sharp_is_taken)
{
    static const double less_P0[] = {2, 0.5, 0.5, 1};
    put_prior(&start, 2, range, x0, less_P0);
    for (int k = 8; k <= 14; k++) {
        put_sensors(ldexp(1, -k), ldexp(1, -k));
        for (uint32_t seed = 1; seed <= 20; seed++) {
            uint32_t state = seed;
            begin();
            ASSERT_OK(K(filter_init)(&track_f64, x0, less_P0));
            for (int t = 0; t < 12; t++) {
                double values[2];
                random_words(values, &state);
                ASSERT_OK(K(update)(&track_f64, &radar_f64, values));
                ASSERT_OK(kq_update_q31(&twin, &lean.sensor, measured(values)));
                ASSERT_LIKE(&track_f64, &twin, 0x1p-20);
                ASSERT_OK(K(predict)(&track_f64, &motion_f64, NULL));
                ASSERT_OK(kq_predict_q31(&twin, &motion.process, NULL));
            }
            TEST_ASSERT_EQUAL_UINT(0, kq_events_q31(&twin));
        }
    }
}

/* As one with the noise 2^-15 S, as the filter in double has it */
TEST(what_is_sharp_is_taken_coarsely)
{
    static const double noises[] = {0, 0x1p-12, 0x1p-20};
    for (int k = 0; k < COUNT(noises); k++) {
        set_up();
        put_sensors(64 * 0x1p-15, 1);
        ASSERT_OK(K(update)(&track_f64, &radar_f64, z));
        put_sensors(noises[k], 1);
        ASSERT_OK(kq_update_q31(&twin, &lean.sensor, measured(z)));
        ASSERT_LIKE(&track_f64, &twin, 0x1p-15);
        TEST_ASSERT_EQUAL_INT(2, kq_taken_q31(&twin));
        TEST_ASSERT_EQUAL_UINT(KQ_EVENT_LOW_NOISE, kq_events_q31(&twin));
        kq_events_clear_q31(&twin);
        TEST_ASSERT_EQUAL_UINT(0, kq_events_q31(&twin));
    }
}

/* S is 64 + r: at 2^-16 of it and above as it is, below 2^-17 coarsely, whatever the mantissas are */
TEST(where_sharp_begins)
{
    static const double taken[] = {1.001, 1.3, 1.7, 2.6}, coarse[] = {0.499, 0.37, 0.26};
    for (int k = 0; k < COUNT(taken); k++) {
        set_up();
        put_sensors(0x1p-10 * taken[k], 1);
        ASSERT_OK(kq_update_subset_q31(&twin, &lean.sensor, measured(z), 1));
        ASSERT_OK(K(update_subset)(&track_f64, &radar_f64, z, 1));
        ASSERT_LIKE(&track_f64, &twin, 0x1p-20);
        TEST_ASSERT_EQUAL_UINT(0, kq_events_q31(&twin));
    }
    for (int k = 0; k < COUNT(coarse); k++) {
        set_up();
        put_sensors(0x1p-10 * coarse[k], 1);
        ASSERT_OK(kq_update_subset_q31(&twin, &lean.sensor, measured(z), 1));
        TEST_ASSERT_EQUAL_UINT(KQ_EVENT_LOW_NOISE, kq_events_q31(&twin));
    }
}

/* Nothing is known, and nothing is left to know. */
TEST(a_variance_of_0)
{
    static const double none[4] = {0};
    put_prior(&start, 2, range, x0, none);
    put_sensors(0, 1);
    begin();
    ASSERT_OK(kq_update_q31(&twin, &lean.sensor, measured(z)));
    TEST_ASSERT_EQUAL_UINT(KQ_EVENT_LOW_NOISE, kq_events_q31(&twin));
    for (int i = 0; i < 2; i++) TEST_ASSERT_EQUAL_INT(kq_mean_q31(&track, i), kq_mean_q31(&twin, i));
}

/* Of sigmas far beyond the words, too; in double nothing is raised so early */
TEST(after_any_outage_it_comes_back)
{
    static const int32_t outages[] = {10, 100, 10000};
    static const double noises[] = {1, 0.01, 1e-4};
    for (int k = 0; k < COUNT(outages); k++) {
        for (int j = 0; j < COUNT(noises); j++) {
            put_sensors(noises[j], noises[j]);
            begin();
            for (int32_t t = 0; t < outages[k]; t++) {
                ASSERT_OK(kq_predict_q31(&track, &motion.process, NULL));
                ASSERT_OK(kq_predict_q31(&twin, &motion.process, NULL));
            }
            for (int t = 0; t < 12; t++) {
                ASSERT_OK(kq_step_q31(&twin, &motion.process, NULL, &lean.sensor, measured(z)));
                ASSERT_OK(kq_step_q31(&track, &motion.process, NULL, &full.sensor, measured(z)));
            }
            for (int i = 0; i < 2; i++) {
                ASSERT_WITHIN(0.02 * kq_sigma_q31(&track, i) + 2, kq_sigma_q31(&track, i), kq_sigma_q31(&twin, i));
            }
            kq_events_clear_q31(&twin);
            ASSERT_OK(kq_step_q31(&twin, &motion.process, NULL, &lean.sensor, measured(z)));
            TEST_ASSERT_EQUAL_UINT(0, kq_events_q31(&twin));
        }
    }
}

TEST(robust_updates_take_it)
{
    const kq_scaled_q31 two = {1 << 30, -29};
    put_sensors(0, 1);
    ASSERT_OK(huber_q31(&track, &full.sensor, measured(z), 3, two, NULL));
    ASSERT_OK(huber_q31(&twin, &lean.sensor, measured(z), 3, two, NULL));
    ASSERT_SAME_Q31(&track, &twin);
}

/* With what is known of A and H: the very state of the same model by init */
TEST(const_tables_with_zeros)
{
    const kq_process_q31 table = KQ_PROCESS_TABLE_Q31(2, 0, motion.state_format, NULL, motion.transition, NULL,
                                                      motion.noise_root, (0, 1));
    const kq_sensor_q31 lean_table =
        KQ_SENSOR_LEAN_TABLE_Q31(2, 2, lean.state_format, lean.measurement_format, lean.measurement, lean.noise,
                                 (1, 0)); /* component 0: of as many fraction bits as state 0 */
    TEST_ASSERT_EQUAL_MEMORY(motion.process.first, table.first, sizeof table.first);
    TEST_ASSERT_EQUAL_MEMORY(lean.sensor.selects, lean_table.selects, sizeof lean_table.selects);
    uint32_t seed = 1;
    begin();
    for (int t = 0; t < 12; t++) {
        double values[2];
        random_words(values, &seed);
        ASSERT_OK(kq_step_q31(&twin, &table, NULL, &lean_table, measured(values)));
        ASSERT_OK(kq_step_q31(&track, &motion.process, NULL, &lean.sensor, measured(values)));
        ASSERT_SAME_Q31(&track, &twin);
    }
}

/* The arrays as constants' initialisers, with the careful path and without */
TEST(const_tables)
{
    const kq_process_q31 table = KQ_PROCESS_TABLE_Q31(2, 0, motion.state_format, NULL,
                                                      motion.transition, NULL, motion.noise_root);
    const kq_sensor_q31 lean_table = KQ_SENSOR_LEAN_TABLE_Q31(
        2, 2, lean.state_format, lean.measurement_format, lean.measurement, lean.noise);
    const kq_sensor_q31 full_table = KQ_SENSOR_TABLE_Q31(
        2, 2, full.state_format, full.measurement_format, full.measurement, full.noise);
    const kq_sensor_q31 *const sensors[] = {&full_table, &lean_table};
    for (int k = 0; k < 2; k++) {
        uint32_t seed = 1;
        begin();
        for (int t = 0; t < 12; t++) {
            double values[2];
            random_words(values, &seed);
            ASSERT_OK(kq_step_q31(&twin, &table, NULL, sensors[k], measured(values)));
            ASSERT_OK(K(step)(&track_f64, &motion_f64, NULL, &radar_f64, values));
            ASSERT_LIKE(&track_f64, &twin, 0x1p-24);
        }
        TEST_ASSERT_EQUAL_UINT(0, kq_events_q31(&twin));
        TEST_ASSERT_EQUAL_INT(k == 0, kq_log_likelihood_q31(&twin) != 0);
    }
}

TEST(bad_inputs)
{
    put_sensor(&correlated, 2, 2, range, measured_range, H, correlated_R);
    ASSERT_REFUSED(KQ_ERR_NULL, kq_sensor_init_lean_q31(NULL, &lean.table, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_sensor_init_lean_q31(&lean.sensor, NULL, NULL));
    ASSERT_REFUSED(KQ_ERR_TABLE, kq_sensor_init_lean_q31(&lean.sensor, &correlated.table, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, kq_update_q31(&track, &lean.sensor, NULL));
    lean.noise[0].mantissa = -lean.noise[0].mantissa;
    ASSERT_REFUSED(KQ_ERR_TABLE, kq_sensor_init_lean_q31(&lean.sensor, &lean.table, NULL));
}

SUITE(lean_q31, set_up)
#include "lean_q31.tests"
