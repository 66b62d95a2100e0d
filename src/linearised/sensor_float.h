/* The inits of sensors that take innovations, in floating point. */
#ifndef KQ_SRC_LINEARISED_SENSOR_FLOAT_H
#define KQ_SRC_LINEARISED_SENSOR_FLOAT_H

#include "kalmanq/extended.h"
#include "kalmanq/sensor.h"
#include "kalmanq/status.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/compiler.h"
#include "../model/sensor.h"
#include "../model/types.h"
#include "../model/units.h"
#include "innovation.h"

KQ_COLD kq_status T(kq_sensor_init_extended)(sensor *s, const num *H, const num *R)
{
    const kq_status status = T(kq_sensor_init)(s, H, R);
    if (status) return status;
    return sensor_extend(s, sensor_is_correlated(s) ? &T(kq_sensor_correlated_extended) : &independent_extended, KQ_OK);
}

KQ_COLD kq_status T(kq_sensor_init_diagonal_extended)(sensor *s, const num *H, const num *r)
{
    return sensor_extend(s, &independent_extended, T(kq_sensor_init_diagonal)(s, H, r));
}

KQ_COLD kq_status T(kq_sensor_init_lean_extended)(sensor *s, const num *H, const num *r)
{
    return sensor_extend(s, &lean_extended, T(kq_sensor_init_lean)(s, H, r));
}

#endif
