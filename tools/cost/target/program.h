/* What every program for a target begins with. */
#ifndef KALMANQ_COST_PROGRAM_H
#define KALMANQ_COST_PROGRAM_H

#include "marks.h"
#include "names.h"

enum { STEADY = 20 }; /* the step that is measured */

#define TAPE_STEPS 30 /* of the smoother; the one in the middle is measured */

/* Of a user's program: no frame but the caller's lies between the mark and the library. */
#define ALWAYS_INLINE __attribute__((always_inline, unused)) static inline

static void need_ok(int status)
{
    if (status) cost_failed(status);
}

#endif
