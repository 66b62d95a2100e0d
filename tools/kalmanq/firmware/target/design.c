/* A filter that kalmanq design has written, on a target: cost-calls.h names it (costs.py). */
#include "cost-calls.h"

void cost_region(unsigned region);
void cost_failed(int status);
void cost_end(void);

enum { INIT = COUNTED, UPDATE, STEP, LATE, FIRST_ROWS = 4, WRONG = -100 };
enum { FAR = 23, INFINITE = 40, WIDTHS = 3 }; /* bits */

static volatile word input[M], output[2]; /* volatile: nothing is left out */

static void need(int status)
{
    if (status < 0) cost_failed(status);
}

/* The twin's numbers after row t; of a state that nothing is known of yet, NaN */
static void compare(int t)
{
    for (int i = 0; i < N; i++) {
        const word mean = MEAN(DESIGN(filter)(), i), twin = expected[t][i];
        if (mean != twin && (IS_KNOWN(mean) || IS_KNOWN(twin))) cost_failed(WRONG - i);
    }
}

/* Row 0 is before the first step; region: of this step, or none */
static void begin(void)
{
    cost_region(INIT);
    need(DESIGN(init)());
    cost_region(UPDATE);
    need(DESIGN(update)(rows[0], present[0]));
    for (int t = 1; t < FIRST_ROWS; t++) {
        cost_region(STEP);
        need(STEP_OF(t, rows[t], present[t]));
        compare(t);
    }
}

/* Sigmas of the states 14 decades apart, or all far above the noise: rows of the root, which ends the memory */
static void widen(int width)
{
    for (int i = 0; i < N; i++) {
        int bits = width == WIDTHS - 1 ? INFINITE : (i + width) % 2 ? FAR : -FAR;
#ifdef EXPONENTS
        EXPONENTS[i] += bits;
#else
        word *const root = DESIGN(filter)()->memory + MEAN_LEN;
        for (int j = i; j < N; j++) root[j * (j + 1) / 2 + i] *= bits > 0 ? (word)(INT64_C(1) << bits) : 1 / (word)(INT64_C(1) << -bits);
#endif
    }
}

/* What goes deepest: measurements of low noise, each twice, and what comes late.  An answer does not count */
static void hard(int width)
{
    widen(width);
    for (int twin = 0; twin < 2; twin++) {
        cost_region(UPDATE);
        output[0] = (word)DESIGN(update)(rows[ROWS - 1], ALL);
    }
    output[0] = (word)STEP_OF(1, rows[0], 0);
    widen(width);
    cost_region(STEP);
    output[0] = (word)STEP_OF(1, rows[0], ALL);
#ifdef LATE_OF
    cost_region(LATE);
    output[0] = (word)LATE_OF(rows[0]);
#endif
}

int main(void)
{
    begin();
    for (int t = FIRST_ROWS; t < ROWS; t++) {
        if (t >= ROWS - COUNTED) cost_region((unsigned)(t - (ROWS - COUNTED)));
        need(STEP_OF(t, rows[t], present[t]));
        if (t < ROWS - COUNTED) compare(t);
    }
    compare(ROWS - 1);
    for (int width = 0; width < WIDTHS; width++) hard(width);
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
        if (STEP_OF(1, z, ALL)) continue;
#ifdef LATE_OF
        if (LATE_OF(z)) continue;
#endif
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
