/* Whole sequences in one call, in each arithmetic. */
#ifndef KALMANQ_NATIVE_SEQUENCES_H
#define KALMANQ_NATIVE_SEQUENCES_H

#include "kalmanq/kalmanq.h"

#include "continuous.h"
#include "exact.h"
#include "printing.h"
#include "slopes.h"
#include "tables.h"
#include "varying.h"

#include "of_f32.h"
#include "sequence_types.h"
#include "of_f64.h"
#include "sequence_types.h"
#include "of_q31.h"
#include "sequence_types.h"

#undef K
#undef num
#undef number
#undef score

#endif
