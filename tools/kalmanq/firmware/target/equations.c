/* A nonlinear filter that kalmanq compile has written, on a target: cost-calls.h names it (measured.py).  Its
 * predict and the update of each sensor, at the simulated rows of NAME_test.c after it has started. */
#include "cost-calls.h"

void cost_region(unsigned region);
void cost_failed(int status);
void cost_end(void);

static FILTER f;

int main(void)
{
    DO(start)(&f);
    for (int t = 0; t < ROWS; t++) {
        const int k = t % RECORDED;
        if (t) {
            cost_region(0);
            PREDICT_OF(k);
        }
        UPDATES_OF(k)
        cost_region(NO_MORE);
        if (f.events & FAILED) cost_failed(-1);
    }
    cost_end();
    return 0;
}
