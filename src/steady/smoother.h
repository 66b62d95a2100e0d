#ifndef KQ_SRC_STEADY_SMOOTHER_H
#define KQ_SRC_STEADY_SMOOTHER_H

#include <stddef.h>
#include <stdint.h>

#include "kalmanq/size.h"
#include "kalmanq/smoother.h"
#include "kalmanq/status.h"
#include "kalmanq/steady.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/coordinates.h"
#include "../arithmetic/root.h"
#include "../arithmetic/rows.h"
#include "../arithmetic/scaled.h"
#include "../arithmetic/triangle.h"
#include "../model/advance.h"
#include "../model/definitions.h"
#include "../model/sensor.h"
#include "../model/types.h"
#include "../model/units.h"
#include "../filter/filter.h"
#include "../filter/gain.h"
#include "../filter/match.h"
#include "../filter/sharp.h"
#include "../smoother/smoother.h"
#include "../smoother/tape.h"
#include "../smoother/whitened.h"
#include "checks.h"
#include "schedule.h"

typedef T(kq_steady_smoother) steady_smoother;

/* ------------------------------------------------------------------ the smoother's constants */

/* Takes measurements into f's root, the innovation of component `only` being e and the others 0, or
   all of them 0; f's history gets their records. */
static void record_innovation(filter *f, const reading *z, int only, scaled e)
{
    static const scaled zero;
    const sensor *s = z->sensor;
    scaled buffer[KQ_SIZE_MAX], x[KQ_SIZE_MAX], memory[SHARP_PARTS * KQ_SIZE_MAX];
    const sharp_work w = sharp_work_at(memory, f->states);
    careful_scalar one;
    const int n = f->states;
    for (int i = 0; i < n; i++) x[i] = zero;
    one.z = z;
    filter_set_ready(f, FILTER_READY);
    for (int c = 0; c < s->components; c++) {
        one.component = c;
        one.h = scalar_row(z, c, buffer);
        one.r = scalar_noise(z, c);
        one.e = c == only ? e : zero;
        if (sensor_is_correlated(s) && c < only) one.e = scaled_times(z->noise[column(only) + c], e);
        for (int i = 0; i < n; i++) {
            one.e = scaled_minus(one.e, scaled_times(scaled_normal(one.h[i]), x[i]));
        }
        if (!update_root(f, &one, &w)) continue;
        for (int i = 0; i < n; i++) {
            x[i] = scaled_plus(x[i], scaled_times(w.b[i], one.w));
        }
    }
}

/* The standard deviation of innovation c, or 1 */
static scaled innovation_sigma(const filter *f, const sensor *s, int c)
{
    num F[ROW_LEN(KQ_SIZE_MAX)];
    project(F, filter_root(f), s->measurement + c * f->states, f->states);
    const scaled variance = scaled_plus(row_product(F, F, f->states), noise_covariance(s, c, c));
    const scaled sigma = scaled_root(variance);
    return scaled_is_less(num_zero_variance, variance) ? sigma : scaled_normal(unit_entry(num_one));
}

/* One column of the map from (a, e) after an update to a before the predict before it: that of a's
   entry k, or of e's entry c in units of its `scale` */
static void smoother_column(scaled *out, int stride, history *h, filter *f, const num *root,
                            const process *p, const reading *z, int k, int c, scaled scale)
{
    const int n = f->states;
    const workspace v = workspace_at(h->memory, n);
    copy(filter_root(f), root, ROOT_LEN(n));
    predict_root(filter_root(f), filter_root(f), p, v.W, v.pq);
    renormalise(filter_root(f), n);
    history_begin(h, f, &history_hooks);
    record_innovation(f, z, c, scale);
    for (int i = 0; i < COORDINATE_PLANES * n; i++) v.a[i] = 0;
    if (k >= 0) {
        wide one;
        history_note(h, coordinate_of(&one, unit_entry(num_one)));
        history_note(h, coordinate_set(v.a, n, k, one));
    }
    undo_updates(h, n, 1);
    history_note(h, undo_predict_mean(p, root, &v));
    for (int i = 0; i < n; i++) {
        const scaled entry = coordinate_scaled(coordinate_get(v.a, n, i));
        out[i * stride] = c < 0 ? entry : scaled_over(entry, scale);
    }
    filter_set_attached(f, 0);
}

static void smoother_constants(const process *p, const reading *z, filter *f, num *root, history *h,
                               scaled *back, scaled *drive)
{
    static const scaled zero;
    const sensor *s = z->sensor;
    const int n = f->states, m = s->components;
    const workspace v = workspace_at(h->memory, n);
    for (int k = 0; k < n; k++) smoother_column(back + k, n, h, f, root, p, z, k, -1, zero);
    for (int c = 0; c < m; c++) {
        copy(filter_root(f), root, ROOT_LEN(n));
        predict_root(filter_root(f), filter_root(f), p, v.W, v.pq);
        renormalise(filter_root(f), n);
        smoother_column(drive + c, m, h, f, root, p, z, -1, c, innovation_sigma(f, s, c));
    }
}

kq_status T(kq_steady_smoother_make)(const filter *f, const process *p, const sensor *s,
                                     num *memory, size_t length, num *root, scaled *back,
                                     scaled *drive)
{
    scaled noise[KQ_TRIANGLE(KQ_SIZE_MAX)];
    filter trial;
    history h = {.filter = 0};
    kq_status status = steady_model_check(f, p, s);
    if (status) return status;
    if (!memory || !root || !back || !drive) return KQ_ERR_NULL;
    const int n = f->states, m = s->components;
    if (length < (size_t)STEADY_WORK_LEN(n, m)) return KQ_ERR_MEMORY;
    reading z = {s, s->noise, 0, UINT32_MAX};
    if (noise_is_of_others(s, UINT32_MAX)) {
        noise_of_present(noise, s, UINT32_MAX);
        z.noise = noise;
    }
    trial_of(&trial, f, memory);
    num *own = memory + FILTER_LEN(n);
    copy(own, filter_root(f), ROOT_LEN(n));
    status = T(kq_history_assign)(&h, n, own + ROOT_LEN(n), (size_t)HISTORY_LEN(n, m, 1, 0));
    if (status) return status;
    smoother_constants(p, &z, &trial, own, &h, back, drive);
    copy(root, own, ROOT_LEN(n));
    return KQ_OK;
}

/* ------------------------------------------------------------------ the smoother */

static kq_status smoother_check(const steady_smoother *c)
{
    if (!c || !c->root || !c->back || !c->drive) return KQ_ERR_NULL;
    if (c->states < 1 || c->states > KQ_SIZE_MAX) return KQ_ERR_SIZE;
    if (c->components < 1 || c->components > KQ_SIZE_MAX) return KQ_ERR_SIZE;
    const int n = (int)c->states, m = (int)c->components;
    kq_status status = smoother_root_check(c->root, n);
    if (!status) status = contraction_check(c->back, n * n);
    return status ? status : numbers_check(c->drive, n * m);
}

/* a <- J a + j e.  Answers the events. */
static unsigned smoother_back(num *a, const steady_smoother *c, const num *e)
{
    const int n = (int)c->states, m = (int)c->components;
    unsigned events = 0;
    num t[COORDINATE_PLANES * KQ_SIZE_MAX];
    copy(t, a, COORDINATE_PLANES * n);
    for (int i = 0; i < n; i++) {
        wide total = coordinate_row(c->back + i * n, t, n);
        for (int k = 0; k < m; k++) {
            const scaled part = scaled_times(c->drive[i * m + k], scaled_of_word(e[k]));
            events |= coordinate_add(&total, part);
        }
        events |= coordinate_set(a, n, i, total);
    }
    return events;
}

kq_status T(kq_steady_smooth)(const steady_smoother *c, num *x, const num *e, size_t steps)
{
    num a[COORDINATE_PLANES * KQ_SIZE_MAX];
    scaled row[KQ_SIZE_MAX];
    if (!x || !e) return KQ_ERR_NULL;
    kq_status status = smoother_check(c);
    if (!status && (steps < 1 || steps > KQ_COUNT_MAX)) status = KQ_ERR_SIZE;
    if (status) return status;
    const int n = (int)c->states, m = (int)c->components;
    for (size_t t = 0; t < steps; t++) {
        status = words_check(x + t * (size_t)n, n);
        if (!status) status = words_check(e + t * (size_t)m, m);
        if (status) return status;
    }
    unsigned events = 0;
    for (int k = 0; k < COORDINATE_PLANES * n; k++) a[k] = 0;
    for (size_t t = steps - 1; t > 0; t--) {
        num *mean = x + (t - 1) * (size_t)n;
        events |= smoother_back(a, c, e + t * (size_t)m);
        for (int i = 0; i < n; i++) {
            root_row(row, c->root, n, i);
            const scaled part = mean_part(row, a, n, i);
            events |= word_take(mean + i, scaled_plus(scaled_of_word(mean[i]), part));
        }
    }
    return events ? KQ_SATURATED : KQ_OK;
}

#endif
