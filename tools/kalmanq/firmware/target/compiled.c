/* A filter that kalmanq compile has written, on a target: cost-calls.h names it (measured.py). */
#include "cost-calls.h"

void cost_region(unsigned region);
void cost_failed(int status);
void cost_end(void);

enum { PREDICT, UPDATE, PREDICT_SETTLED, UPDATE_SETTLED, STEP_SETTLED, STEP, NO_MORE };

static FILTER f;
/* Never the same, so that no innovation comes to 0: without an FPU that would cost less.  volatile: nothing is left
 * out */
static volatile word inputs[] = {-12 * ONE, 2 * ONE, -2 * ONE, -ONE, 5 * ONE, -7 * ONE, 9 * ONE, 7 * ONE};
static int rows;

static void sample(word z[M + 1])
{
    for (int j = 0; j < M; j++) z[j] = inputs[(rows + 3 * j) % 8];
    rows++;
}

static void in_two(unsigned region)
{
    word z[M + 1];
    sample(z);
    cost_region(region);
    PREDICT_OF(&f);
    cost_region(region + 1);
    DO(update)(&f, z);
    cost_region(NO_MORE);
}

static void in_one(unsigned region)
{
    word z[M + 1];
    sample(z);
    cost_region(region);
    STEP_OF(&f, z);
    cost_region(NO_MORE);
}

int main(void)
{
    word z[M + 1];
    sample(z);
    DO(start)(&f);
    DO(update)(&f, z);
    in_one(STEP);
    in_two(PREDICT);
    for (int t = 0; t < ROWS; t++) {
        sample(z);
        STEP_OF(&f, z);
    }
    SETTLE(f);
    in_two(PREDICT_SETTLED);
    for (int k = 0; k < 4; k++) in_one(STEP_SETTLED); /* the one with most instructions counts */
    if (REFUSED) cost_failed(-1);
    cost_end();
    return 0;
}
