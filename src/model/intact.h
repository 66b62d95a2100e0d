/* Are a process and a sensor what their init has left?  Nothing is followed before the seal is seen whole. */
#ifndef KQ_SRC_MODEL_INTACT_H
#define KQ_SRC_MODEL_INTACT_H

#include "kalmanq/process.h"
#include "kalmanq/sensor.h"
#include "kalmanq/size.h"
#include "kalmanq/status.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/compiler.h"
#include "../arithmetic/size.h"
#include "process.h"
#include "seal.h"
#include "sensor.h"
#include "types.h"
#include "units.h"

/* A table may say less of its matrix than init finds: `first` too small, `selects` 0. */
KQ_COLD static int first_agrees(const process *p, const process *found)
{
    for (int i = 0; i < p->states; i++) {
        if (p->seal ? p->first[i] != found->first[i] : p->first[i] > found->first[i]) return 0;
    }
    return !p->seal || (p->plain == found->plain && p->fingerprint == found->fingerprint);
}

KQ_COLD kq_status T(kq_process_check)(const process *p)
{
    const kq_status status = process_check(p);
    if (status) return status;
    if (!size_is_valid(p->states) || p->controls > KQ_SIZE_MAX || !p->transition) return KQ_ERR_TABLE;
    if (p->seal && p->seal != process_seal(p)) return KQ_ERR_TABLE;
    process found = *p;
    process_set_transition(&found, p->transition);
    return first_agrees(p, &found) ? KQ_OK : KQ_ERR_TABLE;
}

KQ_COLD static int selects_agree(const sensor *s, const sensor *found)
{
    for (int c = 0; c < s->components; c++) {
        if (s->selects[c] != found->selects[c] && (s->seal || s->selects[c])) return 0;
    }
    return !s->seal || (s->plain == found->plain && s->noise_seal == found->noise_seal &&
                        s->measurement_seal == found->measurement_seal);
}

KQ_COLD kq_status T(kq_sensor_check)(const sensor *s)
{
    const kq_status status = sensor_check(s);
    if (status) return status;
    if (!size_is_valid(s->states) || !size_is_valid(s->components)) return KQ_ERR_TABLE;
    if (!s->measurement || !s->kind) return KQ_ERR_TABLE;
    if (s->seal && s->seal != sensor_seal(s)) return KQ_ERR_TABLE;
    sensor found = *s;
    sensor_set_measurement(&found, s->measurement);
    sensor_set_plain(&found);
    return selects_agree(s, &found) ? KQ_OK : KQ_ERR_TABLE;
}

#endif
