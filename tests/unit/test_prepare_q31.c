/* Tables of the q31 arithmetic made from doubles. */
#include "q31.h"
#include "reading.h"
#include "unchanged.h"

static kq_format_q31 format[2];
static kq_range_error_q31 range_error;
static kq_scaled_q31 table[4];
static int32_t root[KQ_ROOT_LEN_Q31(2)], words[2];

/* Q31.0 for both components, unless a test says otherwise */
static void set_up(void)
{
    for (int i = 0; i < 2; i++) format[i] = (kq_format_q31){.range = INT32_MAX, .fraction = 0};
    range_error = (kq_range_error_q31){KQ_CONTROL, 7, 7};
    memset(table, 0x5A, sizeof table);
    memset(root, 0x5A, sizeof root);
    memset(words, 0x5A, sizeof words);
    watch_nothing();
    WATCH(format), WATCH(range_error), WATCH(table), WATCH(root), WATCH(words);
}

static const double not_finite[] = {(double)NAN, (double)INFINITY, -(double)INFINITY};

static void assert_scaled(int32_t mantissa, int32_t exponent, kq_scaled_q31 actual)
{
    TEST_ASSERT_EQUAL_INT32(mantissa, actual.mantissa);
    TEST_ASSERT_EQUAL_INT32(exponent, actual.exponent);
}

/* ----------------------------------------------------------------------------- formats */

static void assert_format(double range, int32_t word, int32_t fraction)
{
    ASSERT_OK(kq_format_prepare_q31(&format[0], KQ_FRACTION_BEST_Q31, range, NULL));
    TEST_ASSERT_EQUAL_INT32(word, format[0].range);
    TEST_ASSERT_EQUAL_INT32(fraction, format[0].fraction);
}

TEST(a_format_has_as_many_fraction_bits_as_its_range_allows)
{
    assert_format(1, 1 << 30, 30);
    assert_format(0.9375, 0x78000000, 31);
    assert_format(100, 100 << 24, 24);
    assert_format(0.1, 1717986919, 34); /* rounded up: the range is within */
    assert_format(INT32_MAX, INT32_MAX, 0);
    assert_format(2147483647.5, 1 << 30, -1); /* more than the word holds */
    assert_format(1e12, 1953125000, -9);
    assert_format(0x1p-64, 1 << 30, KQ_FRACTION_MAX_Q31);
    assert_format(0x1.8p94, 3 << 29, KQ_FRACTION_MIN_Q31);
}

TEST(a_format_needs_a_range_that_it_can_hold)
{
    static const double bad[] = {0,     -0.0,  -1,     0x1.8p-65, 0x1.fffffffffffffp-65,
                                 0x1p95, 1e300, 5e-324, DBL_MAX,   -DBL_MAX};
    ASSERT_REFUSED(KQ_ERR_NULL, kq_format_prepare_q31(NULL, KQ_FRACTION_BEST_Q31, 1, NULL));
    for (int k = 0; k < COUNT(not_finite); k++) {
        ASSERT_REFUSED(KQ_ERR_NOT_FINITE, kq_format_prepare_q31(&format[0], KQ_FRACTION_BEST_Q31, not_finite[k], NULL));
    }
    for (int k = 0; k < COUNT(bad); k++) {
        ASSERT_REFUSED(KQ_ERR_RANGE, kq_format_prepare_q31(&format[0], KQ_FRACTION_BEST_Q31, bad[k], NULL));
    }
}

TEST(a_named_format_is_the_one_named)
{
    ASSERT_OK(kq_format_prepare_q31(&format[0], 15, 100, &range_error));
    TEST_ASSERT_EQUAL_INT32(100 << 15, format[0].range);
    TEST_ASSERT_EQUAL_INT32(15, format[0].fraction);
    TEST_ASSERT_EQUAL_INT(7, range_error.bits);
    ASSERT_OK(kq_format_prepare_q31(&format[0], 0, 0.75, NULL));
    TEST_ASSERT_EQUAL_INT32(1, format[0].range);
    ASSERT_OK(kq_format_prepare_q31(&format[0], 15, 65535, NULL));
    ASSERT_OK(kq_format_prepare_q31(&format[0], KQ_FRACTION_MIN_Q31, 0x1.8p94, NULL));
    ASSERT_OK(kq_format_prepare_q31(&format[0], KQ_FRACTION_MAX_Q31, 0x1p-64, NULL));
    ASSERT_OK(kq_format_prepare_q31(&format[0], -3, 1e10, NULL));
    TEST_ASSERT_EQUAL_INT32(1250000000, format[0].range);
}

/* The bits of the range_error are those that it takes. */
static void assert_range_error(int fraction, double range, int bits)
{
    WATCH(format);
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_format_prepare_q31(&format[0], fraction, range, NULL));
    const kq_format_q31 before = format[0];
    TEST_ASSERT_EQUAL_INT(KQ_ERR_RANGE,
                          kq_format_prepare_q31(&format[0], fraction, range, &range_error));
    ASSERT_SAME_BITS(before, format[0]);
    TEST_ASSERT_EQUAL_INT(bits, range_error.bits);
    ASSERT_OK(kq_format_prepare_q31(&format[1], fraction - bits, range, NULL));
    TEST_ASSERT_EQUAL_INT(
        KQ_ERR_RANGE, kq_format_prepare_q31(&format[1], fraction - bits + 1, range, NULL));
}

TEST(a_named_format_says_how_many_bits_are_missing)
{
    assert_range_error(15, 65536, 1);
    assert_range_error(15, 65535.99999, 1);
    assert_range_error(15, 1e6, 4);
    assert_range_error(30, 100, 6);
    assert_range_error(31, 1, 1);
    assert_range_error(0, 1e12, 9);
}

TEST(a_named_format_refuses)
{
    static const int bad[] = {KQ_FRACTION_MIN_Q31 - 1, KQ_FRACTION_MAX_Q31 + 1, INT_MAX, INT_MIN};
    ASSERT_REFUSED(KQ_ERR_NULL, kq_format_prepare_q31(NULL, 15, 1, &range_error));
    for (int k = 0; k < COUNT(bad); k++) {
        ASSERT_REFUSED(KQ_ERR_SIZE, kq_format_prepare_q31(&format[0], bad[k], 1, &range_error));
    }
    for (int k = 0; k < COUNT(not_finite); k++) {
        ASSERT_REFUSED(KQ_ERR_NOT_FINITE,
                       kq_format_prepare_q31(&format[0], 15, not_finite[k], &range_error));
    }
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_format_prepare_q31(&format[0], 15, 0, &range_error));
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_format_prepare_q31(&format[0], 15, -1, &range_error));
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_format_prepare_q31(&format[0], 15, 0x1p-17, &range_error));
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_format_prepare_q31(&format[0], 65,
                                                             0x1.fffffffffffffp-65, &range_error));
}

/* ------------------------------------------------------------------------------ range_error */

static void assert_text(const char *expected, kq_quantity quantity, int component, int bits)
{
    const kq_range_error_q31 m = {quantity, component, bits};
    char text[64];
    memset(text, '?', sizeof text);
    TEST_ASSERT_EQUAL_INT(strlen(expected), kq_range_error_text_q31(&m, text, sizeof text));
    TEST_ASSERT_EQUAL_STRING(expected, text);
}

TEST(a_range_error_in_words)
{
    assert_text("state 2 needs 3 more integer bits", KQ_STATE, 2, 3);
    assert_text("control 0 needs 1 more integer bit", KQ_CONTROL, 0, 1);
    assert_text("measurement 15 needs 31 more integer bits", KQ_MEASUREMENT, 15, 31);
}

TEST(a_range_error_is_cut_where_there_is_no_room)
{
    static const char whole[] = "state 2 needs 3 more integer bits";
    const kq_range_error_q31 m = {KQ_STATE, 2, 3};
    for (size_t room = 0; room <= sizeof whole + 1; room++) {
        char text[64];
        const size_t kept = room > sizeof whole ? sizeof whole - 1 : room ? room - 1 : 0;
        memset(text, '?', sizeof text);
        TEST_ASSERT_EQUAL_INT(sizeof whole - 1, kq_range_error_text_q31(&m, text, room));
        if (kept) TEST_ASSERT_EQUAL_MEMORY(whole, text, kept);
        if (room == 0) TEST_ASSERT_EQUAL_INT('?', text[0]);
        else TEST_ASSERT_EQUAL_INT(0, text[kept]);
        TEST_ASSERT_EQUAL_INT('?', text[kept + 1]);
    }
}

TEST(no_range_error_has_no_words)
{
    const kq_range_error_q31 m = {KQ_STATE, 2, 3};
    char text[4] = "???";
    TEST_ASSERT_EQUAL_INT(0, kq_range_error_text_q31(NULL, text, sizeof text));
    TEST_ASSERT_EQUAL_STRING("", text);
    TEST_ASSERT_EQUAL_INT(33, kq_range_error_text_q31(&m, NULL, 100));
    TEST_ASSERT_EQUAL_INT(0, kq_range_error_text_q31(NULL, NULL, 0));
}

/* ------------------------------------------------------------------------------ vector */

TEST(words_are_rounded_to_nearest)
{
    static const double x[] = {1.49, -1.51};
    ASSERT_OK(kq_vector_prepare_q31(words, x, 2, format, &range_error));
    TEST_ASSERT_EQUAL_INT32(1, words[0]);
    TEST_ASSERT_EQUAL_INT32(-2, words[1]);
    format[0].fraction = 16;
    format[1].fraction = -1;
    ASSERT_OK(kq_vector_prepare_q31(words, x, 2, format, &range_error));
    TEST_ASSERT_EQUAL_INT32(97649, words[0]);
    TEST_ASSERT_EQUAL_INT32(-1, words[1]);
}

/* The sum of a half and the number below it is rounded to 1. */
TEST(what_is_just_below_a_half_is_no_word)
{
    static const double x[] = {0x1.fffffffffffffp-2, -0x1.fffffffffffffp-2}, half[] = {0.5, -0.5};
    ASSERT_OK(kq_vector_prepare_q31(words, x, 2, format, NULL));
    TEST_ASSERT_EQUAL_INT32(0, words[0]);
    TEST_ASSERT_EQUAL_INT32(0, words[1]);
    ASSERT_OK(kq_vector_prepare_q31(words, half, 2, format, NULL));
    TEST_ASSERT_EQUAL_INT32(1, words[0]);
    TEST_ASSERT_EQUAL_INT32(-1, words[1]);
}

TEST(words_may_use_the_whole_range)
{
    static const double x[] = {1000, -1000}, end[] = {INT32_MAX, -INT32_MAX}, beyond[] = {1, 1001};
    ASSERT_OK(kq_vector_prepare_q31(words, end, 2, format, NULL));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, words[0]);
    TEST_ASSERT_EQUAL_INT32(-INT32_MAX, words[1]);
    format[0].range = format[1].range = 1000;
    ASSERT_OK(kq_vector_prepare_q31(words, x, 2, format, NULL));
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_vector_prepare_q31(words, beyond, 2, format, NULL));
}

TEST(words_out_of_range_name_their_component)
{
    static const double x[] = {1, 0x1p33};
    TEST_ASSERT_EQUAL_INT(KQ_ERR_RANGE, kq_vector_prepare_q31(words, x, 2, format, &range_error));
    TEST_ASSERT_EQUAL_INT(1, range_error.component);
    TEST_ASSERT_EQUAL_INT(3, range_error.bits);
    format[1] = (kq_format_q31){.range = INT32_MAX, .fraction = -3};
    ASSERT_OK(kq_vector_prepare_q31(words, x, 2, format, &range_error));
}

/* Every function of prepare.h comes back for every size of number, in formats of any fraction. */
TEST(every_finite_number_is_taken_or_refused)
{
    static const int32_t fraction[] = {KQ_FRACTION_MIN_Q31, 0, 24, KQ_FRACTION_MAX_Q31};
    for (int k = 0; k < COUNT(fraction); k++) {
        for (int exponent = -1074; exponent < 1024; exponent++) {
            const double a = ldexp(-1, exponent), P[] = {-a, 0, 0, -a}, R[] = {-a, a / 2, a / 2, -a};
            const double F[] = {a, a, -a, a};
            format[0] = format[1] = (kq_format_q31){.range = 1000, .fraction = fraction[k]};
            const kq_status status = kq_vector_prepare_q31(words, &a, 1, format, &range_error);
            TEST_ASSERT_EQUAL_INT(exponent + fraction[k] > 9 ? KQ_ERR_RANGE : KQ_OK, status);
            TEST_ASSERT_TRUE(kq_matrix_prepare_q31(table, F, 2, 2, format, format) <= 0);
            TEST_ASSERT_TRUE(kq_noise_prepare_q31(table, R, 2, format) <= 0);
            TEST_ASSERT_TRUE(kq_noise_prepare_diagonal_q31(table, P, 1, format) <= 0);
            TEST_ASSERT_TRUE(kq_root_prepare_q31(root, P, 2, format) <= 0);
            TEST_ASSERT_TRUE(kq_root_prepare_q31(root, R, 2, format) <= 0);
            TEST_ASSERT_TRUE(kq_root_prepare_factor_q31(root, F, 2, 2, format) <= 0);
            if (exponent > 500) {
                TEST_ASSERT_EQUAL_INT(KQ_ERR_RANGE,
                                      kq_root_prepare_factor_q31(root, F, 2, 2, format));
            }
        }
    }
}

/* The bits that are missing are told, however many they are. */
TEST(words_far_out_of_range_say_how_many_bits)
{
    const double x[] = {1e308};
    format[0].fraction = 24;
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_vector_prepare_q31(words, x, 1, format, NULL));
    TEST_ASSERT_EQUAL_INT(KQ_ERR_RANGE, kq_vector_prepare_q31(words, x, 1, format, &range_error));
    TEST_ASSERT_EQUAL_INT(1024 + 24 - 31, range_error.bits);
}

/* With as many integer bits more the word fits, with one less it does not: also where rounding makes
   the word a power of 2. */
TEST(the_bits_that_are_missing_are_enough)
{
    static const double x[] = {0x1.fffffffffffffp30,  -0x1.fffffffffffffp30, 0x1.fffffffcp30,
                               0x1.fffffffbfffffp30, 0x1p31,                0x1.8p40};
    for (int k = 0; k < COUNT(x); k++) {
        format[0].fraction = 20;
        ASSERT_REFUSED(KQ_ERR_RANGE, kq_vector_prepare_q31(words, x + k, 1, format, NULL));
        TEST_ASSERT_EQUAL_INT(KQ_ERR_RANGE, kq_vector_prepare_q31(words, x + k, 1, format, &range_error));
        format[0].fraction -= range_error.bits - 1;
        TEST_ASSERT_EQUAL_INT(KQ_ERR_RANGE, kq_vector_prepare_q31(words, x + k, 1, format, NULL));
        format[0].fraction--;
        ASSERT_OK(kq_vector_prepare_q31(words, x + k, 1, format, NULL));
    }
}

/* ------------------------------------------------------------------------------ matrix */

TEST(coefficients_are_exact_where_the_numbers_are)
{
    static const double M[] = {1, -0.5, 0, 3};
    ASSERT_OK(kq_matrix_prepare_q31(table, M, 2, 2, format, format));
    assert_scaled(1 << 30, -30, table[0]);
    assert_scaled(-(1 << 30), -31, table[1]);
    assert_scaled(0, 0, table[2]);
    assert_scaled(3 << 29, -29, table[3]);
}

TEST(coefficients_are_rounded_to_31_bits)
{
    static const double M[] = {0.01, -0.01, 0x1.fffffffffp0, -1.0 / 3};
    ASSERT_OK(kq_matrix_prepare_q31(table, M, 2, 2, format, format));
    assert_scaled((int32_t)(0.01 * 0x1p37 + 0.5), -37, table[0]);
    assert_scaled(-(int32_t)(0.01 * 0x1p37 + 0.5), -37, table[1]);
    assert_scaled(1 << 30, -29, table[2]);
    assert_scaled(-1431655765, -32, table[3]);
}

TEST(coefficients_are_in_words)
{
    static const double M[] = {1, 1, 1, 1};
    format[0].fraction = 20;
    format[1].fraction = -3;
    ASSERT_OK(kq_matrix_prepare_q31(table, M, 2, 2, format, format));
    assert_scaled(1 << 30, -30, table[0]);
    assert_scaled(1 << 30, -30 + 23, table[1]);
    assert_scaled(1 << 30, -30 - 23, table[2]);
    assert_scaled(1 << 30, -30, table[3]);
}

TEST(matrix_reaches_the_largest_exponent)
{
    static const double large[] = {0x1p938}, small[] = {0x1p-970}, beyond[] = {0x1p-971};
    format[0].fraction = KQ_FRACTION_MAX_Q31 - 2;
    ASSERT_OK(kq_matrix_prepare_q31(table, large, 1, 1, &format[0], &format[1]));
    assert_scaled(1 << 30, KQ_EXPONENT_MAX_Q31, table[0]);
    ASSERT_OK(kq_matrix_prepare_q31(table, small, 1, 1, &format[1], &format[1]));
    assert_scaled(1 << 30, -KQ_EXPONENT_MAX_Q31, table[0]);
    ASSERT_REFUSED(KQ_ERR_COEFFICIENT,
                   kq_matrix_prepare_q31(table, beyond, 1, 1, &format[1], &format[1]));
}

/* ------------------------------------------------------------------------------- roots */

/* T (i, j) in units of 2^-fraction words, from the root */
static double root_value(int i, int j)
{
    return ldexp(root[j * (j + 1) / 2 + i], root[KQ_TRIANGLE(2) + i] - format[i].fraction);
}

static void assert_root(double t00, double t01, double t11)
{
    TEST_ASSERT_TRUE(root_value(0, 0) == t00);
    TEST_ASSERT_TRUE(root_value(0, 1) == t01);
    TEST_ASSERT_TRUE(root_value(1, 1) == t11);
}

TEST(roots_are_exact_where_the_numbers_are)
{
    static const double diagonal[] = {4, 0, 0, 9}, full[] = {5, 2, 2, 1}, zero[4];
    ASSERT_OK(kq_root_prepare_q31(root, diagonal, 2, format));
    assert_root(2, 0, 3);
    ASSERT_OK(kq_root_prepare_q31(root, full, 2, format));
    assert_root(1, 2, 1);
    format[0].fraction = 12;
    format[1].fraction = -5;
    ASSERT_OK(kq_root_prepare_q31(root, full, 2, format));
    assert_root(1, 2, 1);
    ASSERT_OK(kq_root_prepare_q31(root, zero, 2, format));
    for (int k = 0; k < KQ_TRIANGLE(2); k++) TEST_ASSERT_EQUAL_INT32(0, root[k]);
}

/* A row is as large as its norm allows: 29 bits for two entries, 30 for the last one. */
TEST(roots_are_as_large_as_a_row_may_be)
{
    static const double P[] = {4, 0, 0, 9}, large[] = {1e300, 0, 0, 1e300}, beyond[] = {1, 0, 0, 1e302};
    ASSERT_OK(kq_root_prepare_q31(root, large, 2, format));
    ASSERT_REFUSED(KQ_ERR_RANGE, kq_root_prepare_q31(root, beyond, 2, format));
    ASSERT_OK(kq_root_prepare_q31(root, P, 2, format));
    TEST_ASSERT_EQUAL_INT32(1 << 28, root[0]);
    TEST_ASSERT_EQUAL_INT32(-27, root[3]);
    TEST_ASSERT_EQUAL_INT32(3 << 28, root[2]);
    TEST_ASSERT_EQUAL_INT32(-28, root[4]);
}

TEST(a_singular_root_may_be_given_by_its_factor)
{
    static const double F[] = {3, 2}, wide[] = {1, 0, 0, 2, 0, 0};
    ASSERT_OK(kq_root_prepare_factor_q31(root, F, 2, 1, format));
    assert_root(0, 3, 2);
    ASSERT_OK(kq_root_prepare_factor_q31(root, wide, 2, 3, format));
    assert_root(0, 1, 2);
    ASSERT_OK(kq_root_prepare_factor_q31(root, NULL, 2, 0, format));
    assert_root(0, 0, 0);
}

/* ------------------------------------------------------------------------------ noises */

TEST(variances_are_exact_where_the_numbers_are)
{
    static const double r[] = {0.25, 0.01};
    format[0].fraction = 10;
    table[2] = (kq_scaled_q31){77, 7};
    ASSERT_OK(kq_noise_prepare_diagonal_q31(table, r, 2, format));
    assert_scaled(1 << 30, -32 + 20, table[0]);
    assert_scaled((int32_t)(0.01 * 0x1p37 + 0.5), -37, table[1]);
    assert_scaled(77, 7, table[2]); /* not written behind the last one */
}

/* [5 2; 2 1] = U D U' with U = [1 2; 0 1], D = I */
TEST(a_noise_is_U_and_D)
{
    static const double R[] = {5, 2, 2, 1}, zero[4];
    format[0].fraction = 3;
    format[1].fraction = 1;
    ASSERT_OK(kq_noise_prepare_q31(table, R, 2, format));
    assert_scaled(1 << 30, -30 + 6, table[0]);
    assert_scaled(1 << 30, -29 + 2, table[1]);
    assert_scaled(1 << 30, -30 + 2, table[2]);
    ASSERT_OK(kq_noise_prepare_q31(table, zero, 2, format));
    for (int k = 0; k < 3; k++) assert_scaled(0, 0, table[k]);
}

/* Two noises behind three components: one of them has no noise of its own. */
TEST(what_rounding_leaves_of_a_singular_noise_is_none)
{
    const kq_format_q31 formats[3] = {{1 << 20, 10}, {1 << 20, 10}, {1 << 20, 10}};
    kq_scaled_q31 noises[6];
    uint32_t seed = 11;
    for (int k = 0; k < 500; k++) {
        double N[6], R[9];
        for (int i = 0; i < 6; i++) N[i] = floor(16 * noise(&seed));
        for (int i = 0; i < 9; i++) {
            const double *a = N + 2 * (i / 3), *b = N + 2 * (i % 3);
            R[i] = a[0] * b[0] + a[1] * b[1];
        }
        ASSERT_OK(kq_noise_prepare_q31(noises, R, 3, formats));
        TEST_ASSERT_TRUE(!noises[0].mantissa || !noises[2].mantissa || !noises[5].mantissa);
    }
}

/* -------------------------------------------------------------------- tables by hand */

/* Position and speed, 0.01 s: the table that a reader of the headers would write. */
static const kq_format_q31 by_hand_format[] = {{100 << 15, 15}, {10 << 20, 20}};
static const kq_scaled_q31 by_hand_A[] = {
    {1 << 30, -30},
    {(int32_t)(0.01 * 0x1p37 + 0.5), -37 + 15 - 20},
    {0, 0},
    {1 << 30, -30},
};

TEST(a_table_by_hand_is_the_prepared_one)
{
    static const double A[] = {1, 0.01, 0, 1};
    ASSERT_OK(kq_format_prepare_q31(&format[0], 15, 100, NULL));
    ASSERT_OK(kq_format_prepare_q31(&format[1], 20, 10, NULL));
    ASSERT_SAME_BITS(by_hand_format, format);
    ASSERT_OK(kq_matrix_prepare_q31(table, A, 2, 2, format, format));
    ASSERT_SAME_BITS(by_hand_A, table);
}

SUITE(prepare_q31, set_up)
#include "prepare_q31.tests"
