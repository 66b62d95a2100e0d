/*
 * kalmanq in float: the adaptation of the noise scales, and its public names.  A file of its own:
 * who does not call it has the code that there was without it.
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

/* The steps are the library's. */


#include "robust/parameters.h"
#include "adaptation/scaled.h"
#include "adaptation/adaptation.h"

kq_status kq_adaptation_assign_f32(kq_adaptation_f32 *a, int n, int m, float *memory, size_t length)
{
    return adaptation_assign(a, n, m, memory, length);
}

kq_status kq_adaptation_init_f32(kq_adaptation_f32 *a, const kq_process_f32 *p,
                                 const kq_sensor_f32 *s, const kq_adaptation_rule_f32 *rule)
{
    return adaptation_init(a, p, s, rule);
}

kq_status kq_adaptation_restart_f32(kq_adaptation_f32 *a) { return adaptation_restart(a); }

kq_status kq_adaptation_predict_f32(kq_adaptation_f32 *a, kq_filter_f32 *f, const float *u)
{
    return adaptation_predict(a, f, u);
}

kq_status kq_adaptation_update_f32(kq_adaptation_f32 *a, kq_filter_f32 *f, const float *z,
                                   uint32_t present)
{
    return adaptation_update(a, f, z, present);
}

float kq_adaptation_process_scale_f32(const kq_adaptation_f32 *a)
{
    return adaptation_check(a) ? num_nan() : a->process_scale;
}

float kq_adaptation_sensor_scale_f32(const kq_adaptation_f32 *a)
{
    return adaptation_check(a) ? num_nan() : a->sensor_scale;
}

const kq_process_f32 *kq_adaptation_process_f32(kq_adaptation_f32 *a)
{
    return adaptation_process(a);
}

const kq_sensor_f32 *kq_adaptation_sensor_f32(kq_adaptation_f32 *a) { return adaptation_sensor(a); }
