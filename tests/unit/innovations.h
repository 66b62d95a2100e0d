/* Sensors that take innovations, made of plain ones. */
#ifndef KALMANQ_TESTS_INNOVATIONS_H
#define KALMANQ_TESTS_INNOVATIONS_H

#include "arithmetic.h"

/* Like s, which stays; the last one that was made */
static inline const K(sensor) *of_innovations(const K(sensor) *s)
{
    static num memory[KQ_SENSOR_LEN(KQ_SIZE_MAX)];
    static K(sensor) made;
    ASSERT_OK(K(sensor_assign)(&made, s->states, s->components, memory, COUNT(memory)));
    if (s->covariance) ASSERT_OK(K(sensor_init_extended)(&made, s->measurement, s->covariance));
    else ASSERT_OK(K(sensor_init_diagonal_extended)(&made, s->measurement, s->noise));
    return &made;
}

#endif
