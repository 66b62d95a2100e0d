/* A model built in double and made into q31's tables runs as it does in double. */
#include "q31.h"
#include "reading.h"

KQ_MODEL_F64(made, 3, 3, 1);
KQ_MODEL_F64(season, KQ_SEASON_STATES(4), 1, 1);
KQ_MODEL_F64(series, KQ_ARMA_STATES(3, 1), 1, 1);

static kq_format_q31 state_format[3], measurement_format[1];
static kq_scaled_q31 transition[9], measurement[3], noise_table[1];
static int32_t noise_root[KQ_ROOT_LEN_Q31(3)], mean[3], root[KQ_ROOT_LEN_Q31(3)];
static kq_process_q31 motion;
static kq_sensor_q31 sensor;
KQ_FILTER_Q31(track, 3);

/* the same in double */
PROCESS(motion_f64, 3, 0);
SENSOR(sensor_f64, 3, 1);
FILTER(track_f64, 3);

/* What a user does with a model for q31 */
static void make_tables(const kq_model_f64 *m, const double *range, double measured_range)
{
    static kq_process_table_q31 process_table;
    static kq_sensor_table_q31 sensor_table;
    static kq_prior_table_q31 prior;
    const int n = m->states;
    put_formats(state_format, range, n);
    put_formats(measurement_format, &measured_range, 1);
    ASSERT_OK(kq_matrix_prepare_q31(transition, m->A, n, n, state_format, state_format));
    ASSERT_OK(kq_root_prepare_factor_q31(noise_root, m->F, n, m->noises, state_format));
    ASSERT_OK(kq_matrix_prepare_q31(measurement, m->H, 1, n, measurement_format, state_format));
    ASSERT_OK(kq_noise_prepare_diagonal_q31(noise_table, m->R, 1, measurement_format));
    ASSERT_OK(kq_vector_prepare_q31(mean, m->x0, n, state_format, NULL));
    ASSERT_OK(kq_root_prepare_q31(root, m->P0, n, state_format));
    process_table = (kq_process_table_q31){.states = n,
                                           .state_format = state_format,
                                           .transition = transition,
                                           .noise_root = noise_root};
    sensor_table = (kq_sensor_table_q31){.states = n,
                                         .components = 1,
                                         .state_format = state_format,
                                         .measurement_format = measurement_format,
                                         .measurement = measurement,
                                         .noise = noise_table};
    prior =
        (kq_prior_table_q31){.states = n, .state_format = state_format, .mean = mean, .root = root};
    ASSERT_OK(kq_process_init_q31(&motion, &process_table, NULL));
    ASSERT_OK(kq_sensor_init_q31(&sensor, &sensor_table, NULL));
    ASSERT_OK(kq_filter_init_q31(&track, &prior, NULL));
    ASSERT_OK(K(process_init_factor)(&motion_f64, m->A, NULL, m->F, m->noises));
    ASSERT_OK(K(sensor_init_diagonal)(&sensor_f64, m->H, m->R));
    ASSERT_OK(K(filter_init)(&track_f64, m->x0, m->P0));
}

static void run_both(double size)
{
    uint32_t seed = 3;
    for (int k = 0; k < 100; k++) {
        double z = size * noise(&seed);
        const int32_t *words = words_of(&z, 1, measurement_format);
        z = ldexp(words[0], -measurement_format[0].fraction);
        ASSERT_OK(kq_update_q31(&track, &sensor, words));
        ASSERT_OK(K(update)(&track_f64, &sensor_f64, &z));
        ASSERT_LIKE(&track_f64, &track, 0x1p-21);
        ASSERT_OK(kq_predict_q31(&track, &motion, NULL));
        ASSERT_OK(K(predict)(&track_f64, &motion_f64, NULL));
    }
    TEST_ASSERT_EQUAL_HEX(0, kq_events_q31(&track));
}

static void an_acceleration_runs_in_q31(void)
{
    static const double range[] = {1000, 200, 100}, density[] = {2}, noise[] = {0.25};
    static const double variance[] = {100, 10, 1};
    ASSERT_OK(K(model_acceleration)(&made, 1, 0.5, density, noise, NULL, variance));
    make_tables(&made, range, 1000);
    run_both(5);
}

static void a_season_runs_in_q31(void)
{
    static const double range[] = {100, 100, 100}, variance[] = {4, 4, 4};
    ASSERT_OK(K(model_season)(&season, 4, 0.25, 1, NULL, variance));
    make_tables(&season, range, 100);
    run_both(2);
}

static void an_arma_runs_in_q31(void)
{
    static const double range[] = {100, 100, 100};
    static const double phi[] = {0.5, -0.25, 0.125}, theta[] = {0.75};
    ASSERT_OK(K(model_arma)(&series, phi, 3, theta, 1, 1, 0.125));
    make_tables(&series, range, 100);
    run_both(2);
}

SUITE(models, NULL)
{
    RUN_TEST(an_acceleration_runs_in_q31);
    RUN_TEST(a_season_runs_in_q31);
    RUN_TEST(an_arma_runs_in_q31);
}
