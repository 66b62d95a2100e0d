/* The call sites of the checked number layer. */
#ifndef KALMANQ_TESTS_SITES_H
#define KALMANQ_TESTS_SITES_H

#include <stdint.h>

typedef struct checked_site {
    const char *operation, *file;
    int line, bits, seen;
    uint64_t most; /* the largest magnitude that it has made, of 2^bits allowed */
    struct checked_site *next;
} checked_site;

void checked_enter(checked_site *site);

/* Says where and why, and stops the program. */
_Noreturn void checked_stop(const checked_site *site, const char *why, int64_t a, int64_t b,
                            int bits, int64_t result);

/* Every site that came within `bits` bits of its bound, to standard output */
void checked_report(double bits);

#endif
