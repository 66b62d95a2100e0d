/* By the macros themselves: what they are to change is what they have. */
#include "tables.h"

#define FLOATING(T, TABLE, LEAN)                                                                   \
    void kq_process_as_table_##T(kq_process_##T *p)                                                \
    {                                                                                              \
        const kq_process_##T table =                                                               \
            KQ_PROCESS_TABLE(p->states, p->controls, p->transition, p->control, p->noise_root);    \
        p->plain = table.plain;                                                                    \
    }                                                                                              \
    void kq_sensor_as_table_##T(kq_sensor_##T *s, int is_lean)                                     \
    {                                                                                              \
        const kq_sensor_##T table = TABLE(s->states, s->components, s->measurement, s->noise);     \
        const kq_sensor_##T lean = LEAN(s->states, s->components, s->measurement, s->noise);       \
        s->plain = is_lean ? lean.plain : table.plain;                                             \
    }

FLOATING(f32, KQ_SENSOR_TABLE_F32, KQ_SENSOR_LEAN_TABLE_F32)
FLOATING(f64, KQ_SENSOR_TABLE_F64, KQ_SENSOR_LEAN_TABLE_F64)

void kq_process_as_table_q31(kq_process_q31 *p)
{
    const kq_process_q31 table = KQ_PROCESS_TABLE_Q31(p->states, p->controls, p->state_format, p->control_format,
                                                      p->transition, p->control, p->noise_root);
    p->plain = table.plain;
}

void kq_sensor_as_table_q31(kq_sensor_q31 *s, int is_lean)
{
    const kq_sensor_q31 table = KQ_SENSOR_TABLE_Q31(s->states, s->components, s->state_format, s->measurement_format,
                                                    s->measurement, s->noise);
    const kq_sensor_q31 lean = KQ_SENSOR_LEAN_TABLE_Q31(s->states, s->components, s->state_format,
                                                        s->measurement_format, s->measurement, s->noise);
    s->plain = is_lean ? lean.plain : table.plain;
}
