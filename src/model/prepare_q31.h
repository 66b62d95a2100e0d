/*
 * Tables of the q31 arithmetic from doubles.  Every operation is exact or correctly rounded, and in
 * one order, so the bytes are the same on every machine whose double is IEEE's.
 */
#ifndef KQ_SRC_MODEL_PREPARE_Q31_H
#define KQ_SRC_MODEL_PREPARE_Q31_H

#include "kalmanq/prepare.h"

#include "kalmanq/process.h"
#include "../arithmetic/scaled_q31.h"
#include "../arithmetic/size.h"
#include "../arithmetic/triangle.h"

static int is_finite(double a) { return a - a == 0; }

/* a 2^exponent, exact unless it leaves the range of double */
static double scaled_double(double a, int exponent)
{
    for (; exponent > 0; exponent--) a *= 2;
    for (; exponent < 0; exponent++) a *= 0.5;
    return a;
}

/* The exponent of |a| = m 2^exponent, 1/2 <= m < 1; a is neither 0 nor infinite: at most 1074
   halvings or doublings. */
static int exponent_of(double a)
{
    int exponent = 0;
    a = a < 0 ? -a : a;
    for (; a >= 1; a *= 0.5) exponent++;
    for (; a < 0.5; a *= 2) exponent--;
    return exponent;
}

/* a to the nearest integer, |a| < 2^31 - 1/2.  What is left of a is exact; a + 1/2 is not. */
static int32_t rounded(double a)
{
    const int32_t whole = (int32_t)a;
    const double rest = a - whole;
    return whole + (rest >= 0.5) - (rest <= -0.5);
}

/* Is |a| 2^31 once it is rounded to 31 bits? 2^30 <= |a| < 2^31 */
static int is_rounded_up(double a) { return a >= INT32_MAX + 0.5 || a <= -INT32_MAX - 0.5; }

static kq_status fractions_check(const kq_format_q31 *format, int count)
{
    for (int i = 0; i < count; i++) {
        if (format[i].fraction < KQ_FRACTION_MIN_Q31) return KQ_ERR_SIZE;
        if (format[i].fraction > KQ_FRACTION_MAX_Q31) return KQ_ERR_SIZE;
    }
    return KQ_OK;
}

/* ------------------------------------------------------------------ formats and words */

/* The format with the most fraction bits that holds +-range */
static kq_status format_of_range(kq_format_q31 *format, double range)
{
    if (!is_finite(range)) return KQ_ERR_NOT_FINITE;
    if (!(range > 0)) return KQ_ERR_RANGE;
    int fraction = 31 - exponent_of(range);
    if (fraction > KQ_FRACTION_MAX_Q31) return KQ_ERR_RANGE;
    double word = scaled_double(range, fraction); /* 2^30 <= word < 2^31 */
    if (word > INT32_MAX) {
        fraction--;
        word *= 0.5;
    }
    if (fraction < KQ_FRACTION_MIN_Q31) return KQ_ERR_RANGE;
    const int32_t whole = (int32_t)word;
    *format = (kq_format_q31){.range = whole + (whole < word), .fraction = fraction};
    return KQ_OK;
}

kq_status kq_format_prepare_q31(kq_format_q31 *format, int fraction, double range,
                                kq_range_error_q31 *range_error)
{
    kq_format_q31 best;
    if (!format) return KQ_ERR_NULL;
    if (fraction == KQ_FRACTION_BEST_Q31) return format_of_range(format, range);
    if (fraction < KQ_FRACTION_MIN_Q31 || fraction > KQ_FRACTION_MAX_Q31) return KQ_ERR_SIZE;
    const kq_status status = format_of_range(&best, range);
    if (status) return status;
    if (best.fraction < fraction) {
        if (range_error) *range_error = (kq_range_error_q31){.bits = fraction - best.fraction};
        return KQ_ERR_RANGE;
    }
    const double word = scaled_double(range, fraction);
    if (word < 0.5) return KQ_ERR_RANGE;
    const int32_t whole = (int32_t)word;
    *format = (kq_format_q31){.range = whole + (whole < word), .fraction = fraction};
    return KQ_OK;
}

/* The integer bits that x lacks as a word, 0 or less where it has them */
static int missing_bits(double x, int fraction)
{
    if (x == 0) return 0;
    const int exponent = exponent_of(x);
    return exponent + fraction - 31 + is_rounded_up(scaled_double(x, 31 - exponent));
}

/* x as a word, or what it lacks: -1, or the integer bits that its format would need more, 0 where x
   is beyond the declared range alone.  They are looked at first: a word that is made is below 2^31. */
static int word_of_double(int32_t *made, double x, const kq_format_q31 *format)
{
    const int bits = missing_bits(x, format->fraction);
    if (bits > 0) return bits;
    const double word = scaled_double(x, format->fraction), size = word < 0 ? -word : word;
    if (size >= format->range + 0.5) return 0;
    *made = rounded(word);
    return -1;
}

kq_status kq_vector_prepare_q31(int32_t *words, const double *x, int count,
                                const kq_format_q31 *format, kq_range_error_q31 *range_error)
{
    int32_t made[KQ_SIZE_MAX];
    if (!words || !x || !format) return KQ_ERR_NULL;
    if (!size_is_valid(count) || fractions_check(format, count)) return KQ_ERR_SIZE;
    for (int i = 0; i < count; i++) {
        if (!is_finite(x[i])) return KQ_ERR_NOT_FINITE;
    }
    for (int i = 0; i < count; i++) {
        const int bits = word_of_double(&made[i], x[i], &format[i]);
        if (bits >= 0) {
            if (range_error) *range_error = (kq_range_error_q31){.component = i, .bits = bits};
            return KQ_ERR_RANGE;
        }
    }
    for (int i = 0; i < count; i++) words[i] = made[i];
    return KQ_OK;
}

/* ------------------------------------------------------------------ coefficients */

/* a 2^shift to 31 bits; KQ_ERR_COEFFICIENT if its exponent is beyond the limit */
static kq_status coefficient_of(kq_scaled_q31 *out, double a, int shift)
{
    *out = (kq_scaled_q31){0, 0};
    if (a == 0) return KQ_OK;
    int exponent = exponent_of(a);
    double mantissa = scaled_double(a, 31 - exponent); /* 2^30 <= |mantissa| < 2^31 */
    if (is_rounded_up(mantissa)) {
        mantissa *= 0.5;
        exponent++;
    }
    out->mantissa = rounded(mantissa);
    out->exponent = exponent - 31 + shift;
    const int32_t most = KQ_EXPONENT_MAX_Q31;
    return out->exponent > most || out->exponent < -most ? KQ_ERR_COEFFICIENT : KQ_OK;
}

kq_status kq_matrix_prepare_q31(kq_scaled_q31 *table, const double *M, int rows, int columns,
                                const kq_format_q31 *row_format, const kq_format_q31 *column_format)
{
    kq_scaled_q31 trial;
    if (!table || !M || !row_format || !column_format) return KQ_ERR_NULL;
    if (!size_is_valid(rows) || !size_is_valid(columns)) return KQ_ERR_SIZE;
    if (fractions_check(row_format, rows) || fractions_check(column_format, columns)) {
        return KQ_ERR_SIZE;
    }
    for (int k = 0; k < rows * columns; k++) {
        if (!is_finite(M[k])) return KQ_ERR_NOT_FINITE;
    }
    for (int write = 0; write <= 1; write++) {
        for (int k = 0; k < rows * columns; k++) {
            const int shift =
                row_format[k / columns].fraction - column_format[k % columns].fraction;
            const kq_status status = coefficient_of(write ? table + k : &trial, M[k], shift);
            if (status) return status;
        }
    }
    return KQ_OK;
}

/* ------------------------------------------------------------------ roots */

/* The triangular root T of a covariance, or of F F': that of a process in double. */
static kq_status root_of_matrix(double *T, const double *P, const double *F, int n, int r)
{
    static const double A[KQ_SIZE_MAX * KQ_SIZE_MAX];
    kq_process_f64 p;
    kq_status status = kq_process_assign_f64(&p, n, 0, T, KQ_PROCESS_LEN(KQ_SIZE_MAX));
    if (!status && P) status = kq_process_init_f64(&p, A, NULL, P);
    else if (!status) status = kq_process_init_factor_f64(&p, A, NULL, F, r);
    for (int i = 0; i < n && !status; i++) {
        double *pivot = T + column(i) + i;
        if (*pivot <= 0x1p-200) *pivot = 0; /* the process needs a pivot, a table does not */
    }
    return status;
}

/* Row i of T in units of 2^exponent words: as large as a row may be */
static kq_status root_row_of(int32_t *root, const double *T, int n, int i, int fraction)
{
    double largest = 0;
    for (int j = i; j < n; j++) {
        const double entry = T[column(j) + i], size = entry < 0 ? -entry : entry;
        if (size > largest) largest = size;
    }
    const int bits = n - i <= 1 ? 30 : n - i <= 4 ? 29 : 28; /* 2^bits sqrt(n - i) <= 2^30 */
    int exponent = largest > 0 ? exponent_of(largest) - bits : lowest_exponent - fraction;
    if (largest > 0 && rounded(scaled_double(largest, -exponent)) >> bits) exponent++;
    for (int j = i; j < n; j++) {
        const int k = column(j) + i;
        root[k] = largest > 0 ? rounded(scaled_double(T[k], -exponent)) : 0;
    }
    root[KQ_TRIANGLE(n) + i] = exponent + fraction;
    const int32_t own = exponent + fraction, most = KQ_EXPONENT_MAX_Q31;
    return largest > 0 && (own > most || own < -most) ? KQ_ERR_COEFFICIENT : KQ_OK;
}

static kq_status root_prepare(int32_t *root, const double *P, const double *F, int n, int r,
                              const kq_format_q31 *format)
{
    double T[KQ_TRIANGLE(KQ_SIZE_MAX)];
    int32_t made[KQ_ROOT_LEN_Q31(KQ_SIZE_MAX)];
    if (!root || !format) return KQ_ERR_NULL;
    if (!size_is_valid(n) || fractions_check(format, n)) return KQ_ERR_SIZE;
    kq_status status = root_of_matrix(T, P, F, n, r);
    for (int i = 0; i < n && !status; i++) status = root_row_of(made, T, n, i, format[i].fraction);
    for (int k = 0; k < KQ_ROOT_LEN_Q31(n) && !status; k++) root[k] = made[k];
    return status;
}

kq_status kq_root_prepare_q31(int32_t *root, const double *P, int n, const kq_format_q31 *format)
{
    return P ? root_prepare(root, P, NULL, n, 0, format) : KQ_ERR_NULL;
}

kq_status kq_root_prepare_factor_q31(int32_t *root, const double *F, int n, int r,
                                     const kq_format_q31 *format)
{
    return root_prepare(root, NULL, F, n, r, format);
}

/* ------------------------------------------------------------------ noises */

kq_status kq_noise_prepare_diagonal_q31(kq_scaled_q31 *table, const double *r, int m,
                                        const kq_format_q31 *format)
{
    kq_scaled_q31 made[KQ_SIZE_MAX];
    if (!table || !r || !format) return KQ_ERR_NULL;
    if (!size_is_valid(m) || fractions_check(format, m)) return KQ_ERR_SIZE;
    for (int c = 0; c < m; c++) {
        if (!is_finite(r[c])) return KQ_ERR_NOT_FINITE;
        if (r[c] < 0) return KQ_ERR_NOT_SEMIDEFINITE;
    }
    for (int c = 0; c < m; c++) {
        const kq_status status = coefficient_of(&made[c], r[c], 2 * format[c].fraction);
        if (status) return status;
    }
    for (int c = 0; c < m; c++) table[c] = made[c];
    return KQ_OK;
}

/* R's variances are rounded, and so is what the other components leave of one: a pivot whose square
   is up to 8 m eps of its row's is none, and what its column holds goes into the others. */
static kq_status drop_dependent(double *T, int m)
{
    double F[KQ_SIZE_MAX * KQ_SIZE_MAX];
    kq_status status = KQ_OK;
    for (int k = m - 1; k >= 0 && !status; k--) {
        double pivot = T[column(k) + k] * T[column(k) + k], row = pivot;
        for (int j = k + 1; j < m; j++) row += T[column(j) + k] * T[column(j) + k];
        if (pivot == 0 || pivot > 8 * m * 0x1p-52 * row) continue;
        for (int i = 0; i < m * m; i++) F[i] = i / m > i % m ? 0 : T[column(i % m) + i / m];
        F[k * m + k] = 0;
        status = root_of_matrix(T, NULL, F, m, m);
    }
    return status;
}

kq_status kq_noise_prepare_q31(kq_scaled_q31 *table, const double *R, int m,
                               const kq_format_q31 *format)
{
    double T[KQ_TRIANGLE(KQ_SIZE_MAX)];
    kq_scaled_q31 made[KQ_TRIANGLE(KQ_SIZE_MAX)];
    if (!table || !R || !format) return KQ_ERR_NULL;
    if (!size_is_valid(m) || fractions_check(format, m)) return KQ_ERR_SIZE;
    kq_status status = root_of_matrix(T, R, NULL, m, 0);
    if (!status) status = drop_dependent(T, m);
    for (int j = 0; j < m && !status; j++) {
        const double pivot = T[column(j) + j];
        for (int i = 0; i < j && !status; i++) {
            const int shift = format[i].fraction - format[j].fraction;
            const double U = pivot > 0 ? T[column(j) + i] / pivot : 0;
            status = coefficient_of(&made[column(j) + i], U, shift);
        }
        if (status) break;
        status = coefficient_of(&made[column(j) + j], pivot * pivot, 2 * format[j].fraction);
    }
    for (int k = 0; k < KQ_TRIANGLE(m) && !status; k++) table[k] = made[k];
    return status;
}

#endif
