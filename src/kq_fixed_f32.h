/*
 * kq_predict_f32, kq_update_f32, kq_step_f32 and kq_smooth_step_f32 for sizes that the compiler
 * knows: fixed_sizes.h says how they are used.  Arguments, results and errors are those of
 * kalmanq/filter.h and kalmanq/smoother.h, and
 *
 *   n, m, l   the filter's states, the sensor's components and the process's controls, constants
 *   options   KQ_UPPER, KQ_BARE or 0, a constant (KQ_BARE: for update and step)
 */
#ifndef KALMANQ_FIXED_F32_H
#define KALMANQ_FIXED_F32_H

#pragma GCC system_header

#include "fixed_sizes.h"

#include "types_f32.h"

#include "triangle.inc"

#include "process.inc"
#include "predict.inc"
#include "update.inc"

#include "fit_float.inc"
#include "sensor.inc"
#include "likelihood.inc"
#include "filter.inc"
#include "history.inc"

/* The unusual measurement and those that follow it: the library takes them, and what it keeps of the
   likelihood is joined.  A copy of a filter is left as one that is not ready. */
static void take_rest(filter *f, const reading *z, int c, int mode)
{
    if (f->states <= states_in_registers) {
        f->ready = 0;
        return;
    }
    const likelihood before = f->last;
    const likelihood_run run = f->run;
    kq_update_subset_f32(f, z->sensor, z->z, ~UINT32_C(0) << c);
    f->run = run;
    if (mode == MODE_BARE) f->last = before;
    else likelihood_join(&f->last, &before);
}

#include "take.inc"
#include "smooth_kernels.inc"
#include "steady.inc"
#include "fixed_sizes.inc"

/* What KQ_BARE leaves to the library leaves the likelihood as it was, too. */
KQ_NOINLINE static kq_status update_bare(filter *f, const sensor *s, const num *z)
{
    if (!f) return kq_update_f32(f, s, z);
    const likelihood before = f->last;
    const likelihood_run run = f->run;
    const kq_status status = kq_update_f32(f, s, z);
    f->last = before;
    f->run = run;
    return status;
}

KQ_NOINLINE static kq_status step_bare(filter *f, const process *p, const num *u, const sensor *s,
                                       const num *z)
{
    if (!f) return kq_step_f32(f, p, u, s, z);
    const likelihood before = f->last;
    const likelihood_run run = f->run;
    const kq_status status = kq_step_f32(f, p, u, s, z);
    f->last = before;
    f->run = run;
    return status;
}

KQ_INLINE kq_status kq_fixed_predict_f32(kq_filter_f32 *f, const kq_process_f32 *p, const float *u,
                                         int n, int l, int options)
{
    if (KQ_MOSTLY(fixed_predict(f, p, u, n, l, options) == KQ_OK)) return KQ_OK;
    return kq_predict_f32(f, p, u);
}

KQ_INLINE kq_status kq_fixed_update_f32(kq_filter_f32 *f, const kq_sensor_f32 *s, const float *z,
                                        int n, int m, int options)
{
    if (KQ_MOSTLY(fixed_update(f, s, z, n, m, options) == KQ_OK)) return KQ_OK;
    return options & KQ_BARE ? update_bare(f, s, z) : kq_update_f32(f, s, z);
}

KQ_INLINE kq_status kq_fixed_step_f32(kq_filter_f32 *f, const kq_process_f32 *p, const float *u,
                                      const kq_sensor_f32 *s, const float *z, int n, int m, int l,
                                      int options)
{
    if (KQ_MOSTLY(fixed_step(f, p, u, s, z, n, m, l, options) == KQ_OK)) return KQ_OK;
    return options & KQ_BARE ? step_bare(f, p, u, s, z) : kq_step_f32(f, p, u, s, z);
}

KQ_INLINE kq_status kq_fixed_smooth_step_f32(kq_history_f32 *h, const kq_process_f32 *p,
                                             const kq_smooth_extras_f32 *extras, int n, int options)
{
    if (fixed_smooth_step(h, p, extras, n, options) == KQ_OK) return KQ_OK;
    return kq_smooth_step_f32(h, p, extras);
}

/* The steady-state filter's (kalmanq/steady.h); options: KQ_UPPER or 0 */
KQ_INLINE kq_status kq_fixed_steady_step_f32(kq_steady_f32 *st, const float *u, const float *z,
                                             int n, int m, int l, int options)
{
    if (fixed_steady_step(st, u, z, n, m, l, options) == KQ_OK) return KQ_OK;
    return kq_steady_step_f32(st, u, z);
}

#endif
