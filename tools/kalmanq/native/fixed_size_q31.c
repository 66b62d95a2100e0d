#include "fixed_size.h"

#include "kq_fixed_q31.h"

/* A mean may need more words within an update: all of every step is done. */
int kq_calm_find_q31(kq_calm_q31 *k, const filter *f, const process *p, const sensor *s, const int32_t *next)
{
    (void)k, (void)f, (void)p, (void)s, (void)next;
    return 0;
}

static int calm_step(const kq_calm_q31 *k, filter *f, const process *p, const num *u, const sensor *s, const num *z,
                     num *e, int n, int m)
{
    (void)k, (void)f, (void)p, (void)u, (void)s, (void)z, (void)e, (void)n, (void)m;
    return 0;
}

#define kq_calm_any_q31 0 /* other sizes have none */

#define SIZES(of) of(1) of(2) of(3) of(4)
#define PAIRS(of) of(1, 1) of(2, 1) of(2, 2) of(3, 1) of(4, 1) of(4, 2)

#include "fixed_size_table.h"
