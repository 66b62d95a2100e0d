/*
 * Are a process and a sensor what they were when the check was first called?  It keeps seals then, which an init or a
 * change clears.  Nothing is followed before the seal of the fields is seen whole.
 */
#ifndef KQ_SRC_MODEL_INTACT_H
#define KQ_SRC_MODEL_INTACT_H

#include "process.h"
#include "sensor.h"

KQ_COLD static uint8_t process_seal(const process *p)
{
    uint32_t seal = seal_join(process_addresses(p), p->states | (uint32_t)p->controls << 8 | (uint32_t)p->plain << 16);
    for (int i = 0; i < KQ_SIZE_MAX; i++) seal = seal_join(seal, p->first[i]);
    return seal_close(seal_join(seal, p->fingerprint));
}

/* A table may say less of A than init finds (`first` too small) and has no fingerprint; a scaled noise has
   another one. */
KQ_COLD static int transition_agrees(const process *p)
{
    process found = *p;
    process_set_transition(&found, p->transition);
    for (int i = 0; i < p->states; i++) {
        if (p->first[i] > found.first[i]) return 0;
    }
    if (p->fingerprint == 0 || p->fingerprint & process_scaled) return 1;
    return p->plain == found.plain && p->fingerprint == found.fingerprint;
}

KQ_COLD kq_status T(kq_process_check)(process *p)
{
    const kq_status status = process_check(p);
    if (status) return status;
    if (!size_is_valid(p->states) || p->controls > KQ_SIZE_MAX || !p->transition) return KQ_ERR_TABLE;
    const uint8_t seal = process_seal(p);
    if ((p->seal && p->seal != seal) || !transition_agrees(p)) return KQ_ERR_TABLE;
    p->seal = seal;
    return KQ_OK;
}

KQ_COLD static uint8_t sensor_seal(const sensor *s)
{
    uint32_t seal = seal_join(sensor_addresses(s), s->plain);
    for (int c = 0; c < KQ_SIZE_MAX; c++) seal = seal_join(seal, s->selects[c]);
    return seal_close(seal);
}

KQ_COLD static int selects_agree(const sensor *s)
{
    sensor found = *s;
    sensor_set_measurement(&found, s->measurement);
    for (int c = 0; c < s->components; c++) {
        if (s->selects[c] && s->selects[c] != found.selects[c]) return 0;
    }
    return 1;
}

KQ_COLD kq_status T(kq_sensor_check)(sensor *s)
{
    const kq_status status = sensor_check(s);
    if (status) return status;
    if (!size_is_valid(s->states) || !size_is_valid(s->components) || !s->measurement || !s->kind) return KQ_ERR_TABLE;
    const uint8_t seal = sensor_seal(s);
    if (s->seal && s->seal != seal) return KQ_ERR_TABLE;
    const int m = s->components;
    const uint8_t noise = seal_of(s->noise, sensor_is_correlated(s) ? KQ_TRIANGLE(m) : m);
    const uint8_t measurement = seal_of(s->measurement, m * s->states);
    if (s->seal && (s->noise_seal != noise || s->measurement_seal != measurement)) return KQ_ERR_TABLE;
    if (!selects_agree(s)) return KQ_ERR_TABLE;
    s->seal = seal;
    s->noise_seal = noise;
    s->measurement_seal = measurement;
    return KQ_OK;
}

#endif
