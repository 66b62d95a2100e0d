/* The text of tune.c for one arithmetic: it has its names. */

/* ------------------------------------------------------------------ numbers, out of double and back */

/* Rows of values, less offsets, as the arithmetic has them; NaN: missing.  NULL: refused, and *status says why. */
static num *K(rows_of)(K(tuned) *r, tune_part part, const double *given, size_t rows, int columns, int first, kq_status *status)
{
    num *made = tune_take(rows * (size_t)columns * sizeof(num));
    const double *less = part == TUNE_MEASUREMENTS ? r->of->d : NULL;
    *status = made ? KQ_OK : refused(r->of, TUNE_MEMORY, KQ_ERR_MEMORY);
    for (size_t k = 0; made && k < rows * (size_t)columns; k++) {
        const int c = (int)(k % (size_t)columns);
        if (K(number_of)(r->formats + first + c, given[k], less ? less[c] : 0, made + k)) continue;
        r->of->row = (int32_t)(k / (size_t)columns);
        r->of->component = c;
        *status = refused(r->of, part, KQ_ERR_RANGE);
        return NULL;
    }
    return made;
}

/* Means of `count` rows, with what is below their words */
static void K(means)(const K(tuned) *r, const num *mean, const num *low, size_t count, double *made)
{
    const size_t n = (size_t)r->of->n;
    for (size_t k = 0; made && k < count * n; k++) made[k] = K(double_of_mean)(mean[k], low ? low[k] : 0, r->formats[k % n].fraction);
}

/* Those of the variances, where there are any; otherwise those of the words */
static void K(sigmas)(const K(tuned) *r, const num *sigma, const number *variance, size_t count, double *made)
{
    const size_t n = (size_t)r->of->n;
    for (size_t k = 0; made && k < count * n; k++) {
        const int fraction = r->formats[k % n].fraction;
        const double exact = variance ? sqrt(K(double_of_number)(variance[k], 2 * fraction)) : NAN;
        made[k] = exact == exact ? exact : K(double_of_mean)(sigma[k], 0, fraction);
    }
}

/* ------------------------------------------------------------------ a run */

static kq_status K(begin)(K(tuned) *r, size_t early)
{
    const int n = r->of->n;
    const size_t length = (size_t)K(length)(KQ_OBJECT_FILTER, n, 0, 0, 0);
    num *memory = tune_take(length * sizeof(num));
    if (!memory) return refused(r->of, TUNE_MEMORY, KQ_ERR_MEMORY);
    kq_status status = K(filter_assign)(&r->filter, n, memory, length);
    if (!status && r->of->unknown) {
        const size_t size = (size_t)K(length)(KQ_OBJECT_DIFFUSE, n, 0, early, 0);
        num *more = tune_take(size * sizeof(num));
        if (!more) return refused(r->of, TUNE_MEMORY, KQ_ERR_MEMORY);
        status = K(diffuse_assign)(&r->start, n, early, more, size);
    }
    if (!status) status = K(prior)(r);
    for (size_t k = 0; k < r->q.losses_count; k++) r->q.losses[k].rejected = 0;
    return status ? refused(r->of, TUNE_PRIOR, status) : KQ_OK;
}

static void K(choose_losses)(K(tuned) *r, K(loss) *losses, score *limits)
{
    const kq_tune *of = r->of;
    if (!of->loss) return;
    const K(loss) begun = {.kind = of->loss, .parameter = K(parameter)(*of->parameter), .run = (uint16_t)of->run};
    for (int k = 0; k < of->losses; k++) losses[k] = begun;
    r->q.losses = losses, r->q.losses_count = (size_t)of->losses, r->q.measured = of->measured;
    if (of->level < 0) return;
    for (int c = 0; c < of->m; c++) limits[c] = K(chi_square_limit)(c + 1, (kq_level)of->level);
    r->q.limits = limits;
}

/* The rows from `first` on; what is asked of them is in r->q. */
static kq_status K(run)(K(tuned) *r, size_t first, size_t count)
{
    K(sequence) q = r->q;
    q.filter = &r->filter;
    q.begins = first == 0;
    q.steps = count;
    q.z += first * (size_t)r->of->m;
    if (q.u) q.u += first * (size_t)r->of->l;
    if (q.processes) q.processes += first;
    const kq_status status = K(sequence_run)(&q);
    if (status >= KQ_OK) return KQ_OK;
    r->of->row = (int32_t)(first + q.done);
    return refused(r->of, TUNE_RUN, status);
}

/* Rows until all of the start is known, by a filter that nothing is asked of */
static kq_status K(rows_to_know)(K(tuned) *r, size_t *early)
{
    const size_t rows = (size_t)r->of->rows, block = 64, most = 65534;
    void *mark = tune_mark();
    kq_status status = K(begin)(r, 0);
    *early = rows + 1 < most ? rows + 1 : most;
    for (size_t first = 0; !status && first < rows; first += block) {
        status = K(run)(r, first, first + block < rows ? block : rows - first);
        if (K(diffuse_count)(&r->start) && first + block <= most) continue;
        *early = first + block < most ? first + block : most;
        break;
    }
    tune_release(mark);
    return status;
}

static kq_status K(record)(K(tuned) *r, size_t early)
{
    const kq_tune *of = r->of;
    const size_t rows = (size_t)of->rows;
    const size_t length = (size_t)K(length)(KQ_OBJECT_HISTORY, of->n, of->m, rows, of->which ? rows : 0);
    kq_status status = K(begin)(r, early);
    num *memory = status ? NULL : tune_take(length * sizeof(num));
    if (!status && !memory) return refused(r->of, TUNE_MEMORY, KQ_ERR_MEMORY);
    if (!status) status = K(history_assign)(&r->history, of->n, memory, length);
    if (!status) status = K(attach)(&r->filter, &r->history.attached);
    return status ? refused(r->of, TUNE_SMOOTHER, status) : K(run)(r, 0, rows);
}

/* What a view shows of the states that are wanted; of a start that is in part unknown a number may be NaN. */
static void K(read_row)(const K(tuned) *r, const K(filter) *view, size_t t)
{
    const kq_tune *of = r->of;
    const size_t n = (size_t)of->n, first = of->only >= 0 ? (size_t)of->only : 0, last = of->only >= 0 ? first + 1 : n;
    number P[KQ_SIZE_MAX * KQ_SIZE_MAX];
    const int is_exact = has_exact_variance && !K(covariance)(view, P);
    for (size_t i = first; i < last; i++) {
        const int fraction = r->formats[i].fraction;
        const double exact = is_exact ? sqrt(K(double_of_number)(P[i * n + i], 2 * fraction)) : NAN;
        of->smoothed[t * n + i] = K(double_of_mean)(K(mean)(view, (int)i), K(mean_low)(view, (int)i), fraction);
        of->smoothed_sigma[t * n + i] = exact == exact ? exact : K(double_of_mean)(K(sigma)(view, (int)i), 0, fraction);
    }
}

static kq_status K(read_back)(K(tuned) *r)
{
    for (size_t t = 0; t < (size_t)r->of->rows; t++) {
        K(filter) view;
        const kq_status status = r->of->unknown ? K(diffuse_smoothed)(&r->start, t, &view) : K(smoothed)(&r->history, t, &view);
        if (status && status != KQ_ERR_NOT_READY) return status;
        K(read_row)(r, &view, t);
    }
    return KQ_OK;
}

/* A run that is recorded, and back */
static kq_status K(smooth_all)(K(tuned) *r)
{
    size_t early = 0;
    kq_status status = r->of->unknown ? K(rows_to_know)(r, &early) : KQ_OK;
    if (!status) status = K(record)(r, early);
    if (status) return status;
    status = r->of->unknown ? K(diffuse_smooth)(&r->start) : K(smooth)(&r->history);
    if (!status) status = K(read_back)(r);
    return status ? refused(r->of, TUNE_SMOOTHER, status) : KQ_OK;
}

/* ------------------------------------------------------------------ what is asked of a run */

/* What the filter writes at each row, in its own numbers */
typedef struct {
    num *mean, *low, *sigma, *innovation;
    number *variance, *spread;
    score *nis, *likelihood;
    int32_t *taken;
} K(written);

static kq_status K(ask_for_rows)(K(tuned) *r, K(written) *w)
{
    const size_t rows = (size_t)r->of->rows, n = (size_t)r->of->n, m = (size_t)r->of->m;
    *w = (K(written)){.mean = tune_take(rows * n * sizeof(num)), .low = tune_take(rows * n * sizeof(num)),
                      .sigma = tune_take(rows * n * sizeof(num)), .innovation = tune_take(rows * m * sizeof(num)),
                      .spread = tune_take(rows * m * sizeof(number)), .nis = tune_take(rows * sizeof(score)),
                      .likelihood = tune_take(rows * sizeof(score)), .taken = tune_take(rows * sizeof(int32_t))};
    if (has_exact_variance) w->variance = tune_take(rows * n * sizeof(number));
    if (!w->taken || (has_exact_variance && !w->variance)) return refused(r->of, TUNE_MEMORY, KQ_ERR_MEMORY);
    r->q.mean = w->mean, r->q.mean_low = has_low_words ? w->low : NULL, r->q.sigma = w->sigma, r->q.variance = w->variance;
    r->q.innovation = w->innovation, r->q.innovation_variance = w->spread;
    r->q.nis = w->nis, r->q.log_likelihood = w->likelihood, r->q.taken = w->taken;
    return KQ_OK;
}

static void K(tell_rows)(const K(tuned) *r, const K(written) *w)
{
    const kq_tune *of = r->of;
    const size_t rows = (size_t)of->rows, m = (size_t)of->m;
    K(means)(r, w->mean, r->q.mean_low, rows, of->mean);
    K(sigmas)(r, w->sigma, w->variance, rows, of->sigma);
    for (size_t k = 0; k < rows * m; k++) {
        const int fraction = r->formats[(size_t)of->n + k % m].fraction;
        of->innovation[k] = K(double_of_mean)(w->innovation[k], 0, fraction);
        of->innovation_sigma[k] = sqrt(K(double_of_number)(w->spread[k], 2 * fraction));
    }
    for (size_t t = 0; t < rows; t++) {
        of->nis[t] = K(double_of_score)(w->nis[t]);
        of->log_likelihood[t] = K(double_of_score)(w->likelihood[t]);
        of->taken[t] = w->taken[t];
    }
}

static kq_status K(filter_all)(K(tuned) *r)
{
    kq_tune *of = r->of;
    K(written) w;
    kq_status status = of->mean ? K(ask_for_rows)(r, &w) : KQ_OK;
    if (!status) status = K(begin)(r, 0);
    if (!status) status = of->latest > 0 && of->mean ? K(run_late)(r, (size_t)of->latest) : K(run)(r, 0, (size_t)of->rows);
    if (status) return status;
    *of->total = K(double_of_score)(K(log_likelihood)(&r->filter));
    of->events = (int32_t)K(events)(&r->filter);
    if (of->mean) K(tell_rows)(r, &w);
    return KQ_OK;
}

/* Rows after the last one; controls stay as they are.  What is not known yet is NaN. */
static kq_status K(look_ahead)(K(tuned) *r)
{
    const kq_tune *of = r->of;
    const size_t n = (size_t)of->n, length = (size_t)K(length)(KQ_OBJECT_FILTER, of->n, 0, 0, 0);
    num *memory = tune_take(length * sizeof(num));
    K(filter) ahead;
    if (!memory) return refused(r->of, TUNE_MEMORY, KQ_ERR_MEMORY);
    kq_status status = K(filter_assign)(&ahead, of->n, memory, length);
    const num *u = r->q.u ? r->q.u + (size_t)of->rows * (size_t)of->l : NULL; /* a row more than there are: the last one again */
    if (!status) status = K(forecast)(&r->filter, r->processes, NULL, 0, &ahead);
    for (size_t t = 0; t < (size_t)of->ahead; t++) {
        number P[KQ_SIZE_MAX * KQ_SIZE_MAX];
        if (!status) status = K(predict)(&ahead, r->processes, u);
        const int is_known = !status && !K(covariance)(&ahead, P);
        for (size_t i = 0; i < n; i++) {
            const double exact = is_known ? sqrt(K(double_of_number)(P[i * n + i], 2 * r->formats[i].fraction)) : NAN;
            const double word = is_known ? K(double_of_mean)(K(sigma)(&ahead, (int)i), 0, r->formats[i].fraction) : NAN;
            of->forecast[t * n + i] = is_known ? K(double_of_mean)(K(mean)(&ahead, (int)i), K(mean_low)(&ahead, (int)i), r->formats[i].fraction)
                                               : NAN;
            of->forecast_sigma[t * n + i] = has_exact_variance && exact == exact ? exact : word;
        }
    }
    return KQ_OK;
}

static kq_status K(follow_with_lag)(K(tuned) *r)
{
    const kq_tune *of = r->of;
    const size_t rows = (size_t)of->rows, n = (size_t)of->n;
    const size_t length = (size_t)K(length)(KQ_OBJECT_LAG, of->n, of->m, (size_t)of->lag, 0);
    num *memory = tune_take(length * sizeof(num)), *mean = tune_take(rows * n * sizeof(num));
    num *low = tune_take(rows * n * sizeof(num)), *sigma = tune_take(rows * n * sizeof(num));
    number *variance = has_exact_variance ? tune_take(rows * n * sizeof(number)) : NULL;
    if (!memory || !mean || !low || !sigma || (has_exact_variance && !variance)) return refused(r->of, TUNE_MEMORY, KQ_ERR_MEMORY);
    kq_status status = K(lag_assign)(&r->lag, of->n, of->m, (size_t)of->lag, memory, length);
    r->q.lag = &r->lag, r->q.age = (size_t)of->lag;
    r->q.lagged = mean, r->q.lagged_low = low, r->q.lagged_sigma = sigma, r->q.lagged_variance = variance;
    if (!status) status = K(begin)(r, 0);
    if (!status) status = K(run)(r, 0, rows);
    if (status) return status == KQ_ERR_MEMORY ? status : refused(r->of, TUNE_LAG, status);
    K(means)(r, mean, low, rows, of->lagged);
    K(sigmas)(r, sigma, variance, rows, of->lagged_sigma);
    return KQ_OK;
}

/* ------------------------------------------------------------------ all of it */

static kq_status K(data)(K(tuned) *r)
{
    kq_tune *of = r->of;
    kq_status status;
    const size_t rows = (size_t)of->rows, l = (size_t)of->l;
    r->q.z = K(rows_of)(r, TUNE_MEASUREMENTS, of->z, rows, of->m, of->n, &status);
    if (status || !of->u) return status;
    num *u = K(rows_of)(r, TUNE_CONTROLS, of->u, rows, of->l, of->n + of->m, &status);
    num *carried = tune_take((rows + 1) * l * sizeof(num)); /* at row t what moves the state from row t - 1 */
    if (!status && !carried) status = refused(of, TUNE_MEMORY, KQ_ERR_MEMORY);
    for (size_t k = 0; !status && k < (rows + 1) * l; k++) carried[k] = k < l ? 0 : u[k - l];
    r->q.u = carried;
    return status;
}

static kq_status K(processes_of_rows)(K(tuned) *r)
{
    const kq_tune *of = r->of;
    if (!of->which) return KQ_OK;
    const K(process) **made = tune_take((size_t)of->rows * sizeof *made);
    if (!made) return refused(r->of, TUNE_MEMORY, KQ_ERR_MEMORY);
    for (size_t t = 0; t < (size_t)of->rows; t++) made[t] = r->processes + of->which[t];
    r->q.processes = made;
    return KQ_OK;
}

static kq_status K(tune)(kq_tune *of)
{
    static K(tuned) kept;
    K(tuned) *r = &kept;
    score limits[KQ_SIZE_MAX];
    K(loss) losses[KQ_SIZE_MAX];
    kept = (K(tuned)){.of = of};
    r->processes = tune_take((size_t)of->processes * sizeof *r->processes);
    if (!r->processes) return refused(of, TUNE_MEMORY, KQ_ERR_MEMORY);
    kq_status status = K(parts)(r);
    if (!status) status = K(data)(r);
    if (!status) status = K(processes_of_rows)(r);
    if (status) return status;
    r->q.process = r->processes, r->q.sensor = &r->sensor;
    r->q.is_upper = are_upper(of);
    K(choose_losses)(r, losses, limits);
    const K(sequence) plain = r->q;
    void *mark = tune_mark();
    status = of->total ? K(filter_all)(r) : KQ_OK;
    if (!status && of->ahead) status = K(look_ahead)(r);
    tune_release(mark);
    r->q = plain;
    if (!status && of->lag >= 0) status = K(follow_with_lag)(r);
    tune_release(mark);
    r->q = plain;
    if (!status && of->smooth) status = K(smooth_all)(r);
    return status;
}
