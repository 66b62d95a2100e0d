/*
 * kalmanq: the fixed-point smoother, one chosen instant, refined as data come in.
 *
 *     x_s|t,  P_s|t        s fixed, t = s, s + 1, ...
 *
 * The instant is that of the filter when the POINT is attached to it: the start of a run, a launch,
 * an alarm.  The memory does not depend on the number of steps.  kq_smooth over a tape of the run
 * would say the same of that step, up to rounding.
 *
 *     kq_attach_f32(&track, &start.attached);
 *     for (;;) {
 *         kq_update_f32(&track, &ranger, &z);
 *         if (kq_point_smooth_f32(&start) == KQ_OK)
 *             ... kq_point_mean_f32(&start, i), kq_point_sigma_f32(&start, i)
 *         kq_predict_f32(&track, &motion, NULL);
 *     }
 *
 * The filter is, bit for bit, what it is without a point.  Processes, sensors and what they refer
 * to may change from step to step: nothing of them is kept.
 *
 * How it works.  The map of the coordinates of the root (smoother.h, lag.h),
 *     xi_s = C xi_t + c + E zeta,    zeta ~ N(0, I),    x_s = x_f(s) + S_s xi_s
 * goes forwards with each step: C <- C J, c <- c + C d, E <- tria [E, C Theta12].  Nothing is
 * inverted or subtracted: the covariance is positive semi-definite, and C, a contraction, fades.
 *
 * Sources: Rauch, Tung and Striebel, Maximum likelihood estimates of linear dynamic systems, AIAA
 * J. 3 (1965); Anderson and Moore, Optimal Filtering (1979), chapter 7.
 */
#ifndef KALMANQ_POINT_H
#define KALMANQ_POINT_H

#include "lag.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * Words of memory of a point.
 *   n   states, 1..16
 *   m   the most scalar measurements of one step, of all sensors together, at least 1
 */
#define KQ_PRIVATE_POINT_COLUMNS_LEN(n) (2 * (n) * (n))
#define KQ_POINT_LEN_F32(n, m)                                                                     \
    (KQ_PRIVATE_ON_LINE_LEN_F32(n, m) + KQ_PRIVATE_POINT_COLUMNS_LEN((size_t)(n)) +                \
     KQ_FILTER_LEN_F32((size_t)(n)) + 2 * KQ_PRIVATE_MAP_LEN_F32((size_t)(n)))
#define KQ_POINT_LEN_F64(n, m)                                                                     \
    (KQ_PRIVATE_ON_LINE_LEN_F64(n, m) + KQ_PRIVATE_POINT_COLUMNS_LEN((size_t)(n)) +                \
     KQ_FILTER_LEN_F64((size_t)(n)) + 2 * KQ_PRIVATE_MAP_LEN_F64((size_t)(n)))

/* The fields are the library's (see process.h). */
typedef struct kq_point_f32 {
    union {
        kq_history_f32 tape; /* of the current step; its memory is all of the memory */
        struct kq_attached_f32 attached;
    };
    uint8_t columns;     /* of the root of the answer's covariance, 0: there is no answer */
} kq_point_f32;

extern const struct kq_hooks_f32 kq_point_hooks_f32; /* what it does in the steps */

typedef struct kq_point_f64 {
    union {
        kq_history_f64 tape;
        struct kq_attached_f64 attached;
    };
    uint8_t columns;
} kq_point_f64;

extern const struct kq_hooks_f64 kq_point_hooks_f64;

/** A point `name` with its storage, in static memory: for n states, at most m scalar
    measurements a step. */
#define KQ_POINT_F32(name, n, m)                                                                   \
    static float name##_memory[KQ_POINT_LEN_F32(n, m)];                                            \
    static kq_point_f32 name = {                                                                   \
        {{{&kq_point_hooks_f32}, n, 0, 0, 0, 0, 0, KQ_PRIVATE_ON_LINE_LEN_F32(n, m), 0, name##_memory, NULL, NULL, 0}}, 0}
#define KQ_POINT_F64(name, n, m)                                                                   \
    static double name##_memory[KQ_POINT_LEN_F64(n, m)];                                           \
    static kq_point_f64 name = {                                                                   \
        {{{&kq_point_hooks_f64}, n, 0, 0, 0, 0, 0, KQ_PRIVATE_ON_LINE_LEN_F64(n, m), 0, name##_memory, NULL, NULL, 0}}, 0}

/**
 * Sizes and memory known at run time only (the macros do the same at compile time).
 *   point    written
 *   length   words at memory: KQ_POINT_LEN_<T>(n, m)
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY.
 */
KQ_NODISCARD kq_status kq_point_assign_f32(kq_point_f32 *point, int n, int m, float *memory, size_t length);
KQ_NODISCARD kq_status kq_point_assign_f64(kq_point_f64 *point, int n, int m, double *memory, size_t length);

/*
 * The state as it is, updates made or not, is the one to refine.  A point takes the place of the
 * filter's history, and a filter has one: after kq_filter_init, or with another point, lag or
 * history, the point is not attached any more.  Who has to outlive whom is as in kq_attach:
 * point and filter each other, until the point is detached.
 *     Cost of a predict from then on, beside kq_predict: about 5 n^3 + 4 m n^2 multiplications, n square
 * roots and as many divisions.  A point never stops its filter.  More than m measurements in a
 * step set KQ_EVENT_HISTORY_FULL in the filter: the instant is lost.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY (filter), KQ_ERR_SIZE or KQ_ERR_MEMORY (a point that was never
 * given them), KQ_ERR_MISMATCH (states), KQ_ERR_RECORDING (it has another filter, or an adaptation or a
 * settling is attached to f: detach it).
 */

/**
 * The instant's state given all measurements so far; the functions below read it, until the
 * next call.  The filter does not change.
 * Cost: n^3 + n^2 multiplications.
 * Accuracy: that of the filter; to it come a few eps sigma_filtered in the mean and in sigma.
 * KQ_ERR_NULL, KQ_ERR_HISTORY_EMPTY (not attached, or not any more), KQ_ERR_HISTORY_FULL (the instant is
 * lost).
 */
KQ_NODISCARD kq_status kq_point_smooth_f32(kq_point_f32 *point);
KQ_NODISCARD kq_status kq_point_smooth_f64(kq_point_f64 *point);

/** x_i, the low part of its word, and sqrt(P_ii) of the instant when it was smoothed last.  NaN
   where it was not, or point or i is bad. */
float kq_point_mean_f32(const kq_point_f32 *point, int i);
double kq_point_mean_f64(const kq_point_f64 *point, int i);
float kq_point_mean_low_f32(const kq_point_f32 *point, int i);
double kq_point_mean_low_f64(const kq_point_f64 *point, int i);
float kq_point_sigma_f32(const kq_point_f32 *point, int i);
double kq_point_sigma_f64(const kq_point_f64 *point, int i);

/**
 * P of it, exactly symmetric.
 *   P        n x n, written
 * Cost: n^3 multiplications.  KQ_ERR_NULL, KQ_ERR_NOT_READY (not smoothed).
 */
KQ_NODISCARD kq_status kq_point_covariance_f32(const kq_point_f32 *point, float *P);
KQ_NODISCARD kq_status kq_point_covariance_f64(const kq_point_f64 *point, double *P);

/* ------------------------------------------------------------------ q31, as in f32
 *
 * Events as lag.h says.
 */

#define KQ_POINT_LEN_Q31(n, m)                                                                     \
    (KQ_PRIVATE_ON_LINE_LEN_Q31(n, m) + KQ_PRIVATE_POINT_COLUMNS_LEN((size_t)(n)) +                \
     KQ_FILTER_LEN_Q31((size_t)(n)) + 2 * KQ_PRIVATE_MAP_LEN_Q31((size_t)(n)))

/* The fields are the library's. */
typedef struct kq_point_q31 {
    union {
        kq_history_q31 tape;
        struct kq_attached_q31 attached;
    };
    uint8_t columns;
} kq_point_q31;

extern const struct kq_hooks_q31 kq_point_hooks_q31;

#define KQ_POINT_Q31(name, n, m)                                                                   \
    static int32_t name##_memory[KQ_POINT_LEN_Q31(n, m)];                                          \
    static kq_point_q31 name = {                                                                   \
        {{{&kq_point_hooks_q31}, n, 0, 0, 0, 0, 0, KQ_PRIVATE_ON_LINE_LEN_Q31(n, m), 0, name##_memory, NULL, NULL, 0}}, 0}

KQ_NODISCARD kq_status kq_point_assign_q31(kq_point_q31 *point, int n, int m, int32_t *memory, size_t length);
KQ_NODISCARD kq_status kq_point_smooth_q31(kq_point_q31 *point);

/** Words of the states' formats, as kq_mean_q31, kq_mean_low_q31 and kq_sigma_q31. */
int32_t kq_point_mean_q31(const kq_point_q31 *point, int i);
int32_t kq_point_mean_low_q31(const kq_point_q31 *point, int i);
int32_t kq_point_sigma_q31(const kq_point_q31 *point, int i);
KQ_NODISCARD kq_status kq_point_covariance_q31(const kq_point_q31 *point, kq_scaled_q31 *P);

#ifdef __cplusplus
}
#endif
#endif
