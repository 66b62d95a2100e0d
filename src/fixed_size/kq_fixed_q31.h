/*
 * kq_predict_q31, kq_update_q31, kq_step_q31 and kq_smooth_step_q31 for sizes that the compiler
 * knows: options.h says how they are used.  Arguments, results and errors are those of
 * kalmanq/filter.h and kalmanq/smoother.h, and
 *
 *   n, m, l   the filter's states, the sensor's components and the process's controls, constants
 *   options   KQ_FIXED_UPPER, KQ_FIXED_BARE or 0, a constant (KQ_FIXED_BARE: for update and step)
 */
#ifndef KALMANQ_FIXED_Q31_H
#define KALMANQ_FIXED_Q31_H

#pragma GCC system_header

#define KQ_SIZES_ARE_CONSTANT

#include "../arithmetic/q31.h"

#include "api.h"

#endif
