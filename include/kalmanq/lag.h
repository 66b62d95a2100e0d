/*
 * kalmanq: the fixed-lag smoother: the state of k steps ago given all measurements so far, at run time.
 *
 *     x_t-k|t,  P_t-k|t        0 <= k <= L, any k at any time
 *
 * k = 0 is the filter, bit for bit.  The oldest step is what kq_smooth gives for it, but for rounding.
 *
 *     kq_filter_f32 view;                               without memory
 *     kq_attach_f32(&track, &past.attached);
 *     for (;;) {
 *         kq_update_f32(&track, &ranger, &z);
 *         if (kq_lagged_f32(&past, kq_lag_steps_f32(&past), &view) == KQ_OK)
 *             ... kq_mean_f32(&view, i), kq_sigma_f32(&view, i)
 *         kq_predict_f32(&track, &motion, NULL);
 *     }
 *
 * The lag does not change the filter's bits.  It keeps nothing of processes and sensors: they may change at every
 * step.  For each of L steps it keeps the filtered state and an orthogonal map xi_t = J xi_t+1 + d + E zeta of the
 * root's coordinates.  It composes at most two maps a predict, so the cost does not depend on L.
 */
#ifndef KALMANQ_LAG_H
#define KALMANQ_LAG_H

#include "smoother.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Length of a lag's memory, in words.
 *   n, m     1..16 states; the most scalar measurements of one step, all sensors together, at least 1
 *   L        the longest lag, 0 or more
 * f32: 2.5 n^2 + 3.5 n words a step; at L = 10, (n, m) = (2, 1), (4, 2), (9, 3) 912, 2912, 12600 bytes. */
#define KQ_PRIVATE_MAP_LEN_F32(n) (2 * (n) * (n) + (n))
#define KQ_PRIVATE_ON_LINE_LEN_F32(n, m) \
    (KQ_PRIVATE_HISTORY_WORKSPACE_LEN(n) + (kq_length)(m) * ((kq_length)(n) + 3) + \
        KQ_FILTER_LEN_F32((size_t)(n)))
#define KQ_PRIVATE_LAG_STEP_LEN_F32(n) (KQ_FILTER_LEN_F32((size_t)(n)) + KQ_PRIVATE_MAP_LEN_F32((size_t)(n)))
#define KQ_LAG_LEN_F32(n, m, L) \
    ((kq_length)(L)*KQ_PRIVATE_LAG_STEP_LEN_F32(n) + KQ_PRIVATE_ON_LINE_LEN_F32(n, m) + \
        2 * KQ_PRIVATE_MAP_LEN_F32((size_t)(n)))
#define KQ_PRIVATE_MAP_LEN_F64(n) (2 * (n) * (n) + (n))
#define KQ_PRIVATE_ON_LINE_LEN_F64(n, m) \
    (KQ_PRIVATE_HISTORY_WORKSPACE_LEN(n) + (kq_length)(m) * ((kq_length)(n) + 3) + \
        KQ_FILTER_LEN_F64((size_t)(n)))
#define KQ_PRIVATE_LAG_STEP_LEN_F64(n) (KQ_FILTER_LEN_F64((size_t)(n)) + KQ_PRIVATE_MAP_LEN_F64((size_t)(n)))
#define KQ_LAG_LEN_F64(n, m, L) \
    ((kq_length)(L)*KQ_PRIVATE_LAG_STEP_LEN_F64(n) + KQ_PRIVATE_ON_LINE_LEN_F64(n, m) + \
        2 * KQ_PRIVATE_MAP_LEN_F64((size_t)(n)))

/* The fields are the library's (see process.h). */
typedef struct kq_lag_f32 {
    union {
        kq_history_f32 tape; /* of the current step; its memory is all of the memory */
        struct kq_attached_f32 attached;
    };
    uint32_t most, block, steps; /* L; steps whose maps are composed with each other; that can be read */
    uint32_t next, head; /* place in the ring of the next step; steps of the block that is being filled */
    uint32_t joined; /* age of the last step that is composed with the later steps of its block */
} kq_lag_f32;
extern const struct kq_hooks_f32 kq_lag_hooks_f32, kq_delay_hooks_f32; /* what it does in the steps */
typedef struct kq_lag_f64 {
    union {
        kq_history_f64 tape; /* of the current step; its memory is all of the memory */
        struct kq_attached_f64 attached;
    };
    uint32_t most, block, steps, next, head, joined;
} kq_lag_f64;
extern const struct kq_hooks_f64 kq_lag_hooks_f64, kq_delay_hooks_f64;

/** Declares a lag `name` with its static memory. */
#define KQ_LAG_F32(name, n, m, L) KQ_PRIVATE_LAG_F32(name, n, m, L, kq_lag_hooks_f32)
#define KQ_PRIVATE_LAG_F32(name, n, m, L, hooks) \
    static float name##_memory[KQ_LAG_LEN_F32(n, m, L)]; \
    static kq_lag_f32 name = { {{{&hooks}, n, 0, 0, 0, 0, 0, KQ_PRIVATE_ON_LINE_LEN_F32(n, m), \
        0, name##_memory, NULL, NULL, 0, 0}}, L, 0, 0, 0, 0, 0}
#define KQ_LAG_F64(name, n, m, L) KQ_PRIVATE_LAG_F64(name, n, m, L, kq_lag_hooks_f64)
#define KQ_PRIVATE_LAG_F64(name, n, m, L, hooks) \
    static double name##_memory[KQ_LAG_LEN_F64(n, m, L)]; \
    static kq_lag_f64 name = { {{{&hooks}, n, 0, 0, 0, 0, 0, KQ_PRIVATE_ON_LINE_LEN_F64(n, m), \
        0, name##_memory, NULL, NULL, 0, 0}}, L, 0, 0, 0, 0, 0}

/** Sets sizes and memory at run time.
 *   lag      written
 *   n        1..16 states
 *   m        1 or more: the most scalar measurements of one step, all sensors together
 *   L        0 or more: the longest lag, in steps
 *   memory   `length` words, yours while in use
 *   length   KQ_LAG_LEN_<T>(n, m, L) or more
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY. */
KQ_NODISCARD kq_status kq_lag_assign_f32(kq_lag_f32 *lag, int n, int m, size_t L, float *memory, size_t length);
KQ_NODISCARD kq_status kq_lag_assign_f64(kq_lag_f64 *lag, int n, int m, size_t L, double *memory, size_t length);

/*
 * kq_attach (filter.h) makes the present state the oldest step.  kq_filter_init, or another lag, instant or history,
 * ends the lag.  The last view stays valid after kq_detach.
 * Event in the filter: KQ_EVENT_HISTORY_FULL after more than m measurements in a step.  The lag has ended; attach it
 * again.
 * Cost of a predict, besides kq_predict: at most about 9 n^3 + 4 m n^2 multiplications, 2n roots and divisions.
 * Stack: independent of n.
 */

/** The largest k: L or the steps since kq_attach, the smaller.
 *   lag      read
 * 0 if it is NULL or not attached, or has ended (then kq_lagged answers the error). */
size_t kq_lag_steps_f32(const kq_lag_f32 *lag);
size_t kq_lag_steps_f64(const kq_lag_f64 *lag);

/** Shows the state of k steps ago, given all measurements so far, in a view (kq_smoothed).
 *   lag      attached; its scratch changes.  It keeps what the view shows until the next call
 *   k        0 .. kq_lag_steps()
 *   view     written; without memory, not the lag's filter.  After an error its readings are NaN
 * Events (of the view and the filter): KQ_EVENT_PRECISION as kq_smooth, without what A x is rounded by;
 * KQ_EVENT_OVERFLOW as kq_smooth.
 * Accuracy: as the filter; a few eps sigma_filtered are added to mean and sigma.
 * Cost for k = L or k <= 4: at most about 12 n^3 multiplications and 4n square roots.  For other k up to L/2 maps of
 * 3 n^3 multiplications more.
 * KQ_ERR_NULL, KQ_ERR_SIZE (k), KQ_ERR_MISMATCH (view), KQ_ERR_HISTORY_EMPTY (not attached, or ended),
 * KQ_ERR_HISTORY_FULL (more than m measurements in a step: attach it again). */
KQ_NODISCARD kq_status kq_lagged_f32(kq_lag_f32 *lag, size_t k, kq_filter_f32 *view);
KQ_NODISCARD kq_status kq_lagged_f64(kq_lag_f64 *lag, size_t k, kq_filter_f64 *view);

/** As kq_lagged, the mean only, bit for bit, in 4 n^2 multiplications.  In the view kq_sigma is NaN and kq_covariance
 * answers KQ_ERR_NOT_READY. */
KQ_NODISCARD kq_status kq_lagged_states_f32(kq_lag_f32 *lag, size_t k, kq_filter_f32 *view);
KQ_NODISCARD kq_status kq_lagged_states_f64(kq_lag_f64 *lag, size_t k, kq_filter_f64 *view);

/* ------------------------------------------------------------------ late measurements
 *
 * A measurement that comes late is one of the state of k steps ago.  A delay is a lag that can take it:
 *
 *     KQ_DELAY_F32(past, 4, 3, 60);                     up to 60 steps late
 *     kq_attach_f32(&track, &past.attached);
 *     ...                                               predict and update as without it
 *     kq_update_delayed_f32(&past, k, &gps, z, UINT32_MAX);
 *
 * A history does not take late measurements.  While the filter runs, attach a delay in the place of the history; to smooth
 * a whole run, replay its rows in the order of their times.
 *
 * A delay keeps the maps of its steps apart, so that a late measurement changes them.  Memory and functions are as for a
 * lag; kq_lagged costs 3 n^3 multiplications for each of k steps.
 */

/** Declares a lag `name` that takes late measurements, with its static memory: 1 <= L, or kq_attach answers KQ_ERR_SIZE. */
#define KQ_DELAY_F32(name, n, m, L) KQ_PRIVATE_LAG_F32(name, n, m, L, kq_delay_hooks_f32)
#define KQ_DELAY_F64(name, n, m, L) KQ_PRIVATE_LAG_F64(name, n, m, L, kq_delay_hooks_f64)

/** As kq_lag_assign_f32, for late measurements: L is 1 or more. */
KQ_NODISCARD kq_status kq_delay_assign_f32(kq_lag_f32 *lag, int n, int m, size_t L, float *memory, size_t length);
KQ_NODISCARD kq_status kq_delay_assign_f64(kq_lag_f64 *lag, int n, int m, size_t L, double *memory, size_t length);

/** Takes a measurement of the state of k steps ago, as if it had come at the end of that step: the filter, the states
 * of the lag and what is taken later, of any step, are as in the run in which it did.
 *   lag      attached
 *   k        0 .. kq_lag_steps().  0 is kq_update_subset
 *   s, z     as in kq_update; not a sensor of innovations
 *   present  bit c: component c was measured.  UINT32_MAX: all
 * NIS and likelihood are those given all data so far.  A gate before it: kq_lagged, then kq_measurement of the view.
 * Cost of a component: for each of k steps about 24 n^2 multiplications and 6n square roots and divisions.  To replay
 * kept measurements from a copy of an old filter is cheaper where a program can keep them.
 * Accuracy: as the filter; of low-noise measurements, in the middle, twice its rounding.
 * Events: as kq_update.  After KQ_EVENT_OVERFLOW with KQ_EVENT_HISTORY_FULL the lag has ended.
 * KQ_ERR_NULL, KQ_ERR_HISTORY_EMPTY, KQ_ERR_HISTORY_FULL as kq_lagged; KQ_ERR_SIZE (k); KQ_ERR_MISMATCH (not a delay;
 * a sensor of innovations, or of another size); as kq_update. */
KQ_NODISCARD kq_status kq_update_delayed_f32(kq_lag_f32 *lag, size_t k, const kq_sensor_f32 *s, const float *z,
    uint32_t present);
KQ_NODISCARD kq_status kq_update_delayed_f64(kq_lag_f64 *lag, size_t k, const kq_sensor_f64 *s, const double *z,
    uint32_t present);

/* ------------------------------------------------------------------ q31, as f32 */

#define KQ_PRIVATE_MAP_LEN_Q31(n) (2 * (n) * (n) + 2 * (n))
#define KQ_PRIVATE_ON_LINE_LEN_Q31(n, m) \
    (KQ_PRIVATE_HISTORY_WORKSPACE_LEN_Q31(n) + (kq_length)(m) * ((kq_length)(n) + 7) + \
        KQ_FILTER_LEN_Q31((size_t)(n)))
#define KQ_PRIVATE_LAG_STEP_LEN_Q31(n) (KQ_FILTER_LEN_Q31((size_t)(n)) + KQ_PRIVATE_MAP_LEN_Q31((size_t)(n)))
#define KQ_LAG_LEN_Q31(n, m, L) \
    ((kq_length)(L)*KQ_PRIVATE_LAG_STEP_LEN_Q31(n) + KQ_PRIVATE_ON_LINE_LEN_Q31(n, m) + \
        2 * KQ_PRIVATE_MAP_LEN_Q31((size_t)(n)))

typedef struct kq_lag_q31 {
    union {
        kq_history_q31 tape; /* of the current step; its memory is all of the memory */
        struct kq_attached_q31 attached;
    };
    uint32_t most, block, steps, next, head, joined;
} kq_lag_q31;
extern const struct kq_hooks_q31 kq_lag_hooks_q31, kq_delay_hooks_q31;

#define KQ_LAG_Q31(name, n, m, L) KQ_PRIVATE_LAG_Q31(name, n, m, L, kq_lag_hooks_q31)
#define KQ_DELAY_Q31(name, n, m, L) KQ_PRIVATE_LAG_Q31(name, n, m, L, kq_delay_hooks_q31)
#define KQ_PRIVATE_LAG_Q31(name, n, m, L, hooks) \
    static int32_t name##_memory[KQ_LAG_LEN_Q31(n, m, L)]; \
    static kq_lag_q31 name = { {{{&hooks}, n, 0, 0, 0, 0, 0, KQ_PRIVATE_ON_LINE_LEN_Q31(n, m), \
        0, name##_memory, NULL, NULL, 0, 0, NULL}}, L, 0, 0, 0, 0, 0}

/** As kq_lag_assign_f32 and kq_delay_assign_f32. */
KQ_NODISCARD kq_status kq_lag_assign_q31(kq_lag_q31 *lag, int n, int m, size_t L, int32_t *memory, size_t length);
KQ_NODISCARD kq_status kq_delay_assign_q31(kq_lag_q31 *lag, int n, int m, size_t L, int32_t *memory, size_t length);
/** As kq_update_delayed_f32; KQ_EVENT_SATURATED as kq_lagged_q31. */
KQ_NODISCARD kq_status kq_update_delayed_q31(kq_lag_q31 *lag, size_t k, const kq_sensor_q31 *s, const int32_t *z,
    uint32_t present);
/** As kq_lag_steps_f32. */
size_t kq_lag_steps_q31(const kq_lag_q31 *lag);
/** As kq_lagged_f32 and kq_lagged_states_f32.
 * KQ_EVENT_SATURATED (in the view and the filter): a smoothed mean saturated, or data contradict it by 32768 sigma.
 * Accuracy: as the filter; about 2^-27 of the filtered sigma is added. */
KQ_NODISCARD kq_status kq_lagged_q31(kq_lag_q31 *lag, size_t k, kq_filter_q31 *view);
KQ_NODISCARD kq_status kq_lagged_states_q31(kq_lag_q31 *lag, size_t k, kq_filter_q31 *view);

#ifdef __cplusplus
}
#endif
#endif
