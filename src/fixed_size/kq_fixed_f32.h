/*
 * kq_predict_f32, kq_update_f32, kq_step_f32 and kq_smooth_step_f32 for sizes that the compiler
 * knows: options.h says how they are used.  Arguments, results and errors are those of
 * kalmanq/filter.h and kalmanq/smoother.h, and
 *
 *   n, m, l   the filter's states, the sensor's components and the process's controls, constants
 *   options   KQ_FIXED_UPPER, KQ_FIXED_BARE or 0, a constant (KQ_FIXED_BARE: for update and step)
 */
#ifndef KALMANQ_FIXED_F32_H
#define KALMANQ_FIXED_F32_H

#pragma GCC system_header

#define KQ_SIZES_ARE_CONSTANT

#include "../arithmetic/f32.h"

#include "api.h"

#endif
