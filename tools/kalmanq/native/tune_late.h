/* Measurements that come late: a delay follows the filter, and takes each at the row that it was measured at.  tune.c has the names. */

/* Of row s, cells that come k rows later; NaN never comes */
static uint32_t K(late_cells)(const kq_tune *of, size_t s, size_t k)
{
    const size_t m = (size_t)of->m;
    uint32_t made = 0;
    for (size_t c = 0; c < m; c++) made |= (uint32_t)(of->late[s * m + c] == (int32_t)k && of->z[s * m + c] == of->z[s * m + c]) << c;
    return made;
}

/* Innovations of these cells, given what is known when they come */
static kq_status K(look_late)(K(tuned) *r, size_t s, size_t k, uint32_t cells, const num *z)
{
    const size_t m = (size_t)r->of->m;
    number S[KQ_SIZE_MAX * KQ_SIZE_MAX];
    num e[KQ_SIZE_MAX];
    K(filter) view = {0};
    kq_status status = K(lagged)(&r->lag, k, &view);
    if (!status) status = K(innovation)(&view, &r->sensor, z, e);
    if (!status) status = K(measurement)(&view, &r->sensor, NULL, S);
    for (size_t c = 0; c < m && !status; c++) {
        if (!(cells >> c & 1)) continue;
        r->q.innovation[s * m + c] = e[c];
        r->q.innovation_variance[s * m + c] = S[c * m + c];
    }
    return status;
}

static kq_status K(take_late)(K(tuned) *r, size_t s, size_t k, uint32_t cells)
{
    const size_t m = (size_t)r->of->m;
    num z[KQ_SIZE_MAX];
    for (size_t c = 0; c < m; c++) z[c] = cells >> c & 1 ? r->late_z[s * m + c] : 0;
    kq_status status = K(look_late)(r, s, k, cells, z);
    if (!status) status = K(update_delayed)(&r->lag, k, &r->sensor, z, cells);
    if (status < KQ_OK) return status;
    const int others = r->q.taken[s];
    r->q.nis[s] = (others ? r->q.nis[s] : 0) + K(nis)(&r->filter);
    r->q.log_likelihood[s] += K(log_likelihood_last)(&r->filter);
    r->q.taken[s] += K(taken)(&r->filter);
    return KQ_OK;
}

static void K(read_again)(K(tuned) *r, size_t t)
{
    const size_t n = (size_t)r->of->n;
    number P[KQ_SIZE_MAX * KQ_SIZE_MAX];
    const int is_known = r->q.variance && !K(covariance)(&r->filter, P);
    for (size_t i = 0; i < n; i++) {
        r->q.mean[t * n + i] = K(mean)(&r->filter, (int)i);
        if (r->q.mean_low) r->q.mean_low[t * n + i] = K(mean_low)(&r->filter, (int)i);
        r->q.sigma[t * n + i] = K(sigma)(&r->filter, (int)i);
        if (is_known) r->q.variance[t * n + i] = P[i * n + i];
    }
}

/* What comes at row t of the rows before */
static kq_status K(arrive)(K(tuned) *r, size_t t, size_t latest)
{
    int is_other = 0;
    for (size_t k = t < latest ? t : latest; k > 0; k--) {
        const uint32_t cells = K(late_cells)(r->of, t - k, k);
        if (!cells) continue;
        const kq_status status = K(take_late)(r, t - k, k, cells);
        if (status) {
            r->of->row = (int32_t)(t - k);
            return refused(r->of, TUNE_LATE, status);
        }
        is_other = 1;
    }
    if (is_other) K(read_again)(r, t);
    return KQ_OK;
}

/* The rows without what is late */
static kq_status K(hold_back)(K(tuned) *r)
{
    const kq_tune *of = r->of;
    const size_t count = (size_t)of->rows * (size_t)of->m;
    const double nothing = NAN;
    num *made = tune_take(count * sizeof(num)), none;
    if (!made) return refused(r->of, TUNE_MEMORY, KQ_ERR_MEMORY);
    (void)K(number_of)(r->formats, nothing, 0, &none);
    for (size_t k = 0; k < count; k++) made[k] = of->late[k] > 0 ? none : r->q.z[k];
    r->late_z = r->q.z, r->q.z = made;
    return KQ_OK;
}

/* Row t of a sequence */
static K(sequence) K(row_of)(K(tuned) *r, size_t t)
{
    const size_t n = (size_t)r->of->n, m = (size_t)r->of->m;
    K(sequence) q = r->q;
    q.filter = &r->filter, q.lag = &r->lag; /* with what is attached no step may leave it out */
    q.steps = 1, q.begins = t == 0;
    q.z += t * m;
    if (q.u) q.u += t * (size_t)r->of->l;
    if (q.processes) q.processes += t;
    q.mean += t * n, q.sigma += t * n;
    if (q.mean_low) q.mean_low += t * n;
    if (q.variance) q.variance += t * n;
    q.innovation += t * m, q.innovation_variance += t * m;
    q.nis += t, q.log_likelihood += t, q.taken += t;
    return q;
}

/* A filter that is asked for its rows.  A diffuse start has to be known before what is late is measured. */
static kq_status K(run_late)(K(tuned) *r, size_t latest)
{
    const kq_tune *of = r->of;
    const size_t length = (size_t)K(length)(KQ_OBJECT_LAG, of->n, of->m, latest, 0);
    num *memory = tune_take(length * sizeof(num));
    if (!memory) return refused(r->of, TUNE_MEMORY, KQ_ERR_MEMORY);
    kq_status status = K(hold_back)(r);
    if (!status) status = K(delay_assign)(&r->lag, of->n, of->m, latest, memory, length);
    int follows = 0;
    for (size_t t = 0; t < (size_t)of->rows && !status; t++) {
        K(sequence) one = K(row_of)(r, t);
        status = K(sequence_run)(&one);
        if (status < KQ_OK) {
            r->of->row = (int32_t)t;
            return refused(r->of, TUNE_RUN, status);
        }
        status = KQ_OK;
        if (!follows) follows = !K(attach)(&r->filter, &r->lag.attached);
        if (!status) status = K(arrive)(r, t, latest);
    }
    return status;
}
