/* What moves the mean of a filter, but for its own steps.  The door: sigma points use it, too. */
#ifndef KQ_SRC_LINEARISED_LINEARISED_H
#define KQ_SRC_LINEARISED_LINEARISED_H

#include "../filter/filter.h"

/* Has what is attached nothing to say of how the mean moves?  What is learnt from it, or moves it, has; a
   start of which nothing is unknown has not. */
static int mean_is_free(const filter *f)
{
    if (!f->attached) return 1;
    const hooks *with = f->attached->hooks;
    return with->is_recorder || (with->give && f->ready);
}

static kq_status free_mean_check(const filter *f)
{
    const kq_status status = filter_check(f);
    if (status) return status;
    return mean_is_free(f) ? KQ_OK : KQ_ERR_RECORDING;
}

/* x += d + low; low: NULL for none.  What is moved not representable is lost (arithmetic/saturate_float.h), and what is
   recorded ends. */
static void move_by(filter *f, const num *d, const num *low)
{
    num *x = f->memory;
    const int n = f->states;
    const unsigned events = mean_saturated(x, filter_root(f), n, mean_shift(x, n, d, low));
    filter_note(f, events);
    if ((events & KQ_EVENT_OVERFLOW) && f->attached) f->attached->hooks->record_end(f);
}

/* May p linearised predict f?  All that can be said before its increment is known. */
kq_status T(kq_predict_check)(const filter *f, const process *p);

/* Are they ready, and s for f? */
kq_status T(kq_update_check)(const filter *f, const sensor *s);

/* root <- tria [rows, G], G the root of p's noise, in floating point.  rows: n x n, not kept; pq: 2 n.  Answers
   how far it reaches. */
extent T(kq_root_of_rows)(num *root, num *rows, const process *p, num *pq);

/* Ends a predict, the root being predicted: x <- x + d, and what is not representable is held.  Answers the
   events, which have been told. */
unsigned T(kq_predict_end)(filter *f, const num *d, extent of_root);

/* The update by a sensor whose rows are S'h, its components independent, and the innovation e, in floating point:
   that of a state of mean 0 and root I, by which S is multiplied.  own: FILTER_LEN(n) words, of that state */
kq_status T(kq_update_by_rows)(filter *f, const sensor *s, const num *e, num *own);

#endif
