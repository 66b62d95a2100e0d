/* The filter's own functions, as if nothing were attached: called, so that a module that is attached does
   not compile them once more. */
#ifndef KQ_SRC_FILTER_ALONE_H
#define KQ_SRC_FILTER_ALONE_H

#include <stdint.h>

#include "kalmanq/filter.h"
#include "kalmanq/status.h"

#include "../arithmetic/arithmetic.h"
#include "../model/types.h"
#include "attached.h"

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
