/*
 * kalmanq: the fixed-lag smoother, what is known on line of the steps just past.
 *
 *     x_t-k|t,  P_t-k|t        0 <= k <= L, at every new measurement
 *
 * The estimate of k steps ago given all measurements so far, the newest included (smoother.h has
 * the formulas).  k = 0 is the filter, bit for bit; k = the number of steps made is what kq_smooth
 * would say of the first step, up to rounding.  Any k may be asked for at any time, so the window
 * can be flushed at the end of a run.
 *
 * How to use it.  A LAG is attached to a filter, whose kq_predict, kq_update and kq_step go on as ever:
 * updates by any of its functions, any number of them, of any sensor, or none.
 *
 *     kq_attach_f32(&track, &past.attached);
 *     for (;;) {
 *         kq_update_f32(&track, &ranger, &z);
 *         if (kq_lag_smooth_f32(&past, kq_lag_steps_f32(&past)) == KQ_OK)
 *             ... kq_lag_mean_f32(&past, i), kq_lag_sigma_f32(&past, i)
 *         kq_predict_f32(&track, &motion, NULL);
 *     }
 *
 * The filter is, bit for bit, what it is without a lag.  Processes, sensors and what they refer to
 * may change from step to step: nothing of them is kept.
 *
 * How it works.  Predict and update are orthogonal maps of the coordinates of the root S
 * (smoother.h).  A lag keeps, of each of L steps, the filtered state and the map
 *     xi_t = J xi_t+1 + d + E zeta,    zeta ~ N(0, I), J J' + E E' <= I
 * and composes maps beforehand, two at most a predict, so that the cost of a sample does not
 * depend on L, and no sample costs much more than another.  Nothing is inverted or subtracted: the
 * covariance is positive semi-definite.
 *
 * Sources: Rauch, Tung and Striebel, Maximum likelihood estimates of linear dynamic systems, AIAA
 * J. 3 (1965); Anderson and Moore, Optimal Filtering (1979), chapter 7; of the composition of maps
 * beforehand: Tangwongsan, Hirzel and Schneider, Low-latency sliding-window aggregation in
 * worst-case constant time, DEBS 2017.
 */
#ifndef KALMANQ_LAG_H
#define KALMANQ_LAG_H

#include "smoother.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * Words of memory: of a map; of what is of the current step (workspace, records of m
 * measurements, and the answer); of a lag.
 *   n   states, 1..16
 *   m   the most scalar measurements of one step, of all sensors together, at least 1
 *   L   the longest lag, 0 or more
 * Each of the L steps takes 2.5 n^2 + 3.5 n words in f32; bytes at L = 10 and (n, m) = (2,1),
 * (4,2), (9,3): 992, 3232, 14220.
 */
#define KQ_PRIVATE_LAG_COLUMNS_LEN(n) (5 * (n) * (n))
#define KQ_PRIVATE_MAP_LEN_F32(n) (2 * (n) * (n) + (n))
#define KQ_PRIVATE_ON_LINE_LEN_F32(n, m)                                                           \
    (KQ_PRIVATE_HISTORY_WORKSPACE_LEN(n) + (kq_length)(m) * ((kq_length)(n) + 3) + KQ_FILTER_LEN_F32((size_t)(n)))
#define KQ_PRIVATE_LAG_STEP_LEN_F32(n) (KQ_FILTER_LEN_F32((size_t)(n)) + KQ_PRIVATE_MAP_LEN_F32((size_t)(n)))
#define KQ_LAG_LEN_F32(n, m, L)                                                                    \
    ((kq_length)(L)*KQ_PRIVATE_LAG_STEP_LEN_F32(n) + KQ_PRIVATE_ON_LINE_LEN_F32(n, m) +            \
     KQ_PRIVATE_LAG_COLUMNS_LEN((size_t)(n)) + 2 * KQ_PRIVATE_MAP_LEN_F32((size_t)(n)))
#define KQ_PRIVATE_MAP_LEN_F64(n) (2 * (n) * (n) + (n))
#define KQ_PRIVATE_ON_LINE_LEN_F64(n, m)                                                           \
    (KQ_PRIVATE_HISTORY_WORKSPACE_LEN(n) + (kq_length)(m) * ((kq_length)(n) + 3) + KQ_FILTER_LEN_F64((size_t)(n)))
#define KQ_PRIVATE_LAG_STEP_LEN_F64(n) (KQ_FILTER_LEN_F64((size_t)(n)) + KQ_PRIVATE_MAP_LEN_F64((size_t)(n)))
#define KQ_LAG_LEN_F64(n, m, L)                                                                    \
    ((kq_length)(L)*KQ_PRIVATE_LAG_STEP_LEN_F64(n) + KQ_PRIVATE_ON_LINE_LEN_F64(n, m) +            \
     KQ_PRIVATE_LAG_COLUMNS_LEN((size_t)(n)) + 2 * KQ_PRIVATE_MAP_LEN_F64((size_t)(n)))

/* The fields are the library's (see process.h). */
typedef struct kq_lag_f32 {
    union {
        kq_history_f32 tape; /* of the current step; its memory is all of the memory */
        struct kq_attached_f32 attached;
    };
    uint8_t smoothed;    /* there is an answer */
    uint8_t columns;     /* of the root of its covariance, 0: the mean alone */
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
        kq_history_f64 tape;
        struct kq_attached_f64 attached;
    };
    uint8_t smoothed;
    uint8_t columns;
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
        0,                                                                                         \
        0,                                                                                         \
        L,                                                                                         \
        0,                                                                                         \
        0,                                                                                         \
        0,                                                                                         \
        0,                                                                                         \
        0}
#define KQ_LAG_F64(name, n, m, L)                                                                  \
    static double name##_memory[KQ_LAG_LEN_F64(n, m, L)];                                          \
    static kq_lag_f64 name = {                                                                     \
        {{{&kq_lag_hooks_f64}, n, 0, 0, 0, 0, 0, KQ_PRIVATE_ON_LINE_LEN_F64(n, m), 0, name##_memory, NULL, NULL, 0}}, \
        0,                                                                                         \
        0,                                                                                         \
        L,                                                                                         \
        0,                                                                                         \
        0,                                                                                         \
        0,                                                                                         \
        0,                                                                                         \
        0}

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
 * Begins: no step can be asked for but the current one.  A lag takes the place of the filter's
 * history, and a filter has one: after kq_filter_init, or with another lag or history, the lag is
 * not attached any more.  Who has to outlive whom is as in kq_attach: lag and filter each
 * other, until the lag is detached.
 *     From then on a predict is a step more for the lag, too.  Cost beside kq_predict: about 9 n^3 +
 * 4 m n^2 multiplications, 2n square roots and as many divisions at most, whatever L is; the stack
 * does not depend on n, since the scratch is in the lag's memory.
 *     A lag never stops its filter.  More than m measurements in a step
 * set KQ_EVENT_HISTORY_FULL in the filter, which goes on by itself: attach the lag again.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY (filter), KQ_ERR_SIZE or KQ_ERR_MEMORY (a lag that was never
 * given them), KQ_ERR_MISMATCH (states), KQ_ERR_RECORDING (it has another filter, or an adaptation or a
 * settling is attached to f: detach it).
 */

/** How far back can be asked: the lesser of L and the steps made since the lag was attached.  0
    where it is not attached, or cannot go on (which kq_lag_smooth then answers). */
size_t kq_lag_steps_f32(const kq_lag_f32 *lag);
size_t kq_lag_steps_f64(const kq_lag_f64 *lag);

/**
 * The state of k steps ago given all measurements so far; the functions below read it, until the
 * next call.  The filter and what can be asked for do not change.
 *   k        0 .. kq_lag_steps()
 * Cost for k = L, and for k up to 4: at most about 12 n^3 multiplications, no root; for other k a
 * few of the L / 2 maps in between, 4 n^3 each.
 * Accuracy: that of the filter; to it come a few eps sigma_filtered in the mean and in sigma, as
 * in kq_smooth.
 * KQ_ERR_NULL, KQ_ERR_SIZE (k), KQ_ERR_HISTORY_EMPTY (not attached, or not any more),
 * KQ_ERR_HISTORY_FULL (a step that it could not follow: attach it again).
 */
KQ_NODISCARD kq_status kq_lag_smooth_f32(kq_lag_f32 *lag, size_t k);
KQ_NODISCARD kq_status kq_lag_smooth_f64(kq_lag_f64 *lag, size_t k);

/**
 * The mean only, of the same bits: kq_lag_sigma and kq_lag_covariance then answer NaN and
 * KQ_ERR_NOT_READY.
 * Cost: 4 n^2 multiplications where the other one has 12 n^3.
 * Errors as kq_lag_smooth.
 */
KQ_NODISCARD kq_status kq_lag_smooth_states_f32(kq_lag_f32 *lag, size_t k);
KQ_NODISCARD kq_status kq_lag_smooth_states_f64(kq_lag_f64 *lag, size_t k);

/** x_i, the low part of its word, and sqrt(P_ii) of what was smoothed last.  NaN where nothing was,
    or lag or i is bad. */
float kq_lag_mean_f32(const kq_lag_f32 *lag, int i);
double kq_lag_mean_f64(const kq_lag_f64 *lag, int i);
float kq_lag_mean_low_f32(const kq_lag_f32 *lag, int i);
double kq_lag_mean_low_f64(const kq_lag_f64 *lag, int i);
float kq_lag_sigma_f32(const kq_lag_f32 *lag, int i);
double kq_lag_sigma_f64(const kq_lag_f64 *lag, int i);

/**
 * P of what was smoothed last, exactly symmetric.
 *   P        n x n, written
 * Cost: at most 2.5 n^3 multiplications.  KQ_ERR_NULL, KQ_ERR_NOT_READY.
 */
KQ_NODISCARD kq_status kq_lag_covariance_f32(const kq_lag_f32 *lag, float *P);
KQ_NODISCARD kq_status kq_lag_covariance_f64(const kq_lag_f64 *lag, double *P);

/* ------------------------------------------------------------------ q31, as in f32
 *
 * Accuracy: to that of the filter come about 2^-27 of the filtered sigma.  Maps are kept in units
 * of 2^-29 without exponents, which no entry is above.
 * A smoothed mean that had to be held at its word sets KQ_EVENT_SATURATED in the filter, and so
 * does what smoother.h says of more than 32768 sigma.
 */

#define KQ_PRIVATE_MAP_LEN_Q31(n) (2 * (n) * (n) + 2 * (n))
#define KQ_PRIVATE_ON_LINE_LEN_Q31(n, m)                                                           \
    (KQ_PRIVATE_HISTORY_WORKSPACE_LEN_Q31(n) + (kq_length)(m) * ((kq_length)(n) + 7) +             \
     KQ_FILTER_LEN_Q31((size_t)(n)))
#define KQ_PRIVATE_LAG_STEP_LEN_Q31(n) (KQ_FILTER_LEN_Q31((size_t)(n)) + KQ_PRIVATE_MAP_LEN_Q31((size_t)(n)))
#define KQ_LAG_LEN_Q31(n, m, L)                                                                    \
    ((kq_length)(L)*KQ_PRIVATE_LAG_STEP_LEN_Q31(n) + KQ_PRIVATE_ON_LINE_LEN_Q31(n, m) +            \
     KQ_PRIVATE_LAG_COLUMNS_LEN((size_t)(n)) + 2 * KQ_PRIVATE_MAP_LEN_Q31((size_t)(n)))

/* The fields are the library's. */
typedef struct kq_lag_q31 {
    union {
        kq_history_q31 tape;
        struct kq_attached_q31 attached;
    };
    uint8_t smoothed;
    uint8_t columns;
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
        {{{&kq_lag_hooks_q31}, n, 0, 0, 0, 0, 0, KQ_PRIVATE_ON_LINE_LEN_Q31(n, m), 0, name##_memory, NULL, NULL, 0}}, \
        0,                                                                                         \
        0,                                                                                         \
        L,                                                                                         \
        0,                                                                                         \
        0,                                                                                         \
        0,                                                                                         \
        0,                                                                                         \
        0}

KQ_NODISCARD kq_status kq_lag_assign_q31(kq_lag_q31 *lag, int n, int m, size_t L, int32_t *memory, size_t length);
size_t kq_lag_steps_q31(const kq_lag_q31 *lag);
KQ_NODISCARD kq_status kq_lag_smooth_q31(kq_lag_q31 *lag, size_t k);
KQ_NODISCARD kq_status kq_lag_smooth_states_q31(kq_lag_q31 *lag, size_t k);

/** Words of the states' formats, as kq_mean_q31, kq_mean_low_q31 and kq_sigma_q31. */
int32_t kq_lag_mean_q31(const kq_lag_q31 *lag, int i);
int32_t kq_lag_mean_low_q31(const kq_lag_q31 *lag, int i);
int32_t kq_lag_sigma_q31(const kq_lag_q31 *lag, int i);
KQ_NODISCARD kq_status kq_lag_covariance_q31(const kq_lag_q31 *lag, kq_scaled_q31 *P);

#ifdef __cplusplus
}
#endif
#endif
