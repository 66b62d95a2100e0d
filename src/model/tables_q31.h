/*
 * Models in fixed point: process, sensor and prior as const tables, checked once, so that no
 * table, however corrupted, can lead to an overflow or to a loop that does not end.
 * (In floating point models are made from matrices: matrices_float.h.)
 */
#ifndef KQ_SRC_MODEL_TABLES_Q31_H
#define KQ_SRC_MODEL_TABLES_Q31_H

#include "../arithmetic/q31.h"
#include "sensor.h"

/* ------------------------------------------------------------------ checks of the parts */

KQ_COLD static kq_status formats_check(const kq_format_q31 *format, int count)
{
    for (int i = 0; i < count; i++) {
        const int32_t fraction = format[i].fraction;
        if (fraction < KQ_FRACTION_MIN_Q31 || fraction > KQ_FRACTION_MAX_Q31) return KQ_ERR_TABLE;
        if (format[i].range < 1) return KQ_ERR_TABLE;
    }
    return KQ_OK;
}

/* Coefficients are normalised, or 0: what is smaller would lose bits of the mean. */
KQ_COLD static kq_status coefficients_check(const scaled *a, int count)
{
    const int32_t most = KQ_EXPONENT_MAX_Q31;
    for (int k = 0; k < count; k++) {
        const uint32_t size = magnitude(a[k].mantissa);
        if (size > INT32_MAX || (size && size < UINT32_C(1) << 30)) return KQ_ERR_COEFFICIENT;
        if (size == 0 && a[k].exponent != 0) return KQ_ERR_COEFFICIENT;
        if (a[k].exponent > most || a[k].exponent < -most) return KQ_ERR_COEFFICIENT;
    }
    return KQ_OK;
}

/* A sum of magnitudes in units of 2^-20, each rounded up, held at 2^60 */
KQ_COLD KQ_NOINLINE static void add_magnitude(int64_t *total, scaled a)
{
    const int32_t shift = a.exponent + 20, less = (int32_t)magnitude(a.mantissa) - 1;
    int64_t part = INT64_C(1) << 59;
    if (less < 0) return;
    if (shift <= 0) part = (less >> (shift < -31 ? 31 : -shift)) + 1;
    else if (shift <= 28) part = shift_up_word(less + 1, (int)shift, 59);
    *total += part;
    if (*total > INT64_C(1) << 60) *total = INT64_C(1) << 60;
}

/*
 * A full word of every x_k must leave row i's sum of products within 16 words (mean_q31.h).  If it
 * does not, component i needs more integer bits: one halves the coefficients of the others, but
 * not that of the component itself.
 */
KQ_COLD static kq_status gain_check(int64_t own, int64_t others, kq_quantity quantity, int i,
                            kq_range_error_q31 *range_error)
{
    const int64_t most = INT64_C(16) << 20;
    int32_t bits = 0;
    if (own > most) return KQ_ERR_COEFFICIENT;
    for (; own + others > most; others >>= 1) bits++;
    if (bits == 0) return KQ_OK;
    if (range_error) *range_error = (kq_range_error_q31){.quantity = quantity, .component = i, .bits = bits};
    return KQ_ERR_RANGE;
}

/* Row norms within 2^30, exponents within their limits, pivots >= 0 */
KQ_COLD static kq_status root_check(const num *S, int n)
{
    for (int i = 0; i < n; i++) {
        const int32_t exponent = exponents_of(S, n)[i];
        uint64_t square = 0; /* in units of 16: <= 16 2^56 */
        for (int j = i; j < n; j++) {
            const uint32_t size = magnitude(S[column(j) + i]);
            if (size > UINT32_C(1) << 30) return KQ_ERR_TABLE;
            square += (product_unsigned(size, size) + 15) >> 4;
        }
        const int32_t least = square ? -KQ_EXPONENT_MAX_Q31 : lowest_exponent;
        if (square > UINT64_C(1) << 56 || S[column(i) + i] < 0) return KQ_ERR_TABLE;
        if (exponent > KQ_EXPONENT_MAX_Q31 || exponent < least) return KQ_ERR_TABLE;
    }
    return KQ_OK;
}

/* Row i is refused, and no integer bits would help. */
static kq_status row_is_refused(kq_quantity quantity, int i, kq_range_error_q31 *range_error)
{
    if (range_error) *range_error = (kq_range_error_q31){.quantity = quantity, .component = i};
    return KQ_ERR_COEFFICIENT;
}

/* Coefficients; which row has the first one that is not normalised? */
KQ_COLD static kq_status rows_check(const scaled *M, int rows, int n, kq_quantity quantity,
                                    kq_range_error_q31 *range_error)
{
    for (int i = 0; i < rows; i++) {
        if (coefficients_check(M + i * n, n)) return row_is_refused(quantity, i, range_error);
    }
    return KQ_OK;
}

/* What was found of a table that is taken */
static void say_all_fit(kq_range_error_q31 *range_error)
{
    if (!range_error) return;
    clear_bytes(range_error, sizeof *range_error);
    range_error->quantity = KQ_NO_RANGE_ERROR;
}

/* Coefficients, and the gains of the rows of M and of B, which has l columns */
KQ_COLD static kq_status gains_check(const scaled *M, int rows, int n, const scaled *B, int l, kq_quantity quantity,
                                     kq_range_error_q31 *range_error)
{
    kq_status status = coefficients_check(M, rows * n);
    if (!status) status = coefficients_check(B, rows * l);
    for (int i = 0; i < rows && !status; i++) {
        int64_t own = 0, others = 0;
        for (int k = 0; k < n; k++) add_magnitude(quantity == KQ_STATE && k == i ? &own : &others, *M++);
        for (int k = 0; k < l; k++) add_magnitude(&others, *B++);
        status = gain_check(own, others, quantity, i, range_error);
    }
    return status;
}

/* ------------------------------------------------------------------ process */

KQ_COLD static kq_status transition_check(const scaled *A, const scaled *B, int n, int l,
                                          kq_range_error_q31 *range_error)
{
    return gains_check(A, n, n, B, l, KQ_STATE, range_error);
}

/* Of an A that is refused with KQ_ERR_COEFFICIENT: the row */
KQ_COLD static void name_row(const scaled *A, int n, kq_range_error_q31 *range_error)
{
    if (rows_check(A, n, n, KQ_STATE, range_error)) return;
    for (int i = n; i-- > 0;) {
        int64_t own = 0;
        add_magnitude(&own, A[i * (n + 1)]);
        if (gain_check(own, 0, KQ_STATE, i, 0)) row_is_refused(KQ_STATE, i, range_error);
    }
}

/* ------------------------------------------------------------------ sensor */

KQ_COLD static kq_status measurement_check(const scaled *H, int m, int n, kq_range_error_q31 *range_error)
{
    return gains_check(H, m, n, 0, 0, KQ_MEASUREMENT, range_error);
}

/* Coefficients, and variances >= 0 */
KQ_COLD static kq_status noise_check(const scaled *noise, int m, int correlated)
{
    const kq_status status = coefficients_check(noise, correlated ? KQ_TRIANGLE(m) : m);
    for (int c = 0; c < m && !status; c++) {
        if (noise[correlated ? column(c) + c : c].mantissa < 0) return KQ_ERR_TABLE;
    }
    return status;
}

KQ_COLD static kq_status sensor_init_table(sensor *s, const kq_sensor_table_q31 *table,
                                           const sensor_kind *kind, kq_range_error_q31 *range_error)
{
    if (!s || !table) return KQ_ERR_NULL;
    if (table->states < 1 || table->states > KQ_SIZE_MAX) return KQ_ERR_SIZE;
    if (table->components < 1 || table->components > KQ_SIZE_MAX) return KQ_ERR_SIZE;
    const int n = (int)table->states, m = (int)table->components;
    if (!table->state_format || !table->measurement_format) return KQ_ERR_NULL;
    if (!table->measurement || !table->noise) return KQ_ERR_NULL;
    if (table->correlated != 0 && table->correlated != 1) return KQ_ERR_TABLE;
    kq_status status = formats_check(table->state_format, n);
    if (!status) status = formats_check(table->measurement_format, m);
    if (!status) status = noise_check(table->noise, m, table->correlated == 1);
    if (!status) status = measurement_check(table->measurement, m, n, range_error);
    if (status) return status;
    clear_bytes(s, sizeof *s);
    s->states = (uint8_t)n;
    s->components = (uint8_t)m;
    s->correlated = (uint8_t)table->correlated;
    s->state_format = table->state_format;
    s->measurement_format = table->measurement_format;
    s->noise = table->noise;
    s->kind = kind;
    sensor_set_measurement(s, table->measurement);
    sensor_set_plain(s);
    say_all_fit(range_error);
    return KQ_OK;
}

KQ_COLD static kq_status sensor_init_diagonal(sensor *s, const kq_sensor_table_q31 *table,
                                              const sensor_kind *kind, kq_range_error_q31 *range_error)
{
    if (!s || !table) return KQ_ERR_NULL;
    return table->correlated ? KQ_ERR_TABLE : sensor_init_table(s, table, kind, range_error);
}

/* R_jc = sum over k of U_jk D_k U_ck */
KQ_COLD static scaled noise_entry(const sensor *s, int j, int c)
{
    const scaled zero = scaled_zero();
    if (!s->correlated) return j == c ? s->noise[c] : zero;
    scaled total = zero;
    for (int k = j > c ? j : c; k < s->components; k++) {
        scaled part = s->noise[column(k) + k];
        if (j < k) part = scaled_times(part, s->noise[column(k) + j]);
        if (c < k) part = scaled_times(part, s->noise[column(k) + c]);
        total = scaled_plus(total, part);
    }
    return total;
}

/*
 * U D U' + d v v' for the first `count` components, U and D in place, v is used up (Agee and
 * Turner): nothing is subtracted from D.
 */
KQ_COLD static void noise_add(scaled *U, scaled d, scaled *v, int count)
{
    for (int j = count - 1; j >= 0 && !scaled_is_zero(d); j--) {
        const scaled old = U[column(j) + j], along = scaled_times(d, v[j]);
        const scaled now = scaled_plus(old, scaled_times(along, v[j]));
        if (scaled_is_zero(now)) continue;
        const scaled share = scaled_over(along, now);
        for (int i = 0; i < j; i++) {
            scaled *u = U + column(j) + i;
            v[i] = scaled_minus(v[i], scaled_times(v[j], *u));
            *u = scaled_plus(*u, scaled_times(share, v[i]));
        }
        d = scaled_times(d, scaled_over(old, now));
        U[column(j) + j] = now;
    }
}

/*
 * The decorrelation M = U^-1 and D of the components present.  A component that is missing is taken
 * out of R = U D U': its column is a part of the others' covariance and is added to them.
 */
KQ_COLD static void noise_of_present(scaled *noise, const sensor *s, uint32_t present)
{
    const scaled zero = scaled_zero();
    const int m = s->components;
    scaled v[KQ_SIZE_MAX];
    for (int k = 0; k < KQ_TRIANGLE(m); k++) noise[k] = s->noise[k];
    for (int c = 0; c < m; c++) {
        if (present >> c & 1) continue;
        for (int i = 0; i < c; i++) {
            v[i] = noise[column(c) + i];
            noise[column(c) + i] = zero;
        }
        noise_add(noise, noise[column(c) + c], v, c);
        for (int j = c + 1; j < m; j++) noise[column(j) + c] = zero;
    }
    invert_unit(noise, m);
}

#endif
