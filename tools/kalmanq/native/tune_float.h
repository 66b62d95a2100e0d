/* Of f32 and f64: numbers, and the parts of a filter.  tune.c has the names. */

#define has_exact_variance 0

/* 0: not representable */
static int K(number_of)(const kq_format_q31 *format, double given, double less, num *made)
{
    const num word = (num)given;
    (void)format;
    *made = word - (num)less;
    return word != word || word - word == 0;
}

static double K(double_of_mean)(num mean, num low, int fraction)
{
    (void)fraction;
    return has_low_words ? (double)mean + (double)low : (double)mean;
}

static double K(double_of_number)(num given, int fraction)
{
    (void)fraction;
    return (double)given;
}

static double K(double_of_score)(num given) { return (double)given; }

static num K(parameter)(double given) { return (num)given; }

/* Numbers that stay; NULL: none, or no memory */
static num *K(numbers)(const double *given, size_t count)
{
    num *made = given ? tune_take(count * sizeof(num)) : NULL;
    for (size_t k = 0; made && k < count; k++) made[k] = (num)given[k];
    return made;
}

static kq_status K(process_at)(K(tuned) *r, size_t k)
{
    const kq_tune *of = r->of;
    const size_t n = (size_t)of->n, l = (size_t)of->l, length = (size_t)K(length)(KQ_OBJECT_PROCESS, of->n, 0, 0, 0);
    K(process) *p = r->processes + k;
    num *memory = tune_take(length * sizeof(num)), *A = K(numbers)(of->A + k * n * n, n * n);
    num *B = K(numbers)(of->B ? of->B + k * n * l : NULL, n * l);
    num *Q = of->factor ? K(numbers)(of->G, n * (size_t)of->factor) : K(numbers)(of->Q + k * n * n, n * n);
    if (!memory || !A || !Q || (of->B && !B)) return KQ_ERR_MEMORY;
    const kq_status status = K(process_assign)(p, of->n, of->l, memory, length);
    if (status) return status;
    return of->factor ? K(process_init_factor)(p, A, B, Q, of->factor) : K(process_init)(p, A, B, Q);
}

static kq_status K(sensor_of)(K(tuned) *r)
{
    const kq_tune *of = r->of;
    const size_t n = (size_t)of->n, m = (size_t)of->m, length = (size_t)K(length)(KQ_OBJECT_SENSOR, 0, of->m, 0, 0);
    num *memory = tune_take(length * sizeof(num)), *H = K(numbers)(of->H, m * n), *R = K(numbers)(of->R, m * m);
    if (!memory || !H || !R) return KQ_ERR_MEMORY;
    const kq_status status = K(sensor_assign)(&r->sensor, of->n, of->m, memory, length);
    if (status) return status;
    if (is_correlated(of)) return K(sensor_init)(&r->sensor, H, R);
    for (size_t c = 0; c < m; c++) R[c] = R[c * m + c];
    return K(sensor_init_diagonal)(&r->sensor, H, R);
}

static kq_status K(prior)(K(tuned) *r)
{
    const kq_tune *of = r->of;
    const size_t n = (size_t)of->n;
    num *x0 = K(numbers)(of->x0, n), *P0 = K(numbers)(of->P0, n * n);
    if (!x0 || !P0) return KQ_ERR_MEMORY;
    return of->unknown ? K(diffuse_init)(&r->start, &r->filter, x0, P0, of->unknown) : K(filter_init)(&r->filter, x0, P0);
}

static kq_status K(parts)(K(tuned) *r)
{
    for (size_t k = 0; k < (size_t)r->of->processes; k++) {
        const kq_status status = K(process_at)(r, k);
        if (status) return refused(r->of, TUNE_PROCESS, status);
    }
    const kq_status status = K(sensor_of)(r);
    return status ? refused(r->of, TUNE_SENSOR, status) : KQ_OK;
}
