/*
 * kalmanq in float: least squares and consistency, and their public names.  A file of its own: who
 * does not call them has the code that there was without them.
 */
/* Of these files a part is used. */
#include "arithmetic/f32.h"

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

kq_status kq_fade_f32(kq_filter_f32 *f, float lambda) { return filter_fade(f, lambda); }

kq_status kq_least_squares_init_f32(kq_least_squares_f32 *q, kq_filter_f32 *f, float lambda)
{
    return least_squares_init(q, f, lambda);
}

kq_status kq_least_squares_add_f32(kq_least_squares_f32 *q, const float *h, float z, float r)
{
    return least_squares_add(q, h, z, r);
}

kq_status kq_least_squares_add_all_f32(kq_least_squares_f32 *q, const float *H, const float *z,
                                       const float *r, int count)
{
    return least_squares_add_all(q, H, z, r, count);
}

float kq_least_squares_residual_f32(const kq_least_squares_f32 *q)
{
    return least_squares_score(q, q ? &q->residual : 0);
}

float kq_least_squares_weight_f32(const kq_least_squares_f32 *q)
{
    return least_squares_score(q, q ? &q->weight : 0);
}

kq_status kq_consistency_assign_f32(kq_consistency_f32 *c, int m, int window, float *memory,
                                    size_t length)
{
    return consistency_assign(c, m, window, memory, length);
}

kq_status kq_consistency_clear_f32(kq_consistency_f32 *c) { return consistency_clear(c); }

kq_status kq_consistency_watch_f32(kq_consistency_f32 *c, const kq_filter_f32 *f,
                                   const kq_sensor_f32 *s, const float *z, uint32_t present)
{
    return consistency_watch(c, f, s, z, present);
}

kq_status kq_consistency_record_f32(kq_consistency_f32 *c, const kq_filter_f32 *f)
{
    return consistency_record(c, f);
}

int kq_consistency_count_f32(const kq_consistency_f32 *c) { return c ? c->count : 0; }

kq_status kq_consistency_nis_f32(const kq_consistency_f32 *c, float q, float *nis, float *low,
                                 float *high)
{
    return consistency_nis(c, q, nis, low, high);
}

kq_status kq_consistency_innovation_f32(const kq_consistency_f32 *c, int component, float q,
                                        float *mean, float *mean_bound, float *correlation,
                                        float *correlation_bound)
{
    return consistency_innovation(c, component, q, mean, mean_bound, correlation,
                                  correlation_bound);
}
