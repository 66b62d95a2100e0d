#ifndef KQ_SRC_SMOOTHER_ON_LINE_H
#define KQ_SRC_SMOOTHER_ON_LINE_H

#include "kalmanq/status.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/compiler.h"
#include "../arithmetic/coordinates.h"
#include "../arithmetic/mean.h"
#include "../arithmetic/root.h"
#include "../arithmetic/rows.h"
#include "../arithmetic/scaled.h"
#include "../model/types.h"
#include "../filter/attached.h"
#include "estimate.h"
#include "recorder.h"
#include "tape.h"
#include "whitened.h"

/* Of what both smoothers on line have: the tape of the current step, behind it what they answer */
KQ_KERNEL num *answer_state(const history *h, int n)
{
    return h->memory + h->length - FILTER_LEN(n);
}

/* The update as it is, its rotations to be made later: the row, then r, e and s */
static void history_record_row(filter *f, const num *row, const scaled *exact, scaled r,
                               scaled e, scaled s)
{
    num *record = history_extend(f, ROW_RECORD_LEN(f->states));
    if (!record) return;
    if (row) copy(record, row, ROW_LEN(f->states));
    else row_fitted(record, exact, f->states);
    record += ROW_LEN(f->states);
    store_scaled(record, r);
    store_scaled(record + SCALED_WORDS, e);
    store_scaled(record + 2 * SCALED_WORDS, s);
    history_of(f)->records++;
}

/* A measurement that was not taken moves no coordinate. */
static void history_record_no_row(filter *f) { (void)f; }

/* Another function has predicted: that step is not among the maps. */
static void on_line_end(filter *f, const process *p)
{
    (void)p;
    history_end(f);
}

/* What lag and point record */
#define KQ_RECORDS_ROWS                                                                            \
    .detach = history_detach, .record_predict = on_line_end, .record_update = history_record_row,                            \
    .record_nothing = history_record_no_row, .record_end = history_end, .is_recorder = RECORDS_MAPS

/* Records updates, for map_take_tape */
static kq_status on_line_attach(history *h, filter *f, const hooks *with)
{
    const kq_status status = tape_attach(h, f, with);
    if (!status) h->phase = HISTORY_ROWS;
    return status;
}

/* Can what is attached to f go on?  If not, f goes on without it. */
static int on_line_goes_on(filter *f)
{
    const history *h = history_of(f);
    if (h->filter == f) return h->phase == HISTORY_ROWS;
    history_end(f);
    return 0;
}

/* Is it attached, and has it been able to follow? */
static kq_status on_line_check(const history *h)
{
    if (!h->filter || h->filter->attached != &h->attached) return KQ_ERR_HISTORY_EMPTY;
    return h->phase == HISTORY_ROWS ? KQ_OK : KQ_ERR_HISTORY_FULL;
}

KQ_KERNEL estimate answer_of(const history *h, int count, int n)
{
    const workspace v = workspace_at(h->memory, n);
    return (estimate){.state = answer_state(h, n),
                      .columns = h->memory + h->length,
                      .next = v.a,
                      .after = v.spare,
                      .count = count};
}

/* What can be read of an answer; `count` columns, 0 where there is the mean alone */
static num answer_mean(const history *h, int i)
{
    if (i < 0 || i >= h->states) return num_nan();
    return mean_get(answer_state(h, h->states), h->states, i);
}

static num answer_mean_low(const history *h, int i)
{
    if (i < 0 || i >= h->states) return num_nan();
    return mean_low(answer_state(h, h->states), h->states, i);
}

static num answer_sigma(const history *h, int count, int i)
{
    if (count == 0 || i < 0 || i >= h->states) return num_nan();
    const estimate now = answer_of(h, count, h->states);
    return word_of(scaled_root(estimate_product(&now, h->states, i, i)));
}

static kq_status answer_covariance(const history *h, int count, scaled *P)
{
    if (!P) return KQ_ERR_NULL;
    if (count == 0) return KQ_ERR_NOT_READY;
    const estimate now = answer_of(h, count, h->states);
    estimate_covariance(&now, P, h->states);
    return KQ_OK;
}

#endif
