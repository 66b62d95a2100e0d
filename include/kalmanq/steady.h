/*
 * kalmanq: the steady state of a constant model, and filters that use it.
 *
 *     P- = A (P- - P- H'(H P- H' + R)^-1 H P-) A' + Q          the predicted covariance
 *     K  = P- H'(H P- H' + R)^-1                               the gain
 *     x  = x- + K (z - H x-),    x- = A x + B u                the steady-state filter
 *
 * With A, H, Q and R constant, P- and K converge, whatever the prior was.
 *
 *     kq_steady_solve   solves the equation: P-, P, K, the smoother's gain (f32, f64; q31: on the host, then
 *                       kq_matrix_prepare_q31)
 *     kq_steady         a filter of the mean only, with gains that you give it
 *     kq_freeze         an ordinary filter that stops its covariance work while that is steady
 *
 * A steady state exists if every state that does not decay by itself (|eigenvalue of A| >= 1) is measured
 * (detectable) and moved by the noise (stabilisable).
 */
#ifndef KALMANQ_STEADY_H
#define KALMANQ_STEADY_H

#include "filter.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Words of scratch for kq_steady_solve: 200 at n, m = 4, 2 in f32. */
#define KQ_STEADY_SOLVE_LEN_F32(n, m) \
    (KQ_PRIVATE_STEADY_SQUARES_LEN((size_t)(n), (size_t)(m)) + (size_t)KQ_FILTER_LEN_F32(n))
#define KQ_STEADY_SOLVE_LEN_F64(n, m) \
    (KQ_PRIVATE_STEADY_SQUARES_LEN((size_t)(n), (size_t)(m)) + (size_t)KQ_FILTER_LEN_F64(n))
#define KQ_PRIVATE_STEADY_SQUARES_LEN(n, m) \
    ((n) * (7 * (n) + 2 * (m) + 2 + ((n) > (m) ? (n) : (m))) + 3 * KQ_TRIANGLE(n))

/** What kq_steady_solve writes; each pointer may be NULL. */
typedef struct {
    float *predicted;     /* n x n: P-, exactly symmetric */
    float *filtered;      /* n x n: P = P- - K H P- */
    float *gain;          /* n x m: K */
    float *smoother_gain; /* n x n: G = P A' (P-)^-1, the pseudo-inverse where P- is singular */
} kq_steady_solution_f32;
typedef struct { double *predicted, *filtered, *gain, *smoother_gain; } kq_steady_solution_f64;

/** Solves the equation.
 *   p        read
 *   s        read; R may be correlated, singular or 0
 *   memory   `length` words, scratch
 *   length   KQ_STEADY_SOLVE_LEN_<T>(n, m) or more
 *   out      read; its arrays are written
 * P- is positive semi-definite by construction.
 * Accuracy: about eps / (1 - rho), relative to sqrt(P_ii P_jj), rho the largest |eigenvalue| of A (I - K H).  A mode
 * with 1 - rho below 2^-20 (f32), 2^-48 (f64) counts as lasting for ever.
 * Cost: about 40 n^3 multiplications a doubling; 4 + log2 T doublings for a state that is forgotten in T steps, and
 * as many for each step of Newton's.  Stack: 300 words.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_MISMATCH (states), KQ_ERR_MEMORY, KQ_ERR_NOT_DETECTABLE,
 * KQ_ERR_NOT_STABILISABLE (if both hold, either), KQ_ERR_NO_CONVERGENCE (not representable; or a noise-free sensor
 * with transmission zeros on the unit circle: there is a limit, but the filter does not forget). */
KQ_NODISCARD kq_status kq_steady_solve_f32(const kq_process_f32 *p, const kq_sensor_f32 *s, float *memory,
    size_t length, const kq_steady_solution_f32 *out);
KQ_NODISCARD kq_status kq_steady_solve_f64(const kq_process_f64 *p, const kq_sensor_f64 *s, double *memory,
    size_t length, const kq_steady_solution_f64 *out);

/** The largest `bits` of kq_freeze_init; above it there is only rounding. */
#define KQ_FREEZE_BITS_MAX_F32 18
#define KQ_FREEZE_BITS_MAX_F64 46
#define KQ_FREEZE_BITS_MAX_Q31 24

/** Length of a steady-state filter's memory, in words: the mean. */
#define KQ_STEADY_LEN_F32(n) (n)
#define KQ_STEADY_LEN_F64(n) (n)

/* The fields are the library's (see process.h). */
typedef struct {
    uint8_t states, components; /* n; m */
    uint8_t events;
    uint8_t length; /* words at memory */
    uint16_t plain; /* n + 256 m, and 128 where A is upper triangular; 0 before the last gain */
    float *memory; /* the caller's: the mean */
    const float *gain; /* of the next update; NULL until initialised */
    size_t left; /* gains behind it */
    const kq_process_f32 *process; const kq_sensor_f32 *sensor;
} kq_steady_f32;
typedef struct {
    uint8_t states, components, events, length; uint16_t plain; double *memory; const double *gain;
    size_t left; const kq_process_f64 *process; const kq_sensor_f64 *sensor;
} kq_steady_f64;

/** Declares a steady-state filter `name` of n states and m components with its static memory. */
#define KQ_STEADY_F32(name, n, m) \
    static float name##_memory[KQ_STEADY_LEN_F32(n)]; \
    static kq_steady_f32 name = {n, m, 0, KQ_STEADY_LEN_F32(n), 0, name##_memory, NULL, 0, NULL, NULL}
#define KQ_STEADY_F64(name, n, m) \
    static double name##_memory[KQ_STEADY_LEN_F64(n)]; \
    static kq_steady_f64 name = {n, m, 0, KQ_STEADY_LEN_F64(n), 0, name##_memory, NULL, 0, NULL, NULL}

/** Sets sizes and memory at run time.
 *   st       written
 *   n        1..16 states
 *   m        1..16 components
 *   memory   `length` words, yours while in use
 *   length   KQ_STEADY_LEN_<T>(n) or more
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY. */
KQ_NODISCARD kq_status kq_steady_assign_f32(kq_steady_f32 *st, int n, int m, float *memory, size_t length);
KQ_NODISCARD kq_status kq_steady_assign_f64(kq_steady_f64 *st, int n, int m, double *memory, size_t length);

/** Sets the model, the mean and the gains.
 *   st       has sizes and memory; written
 *   p        kept by reference.  You must not change it; after a change call this again
 *   s        likewise
 *   x0       n; copied
 *   gains    count x n x m, kept by reference, may be in flash.  Update t takes gain t, later ones the last
 *   count    1 .. KQ_COUNT_MAX; 1: the steady gain only
 * KQ_ERR_NULL, KQ_ERR_SIZE (count, or never assigned), KQ_ERR_MEMORY, KQ_ERR_NOT_READY (p, s), KQ_ERR_MISMATCH
 * (sizes; s takes innovations), KQ_ERR_NOT_FINITE.  Cost: a comparison for each number. */
KQ_NODISCARD kq_status kq_steady_init_f32(kq_steady_f32 *st, const kq_process_f32 *p, const kq_sensor_f32 *s,
    const float *x0, const float *gains, size_t count);
KQ_NODISCARD kq_status kq_steady_init_f64(kq_steady_f64 *st, const kq_process_f64 *p, const kq_sensor_f64 *s,
    const double *x0, const double *gains, size_t count);

/** predict   x <- A x + B u
 * update    x <- x + K (z - H x)        also by a correlated sensor
 * step      predict, then update. Refused as a whole
 *   st       changed
 *   u        l, or NULL: no control
 *   z        m
 * If a measurement is missing, only predict: the estimate stays unbiased, the next gain is too small.
 * Accuracy: the mean is one number in f32, rounded at its size: about eps |x| / (1 - rho) adds up, and a correction K
 * e below eps |x| / 2 is lost.  If sigma is below 1e-5 of the state's range, take kq_freeze, f64 or q31.  A gain
 * within 2^-b of the steady one moves the mean by about 2^-b |e| / (1 - rho)^2.
 * Cost: n^2 + 2 n m multiplications, n (n + 1) / 2 + 2 n m for an upper triangular A.  Stack: 54 words.
 * kq_fixed_steady_step (src/fixed_size/kq_fixed_<T>.h) takes fewer.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_NOT_FINITE (u, z; overflow: call kq_steady_init). */
KQ_NODISCARD kq_status kq_steady_predict_f32(kq_steady_f32 *st, const float *u);
KQ_NODISCARD kq_status kq_steady_predict_f64(kq_steady_f64 *st, const double *u);
KQ_NODISCARD kq_status kq_steady_update_f32(kq_steady_f32 *st, const float *z);
KQ_NODISCARD kq_status kq_steady_update_f64(kq_steady_f64 *st, const double *z);
KQ_NODISCARD kq_status kq_steady_step_f32(kq_steady_f32 *st, const float *u, const float *z);
KQ_NODISCARD kq_status kq_steady_step_f64(kq_steady_f64 *st, const double *u, const double *z);

/** x_i, in the state's unit.
 *   st       read
 *   i        0 .. n-1
 * NaN if st or i is bad. */
float kq_steady_mean_f32(const kq_steady_f32 *st, int i);
double kq_steady_mean_f64(const kq_steady_f64 *st, int i);

/** e = z - H x.  Call it before the update.
 *   st       read
 *   z        m, in the sensor's units
 *   e        m, written; may be z
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_NOT_FINITE (z, or e overflows).  Cost: m n multiplications. */
KQ_NODISCARD kq_status kq_steady_innovation_f32(const kq_steady_f32 *st, const float *z, float *e);
KQ_NODISCARD kq_status kq_steady_innovation_f64(const kq_steady_f64 *st, const double *z, double *e);

/* ------------------------------------------------------------------ steady-state detection, frozen gain
 *
 * An ordinary filter that freezes its gain in the steady state: kq_step then moves the mean only.
 *
 *     kq_attach_f32(&track, &lazy.attached);
 *     kq_update_f32(&track, &radar, z);                             the first measurement
 *     ... kq_step_f32(&track, &motion, NULL, &radar, z);            or kq_predict: no measurement
 *
 * The filter works in full again when a measurement is missing, when the process or the sensor is another
 * object, when A or Q has changed by a call (fingerprint, smoother.h), when H is another array, or when
 * anything else moved the covariance.  It does not see a new R, new numbers in H's array, or a process table
 * that was overwritten: call kq_freeze_release after these.  A frozen step judges no measurement: kq_nis,
 * kq_taken and the log-likelihoods stay as after the last full step.
 */

/** Length of a freeze's memory, in words; it also needs n x m numbers for the gain. */
#define KQ_FREEZE_LEN_F32(n) KQ_TRIANGLE(n)
#define KQ_FREEZE_LEN_F64(n) KQ_TRIANGLE(n)

typedef struct {
    struct kq_attached_f32 attached; uint8_t states, components;
    uint8_t bits, phase; /* 0: not initialised; moving, steady, keeping the gain, frozen */
    uint16_t length;
    float *memory, *gain; /* the caller's: the root of the step before; the caller's, n x m */
    const kq_process_f32 *process;
    uint32_t fingerprint; /* of the process at the last step */
    const kq_sensor_f32 *sensor; const float *measurement;
    kq_filter_f32 *filter; /* attached to */
} kq_freeze_f32;
extern const struct kq_hooks_f32 kq_freeze_hooks_f32; /* what it does in the steps */
typedef struct {
    struct kq_attached_f64 attached; uint8_t states, components, bits, phase; uint16_t length;
    double *memory, *gain; const kq_process_f64 *process; uint32_t fingerprint; const kq_sensor_f64 *sensor;
    const double *measurement; kq_filter_f64 *filter;
} kq_freeze_f64;
extern const struct kq_hooks_f64 kq_freeze_hooks_f64;

/** Declares a freeze `name` for n states and m components with its static memory. */
#define KQ_FREEZE_F32(name, n, m) \
    static float name##_memory[KQ_FREEZE_LEN_F32(n)], name##_gain[(n) * (m)]; \
    static kq_freeze_f32 name = { {&kq_freeze_hooks_f32}, n, m, 0, 0, KQ_FREEZE_LEN_F32(n), name##_memory, \
        name##_gain, NULL, 0, NULL, NULL, NULL}
#define KQ_FREEZE_F64(name, n, m) \
    static double name##_memory[KQ_FREEZE_LEN_F64(n)], name##_gain[(n) * (m)]; \
    static kq_freeze_f64 name = { {&kq_freeze_hooks_f64}, n, m, 0, 0, KQ_FREEZE_LEN_F64(n), name##_memory, \
        name##_gain, NULL, 0, NULL, NULL, NULL}

/** Sets sizes and memory at run time.
 *   w        written
 *   n        1..16 states
 *   m        1..16 components
 *   memory   `length` words, yours while in use
 *   length   KQ_FREEZE_LEN_<T>(n) or more
 *   gain     n x m numbers, yours while in use
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY. */
KQ_NODISCARD kq_status kq_freeze_assign_f32(kq_freeze_f32 *w, int n, int m, float *memory, size_t length,
    float *gain);
KQ_NODISCARD kq_status kq_freeze_assign_f64(kq_freeze_f64 *w, int n, int m, double *memory, size_t length,
    double *gain);

/** Sets when the filter counts as steady; it is not frozen.
 *   w        has sizes and memory; written
 *   bits     1 .. KQ_FREEZE_BITS_MAX_<T>: steady is a step that changes each row of the filtered root by at most
 *            2^-bits of its norm.  The gain is then within about 2^-bits / (1 - rho^2) of the steady one.  10 costs
 *            less than 1 % of the innovation's variance for rho below 0.9
 * KQ_ERR_NULL, KQ_ERR_SIZE (bits, or never assigned), KQ_ERR_MEMORY. */
KQ_NODISCARD kq_status kq_freeze_init_f32(kq_freeze_f32 *w, int bits);
KQ_NODISCARD kq_status kq_freeze_init_f64(kq_freeze_f64 *w, int bits);

/*
 * kq_attach (filter.h): from now on kq_step of the filter by a sensor of m components may be frozen.  kq_predict and
 * kq_update by themselves are the filter's own, and end a frozen phase.  Attach nothing else.
 * Cost of kq_step: frozen, n^2 + 2 n m multiplications and n^2 comparisons; otherwise n^2 more than kq_step, and once
 * kq_gain before it freezes.  kq_step also answers KQ_ERR_MISMATCH (a sensor of other than m components).
 */

/** 1 if the last step was frozen.
 *   w        read; 0 for NULL */
int kq_freeze_is_active_f32(const kq_freeze_f32 *w);
int kq_freeze_is_active_f64(const kq_freeze_f64 *w);

/** Ends the frozen phase: the next steps are full until the filter is steady again.  Call it after a sensor has got
 * new numbers.
 *   w        changed
 * KQ_ERR_NULL, KQ_ERR_NOT_READY. */
KQ_NODISCARD kq_status kq_freeze_release_f32(kq_freeze_f32 *w);
KQ_NODISCARD kq_status kq_freeze_release_f64(kq_freeze_f64 *w);

/* ------------------------------------------------------------------ q31, as f32
 *
 * Solve the equation in f64 and prepare K by kq_matrix_prepare_q31 with the formats of states and
 * measurements (prepare.h).  Means, measurements and gains are in raw values of their formats.
 */

/** Length of the memory, in words: the mean in 32 + 24 bits. */
#define KQ_STEADY_LEN_Q31(n) (2 * (n))

typedef struct {
    uint8_t states, components, events, length; uint16_t plain; int32_t *memory; const kq_scaled_q31 *gain;
    size_t left; const kq_process_q31 *process; const kq_sensor_q31 *sensor;
} kq_steady_q31;

#define KQ_STEADY_Q31(name, n, m) \
    static int32_t name##_memory[KQ_STEADY_LEN_Q31(n)]; \
    static kq_steady_q31 name = {n, m, 0, KQ_STEADY_LEN_Q31(n), 0, name##_memory, NULL, 0, NULL, NULL}

/** As kq_steady_assign_f32. */
KQ_NODISCARD kq_status kq_steady_assign_q31(kq_steady_q31 *st, int n, int m, int32_t *memory, size_t length);

/** As kq_steady_init_f32.  KQ_ERR_RANGE (x0 outside its declared range), KQ_ERR_COEFFICIENT (a gain that is not
 * normalised, or an exponent beyond its limit), KQ_ERR_MISMATCH (formats of the states, too). */
KQ_NODISCARD kq_status kq_steady_init_q31(kq_steady_q31 *st, const kq_process_q31 *p, const kq_sensor_q31 *s,
    const int32_t *x0, const kq_scaled_q31 *gains, size_t count);

/** As f32; KQ_ERR_RANGE (u, z).  A mean saturates at its raw value, with KQ_EVENT_SATURATED; so does a part K_ic e_c
 * of more than 8 times the largest raw value, but not the sum of the parts.
 * Accuracy: each product with a coefficient other than 1 is rounded to 2^-24 of a raw value, the innovation truncated
 * to 30 bits. */
KQ_NODISCARD kq_status kq_steady_predict_q31(kq_steady_q31 *st, const int32_t *u);
KQ_NODISCARD kq_status kq_steady_update_q31(kq_steady_q31 *st, const int32_t *z);
KQ_NODISCARD kq_status kq_steady_step_q31(kq_steady_q31 *st, const int32_t *u, const int32_t *z);

/** Reads and clears the events, KQ_EVENT_...
 *   st       read; kq_steady_events_clear changes it.  0 for NULL */
unsigned kq_steady_events_q31(const kq_steady_q31 *st);
void kq_steady_events_clear_q31(kq_steady_q31 *st);

/** As kq_steady_mean_f32: x_i rounded to a raw value, and what the rounding left, in 2^-24 of a raw value.
 * KQ_NOT_A_VALUE_Q31 if st or i is bad. */
int32_t kq_steady_mean_q31(const kq_steady_q31 *st, int i);
int32_t kq_steady_mean_low_q31(const kq_steady_q31 *st, int i);

/** As kq_steady_innovation_f32: e in raw values of the measurement, saturated at +-(2^31 - 1).  KQ_ERR_RANGE (z). */
KQ_NODISCARD kq_status kq_steady_innovation_q31(const kq_steady_q31 *st, const int32_t *z, int32_t *e);

#define KQ_FREEZE_LEN_Q31(n) KQ_ROOT_LEN_Q31(n)

typedef struct {
    struct kq_attached_q31 attached; uint8_t states, components, bits, phase; uint16_t length;
    int32_t *memory; kq_scaled_q31 *gain; const kq_process_q31 *process; uint32_t fingerprint;
    const kq_sensor_q31 *sensor; const kq_scaled_q31 *measurement; kq_filter_q31 *filter;
} kq_freeze_q31;
extern const struct kq_hooks_q31 kq_freeze_hooks_q31;

#define KQ_FREEZE_Q31(name, n, m) \
    static int32_t name##_memory[KQ_FREEZE_LEN_Q31(n)]; \
    static kq_scaled_q31 name##_gain[(n) * (m)]; \
    static kq_freeze_q31 name = { {&kq_freeze_hooks_q31}, n, m, 0, 0, KQ_FREEZE_LEN_Q31(n), name##_memory, \
        name##_gain, NULL, 0, NULL, NULL, NULL}

/** As kq_freeze_assign_f32, kq_freeze_init_f32, kq_freeze_is_active_f32 and kq_freeze_release_f32. */
KQ_NODISCARD kq_status kq_freeze_assign_q31(kq_freeze_q31 *w, int n, int m, int32_t *memory, size_t length,
    kq_scaled_q31 *gain);
KQ_NODISCARD kq_status kq_freeze_init_q31(kq_freeze_q31 *w, int bits);
int kq_freeze_is_active_q31(const kq_freeze_q31 *w);
KQ_NODISCARD kq_status kq_freeze_release_q31(kq_freeze_q31 *w);

#ifdef __cplusplus
}
#endif
#endif
