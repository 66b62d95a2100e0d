/*
 * kalmanq in double: steady states.  A file of its own, so that the code of the filter is compiled
 * without regard to it; what it needs of that is compiled here again.
 */
#include "arithmetic/has_double.h"

#if KQ_HAS_DOUBLE
#include "arithmetic/f64.h"

#include "arithmetic/root.h"

#include "model/process.h"
#include "model/advance.h"
#include "filter/rotate.h"

#include "model/units.h"
#include "model/sensor.h"
#include "filter/likelihood.h"
#include "filter/filter.h"

#include "model/factor.h"
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
#include "steady/riccati_float.h"
#include "steady/kernel.h"
#include "steady/steady.h"
#include "steady/schedule.h"
#include "steady/smoother.h"

/* The switch moves a filter as a caller does. */


#include "steady/switch.h"

kq_status kq_steady_solve_f64(const kq_process_f64 *p, const kq_sensor_f64 *s, double *memory,
                              size_t length, const kq_steady_solution_f64 *out)
{
    return steady_solve(p, s, memory, length, out);
}

kq_status kq_steady_schedule_f64(const kq_filter_f64 *f, const kq_process_f64 *p,
                                 const kq_sensor_f64 *s, double *memory, size_t length, int bits,
                                 double *gains, size_t steps, size_t *used)
{
    return steady_schedule(f, p, s, memory, length, bits, gains, steps, used);
}

kq_status kq_steady_assign_f64(kq_steady_f64 *st, int n, int m, double *memory, size_t length)
{
    return steady_assign(st, n, m, memory, length);
}

kq_status kq_steady_init_f64(kq_steady_f64 *st, const kq_process_f64 *p, const kq_sensor_f64 *s,
                             const double *x0, const double *gains, size_t count)
{
    return steady_init(st, p, s, x0, gains, count);
}

kq_status kq_steady_predict_f64(kq_steady_f64 *st, const double *u)
{
    return steady_predict(st, u);
}

kq_status kq_steady_update_f64(kq_steady_f64 *st, const double *z) { return steady_update(st, z); }

kq_status kq_steady_step_f64(kq_steady_f64 *st, const double *u, const double *z)
{
    return steady_step(st, u, z);
}

double kq_steady_mean_f64(const kq_steady_f64 *st, int i)
{
    return steady_has(st, i) ? steady_get(st->memory, st->states, i) : num_nan();
}

kq_status kq_steady_innovation_f64(const kq_steady_f64 *st, const double *z, double *e)
{
    return steady_innovation(st, z, e);
}

kq_status kq_steady_smoother_make_f64(const kq_filter_f64 *f, const kq_process_f64 *p,
                                      const kq_sensor_f64 *s, double *memory, size_t length,
                                      double *root, double *back, double *drive)
{
    return steady_smoother_make(f, p, s, memory, length, root, back, drive);
}

kq_status kq_steady_smooth_f64(const kq_steady_smoother_f64 *c, double *x, const double *e,
                               size_t steps)
{
    return steady_smooth(c, x, e, steps);
}

kq_status kq_switch_assign_f64(kq_switch_f64 *w, int n, int m, double *memory, size_t length,
                               double *gain)
{
    return switch_assign(w, n, m, memory, length, gain);
}

kq_status kq_switch_init_f64(kq_switch_f64 *w, int bits) { return switch_init(w, bits); }

kq_status kq_switch_step_f64(kq_switch_f64 *w, kq_filter_f64 *f, const kq_process_f64 *p,
                             const double *u, const kq_sensor_f64 *s, const double *z)
{
    return switch_step(w, f, p, u, s, z);
}

int kq_switch_settled_f64(const kq_switch_f64 *w) { return switch_is_settled(w); }

kq_status kq_switch_release_f64(kq_switch_f64 *w) { return switch_release(w); }

#endif
