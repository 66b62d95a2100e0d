/* Process, sensor and prior in q31: what init takes, what it refuses, and what it says of it. */
#include "q31.h"
#include "reading.h"
#include "turned.h"
#include "unchanged.h"

static process_model motion;
static sensor_model radar;
static prior_model start;
static kq_range_error_q31 range_error;
static kq_process_q31 blank_process;
static kq_sensor_q31 blank_sensor;
KQ_FILTER_Q31(track, 2);

static const double range[] = {100, 10}, drive_range[] = {5}, measured_range[] = {100, 100};
static const double A[] = {1, 0.5, 0, 1}, B[] = {0.125, 0.5}, Q[] = {0.25, 0.125, 0.125, 0.5};
static const double H[] = {1, 0, 0.5, 1}, R[] = {0.5, 0.25, 0.25, 1};
static const double x0[] = {1, -2}, P0[] = {2, 0.5, 0.5, 1};

static void set_up(void)
{
    put_process(&motion, 2, 1, range, drive_range, A, B, Q);
    put_sensor(&radar, 2, 2, range, measured_range, H, R);
    put_prior(&start, 2, range, x0, P0);
    ASSERT_OK(kq_filter_assign_q31(&track, 2, track_memory, COUNT(track_memory)));
    ASSERT_OK(kq_filter_init_q31(&track, &start.table, NULL));
    range_error = (kq_range_error_q31){KQ_CONTROL, 7, 7};
    watch_nothing();
    WATCH(motion), WATCH(radar), WATCH(start), WATCH(range_error), WATCH(track), WATCH(track_memory);
    WATCH(blank_process), WATCH(blank_sensor);
}

static kq_status init_process(void)
{
    return kq_process_init_q31(&motion.process, &motion.table, &range_error);
}

static kq_status init_sensor(void)
{
    return kq_sensor_init_q31(&radar.sensor, &radar.table, &range_error);
}

static kq_status init_filter(void) { return kq_filter_init_q31(&track, &start.table, &range_error); }

static void assert_range_error_of(const kq_range_error_q31 *found, kq_quantity quantity, int component, int bits)
{
    TEST_ASSERT_EQUAL_INT(quantity, found->quantity);
    TEST_ASSERT_EQUAL_INT(component, found->component);
    TEST_ASSERT_EQUAL_INT(bits, found->bits);
}

typedef kq_status initialise(void);

/* ------------------------------------------------------------------- what all refuse */

static const int32_t bad_sizes[] = {0, -1, 17, 258, INT32_MAX, INT32_MIN};

static void assert_size_is_checked(int32_t *size, int zero_is_good, initialise *init)
{
    for (int k = zero_is_good; k < COUNT(bad_sizes); k++) ASSERT_REFUSED_WITH(*size, bad_sizes[k], KQ_ERR_SIZE, init());
    ASSERT_OK(init());
}

/* Each entry: fractions and ranges that are none */
static void assert_formats_are_checked(kq_format_q31 *format, int count, initialise *init)
{
    static const int32_t ranges[] = {0, -1, INT32_MIN};
    static const int32_t fractions[] = {KQ_FRACTION_MIN_Q31 - 1, KQ_FRACTION_MAX_Q31 + 1, INT32_MAX,
                                        INT32_MIN};
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < COUNT(ranges); k++) ASSERT_REFUSED_WITH(format[i].range, ranges[k], KQ_ERR_TABLE, init());
        for (int k = 0; k < COUNT(fractions); k++) {
            ASSERT_REFUSED_WITH(format[i].fraction, fractions[k], KQ_ERR_TABLE, init());
        }
        const int32_t good = format[i].fraction;
        format[i].fraction = KQ_FRACTION_MAX_Q31; /* a format, though nothing else may go with it */
        TEST_ASSERT_TRUE(init() != KQ_ERR_TABLE);
        format[i].fraction = KQ_FRACTION_MIN_Q31;
        TEST_ASSERT_TRUE(init() != KQ_ERR_TABLE);
        format[i].fraction = good;
    }
    ASSERT_OK(init());
}

static void assert_coefficients_are_checked(kq_scaled_q31 *a, int count, initialise *init)
{
    static const kq_scaled_q31 bad[] = {
        {(1 << 30) - 1, -30}, {-(1 << 30) + 1, -30}, {1, 0},
        {INT32_MIN, -31},     {1 << 30, -1001},      {0, -1001},
        {1 << 30, INT32_MIN}, {0, INT32_MAX},        {1 << 30, 1001}};
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < COUNT(bad); k++) ASSERT_REFUSED_WITH(a[i], bad[k], KQ_ERR_COEFFICIENT, init());
    }
    ASSERT_OK(init());
}

/* The root of 2 states: row 0 is words 0 and 1, row 1 word 2, the exponents words 3 and 4. */
static void assert_root_is_checked(int32_t *root, initialise *init)
{
    static const int32_t bad[][2] = {{0, -1},        {2, -1},        {2, (1 << 30) + 1},
                                     {1, INT32_MIN}, {1, INT32_MAX}, {3, 1001},
                                     {4, -1001},     {3, INT32_MAX}, {4, INT32_MIN}};
    int32_t good[KQ_ROOT_LEN_Q31(2)];
    memcpy(good, root, sizeof good);
    for (int k = 0; k < COUNT(bad); k++) ASSERT_REFUSED_WITH(root[bad[k][0]], bad[k][1], KQ_ERR_TABLE, init());
    root[0] = root[1] = 1 << 30; /* the norm is above 2^30, though no entry is */
    ASSERT_REFUSED(KQ_ERR_TABLE, init());
    memcpy(root, good, sizeof good);
    ASSERT_OK(init());
}

/* ----------------------------------------------------------------------------- process */

TEST(process_refuses_null)
{
    ASSERT_REFUSED_WITH(motion.table.state_format, NULL, KQ_ERR_NULL, init_process());
    ASSERT_REFUSED_WITH(motion.table.control_format, NULL, KQ_ERR_NULL, init_process());
    ASSERT_REFUSED_WITH(motion.table.transition, NULL, KQ_ERR_NULL, init_process());
    ASSERT_REFUSED_WITH(motion.table.control, NULL, KQ_ERR_NULL, init_process());
    ASSERT_REFUSED_WITH(motion.table.noise_root, NULL, KQ_ERR_NULL, init_process());
}

TEST(process_needs_no_control_arrays_without_controls)
{
    motion.table.controls = 0;
    motion.table.control_format = NULL;
    motion.table.control = NULL;
    ASSERT_OK(init_process());
    ASSERT_OK(kq_predict_q31(&track, &motion.process, NULL));
}

TEST(process_checks_its_table)
{
    assert_size_is_checked(&motion.table.states, 0, init_process);
    assert_size_is_checked(&motion.table.controls, 1, init_process);
    assert_formats_are_checked(motion.state_format, 2, init_process);
    assert_formats_are_checked(motion.control_format, 1, init_process);
    assert_coefficients_are_checked(motion.transition, 4, init_process);
    assert_coefficients_are_checked(motion.control, 2, init_process);
    assert_root_is_checked(motion.noise_root, init_process);
}

/* a 2^-30, of any size, as a coefficient */
static kq_scaled_q31 coefficient(double a)
{
    int exponent;
    const double share = frexp(a, &exponent);
    if (a == 0) return (kq_scaled_q31){0, 0};
    return (kq_scaled_q31){(int32_t)(share * 0x1p31), exponent - 31};
}

/* Row 1 of A with a large coefficient: `bits` more integer bits, and not one less, make it fit. */
static void assert_state_range_error(double large, int bits)
{
    motion.transition[2] = coefficient(large);
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_process_init_q31(&motion.process, &motion.table, NULL));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_RANGE, init_process());
    assert_range_error_of(&range_error, KQ_STATE, 1, bits);
    motion.transition[2] = coefficient(ldexp(large, 1 - bits));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_RANGE, init_process());
    motion.transition[2] = coefficient(ldexp(large, -bits));
    ASSERT_OK(init_process());
}

TEST(the_overflow_check_names_component_and_bits)
{
    motion.control[1] = coefficient(0);
    assert_state_range_error(15.01, 1);
    assert_state_range_error(29.99, 1);
    assert_state_range_error(30.01, 2);
    assert_state_range_error(1e6, 17);
    motion.transition[2] = coefficient(14.9999);
    ASSERT_OK(init_process());
}

/* In doubles: a speed in too small a word.  The format with the bits that the range_error names does. */
TEST(a_format_with_the_bits_named_fits)
{
    static const double fast[] = {1, 0, 1000, 1};
    kq_format_q31 *format = motion.state_format;
    ASSERT_OK(kq_format_prepare_q31(&format[0], 15, 100, NULL));
    ASSERT_OK(kq_format_prepare_q31(&format[1], 24, 100, NULL));
    motion.table.controls = 0;
    ASSERT_OK(kq_matrix_prepare_q31(motion.transition, fast, 2, 2, format, format));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_RANGE, init_process());
    TEST_ASSERT_EQUAL_INT(1, range_error.component);
    for (int less = 1; less >= 0; less--) {
        format[1].fraction = 24 - range_error.bits + less;
        ASSERT_OK(kq_matrix_prepare_q31(motion.transition, fast, 2, 2, format, format));
        TEST_ASSERT_EQUAL_INT(less ? KQ_ERR_RANGE : KQ_OK,
                              kq_process_init_q31(&motion.process, &motion.table, NULL));
    }
}

TEST(a_control_counts_as_a_part_of_its_state)
{
    motion.control[0] = coefficient(15.5);
    TEST_ASSERT_EQUAL_INT(KQ_ERR_RANGE, init_process());
    assert_range_error_of(&range_error, KQ_STATE, 0, 1);
}

/* No format makes A_ii smaller. */
TEST(a_state_cannot_grow_beyond_16_times_itself)
{
    motion.transition[0] = coefficient(16.01);
    ASSERT_REFUSED(KQ_ERR_COEFFICIENT, init_process());
}

/* Also where the range_error was never written, or told of another table */
TEST(what_fits_is_said_to_fit)
{
    static kq_status (*const init[])(void) = {init_process, init_sensor, init_filter};
    char text[40];
    for (int k = 0; k < 3; k++) {
        range_error = (kq_range_error_q31){KQ_STATE, 0, 0};
        ASSERT_OK(init[k]());
        TEST_ASSERT_EQUAL_INT(KQ_NO_RANGE_ERROR, range_error.quantity);
        TEST_ASSERT_EQUAL_INT(15, kq_range_error_text_q31(&range_error, text, sizeof text));
        TEST_ASSERT_EQUAL_STRING("all formats fit", text);
    }
    ASSERT_OK(kq_process_init_q31(&motion.process, &motion.table, NULL));
}

TEST(change_transition_names_the_row)
{
    kq_scaled_q31 other[4];
    kq_range_error_q31 found;
    memcpy(other, motion.transition, sizeof other);
    other[2] = coefficient(17);
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_process_change_transition_q31(&motion.process, other, NULL));
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_process_change_transition_q31(&motion.process, other, &found));
    assert_range_error_of(&found, KQ_STATE, 1, 1);
    other[2] = (kq_scaled_q31){1, 0};
    ASSERT_REFUSED(KQ_ERR_COEFFICIENT, kq_process_change_transition_q31(&motion.process, other, &found));
    assert_range_error_of(&found, KQ_STATE, 1, 0);
    memcpy(other, motion.transition, sizeof other);
    other[3] = coefficient(17);
    found.component = 0;
    ASSERT_REFUSED(KQ_ERR_COEFFICIENT, kq_process_change_transition_q31(&motion.process, other, &found));
    assert_range_error_of(&found, KQ_STATE, 1, 0);
    ASSERT_OK(kq_process_change_transition_q31(&motion.process, motion.transition, &found));
    assert_range_error_of(&found, KQ_NO_RANGE_ERROR, 0, 0);
}

TEST(change_transition_moves_otherwise)
{
    static const double faster[] = {1, 2, 0, 1};
    PROCESS(expected, 2, 1);
    FILTER(twin, 2);
    static kq_scaled_q31 other[4];
    ASSERT_OK(kq_matrix_prepare_q31(other, faster, 2, 2, motion.state_format, motion.state_format));
    ASSERT_OK(kq_process_change_transition_q31(&motion.process, other, NULL));
    ASSERT_OK(K(process_init)(&expected, faster, B, Q));
    ASSERT_OK(K(filter_init)(&twin, x0, P0));
    ASSERT_OK(kq_predict_q31(&track, &motion.process, NULL));
    ASSERT_OK(K(predict)(&twin, &expected, NULL));
    ASSERT_LIKE(&twin, &track, 0x1p-26);
}

/* ------------------------------------------------------------------------------ sensor */

TEST(sensor_refuses_null)
{
    ASSERT_REFUSED_WITH(radar.table.state_format, NULL, KQ_ERR_NULL, init_sensor());
    ASSERT_REFUSED_WITH(radar.table.measurement_format, NULL, KQ_ERR_NULL, init_sensor());
    ASSERT_REFUSED_WITH(radar.table.measurement, NULL, KQ_ERR_NULL, init_sensor());
    ASSERT_REFUSED_WITH(radar.table.noise, NULL, KQ_ERR_NULL, init_sensor());
}

TEST(sensor_checks_its_table)
{
    static const int32_t flags[] = {-1, 2, INT32_MAX, INT32_MIN};
    assert_size_is_checked(&radar.table.states, 0, init_sensor);
    assert_size_is_checked(&radar.table.components, 0, init_sensor);
    assert_formats_are_checked(radar.state_format, 2, init_sensor);
    assert_formats_are_checked(radar.measurement_format, 2, init_sensor);
    assert_coefficients_are_checked(radar.measurement, 4, init_sensor);
    assert_coefficients_are_checked(radar.noise, 3, init_sensor);
    for (int k = 0; k < COUNT(flags); k++) {
        ASSERT_REFUSED_WITH(radar.table.correlated, flags[k], KQ_ERR_TABLE, init_sensor());
    }
}

TEST(init_diagonal_is_init_of_a_diagonal_table)
{
    kq_sensor_q31 *s = &radar.sensor, other;
    radar.table.correlated = 0;
    memset(&other, 0, sizeof other);
    ASSERT_OK(kq_sensor_init_q31(&other, &radar.table, NULL));
    ASSERT_OK(kq_sensor_init_diagonal_q31(s, &radar.table, NULL));
    TEST_ASSERT_EQUAL_PTR(other.noise, s->noise);
    TEST_ASSERT_EQUAL_PTR(other.measurement, s->measurement);
    TEST_ASSERT_EQUAL_INT(other.plain, s->plain);
    TEST_ASSERT_EQUAL_INT(0, s->correlated);
}

TEST(a_variance_is_not_negative)
{
    radar.noise[2] = (kq_scaled_q31){-(1 << 30), -30};
    ASSERT_REFUSED(KQ_ERR_TABLE, init_sensor());
    radar.noise[2] = radar.noise[0];
    radar.noise[1] = (kq_scaled_q31){-(1 << 30), -30}; /* U may be */
    ASSERT_OK(init_sensor());
    radar.table.correlated = 0;
    ASSERT_REFUSED(KQ_ERR_TABLE, init_sensor());
    radar.noise[0] = (kq_scaled_q31){-(1 << 30), -30};
    ASSERT_REFUSED(KQ_ERR_TABLE, init_sensor());
}

TEST(a_measurement_without_enough_bits_is_named)
{
    static const double large[] = {17, 33, 1000};
    static const int bits[] = {1, 2, 6};
    for (int k = 0; k < COUNT(large); k++) {
        radar.measurement[2] = coefficient(0);
        radar.measurement[3] = coefficient(large[k]);
        ASSERT_REFUSED(KQ_ERR_RANGE, kq_sensor_init_q31(&radar.sensor, &radar.table, NULL));
        TEST_ASSERT_EQUAL_INT(KQ_ERR_RANGE, init_sensor());
        assert_range_error_of(&range_error, KQ_MEASUREMENT, 1, bits[k]);
        radar.measurement[3] = coefficient(ldexp(large[k], -bits[k]));
        ASSERT_OK(init_sensor());
    }
}

TEST(change_measurement_refuses)
{
    kq_scaled_q31 other[4];
    kq_range_error_q31 found = {KQ_STATE, 0, 1};
    memcpy(other, radar.measurement, sizeof other);
    other[1] = coefficient(17);
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_sensor_change_measurement_q31(&radar.sensor, other, NULL));
    other[1] = (kq_scaled_q31){1, 0};
    ASSERT_REFUSED(KQ_ERR_COEFFICIENT, kq_sensor_change_measurement_q31(&radar.sensor, other, NULL));
    ASSERT_REFUSED(KQ_ERR_COEFFICIENT, kq_sensor_change_measurement_q31(&radar.sensor, other, &found));
    assert_range_error_of(&found, KQ_MEASUREMENT, 0, 0);
    ASSERT_OK(kq_sensor_change_measurement_q31(&radar.sensor, radar.measurement, &found));
    assert_range_error_of(&found, KQ_NO_RANGE_ERROR, 0, 0);
}

/* ------------------------------------------------------------------------------ filter */

TEST(filter_refuses_null)
{
    ASSERT_REFUSED_WITH(start.table.state_format, NULL, KQ_ERR_NULL, init_filter());
    ASSERT_REFUSED_WITH(start.table.mean, NULL, KQ_ERR_NULL, init_filter());
    ASSERT_REFUSED_WITH(start.table.root, NULL, KQ_ERR_NULL, init_filter());
}

TEST(filter_checks_its_prior)
{
    kq_filter_q31 bare;
    memset(&bare, 0, sizeof bare);
    WATCH(bare);
    ASSERT_REFUSED_SIZE_OR_MEMORY(kq_filter_init_q31(&bare, &start.table, &range_error));
    for (int k = 0; k < COUNT(bad_sizes); k++) {
        ASSERT_REFUSED_WITH(start.table.states, bad_sizes[k], KQ_ERR_MISMATCH, init_filter());
    }
    assert_formats_are_checked(start.state_format, 2, init_filter);
    assert_root_is_checked(start.root, init_filter);
}

TEST(a_mean_out_of_its_range_is_refused)
{
    static const int32_t bad[] = {(10 << 27) + 1, INT32_MAX, -(10 << 27) - 1, INT32_MIN};
    TEST_ASSERT_EQUAL_INT32(10 << 27, start.state_format[1].range);
    for (int k = 0; k < COUNT(bad); k++) {
        start.mean[1] = bad[k];
        ASSERT_REFUSED(KQ_ERR_RANGE, kq_filter_init_q31(&track, &start.table, NULL));
        TEST_ASSERT_EQUAL_INT(KQ_ERR_RANGE, init_filter());
        TEST_ASSERT_EQUAL_INT(KQ_STATE, range_error.quantity);
        TEST_ASSERT_EQUAL_INT(1, range_error.component);
    }
    start.mean[1] = -(10 << 27);
    ASSERT_OK(init_filter());
}

TEST(init_sets_the_state)
{
    FILTER(twin, 2);
    ASSERT_OK(K(filter_init)(&twin, x0, P0));
    ASSERT_LIKE(&twin, &track, 0x1p-27);
    for (int i = 0; i < 2; i++) {
        TEST_ASSERT_EQUAL_INT32(start.mean[i], kq_mean_q31(&track, i));
        TEST_ASSERT_EQUAL_INT32(0, kq_mean_low_q31(&track, i));
        const double sigma = ldexp(sqrt(P0[3 * i]), start.state_format[i].fraction);
        ASSERT_WITHIN(0.51 + sigma * 0x1p-29, sigma, kq_sigma_q31(&track, i));
    }
    TEST_ASSERT_EQUAL_INT(0, kq_taken_q31(&track));
    TEST_ASSERT_TRUE(kq_nis_q31(&track) == 0 && kq_log_likelihood_q31(&track) == 0);
    TEST_ASSERT_EQUAL_HEX(0, kq_events_q31(&track));
}

/* Mean and root are the filter's own, the table may go. */
TEST(init_copies_the_prior)
{
    FILTER(twin, 2);
    memset(start.mean, 0x5A, sizeof start.mean);
    memset(start.root, 0x5A, sizeof start.root);
    ASSERT_OK(K(filter_init)(&twin, x0, P0));
    ASSERT_LIKE(&twin, &track, 0x1p-27);
}

/* ------------------------------------------------------------------- check */

static kq_status check_process(void) { return kq_process_check_q31(&motion.process); }
static kq_status check_sensor(void) { return kq_sensor_check_q31(&radar.sensor); }
static kq_status check_filter(void) { return kq_filter_check_q31(&track); }

static void assert_found(void *words, int count, kq_status (*check)(void))
{
    TEST_ASSERT_EQUAL_INT(32 * count, bits_found(words, (size_t)count * sizeof(int32_t), check));
}

/* All but padding */
TEST(check_finds_every_bit)
{
    const size_t process = 2 + KQ_SIZE_MAX + 2 + 4 + 5 * sizeof(void *), sensor = 4 + KQ_SIZE_MAX + 4 + 5 * sizeof(void *);
    TEST_ASSERT_EQUAL_INT(8 * (int)process, BITS_FOUND(motion.process, check_process));
    TEST_ASSERT_EQUAL_INT(8 * (int)sensor, BITS_FOUND(radar.sensor, check_sensor));
    assert_found(motion.noise_root, KQ_ROOT_LEN_Q31(2), check_process);
    assert_found(motion.transition, 2 * 4, check_process);
    assert_found(radar.noise, 2 * KQ_TRIANGLE(2), check_sensor);
    assert_found(radar.measurement, 2 * 4, check_sensor);
    ASSERT_ALL_FOUND(track.ready, check_filter);
    ASSERT_ALL_FOUND(track.known, check_filter);
    ASSERT_ALL_FOUND(track.memory, check_filter);
    ASSERT_ALL_FOUND(track.state_format, check_filter);
    TEST_ASSERT_GREATER_THAN_INT(32 - 23, BITS_FOUND(track.run.determinant.exponent, check_filter));
    TEST_ASSERT_GREATER_THAN_INT(2 * 8 + 2 * 18, BITS_FOUND(track_memory, check_filter)); /* low words, exponents */
}

TEST(check_takes_what_calls_have_left)
{
    uint32_t state = 1;
    for (int t = 0; t < 2000; t++) {
        const int32_t z[] = {(int32_t)(noise(&state) * 0x1p22), (int32_t)(noise(&state) * 0x1p20)};
        ASSERT_OK(kq_predict_q31(&track, &motion.process, NULL));
        ASSERT_OK(kq_filter_check_q31(&track));
        ASSERT_OK(kq_update_subset_q31(&track, &radar.sensor, z, (uint32_t)(t % 4)));
        ASSERT_OK(kq_filter_check_q31(&track));
    }
    ASSERT_OK(kq_process_change_transition_q31(&motion.process, motion.transition, NULL));
    ASSERT_OK(kq_process_check_q31(&motion.process));
    ASSERT_OK(kq_sensor_change_measurement_q31(&radar.sensor, radar.measurement, NULL));
    ASSERT_OK(kq_sensor_check_q31(&radar.sensor));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_process_check_q31(&blank_process));
    ASSERT_REFUSED(KQ_ERR_NOT_READY, kq_sensor_check_q31(&blank_sensor));
}

SUITE(model_q31, set_up)
#include "model_q31.tests"
