/*
 * What is attached to a filter takes part in its steps: a history, a lag, a point, a start, an adaptation, a
 * settling.  By reference, from its attach: a program links nothing of what it never attaches.
 */
#ifndef KQ_SRC_FILTER_ATTACHED_H
#define KQ_SRC_FILTER_ATTACHED_H

#include <stdint.h>

#include "kalmanq/filter.h"
#include "kalmanq/status.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/compiler.h"
#include "../arithmetic/scaled.h"
#include "../model/types.h"

typedef struct T(kq_attached) attached;
typedef struct T(kq_hooks) hooks;
typedef struct T(kq_recorder) recorder;

/* Of each step that is recorded: before a predict; before a scalar measurement of row S'h (or `exact`, in
   numbers), noise r, innovation e and variance s is taken; for one that is not taken; where the state has
   left the numbers. */
struct T(kq_recorder) {
    void (*predict)(filter *f, const process *p);
    void (*update)(filter *f, const num *row, const scaled *exact, scaled r, scaled e, scaled s);
    void (*nothing)(filter *f);
    void (*end)(filter *f);
};

struct T(kq_hooks) {
    /* In the place of the public functions, with the checks that they have.  update: NULL where it is the
       filter's own. */
    kq_status (*predict)(filter *f, const process *p, const num *u);
    kq_status (*update)(filter *f, const sensor *s, const num *z, uint32_t present);
    kq_status (*step)(filter *f, const process *p, const num *u, const sensor *s, const num *z);
    /* Of a filter that may not be ready: is component i known?  h is to record once all is; or no more.
       NULL where it is ready. */
    int (*knows)(const filter *f, int i);
    kq_status (*give)(filter *f, history *h);
    void (*lose)(filter *f, const history *h);
    const recorder *records; /* NULL: it records nothing */
};

/* NULL also where what is attached has been assigned anew */
KQ_INLINE const hooks *hooks_of(const filter *f) { return f && f->attached ? f->attached->hooks : 0; }

/* Is something else than `own` attached?  A start of which nothing is unknown has nothing to do any more. */
static int has_other_attached(const filter *f, const attached *own)
{
    const hooks *with = hooks_of(f);
    return with && f->attached != own && !(with->knows && f->ready);
}

static const recorder *recorder_of(const filter *f)
{
    const hooks *attached = hooks_of(f);
    return attached ? attached->records : 0;
}

static void record_predict(filter *f, const process *p)
{
    const recorder *r = recorder_of(f);
    if (r) r->predict(f, p);
}

static void record_update(filter *f, const num *row, const scaled *exact, scaled r, scaled e, scaled s)
{
    const recorder *to = recorder_of(f);
    if (to) to->update(f, row, exact, r, e, s);
}

static void record_nothing(filter *f)
{
    const recorder *r = recorder_of(f);
    if (r) r->nothing(f);
}

static void record_end(filter *f)
{
    const recorder *r = recorder_of(f);
    if (r) r->end(f);
}

#endif
