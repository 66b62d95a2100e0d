/* The robust updates of q31 with their parameter as an argument. */
#ifndef KALMANQ_TESTS_LOSSES_Q31_H
#define KALMANQ_TESTS_LOSSES_Q31_H

#include "q31.h"

static inline kq_status huber_q31(kq_filter_q31 *f, const kq_sensor_q31 *s, const int32_t *z, uint32_t present,
                           kq_scaled_q31 k, kq_scaled_q31 *w)
{
    return kq_update_robust_q31(f, s, z, present,
                                &(kq_loss_q31){.kind = &kq_loss_huber_q31, .parameter = k, .weights = w});
}

static inline kq_status student_q31(kq_filter_q31 *f, const kq_sensor_q31 *s, const int32_t *z, uint32_t present,
                             kq_scaled_q31 nu, kq_scaled_q31 *w)
{
    return kq_update_robust_q31(f, s, z, present,
                                &(kq_loss_q31){.kind = &kq_loss_student_q31, .parameter = nu, .weights = w});
}

static inline kq_status jump_q31(kq_filter_q31 *f, const kq_sensor_q31 *s, const int32_t *z, uint32_t present,
                          kq_scaled_q31 g)
{
    return kq_update_robust_q31(f, s, z, present, &(kq_loss_q31){.kind = &kq_loss_jump_q31, .parameter = g});
}

#endif
