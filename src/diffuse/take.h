/* The diffuse start: one scalar measurement (unknown.h). */
#ifndef KQ_SRC_DIFFUSE_TAKE_H
#define KQ_SRC_DIFFUSE_TAKE_H

#include "../smoother/smoother.h"
#include "columns.h"
#include "past.h"
#if KQ_FLOATING
#include "ranges_float.h"
#else
#include "ranges_q31.h"
#endif

/* A measurement, as the unknowns are seen by it */
typedef struct {
    scaled h[KQ_SIZE_MAX];      /* its row of H */
    scaled size[KQ_SIZE_MAX];   /* the sizes of the terms that h is the sum of */
    scaled g[KQ_SIZE_MAX];      /* D'h */
    scaled w[KQ_SIZE_MAX];      /* F F'h */
    scaled error;               /* the standard error of h'F */
    scaled own;                 /* and of g's own rounding, but for the entry that leads */
    scaled fresh[KQ_SIZE_MAX];  /* the sizes of the terms that g is the sum of */
    scaled turned[KQ_SIZE_MAX]; /* what D's reflection rounds in each row, squared */
    scaled range;               /* the sigma of delta_1 by the ranges, or 0 where it tells more */
} sight;

static void diffuse_row(sight *by, const reading *z, int c)
{
    const sensor *s = z->sensor;
    const int n = s->states;
    for (int k = 0; k < n; k++) {
        terms t = terms_begin();
        terms_add(&t, scaled_one, s->measurement[c * n + k]);
        for (int j = c + 1; sensor_is_correlated(s) && j < s->components; j++) {
            if (!(z->present >> j & 1)) continue;
            terms_add(&t, z->noise[column(j) + c], s->measurement[j * n + k]);
        }
        by->h[k] = t.value;
        by->size[k] = t.size;
    }
}

/* g = D'h; answers whether it is not 0.  Where that is within 4 to 32 standard errors of rounding, it is hard
   to tell, or phi is uncertain by more than 3 %: precision is lost. */
static int diffuse_sees(const start *s, sight *by)
{
    const scaled zero = scaled_zero();
    const diffuse_memory v = diffuse_memory_of(s);
    const int n = s->states;
    int sees = 0, may_see = 0, surely = 0;
    by->error = rounding_seen(by->w, v.rounding, by->h, n);
    for (int j = 0; j < s->unknowns; j++) {
        terms t = terms_begin();
        scaled size = zero;
        for (int i = 0; i < n; i++) {
            const scaled entry = entry_get(unknown_row(v.unknown, n, i), j);
            terms_add(&t, by->h[i], entry);
            size = scaled_plus(size, scaled_times(by->size[i], scaled_magnitude(entry)));
        }
        by->g[j] = t.value;
        by->fresh[j] = size;
        const scaled error = hypotenuse(by->error, size);
        sees |= is_significant(t.value, error);
        may_see |= is_significant(t.value, scaled_shift(error, -2));
        surely |= is_significant(scaled_shift(t.value, -1), error);
    }
    if (may_see && !surely) s->filter->events |= KQ_EVENT_PRECISION;
    return sees;
}

/* F <- (I - k h') F + k e' and what the reflection rounds, e being what g is rounded by.  The lower triangle is the upper
   one: what they differ by would grow as A does. */
static void rounding_define(num *rounding, int n, const scaled *k, const sight *by)
{
    const scaled zero = scaled_zero();
    const scaled seen = hypotenuse(by->error, by->own), square = scaled_times(seen, seen);
    for (int i = 0; i < n; i++) {
        num *row = rounding_row(rounding, n, i);
        for (int j = i; j < n; j++) {
            scaled entry = scaled_minus(entry_get(row, j), scaled_times(k[i], by->w[j]));
            entry = scaled_minus(entry, scaled_times(by->w[i], k[j]));
            entry = scaled_plus(entry, scaled_times(scaled_times(k[i], k[j]), square));
            if (i == j && scaled_is_negative(entry)) entry = zero;
            entry_set(row, j, entry);
            entry_set(rounding_row(rounding, n, j), i, entry);
        }
        rounding_add(rounding, n, i, by->turned[i]);
    }
}

/* x += k e, in the past too */
static void diffuse_move(const start *s, const definition *m, const scaled *k, scaled e)
{
    const int n = s->states;
    update_mean(s->filter, k, e);
    for (uint32_t t = past_begin(s); t < s->steps; t++) {
        const past_state q = past_at(s, t);
        for (int i = 0; i < n; i++) {
            const scaled share = defined_share(q.unknown, n, i, m);
            filter_note(s->filter, mean_correct_exactly(q.mean, n, i, share, e));
        }
    }
}

/* By what the first move's rounding has left, unless that is beyond the numbers */
static void diffuse_move_again(const start *s, const definition *m, const scaled *k, scaled rest)
{
    if (move_is_finite(s->filter, k, rest)) diffuse_move(s, m, k, rest);
    else s->filter->events |= KQ_EVENT_PRECISION;
}

static void diffuse_define_root(const start *s, const definition *m, const scaled *k)
{
    const diffuse_memory v = diffuse_memory_of(s);
    const int n = s->states;
    const reflectors map = {v.W, v.pq, 0, n + 1, SHAPE_FULL};
    num *S = filter_root(s->filter);
    scaled row[KQ_SIZE_MAX] = {0};
    for (int i = 0; i < n; i++) {
        full_row(row, S, n, i);
        defined_row(v.W + i * ROW_LEN(n + 1), row, k[i], m, n);
    }
    root_of_rows(S, v.W, n + 1, n, v.pq);
    for (uint32_t t = past_begin(s); t < s->steps; t++) past_turn(s, t, &map, m);
}

/* What any history does, at an address of its own: a history that has been attached or assigned anew is
   seen not to be the one that the start began. */
static const hooks diffuse_tape_hooks = {KQ_RECORDS_STEPS};

static void diffuse_begin_tape(start *s)
{
    history_begin(s->tape, s->filter, &diffuse_tape_hooks);
}

static int diffuse_has_tape(const start *s)
{
    return s->tape && s->tape->attached.hooks == &diffuse_tape_hooks;
}

/* The filter takes over. */
static void diffuse_end(start *s)
{
    filter_set_ready(s->filter, s->filter->ready);
    if (!diffuse_is_recording(s)) s->tape = 0;
    else diffuse_begin_tape(s);
}

/* D <- D M, so that g = (phi, 0, ...), and B; k = D_1 / phi.  Answers phi. */
static scaled diffuse_reflect(start *s, sight *by, scaled *k)
{
    const scaled zero = scaled_zero();
    const diffuse_memory v = diffuse_memory_of(s);
    const int n = s->states, count = s->unknowns;
    mirror turn;
    const scaled phi = mirror_of(&turn, by->g, count);
    by->own = zero;
    for (int j = 0; j < count; j++) {
        if (j != turn.pivot) by->own = hypotenuse(by->own, by->fresh[j]);
    }
    for (int i = 0; i < n; i++) {
        num *row = unknown_row(v.unknown, n, i);
        by->turned[i] = mirror_row(row, &turn, count);
        k[i] = scaled_over(entry_get(row, 0), phi);
    }
    for (uint32_t t = past_begin(s); t < s->steps; t++) {
        const past_state q = past_at(s, t);
        past_reflect(&q, n, count, &turn, phi, hypotenuse(by->error, by->own));
    }
    return phi;
}

/* One dimension less */
static void diffuse_close_dimension(start *s)
{
    diffuse_drop(s, 0);
    diffuse_forget(s);
    if (s->unknowns == 0) diffuse_end(s);
}

/* What is seen is as large as the ranges let it be: S <- tria [S, D_1 range]. */
static void diffuse_bound(start *s, definition *m, const sight *by, const scaled *k)
{
    const scaled zero = scaled_zero();
    const int n = s->states;
    for (int i = 0; i < n; i++) {
        m->f[i] = zero;
        rounding_add(diffuse_memory_of(s).rounding, n, i, by->turned[i]);
    }
    m->sigma = scaled_times(m->phi, by->range);
    diffuse_define_root(s, m, k);
    s->filter->events |= range_event;
    diffuse_close_dimension(s);
}

/* Component c of z, of innovation e, defines what it sees.  0: it is still to be taken, as one that sees
   nothing unknown. */
KQ_NOINLINE static int diffuse_define(start *s, const reading *z, int c, sight *by, scaled e)
{
    const scaled zero = scaled_zero();
    filter *f = s->filter;
    const int n = s->states;
    const scaled r = scalar_noise(z, c);
    num row[ROW_LEN(KQ_SIZE_MAX)];
    scaled k[KQ_SIZE_MAX];
    definition m;
    m.phi = diffuse_reflect(s, by, k);
    m.sigma = scaled_root(r);
    project(row, filter_root(f), by->h, n);
    const scaled variance = scaled_plus(r, row_product(row, row, n));
    if (!move_is_finite(f, k, e)) {
        for (int i = 0; i < n; i++) {
            rounding_add(diffuse_memory_of(s).rounding, n, i, by->turned[i]);
        }
        f->events |= KQ_EVENT_OVERFLOW;
        return 1;
    }
    by->range = range_sigma(k, n, m.phi, variance);
    if (!scaled_is_zero(by->range)) {
        diffuse_bound(s, &m, by, k);
        return 0;
    }
    rounding_define(diffuse_memory_of(s).rounding, n, k, by);
    for (int j = 0; j < n; j++) m.f[j] = row_entry(row, n, j);
    diffuse_define_root(s, &m, k);
    diffuse_move(s, &m, k, e);
    diffuse_move_again(s, &m, k, scalar_innovation(f, z, c));
    const scaled size = scaled_magnitude(m.phi);
    likelihood_add(&f->last, zero, physical_variance(z->sensor, c, size));
    likelihood_multiply(&f->last, size);
    if (scaled_is_less(r, low_noise_share(variance))) filter_set_ready(f, f->ready | FILTER_LOW_NOISE);
    diffuse_close_dimension(s);
    return 1;
}

/* One that sees nothing unknown.  The tape, which has not begun, takes its record for the past. */
static void diffuse_take_known(start *s, const reading *z, int c, const scaled *h, scaled e)
{
    filter *f = s->filter;
    history *tape = diffuse_is_recording(s) ? s->tape : 0;
    if (tape) {
        tape->used = 0;
        tape->records = 0;
        filter_set_attached(f, &tape->attached);
    }
    take_with_care(f, z, c, h, e);
    if (!tape) return;
    filter_set_attached(f, 0);
    for (uint32_t t = past_begin(s); tape->records && t < s->steps; t++) {
        past_update(s, t, history_tape(tape, s->states));
    }
}

/* A prior's variance counts in the likelihood as in that of ever larger ones. */
static void likelihood_unbound(likelihood *p, scaled range)
{
    const scaled share = scaled_over(scaled_one, range);
    likelihood_multiply(p, share);
    likelihood_multiply(p, share);
}

/* K s = S S'h; answers s */
static scaled diffuse_gain(scaled *k, const filter *f, const scaled *h, scaled r)
{
    const int n = f->states;
    const num *S = filter_root(f);
    num row[ROW_LEN(KQ_SIZE_MAX)];
    project(row, S, h, n);
    for (int i = 0; i < n; i++) {
        k[i] = scaled_zero();
        for (int j = i; j < n; j++) k[i] = scaled_plus(k[i], scaled_times(root_number(S, n, i, j), row_entry(row, n, j)));
    }
    return scaled_plus(r, row_product(row, row, n));
}

/*
 * A measurement that sees nothing unknown: h'(D + F) = 0, so that (I - K h') (D + F) is D + F for any K.  With the filter's
 * own gain D loses what rounding has left of h'D, and F does not grow where the filter's errors do not, however A grows.
 */
KQ_NOINLINE static void unknown_measured(const start *s, sight *by, scaled r)
{
    const scaled zero = scaled_zero();
    const diffuse_memory v = diffuse_memory_of(s);
    const int n = s->states;
    scaled k[KQ_SIZE_MAX];
    const scaled variance = diffuse_gain(k, s->filter, by->h, r);
    if (!scaled_is_less(zero, variance) || variance_overflows(variance)) return;
    by->own = zero;
    for (int j = 0; j < s->unknowns; j++) by->own = hypotenuse(by->own, by->fresh[j]);
    for (int i = 0; i < n; i++) {
        num *row = unknown_row(v.unknown, n, i);
        k[i] = scaled_over(k[i], variance);
        by->turned[i] = zero;
        for (int j = 0; j < s->unknowns && !scaled_is_zero(k[i]); j++) {
            const scaled old = entry_get(row, j), part = scaled_times(k[i], by->g[j]);
            if (scaled_is_zero(part)) continue;
            entry_set(row, j, scaled_minus(old, part));
            by->turned[i] = scaled_plus(by->turned[i], scaled_times(old, old));
        }
    }
    rounding_define(v.rounding, n, k, by);
}

static void diffuse_take(start *s, const reading *z)
{
    sight by;
    for (int c = 0; c < z->sensor->components; c++) {
        if (!(z->present >> c & 1)) continue;
        diffuse_row(&by, z, c);
        const scaled e = scalar_innovation(s->filter, z, c);
        by.range = scaled_zero();
        if (s->unknowns && !diffuse_sees(s, &by)) unknown_measured(s, &by, scalar_noise(z, c));
        else if (s->unknowns && diffuse_define(s, z, c, &by, e)) continue;
        if (s->unknowns == 0) take_with_care(s->filter, z, c, by.h, e);
        else diffuse_take_known(s, z, c, by.h, e);
        if (!scaled_is_zero(by.range)) likelihood_unbound(&s->filter->last, by.range);
    }
}

/* Correlated, with components missing: the others' noise is made anew. */
KQ_NOINLINE static void diffuse_take_present(start *s, const reading *z)
{
    scaled noise[KQ_TRIANGLE(KQ_SIZE_MAX)];
    noise_of_present(noise, z->sensor, z->present);
    const reading some = {z->sensor, noise, z->z, z->present};
    diffuse_take(s, &some);
}

#endif
