/* One text for f32 and f64: compiled with VECTOR_F32 or with VECTOR_F64. */
#ifndef KALMANQ_FLOATS_NUMBER_H
#define KALMANQ_FLOATS_NUMBER_H

#include <kalmanq/kalmanq.h>

#if defined(VECTOR_F32)
typedef float num;
#define K(name) kq_##name##_f32
#define FILTER_LEN KQ_FILTER_LEN_F32
#define HISTORY_LEN KQ_HISTORY_LEN_F32
#define JACOBIANS_LEN KQ_JACOBIANS_LEN_F32
#define LAG_LEN KQ_LAG_LEN_F32
#define START_LEN KQ_DIFFUSE_LEN_F32
#define INSTANT_LEN KQ_INSTANT_LEN_F32
#define CONSISTENCY_LEN KQ_CONSISTENCY_LEN_F32
#define ADAPTATION_LEN KQ_ADAPTATION_LEN_F32
#define EM_LEN KQ_EM_LEN_F32
#define STEADY_SOLVE_LEN KQ_STEADY_SOLVE_LEN_F32
#define SMALL 0x1p-42f /* variances at the lower end of those that count */
#define TINY 0x1p-118f /* no variances; means whose low parts are subnormal */
#define LARGE 0x1p+57f /* variances at the upper end of all numbers */
#elif defined(VECTOR_F64)
typedef double num;
#define K(name) kq_##name##_f64
#define FILTER_LEN KQ_FILTER_LEN_F64
#define HISTORY_LEN KQ_HISTORY_LEN_F64
#define JACOBIANS_LEN KQ_JACOBIANS_LEN_F64
#define LAG_LEN KQ_LAG_LEN_F64
#define START_LEN KQ_DIFFUSE_LEN_F64
#define INSTANT_LEN KQ_INSTANT_LEN_F64
#define CONSISTENCY_LEN KQ_CONSISTENCY_LEN_F64
#define ADAPTATION_LEN KQ_ADAPTATION_LEN_F64
#define EM_LEN KQ_EM_LEN_F64
#define STEADY_SOLVE_LEN KQ_STEADY_SOLVE_LEN_F64
#define SMALL 0x1p-170
#define TINY 0x1p-1018
#define LARGE 0x1p+497
#else
#error "compile with one of -DVECTOR_F32 and -DVECTOR_F64"
#endif

#endif
