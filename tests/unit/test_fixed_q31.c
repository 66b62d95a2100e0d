/* q31's steps for sizes that the compiler knows: the same bits as those for run-time sizes. */
#include <string.h>

#include "kalmanq/extended.h"
#include "kalmanq/prepare.h"
#include "suite.h"

#include "fixed_size/kq_fixed_q31.h"

#include "fixed.h"

FIXED_SIZES(q31, int32_t, 0, dense)
FIXED_SIZES(q31, int32_t, KQ_FIXED_UPPER, upper)
FIXED_SIZES(q31, int32_t, KQ_FIXED_BARE, bare)
FIXED_STEADY(q31, int32_t, 1, 1)
FIXED_STEADY(q31, int32_t, 4, 2)

#define ASSERT_OK(call) TEST_ASSERT_EQUAL_INT(KQ_OK, call)

enum { STATES = 4, COMPONENTS = 2, STEPS = 30 };

typedef struct {
    int n, m;
    kq_status (*predict)(kq_filter_q31 *, const kq_process_q31 *, const int32_t *);
    kq_status (*update)(kq_filter_q31 *, const kq_sensor_q31 *, const int32_t *);
    kq_status (*step)(kq_filter_q31 *, const kq_process_q31 *, const int32_t *,
                      const kq_sensor_q31 *, const int32_t *);
} fixed_size;

static const fixed_size dense[] = {FIXED_ROWS(dense)}, upper[] = {FIXED_ROWS(upper)},
                        bare[] = {FIXED_ROWS(bare)};

typedef struct {
    kq_filter_q31 filter;
    int32_t memory[KQ_FILTER_LEN_Q31(STATES)];
} own_filter;

static own_filter ours, theirs; /* of compile-time sizes, and of run-time sizes */
static kq_process_q31 process_of;
static kq_sensor_q31 sensor_of;
static kq_format_q31 state_format[STATES], measurement_format[COMPONENTS], control_format[1];
static kq_scaled_q31 transition[STATES * STATES], control[STATES], rows[COMPONENTS * STATES],
    noise[COMPONENTS];
static int32_t noise_root[KQ_ROOT_LEN_Q31(STATES)], prior_root[KQ_ROOT_LEN_Q31(STATES)],
    prior_mean[STATES];
static uint32_t seed;

/* -1 .. 1 */
static double draw(void)
{
    seed = seed * 1664525 + 1013904223;
    return (double)((int)(seed >> 20) - 2048) / 2048;
}

static void make_formats(kq_format_q31 *format, int count)
{
    for (int i = 0; i < count; i++) ASSERT_OK(kq_format_prepare_q31(&format[i], KQ_FRACTION_BEST_Q31, 64 << i, NULL));
}

static void make_process(int n, int upper_only)
{
    double A[STATES * STATES], B[STATES], Q[STATES * STATES];
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            A[i * n + j] = (i == j) + (upper_only && j <= i ? 0 : draw() / 8);
            Q[i * n + j] = i == j ? 0.25 : 0.03125;
        }
        B[i] = draw() / 4;
    }
    const kq_process_table_q31 table = {n,          1,       state_format, control_format,
                                        transition, control, noise_root};
    ASSERT_OK(kq_matrix_prepare_q31(transition, A, n, n, state_format, state_format));
    ASSERT_OK(kq_matrix_prepare_q31(control, B, n, 1, state_format, control_format));
    ASSERT_OK(kq_root_prepare_q31(noise_root, Q, n, state_format));
    ASSERT_OK(kq_process_init_q31(&process_of, &table, NULL));
}

/* The first component selects a state, the others are any rows. */
static void make_sensor(int n, int m, double variance)
{
    double H[COMPONENTS * STATES], r[COMPONENTS];
    for (int k = 0; k < m * n; k++) H[k] = k < n ? k == n - 1 : draw();
    for (int c = 0; c < m; c++) r[c] = variance;
    const kq_sensor_table_q31 table = {n, m, 0, state_format, measurement_format, rows, noise};
    ASSERT_OK(kq_matrix_prepare_q31(rows, H, m, n, measurement_format, state_format));
    ASSERT_OK(kq_noise_prepare_diagonal_q31(noise, r, m, measurement_format));
    ASSERT_OK(kq_sensor_init_q31(&sensor_of, &table, NULL));
}

static void begin_filter(own_filter *f, int n)
{
    const kq_prior_table_q31 prior = {n, state_format, prior_mean, prior_root};
    ASSERT_OK(kq_filter_assign_q31(&f->filter, n, f->memory, KQ_FILTER_LEN_Q31(STATES)));
    ASSERT_OK(kq_filter_init_q31(&f->filter, &prior, NULL));
}

static void begin(int n, int m, int upper_only)
{
    double P0[STATES * STATES] = {0};
    for (int i = 0; i < n; i++) P0[i * n + i] = 4 + i;
    make_formats(state_format, n);
    make_formats(measurement_format, m);
    make_formats(control_format, 1);
    make_process(n, upper_only);
    make_sensor(n, m, 0.5);
    ASSERT_OK(kq_root_prepare_q31(prior_root, P0, n, state_format));
    begin_filter(&ours, n);
    begin_filter(&theirs, n);
}

static void draw_words(int32_t *words, int count)
{
    for (int c = 0; c < count; c++) words[c] = (int32_t)(draw() * (1 << 25));
}

static void assert_same(int line)
{
    const size_t bytes = sizeof(int32_t) * (size_t)KQ_FILTER_LEN_Q31(ours.filter.states);
    if (memcmp(ours.memory, theirs.memory, bytes) == 0 &&
        kq_events_q31(&ours.filter) == kq_events_q31(&theirs.filter)) {
        return;
    }
    UNITY_TEST_FAIL(line, "the two filters differ");
}

#define ASSERT_SAME() assert_same(__LINE__)

static void assert_same_likelihood(void)
{
    TEST_ASSERT_TRUE(kq_nis_q31(&ours.filter) == kq_nis_q31(&theirs.filter));
    TEST_ASSERT_TRUE(kq_log_likelihood_q31(&ours.filter) == kq_log_likelihood_q31(&theirs.filter));
    TEST_ASSERT_EQUAL_INT(kq_taken_q31(&theirs.filter), kq_taken_q31(&ours.filter));
}

/* predict, update and step in turns */
static void compare(const fixed_size *size, int upper_only, int with_likelihood)
{
    int32_t z[COMPONENTS], u[1];
    begin(size->n, size->m, upper_only);
    for (int t = 0; t < STEPS; t++) {
        draw_words(z, size->m);
        draw_words(u, 1);
        const int32_t *drive = t % 3 ? u : NULL;
        if (t % 2) {
            ASSERT_OK(size->step(&ours.filter, &process_of, drive, &sensor_of, z));
        } else {
            ASSERT_OK(size->predict(&ours.filter, &process_of, drive));
            ASSERT_OK(size->update(&ours.filter, &sensor_of, z));
        }
        ASSERT_OK(kq_step_q31(&theirs.filter, &process_of, drive, &sensor_of, z));
        ASSERT_SAME();
        if (with_likelihood) assert_same_likelihood();
    }
}

static void the_bits_are_those_of_run_time_sizes(void)
{
    for (size_t k = 0; k < sizeof dense / sizeof dense[0]; k++) {
        compare(&dense[k], 0, 1);
        compare(&dense[k], 1, 1);
        compare(&upper[k], 1, 1);
        compare(&bare[k], 0, 0);
    }
}

typedef kq_status steady_function(kq_steady_q31 *, const int32_t *, const int32_t *);

/* Three gains, the last one for good, with and without a control */
static void compare_steady(steady_function *step, int n, int m, int upper_only)
{
    enum { GAINS = 3 };
    static int32_t memory[KQ_STEADY_LEN_Q31(STATES)], other[KQ_STEADY_LEN_Q31(STATES)];
    static kq_scaled_q31 gains[GAINS * STATES * COMPONENTS];
    kq_steady_q31 one, two;
    begin(n, m, upper_only);
    for (int k = 0; k < GAINS * n * m; k++) {
        const double K = draw() / 8;
        ASSERT_OK(kq_matrix_prepare_q31(gains + k, &K, 1, 1, state_format, measurement_format));
    }
    ASSERT_OK(kq_steady_assign_q31(&one, n, m, memory, 2 * STATES));
    ASSERT_OK(kq_steady_assign_q31(&two, n, m, other, 2 * STATES));
    ASSERT_OK(kq_steady_init_q31(&one, &process_of, &sensor_of, prior_mean, gains, GAINS));
    ASSERT_OK(kq_steady_init_q31(&two, &process_of, &sensor_of, prior_mean, gains, GAINS));
    for (int t = 0; t < STEPS; t++) {
        int32_t z[COMPONENTS], u[1];
        draw_words(z, m);
        draw_words(u, 1);
        ASSERT_OK(step(&one, t % 3 ? u : NULL, z));
        ASSERT_OK(kq_steady_step_q31(&two, t % 3 ? u : NULL, z));
        TEST_ASSERT_EQUAL_MEMORY(other, memory, sizeof memory);
    }
    const int32_t wrong[COMPONENTS] = {0, INT32_MAX};
    if (m == 2) TEST_ASSERT_EQUAL_INT(KQ_ERR_RANGE, step(&one, NULL, wrong));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, step(&one, NULL, NULL));
    TEST_ASSERT_EQUAL_MEMORY(other, memory, sizeof memory);
}

static void the_steady_states_bits_are_those_of_run_time_sizes(void)
{
    compare_steady(steady_1_1_dense, 1, 1, 0);
    compare_steady(steady_1_1_upper, 1, 1, 1);
    compare_steady(steady_4_2_dense, 4, 2, 0);
    compare_steady(steady_4_2_dense, 4, 2, 1);
    compare_steady(steady_4_2_upper, 4, 2, 1);
    compare_steady(steady_4_2_upper, 4, 2, 0); /* is not upper triangular: taken as it is */
}

static void a_sharp_measurement_is_taken_with_care(void)
{
    int32_t z[2];
    begin(4, 2, 0);
    make_sensor(4, 2, 1e-9);
    for (int t = 0; t < 3; t++) {
        draw_words(z, 2);
        ASSERT_OK(dense[3].step(&ours.filter, &process_of, NULL, &sensor_of, z));
        ASSERT_OK(kq_step_q31(&theirs.filter, &process_of, NULL, &sensor_of, z));
        ASSERT_SAME();
        assert_same_likelihood();
    }
}

/* States within +-128, (5, 20, 0, 0) measured: the first component alone leaves state 0 at 550.
   Sharp, and not. */
static void beyond_between_components(const fixed_size *size, double r, int with_likelihood)
{
    static const double H[] = {0.0625, 1.875, 0, 0, 0.0625, 0, 0, 0};
    const double variance[] = {r, r};
    static const double z[] = {37.8125, 0.3125};
    static const double P0[] = {1e4, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    int32_t words[COMPONENTS];
    begin(4, 2, 0);
    ASSERT_OK(kq_matrix_prepare_q31(rows, H, 2, 4, measurement_format, state_format));
    ASSERT_OK(kq_noise_prepare_diagonal_q31(noise, variance, 2, measurement_format));
    ASSERT_OK(kq_sensor_change_measurement_q31(&sensor_of, rows, NULL));
    ASSERT_OK(kq_vector_prepare_q31(words, z, 2, measurement_format, NULL));
    ASSERT_OK(kq_root_prepare_q31(prior_root, P0, 4, state_format));
    begin_filter(&ours, 4);
    begin_filter(&theirs, 4);
    ASSERT_OK(size->update(&ours.filter, &sensor_of, words));
    ASSERT_OK(kq_update_q31(&theirs.filter, &sensor_of, words));
    ASSERT_SAME();
    if (with_likelihood) assert_same_likelihood();
    TEST_ASSERT_EQUAL_HEX(0, kq_events_q31(&ours.filter));
}

static void a_mean_may_leave_its_word_between_components(void)
{
    beyond_between_components(&dense[3], 1e-4, 1);
    beyond_between_components(&bare[3], 1e-4, 0);
    beyond_between_components(&dense[3], 0.5, 1);
    beyond_between_components(&bare[3], 0.5, 0);
}

static void errors_are_those_of_the_library(void)
{
    const int32_t z[2] = {1, 2}, beyond[2] = {1, INT32_MAX};
    const fixed_size *size = &dense[3];
    begin(4, 2, 0);
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, size->predict(NULL, &process_of, NULL));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NULL, size->update(&ours.filter, &sensor_of, NULL));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_RANGE, size->update(&ours.filter, &sensor_of, beyond));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_RANGE,
                          size->step(&ours.filter, &process_of, NULL, &sensor_of, beyond));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_RANGE, size->predict(&ours.filter, &process_of, beyond + 1));
    ASSERT_SAME();
    ASSERT_OK(dense[2].step(&ours.filter, &process_of, NULL, &sensor_of, z)); /* 4, 2 as they are */
    ASSERT_OK(kq_step_q31(&theirs.filter, &process_of, NULL, &sensor_of, z));
    ASSERT_SAME();
    ASSERT_OK(kq_process_change_jacobian_q31(&process_of, transition, NULL));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NOT_READY, size->predict(&ours.filter, &process_of, NULL));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_NOT_READY, size->step(&ours.filter, &process_of, NULL, &sensor_of, z));
    ASSERT_SAME();
}

static void compare_attached(const fixed_size *size)
{
    int32_t z[COMPONENTS];
    for (int t = 0; t < 2 * STEPS; t++) {
        draw_words(z, size->m);
        ASSERT_OK(size->step(&ours.filter, &process_of, NULL, &sensor_of, z));
        ASSERT_OK(kq_step_q31(&theirs.filter, &process_of, NULL, &sensor_of, z));
        ASSERT_SAME();
        assert_same_likelihood();
    }
}

static void an_adaptation_learns(void)
{
    const kq_scaled_q31 least = {INT32_C(1) << 30, -33}, most = {INT32_C(1) << 30, -27};
    const kq_adaptation_rule_q31 rule = {KQ_ADAPT_BOTH, 50, least, least, most, least, most};
    static kq_scaled_q31 memory[2][KQ_ADAPTATION_LEN_Q31(STATES, COMPONENTS)];
    static int32_t root[2][KQ_ROOT_LEN_Q31(STATES)];
    own_filter *filters[] = {&ours, &theirs};
    kq_adaptation_q31 a[2];
    begin(4, 2, 0);
    for (int i = 0; i < 2; i++) {
        ASSERT_OK(kq_adaptation_assign_q31(&a[i], 4, 2, memory[i],
                                           sizeof memory[i] / sizeof memory[i][0], root[i]));
        ASSERT_OK(kq_adaptation_init_q31(&a[i], &process_of, &sensor_of, &rule));
        ASSERT_OK(kq_attach_q31(&filters[i]->filter, &a[i].attached));
    }
    compare_attached(&dense[3]);
    TEST_ASSERT_EQUAL_MEMORY(a[0].information, a[1].information, sizeof a[0].information);
    TEST_ASSERT_TRUE(a[0].information[0].mantissa != 0);
}

static void a_settling_settles(void)
{
    static int32_t memory[2][KQ_ROOT_LEN_Q31(STATES)];
    static kq_scaled_q31 gain[2][STATES * COMPONENTS];
    own_filter *filters[] = {&ours, &theirs};
    kq_freeze_q31 w[2];
    begin(3, 2, 0);
    for (int i = 0; i < 2; i++) {
        ASSERT_OK(kq_freeze_assign_q31(&w[i], 3, 2, memory[i],
                                         sizeof memory[i] / sizeof memory[i][0], gain[i]));
        ASSERT_OK(kq_freeze_init_q31(&w[i], 6));
        ASSERT_OK(kq_attach_q31(&filters[i]->filter, &w[i].attached));
    }
    compare_attached(&dense[2]);
    TEST_ASSERT_EQUAL_INT(1, kq_freeze_is_active_q31(&w[0]));
    TEST_ASSERT_EQUAL_INT(1, kq_freeze_is_active_q31(&w[1]));
}

static void set_up(void) { seed = 1; }

SUITE(fixed, set_up)
{
    RUN_TEST(the_bits_are_those_of_run_time_sizes);
    RUN_TEST(the_steady_states_bits_are_those_of_run_time_sizes);
    RUN_TEST(a_sharp_measurement_is_taken_with_care);
    RUN_TEST(a_mean_may_leave_its_word_between_components);
    RUN_TEST(an_adaptation_learns);
    RUN_TEST(a_settling_settles);
    RUN_TEST(errors_are_those_of_the_library);
}
