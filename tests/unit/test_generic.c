/* Names without a suffix are the functions of their arithmetic: one text for C and, by test_generic.cpp, C++. */
#include <kalmanq/kalmanq.h>

#include <kalmanq/generic.h>
#include <stdio.h>

KQ_PROCESS_F32(motion_f32, 1, 0);
KQ_SENSOR_F32(radar_f32, 1, 1);
KQ_FILTER_F32(track_f32, 1);
KQ_FILTER_F32(twin_f32, 1);
KQ_HISTORY_F32(tape_f32, 1, 1, 4, 0);

KQ_PROCESS_F64(motion_f64, 1, 0);
KQ_SENSOR_F64(radar_f64, 1, 1);
KQ_FILTER_F64(track_f64, 1);
KQ_FILTER_F64(twin_f64, 1);
KQ_HISTORY_F64(tape_f64, 1, 1, 4, 0);

static kq_process_q31 motion_q31;
static kq_sensor_q31 radar_q31;
KQ_FILTER_Q31(track_q31, 1);
KQ_FILTER_Q31(twin_q31, 1);
KQ_HISTORY_Q31(tape_q31, 1, 1, 4, 0);

static kq_filter_f32 view_f32;
static kq_filter_f64 view_f64;
static kq_filter_q31 view_q31;
static int failed;

static void check(int good, const char *what, int line)
{
    if (good) return;
    printf("test_generic.c:%d: %s\n", line, what);
    failed = 1;
}

#define CHECK(good) check(good, #good, __LINE__)

/* The same run by both names */
#define RUN(T, word, number, z)                                                                    \
    static void run_##T(void)                                                                      \
    {                                                                                              \
        const kq_filter_##T *f = &track_##T;                                                       \
        word e = 0, other = 0;                                                                     \
        number P[1], Q[1];                                                                         \
        CHECK(kq_attach(&track_##T, &tape_##T.attached) == KQ_OK);                                 \
        CHECK(kq_innovation(f, &radar_##T, &z, &e) == KQ_OK);                                      \
        CHECK(kq_innovation_##T(&twin_##T, &radar_##T, &z, &other) == KQ_OK && e == other);        \
        CHECK(kq_update(&track_##T, &radar_##T, &z) == KQ_OK);                                     \
        CHECK(kq_update_##T(&twin_##T, &radar_##T, &z) == KQ_OK);                                  \
        CHECK(kq_nis(f) == kq_nis_##T(&twin_##T));                                                 \
        CHECK(kq_predict(&track_##T, &motion_##T, NULL) == KQ_OK);                                 \
        CHECK(kq_predict_##T(&twin_##T, &motion_##T, NULL) == KQ_OK);                              \
        CHECK(kq_update_subset(&track_##T, &radar_##T, &z, 1) == KQ_OK);                           \
        CHECK(kq_update_subset_##T(&twin_##T, &radar_##T, &z, 1) == KQ_OK);                        \
        CHECK(kq_step(&track_##T, &motion_##T, NULL, &radar_##T, &z) == KQ_OK);                    \
        CHECK(kq_step_##T(&twin_##T, &motion_##T, NULL, &radar_##T, &z) == KQ_OK);                 \
        CHECK(kq_mean(f, 0) == kq_mean_##T(&twin_##T, 0));                                         \
        CHECK(kq_sigma(f, 0) == kq_sigma_##T(&twin_##T, 0) && kq_sigma(f, 0) > 0);                 \
        CHECK(kq_covariance(f, P) == KQ_OK && kq_covariance_##T(&twin_##T, Q) == KQ_OK);           \
        CHECK(kq_events(f) == kq_events_##T(&twin_##T));                                           \
        CHECK(kq_log_likelihood(f) == kq_log_likelihood_##T(&twin_##T));                           \
        CHECK(kq_history_steps_##T(&tape_##T) == 3 && kq_smooth(&tape_##T) == KQ_OK);              \
        CHECK(kq_smoothed(&tape_##T, 0, &view_##T) == KQ_OK && kq_mean(&view_##T, 0) != kq_mean(f, 0)); \
        CHECK(kq_filter_copy(&twin_##T, f) == KQ_OK && kq_mean(&twin_##T, 0) == kq_mean(f, 0));    \
        kq_events_clear(&twin_##T);                                                                \
        CHECK(kq_events(&twin_##T) == 0);                                                          \
        CHECK(kq_forecast(f, &motion_##T, NULL, 2, &twin_##T) == KQ_OK);                           \
        CHECK(kq_sigma(&twin_##T, 0) > kq_sigma(f, 0));                                            \
        CHECK(kq_attach(&track_##T, &tape_##T.attached) == KQ_OK);                                 \
        CHECK(kq_detach(&tape_##T.attached) == KQ_OK && kq_history_steps_##T(&tape_##T) == 0);     \
        CHECK(kq_step(&track_##T, &motion_##T, NULL, &radar_##T, (const word *)NULL) == KQ_ERR_NULL); \
    }

static const float z_f32 = 3;
static const double z_f64 = 3;
static int32_t z_q31;

RUN(f32, float, float, z_f32)
RUN(f64, double, double, z_f64)
RUN(q31, int32_t, kq_scaled_q31, z_q31)

static void make_f32(void)
{
    static const float one[] = {1}, four[] = {4}, zero[] = {0};
    CHECK(kq_process_init(&motion_f32, one, NULL, one) == KQ_OK);
    CHECK(kq_sensor_init_diagonal(&radar_f32, one, four) == KQ_OK);
    CHECK(kq_sensor_init_lean(&radar_f32, one, four) == KQ_OK);
    CHECK(kq_sensor_init(&radar_f32, one, four) == KQ_OK);
    CHECK(kq_filter_init(&track_f32, zero, four) == KQ_OK);
    CHECK(kq_filter_init(&twin_f32, zero, four) == KQ_OK);
}

static void make_f64(void)
{
    static const double one[] = {1}, four[] = {4}, zero[] = {0};
    CHECK(kq_process_init(&motion_f64, one, NULL, one) == KQ_OK);
    CHECK(kq_sensor_init_diagonal(&radar_f64, one, four) == KQ_OK);
    CHECK(kq_sensor_init_lean(&radar_f64, one, four) == KQ_OK);
    CHECK(kq_sensor_init(&radar_f64, one, four) == KQ_OK);
    CHECK(kq_filter_init(&track_f64, zero, four) == KQ_OK);
    CHECK(kq_filter_init(&twin_f64, zero, four) == KQ_OK);
}

static void make_q31(void)
{
    static const double one[] = {1}, four[] = {4}, zero[] = {0}, three[] = {3};
    static kq_format_q31 format[1];
    static kq_scaled_q31 unit[1], noise[1];
    static int32_t step[KQ_ROOT_LEN_Q31(1)], root[KQ_ROOT_LEN_Q31(1)], mean[1];
    static kq_process_table_q31 process;
    static kq_sensor_table_q31 sensor;
    static kq_prior_table_q31 prior;
    CHECK(kq_format_prepare_q31(format, KQ_FRACTION_BEST_Q31, 100, NULL) == KQ_OK);
    CHECK(kq_matrix_prepare_q31(unit, one, 1, 1, format, format) == KQ_OK);
    CHECK(kq_root_prepare_q31(step, one, 1, format) == KQ_OK);
    CHECK(kq_root_prepare_q31(root, four, 1, format) == KQ_OK);
    CHECK(kq_noise_prepare_diagonal_q31(noise, four, 1, format) == KQ_OK);
    CHECK(kq_vector_prepare_q31(mean, zero, 1, format, NULL) == KQ_OK);
    CHECK(kq_vector_prepare_q31(&z_q31, three, 1, format, NULL) == KQ_OK);
    process.states = sensor.states = sensor.components = prior.states = 1;
    process.state_format = sensor.state_format = sensor.measurement_format = prior.state_format = format;
    process.transition = sensor.measurement = unit;
    process.noise_root = step;
    sensor.noise = noise;
    prior.mean = mean;
    prior.root = root;
    CHECK(kq_process_init(&motion_q31, &process, NULL) == KQ_OK);
    CHECK(kq_sensor_init_diagonal(&radar_q31, &sensor, NULL) == KQ_OK);
    CHECK(kq_sensor_init_lean(&radar_q31, &sensor, NULL) == KQ_OK);
    CHECK(kq_sensor_init(&radar_q31, &sensor, NULL) == KQ_OK);
    CHECK(kq_filter_init(&track_q31, &prior, NULL) == KQ_OK);
    CHECK(kq_filter_init(&twin_q31, &prior, NULL) == KQ_OK);
}

int main(void)
{
    make_f32(), make_f64(), make_q31();
    run_f32(), run_f64(), run_q31();
    puts(failed ? "FAIL" : "OK");
    return failed;
}
