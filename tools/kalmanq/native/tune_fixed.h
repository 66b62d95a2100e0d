/* Of q31: numbers, and the parts of a filter, as prepare.h makes them.  tune.c has the names. */

static double kq_double_of_mean_q31(int32_t mean, int32_t low, int fraction)
{
    if (mean == KQ_NOT_A_VALUE_Q31) return NAN;
    return ldexp(mean + low * 0x1p-24, -fraction);
}

static double kq_double_of_number_q31(kq_scaled_q31 given, int fraction)
{
    return given.mantissa == KQ_NOT_A_VALUE_Q31 ? NAN : ldexp(given.mantissa, given.exponent - fraction);
}

static double kq_double_of_score_q31(int64_t given) { return given == KQ_NOT_A_SCORE_Q31 ? NAN : (double)given * 0x1p-24; }

/* To the nearest integer, halves away from 0 */
static double nearest(double value)
{
    const double whole = __builtin_trunc(value), rest = value - whole;
    return whole + (rest >= 0.5) - (rest <= -0.5);
}

static kq_scaled_q31 kq_parameter_q31(double given)
{
    int exponent = 0;
    while (given >= 1) given /= 2, exponent++;
    while (given < 0.5 && given > 0) given *= 2, exponent--;
    double mantissa = nearest(given * 0x1p31);
    if (mantissa == 0x1p31) mantissa /= 2, exponent++;
    return (kq_scaled_q31){(int32_t)mantissa, mantissa != 0 ? exponent - 31 : 0};
}

/* 0: beyond the declared range */
static int kq_number_of_q31(const kq_format_q31 *format, double given, double less, int32_t *made)
{
    *made = KQ_NOT_A_VALUE_Q31;
    if (given != given) return 1;
    const double word = nearest(ldexp(given, format->fraction)) - nearest(ldexp(less, format->fraction));
    if (!(word <= format->range && word >= -(double)format->range)) return 0;
    *made = (int32_t)word;
    return 1;
}

static kq_status formats_of(kq_tuned_q31 *r)
{
    kq_tune *of = r->of;
    for (int k = 0; k < of->n + of->m + of->l; k++) {
        kq_range_error_q31 error = {0};
        const int c = k - of->n;
        const double less = of->d && c >= 0 && c < of->m ? of->d[c] : 0;
        const double range = of->range[k] + (less < 0 ? -less : less);
        const kq_status status = kq_format_prepare_q31(r->formats + k, of->fraction[k], range, &error);
        if (!status) continue;
        of->component = k;
        of->bits = error.bits;
        return refused(of, TUNE_FORMATS, status);
    }
    return KQ_OK;
}

/* A range that does not fit, with whose it is */
static kq_status range_refused(kq_tune *of, tune_part part, kq_status status, const kq_range_error_q31 *error)
{
    const int first = error->quantity == KQ_STATE ? 0 : error->quantity == KQ_MEASUREMENT ? of->n : of->n + of->m;
    if (status == KQ_ERR_RANGE && error->quantity != KQ_NO_RANGE_ERROR) {
        of->component = first + error->component;
        of->bits = error->bits;
    }
    return refused(of, part, status);
}

static kq_status kq_process_at_q31(kq_tuned_q31 *r, size_t k)
{
    kq_tune *of = r->of;
    const int n = of->n, l = of->l;
    const size_t square = (size_t)(n * n);
    const kq_format_q31 *states = r->formats, *controls = l ? r->formats + n + of->m : NULL;
    kq_scaled_q31 *A = tune_take(square * sizeof *A), *B = tune_take((size_t)(n * l) * sizeof *B);
    int32_t *root = tune_take((size_t)kq_length_q31(KQ_OBJECT_ROOT, n, 0, 0, 0) * sizeof *root);
    if (!A || !B || !root) return refused(of, TUNE_MEMORY, KQ_ERR_MEMORY);
    kq_status status = kq_matrix_prepare_q31(A, of->A + k * square, n, n, states, states);
    if (!status && l) status = kq_matrix_prepare_q31(B, of->B + k * (size_t)(n * l), n, l, states, controls);
    if (!status) {
        status = of->factor ? kq_root_prepare_factor_q31(root, of->G, n, of->factor, states)
                            : kq_root_prepare_q31(root, of->Q + k * square, n, states);
    }
    if (status) return refused(of, TUNE_PROCESS, status);
    const kq_process_table_q31 table = {n, l, states, controls, A, l ? B : NULL, root};
    kq_range_error_q31 error;
    status = kq_process_init_q31(r->processes + k, &table, &error);
    return status ? range_refused(of, TUNE_PROCESS, status, &error) : KQ_OK;
}

static kq_status kq_sensor_of_q31(kq_tuned_q31 *r)
{
    kq_tune *of = r->of;
    const int n = of->n, m = of->m, correlated = is_correlated(of);
    const kq_format_q31 *measurements = r->formats + n;
    kq_scaled_q31 *H = tune_take((size_t)(m * n) * sizeof *H), *R = tune_take((size_t)(m * (m + 1) / 2) * sizeof *R);
    double variances[KQ_SIZE_MAX];
    if (!H || !R) return refused(of, TUNE_MEMORY, KQ_ERR_MEMORY);
    for (int c = 0; c < m; c++) variances[c] = of->R[c * m + c];
    kq_status status = kq_matrix_prepare_q31(H, of->H, m, n, measurements, r->formats);
    if (!status) {
        status = correlated ? kq_noise_prepare_q31(R, of->R, m, measurements)
                            : kq_noise_prepare_diagonal_q31(R, variances, m, measurements);
    }
    if (status) return refused(of, TUNE_SENSOR, status);
    const kq_sensor_table_q31 table = {n, m, correlated, r->formats, measurements, H, R};
    kq_range_error_q31 error;
    status = kq_sensor_init_q31(&r->sensor, &table, &error);
    return status ? range_refused(of, TUNE_SENSOR, status, &error) : KQ_OK;
}

/* P0 without what is not looked at */
static void known_prior(const kq_tune *of, double *known)
{
    for (int k = 0; k < of->n * of->n; k++) {
        const int is_unknown = of->unknown >> (k % of->n) & 1 || of->unknown >> (k / of->n) & 1;
        known[k] = is_unknown ? 0 : of->P0[k];
    }
}

static kq_status kq_prior_q31(kq_tuned_q31 *r)
{
    kq_tune *of = r->of;
    kq_range_error_q31 error = {KQ_NO_RANGE_ERROR, 0, 0};
    double known[KQ_SIZE_MAX * KQ_SIZE_MAX];
    int32_t *mean = tune_take((size_t)of->n * sizeof *mean);
    int32_t *root = tune_take((size_t)kq_length_q31(KQ_OBJECT_ROOT, of->n, 0, 0, 0) * sizeof *root);
    if (!mean || !root) return refused(of, TUNE_MEMORY, KQ_ERR_MEMORY);
    known_prior(of, known);
    kq_status status = kq_vector_prepare_q31(mean, of->x0, of->n, r->formats, &error);
    if (!status) status = kq_root_prepare_q31(root, known, of->n, r->formats);
    const kq_prior_table_q31 prior = {of->n, r->formats, mean, root};
    if (!status) {
        status = of->unknown ? kq_diffuse_init_q31(&r->start, &r->filter, &prior, of->unknown, &error)
                             : kq_filter_init_q31(&r->filter, &prior, &error);
    }
    return status ? range_refused(of, TUNE_PRIOR, status, &error) : KQ_OK;
}

static kq_status kq_parts_q31(kq_tuned_q31 *r)
{
    kq_status status = formats_of(r);
    for (size_t k = 0; !status && k < (size_t)r->of->processes; k++) status = kq_process_at_q31(r, k);
    return status ? status : kq_sensor_of_q31(r);
}
