/*
 * kalmanq in double: the adaptation of the noise scales, and its public names.  A file of its own:
 * who does not call it has the code that there was without it.
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

/* The steps are the library's. */


#include "robust/parameters.h"
#include "adaptation/scaled.h"
#include "adaptation/adaptation.h"

kq_status kq_adaptation_assign_f64(kq_adaptation_f64 *a, int n, int m, double *memory,
                                   size_t length)
{
    return adaptation_assign(a, n, m, memory, length);
}

kq_status kq_adaptation_init_f64(kq_adaptation_f64 *a, const kq_process_f64 *p,
                                 const kq_sensor_f64 *s, const kq_adaptation_rule_f64 *rule)
{
    return adaptation_init(a, p, s, rule);
}

kq_status kq_adaptation_restart_f64(kq_adaptation_f64 *a) { return adaptation_restart(a); }

kq_status kq_adaptation_predict_f64(kq_adaptation_f64 *a, kq_filter_f64 *f, const double *u)
{
    return adaptation_predict(a, f, u);
}

kq_status kq_adaptation_update_f64(kq_adaptation_f64 *a, kq_filter_f64 *f, const double *z,
                                   uint32_t present)
{
    return adaptation_update(a, f, z, present);
}

double kq_adaptation_process_scale_f64(const kq_adaptation_f64 *a)
{
    return adaptation_check(a) ? num_nan() : a->process_scale;
}

double kq_adaptation_sensor_scale_f64(const kq_adaptation_f64 *a)
{
    return adaptation_check(a) ? num_nan() : a->sensor_scale;
}

const kq_process_f64 *kq_adaptation_process_f64(kq_adaptation_f64 *a)
{
    return adaptation_process(a);
}

const kq_sensor_f64 *kq_adaptation_sensor_f64(kq_adaptation_f64 *a) { return adaptation_sensor(a); }

#endif
