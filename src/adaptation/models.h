/* The adaptation's object: its memory, what its models and its rule may be, and the models with their noises scaled. */
#ifndef KQ_SRC_ADAPTATION_MODELS_H
#define KQ_SRC_ADAPTATION_MODELS_H

#include "../robust/robust.h"
#if KQ_FLOATING
#include "adaptation_float.h"
#else
#include "adaptation_q31.h"
#endif

typedef T(kq_adaptation_rule) adaptation_rule;

/* What the scales as given are worth, as information; and how far nu and its slope count. */
enum { WORTH = 4, MOST = 4 };

/* The memory: D = dP / d log q, n x n; d = dx / d log q; then, of an update's scalar measurements
   as they are taken, k = P h / sqrt(s), m x n, and nu = e / sqrt(s); the noise of the scaled
   sensor, as in the sensor that was given. */
static scaled *covariance_slope(const adaptation *a) { return a->memory; }
static scaled *mean_slope(const adaptation *a) { return a->memory + a->states * a->states; }
static scaled *scalar_gains(const adaptation *a) { return mean_slope(a) + a->states; }

static scaled *scalar_units(const adaptation *a)
{
    return scalar_gains(a) + a->components * a->states;
}

static scaled *sensor_noise(const adaptation *a) { return scalar_units(a) + a->components; }

/* ------------------------------------------------------------------ checks */

static kq_status limits_check(scaled least, scaled most)
{
    kq_status status = parameter_check(least);
    if (!status) status = parameter_check(most);
    if (status) return status;
    const int holds_1 = !scaled_is_less(scaled_one, least) && !scaled_is_less(most, scaled_one);
    return holds_1 ? KQ_OK : KQ_ERR_RANGE;
}

static kq_status rule_check(const adaptation_rule *rule)
{
    const int scales = (int)rule->scales;
    if (rule->memory < KQ_ADAPTATION_MEMORY_MIN) return KQ_ERR_SIZE;
    if (rule->memory > KQ_ADAPTATION_MEMORY_MAX) return KQ_ERR_SIZE;
    if (scales < KQ_ADAPT_BOTH || scales > KQ_ADAPT_SENSOR) return KQ_ERR_RANGE;
    kq_status status = parameter_check(rule->step);
    if (status) return status;
    if (scaled_is_less(scaled_one, rule->step)) return KQ_ERR_RANGE;
    status = limits_check(rule->process_least, rule->process_most);
    return status ? status : limits_check(rule->sensor_least, rule->sensor_most);
}

static kq_status process_at_scale(const adaptation *a, const process *p, scaled q)
{
    const kq_status status = process_check(p);
    if (status) return status;
    if (p->states != a->states) return KQ_ERR_MISMATCH;
    const process target = process_to_scale(a);
    return scaled_noise_check(&target, p, process_root(a), scaled_root(q));
}

static kq_status sensor_at_scale(const adaptation *a, const sensor *s, scaled r)
{
    const kq_status status = sensor_check(s);
    if (status) return status;
    if (s->states != a->states || s->components != a->components) return KQ_ERR_MISMATCH;
    return sensor_scale_check(s, r);
}

static kq_status models_check(const adaptation *a, const process *p, const sensor *s,
                              const adaptation_rule *rule)
{
    kq_status status = process_at_scale(a, p, rule->process_least);
    if (!status) status = process_at_scale(a, p, rule->process_most);
    if (!status) status = sensor_at_scale(a, s, rule->sensor_least);
    if (!status) status = sensor_at_scale(a, s, rule->sensor_most);
    if (status) return status;
    return models_agree(p, s) ? KQ_OK : KQ_ERR_MISMATCH;
}

static kq_status adaptation_check(const adaptation *a)
{
    if (!a) return KQ_ERR_NULL;
    return a->process ? KQ_OK : KQ_ERR_NOT_READY;
}

/* ------------------------------------------------------------------ the scaled models */

static void begin_anew(adaptation *a)
{
    const scaled zero = scaled_zero();
    const int n = a->states;
    for (int k = 0; k < n * n + n; k++) a->memory[k] = zero; /* D, d */
    a->waiting = (uint8_t)n;
}

kq_status T(kq_adaptation_init)(adaptation *a, const process *p, const sensor *s,
                                const adaptation_rule *rule)
{
    const scaled zero = scaled_zero();
    if (!a || !p || !s || !rule) return KQ_ERR_NULL;
    if (!size_is_valid(a->states) || !size_is_valid(a->components)) return KQ_ERR_SIZE;
    if (!adaptation_has_memory(a)) return KQ_ERR_MEMORY;
    if ((int)a->length < ADAPTATION_LEN(a->states, a->components)) return KQ_ERR_MEMORY;
    kq_status status = rule_check(rule);
    if (!status) status = models_check(a, p, s, rule);
    if (status) return status;
    a->process = p;
    a->sensor = s;
    a->rule = *rule;
    a->process_scale = scaled_one;
    a->sensor_scale = scaled_one;
    for (int k = 0; k < 3; k++) a->information[k] = zero;
    a->scaled_process = process_to_scale(a);
    begin_anew(a);
    return KQ_OK;
}

static void scale_process(adaptation *a)
{
    set_scaled_noise(&a->scaled_process, a->process, process_root(a),
                     scaled_root(a->process_scale));
}

static void scale_sensor(adaptation *a)
{
    set_scaled_sensor(a, a->sensor, a->sensor_scale, sensor_noise(a));
    if (sensor_is_correlated(a->sensor)) return;
    /* What teaches is taken whole: a lean sensor leaves what is beyond its stages. */
    a->scaled_sensor.kind = &T(kq_sensor_independent);
}

const process *T(kq_adaptation_process)(adaptation *a)
{
    if (adaptation_check(a) || process_at_scale(a, a->process, a->process_scale)) return 0;
    scale_process(a);
    return &a->scaled_process;
}

const sensor *T(kq_adaptation_sensor)(adaptation *a)
{
    if (adaptation_check(a) || sensor_at_scale(a, a->sensor, a->sensor_scale)) return 0;
    scale_sensor(a);
    return &a->scaled_sensor;
}

#endif
