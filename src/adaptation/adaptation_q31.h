/*
 * What adaptation has of its own in fixed point: its memory, and a sensor with its noise scaled.
 * adaptation_float.h is the twin.
 */
#ifndef KQ_SRC_ADAPTATION_ADAPTATION_Q31_H
#define KQ_SRC_ADAPTATION_ADAPTATION_Q31_H

#include <stddef.h>
#include <stdint.h>

#include "kalmanq/adaptation.h"
#include "kalmanq/fixed_point.h"
#include "kalmanq/size.h"
#include "kalmanq/status.h"

#include "../arithmetic/q31.h"
#include "../arithmetic/scaled.h"
#include "../arithmetic/size.h"
#include "../arithmetic/triangle.h"
#include "../model/types.h"
#include "../model/units.h"
#include "../filter/attached.h"

typedef T(kq_adaptation) adaptation;

kq_status T(kq_adaptation_assign)(adaptation *a, int n, int m, scaled *memory, size_t length,
                                  num *root)
{
    if (!a || !memory || !root) return KQ_ERR_NULL;
    if (!size_is_valid(n) || !size_is_valid(m)) return KQ_ERR_SIZE;
    if (length < (size_t)ADAPTATION_LEN(n, m)) return KQ_ERR_MEMORY;
    *a = (adaptation){.attached = {&T(kq_adaptation_hooks)},
                      .states = (uint8_t)n,
                      .components = (uint8_t)m,
                      .length = (uint16_t)ADAPTATION_LEN(n, m),
                      .memory = memory,
                      .root = root};
    return KQ_OK;
}

static int adaptation_has_memory(const adaptation *a) { return a->memory && a->root; }

static num *process_root(const adaptation *a) { return a->root; }

static process process_to_scale(const adaptation *a) { return (process){.states = a->states}; }

static int models_agree(const process *p, const sensor *s)
{
    return formats_agree(p->state_format, s->state_format, p->states);
}

/* r D of U D U': do the exponents stay within those of a table? */
static kq_status sensor_scale_check(const sensor *s, scaled r)
{
    const int32_t most = KQ_EXPONENT_MAX_Q31;
    for (int c = 0; c < s->components; c++) {
        const scaled noise = scaled_times(s->noise[s->correlated ? column(c) + c : c], r);
        if (noise.exponent > most || noise.exponent < -most) return KQ_ERR_COEFFICIENT;
    }
    return KQ_OK;
}

static void set_scaled_sensor(adaptation *a, const sensor *s, scaled r, scaled *noise)
{
    const int m = s->components, count = s->correlated ? KQ_TRIANGLE(m) : m;
    a->scaled_sensor = *s;
    a->scaled_sensor.noise = noise;
    a->scaled_sensor.seal = 0;
    for (int k = 0; k < count; k++) noise[k] = s->noise[k];
    for (int c = 0; c < m; c++) {
        scaled *variance = noise + (s->correlated ? column(c) + c : c);
        *variance = scaled_times(*variance, r);
    }
}

#endif
