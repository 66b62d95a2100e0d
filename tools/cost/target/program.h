/* What every program for a target begins with. */
#ifndef KALMANQ_COST_PROGRAM_H
#define KALMANQ_COST_PROGRAM_H

#include "marks.h"
#include "names.h"

enum { STEADY = 20 }; /* the step that is measured */

#ifndef TAPE_STEPS
#define TAPE_STEPS 30 /* of the smoother; the one in the middle is measured */
#endif

static void need_ok(int status)
{
    if (status) cost_failed(status);
}

#endif
