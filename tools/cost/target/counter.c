/* What search.py hangs into the emulator: instructions of the calls that are announced, by basic blocks. */
#include <stdint.h>

enum { FUNCTIONS = 3, OWN = 2 };

typedef struct {
    uint64_t most[FUNCTIONS], now;             /* instructions of the dearest call, and of the one that runs */
    uint32_t entry[FUNCTIONS], mark;           /* addresses: of the functions, of what announces a call */
    uint32_t own[2 * OWN];                     /* beginnings and ends of what calls them */
    uint32_t base, is_announced;
    int32_t inside;                            /* which function runs, or -1 */
    const uint32_t *before;                    /* instructions before each half of a word from `base` on */
} counter;

static int is_own(const counter *c, uint32_t at)
{
    for (int k = 0; k < OWN; k++) {
        if (at >= c->own[2 * k] && at < c->own[2 * k + 1]) return 1;
    }
    return 0;
}

void entered(void *emulator, uint64_t address, uint32_t size, counter *c)
{
    const uint32_t at = (uint32_t)address, from = (at - c->base) >> 1;
    (void)emulator;
    if (at == c->mark) c->is_announced = 1;
    if (c->inside >= 0 && is_own(c, at)) {
        if (c->now > c->most[c->inside]) c->most[c->inside] = c->now;
        c->inside = -1;
    }
    for (int k = 0; k < FUNCTIONS && c->inside < 0 && c->is_announced; k++) {
        if (at != c->entry[k]) continue;
        c->inside = k, c->now = 0, c->is_announced = 0;
    }
    if (c->inside >= 0) c->now += c->before[from + (size >> 1)] - c->before[from];
}
