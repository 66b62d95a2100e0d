/* The text of sequences.h for one arithmetic: sequences.c has its names. */

/* A root that a run has come by, and what a calm step from it to the next one does */
typedef struct {
    num root[root_words(KQ_SIZE_MAX)];
    int was_sought, is_found;
    K(calm) calm;
} K(place);

/* A run, at one of its rows */
typedef struct {
    const K(sequence) *q;
    K(kernels) kernels;
    size_t t, n, m;
    const K(process) *process; /* of the predict before it */
    const K(sensor) *sensor;
    uint32_t present; /* of the row's measurements */
    uint32_t all;
    int may_rest;   /* is nothing but the filter's own asked for? */
    K(place) *places; /* PLACES: the roots after the last rows, `count` of them, the newest at `newest` */
    int count, newest;
    size_t period;  /* the root after the row is that of so many rows before, which is at `here`; 0: none of them */
    int here, begin; /* begin: what follows the newest */
} K(row);

/* What is attached may have more of a covariance than a root; a history has not. */
static int K(has_root_alone)(const K(filter) *f)
{
    return !f->attached || f->attached->hooks == &K(history_hooks);
}

static int K(next)(const K(row) *r)
{
    return r->here == r->newest ? r->begin : (r->here + 1) % PLACES;
}

static int K(is_at)(const K(row) *r, int place)
{
    const size_t size = sizeof(num) * (size_t)root_words(r->n);
    return !memcmp(r->places[place].root, r->q->filter->memory + mean_words(r->n), size);
}

/* The root goes on being one of those before: the same one, or the next of a cycle, as they come by rounding. */
static int K(goes_round)(K(row) *r)
{
    if (r->period && K(is_at)(r, K(next)(r))) {
        r->here = K(next)(r);
        return 1;
    }
    const int was_round = r->period > 0;
    for (int back = 0; back < r->count && !was_round; back++) {
        const int place = (r->newest + PLACES - back) % PLACES;
        if (!K(is_at)(r, place)) continue;
        r->period = (size_t)back + 1;
        r->here = r->begin = place;
        return 1;
    }
    return 0;
}

static void K(add_place)(K(row) *r)
{
    if (r->period) r->count = 0; /* it has left the cycle */
    if (r->count) r->newest = (r->newest + 1) % PLACES;
    if (r->count < PLACES) r->count++;
    K(place) *place = r->places + r->newest;
    memcpy(place->root, r->q->filter->memory + mean_words(r->n), sizeof(num) * (size_t)root_words(r->n));
    place->was_sought = place->is_found = 0;
    r->period = 0;
}

/* A predict with a weight moves a root by a noise of its own. */
static void K(watch_root)(K(row) *r)
{
    if (!K(has_root_alone)(r->q->filter) || r->q->weights) {
        r->count = 0;
        r->period = 0;
    } else if (!K(goes_round)(r)) {
        K(add_place)(r);
    }
}

/* After a row of a cycle: what the next one, if it is a whole row, does */
static void K(seek_calm)(K(row) *r)
{
    if (!r->period || !r->may_rest) return;
    K(place) *place = r->places + r->here;
    if (place->was_sought) return;
    place->was_sought = 1;
    place->is_found = K(calm_find)(&place->calm, r->q->filter, r->process, r->sensor, r->places[K(next)(r)].root);
}

/* The diagonal of P; what is not known yet has none. */
static void K(diagonal)(const number *P, kq_status unknown, size_t n, number *variance)
{
    for (size_t i = 0; i < n; i++) variance[i] = unknown ? no_number : P[i * n + i];
}

static void K(look_at_states)(const K(row) *r)
{
    number P[KQ_SIZE_MAX * KQ_SIZE_MAX], *variance = r->q->variance + r->t * r->n;
    if (r->period) {
        for (size_t i = 0; i < r->n; i++) variance[i] = (variance - r->period * r->n)[i];
        return;
    }
    K(diagonal)(P, K(covariance)(r->q->filter, P), r->n, variance);
}

/* Before an update, P0 among them */
static void K(widen)(const K(sequence) *q)
{
    number P[KQ_SIZE_MAX * KQ_SIZE_MAX];
    const size_t n = q->filter->states;
    if (!q->widest || K(covariance)(q->filter, P)) return;
    for (size_t i = 0; i < n; i++) {
        const double variance = double_of(P[i * n + i]);
        if (variance > q->widest[i]) q->widest[i] = variance;
    }
}

static void K(readings)(K(row) *r)
{
    const K(sequence) *q = r->q;
    const K(filter) *f = q->filter;
    const size_t n = r->n, t = r->t;
    K(watch_root)(r);
    for (size_t i = 0; i < n; i++) {
        if (q->mean) q->mean[t * n + i] = K(mean)(f, (int)i);
        if (q->mean_low) q->mean_low[t * n + i] = K(mean_low)(f, (int)i);
        if (q->sigma) q->sigma[t * n + i] = r->period ? q->sigma[(t - r->period) * n + i] : K(sigma)(f, (int)i);
    }
    if (q->variance) K(look_at_states)(r);
    if (q->scales) {
        const kq_status status = K(adaptation_scales)(q->adaptation, q->scales + 2 * t, q->scales + 2 * t + 1);
        (void)status; /* it is attached */
    }
}

static void K(look_at_variances)(const K(row) *r, const K(filter) *f)
{
    const K(sequence) *q = r->q;
    number S[KQ_SIZE_MAX * KQ_SIZE_MAX], *variances = q->innovation_variance + r->t * r->m;
    if (r->period) {
        for (size_t c = 0; c < r->m; c++) variances[c] = (variances - r->period * r->m)[c];
        return;
    }
    const kq_status unknown = K(measurement)(f, r->sensor, NULL, S);
    for (size_t c = 0; c < r->m; c++) variances[c] = unknown ? no_number : S[c * r->m + c];
}

/* Where some of a row is missing, or of the state unknown */
static kq_status K(look_at_some)(const K(row) *r, const K(filter) *f, const num *z, num *e)
{
    num there[KQ_SIZE_MAX];
    for (size_t c = 0; c < r->m; c++) there[c] = r->present >> c & 1 ? z[c] : 0;
    const kq_status status = K(innovation)(f, r->sensor, there, e);
    for (size_t c = 0; c < r->m; c++) {
        if (status || !(r->present >> c & 1)) e[c] = lost;
    }
    return status;
}

/* Innovation and its variance at f; what is not known yet has none. */
static kq_status K(look)(const K(row) *r, const K(filter) *f)
{
    const K(sequence) *q = r->q;
    kq_status status = KQ_OK;
    if (q->innovation) {
        const num *z = q->z + r->t * r->m;
        num *e = q->innovation + r->t * r->m;
        status = r->present == r->all ? K(innovation)(f, r->sensor, z, e) : KQ_ERR_NOT_READY;
        if (status == KQ_ERR_NOT_READY) status = K(look_at_some)(r, f, z, e);
    }
    if (q->innovation_variance) K(look_at_variances)(r, f);
    return status == KQ_ERR_NOT_READY ? KQ_OK : status; /* a state that is unknown so far */
}

static kq_status K(take_plainly)(const K(row) *r, const num *z, uint32_t present)
{
    if (present == r->all) return r->kernels.update(r->q->filter, r->sensor, z);
    return K(update_subset)(r->q->filter, r->sensor, z, present);
}

/* By one loss; a gate's limit is that of as many components.  A start that is in part unknown takes its
   measurements as they are: nothing tells an outlier there. */
static kq_status K(take_robustly)(const K(row) *r, const num *z, K(loss) *loss, uint32_t present)
{
    const score *limits = r->q->limits;
    if (limits) loss->limit = limits[count_of(present) - 1];
    const kq_status status = K(update_robust)(r->q->filter, r->sensor, z, present, loss);
    return status == KQ_ERR_NOT_READY ? K(take_plainly)(r, z, present) : status;
}

/* What an update tells, added to the others': what was rejected counts where nothing is taken. */
static void K(join)(K(likelihood) *all, const K(likelihood) *one)
{
    if (all->count && !one->count) return;
    if (one->count && !all->count) {
        *all = *one;
        return;
    }
    all->nis = sum_of_scores(all->nis, one->nis);
    multiply(all, one);
    all->count += one->count;
}

/* What each loss is of, one after the other */
static kq_status K(take_by_losses)(const K(row) *r, const num *z)
{
    const K(sequence) *q = r->q;
    K(likelihood) all = nothing_taken;
    for (size_t k = 0; k < q->losses_count; k++) {
        const uint32_t present = r->present & q->measured[k];
        const kq_status status = present ? K(take_robustly)(r, z, q->losses + k, present) : KQ_OK;
        if (status < KQ_OK) return status;
        if (present) K(join)(&all, &q->filter->last);
    }
    q->filter->last = all;
    return KQ_OK;
}

static kq_status K(take)(const K(row) *r, const num *z)
{
    return r->q->losses && r->present ? K(take_by_losses)(r, z) : K(take_plainly)(r, z, r->present);
}

/* What it has seen just before an update enters the window just after it. */
static kq_status K(take_watched)(const K(row) *r, const num *z)
{
    const K(sequence) *q = r->q;
    const kq_status seen = K(consistency_watch)(q->watch, q->filter, r->sensor, z, r->present);
    if (seen && seen != KQ_ERR_NOT_READY) return seen;
    const kq_status status = K(take)(r, z);
    return status < KQ_OK || seen ? status : K(consistency_record)(q->watch, q->filter);
}

/* A step that may rest on a gain; what the innovation is shows a filter that goes before. */
static kq_status K(step_settling)(const K(row) *r, const num *u, const num *z)
{
    const K(sequence) *q = r->q;
    num memory[3 * KQ_SIZE_MAX + KQ_TRIANGLE(KQ_SIZE_MAX)];
    K(filter) ahead;
    kq_status status = K(filter_assign)(&ahead, q->filter->states, memory, sizeof memory / sizeof memory[0]);
    if (!status) status = K(forecast)(q->filter, r->process, u, 1, &ahead);
    if (!status) status = K(look)(r, &ahead);
    return status ? status : K(step)(q->filter, r->process, u, r->sensor, z);
}

static kq_status K(predict_row)(const K(row) *r, const num *u)
{
    const K(sequence) *q = r->q;
    if (!q->weights) return r->kernels.predict(q->filter, r->process, u);
    const kq_status status = SCALE_NOISE(q, q->weights[r->t]);
    return status ? status : K(predict)(q->filter, q->target, u);
}

static kq_status K(take_row)(const K(row) *r)
{
    const K(sequence) *q = r->q;
    const size_t l = q->process->controls;
    const num *z = q->z + r->t * r->m;
    const num *u = q->u ? q->u + r->t * l : NULL;
    const int is_moved = r->t > 0 || !q->begins;
    if (q->is_settling && is_moved && r->present == r->all) return K(step_settling)(r, u, z);
    kq_status status = is_moved ? K(predict_row)(r, u) : KQ_OK;
    if (!status) status = K(look)(r, q->filter);
    K(widen)(q);
    if (!status) status = q->watch ? K(take_watched)(r, z) : K(take)(r, z);
    return status;
}

static void K(judge)(const K(row) *r)
{
    const K(sequence) *q = r->q;
    if (q->nis) q->nis[r->t] = r->present ? K(nis)(q->filter) : no_score;
    if (q->log_likelihood) q->log_likelihood[r->t] = r->present ? K(log_likelihood_last)(q->filter) : 0;
    if (q->taken) q->taken[r->t] = r->present ? K(taken)(q->filter) : 0;
}

/* Row t of what a view shows; each result may be NULL.  What it does not show is not to be had. */
static kq_status K(read_view)(const K(filter) *view, size_t n, size_t t, num *mean, num *mean_low, num *sigma,
                              number *variance, number *covariance)
{
    number local[KQ_SIZE_MAX * KQ_SIZE_MAX];
    number *P = covariance ? covariance + t * n * n : local;
    for (size_t i = 0; i < n; i++) {
        if (mean) mean[t * n + i] = K(mean)(view, (int)i);
        if (mean_low) mean_low[t * n + i] = K(mean_low)(view, (int)i);
        if (sigma) sigma[t * n + i] = K(sigma)(view, (int)i);
    }
    if (!variance && !covariance) return KQ_OK;
    const kq_status status = K(covariance)(view, P);
    if (variance) K(diagonal)(P, status, n, variance + t * n);
    for (size_t k = 0; k < n * n && status; k++) P[k] = no_number;
    return status;
}

static kq_status K(look_back)(K(sequence) *q, size_t t)
{
    K(filter) view = {0};
    kq_status status = KQ_OK;
    if (!q->lag_follows) {
        status = K(attach)(q->filter, &q->lag->attached);
        q->lag_follows = !status;
    }
    const int is_there = q->lag_follows && K(lag_steps)(q->lag) >= q->age;
    if (!status) status = K(lagged)(q->lag, is_there ? q->age : 0, &view);
    if (!is_there) view = (K(filter)){0};
    (void)K(read_view)(&view, q->filter->states, t, q->lagged, q->lagged_low, q->lagged_sigma, q->lagged_variance, NULL);
    return status == KQ_ERR_NOT_READY ? KQ_OK : status; /* a start that is unknown so far */
}

static uint32_t K(present_in)(const num *z, size_t m)
{
    uint32_t present = 0;
    for (size_t c = 0; c < m; c++) present |= (uint32_t)!is_lost(z[c]) << c;
    return present;
}

static kq_status K(refine)(K(sequence) *q, size_t t)
{
    K(filter) view = {0};
    kq_status status = KQ_OK;
    if (!q->instant_follows && t == q->instant_row) {
        status = K(attach)(q->filter, &q->instant->attached);
        q->instant_follows = !status;
    }
    if (q->instant_follows) status = K(instant_smooth)(q->instant, &view);
    (void)K(read_view)(&view, q->filter->states, t, q->instant_mean, q->instant_low, q->instant_sigma, q->instant_variance,
                       q->instant_covariance);
    return status;
}

/* A start that is unknown so far cannot settle. */
static kq_status K(settle)(K(sequence) *q, size_t t)
{
    kq_status status = KQ_OK;
    if (!q->is_settling) {
        status = K(attach)(q->filter, &q->settling->attached);
        q->is_settling = !status;
    }
    if (q->settled) q->settled[t] = (uint8_t)(q->is_settling && K(freeze_is_active)(q->settling));
    return status == KQ_ERR_NOT_READY ? KQ_OK : status;
}

/* What follows the filter, after a row */
static kq_status K(follow)(K(sequence) *q, size_t t)
{
    kq_status status = q->lag && q->lagged ? K(look_back)(q, t) : KQ_OK;
    if (!status && q->instant) status = K(refine)(q, t);
    if (!status && q->settling) status = K(settle)(q, t);
    return status;
}

/* A whole row that moves the mean alone; 0: it is none. */
static int K(rest)(const K(row) *r)
{
    const K(sequence) *q = r->q;
    const size_t t = r->t, m = r->m, l = q->process->controls;
    num spare[KQ_SIZE_MAX], *e = q->innovation ? q->innovation + t * m : spare;
    const K(place) *place = r->places + r->here;
    if (!r->period || !place->is_found || r->present != r->all) return 0;
    const num *u = q->u ? q->u + t * l : NULL;
    if (!r->kernels.calm(&place->calm, q->filter, r->process, u, r->sensor, q->z + t * m, e)) return 0;
    if (r->period > 1) memcpy(q->filter->memory + mean_words(r->n), r->places[K(next)(r)].root, sizeof(num) * (size_t)root_words(r->n));
    if (q->innovation_variance) K(look_at_variances)(r, q->filter);
    return 1;
}

/* What was found of a calm step is of one process and one sensor. */
static void K(begin_row)(K(row) *r, size_t t)
{
    const K(sequence) *q = r->q;
    const K(process) *process = q->processes ? q->processes[t] : q->process;
    const K(sensor) *sensor = q->sensors ? q->sensors[t] : q->sensor;
    r->t = t;
    r->present = K(present_in)(q->z + t * r->m, r->m);
    if (process != r->process || sensor != r->sensor) {
        r->count = 0;
        r->period = 0;
    }
    r->process = process;
    r->sensor = sensor;
}

kq_status K(sequence_run)(K(sequence) *q)
{
    const size_t n = q->filter->states, m = q->sensor->components;
    K(place) places[PLACES];
    K(row) r = {.q = q, .n = n, .m = m, .all = UINT32_MAX >> (32 - m), .places = places};
    r.kernels = K(kernels_for)((int)n, (int)m, q->is_upper);
    r.may_rest = r.kernels.calm && !q->losses && !q->watch && !q->lag && !q->instant &&
                 !q->settling && !q->adaptation;
    q->rested = 0;
    for (q->done = 0; q->done < q->steps; q->done++) {
        K(begin_row)(&r, q->done);
        const int is_at_rest = K(rest)(&r);
        kq_status status = is_at_rest ? KQ_OK : K(take_row)(&r);
        q->rested += (size_t)is_at_rest;
        if (status < KQ_OK) return status;
        K(judge)(&r);
        K(readings)(&r);
        K(seek_calm)(&r);
        if (q->covariance) {
            status = K(read_view)(q->filter, n, r.t, NULL, NULL, NULL, NULL, q->covariance);
            if (status && status != KQ_ERR_NOT_READY) return status;
        }
        status = K(follow)(q, r.t);
        if (status) return status;
    }
    return KQ_OK;
}

kq_status K(history_read)(const K(history) *h, size_t first, size_t steps, num *mean, num *mean_low, num *sigma,
                          number *variance, number *covariance)
{
    for (size_t t = 0; t < steps; t++) {
        K(filter) view;
        kq_status status = K(smoothed)(h, first + t, &view);
        if (!status) status = K(read_view)(&view, h->states, t, mean, mean_low, sigma, variance, covariance);
        if (status) return status;
    }
    return KQ_OK;
}

kq_status K(diffuse_read)(const K(diffuse) *s, size_t first, size_t steps, num *mean, num *mean_low, num *sigma,
                        number *variance, number *covariance)
{
    for (size_t t = 0; t < steps; t++) {
        K(filter) view;
        kq_status status = K(diffuse_smoothed)(s, first + t, &view);
        if (!status || status == KQ_ERR_NOT_READY) { /* not determined by all rows, or there was no room for it */
            status = K(read_view)(&view, s->states, t, mean, mean_low, sigma, variance, covariance);
        }
        if (status && status != KQ_ERR_NOT_READY) return status;
    }
    return KQ_OK;
}

kq_status K(steady_run)(K(steady) *filter, size_t steps, const num *z, const uint32_t *present,
                        const num *u, int begins, num *mean, num *innovation, size_t *done)
{
    const size_t n = filter->states, m = filter->components;
    const size_t l = filter->process ? filter->process->controls : 0;
    for (*done = 0; *done < steps; ++*done) {
        const size_t t = *done;
        const num *control = u ? u + t * l : NULL;
        kq_status status = t || !begins ? K(steady_predict)(filter, control) : KQ_OK;
        for (size_t c = 0; c < m && innovation; c++) innovation[t * m + c] = lost;
        if (!status && present[t]) {
            if (innovation) status = K(steady_innovation)(filter, z + t * m, innovation + t * m);
            if (!status) status = K(steady_update)(filter, z + t * m);
        }
        if (status < KQ_OK) return status;
        for (size_t i = 0; i < n; i++) mean[t * n + i] = K(steady_mean)(filter, (int)i);
    }
    return KQ_OK;
}

kq_status K(least_squares_run)(K(least_squares) *fit, size_t steps, const number *H, const num *z,
                               const number *r, num *mean, num *mean_low, num *sigma, number *variance,
                               score *nis, score *log_likelihood, int32_t *taken, size_t *done)
{
    const K(filter) *f = fit->filter;
    for (*done = 0; *done < steps; ++*done) {
        const size_t t = *done;
        const kq_status status = K(least_squares_add)(fit, H + t * f->states, z + t, r + t, 1);
        if (status < KQ_OK) return status;
        (void)K(read_view)(f, f->states, t, mean, mean_low, sigma, variance, NULL); /* what is not to be had is lost */
        if (nis) nis[t] = K(nis)(f);
        if (log_likelihood) log_likelihood[t] = K(log_likelihood_last)(f);
        if (taken) taken[t] = K(taken)(f);
    }
    return KQ_OK;
}
