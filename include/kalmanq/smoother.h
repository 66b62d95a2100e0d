/*
 * kalmanq: the smoother, what is known of every past state once all measurements are in.
 *
 *     x_t|T = x + G (x_t+1|T - x-_{t+1})       G = P A' (P-_{t+1})^-1
 *     P_t|T = P + G (P_t+1|T - P-_{t+1}) G'    Cov(x_t+1, x_t | T) = P_t+1|T G'
 *
 * Fixed-interval (Rauch, Tung and Striebel 1965).  These are the results, not the arithmetic:
 * predict and update are orthogonal maps of the coordinates of the root S, and the smoother
 * runs the same maps backwards.  No inverse, no gain, no tolerance: a singular P- needs
 * nothing special, P_t|T is positive semi-definite and never above the filtered P.
 *
 * How to use it.  A HISTORY attached to a filter is a tape: predict and update record on it.
 * When the run is over, smooth it, in place, and read the results by step: step t is the time
 * after the t-th predict, t = 0 .. kq_history_steps() - 1.
 *
 *     kq_attach_f32(&track, &tape.attached);
 *     ... updates and predicts ...
 *     kq_smooth_f32(&tape);
 *     kq_smoothed_mean_f32(&tape, t, i);
 *
 * The tape refers to the processes by pointer, and knows each by a fingerprint of A and Q.  One
 * that has changed since (kq_process_init, _change_transition, _scale_noise, or assigned), also
 * between two predicts of the recording, as the A of an extended filter does at every step, is not
 * what the tape needs: smoothing is refused with KQ_ERR_CHANGED, but for one that is again what it
 * was.  Then attach it with a kq_jacobians (extended.h), which keeps each step's A,
 * or give each step its process by kq_smooth_step, or have a process for each step, or smooth on
 * line (lag.h, point.h), which keeps nothing of a process.  (Another model passes for the
 * old one with a probability of 2^-31.  An array that was written without a call is not seen.)
 *     The tape does not refer to the sensors.  Several sensors, rates and gaps need nothing
 * special.
 */
#ifndef KALMANQ_SMOOTHER_H
#define KALMANQ_SMOOTHER_H

#include "filter.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * Words of memory of a history: of one step with m scalar measurements present, of one change of
 * process (a predict by another process than the predict before it), of the workspace, and of
 * a whole history of `steps` steps (m: the most scalar measurements present in one step, all
 * sensors together).  The state that the recording begins with is a step, too: k predicts are k + 1
 * steps.  Bytes of one step in f32: 44, 116, 376 at (n, m) = (2,1), (4,2), (9,3).
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
 * Empties the history and has the filter record on it from now on; the state as it is becomes
 * step 0.  A filter records on one history: the one attached last.
 *     Who has to outlive whom: history and filter each other, until the history is smoothed (its
 * last step is the filter's state) or detached.  The recording also ends when the filter is
 * initialised or assigned anew, is given another history, or the history is assigned anew.  Attach
 * looks at what is attached to the filter, which must be alive.  The others do not look at the other object, which
 * may be gone, and so do not tell it: a history whose filter was initialised anew still has that filter, and is to
 * be detached before it goes to another one, or assigned anew where the filter is gone.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY (filter), KQ_ERR_SIZE or KQ_ERR_MEMORY (a history that was
 * never given them), KQ_ERR_MISMATCH (states), KQ_ERR_RECORDING (it has another filter, or an
 * adaptation or a settling is attached to f: detach it).  Of a filter whose start is in part unknown it
 * records from the instant on where all is known (start.h).
 */

/** Number of steps: predicts since the history was attached, plus 1.  0 where there is none. */
size_t kq_history_steps_f32(const kq_history_f32 *h);
size_t kq_history_steps_f64(const kq_history_f64 *h);

/**
 * Smooths the whole history, in place: means and covariances of every step.  The filter is
 * detached and may go on.
 * Cost: about 6 n^3 + 2 m n^2 multiplications a step.
 * Accuracy: each step is that of the filter; to it comes about eps sigma_filtered in the mean
 * and in sigma, which shows where smoothing makes sigma smaller by 1e4 (f32) or 1e12 (f64).
 * KQ_ERR_NULL, KQ_ERR_HISTORY_EMPTY (nothing recorded, or smoothed already: the results are there,
 * and a new run begins with kq_attach), KQ_ERR_HISTORY_FULL (it overflowed while
 * recording), KQ_ERR_CHANGED (a process is not what it was).
 */
KQ_NODISCARD kq_status kq_smooth_f32(kq_history_f32 *h);
KQ_NODISCARD kq_status kq_smooth_f64(kq_history_f64 *h);

/**
 * The means only, at a third of the cost: kq_smoothed_mean works afterwards,
 * kq_smoothed_sigma and kq_smoothed_covariance answer NaN and KQ_ERR_NOT_READY.
 * Errors as kq_smooth.
 */
KQ_NODISCARD kq_status kq_smooth_states_f32(kq_history_f32 *h);
KQ_NODISCARD kq_status kq_smooth_states_f64(kq_history_f64 *h);

/** What one backward step can give beside mean and covariance of step t: each pointer may be
    NULL, and is not written at the last step, which has no successor. */
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
 * The same one step a call, from the last step to step 0, for work in slices and for what is
 * read on the way.  Call it kq_history_steps() times; the first call closes the tape.  After
 * each call the results of all steps from t up can be read.
 *   p        the process that moved step t to t + 1, or NULL: the one recorded, refused with
 *            KQ_ERR_CHANGED if it has changed.  The first call needs none.
 *   extras   or NULL
 * Errors as kq_smooth, and KQ_ERR_MISMATCH or KQ_ERR_NOT_READY for p.  A history is smoothed
 * by this or by the functions above, not by both.
 */
KQ_NODISCARD kq_status kq_smooth_step_f32(kq_history_f32 *h, const kq_process_f32 *p,
                             const kq_smooth_extras_f32 *extras);
KQ_NODISCARD kq_status kq_smooth_step_f64(kq_history_f64 *h, const kq_process_f64 *p,
                             const kq_smooth_extras_f64 *extras);

/**
 * The smoothed measurement noise of the step that kq_smooth_step did last: of its k-th scalar
 * measurement (k = 0, 1, ... over the components present, in the order of the update), in
 * units of its standard deviation: v / sqrt(R) for a diagonal R, the decorrelated component
 * for a full one.  A mean far beyond 3 is an outlier.
 *   mean, variance   one number each, written
 * Both are 0 for a measurement that was not taken (KQ_EVENT_FLOOR).
 * KQ_ERR_NULL, KQ_ERR_HISTORY_EMPTY (no step done), KQ_ERR_SIZE (k).
 */
KQ_NODISCARD kq_status kq_smoothed_measurement_noise_f32(const kq_history_f32 *h, int k, float *mean,
                                            float *variance);
KQ_NODISCARD kq_status kq_smoothed_measurement_noise_f64(const kq_history_f64 *h, int k, double *mean,
                                            double *variance);

/** x_i, the low part of its word, and sqrt(P_ii) of step t given all measurements.  NaN where
    step t is not smoothed (yet), or h or i is bad. */
float kq_smoothed_mean_f32(const kq_history_f32 *h, size_t t, int i);
double kq_smoothed_mean_f64(const kq_history_f64 *h, size_t t, int i);
float kq_smoothed_mean_low_f32(const kq_history_f32 *h, size_t t, int i);
double kq_smoothed_mean_low_f64(const kq_history_f64 *h, size_t t, int i);
float kq_smoothed_sigma_f32(const kq_history_f32 *h, size_t t, int i);
double kq_smoothed_sigma_f64(const kq_history_f64 *h, size_t t, int i);

/** The sticky events (KQ_EVENT_..., status.h) of smoothing, cleared when the history is attached: its
    filter may be gone.  The filter keeps the events of the run.  A NULL h has no events.  In floating point there is
    KQ_EVENT_PRECISION: smoothing with covariances left less of a sigma than 8 roundings of the filter's mean
    (measurements without noise, processes with hardly any), and means may be off by more than it says.  Steps of
    compile-time sizes do not look.  Of 6,000 such models (tests/campaign/noise_free) a smoothed mean was off by more
    than 0.05 sigma in 15 of f32, 7 of them without it; by more than 1e-3 sigma, at most 0.012, in 4 of q31,
    which does not look. */
unsigned kq_history_events_f32(const kq_history_f32 *h);
unsigned kq_history_events_f64(const kq_history_f64 *h);

/**
 * P of step t given all measurements, exactly symmetric.
 *   P        n x n, written
 * KQ_ERR_NULL, KQ_ERR_NOT_READY (step t not smoothed, or states only), KQ_ERR_SIZE (t).
 */
KQ_NODISCARD kq_status kq_smoothed_covariance_f32(const kq_history_f32 *h, size_t t, float *P);
KQ_NODISCARD kq_status kq_smoothed_covariance_f64(const kq_history_f64 *h, size_t t, double *P);

/* ------------------------------------------------------------------ q31, as in f32
 *
 * Accuracy: to that of the filter come about 2^-25 of the filtered sigma, which shows where
 * smoothing makes sigma smaller by 1000.  The tape keeps rotations to 26 bits.
 * Words: only the smoothed mean is held at its word, no part of its sum is.  A mean that had to be
 * held, and data that contradict the model by more than 32768 sigma, which are held there, set
 * KQ_EVENT_SATURATED in the history.
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
} kq_history_q31;

extern const struct kq_hooks_q31 kq_history_hooks_q31;

#define KQ_HISTORY_Q31(name, n, m, steps, changes)                                                 \
    static int32_t name##_memory[KQ_HISTORY_LEN_Q31(n, m, steps, changes)];                        \
    static kq_history_q31 name = {                                                                 \
        {&kq_history_hooks_q31}, n, 0, 0, 0, 0, 0, KQ_HISTORY_LEN_Q31(n, m, steps, changes), 0, name##_memory,      \
        NULL, NULL, 0}

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

/** Words of the states' formats, as kq_mean_q31, kq_mean_low_q31 and kq_sigma_q31. */
int32_t kq_smoothed_mean_q31(const kq_history_q31 *h, size_t t, int i);
int32_t kq_smoothed_mean_low_q31(const kq_history_q31 *h, size_t t, int i);
int32_t kq_smoothed_sigma_q31(const kq_history_q31 *h, size_t t, int i);
unsigned kq_history_events_q31(const kq_history_q31 *h);
KQ_NODISCARD kq_status kq_smoothed_covariance_q31(const kq_history_q31 *h, size_t t, kq_scaled_q31 *P);

#ifdef __cplusplus
}
#endif
#endif
