/* A filter that freezes its gain in the steady state, and leaves its covariance alone. */
#ifndef KQ_SRC_STEADY_FREEZE_H
#define KQ_SRC_STEADY_FREEZE_H

#include "../filter/filter.h"

typedef T(kq_freeze) freeze;

/* What the last step was: one that moved the root; one that hardly did, after which the gain is
   kept; one that hardly did and has kept it; one of the mean alone. */
enum { FREEZE_MOVING, FREEZE_STEADY, FREEZE_KEEPING, FREEZE_FROZEN };

kq_status T(kq_freeze_assign)(freeze *w, int n, int m, num *memory, size_t length, scaled *gain)
{
    if (!w || !memory || !gain) return KQ_ERR_NULL;
    if (!size_is_valid(n) || !size_is_valid(m)) return KQ_ERR_SIZE;
    if (length < (size_t)FREEZE_LEN(n)) return KQ_ERR_MEMORY;
    *w = (freeze){.attached = {&T(kq_freeze_hooks)},
                    .states = (uint8_t)n,
                    .components = (uint8_t)m,
                    .length = (uint16_t)FREEZE_LEN(n),
                    .memory = memory,
                    .gain = gain};
    return KQ_OK;
}

kq_status T(kq_freeze_init)(freeze *w, int bits)
{
    if (!w) return KQ_ERR_NULL;
    if (!size_is_valid(w->states) || !size_is_valid(w->components)) return KQ_ERR_SIZE;
    if (!w->memory || !w->gain || w->length < FREEZE_LEN((unsigned)w->states)) return KQ_ERR_MEMORY;
    if (bits < 1 || bits > freeze_bits_max) return KQ_ERR_SIZE;
    w->bits = (uint8_t)bits;
    w->phase = FREEZE_MOVING;
    w->process = 0;
    w->sensor = 0;
    return KQ_OK;
}

static kq_status freeze_check(const freeze *w)
{
    if (!w) return KQ_ERR_NULL;
    return w->bits ? KQ_OK : KQ_ERR_NOT_READY;
}

kq_status T(kq_freeze_release)(freeze *w)
{
    const kq_status status = freeze_check(w);
    if (!status) w->phase = FREEZE_MOVING;
    return status;
}

static int freeze_knows(const freeze *w, const process *p, const sensor *s)
{
    return w->process == p && w->sensor == s && w->fingerprint == p->fingerprint &&
           w->measurement == s->measurement;
}

static int roots_are_same(const num *a, const num *b, int n)
{
    for (int k = 0; k < ROOT_LEN(n); k++) {
        if (a[k] != b[k]) return 0;
    }
    return 1;
}

/* Is no row of a further from the row of b than 2^-bits of itself? */
static int root_is_steady(const num *a, const num *b, int n, int bits)
{
    for (int i = 0; i < n; i++) {
        scaled norm = root_number(a, n, i, i), change;
        change = scaled_minus(norm, root_number(b, n, i, i));
        norm = scaled_times(norm, norm);
        change = scaled_times(change, change);
        for (int k = i + 1; k < n; k++) {
            const scaled entry = root_number(a, n, i, k);
            const scaled d = scaled_minus(entry, root_number(b, n, i, k));
            norm = scaled_plus(norm, scaled_times(entry, entry));
            change = scaled_plus(change, scaled_times(d, d));
        }
        if (scaled_is_less(scaled_shift(norm, -2 * bits), change)) return 0;
    }
    return 1;
}

/* Is everything as it was when the last step ended? */
static int freeze_goes_on(const freeze *w, const filter *f, const process *p, const sensor *s)
{
    return w->phase != FREEZE_MOVING && freeze_knows(w, p, s) &&
           roots_are_same(w->memory, filter_root(f), f->states);
}

/* predict and update of the mean */
static void freeze_move_mean(const freeze *w, filter *f, const process *p, const num *u,
                               const sensor *s, const num *z)
{
    num t[MEAN_PLANES * KQ_SIZE_MAX];
    scaled e[KQ_SIZE_MAX];
    const int n = f->states, m = s->components;
    num *x = f->memory;
    extent far = predict_mean(x, p, p->controls ? u : 0, t, n, SHAPE_AS_FOUND);
    unsigned events = 0;
    for (int c = 0; c < m; c++) e[c] = mean_residual(z[c], s->measurement + c * n, x, n, 0, n);
    for (int i = 0; i < n; i++) {
        for (int c = 0; c < m; c++) {
            events |= mean_correct_exactly(x, n, i, w->gain[i * m + c], e[c]);
        }
    }
    mean_settle(x, n);
    for (int i = 0; i < n; i++) {
        events |= mean_saturate(x, n, i);
        far = extent_join(far, mean_extent(x, n, i));
    }
    filter_note(f, events | mean_saturated(x, filter_root(f), n, far));
}

/* predict and update; is the root steady? */
static kq_status freeze_move_all(freeze *w, filter *f, const process *p, const num *u,
                                   const sensor *s, const num *z)
{
    const int n = f->states, may_freeze = freeze_knows(w, p, s);
    const int keep = w->phase == FREEZE_STEADY;
    kq_status status = predict_alone(f, p, u);
    if (!status && keep) status = T(kq_gain)(f, s, w->gain);
    if (!status) status = update_alone(f, s, z, UINT32_MAX);
    if (status) return status;
    const int is_steady = may_freeze && root_is_steady(filter_root(f), w->memory, n, w->bits);
    w->phase = (uint8_t)(!is_steady ? FREEZE_MOVING : keep ? FREEZE_KEEPING : FREEZE_STEADY);
    copy(w->memory, filter_root(f), ROOT_LEN(n));
    w->process = p;
    w->sensor = s;
    w->fingerprint = p->fingerprint;
    w->measurement = s->measurement;
    return KQ_OK;
}

/* The freeze that is attached to f.  A copy of its filter goes on without it. */
static freeze *freeze_of(filter *f)
{
    freeze *w = (freeze *)f->attached;
    if (w->filter == f) return w;
    filter_set_attached(f, 0);
    return 0;
}

/* A predict by itself: there is no measurement at this step. */
static kq_status freeze_predict(filter *f, const process *p, const num *u)
{
    const kq_status status = predict_check(f, p, u);
    if (status) return status;
    freeze *w = freeze_of(f);
    if (w) {
        w->phase = FREEZE_MOVING;
        w->process = 0;
    }
    return predict_alone(f, p, u);
}

static kq_status freeze_step(filter *f, const process *p, const num *u, const sensor *s, const num *z)
{
    kq_status status = step_check(f, p, u, s, z);
    if (!status) status = takes_measurements(s, KQ_ERR_RECORDING);
    if (status) return status;
    freeze *w = freeze_of(f);
    if (!w) return T(kq_step)(f, p, u, s, z); /* nothing is attached to f any more */
    if (s->components != w->components) return KQ_ERR_MISMATCH;
    if (!freeze_goes_on(w, f, p, s)) w->phase = FREEZE_MOVING;
    if (w->phase < FREEZE_KEEPING) return freeze_move_all(w, f, p, u, s, z);
    freeze_move_mean(w, f, p, u, s, z);
    w->phase = FREEZE_FROZEN;
    return KQ_OK;
}

/* An update by itself has moved the root since the frozen step. */
static int freeze_is_active(const filter *f)
{
    const freeze *w = (const freeze *)f->attached;
    return w->filter == f && w->phase == FREEZE_FROZEN &&
           roots_are_same(w->memory, filter_root(f), f->states);
}

static kq_status freeze_attach(filter *f, attached *object)
{
    freeze *w = (freeze *)object;
    kq_status status = freeze_check(w);
    if (!status) status = filter_check(f);
    if (status) return status;
    if (f->states != w->states) return KQ_ERR_MISMATCH;
    if (has_other_filter(w->filter, f) || has_other_attached(f, &w->attached)) return KQ_ERR_RECORDING;
    w->phase = FREEZE_MOVING;
    w->process = 0;
    w->sensor = 0;
    w->filter = f;
    filter_set_attached(f, &w->attached);
    return KQ_OK;
}

static kq_status freeze_detach(attached *object)
{
    freeze *w = (freeze *)object;
    const kq_status status = freeze_check(w);
    if (status) return status;
    if (w->filter && w->filter->attached == &w->attached) filter_set_attached(w->filter, 0);
    w->filter = 0;
    return KQ_OK;
}

const hooks T(kq_freeze_hooks) = {
    .attach = freeze_attach, .detach = freeze_detach, .predict = freeze_predict, .step = freeze_step, .is_frozen = freeze_is_active, KQ_RECORDS_NOTHING};

int T(kq_freeze_is_active)(const freeze *w) { return w && w->phase == FREEZE_FROZEN; }

#endif
