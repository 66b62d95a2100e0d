/* Predict and update for sizes that the compiler knows, where there are such: the same bits in half of the time. */
#ifndef KALMANQ_NATIVE_KNOWN_SIZES_H
#define KALMANQ_NATIVE_KNOWN_SIZES_H

#include "kalmanq/kalmanq.h"

#define KERNELS(T, num)                                                                            \
    typedef struct {                                                                               \
        kq_status (*predict)(kq_filter_##T *, const kq_process_##T *, const num *);                \
        kq_status (*update)(kq_filter_##T *, const kq_sensor_##T *, const num *);                  \
    } kq_kernels_##T;                                                                              \
    /* is_upper: A has nothing below its diagonal.  Where no size fits: the library's functions. */ \
    kq_kernels_##T kq_kernels_for_##T(int n, int m, int is_upper);

KERNELS(f32, float)
KERNELS(f64, double)
KERNELS(q31, int32_t)

#undef KERNELS
#endif
