/* The inits of sensors that take innovations, in fixed point. */
#ifndef KQ_SRC_LINEARISED_SENSOR_Q31_H
#define KQ_SRC_LINEARISED_SENSOR_Q31_H

#include "kalmanq/extended.h"
#include "kalmanq/sensor.h"
#include "kalmanq/status.h"

#include "../arithmetic/q31.h"
#include "../arithmetic/compiler.h"
#include "../model/sensor.h"
#include "../model/types.h"
#include "../model/units.h"
#include "innovation.h"

KQ_COLD kq_status T(kq_sensor_init_extended)(sensor *s, const kq_sensor_table_q31 *table, kq_range_error_q31 *range_error)
{
    const kq_status status = T(kq_sensor_init)(s, table, range_error);
    if (status) return status;
    return sensor_extend(s, sensor_is_correlated(s) ? &T(kq_sensor_correlated_extended) : &independent_extended, KQ_OK);
}

KQ_COLD kq_status T(kq_sensor_init_diagonal_extended)(sensor *s, const kq_sensor_table_q31 *table, kq_range_error_q31 *range_error)
{
    return sensor_extend(s, &independent_extended, T(kq_sensor_init_diagonal)(s, table, range_error));
}

KQ_COLD kq_status T(kq_sensor_init_lean_extended)(sensor *s, const kq_sensor_table_q31 *table, kq_range_error_q31 *range_error)
{
    return sensor_extend(s, &lean_extended, T(kq_sensor_init_lean)(s, table, range_error));
}

#endif
