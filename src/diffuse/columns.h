/* The diffuse start: the columns of D (unknown.h). */
#ifndef KQ_SRC_DIFFUSE_COLUMNS_H
#define KQ_SRC_DIFFUSE_COLUMNS_H

#include "rounding.h"
#include "unknown.h"

/* The columns of D (bit j) that are below the rounding of each row, though A has not taken them to 0: other modes have
   grown away from them.  In these an entry is unknown however small it is. */
static uint32_t hidden_columns(const start *s)
{
    const diffuse_memory v = diffuse_memory_of(s);
    uint32_t hidden = (UINT32_C(1) << s->unknowns) - 1;
    for (int i = 0; i < s->states; i++) {
        const num *row = unknown_row(v.unknown, s->states, i);
        const scaled error = row_error(v.rounding, s->states, i);
        for (int j = 0; j < s->unknowns; j++) {
            if (is_significant(entry_get(row, j), error)) hidden &= ~(UINT32_C(1) << j);
        }
    }
    return hidden;
}

static int row_is_zero(const num *row, scaled error, int count, uint32_t hidden)
{
    const scaled zero = scaled_zero();
    for (int j = 0; j < count; j++) {
        if (is_significant(entry_get(row, j), hidden >> j & 1 ? zero : error)) return 0;
    }
    return 1;
}

/* The states (bit i) of which D_i is 0 */
static uint16_t known_states(const start *s)
{
    const diffuse_memory v = diffuse_memory_of(s);
    const uint32_t hidden = hidden_columns(s);
    uint32_t known = 0;
    for (int i = 0; i < s->states; i++) {
        const scaled error = row_error(v.rounding, s->states, i);
        if (row_is_zero(unknown_row(v.unknown, s->states, i), error, s->unknowns, hidden)) known |= UINT32_C(1) << i;
    }
    return (uint16_t)known;
}

/* Has A taken column j to 0?  Where the volumes of all A have not shrunk much, what is left of it was
   not taken by A but is below the rounding of others that have grown: then it is unknown still. */
static int column_is_zero(const start *s, int j)
{
    const scaled zero = scaled_zero();
    const diffuse_memory v = diffuse_memory_of(s);
    const int may_vanish = scaled_is_less(load_scaled(v.volume), scaled_shift(scaled_one, -8));
    for (int i = 0; i < s->states; i++) {
        const scaled entry = entry_get(unknown_row(v.unknown, s->states, i), j);
        const scaled error = may_vanish ? row_error(v.rounding, s->states, i) : zero;
        if (is_significant(entry, error)) return 0;
    }
    return 1;
}

static void column_drop(num *unknown, int n, int j, int last)
{
    for (int i = 0; i < n; i++) {
        num *row = unknown_row(unknown, n, i);
        entry_set(row, j, entry_get(row, last));
    }
}

/* Column j is gone, here and in the past. */
static void diffuse_drop(start *s, int j)
{
    const int last = s->unknowns - 1;
    column_drop(diffuse_memory_of(s).unknown, s->states, j, last);
    for (uint32_t t = past_begin(s); t < s->steps; t++) {
        column_drop(past_at(s, t).unknown, s->states, j, last);
    }
    s->unknowns = (uint8_t)last;
}

/* What depends on column j will never be known. */
static void past_lose(const past_state *q, int n, int j)
{
    uint32_t lost = lost_rows(q);
    for (int i = 0; i < n; i++) {
        const scaled entry = entry_get(unknown_row(q->unknown, n, i), j);
        if (is_significant(entry, entry_get(q->error, i))) lost |= UINT32_C(1) << i;
    }
    *q->lost = (num)lost;
}

/* A column of D that has become 0 is forgotten. */
static void diffuse_forget(start *s)
{
    for (int j = s->unknowns - 1; j >= 0; j--) {
        if (!column_is_zero(s, j)) continue;
        for (uint32_t t = past_begin(s); t < s->steps; t++) {
            const past_state q = past_at(s, t);
            past_lose(&q, s->states, j);
        }
        diffuse_drop(s, j);
    }
}

/* v <- A v for the n numbers `stride` apart; the squares of its roundings are added to `fresh` */
static void advance_vector(num *v, int stride, const process *p, scaled *fresh)
{
    scaled old[KQ_SIZE_MAX];
    const int n = p->states;
    for (int k = 0; k < n; k++) old[k] = entry_get(v, k * stride);
    for (int i = 0; i < n; i++) {
        terms t = terms_begin();
        for (int k = first_column(p, i, SHAPE_AS_FOUND); k < n; k++) {
            terms_add(&t, p->transition[i * n + k], old[k]);
        }
        entry_set(v, i * stride, t.value);
        if (!t.is_exact) fresh[i] = scaled_plus(fresh[i], scaled_times(t.size, t.size));
    }
}

/* D <- A D, F <- A F and what that rounds */
static void unknown_advance(const start *s, const process *p)
{
    const diffuse_memory v = diffuse_memory_of(s);
    const int n = s->states;
    scaled fresh[KQ_SIZE_MAX] = {0}, unused[KQ_SIZE_MAX] = {0};
    for (int j = 0; j < s->unknowns; j++) {
        advance_vector(v.unknown + j * SCALED_WORDS, n, p, fresh);
    }
    for (int j = 0; j < n; j++) advance_vector(v.rounding + j * SCALED_WORDS, n, p, unused);
    for (int i = 0; i < n; i++) advance_vector(rounding_row(v.rounding, n, i), 1, p, unused);
    for (int i = 0; i < n; i++) rounding_add(v.rounding, n, i, fresh[i]);
    entry_set(v.volume, 0, scaled_times(load_scaled(v.volume), volume_of(p)));
}

/* The reflection I - tau u u', u_0 = 1, behind the exchange of columns 0 and pivot */
typedef struct {
    scaled u[KQ_SIZE_MAX];
    scaled tau;
    int pivot;
    int exchange_only;
} mirror;

/* Takes g to (phi, 0, ...); answers phi.  The largest entry leads: no row loses digits. */
static scaled mirror_of(mirror *m, const scaled *g, int count)
{
    int pivot = 0;
    scaled phi = scaled_magnitude(g[0]), square = scaled_one;
    for (int j = 1; j < count; j++) {
        const scaled size = scaled_magnitude(g[j]);
        if (scaled_is_less(scaled_magnitude(g[pivot]), size)) pivot = j;
        phi = hypotenuse(phi, size);
    }
    for (int j = 0; j < count; j++) m->u[j] = g[j == 0 ? pivot : j == pivot ? 0 : j];
    m->pivot = pivot;
    m->exchange_only = 1;
    for (int j = 1; j < count; j++) m->exchange_only &= scaled_is_zero(m->u[j]);
    const scaled lead = g[pivot];
    if (m->exchange_only) return lead;
    if (scaled_is_negative(lead)) phi = scaled_negative(phi);
    const scaled v = scaled_plus(lead, phi);
    m->u[0] = scaled_one;
    for (int j = 1; j < count; j++) {
        m->u[j] = scaled_over(m->u[j], v);
        square = scaled_plus(square, scaled_times(m->u[j], m->u[j]));
    }
    m->tau = scaled_over(scaled_plus(scaled_one, scaled_one), square);
    return scaled_negative(phi);
}

/* A row of D or B; answers the square of what that rounds in all its columns but the first. */
static scaled mirror_row(num *row, const mirror *m, int count)
{
    const scaled zero = scaled_zero();
    const scaled first = entry_get(row, 0);
    scaled square = zero;
    terms along = terms_begin();
    entry_set(row, 0, entry_get(row, m->pivot));
    entry_set(row, m->pivot, first);
    if (m->exchange_only) return zero;
    for (int j = 0; j < count; j++) terms_add(&along, m->u[j], entry_get(row, j));
    if (scaled_is_zero(along.size)) return zero;
    for (int j = 0; j < count; j++) {
        const scaled old = entry_get(row, j), share = scaled_times(m->tau, m->u[j]);
        entry_set(row, j, scaled_minus(old, scaled_times(along.value, share)));
        if (j == 0 || scaled_is_zero(share)) continue;
        const scaled part = scaled_times(along.size, scaled_magnitude(share));
        const scaled size = scaled_plus(scaled_magnitude(old), part);
        square = scaled_plus(square, scaled_times(size, size));
    }
    return square;
}

/* The first column of D becomes what a measurement sees as phi, and seen, F as it is, with the
   standard error e. */
static void past_reflect(const past_state *q, int n, int count, const mirror *m, scaled phi,
                         scaled e)
{
    for (int i = 0; i < n; i++) {
        num *row = unknown_row(q->unknown, n, i);
        const scaled fresh = scaled_root(mirror_row(row, m, count));
        const scaled share = scaled_magnitude(scaled_over(entry_get(row, 0), phi));
        scaled error = hypotenuse(entry_get(q->error, i), fresh);
        error = hypotenuse(error, scaled_times(share, e));
        entry_set(q->error, i, error);
    }
}

#endif
