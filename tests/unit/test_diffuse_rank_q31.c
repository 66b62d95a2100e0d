/* The unknown start beside exact arithmetic, in fixed point. */
#include "q31.h"

#define S(name) kq_##name##_q31

enum { SQUARE = KQ_SIZE_MAX * KQ_SIZE_MAX };

static kq_format_q31 format[KQ_SIZE_MAX], measured_format[1];
static kq_scaled_q31 transition[SQUARE], measurement[KQ_SIZE_MAX], noise[1];
static int32_t process_root[KQ_ROOT_LEN_Q31(KQ_SIZE_MAX)], prior_root[KQ_ROOT_LEN_Q31(KQ_SIZE_MAX)];
static kq_process_table_q31 process_table;
static kq_sensor_table_q31 sensor_table;
static kq_process_q31 process;
static kq_sensor_q31 sensor;
KQ_FILTER_Q31(filter, KQ_SIZE_MAX);
KQ_DIFFUSE_Q31(start, KQ_SIZE_MAX, 0);

static void put_model(int n, const double *A, const double *h)
{
    static double Q[SQUARE];
    static const double R[] = {1};
    const double range = 1e4;
    for (int i = 0; i < n; i++) ASSERT_OK(kq_format_prepare_q31(&format[i], KQ_FRACTION_BEST_Q31, range, NULL));
    ASSERT_OK(kq_format_prepare_q31(measured_format, KQ_FRACTION_BEST_Q31, range, NULL));
    for (int k = 0; k < n * n; k++) Q[k] = k % (n + 1) ? 0 : 0.0625;
    ASSERT_OK(kq_matrix_prepare_q31(transition, A, n, n, format, format));
    ASSERT_OK(kq_matrix_prepare_q31(measurement, h, 1, n, measured_format, format));
    ASSERT_OK(kq_root_prepare_q31(process_root, Q, n, format));
    ASSERT_OK(kq_noise_prepare_q31(noise, R, 1, measured_format));
    process_table = (kq_process_table_q31){.states = n,
                                           .state_format = format,
                                           .transition = transition,
                                           .noise_root = process_root};
    sensor_table = (kq_sensor_table_q31){.states = n,
                                         .components = 1,
                                         .state_format = format,
                                         .measurement_format = measured_format,
                                         .measurement = measurement,
                                         .noise = noise};
    ASSERT_OK(kq_process_init_q31(&process, &process_table, NULL));
    ASSERT_OK(kq_sensor_init_q31(&sensor, &sensor_table, NULL));
}

static void begin(int n)
{
    static const double P[SQUARE];
    static const int32_t mean[KQ_SIZE_MAX];
    ASSERT_OK(kq_root_prepare_q31(prior_root, P, n, format));
    const kq_prior_table_q31 prior = {
        .states = n, .state_format = format, .mean = mean, .root = prior_root};
    ASSERT_OK(kq_filter_assign_q31(&filter, n, filter_memory, COUNT(filter_memory)));
    ASSERT_OK(kq_diffuse_assign_q31(&start, n, 0, start_memory, COUNT(start_memory)));
    ASSERT_OK(kq_diffuse_init_q31(&start, &filter, &prior, UINT32_MAX, NULL));
}

static void take(double z)
{
    ASSERT_OK(kq_update_q31(&filter, &sensor, words_of(&z, 1, measured_format)));
}

static int is_determined(int i) { return kq_mean_q31(&filter, i) != KQ_NOT_A_VALUE_Q31; }

static void advance(void) { ASSERT_OK(kq_predict_q31(&filter, &process, NULL)); }

#include "diffuse_patterns.h"

SUITE(diffuse_rank, NULL) { run_diffuse_patterns(); }
