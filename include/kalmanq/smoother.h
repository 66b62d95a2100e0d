/*
 * kalmanq: the fixed-interval smoother (Rauch, Tung and Striebel): every past state given all measurements.
 *
 *     x_t|T = x + G (x_t+1|T - x-_{t+1})       G = P A' (P-_{t+1})^-1
 *     P_t|T = P + G (P_t+1|T - P-_{t+1}) G'    Cov(x_t+1, x_t | T) = P_t+1|T G'
 *
 * The smoother runs the orthogonal maps of predict and update backwards on the root S.  It inverts nothing, so P- may
 * be singular.  P_t|T is positive semi-definite and never above the filtered P.
 *
 *     kq_attach_f32(&track, &tape.attached);     a history records predicts and updates of its filter
 *     ... updates and predicts ...
 *     kq_smooth_f32(&tape);                      in place
 *     kq_filter_f32 view;                        without memory
 *     kq_smoothed_f32(&tape, t, &view);          step t: after the t-th predict, 0 .. kq_history_steps() - 1
 *     kq_mean_f32(&view, i);   kq_sigma_f32(&view, i);   kq_covariance_f32(&view, P);
 *
 * A history refers to the processes by pointer and keeps a fingerprint of A and Q of each.  Smoothing refuses a
 * process that is not what it was (KQ_ERR_CHANGED).  You may change a process and change it back, but not between two
 * predicts of the recording.  If A changes at every step, attach a kq_jacobians (extended.h), pass each process to
 * kq_smooth_step, or smooth while the filter runs (lag.h, instant.h).  A changed process is missed with a probability
 * of 2^-31, and always if you write its arrays without a call.  Sensors may change.
 */
#ifndef KALMANQ_SMOOTHER_H
#define KALMANQ_SMOOTHER_H

#include "filter.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Length of a history's memory, in words.
 *   n, m     states; the most scalar measurements of one step, all sensors together
 *   steps    predicts and 1: the state at attach is step 0
 *   changes  predicts by another process than the predict before
 * One step in f32: 44, 116, 376 bytes at (n, m) = (2, 1), (4, 2), (9, 3). */
#define KQ_PRIVATE_HISTORY_STEP_LEN_F32(n, m) \
    (KQ_FILTER_LEN_F32((size_t)(n)) + 1 + (kq_length)(m) * ((kq_length)(n) + 1))
#define KQ_PRIVATE_HISTORY_STEP_LEN_F64(n, m) \
    (KQ_FILTER_LEN_F64((size_t)(n)) + 1 + (kq_length)(m) * ((kq_length)(n) + 1))
#define KQ_PRIVATE_HISTORY_CHANGE_LEN_F32 \
    ((sizeof(void *) + sizeof(uint32_t) + sizeof(float) - 1) / sizeof(float))
#define KQ_PRIVATE_HISTORY_CHANGE_LEN_F64 \
    ((sizeof(void *) + sizeof(uint32_t) + sizeof(double) - 1) / sizeof(double))
#define KQ_PRIVATE_HISTORY_WORKSPACE_LEN(n) (((size_t)(n)*3 + 4) * (size_t)(n) + 2 * KQ_TRIANGLE((size_t)(n)))
#define KQ_HISTORY_LEN_F32(n, m, steps, changes) \
    ((kq_length)(steps)*KQ_PRIVATE_HISTORY_STEP_LEN_F32(n, m) + \
        (kq_length)(changes)*KQ_PRIVATE_HISTORY_CHANGE_LEN_F32 + KQ_PRIVATE_HISTORY_WORKSPACE_LEN(n))
#define KQ_HISTORY_LEN_F64(n, m, steps, changes) \
    ((kq_length)(steps)*KQ_PRIVATE_HISTORY_STEP_LEN_F64(n, m) + \
        (kq_length)(changes)*KQ_PRIVATE_HISTORY_CHANGE_LEN_F64 + KQ_PRIVATE_HISTORY_WORKSPACE_LEN(n))

/* The fields are the library's (see process.h). */
typedef struct kq_history_f32 {
    struct kq_attached_f32 attached;
    uint8_t states, phase; /* n; unused, recording, full, smoothing */
    uint16_t records; /* measurements recorded since the last predict */
    uint32_t steps; /* steps recorded; the last one is closed by smoothing */
    uint32_t step; /* smoothing: steps at and above this one are done */
    uint32_t fingerprint; /* of the process, when it was recorded */
    size_t length, used; /* words at memory; words of the tape not yet smoothed */
    float *memory; /* the caller's: workspace, then tape */
    const kq_process_f32 *process; /* of the step at the tape's end */
    kq_filter_f32 *filter; /* attached to */
    uint8_t events; /* KQ_EVENT_... */
    uint32_t rounding; /* that the measurements have left, in squares */
} kq_history_f32;
extern const struct kq_hooks_f32 kq_history_hooks_f32; /* what it does in the steps */
typedef struct kq_history_f64 {
    struct kq_attached_f64 attached; uint8_t states, phase; uint16_t records;
    uint32_t steps, step, fingerprint; size_t length, used; double *memory; const kq_process_f64 *process;
    kq_filter_f64 *filter; uint8_t events; uint32_t rounding;
} kq_history_f64;
extern const struct kq_hooks_f64 kq_history_hooks_f64;

/** Declares a history `name` with its static memory. */
#define KQ_HISTORY_F32(name, n, m, steps, changes) \
    static float name##_memory[KQ_HISTORY_LEN_F32(n, m, steps, changes)]; \
    static kq_history_f32 name = { {&kq_history_hooks_f32}, n, 0, 0, 0, 0, 0, KQ_HISTORY_LEN_F32(n, m, \
        steps, changes), 0, name##_memory, NULL, NULL, 0, 0}
#define KQ_HISTORY_F64(name, n, m, steps, changes) \
    static double name##_memory[KQ_HISTORY_LEN_F64(n, m, steps, changes)]; \
    static kq_history_f64 name = { {&kq_history_hooks_f64}, n, 0, 0, 0, 0, 0, KQ_HISTORY_LEN_F64(n, m, \
        steps, changes), 0, name##_memory, NULL, NULL, 0, 0}

/** Sets sizes and memory at run time.
 *   h        written
 *   n        1..16 states
 *   memory   `length` words, yours while in use
 *   length   KQ_HISTORY_LEN_<T>(n, m, steps, changes), at least for one step
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY. */
KQ_NODISCARD kq_status kq_history_assign_f32(kq_history_f32 *h, int n, float *memory, size_t length);
KQ_NODISCARD kq_status kq_history_assign_f64(kq_history_f64 *h, int n, double *memory, size_t length);

/*
 * kq_attach (filter.h) empties the history and starts the recording; the present state is step 0.  With a diffuse
 * start recording begins when all components are determined.  kq_filter_init and kq_filter_assign of the filter, and
 * kq_history_assign, end it.  kq_detach keeps only what is smoothed.
 */

/** Recorded steps: predicts since kq_attach, plus 1.
 *   h        read; 0 if it is empty or NULL */
size_t kq_history_steps_f32(const kq_history_f32 *h);
size_t kq_history_steps_f64(const kq_history_f64 *h);

/** Smooths the whole history in place: mean and covariance of every step.
 *   h        recording; changed.  Its filter is detached and may go on
 * Events (of the views): KQ_EVENT_PRECISION where later measurements left less of a sigma, predicted or filtered, than
 * what the recorded ones were rounded by or, in f32 and f64, 8 roundings of the filter's mean: means may be off by more
 * than sigma.  Or, in f32 and f64, a smoothed sigma is 1/2 to 4 roundings of the terms of A x: at one step in 4, one state
 * is looked at.  Steps of compile-time sizes do not check these.  KQ_EVENT_OVERFLOW (f32, f64): measurements contradict
 * the model by so many sigma that a smoothed mean overflowed; it is 0, of a sigma that says so, as kq_predict leaves it.
 * Accuracy: as the filter; about eps sigma_filtered is added to mean and sigma.
 * Cost: about 6 n^3 + 2 m n^2 multiplications a step.
 * KQ_ERR_NULL, KQ_ERR_HISTORY_EMPTY (nothing recorded, or smoothed already), KQ_ERR_HISTORY_FULL (it overflowed while
 * recording), KQ_ERR_CHANGED. */
KQ_NODISCARD kq_status kq_smooth_f32(kq_history_f32 *h);
KQ_NODISCARD kq_status kq_smooth_f64(kq_history_f64 *h);

/** As kq_smooth, means only, at a third of the cost: kq_sigma is NaN, kq_covariance KQ_ERR_NOT_READY. */
KQ_NODISCARD kq_status kq_smooth_states_f32(kq_history_f32 *h);
KQ_NODISCARD kq_status kq_smooth_states_f64(kq_history_f64 *h);

/** What kq_smooth_step can also write; each pointer may be NULL.  Not written at the last step. */
typedef struct {
    float *lag_one;          /* n x n: Cov(x[t+1], x[t] | T) */
    float *noise_mean;       /* n:     E[w[t] | T], the process noise */
    float *noise_covariance; /* n x n: Cov(w[t] | T) */
} kq_smooth_extras_f32;
typedef struct { double *lag_one, *noise_mean, *noise_covariance; } kq_smooth_extras_f64;

/** Smooths one step a call, from the last step to step 0.  Call it kq_history_steps() times.
 *   h        recording at the first call, which ends the recording; changed.  Do not mix with kq_smooth
 *   p        the process that moved step t to t + 1, read; NULL: the recorded one.  The first call needs none
 *   extras   arrays to write, or NULL
 * After each call, step t and the steps above it can be shown.
 * Errors, events and cost of a step: as kq_smooth; also KQ_ERR_MISMATCH, KQ_ERR_NOT_READY (p). */
KQ_NODISCARD kq_status kq_smooth_step_f32(kq_history_f32 *h, const kq_process_f32 *p,
    const kq_smooth_extras_f32 *extras);
KQ_NODISCARD kq_status kq_smooth_step_f64(kq_history_f64 *h, const kq_process_f64 *p,
    const kq_smooth_extras_f64 *extras);

/** The smoothed measurement noise of the last step that kq_smooth_step did: v / sqrt(R) for a diagonal R, the
 * decorrelated component otherwise.  A mean far above 3 is an outlier.
 *   h        read
 *   k        0, 1, ...: scalar measurement of the step, in the order of the updates
 *   mean     one number, written; 0 if the measurement was not taken
 *   variance   one number, written; 0 likewise
 * KQ_ERR_NULL, KQ_ERR_HISTORY_EMPTY (no step done), KQ_ERR_SIZE (k).  Cost: a copy. */
KQ_NODISCARD kq_status kq_smoothed_measurement_noise_f32(const kq_history_f32 *h, int k, float *mean,
    float *variance);
KQ_NODISCARD kq_status kq_smoothed_measurement_noise_f64(const kq_history_f64 *h, int k, double *mean,
    double *variance);

/** Shows step t, given all measurements, in a view: a filter without memory that you can only read.
 *   h        smoothed down to step t; read
 *   t        0 .. kq_history_steps() - 1
 *   view     written.  It points into h, and is valid until h records again, is assigned anew or is gone.  After an
 *            error its readings are NaN.  Never a filter with memory: it would lose it
 * Readings of a view: kq_mean, kq_mean_low, kq_sigma, kq_covariance, kq_measurement, kq_innovation, kq_gain,
 * kq_forecast, kq_filter_copy; kq_events gives the events of smoothing.  Its NIS and likelihoods are NaN.  Calls that
 * move a filter answer KQ_ERR_NOT_READY.  Cost: no arithmetic, no copy.
 * KQ_ERR_NULL, KQ_ERR_SIZE (t), KQ_ERR_NOT_READY (step t is not smoothed). */
KQ_NODISCARD kq_status kq_smoothed_f32(const kq_history_f32 *h, size_t t, kq_filter_f32 *view);
KQ_NODISCARD kq_status kq_smoothed_f64(const kq_history_f64 *h, size_t t, kq_filter_f64 *view);

/* ------------------------------------------------------------------ q31, as f32 */

/** One step: 56, 140, 424 bytes at (n, m) = (2, 1), (4, 2), (9, 3). */
#define KQ_PRIVATE_HISTORY_STEP_LEN_Q31(n, m) \
    (KQ_FILTER_LEN_Q31((size_t)(n)) + 1 + (kq_length)(m) * ((kq_length)(n) + 2))
#define KQ_PRIVATE_HISTORY_CHANGE_LEN_Q31 \
    ((sizeof(void *) + sizeof(uint32_t) + sizeof(int32_t) - 1) / sizeof(int32_t))
#define KQ_PRIVATE_HISTORY_WORKSPACE_LEN_Q31(n) \
    (((size_t)(n)*3 + 10) * (size_t)(n) + 2 * KQ_TRIANGLE((size_t)(n)))
#define KQ_HISTORY_LEN_Q31(n, m, steps, changes) \
    ((kq_length)(steps)*KQ_PRIVATE_HISTORY_STEP_LEN_Q31(n, m) + \
        (kq_length)(changes)*KQ_PRIVATE_HISTORY_CHANGE_LEN_Q31 + KQ_PRIVATE_HISTORY_WORKSPACE_LEN_Q31(n))

typedef struct kq_history_q31 {
    struct kq_attached_q31 attached; uint8_t states, phase; uint16_t records;
    uint32_t steps, step, fingerprint; size_t length, used; int32_t *memory; const kq_process_q31 *process;
    kq_filter_q31 *filter; uint8_t events; uint32_t rounding; const kq_format_q31 *state_format;
} kq_history_q31;
extern const struct kq_hooks_q31 kq_history_hooks_q31;

#define KQ_HISTORY_Q31(name, n, m, steps, changes) \
    static int32_t name##_memory[KQ_HISTORY_LEN_Q31(n, m, steps, changes)]; \
    static kq_history_q31 name = { {&kq_history_hooks_q31}, n, 0, 0, 0, 0, 0, KQ_HISTORY_LEN_Q31(n, m, \
        steps, changes), 0, name##_memory, NULL, NULL, 0, 0, NULL}

/** As kq_history_assign_f32. */
KQ_NODISCARD kq_status kq_history_assign_q31(kq_history_q31 *h, int n, int32_t *memory, size_t length);
/** As kq_history_steps_f32. */
size_t kq_history_steps_q31(const kq_history_q31 *h);
/** As kq_smooth_f32 and kq_smooth_states_f32.
 * KQ_EVENT_SATURATED (in the views): a smoothed mean saturated, or data contradict the model by 32768 sigma.
 * Accuracy: as the filter; about 2^-25 of the filtered sigma is added. */
KQ_NODISCARD kq_status kq_smooth_q31(kq_history_q31 *h);
KQ_NODISCARD kq_status kq_smooth_states_q31(kq_history_q31 *h);

/** In units of the states' raw values. */
typedef struct {
    kq_scaled_q31 *lag_one;          /* n x n */
    kq_scaled_q31 *noise_mean;       /* n */
    kq_scaled_q31 *noise_covariance; /* n x n */
} kq_smooth_extras_q31;

/** As kq_smooth_step_f32.  KQ_EVENT_SATURATED: as kq_smooth_q31. */
KQ_NODISCARD kq_status kq_smooth_step_q31(kq_history_q31 *h, const kq_process_q31 *p,
    const kq_smooth_extras_q31 *extras);

/** As kq_smoothed_measurement_noise_f32, in units of the measurement noise's standard deviation. */
KQ_NODISCARD kq_status kq_smoothed_measurement_noise_q31(const kq_history_q31 *h, int k, kq_scaled_q31 *mean,
    kq_scaled_q31 *variance);

/** As kq_smoothed_f32. */
KQ_NODISCARD kq_status kq_smoothed_q31(const kq_history_q31 *h, size_t t, kq_filter_q31 *view);

#ifdef __cplusplus
}
#endif
#endif
