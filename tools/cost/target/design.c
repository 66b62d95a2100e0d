/* A filter that kalmanq design has written, on a target: design.h is of one (tools/cost/designs.py). */
#include "design.h"

void cost_region(unsigned region);
void cost_failed(int status);
void cost_end(void);

enum { CALLS = COUNTED, NO_MORE, FIRST_ROWS = 4, WRONG = -100 };

static volatile word input[M], output[2]; /* volatile: nothing is left out */

static void need(int status)
{
    if (status < 0) cost_failed(status);
}

/* Row t is the first where t is 0. */
static int take(int t)
{
    if (t == 0) return DESIGN(update)(rows[t], present[t]);
    return STEP(t);
}

/* The twin's numbers after row t; of a state that nothing is known of yet, NaN */
static void compare(int t)
{
    for (int i = 0; i < N; i++) {
        const word mean = MEAN(DESIGN(filter)(), i), twin = expected[t][i];
        if (mean != twin && (IS_KNOWN(mean) || IS_KNOWN(twin))) cost_failed(WRONG - i);
    }
}

static void begin(void)
{
    cost_region(CALLS); /* all that is called up to the next mark: for the stack */
    need(DESIGN(init)());
    for (int t = 0; t < FIRST_ROWS; t++) need(take(t));
    cost_region(NO_MORE);
}

int main(void)
{
    begin();
    for (int t = FIRST_ROWS; t < ROWS; t++) {
        if (t >= ROWS - COUNTED) cost_region((unsigned)(t - (ROWS - COUNTED)));
        need(take(t));
        if (t < ROWS - COUNTED) compare(t);
    }
    compare(ROWS - 1);
    cost_end();
    return 0;
}

/* A user's program, and the same without a filter: what the linker keeps of one more than of the other */
void use_design(void)
{
    word z[M];
    if (DESIGN(init)()) return;
    for (;;) {
        for (int c = 0; c < M; c++) z[c] = input[c];
        if (STEP_OF(z)) continue;
        for (int i = 0; i < N; i++) {
            output[0] = MEAN(DESIGN(filter)(), i);
            output[1] = SIGMA(DESIGN(filter)(), i);
        }
    }
}

void use_nothing(void)
{
    for (;;) {
        for (int c = 0; c < M; c++) output[0] = input[c];
    }
}
