/* The diffuse start: the smoother through it. */
#ifndef KQ_SRC_DIFFUSE_SMOOTH_H
#define KQ_SRC_DIFFUSE_SMOOTH_H

#include "diffuse.h"

/* What stays unknown is no result. */
static void past_mark_lost(const start *s, const past_state *q)
{
    const uint32_t hidden = hidden_columns(s);
    for (int i = 0; i < s->states; i++) {
        const num *row = unknown_row(q->unknown, s->states, i);
        if (row_is_zero(row, entry_get(q->error, i), s->unknowns, hidden)) continue;
        *q->lost = (num)(lost_rows(q) | UINT32_C(1) << i);
    }
}

/* x' given all data: coordinates of mean a and root T, or where these are NULL of 0 and I.  E
   becomes the root. */
static void past_finish(const start *s, uint32_t t, const num *a, const num *T)
{
    const scaled zero = scaled_zero();
    const diffuse_memory v = diffuse_memory_of(s);
    const past_state q = past_at(s, t);
    const int n = s->states;
    num w[ROW_LEN(KQ_SIZE_MAX)];
    scaled row[KQ_SIZE_MAX] = {0};
    past_mark_lost(s, &q);
    for (int i = 0; i < n; i++) {
        scaled move = zero;
        for (int k = 0; k < n; k++) {
            row[k] = load_scaled(along_at(&q, n, i, k));
            if (!a) continue;
            const scaled mean = coordinate_scaled(coordinate_get(a, n, k));
            move = scaled_plus(move, scaled_times(row[k], mean));
        }
        const unsigned moved = mean_correct_exactly(q.mean, n, i, move, scaled_one);
        const unsigned saturated = mean_saturate(q.mean, n, i);
        if (!(lost_rows(&q) >> i & 1)) filter_note(s->filter, moved | saturated);
        if (T) project(w, T, row, n);
        else row_fitted(w, row, n);
        past_join_row(v.joined, &q, n, i, w, n);
    }
    root_of_rows(q.root, v.joined, 2 * n, n, v.spare);
    filter_note(s->filter, state_saturate(q.mean, q.root, 0, n)); /* its root, too: it went through all that overflowed */
}

/* Did a state saturate, in a step or now?  What was recorded is then wrong. */
static kq_status diffuse_saturation(const start *s)
{
    const unsigned events = s->filter->events | (s->tape ? s->tape->events : 0u);
    return events & KQ_EVENT_SATURATED ? KQ_SATURATED : KQ_OK;
}

/* Has the tape been smoothed, or can it be now? */
static kq_status diffuse_smooth_tape(history *h, const filter *f)
{
    const int done = h->phase == HISTORY_SMOOTHING || h->phase == HISTORY_STATES;
    if (done && h->step == 0) return KQ_OK;
    if (h->filter != f) return KQ_ERR_HISTORY_EMPTY;
    return smooth_all(h, undo_mean_and_root, HISTORY_SMOOTHING);
}

kq_status T(kq_diffuse_smooth)(start *s)
{
    const kq_status status = diffuse_check(s);
    if (status) return status;
    if (!s->tape || s->phase != DIFFUSE_WAITING) return KQ_ERR_HISTORY_EMPTY;
    const num *a = 0, *T = 0;
    uint8_t phase = DIFFUSE_SMOOTHED;
    if (diffuse_is_open(s)) { /* nothing follows: the present is the last of the early instants */
        if (!diffuse_is_recording(s) || s->early == 0) return KQ_ERR_HISTORY_EMPTY;
        past_push(s);
        s->tape = 0; /* nothing was recorded on it */
    } else {
        if (!diffuse_has_tape(s)) return KQ_ERR_HISTORY_EMPTY;
        const kq_status wrong = diffuse_smooth_tape(s->tape, s->filter);
        if (wrong) return wrong;
        const workspace v = workspace_at(s->tape->memory, s->states);
        a = v.a;
        if (s->tape->phase == HISTORY_SMOOTHING) T = v.T;
        else phase = DIFFUSE_STATES;
    }
    for (uint32_t t = diffuse_first(s); t < s->steps; t++) past_finish(s, t, a, T);
    s->phase = phase;
    return diffuse_saturation(s);
}

/* Is step t one of the tape's? */
static int diffuse_is_on_tape(const start *s, size_t t)
{
    return !diffuse_check(s) && diffuse_has_tape(s) && s->phase != DIFFUSE_WAITING && t >= s->steps;
}

kq_status T(kq_diffuse_smoothed)(const start *s, size_t t, filter *view)
{
    if (!view) return KQ_ERR_NULL;
    const kq_status status = diffuse_check(s);
    if (status) return view_nothing(view, status);
    if (view == s->filter) return KQ_ERR_MISMATCH;
    if (diffuse_is_on_tape(s, t)) return T(kq_smoothed)(s->tape, t - (size_t)s->steps, view);
    if (t >= s->steps) return view_nothing(view, KQ_ERR_SIZE);
    if (s->phase == DIFFUSE_WAITING || t < diffuse_first(s)) return view_nothing(view, KQ_ERR_NOT_READY);
    const past_state q = past_at(s, (uint32_t)t);
    const int what = s->phase == DIFFUSE_STATES ? VIEW_OF_MEAN : VIEW_OF_STATE;
    view_state(view, q.mean, s->states, what, s->tape ? s->tape->events : 0u);
    view_share_formats(view, s->filter);
    view->known = (uint16_t)(view->known & ~lost_rows(&q));
    return KQ_OK;
}

#endif
