#ifndef KQ_SRC_SMOOTHER_ON_LINE_H
#define KQ_SRC_SMOOTHER_ON_LINE_H

#include "estimate.h"
#include "recorder.h"

/* Where what is of one of them alone begins */
KQ_KERNEL num *on_line_end_of_tape(const history *h) { return h->memory + h->length; }

/* The update as it is, its rotations to be made later: the row, then r, e and s */
static void history_record_row(filter *f, const scaled *h, const num *row, const scaled *exact, scaled r,
                               scaled e, scaled s)
{
    num *record = history_extend(f, ROW_RECORD_LEN(f->states));
    if (!record) return;
    history_add_rounding(f, h, s, 1);
    if (row) copy(record, row, ROW_LEN(f->states));
    else row_fitted(record, exact, f->states);
    store_row_record(record + ROW_LEN(f->states), r, e, s);
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

/* What lag and instant record */
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

/* kq_predict of what is attached to f: `move` predicts, and keeps the map of it */
KQ_KERNEL kq_status on_line_predict(filter *f, const process *p, const num *u,
                                    void (*move)(filter *f, const process *p, const num *u))
{
    const kq_status status = predict_check(f, p, u);
    if (status) return status;
    if (on_line_goes_on(f)) move(f, p, u);
    else (void)predict_now(f, p, u);
    return KQ_OK;
}

/* Is it attached, and has it been able to follow? */
static kq_status on_line_check(const history *h)
{
    if (!h->filter || h->filter->attached != &h->attached) return KQ_ERR_HISTORY_EMPTY;
    return h->phase == HISTORY_ROWS ? KQ_OK : KQ_ERR_HISTORY_FULL;
}

/* Can it show its answer in a view?  h may be NULL. */
static kq_status on_line_check_view(const history *h, filter *view)
{
    if (!view) return KQ_ERR_NULL;
    if (h && view == h->filter) return KQ_ERR_MISMATCH;
    const kq_status status = h ? on_line_check(h) : KQ_ERR_NULL;
    return status ? view_nothing(view, status) : KQ_OK;
}

/* The answer in a view, with its events, which are the filter's, too */
static kq_status on_line_show(const history *h, filter *view, int states_only, unsigned events)
{
    filter_note(h->filter, events);
    view_state(view, on_line_answer(h, h->states), h->states, states_only ? VIEW_OF_MEAN : VIEW_OF_STATE, events);
    view_take_formats(view, h);
    return KQ_OK;
}

#endif
