/* A filter that kalmanq compile has written, on a target: compiled.h names it (tools/cost/compiled.py). */
#include "compiled.h"

void cost_region(unsigned region);
void cost_failed(int status);
void cost_end(void);

enum { PREDICT, UPDATE, PREDICT_SETTLED, UPDATE_SETTLED, STEP_SETTLED, STEP, NO_MORE };

static FILTER f;
static volatile word input[M + 1], output; /* volatile: nothing is left out */

static void in_two(unsigned region)
{
    word z[M + 1];
    for (int j = 0; j < M; j++) z[j] = input[j];
    cost_region(region);
    PREDICT_OF(&f);
    cost_region(region + 1);
    DO(update)(&f, z);
    cost_region(NO_MORE);
}

static void in_one(unsigned region)
{
    word z[M + 1];
    for (int j = 0; j < M; j++) z[j] = input[j];
    cost_region(region);
    STEP_OF(&f, z);
    cost_region(NO_MORE);
}

int main(void)
{
    word z[M + 1];
    for (int j = 0; j < M; j++) {
        input[j] = (word)(j + 1) * ONE;
        z[j] = input[j];
    }
    DO(start)(&f);
    DO(update)(&f, z);
    in_one(STEP);
    in_two(PREDICT);
    for (int t = 0; t < ROWS; t++) STEP_OF(&f, z);
    in_two(PREDICT_SETTLED);
    in_one(STEP_SETTLED);
    if (f.sample_refused) cost_failed(-1);
    if (f.gap_refused) cost_failed(-2);
    cost_end();
    return 0;
}
