/* What the checked number layer has in one place for all files: the sites, and the end. */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "sites.h"

static checked_site *sites;

void checked_enter(checked_site *site)
{
    site->seen = 1;
    site->next = sites;
    sites = site;
}

_Noreturn void checked_stop(const checked_site *site, const char *why, int64_t a, int64_t b,
                            int bits, int64_t result)
{
    fflush(stdout);
    fprintf(stderr, "%s:%d: %s: %s: %" PRId64 ", %" PRId64 ", bits %d: %" PRId64 "\n", site->file,
            site->line, site->operation, why, a, b, bits, result);
    abort();
}

void checked_report(double bits)
{
    for (const checked_site *s = sites; s; s = s->next) {
        const double left = s->most ? s->bits - log2((double)s->most) : 64;
        if (left > bits) continue;
        printf("%s:%d: %s: %.6f of %d bits\n", s->file, s->line, s->operation, s->bits - left,
               s->bits);
    }
}
