/* What is compiled with the library's own text: predict and update for sizes that the compiler knows, where there are
   such (the same bits in half of the time), and steps of the mean alone (calm.h). */
#ifndef KQ_NATIVE_KNOWN_SIZES_H
#define KQ_NATIVE_KNOWN_SIZES_H

#include "kalmanq/kalmanq.h"

#define KERNELS(T, num)                                                                            \
    typedef struct {                                                                               \
        num directions[KQ_SIZE_MAX * KQ_SIZE_MAX]; /* m x n: s times the gain of each component */   \
        num variances[KQ_SIZE_MAX];                /* m: s */                                      \
        num sigmas[KQ_SIZE_MAX], rotations[KQ_SIZE_MAX * KQ_SIZE_MAX]; /* m, m x n: what a history has of an update */ \
        kq_likelihood_##T last;                    /* of a step, but for its NIS */                \
    } kq_calm_##T;                                                                                 \
    /* What a step does to the mean, if a full step makes the root of f `next`; or 0: it does not, or \
       something may be unusual. */                                                                \
    int kq_calm_find_##T(kq_calm_##T *, const kq_filter_##T *, const kq_process_##T *,             \
                         const kq_sensor_##T *, const num *next);                                  \
    /* A calm step of any size: predict and update; e: the innovations.  0: it is unusual, and nothing has changed */ \
    int kq_calm_any_##T(const kq_calm_##T *, kq_filter_##T *, const kq_process_##T *, const num *u, \
                        const kq_sensor_##T *, const num *z, num *e);                              \
    /* A calm step into the history that is attached to f, which has not moved yet; e: what each component left */ \
    void kq_calm_record_##T(const kq_calm_##T *, kq_filter_##T *, const kq_process_##T *, const num *e, int m); \
    typedef struct {                                                                               \
        kq_status (*predict)(kq_filter_##T *, const kq_process_##T *, const num *);                \
        kq_status (*update)(kq_filter_##T *, const kq_sensor_##T *, const num *);                  \
        int (*calm)(const kq_calm_##T *, kq_filter_##T *, const kq_process_##T *, const num *u,    \
                    const kq_sensor_##T *, const num *z, num *e);                                  \
    } kq_kernels_##T;                                                                              \
    /* is_upper: A has nothing below its diagonal.  Where no size fits: the library's functions. */         \
    kq_kernels_##T kq_kernels_for_##T(int n, int m, int is_upper);

KERNELS(f32, float)
KERNELS(f64, double)
KERNELS(q31, int32_t)

#undef KERNELS
#endif
