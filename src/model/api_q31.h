/* The public functions of processes and sensors in fixed point, made of tables. */
#ifndef KQ_SRC_MODEL_API_Q31_H
#define KQ_SRC_MODEL_API_Q31_H

#include "tables_q31.h"
#include "intact.h"

KQ_COLD kq_status T(kq_process_init)(process *p, const kq_process_table_q31 *table,
                                     kq_range_error_q31 *range_error)
{
    if (!p || !table) return KQ_ERR_NULL;
    if (table->states < 1 || table->states > KQ_SIZE_MAX) return KQ_ERR_SIZE;
    if (table->controls < 0 || table->controls > KQ_SIZE_MAX) return KQ_ERR_SIZE;
    const int n = (int)table->states, l = (int)table->controls;
    if (!table->state_format || !table->transition || !table->noise_root) return KQ_ERR_NULL;
    if (l && (!table->control_format || !table->control)) return KQ_ERR_NULL;
    kq_status status = formats_check(table->state_format, n);
    if (!status) status = formats_check(table->control_format, l);
    if (!status) status = root_check(table->noise_root, n);
    if (!status) status = transition_check(table->transition, table->control, n, l, range_error);
    if (status) return status;
    clear_bytes(p, sizeof *p);
    p->states = (uint8_t)n;
    p->controls = (uint8_t)l;
    p->state_format = table->state_format;
    p->control_format = table->control_format;
    p->control = l ? table->control : 0;
    p->noise_root = table->noise_root;
    process_set_transition(p, table->transition);
    say_all_fit(range_error);
    return KQ_OK;
}

KQ_COLD kq_status T(kq_process_change_transition)(process *p, const scaled *A, kq_range_error_q31 *range_error)
{
    kq_status status = process_check(p);
    if (status) return status;
    if (!A) return KQ_ERR_NULL;
    status = transition_check(A, p->control, p->states, p->controls, range_error);
    if (status == KQ_ERR_COEFFICIENT) name_row(A, p->states, range_error);
    if (status) return status;
    process_set_transition(p, A);
    say_all_fit(range_error);
    return KQ_OK;
}

KQ_COLD kq_status T(kq_sensor_init)(sensor *s, const kq_sensor_table_q31 *table,
                                    kq_range_error_q31 *range_error)
{
    const sensor_kind *kind =
        table && table->correlated ? &T(kq_sensor_correlated) : &T(kq_sensor_independent);
    return sensor_init_table(s, table, kind, range_error);
}

kq_status T(kq_sensor_init_diagonal)(sensor *s, const kq_sensor_table_q31 *table,
                                     kq_range_error_q31 *range_error)
{
    return sensor_init_diagonal(s, table, &T(kq_sensor_independent), range_error);
}

kq_status T(kq_sensor_init_lean)(sensor *s, const kq_sensor_table_q31 *table, kq_range_error_q31 *range_error)
{
    return sensor_init_diagonal(s, table, &T(kq_sensor_lean), range_error);
}

KQ_COLD kq_status T(kq_sensor_change_measurement)(sensor *s, const scaled *H, kq_range_error_q31 *range_error)
{
    kq_status status = sensor_check(s);
    if (status) return status;
    if (!H) return KQ_ERR_NULL;
    status = measurement_check(H, s->components, s->states, range_error);
    if (status == KQ_ERR_COEFFICIENT) return rows_check(H, s->components, s->states, KQ_MEASUREMENT, range_error);
    if (status) return status;
    sensor_set_measurement(s, H);
    say_all_fit(range_error);
    return KQ_OK;
}

#endif
