#ifndef KQ_SRC_STEADY_SCHEDULE_H
#define KQ_SRC_STEADY_SCHEDULE_H

#include <stddef.h>

#include "kalmanq/size.h"
#include "kalmanq/status.h"
#include "kalmanq/steady.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/root.h"
#include "../arithmetic/rows.h"
#include "../arithmetic/scaled.h"
#include "../model/advance.h"
#include "../model/process.h"
#include "../model/sensor.h"
#include "../model/types.h"
#include "../model/units.h"
#include "../filter/filter.h"
#include "../filter/gain.h"

/* ------------------------------------------------------------------ the schedule */

/* Is no row of a further from that of b than 2^-bits of itself? */
static int root_has_settled(const num *a, const num *b, int n, int bits)
{
    for (int i = 0; i < n; i++) {
        scaled norm = scaled_normal(root_entry(a, n, i, i)), change;
        change = scaled_minus(norm, scaled_normal(root_entry(b, n, i, i)));
        norm = scaled_times(norm, norm);
        change = scaled_times(change, change);
        for (int k = i + 1; k < n; k++) {
            const scaled entry = scaled_normal(root_entry(a, n, i, k));
            const scaled d = scaled_minus(entry, scaled_normal(root_entry(b, n, i, k)));
            norm = scaled_plus(norm, scaled_times(entry, entry));
            change = scaled_plus(change, scaled_times(d, d));
        }
        if (scaled_is_less(scaled_shift(norm, -2 * bits), change)) return 0;
    }
    return 1;
}

/* From the prior in f, whose root is used up, until it settles: the number of updates, or 0 if
   there are more than `steps`.  Their gains, unless that is NULL.  scratch: a root, then predict's
 */
static size_t run_until_settled(filter *f, const process *p, const sensor *s, int bits,
                                scaled *gains, size_t steps, num *scratch)
{
    const int n = f->states;
    num *S = filter_root(f), *last = scratch, *W = last + ROOT_LEN(n), *pq = W + n * ROW_LEN(n);
    for (size_t t = 0; t < steps; t++) {
        update_root_by(f, s, gains ? gains + t * (size_t)(n * s->components) : 0);
        if (t > 0 && root_has_settled(S, last, n, bits)) return t + 1;
        copy(last, S, ROOT_LEN(n));
        predict_root(S, S, p, W, pq);
        renormalise(S, n);
    }
    return 0;
}

static kq_status steady_model_check(const filter *f, const process *p, const sensor *s)
{
    kq_status status = filter_check(f);
    if (!status) status = process_check(p);
    if (!status) status = sensor_check(s);
    if (status) return status;
    return process_fits(p, f) && sensor_fits(s, f) ? KQ_OK : KQ_ERR_MISMATCH;
}

kq_status T(kq_steady_schedule)(const filter *f, const process *p, const sensor *s, num *memory,
                                size_t length, int bits, scaled *gains, size_t steps, size_t *used)
{
    filter trial;
    const kq_status status = steady_model_check(f, p, s);
    if (status) return status;
    if (!memory || !gains || !used) return KQ_ERR_NULL;
    if (length < (size_t)STEADY_WORK_LEN(f->states, s->components)) return KQ_ERR_MEMORY;
    if (bits < 1 || bits > settled_bits_max) return KQ_ERR_SIZE;
    if (steps < 1 || steps > KQ_COUNT_MAX) return KQ_ERR_SIZE;
    num *scratch = memory + FILTER_LEN(f->states);
    trial_of(&trial, f, memory);
    const size_t count = run_until_settled(&trial, p, s, bits, 0, steps, scratch);
    if (count == 0) return KQ_ERR_NO_CONVERGENCE;
    trial_of(&trial, f, memory);
    *used = run_until_settled(&trial, p, s, bits, gains, count, scratch);
    return KQ_OK;
}

#endif
