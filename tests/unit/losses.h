/* The robust updates with their parameter as an argument. */
#ifndef KALMANQ_TESTS_LOSSES_H
#define KALMANQ_TESTS_LOSSES_H

#include "arithmetic.h"

static inline kq_status update_huber(K(filter) *f, const K(sensor) *s, const num *z, uint32_t present, num k,
                                     num *weights)
{
    return K(update_robust)(f, s, z, present, &(K(loss)){.kind = &K(loss_huber), .parameter = k, .weights = weights});
}

static inline kq_status update_student(K(filter) *f, const K(sensor) *s, const num *z, uint32_t present, num nu,
                                       num *weights)
{
    return K(update_robust)(f, s, z, present, &(K(loss)){.kind = &K(loss_student), .parameter = nu, .weights = weights});
}

static inline kq_status update_jump(K(filter) *f, const K(sensor) *s, const num *z, uint32_t present, num g)
{
    return K(update_robust)(f, s, z, present, &(K(loss)){.kind = &K(loss_jump), .parameter = g});
}

#endif
