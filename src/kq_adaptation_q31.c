/*
 * kalmanq in fixed point: the adaptation of the noise scales, and its public names.  A file of its
 * own: who does not call it has the code that there was without it.
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

/* The steps are the library's. */


#include "robust/parameters.h"
#include "adaptation/scaled.h"
#include "adaptation/adaptation.h"

kq_status kq_adaptation_assign_q31(kq_adaptation_q31 *a, int n, int m, kq_scaled_q31 *memory,
                                   size_t length, int32_t *root)
{
    return adaptation_assign(a, n, m, memory, length, root);
}

kq_status kq_adaptation_init_q31(kq_adaptation_q31 *a, const kq_process_q31 *p,
                                 const kq_sensor_q31 *s, const kq_adaptation_rule_q31 *rule)
{
    return adaptation_init(a, p, s, rule);
}

kq_status kq_adaptation_restart_q31(kq_adaptation_q31 *a) { return adaptation_restart(a); }

kq_status kq_adaptation_predict_q31(kq_adaptation_q31 *a, kq_filter_q31 *f, const int32_t *u)
{
    return adaptation_predict(a, f, u);
}

kq_status kq_adaptation_update_q31(kq_adaptation_q31 *a, kq_filter_q31 *f, const int32_t *z,
                                   uint32_t present)
{
    return adaptation_update(a, f, z, present);
}

kq_scaled_q31 kq_adaptation_process_scale_q31(const kq_adaptation_q31 *a)
{
    return adaptation_check(a) ? (kq_scaled_q31){0, 0} : a->process_scale;
}

kq_scaled_q31 kq_adaptation_sensor_scale_q31(const kq_adaptation_q31 *a)
{
    return adaptation_check(a) ? (kq_scaled_q31){0, 0} : a->sensor_scale;
}

const kq_process_q31 *kq_adaptation_process_q31(kq_adaptation_q31 *a)
{
    return adaptation_process(a);
}

const kq_sensor_q31 *kq_adaptation_sensor_q31(kq_adaptation_q31 *a) { return adaptation_sensor(a); }
