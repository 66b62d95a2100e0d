/*
 * The diffuse start: early instants, carried along until all is known (unknown.h).  Before
 * they are smoothed their means are no results, and may be beyond the largest raw value.
 */
#ifndef KQ_SRC_DIFFUSE_PAST_H
#define KQ_SRC_DIFFUSE_PAST_H

#include "../filter/filter.h"
#include "rounding.h"
#include "unknown.h"

/* S <- tria [0, rows], n rows of `width`, which are left holding reflectors */
KQ_NOINLINE static void root_of_rows(num *S, num *rows, int width, int n, num *pq)
{
    (void)triangularise(S, rows, width, 0, n, pq, SHAPE_FULL);
    renormalise(S, n);
}

/* Row i of a root, its zeros too */
static void full_row(scaled *row, const num *S, int n, int i)
{
    const scaled zero = scaled_zero();
    for (int k = 0; k < n; k++) {
        row[k] = k < i ? zero : root_number(S, n, i, k);
    }
}

/* The present becomes a past: x' = x. */
static void past_push(start *s)
{
    scaled row[KQ_SIZE_MAX] = {0};
    const filter *f = s->filter;
    const int n = s->states;
    if (s->phase != DIFFUSE_WAITING) return; /* smoothed: what has been kept stays as it is */
    s->steps++;
    if (!diffuse_is_recording(s) || s->early == 0) return;
    s->next = (uint16_t)(s->next + 1 < s->early ? s->next + 1 : 0);
    const past_state q = past_at(s, s->steps - 1);
    copy(q.mean, f->memory, MEAN_PLANES * n);
    for (int k = 0; k < ROOT_LEN(n); k++) q.root[k] = 0;
    renormalise(q.root, n);
    for (int i = 0; i < n; i++) {
        full_row(row, filter_root(f), n, i);
        for (int k = 0; k < n; k++) store_scaled(along_at(&q, n, i, k), row[k]);
    }
    copy(q.unknown, diffuse_memory_of(s).unknown, n * n * SCALED_WORDS);
    for (int i = 0; i < n; i++) {
        entry_set(q.error, i, row_error(diffuse_memory_of(s).rounding, n, i));
    }
    *q.lost = 0;
}

/* The orthogonal map that the coordinates are going through, as reflectors */
typedef struct {
    const num *W, *pq;
    const process *model;
    int width, shape;
} reflectors;

/* Row w through it: C_i gets the part along the new coordinates, the rest is left in w. */
static void past_turn_row(const past_state *q, int n, int i, num *w, const reflectors *map)
{
    num row[ROW_LEN(KQ_SIZE_MAX)];
    for (int k = n - 1; k >= 0; k--) {
        const int c = first_column(map->model, k, map->shape);
        const num *r = map->W + k * ROW_LEN(map->width) + c;
        row[k] = reflect(w + c, 0, r, 0, map->pq + 2 * k, map->width - c);
    }
    row_set_exponent(row, n, row_exponent(w, map->width));
    for (int k = 0; k < n; k++) store_scaled(along_at(q, n, i, k), row_entry(row, n, k));
}

/* Row i of [E, w], w of `width` */
static void past_join_row(num *joined, const past_state *q, int n, int i, const num *w, int width)
{
    scaled entries[2 * KQ_SIZE_MAX + 1] = {0};
    full_row(entries, q->root, n, i);
    for (int k = 0; k < width; k++) entries[n + k] = row_entry(w, width, k);
    row_fitted(joined + i * ROW_LEN(n + width), entries, n + width);
}

/* A measurement that defines a delta */
typedef struct {
    scaled f[KQ_SIZE_MAX]; /* S'h */
    scaled sigma;          /* sqrt(r) */
    scaled phi;
} definition;

/* [row - k f', k sqrt(r)] */
static void defined_row(num *w, const scaled *row, scaled k, const definition *m, int n)
{
    scaled entries[KQ_SIZE_MAX + 1];
    for (int j = 0; j < n; j++) {
        entries[j] = scaled_minus(row[j], scaled_times(k, m->f[j]));
    }
    entries[n] = scaled_times(k, m->sigma);
    row_fitted(w, entries, n + 1);
}

/* k_i = B_i1 / phi */
static scaled defined_share(num *unknown, int n, int i, const definition *m)
{
    return scaled_over(entry_get(unknown_row(unknown, n, i), 0), m->phi);
}

/* C and E through a map.  m: the measurement that defined it, or NULL where a predict did */
static void past_turn(const start *s, uint32_t t, const reflectors *map,
                      const definition *m)
{
    const diffuse_memory v = diffuse_memory_of(s);
    const past_state q = past_at(s, t);
    const int n = s->states;
    num w[ROW_LEN(KQ_SIZE_MAX + 1)];
    scaled row[KQ_SIZE_MAX] = {0};
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < n; k++) row[k] = load_scaled(along_at(&q, n, i, k));
        if (m) defined_row(w, row, defined_share(q.unknown, n, i, m), m, n);
        else row_fitted(w, row, n);
        past_turn_row(&q, n, i, w, map);
        past_join_row(v.joined, &q, n, i, w, map->width);
    }
    root_of_rows(q.root, v.joined, n + map->width, n, v.spare);
}

/* The map of a predict to come */
static void past_predict(const start *s, const process *p)
{
    const diffuse_memory v = diffuse_memory_of(s);
    const reflectors map = {v.W, v.pq, p, s->states, SHAPE_AS_FOUND};
    if (past_begin(s) == s->steps) return;
    predict_root(v.joined, filter_root(s->filter), p, v.W, v.pq);
    for (uint32_t t = past_begin(s); t < s->steps; t++) past_turn(s, t, &map, 0);
}

/* The rotations of an ordinary update, from its record on the tape */
static void past_update(const start *s, uint32_t t, const num *record)
{
    const scaled zero = scaled_zero();
    const past_state q = past_at(s, t);
    const int n = s->states;
    for (int i = 0; i < n; i++) {
        scaled b = zero, cosine, sine;
        for (int k = 0; k < n; k++) {
            num *word = along_at(&q, n, i, k);
            const scaled old = load_scaled(word);
            if (record[k] == 0) continue; /* no turn */
            rotation_of(record[k], &cosine, &sine);
            store_scaled(word, scaled_minus(scaled_times(cosine, old), scaled_times(sine, b)));
            b = scaled_plus(scaled_times(cosine, b), scaled_times(sine, old));
        }
        filter_note(s->filter, mean_correct_exactly(q.mean, n, i, b, load_scaled(record + n)));
    }
}

#endif
