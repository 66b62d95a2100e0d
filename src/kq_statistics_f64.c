/*
 * kalmanq in double: least squares and consistency, and their public names.  A file of its own: who
 * does not call them has the code that there was without them.
 */
#include "arithmetic/has_double.h"

#if KQ_HAS_DOUBLE
/* Of these files a part is used. */
#include "arithmetic/f64.h"

#include "arithmetic/root.h"

#include "model/process.h"

#include "model/units.h"
#include "model/sensor.h"
#include "filter/likelihood.h"
#include "filter/filter.h"

#include "model/advance.h"
#include "model/factor.h"
#include "model/definitions.h"
#include "filter/prior.h"
#include "filter/checks.h"
#include "filter/readings.h"

/* The update is the library's. */

#include "statistics/statistics.h"
#include "statistics/least_squares.h"
#include "statistics/consistency.h"

kq_status kq_fade_f64(kq_filter_f64 *f, double lambda) { return filter_fade(f, lambda); }

kq_status kq_least_squares_init_f64(kq_least_squares_f64 *q, kq_filter_f64 *f, double lambda)
{
    return least_squares_init(q, f, lambda);
}

kq_status kq_least_squares_add_f64(kq_least_squares_f64 *q, const double *h, double z, double r)
{
    return least_squares_add(q, h, z, r);
}

kq_status kq_least_squares_add_all_f64(kq_least_squares_f64 *q, const double *H, const double *z,
                                       const double *r, int count)
{
    return least_squares_add_all(q, H, z, r, count);
}

double kq_least_squares_residual_f64(const kq_least_squares_f64 *q)
{
    return least_squares_score(q, q ? &q->residual : 0);
}

double kq_least_squares_weight_f64(const kq_least_squares_f64 *q)
{
    return least_squares_score(q, q ? &q->weight : 0);
}

kq_status kq_consistency_assign_f64(kq_consistency_f64 *c, int m, int window, double *memory,
                                    size_t length)
{
    return consistency_assign(c, m, window, memory, length);
}

kq_status kq_consistency_clear_f64(kq_consistency_f64 *c) { return consistency_clear(c); }

kq_status kq_consistency_watch_f64(kq_consistency_f64 *c, const kq_filter_f64 *f,
                                   const kq_sensor_f64 *s, const double *z, uint32_t present)
{
    return consistency_watch(c, f, s, z, present);
}

kq_status kq_consistency_record_f64(kq_consistency_f64 *c, const kq_filter_f64 *f)
{
    return consistency_record(c, f);
}

int kq_consistency_count_f64(const kq_consistency_f64 *c) { return c ? c->count : 0; }

kq_status kq_consistency_nis_f64(const kq_consistency_f64 *c, double q, double *nis, double *low,
                                 double *high)
{
    return consistency_nis(c, q, nis, low, high);
}

kq_status kq_consistency_innovation_f64(const kq_consistency_f64 *c, int component, double q,
                                        double *mean, double *mean_bound, double *correlation,
                                        double *correlation_bound)
{
    return consistency_innovation(c, component, q, mean, mean_bound, correlation,
                                  correlation_bound);
}

#endif
