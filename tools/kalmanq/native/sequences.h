/* Whole sequences in one call, in each arithmetic. */
#ifndef KALMANQ_NATIVE_SEQUENCES_H
#define KALMANQ_NATIVE_SEQUENCES_H

#include "kalmanq/kalmanq.h"

#include "continuous.h"
#include "printing.h"
#include "slopes.h"
#include "tables.h"
#include "varying.h"

#define K(name) kq_##name##_f32
#define num float
#define number float
#define score float
#include "sequence_types.h"

#define K(name) kq_##name##_f64
#define num double
#define number double
#define score double
#include "sequence_types.h"

#define K(name) kq_##name##_q31
#define num int32_t
#define number kq_scaled_q31
#define score int64_t
#include "sequence_types.h"

#endif
