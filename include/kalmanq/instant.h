/*
 * kalmanq: the fixed-point smoother: one instant s, given all measurements so far.
 *
 *     x_s|t,  P_s|t        s fixed, t = s, s + 1, ...
 *
 * The instant is the time of kq_attach: the start of a run, a launch, an alarm.  Updates before the next kq_predict are
 * of that time.  The memory does not grow with the steps.  kq_smooth of the whole run gives the same for this step, but
 * for rounding.
 *
 *     kq_attach_f32(&track, &launch.attached);
 *     ... updates and predicts ...
 *     kq_instant_smooth_f32(&launch, &view);   kq_mean_f32(&view, i), kq_sigma_f32(&view, i)
 *
 * The filter's bits stay.  Processes and sensors may change at every step: the instant keeps nothing of them.
 */
#ifndef KALMANQ_INSTANT_H
#define KALMANQ_INSTANT_H

#include "lag.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Length of an instant's memory, in words: n states, 1..16; m, the most scalar measurements of one step, all sensors
 * together, at least 1. */
#define KQ_INSTANT_LEN_F32(n, m) \
    (KQ_PRIVATE_ON_LINE_LEN_F32(n, m) + KQ_FILTER_LEN_F32((size_t)(n)) + \
        2 * KQ_PRIVATE_MAP_LEN_F32((size_t)(n)))
#define KQ_INSTANT_LEN_F64(n, m) \
    (KQ_PRIVATE_ON_LINE_LEN_F64(n, m) + KQ_FILTER_LEN_F64((size_t)(n)) + \
        2 * KQ_PRIVATE_MAP_LEN_F64((size_t)(n)))

/* The fields are the library's (see process.h). */
typedef struct kq_instant_f32 {
    union {
        kq_history_f32 tape; /* of the current step; its memory is all of the memory */
        struct kq_attached_f32 attached;
    };
} kq_instant_f32;
extern const struct kq_hooks_f32 kq_instant_hooks_f32; /* what it does in the steps */
typedef struct kq_instant_f64 {
    union {
        kq_history_f64 tape;
        struct kq_attached_f64 attached;
    };
} kq_instant_f64;
extern const struct kq_hooks_f64 kq_instant_hooks_f64; /* what it does in the steps */

/** Declares an instant `name` with its static memory. */
#define KQ_INSTANT_F32(name, n, m) \
    static float name##_memory[KQ_INSTANT_LEN_F32(n, m)]; \
    static kq_instant_f32 name = { {{{&kq_instant_hooks_f32}, n, 0, 0, 0, 0, 0, \
        KQ_PRIVATE_ON_LINE_LEN_F32(n, m), 0, name##_memory, NULL, NULL, 0, 0}}}
#define KQ_INSTANT_F64(name, n, m) \
    static double name##_memory[KQ_INSTANT_LEN_F64(n, m)]; \
    static kq_instant_f64 name = { {{{&kq_instant_hooks_f64}, n, 0, 0, 0, 0, 0, \
        KQ_PRIVATE_ON_LINE_LEN_F64(n, m), 0, name##_memory, NULL, NULL, 0, 0}}}

/** Sets sizes and memory at run time.
 *   instant  written
 *   n        1..16 states
 *   m        1 or more: the most scalar measurements of one step, all sensors together
 *   memory   `length` words, yours while in use
 *   length   KQ_INSTANT_LEN_<T>(n, m) or more
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY. */
KQ_NODISCARD kq_status kq_instant_assign_f32(kq_instant_f32 *instant, int n, int m, float *memory, size_t length);
KQ_NODISCARD kq_status kq_instant_assign_f64(kq_instant_f64 *instant, int n, int m, double *memory, size_t length);

/*
 * kq_attach (filter.h) makes the present state the instant.  kq_filter_init, or another instant, lag or history, ends
 * it.  The last view stays valid after kq_detach.
 * Event in the filter: KQ_EVENT_HISTORY_FULL after more than m measurements in a step; the instant is lost.
 * Cost of a predict, besides kq_predict: about 5 n^3 + 4 m n^2 multiplications, n square roots, n divisions.
 */

/** Shows the instant, given all measurements so far, in a view (kq_smoothed).
 *   instant  attached; its scratch changes.  It keeps what the view shows until the next call
 *   view     written; without memory, not the instant's filter.  After an error its readings are NaN
 * Events (of the view and the filter): KQ_EVENT_PRECISION as kq_smooth, without what A x is rounded by;
 * KQ_EVENT_OVERFLOW as kq_smooth.
 * Accuracy: as the filter; a few eps of the sigma before the first predict are added to mean and sigma.
 * Cost: about 2.5 n^3 multiplications, n square roots.
 * KQ_ERR_NULL, KQ_ERR_MISMATCH (view), KQ_ERR_HISTORY_EMPTY (not attached, or ended), KQ_ERR_HISTORY_FULL (the
 * instant is lost). */
KQ_NODISCARD kq_status kq_instant_smooth_f32(kq_instant_f32 *instant, kq_filter_f32 *view);
KQ_NODISCARD kq_status kq_instant_smooth_f64(kq_instant_f64 *instant, kq_filter_f64 *view);

/* ------------------------------------------------------------------ q31, as f32 */

#define KQ_INSTANT_LEN_Q31(n, m) \
    (KQ_PRIVATE_ON_LINE_LEN_Q31(n, m) + KQ_FILTER_LEN_Q31((size_t)(n)) + \
        2 * KQ_PRIVATE_MAP_LEN_Q31((size_t)(n)))

typedef struct kq_instant_q31 {
    union {
        kq_history_q31 tape;
        struct kq_attached_q31 attached;
    };
} kq_instant_q31;
extern const struct kq_hooks_q31 kq_instant_hooks_q31; /* what it does in the steps */

#define KQ_INSTANT_Q31(name, n, m) \
    static int32_t name##_memory[KQ_INSTANT_LEN_Q31(n, m)]; \
    static kq_instant_q31 name = { {{{&kq_instant_hooks_q31}, n, 0, 0, 0, 0, 0, \
        KQ_PRIVATE_ON_LINE_LEN_Q31(n, m), 0, name##_memory, NULL, NULL, 0, 0, NULL}}}

/** As kq_instant_assign_f32. */
KQ_NODISCARD kq_status kq_instant_assign_q31(kq_instant_q31 *instant, int n, int m, int32_t *memory, size_t length);
/** As kq_instant_smooth_f32.  KQ_EVENT_SATURATED and accuracy: as kq_lagged_q31. */
KQ_NODISCARD kq_status kq_instant_smooth_q31(kq_instant_q31 *instant, kq_filter_q31 *view);

#ifdef __cplusplus
}
#endif
#endif
