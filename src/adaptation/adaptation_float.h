/*
 * What adaptation has of its own in floating point: its memory, and a sensor with its noise scaled.
 * adaptation_q31.h is the twin.
 */
#ifndef KQ_SRC_ADAPTATION_ADAPTATION_FLOAT_H
#define KQ_SRC_ADAPTATION_ADAPTATION_FLOAT_H

#include <stddef.h>
#include <stdint.h>

#include "kalmanq/adaptation.h"
#include "kalmanq/process.h"
#include "kalmanq/sensor.h"
#include "kalmanq/size.h"
#include "kalmanq/status.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/root.h"
#include "../arithmetic/size.h"
#include "../arithmetic/triangle.h"
#include "../model/types.h"
#include "../filter/attached.h"

typedef T(kq_adaptation) adaptation;

kq_status T(kq_adaptation_assign)(adaptation *a, int n, int m, num *memory, size_t length)
{
    if (!a || !memory) return KQ_ERR_NULL;
    if (!size_is_valid(n) || !size_is_valid(m)) return KQ_ERR_SIZE;
    if (length < (size_t)ADAPTATION_LEN(n, m)) return KQ_ERR_MEMORY;
    *a = (adaptation){.attached = {&T(kq_adaptation_hooks)},
                      .states = (uint8_t)n,
                      .components = (uint8_t)m,
                      .length = (uint16_t)ADAPTATION_LEN(n, m),
                      .memory = memory};
    return KQ_OK;
}

static int adaptation_has_memory(const adaptation *a) { return a->memory != 0; }

/* At the end of the memory: the scaled sensor's R, and the root of the scaled process */
static num *process_root(const adaptation *a)
{
    return a->memory + a->length - KQ_PROCESS_LEN(a->states);
}

static num *sensor_covariance(const adaptation *a)
{
    return process_root(a) - a->components * a->components;
}

/* A process that is only memory yet */
static process process_to_scale(const adaptation *a)
{
    return (process){.states = a->states,
                     .length = (uint16_t)KQ_PROCESS_LEN(a->states),
                     .memory = process_root(a)};
}

static int models_agree(const process *p, const sensor *s)
{
    (void)p, (void)s;
    return 1;
}

static kq_status sensor_scale_check(const sensor *s, num r)
{
    const int m = s->components;
    for (int c = 0; c < m; c++) {
        const num noise = s->noise[s->covariance ? column(c) + c : c];
        if (!num_is_finite(r * noise)) return KQ_ERR_NOT_FINITE;
    }
    for (int k = 0; s->covariance && k < m * m; k++) {
        if (!num_is_finite(r * s->covariance[k])) return KQ_ERR_NOT_FINITE;
    }
    return KQ_OK;
}

/* What was no noise is none. */
static num scaled_variance(num variance, num r)
{
    return variance <= num_tiny || r * variance < num_tiny ? num_tiny : r * variance;
}

/* r D of U D U' */
static void set_scaled_sensor(adaptation *a, const sensor *s, num r, num *noise)
{
    const int m = s->components;
    a->scaled_sensor = *s;
    a->scaled_sensor.memory = noise;
    a->scaled_sensor.noise = noise;
    a->scaled_sensor.seal = 0;
    a->scaled_sensor.length = (uint8_t)KQ_SENSOR_LEN(m);
    if (!s->covariance) {
        for (int c = 0; c < m; c++) noise[c] = scaled_variance(s->noise[c], r);
        return;
    }
    copy(noise, s->noise, KQ_TRIANGLE(m));
    for (int c = 0; c < m; c++) {
        noise[column(c) + c] = scaled_variance(s->noise[column(c) + c], r);
    }
    num *R = sensor_covariance(a);
    for (int k = 0; k < m * m; k++) R[k] = r * s->covariance[k];
    a->scaled_sensor.covariance = R;
}

#endif
