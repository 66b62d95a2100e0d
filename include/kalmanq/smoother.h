/*
 * kalmanq: the fixed-interval smoother (Rauch, Tung and Striebel): every past state given all measurements.
 *
 *     x_t|T = x + G (x_t+1|T - x-_{t+1})       G = P A' (P-_{t+1})^-1
 *     P_t|T = P + G (P_t+1|T - P-_{t+1}) G'    Cov(x_t+1, x_t | T) = P_t+1|T G'
 *
 * These are the results, not the arithmetic.  The smoother runs the orthogonal maps of predict and update
 * backwards on the coordinates of the root S.  It inverts nothing and needs no gain: a singular P- needs
 * nothing special.  P_t|T is positive semi-definite and never above the filtered P.
 *
 * How to use it.  Attach a HISTORY to a filter: predict and update record on it.  When the run is over, smooth
 * it, in place.  Then show step t in a view, a filter that you read as any other.  Step t is the time after the
 * t-th predict, t = 0 .. kq_history_steps() - 1.
 *
 *     kq_filter_f32 view;                               without memory
 *     kq_attach_f32(&track, &tape.attached);
 *     ... updates and predicts ...
 *     kq_smooth_f32(&tape);
 *     kq_smoothed_f32(&tape, t, &view);
 *     kq_mean_f32(&view, i);   kq_sigma_f32(&view, i);   kq_covariance_f32(&view, P);
 *
 * The history refers to the processes by pointer, and knows each by a fingerprint of A and Q.  If one has
 * changed (kq_process_init, _change_transition, _scale_noise, or assigned), smoothing answers KQ_ERR_CHANGED,
 * unless it is again what it was.  A change between two predicts of the recording counts, too.  What to do then:
 *   - an A that changes at every step: a kq_jacobians (extended.h), which keeps each step's A
 *   - give each step its process by kq_smooth_step, or have a process for each step
 *   - smooth on line (lag.h, instant.h), which keeps nothing of a process
 * Another model passes for the old one with a probability of 2^-31.  An array that you write without a call is
 * not seen.  The history does not refer to the sensors: several sensors, rates and gaps need nothing special.
 */
#ifndef KALMANQ_SMOOTHER_H
#define KALMANQ_SMOOTHER_H

#include "filter.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * Words of memory of a history.
 *   n        states
 *   m        the most scalar measurements present in one step, all sensors together
 *   steps    predicts and 1: the state that the recording begins with is a step, too
 *   changes  predicts by another process than the predict before
 * Bytes of one step in f32: 44, 116, 376 at (n, m) = (2,1), (4,2), (9,3).
 */
#define KQ_PRIVATE_HISTORY_STEP_LEN_F32(n, m)                                                      \
    (KQ_FILTER_LEN_F32((size_t)(n)) + 1 + (kq_length)(m) * ((kq_length)(n) + 1))
#define KQ_PRIVATE_HISTORY_STEP_LEN_F64(n, m)                                                      \
    (KQ_FILTER_LEN_F64((size_t)(n)) + 1 + (kq_length)(m) * ((kq_length)(n) + 1))
#define KQ_PRIVATE_HISTORY_CHANGE_LEN_F32                                                          \
    ((sizeof(void *) + sizeof(uint32_t) + sizeof(float) - 1) / sizeof(float))
#define KQ_PRIVATE_HISTORY_CHANGE_LEN_F64                                                          \
    ((sizeof(void *) + sizeof(uint32_t) + sizeof(double) - 1) / sizeof(double))
#define KQ_PRIVATE_HISTORY_WORKSPACE_LEN(n)                                                        \
    (((size_t)(n)*3 + 4) * (size_t)(n) + 2 * KQ_TRIANGLE((size_t)(n)))
#define KQ_HISTORY_LEN_F32(n, m, steps, changes)                                                   \
    ((kq_length)(steps)*KQ_PRIVATE_HISTORY_STEP_LEN_F32(n, m) +                                    \
     (kq_length)(changes)*KQ_PRIVATE_HISTORY_CHANGE_LEN_F32 + KQ_PRIVATE_HISTORY_WORKSPACE_LEN(n))
#define KQ_HISTORY_LEN_F64(n, m, steps, changes)                                                   \
    ((kq_length)(steps)*KQ_PRIVATE_HISTORY_STEP_LEN_F64(n, m) +                                    \
     (kq_length)(changes)*KQ_PRIVATE_HISTORY_CHANGE_LEN_F64 + KQ_PRIVATE_HISTORY_WORKSPACE_LEN(n))

/* The fields are the library's (see process.h). */
typedef struct kq_history_f32 {
    struct kq_attached_f32 attached;
    uint8_t states;                /* n */
    uint8_t phase;                 /* unused, recording, full, smoothing */
    uint16_t records;              /* measurements recorded since the last predict */
    uint32_t steps;                /* steps recorded; the last one is closed by smoothing */
    uint32_t step;                 /* smoothing: steps at and above this one are done */
    uint32_t fingerprint;          /* of the process, when it was recorded */
    size_t length;                 /* words at memory */
    size_t used;                   /* words of the tape not yet smoothed */
    float *memory;                 /* the caller's: workspace, then tape */
    const kq_process_f32 *process; /* of the step at the tape's end */
    kq_filter_f32 *filter;         /* attached to */
    uint8_t events;                /* KQ_EVENT_... */
} kq_history_f32;

extern const struct kq_hooks_f32 kq_history_hooks_f32; /* what it does in the steps */

typedef struct kq_history_f64 {
    struct kq_attached_f64 attached;
    uint8_t states;
    uint8_t phase;
    uint16_t records;
    uint32_t steps;
    uint32_t step;
    uint32_t fingerprint;
    size_t length;
    size_t used;
    double *memory;
    const kq_process_f64 *process;
    kq_filter_f64 *filter;
    uint8_t events;
} kq_history_f64;

extern const struct kq_hooks_f64 kq_history_hooks_f64;

/** A history `name` with its storage, in static memory: for n states, at most m scalar
    measurements a step, `steps` steps (predicts and one: the first state counts), `changes`
    changes of process. */
#define KQ_HISTORY_F32(name, n, m, steps, changes)                                                 \
    static float name##_memory[KQ_HISTORY_LEN_F32(n, m, steps, changes)];                          \
    static kq_history_f32 name = {                                                                 \
        {&kq_history_hooks_f32}, n, 0, 0, 0, 0, 0, KQ_HISTORY_LEN_F32(n, m, steps, changes), 0, name##_memory,      \
        NULL, NULL, 0}
#define KQ_HISTORY_F64(name, n, m, steps, changes)                                                 \
    static double name##_memory[KQ_HISTORY_LEN_F64(n, m, steps, changes)];                         \
    static kq_history_f64 name = {                                                                 \
        {&kq_history_hooks_f64}, n, 0, 0, 0, 0, 0, KQ_HISTORY_LEN_F64(n, m, steps, changes), 0, name##_memory,      \
        NULL, NULL, 0}

/**
 * Sizes and memory known at run time only (the macros do the same at compile time).
 *   h        written
 *   n        1..16
 *   length   words at memory: KQ_HISTORY_LEN_<T>(n, m, steps, changes); at least the workspace
 *            and one step
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY.
 */
KQ_NODISCARD kq_status kq_history_assign_f32(kq_history_f32 *h, int n, float *memory, size_t length);
KQ_NODISCARD kq_status kq_history_assign_f64(kq_history_f64 *h, int n, double *memory, size_t length);

/*
 * Attaching (kq_attach) empties the history and has the filter record on it from then on.  The state as it is becomes
 * step 0.  If the start of the filter is in part unknown, recording begins where all is known (diffuse.h).
 *     History and filter must be alive until the history is smoothed or detached.  A filter records on one history, the
 * last one attached.  The recording also ends when the filter is initialised or assigned anew, or the history is
 * assigned anew.  A history whose filter was initialised anew still has that filter: detach it before it goes to
 * another one, or assign it anew if the filter is gone.
 *     kq_detach ends the recording.  What was recorded and not smoothed is lost.  What was smoothed can still be shown.
 */

/** Number of steps: predicts since the history was attached, plus 1.  0 where there is none. */
size_t kq_history_steps_f32(const kq_history_f32 *h);
size_t kq_history_steps_f64(const kq_history_f64 *h);

/**
 * Smooths the whole history, in place: mean and covariance of every step.
 *   h        recording; the filter is detached and may go on
 * KQ_EVENT_PRECISION (f32, f64; in the views): later measurements left less of a sigma, predicted or filtered, than 8
 * roundings of the filter's mean, so means may be off by more than sigma says.  Steps of compile-time sizes do not look.
 * Cost: about 6 n^3 + 2 m n^2 multiplications a step.
 * Accuracy: as the filter; about eps sigma_filtered is added to mean and sigma (tests/README.md, Accuracy).
 * KQ_ERR_NULL, KQ_ERR_HISTORY_EMPTY (nothing recorded, or smoothed already: begin a new run by
 * kq_attach), KQ_ERR_HISTORY_FULL (it overflowed while recording), KQ_ERR_CHANGED (a process is not
 * what it was).
 */
KQ_NODISCARD kq_status kq_smooth_f32(kq_history_f32 *h);
KQ_NODISCARD kq_status kq_smooth_f64(kq_history_f64 *h);

/**
 * The means only, at a third of the cost: of the views kq_sigma is NaN then, and kq_covariance answers
 * KQ_ERR_NOT_READY.  Errors as kq_smooth.
 */
KQ_NODISCARD kq_status kq_smooth_states_f32(kq_history_f32 *h);
KQ_NODISCARD kq_status kq_smooth_states_f64(kq_history_f64 *h);

/** What one backward step can give besides mean and covariance of step t.  Each pointer may be NULL.  Nothing is
    written at the last step, which has no successor. */
typedef struct {
    float *lag_one;          /* n x n: Cov(x[t+1], x[t] | T) */
    float *noise_mean;       /* n:     E[w[t] | T], the process noise */
    float *noise_covariance; /* n x n: Cov(w[t] | T) */
} kq_smooth_extras_f32;

typedef struct {
    double *lag_one;
    double *noise_mean;
    double *noise_covariance;
} kq_smooth_extras_f64;

/**
 * Smooths one step a call, from the last step to step 0.  Call it kq_history_steps() times; the first call ends
 * the recording.  After each call the steps from t up can be shown.
 *   p        the process that moved step t to t + 1; NULL: the recorded one.  The first call needs none.
 *   extras   or NULL
 * Smooth a history by this or by the functions above, not by both.
 * Errors as kq_smooth, and KQ_ERR_MISMATCH or KQ_ERR_NOT_READY for p.
 */
KQ_NODISCARD kq_status kq_smooth_step_f32(kq_history_f32 *h, const kq_process_f32 *p,
                             const kq_smooth_extras_f32 *extras);
KQ_NODISCARD kq_status kq_smooth_step_f64(kq_history_f64 *h, const kq_process_f64 *p,
                             const kq_smooth_extras_f64 *extras);

/**
 * The smoothed measurement noise of the step that kq_smooth_step did last: v / sqrt(R) of a diagonal R, the
 * decorrelated component of a full one.  A mean far beyond 3 is an outlier.
 *   k        0, 1, ...: which scalar measurement of the step, in the order of the updates
 *   mean, variance   one number each, written; both 0 for a measurement that was not taken (KQ_EVENT_REDUNDANT)
 * KQ_ERR_NULL, KQ_ERR_HISTORY_EMPTY (no step done), KQ_ERR_SIZE (k).
 */
KQ_NODISCARD kq_status kq_smoothed_measurement_noise_f32(const kq_history_f32 *h, int k, float *mean,
                                            float *variance);
KQ_NODISCARD kq_status kq_smoothed_measurement_noise_f64(const kq_history_f64 *h, int k, double *mean,
                                            double *variance);

/**
 * Shows step t, given all measurements, in a view.
 *   h        smoothed, down to step t at least; keeps what is shown
 *   t        0 .. kq_history_steps() - 1
 *   view     written; declare it without memory.  It points into h, and is valid until h records again, is
 *            assigned anew or is gone.  After an error its readings are NaN.
 * Of a view you can call kq_mean, kq_mean_low, kq_sigma, kq_covariance, kq_measurement, kq_innovation and kq_gain,
 * forecast from it and copy it (kq_forecast, kq_filter_copy) into another filter.  kq_events gives the events of
 * smoothing, of all steps done; a copy keeps them.  What moves a filter answers KQ_ERR_NOT_READY for a view.  It
 * has no NIS and no likelihood (NaN).
 * Cost: no arithmetic, no copy.
 * KQ_ERR_NULL, KQ_ERR_SIZE (t), KQ_ERR_NOT_READY (step t is not smoothed).
 */
KQ_NODISCARD kq_status kq_smoothed_f32(const kq_history_f32 *h, size_t t, kq_filter_f32 *view);
KQ_NODISCARD kq_status kq_smoothed_f64(const kq_history_f64 *h, size_t t, kq_filter_f64 *view);

/* ------------------------------------------------------------------ q31, as in f32
 *
 * Accuracy: as the filter; about 2^-25 of the filtered sigma is added, which shows where smoothing makes sigma
 * smaller by 1000.  The history keeps rotations to 26 bits.
 * KQ_EVENT_SATURATED (in the views): a smoothed mean saturated, or data contradict the model by more than 32768
 * sigma, where they saturate.
 */

/** Bytes of one step: 56, 140, 424 at (n, m) = (2,1), (4,2), (9,3). */
#define KQ_PRIVATE_HISTORY_STEP_LEN_Q31(n, m)                                                      \
    (KQ_FILTER_LEN_Q31((size_t)(n)) + 1 + (kq_length)(m) * ((kq_length)(n) + 2))
#define KQ_PRIVATE_HISTORY_CHANGE_LEN_Q31                                                          \
    ((sizeof(void *) + sizeof(uint32_t) + sizeof(int32_t) - 1) / sizeof(int32_t))
#define KQ_PRIVATE_HISTORY_WORKSPACE_LEN_Q31(n)                                                    \
    (((size_t)(n)*3 + 10) * (size_t)(n) + 2 * KQ_TRIANGLE((size_t)(n)))
#define KQ_HISTORY_LEN_Q31(n, m, steps, changes)                                                   \
    ((kq_length)(steps)*KQ_PRIVATE_HISTORY_STEP_LEN_Q31(n, m) +                                    \
     (kq_length)(changes)*KQ_PRIVATE_HISTORY_CHANGE_LEN_Q31 + KQ_PRIVATE_HISTORY_WORKSPACE_LEN_Q31(n))

/* The fields are the library's. */
typedef struct kq_history_q31 {
    struct kq_attached_q31 attached;
    uint8_t states;
    uint8_t phase;
    uint16_t records;
    uint32_t steps;
    uint32_t step;
    uint32_t fingerprint;
    size_t length;
    size_t used;
    int32_t *memory;
    const kq_process_q31 *process;
    kq_filter_q31 *filter;
    uint8_t events;
    const kq_format_q31 *state_format;
} kq_history_q31;

extern const struct kq_hooks_q31 kq_history_hooks_q31;

#define KQ_HISTORY_Q31(name, n, m, steps, changes)                                                 \
    static int32_t name##_memory[KQ_HISTORY_LEN_Q31(n, m, steps, changes)];                        \
    static kq_history_q31 name = {                                                                 \
        {&kq_history_hooks_q31}, n, 0, 0, 0, 0, 0, KQ_HISTORY_LEN_Q31(n, m, steps, changes), 0, name##_memory,      \
        NULL, NULL, 0, NULL}

KQ_NODISCARD kq_status kq_history_assign_q31(kq_history_q31 *h, int n, int32_t *memory, size_t length);
size_t kq_history_steps_q31(const kq_history_q31 *h);
KQ_NODISCARD kq_status kq_smooth_q31(kq_history_q31 *h);
KQ_NODISCARD kq_status kq_smooth_states_q31(kq_history_q31 *h);

/** In units of the states' words. */
typedef struct {
    kq_scaled_q31 *lag_one;          /* n x n */
    kq_scaled_q31 *noise_mean;       /* n */
    kq_scaled_q31 *noise_covariance; /* n x n */
} kq_smooth_extras_q31;

KQ_NODISCARD kq_status kq_smooth_step_q31(kq_history_q31 *h, const kq_process_q31 *p,
                             const kq_smooth_extras_q31 *extras);

/** In units of the measurement noise's standard deviation, as in f32. */
KQ_NODISCARD kq_status kq_smoothed_measurement_noise_q31(const kq_history_q31 *h, int k, kq_scaled_q31 *mean,
                                            kq_scaled_q31 *variance);

/** As in f32. */
KQ_NODISCARD kq_status kq_smoothed_q31(const kq_history_q31 *h, size_t t, kq_filter_q31 *view);

#ifdef __cplusplus
}
#endif
#endif
