/*
 * kalmanq in fixed point: steady states.  A file of its own, so that the code of the filter is
 * compiled without regard to it; what it needs of that is compiled here again.
 */
#include "arithmetic/q31.h"

#include "arithmetic/root.h"

#include "model/process.h"
#include "model/advance.h"
#include "filter/rotate.h"

#include "model/units.h"
#include "model/sensor.h"
#include "filter/likelihood.h"
#include "filter/filter.h"

#include "model/definitions.h"
#include "filter/prior.h"

#include "filter/checks.h"
#include "filter/readings.h"
#include "filter/tape.h"

#include "filter/match.h"
#include "filter/sharp.h"
#include "filter/step.h"
#include "filter/gain.h"
#include "smoother/whitened.h"
#include "smoother/smoother.h"

#include "steady/checks.h"
#include "steady/kernel.h"
#include "steady/steady.h"
#include "steady/schedule.h"
#include "steady/smoother.h"

/* The switch moves a filter as a caller does. */


#include "steady/switch.h"

kq_status kq_steady_schedule_q31(const kq_filter_q31 *f, const kq_process_q31 *p,
                                 const kq_sensor_q31 *s, int32_t *memory, size_t length, int bits,
                                 kq_scaled_q31 *gains, size_t steps, size_t *used)
{
    return steady_schedule(f, p, s, memory, length, bits, gains, steps, used);
}

kq_status kq_steady_assign_q31(kq_steady_q31 *st, int n, int m, int32_t *memory, size_t length)
{
    return steady_assign(st, n, m, memory, length);
}

kq_status kq_steady_init_q31(kq_steady_q31 *st, const kq_process_q31 *p, const kq_sensor_q31 *s,
                             const int32_t *x0, const kq_scaled_q31 *gains, size_t count)
{
    return steady_init(st, p, s, x0, gains, count);
}

kq_status kq_steady_predict_q31(kq_steady_q31 *st, const int32_t *u)
{
    return steady_predict(st, u);
}

kq_status kq_steady_update_q31(kq_steady_q31 *st, const int32_t *z) { return steady_update(st, z); }

kq_status kq_steady_step_q31(kq_steady_q31 *st, const int32_t *u, const int32_t *z)
{
    return steady_step(st, u, z);
}

int32_t kq_steady_mean_q31(const kq_steady_q31 *st, int i)
{
    return steady_has(st, i) ? steady_get(st->memory, st->states, i) : num_nan();
}

int32_t kq_steady_mean_low_q31(const kq_steady_q31 *st, int i)
{
    return steady_has(st, i) ? mean_low(st->memory, st->states, i) : num_nan();
}

unsigned kq_steady_events_q31(const kq_steady_q31 *st) { return st ? st->events : 0; }

void kq_steady_events_clear_q31(kq_steady_q31 *st)
{
    if (st) st->events = 0;
}

kq_status kq_steady_innovation_q31(const kq_steady_q31 *st, const int32_t *z, int32_t *e)
{
    return steady_innovation(st, z, e);
}

kq_status kq_steady_smoother_make_q31(const kq_filter_q31 *f, const kq_process_q31 *p,
                                      const kq_sensor_q31 *s, int32_t *memory, size_t length,
                                      int32_t *root, kq_scaled_q31 *back, kq_scaled_q31 *drive)
{
    return steady_smoother_make(f, p, s, memory, length, root, back, drive);
}

kq_status kq_steady_smooth_q31(const kq_steady_smoother_q31 *c, int32_t *x, const int32_t *e,
                               size_t steps)
{
    return steady_smooth(c, x, e, steps);
}

kq_status kq_switch_assign_q31(kq_switch_q31 *w, int n, int m, int32_t *memory, size_t length,
                               kq_scaled_q31 *gain)
{
    return switch_assign(w, n, m, memory, length, gain);
}

kq_status kq_switch_init_q31(kq_switch_q31 *w, int bits) { return switch_init(w, bits); }

kq_status kq_switch_step_q31(kq_switch_q31 *w, kq_filter_q31 *f, const kq_process_q31 *p,
                             const int32_t *u, const kq_sensor_q31 *s, const int32_t *z)
{
    return switch_step(w, f, p, u, s, z);
}

int kq_switch_settled_q31(const kq_switch_q31 *w) { return switch_is_settled(w); }

kq_status kq_switch_release_q31(kq_switch_q31 *w) { return switch_release(w); }
