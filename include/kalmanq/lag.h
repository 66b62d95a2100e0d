/*
 * kalmanq: the fixed-lag smoother: while the filter runs, the state of k steps ago given all measurements so far.
 *
 *     x_t-k|t,  P_t-k|t        0 <= k <= L, at every new measurement
 *
 * k = 0 is the filter, bit for bit.  If k is the number of steps made, the state is what kq_smooth gives for the
 * first step, but for rounding.  You can ask for any k at any time, so at the end of a run you can read the whole
 * window.
 *
 * How to use it.  Attach a LAG to a filter, and use the filter as without it: any steps, sensors and gaps.
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
 * The filter is, bit for bit, what it is without a lag.  Processes, sensors and their matrices may change from
 * step to step: the lag keeps nothing of them.
 *
 * How it works.  Predict and update are orthogonal maps of the coordinates of the root S (smoother.h).  A lag
 * keeps, of each of L steps, the filtered state and the map
 *     xi_t = J xi_t+1 + d + E zeta,    zeta ~ N(0, I), J J' + E E' <= I
 * It composes maps beforehand, at most two a predict, so the cost of a sample does not depend on L.  Nothing is
 * inverted or subtracted: the covariance is positive semi-definite.
 *
 * Sources: Rauch, Tung and Striebel, Maximum likelihood estimates of linear dynamic systems, AIAA J. 3 (1965);
 * Anderson and Moore, Optimal Filtering (1979), chapter 7; Tangwongsan, Hirzel and Schneider, Low-latency
 * sliding-window aggregation in worst-case constant time, DEBS 2017.
 */
#ifndef KALMANQ_LAG_H
#define KALMANQ_LAG_H

#include "smoother.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * Words of memory of a lag.
 *   n   states, 1..16
 *   m   the most scalar measurements of one step, of all sensors together, at least 1
 *   L   the longest lag, 0 or more
 * Each of the L steps takes 2.5 n^2 + 3.5 n words in f32.  Bytes at L = 10 and (n, m) = (2,1), (4,2), (9,3):
 * 912, 2912, 12600.
 */
#define KQ_PRIVATE_MAP_LEN_F32(n) (2 * (n) * (n) + (n))
#define KQ_PRIVATE_ON_LINE_LEN_F32(n, m)                                                           \
    (KQ_PRIVATE_HISTORY_WORKSPACE_LEN(n) + (kq_length)(m) * ((kq_length)(n) + 3) + KQ_FILTER_LEN_F32((size_t)(n)))
#define KQ_PRIVATE_LAG_STEP_LEN_F32(n) (KQ_FILTER_LEN_F32((size_t)(n)) + KQ_PRIVATE_MAP_LEN_F32((size_t)(n)))
#define KQ_LAG_LEN_F32(n, m, L)                                                                    \
    ((kq_length)(L)*KQ_PRIVATE_LAG_STEP_LEN_F32(n) + KQ_PRIVATE_ON_LINE_LEN_F32(n, m) +            \
     2 * KQ_PRIVATE_MAP_LEN_F32((size_t)(n)))
#define KQ_PRIVATE_MAP_LEN_F64(n) (2 * (n) * (n) + (n))
#define KQ_PRIVATE_ON_LINE_LEN_F64(n, m)                                                           \
    (KQ_PRIVATE_HISTORY_WORKSPACE_LEN(n) + (kq_length)(m) * ((kq_length)(n) + 3) + KQ_FILTER_LEN_F64((size_t)(n)))
#define KQ_PRIVATE_LAG_STEP_LEN_F64(n) (KQ_FILTER_LEN_F64((size_t)(n)) + KQ_PRIVATE_MAP_LEN_F64((size_t)(n)))
#define KQ_LAG_LEN_F64(n, m, L)                                                                    \
    ((kq_length)(L)*KQ_PRIVATE_LAG_STEP_LEN_F64(n) + KQ_PRIVATE_ON_LINE_LEN_F64(n, m) +            \
     2 * KQ_PRIVATE_MAP_LEN_F64((size_t)(n)))

/* The fields are the library's (see process.h). */
typedef struct kq_lag_f32 {
    union {
        kq_history_f32 tape; /* of the current step; its memory is all of the memory */
        struct kq_attached_f32 attached;
    };
    uint32_t most;       /* L */
    uint32_t block;      /* steps whose maps are composed with each other */
    uint32_t steps;      /* that can be asked for */
    uint32_t next;       /* place in the ring of the next step */
    uint32_t head;       /* steps of the block that is being filled */
    uint32_t joined;     /* age of the last step composed with those of its block after it */
} kq_lag_f32;

extern const struct kq_hooks_f32 kq_lag_hooks_f32; /* what it does in the steps */

typedef struct kq_lag_f64 {
    union {
        kq_history_f64 tape; /* of the current step; its memory is all of the memory */
        struct kq_attached_f64 attached;
    };
    uint32_t most;
    uint32_t block;
    uint32_t steps;
    uint32_t next;
    uint32_t head;
    uint32_t joined;
} kq_lag_f64;

extern const struct kq_hooks_f64 kq_lag_hooks_f64;

/** A lag `name` with its storage, in static memory: for n states, at most m scalar
    measurements a step, up to L steps back. */
#define KQ_LAG_F32(name, n, m, L)                                                                  \
    static float name##_memory[KQ_LAG_LEN_F32(n, m, L)];                                           \
    static kq_lag_f32 name = {                                                                     \
        {{{&kq_lag_hooks_f32}, n, 0, 0, 0, 0, 0, KQ_PRIVATE_ON_LINE_LEN_F32(n, m), 0, name##_memory, NULL, NULL, 0}}, \
        L, 0, 0, 0, 0, 0}
#define KQ_LAG_F64(name, n, m, L)                                                                  \
    static double name##_memory[KQ_LAG_LEN_F64(n, m, L)];                                          \
    static kq_lag_f64 name = {                                                                     \
        {{{&kq_lag_hooks_f64}, n, 0, 0, 0, 0, 0, KQ_PRIVATE_ON_LINE_LEN_F64(n, m), 0, name##_memory, NULL, NULL, 0}}, \
        L, 0, 0, 0, 0, 0}

/**
 * Sizes and memory known at run time only (the macros do the same at compile time).
 *   lag      written
 *   n, m, L  as above
 *   length   words at memory: KQ_LAG_LEN_<T>(n, m, L)
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY.
 */
KQ_NODISCARD kq_status kq_lag_assign_f32(kq_lag_f32 *lag, int n, int m, size_t L, float *memory, size_t length);
KQ_NODISCARD kq_status kq_lag_assign_f64(kq_lag_f64 *lag, int n, int m, size_t L, double *memory, size_t length);

/*
 * Attaching (kq_attach).  You can ask for the current step alone then.  The lag takes the place of the filter's
 * history: a filter has one of them.  kq_filter_init, or another lag or history, ends the lag.  Lag and filter must be
 * alive until the lag is detached.  After kq_detach the last view stays valid.
 *     More than m measurements in a step set KQ_EVENT_HISTORY_FULL in the filter, which goes on by itself: attach the
 * lag again.
 *     Cost of a predict from then on, besides kq_predict: at most about 9 n^3 + 4 m n^2 multiplications, 2n square roots
 * and as many divisions, whatever L is.  Stack: it does not depend on n, the scratch is in the lag's memory.
 */

/** The longest k that you can ask for: the lesser of L and the steps made since the lag was attached.  0 where it is
    not attached, or could not follow (kq_lagged then says so). */
size_t kq_lag_steps_f32(const kq_lag_f32 *lag);
size_t kq_lag_steps_f64(const kq_lag_f64 *lag);

/**
 * Smooths k steps ago, given all measurements so far, and shows it in a view, as kq_smoothed does.
 *   lag      attached; keeps what is shown until the next call
 *   k        0 .. kq_lag_steps()
 *   view     written; without memory, not the lag's filter.  After an error its readings are NaN.
 * Neither the filter nor what you can ask for changes.
 * Cost for k = L, and for k up to 4: at most about 12 n^3 multiplications, 4n square roots; for other k a few of the
 * L / 2 maps in between, 3 n^3 each.
 * Accuracy: as the filter; a few eps sigma_filtered are added to mean and sigma (tests/README.md, Accuracy).
 * KQ_ERR_NULL, KQ_ERR_SIZE (k), KQ_ERR_MISMATCH (view), KQ_ERR_HISTORY_EMPTY (not attached, or not any more),
 * KQ_ERR_HISTORY_FULL (it could not follow: attach it again).
 */
KQ_NODISCARD kq_status kq_lagged_f32(kq_lag_f32 *lag, size_t k, kq_filter_f32 *view);
KQ_NODISCARD kq_status kq_lagged_f64(kq_lag_f64 *lag, size_t k, kq_filter_f64 *view);

/**
 * The mean alone, of the same bits: of the view kq_sigma is NaN, and kq_covariance answers KQ_ERR_NOT_READY.
 * Cost: 4 n^2 multiplications, where kq_lagged has 12 n^3.
 * Errors as kq_lagged.
 */
KQ_NODISCARD kq_status kq_lagged_states_f32(kq_lag_f32 *lag, size_t k, kq_filter_f32 *view);
KQ_NODISCARD kq_status kq_lagged_states_f64(kq_lag_f64 *lag, size_t k, kq_filter_f64 *view);

/* ------------------------------------------------------------------ q31, as in f32
 *
 * Accuracy: as the filter; about 2^-27 of the filtered sigma is added.
 * KQ_EVENT_SATURATED (in the view and the filter): a smoothed mean saturated, or data contradict the model by more
 * than 32768 sigma.
 */

#define KQ_PRIVATE_MAP_LEN_Q31(n) (2 * (n) * (n) + 2 * (n))
#define KQ_PRIVATE_ON_LINE_LEN_Q31(n, m)                                                           \
    (KQ_PRIVATE_HISTORY_WORKSPACE_LEN_Q31(n) + (kq_length)(m) * ((kq_length)(n) + 7) +             \
     KQ_FILTER_LEN_Q31((size_t)(n)))
#define KQ_PRIVATE_LAG_STEP_LEN_Q31(n) (KQ_FILTER_LEN_Q31((size_t)(n)) + KQ_PRIVATE_MAP_LEN_Q31((size_t)(n)))
#define KQ_LAG_LEN_Q31(n, m, L)                                                                    \
    ((kq_length)(L)*KQ_PRIVATE_LAG_STEP_LEN_Q31(n) + KQ_PRIVATE_ON_LINE_LEN_Q31(n, m) +            \
     2 * KQ_PRIVATE_MAP_LEN_Q31((size_t)(n)))

/* The fields are the library's. */
typedef struct kq_lag_q31 {
    union {
        kq_history_q31 tape; /* of the current step; its memory is all of the memory */
        struct kq_attached_q31 attached;
    };
    uint32_t most;
    uint32_t block;
    uint32_t steps;
    uint32_t next;
    uint32_t head;
    uint32_t joined;
} kq_lag_q31;

extern const struct kq_hooks_q31 kq_lag_hooks_q31;

#define KQ_LAG_Q31(name, n, m, L)                                                                  \
    static int32_t name##_memory[KQ_LAG_LEN_Q31(n, m, L)];                                         \
    static kq_lag_q31 name = {                                                                     \
        {{{&kq_lag_hooks_q31}, n, 0, 0, 0, 0, 0, KQ_PRIVATE_ON_LINE_LEN_Q31(n, m), 0, name##_memory, NULL, NULL, 0, NULL}}, \
        L, 0, 0, 0, 0, 0}

KQ_NODISCARD kq_status kq_lag_assign_q31(kq_lag_q31 *lag, int n, int m, size_t L, int32_t *memory, size_t length);
size_t kq_lag_steps_q31(const kq_lag_q31 *lag);
KQ_NODISCARD kq_status kq_lagged_q31(kq_lag_q31 *lag, size_t k, kq_filter_q31 *view);
KQ_NODISCARD kq_status kq_lagged_states_q31(kq_lag_q31 *lag, size_t k, kq_filter_q31 *view);

#ifdef __cplusplus
}
#endif
#endif
