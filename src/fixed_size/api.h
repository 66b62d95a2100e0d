/* The functions for sizes that the compiler knows: what is not plain, and what is wrong, the library's
   function takes. */
#ifndef KQ_SRC_FIXED_SIZE_API_H
#define KQ_SRC_FIXED_SIZE_API_H

#include "steps.h"

/* What KQ_FIXED_BARE leaves to the library leaves the likelihood as it was, too. */
KQ_NOINLINE static kq_status update_bare(filter *f, const sensor *s, const num *z)
{
    if (!f) return T(kq_update)(f, s, z);
    const likelihood before = f->last;
    const likelihood_run run = f->run;
    const kq_status status = T(kq_update)(f, s, z);
    f->last = before;
    f->run = run;
    return status;
}

KQ_NOINLINE static kq_status step_bare(filter *f, const process *p, const num *u, const sensor *s,
                                       const num *z)
{
    if (!f) return T(kq_step)(f, p, u, s, z);
    const likelihood before = f->last;
    const likelihood_run run = f->run;
    const kq_status status = T(kq_step)(f, p, u, s, z);
    f->last = before;
    f->run = run;
    return status;
}

KQ_KERNEL kq_status T(kq_fixed_predict)(T(kq_filter) *f, const T(kq_process) *p, const num *u,
                                         int n, int l, int options)
{
    if (KQ_MOSTLY(fixed_predict(f, p, u, n, l, options) == KQ_OK)) return KQ_OK;
    return T(kq_predict)(f, p, u);
}

KQ_KERNEL kq_status T(kq_fixed_update)(T(kq_filter) *f, const T(kq_sensor) *s, const num *z,
                                        int n, int m, int options)
{
    if (KQ_MOSTLY(fixed_update(f, s, z, n, m, options) == KQ_OK)) return KQ_OK;
    return options & KQ_FIXED_BARE ? update_bare(f, s, z) : T(kq_update)(f, s, z);
}

KQ_KERNEL kq_status T(kq_fixed_step)(T(kq_filter) *f, const T(kq_process) *p, const num *u,
                                      const T(kq_sensor) *s, const num *z, int n, int m, int l,
                                      int options)
{
    if (KQ_MOSTLY(fixed_step(f, p, u, s, z, n, m, l, options) == KQ_OK)) return KQ_OK;
    return options & KQ_FIXED_BARE ? step_bare(f, p, u, s, z) : T(kq_step)(f, p, u, s, z);
}

KQ_KERNEL kq_status T(kq_fixed_smooth_step)(T(kq_history) *h, const T(kq_process) *p,
                                             const T(kq_smooth_extras) *extras, int n, int options)
{
    if (fixed_smooth_step(h, p, extras, n, options) == KQ_OK) return KQ_OK;
    return T(kq_smooth_step)(h, p, extras);
}

/* The steady-state filter's (kalmanq/steady.h); options: KQ_FIXED_UPPER or 0 */
KQ_KERNEL kq_status T(kq_fixed_steady_step)(T(kq_steady) *st, const num *u, const num *z,
                                             int n, int m, int l, int options)
{
    if (fixed_steady_step(st, u, z, n, m, l, options) == KQ_OK) return KQ_OK;
    return T(kq_steady_step)(st, u, z);
}

#endif
