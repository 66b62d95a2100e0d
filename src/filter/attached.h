/*
 * What is attached to a filter takes part in its steps: a history, a lag, an instant, a start, an adaptation, a
 * freeze.  By reference, from its attach: a program links nothing of what it never attaches.
 */
#ifndef KQ_SRC_FILTER_ATTACHED_H
#define KQ_SRC_FILTER_ATTACHED_H

#include "../model/model.h"

typedef struct T(kq_attached) attached;
typedef struct T(kq_hooks) hooks;

struct T(kq_hooks) {
    /* In the place of the public functions, with the checks that they have.  update: NULL where it is the
       filter's own. */
    kq_status (*predict)(filter *f, const process *p, const num *u);
    kq_status (*update)(filter *f, const sensor *s, const num *z, uint32_t present);
    kq_status (*step)(filter *f, const process *p, const num *u, const sensor *s, const num *z);
    /* Of each step that is recorded: before a predict; before a scalar measurement by h, of row S'h (or `exact`,
       in numbers), noise r, innovation e and variance s is taken; for one that is not taken; where the state
       has left the numbers.  All of them, or the empty ones below. */
    void (*record_predict)(filter *f, const process *p);
    void (*record_update)(filter *f, const scaled *h, const num *row, const scaled *exact, scaled r, scaled e, scaled s);
    void (*record_nothing)(filter *f);
    void (*record_end)(filter *f);
    int is_recorder; /* 0, or RECORDS_... */
    /* Of a filter that may not be ready: h is to record once all of the state is known; or no more.  NULL
       where the filter is ready. */
    kq_status (*give)(filter *f, history *h);
    void (*lose)(filter *f, const history *h);
    /* Did the last step move the mean alone, and judge no measurement?  NULL where every step judges. */
    int (*is_frozen)(const filter *f);
    /* kq_attach and kq_detach of the object that has these hooks; NULL where its init attaches it. */
    kq_status (*attach)(filter *f, attached *object);
    kq_status (*detach)(attached *object);
};

/* What a recorder keeps of the process of a predict: where it is; the map that the predict was; or, of a
   linearised one, all of it */
enum { RECORDS_BY_REFERENCE = 1, RECORDS_MAPS, RECORDS_PROCESSES };

KQ_INLINE int is_attached(const filter *f) { return f && f->attached; }

static int is_recorded(const filter *f) { return f->attached && f->attached->hooks->is_recorder; }

/* Are NIS and count those of a step before the last one? */
static int is_resting(const filter *f)
{
    return is_attached(f) && f->attached->hooks->is_frozen && f->attached->hooks->is_frozen(f);
}

/*
 * Has what is to be attached to f another filter, its `own`?  What that filter has to say of it is not
 * asked: one that was initialised again, or is gone, has told nobody.  So what has a filter goes to another
 * one by its detach alone.
 */
KQ_INLINE int has_other_filter(const filter *own, const filter *f) { return own && own != f; }

/* Is something else than `own` attached?  A start of which nothing is unknown has nothing to do any more. */
static int has_other_attached(const filter *f, const attached *own)
{
    return f->attached && f->attached != own && !(f->attached->hooks->give && f->ready);
}

static void predict_not_recorded(filter *f, const process *p) { (void)f, (void)p; }

static void update_not_recorded(filter *f, const scaled *h, const num *row, const scaled *exact, scaled r, scaled e,
                                scaled s)
{
    (void)f, (void)h, (void)row, (void)exact, (void)r, (void)e, (void)s;
}

static void nothing_recorded(filter *f) { (void)f; }

/* The empty functions of what records nothing */
#define KQ_RECORDS_NOTHING                                                                         \
    .record_predict = predict_not_recorded, .record_update = update_not_recorded,                  \
    .record_nothing = nothing_recorded, .record_end = nothing_recorded

static kq_status predict_alone(filter *f, const process *p, const num *u)
{
    attached *with = f->attached;
    f->attached = 0;
    const kq_status status = T(kq_predict)(f, p, u);
    f->attached = with;
    f->plain = 0;
    return status;
}

static kq_status update_alone(filter *f, const sensor *s, const num *z, uint32_t present)
{
    attached *with = f->attached;
    f->attached = 0;
    const kq_status status = T(kq_update_subset)(f, s, z, present);
    f->attached = with;
    f->plain = 0;
    return status;
}

#endif
