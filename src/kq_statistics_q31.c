/*
 * kalmanq in fixed point: least squares and consistency, and their public names.  A file of its
 * own: who does not call them has the code that there was without them.
 */
/* Of these files a part is used. */
#include "arithmetic/q31.h"

#include "arithmetic/root.h"

#include "model/process.h"

#include "model/units.h"
#include "model/sensor.h"
#include "filter/likelihood.h"
#include "filter/filter.h"
#include "model/definitions.h"
#include "filter/prior.h"
#include "filter/checks.h"
#include "filter/readings.h"

/* The update is the library's. */

#include "statistics/statistics.h"
#include "statistics/least_squares.h"
#include "statistics/consistency.h"

kq_status kq_fade_q31(kq_filter_q31 *f, kq_scaled_q31 lambda) { return filter_fade(f, lambda); }

kq_status kq_least_squares_init_q31(kq_least_squares_q31 *q, kq_filter_q31 *f, kq_scaled_q31 lambda,
                                    const kq_format_q31 *measurement_format)
{
    if (!measurement_format) return KQ_ERR_NULL;
    kq_status status = formats_check(measurement_format, 1);
    if (!status) status = least_squares_init(q, f, lambda);
    if (!status) q->measurement_format = measurement_format;
    return status;
}

kq_status kq_least_squares_add_q31(kq_least_squares_q31 *q, const kq_scaled_q31 *h, int32_t z,
                                   kq_scaled_q31 r)
{
    return least_squares_add(q, h, z, r);
}

kq_status kq_least_squares_add_all_q31(kq_least_squares_q31 *q, const kq_scaled_q31 *H,
                                       const int32_t *z, const kq_scaled_q31 *r, int count)
{
    return least_squares_add_all(q, H, z, r, count);
}

int64_t kq_least_squares_residual_q31(const kq_least_squares_q31 *q)
{
    return least_squares_score(q, q ? &q->residual : 0);
}

int64_t kq_least_squares_weight_q31(const kq_least_squares_q31 *q)
{
    return least_squares_score(q, q ? &q->weight : 0);
}

kq_status kq_consistency_assign_q31(kq_consistency_q31 *c, int m, int window, int32_t *memory,
                                    size_t length)
{
    return consistency_assign(c, m, window, memory, length);
}

kq_status kq_consistency_clear_q31(kq_consistency_q31 *c) { return consistency_clear(c); }

kq_status kq_consistency_watch_q31(kq_consistency_q31 *c, const kq_filter_q31 *f,
                                   const kq_sensor_q31 *s, const int32_t *z, uint32_t present)
{
    return consistency_watch(c, f, s, z, present);
}

kq_status kq_consistency_record_q31(kq_consistency_q31 *c, const kq_filter_q31 *f)
{
    return consistency_record(c, f);
}

int kq_consistency_count_q31(const kq_consistency_q31 *c) { return c ? c->count : 0; }

kq_status kq_consistency_nis_q31(const kq_consistency_q31 *c, int64_t q, int64_t *nis, int64_t *low,
                                 int64_t *high)
{
    return consistency_nis(c, q, nis, low, high);
}

kq_status kq_consistency_innovation_q31(const kq_consistency_q31 *c, int component, int64_t q,
                                        int64_t *mean, int64_t *mean_bound, int64_t *correlation,
                                        int64_t *correlation_bound)
{
    return consistency_innovation(c, component, q, mean, mean_bound, correlation,
                                  correlation_bound);
}
