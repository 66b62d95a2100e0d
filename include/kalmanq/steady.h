/*
 * kalmanq: the steady state, where a constant model leads to, and filters that use it.
 *
 *     P- = A (P- - P- H'(H P- H' + R)^-1 H P-) A' + Q          the predicted covariance
 *     K  = P- H'(H P- H' + R)^-1                               the gain
 *     x  = x- + K (z - H x-),    x- = A x + B u                the steady-state filter
 *
 * With A, H, Q and R constant, P- and K converge whatever the prior was.  The steady-state filter
 * carries no covariance: predict and update move the mean alone.  This header has
 *
 *     kq_steady_solve       the equation above: P-, P, K, the smoother's gain (f32, f64; for q31
 *                           on the host, then kq_matrix_prepare_q31)
 *     kq_steady             a filter with gains that you give it; one gain: the steady one alone
 *     kq_freeze           an ordinary filter that drops its covariance work while it is settled
 *
 * A steady state exists where every state that does not decay by itself (|eigenvalue of A| >= 1) is
 * measured (detectable) and moved by the noise (stabilisable).
 */
#ifndef KALMANQ_STEADY_H
#define KALMANQ_STEADY_H

#include "filter.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------ the equation */

/** Words of workspace for kq_steady_solve: 200 at n, m = 4, 2 in f32. */
#define KQ_STEADY_SOLVE_LEN_F32(n, m)                                                              \
    (KQ_PRIVATE_STEADY_SQUARES_LEN((size_t)(n), (size_t)(m)) + (size_t)KQ_FILTER_LEN_F32(n))
#define KQ_STEADY_SOLVE_LEN_F64(n, m)                                                              \
    (KQ_PRIVATE_STEADY_SQUARES_LEN((size_t)(n), (size_t)(m)) + (size_t)KQ_FILTER_LEN_F64(n))
#define KQ_PRIVATE_STEADY_SQUARES_LEN(n, m)                                                        \
    ((n) * (7 * (n) + 2 * (m) + 2 + ((n) > (m) ? (n) : (m))) + 3 * KQ_TRIANGLE(n))

/** What kq_steady_solve can give; each pointer may be NULL. */
typedef struct {
    float *predicted;     /* n x n: P-, exactly symmetric */
    float *filtered;      /* n x n: P = P- - K H P- */
    float *gain;          /* n x m: K */
    float *smoother_gain; /* n x n: G = P A' (P-)^-1, the pseudo-inverse where P- is singular */
} kq_steady_solution_f32;

typedef struct {
    double *predicted;
    double *filtered;
    double *gain;
    double *smoother_gain;
} kq_steady_solution_f64;

/**
 * Solves the equation for a process and a sensor as they are.  R may be correlated, singular or 0.
 *   memory   scratch, KQ_STEADY_SOLVE_LEN_<T>(n, m) words
 *   length   words at memory
 *   out      written where its pointers are not NULL
 * Method: the structured doubling algorithm on roots, then Newton's method in the form of sums of
 * squares (at most 30 steps, mostly 2 or 3): P- is positive semi-definite by construction.
 * Cost: about 40 n^3 multiplications a doubling; a state that the filter forgets in T steps takes
 * 4 + log2 T doublings, and as many again for each step of Newton's.
 * Stack: 300 words.
 * Accuracy, relative to sqrt(P_ii P_jj): a few eps times the sum of |C^k|^2, C =
 * A (I - K H) in units of the sigmas, which is about eps / (1 - rho) where C is near normal; rho
 * is C's largest |eigenvalue|.  The equation itself is no better conditioned. What lasts too long
 * counts as lasting for ever: 1 - rho below 2^-20 (f32) or 2^-48 (f64).
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_MISMATCH (states), KQ_ERR_MEMORY, KQ_ERR_NOT_DETECTABLE,
 * KQ_ERR_NOT_STABILISABLE (if both are true, either), KQ_ERR_NO_CONVERGENCE (beyond the
 * arithmetic; or a noise-free sensor that the noise reaches by a way with zeros on the unit
 * circle: there is a limit, but the filter does not forget). Sources: Chu, Fan, Lin and Wang,
 * Structure-preserving algorithms for periodic discrete-time algebraic Riccati equations, Int. J.
 * Control 77 (2004); Hewer, An iterative technique for the computation of the steady state gains
 * for the discrete optimal regulator, IEEE Trans. Automat. Contr. 16 (1971).
 */
KQ_NODISCARD kq_status kq_steady_solve_f32(const kq_process_f32 *p, const kq_sensor_f32 *s, float *memory,
                              size_t length, const kq_steady_solution_f32 *out);
KQ_NODISCARD kq_status kq_steady_solve_f64(const kq_process_f64 *p, const kq_sensor_f64 *s, double *memory,
                              size_t length, const kq_steady_solution_f64 *out);

/** The largest `bits` of kq_freeze_init: rounding leaves room for no more. */
#define KQ_FREEZE_BITS_MAX_F32 18
#define KQ_FREEZE_BITS_MAX_F64 46
#define KQ_FREEZE_BITS_MAX_Q31 24

/* ------------------------------------------------------------------ the filter */

/** Words of memory of a steady-state filter with n states: the mean. */
#define KQ_STEADY_LEN_F32(n) (n)
#define KQ_STEADY_LEN_F64(n) (n)

/* The fields are the library's (see process.h). */
typedef struct {
    uint8_t states;     /* n */
    uint8_t components; /* m */
    uint8_t events;
    uint8_t length;    /* words at memory */
    uint16_t plain;    /* n + 256 m, and 128 where A is upper triangular; 0 before the last gain */
    float *memory;     /* the caller's: the mean */
    const float *gain; /* of the next update; NULL until initialised */
    size_t left;       /* gains behind it */
    const kq_process_f32 *process;
    const kq_sensor_f32 *sensor;
} kq_steady_f32;

typedef struct {
    uint8_t states;
    uint8_t components;
    uint8_t events;
    uint8_t length;
    uint16_t plain;
    double *memory;
    const double *gain;
    size_t left;
    const kq_process_f64 *process;
    const kq_sensor_f64 *sensor;
} kq_steady_f64;

/** A steady-state filter `name` of n states for m components with its storage, in static memory. */
#define KQ_STEADY_F32(name, n, m)                                                                  \
    static float name##_memory[KQ_STEADY_LEN_F32(n)];                                              \
    static kq_steady_f32 name = {n, m,    0,   KQ_STEADY_LEN_F32(n), 0, name##_memory, NULL,       \
                                 0, NULL, NULL}
#define KQ_STEADY_F64(name, n, m)                                                                  \
    static double name##_memory[KQ_STEADY_LEN_F64(n)];                                             \
    static kq_steady_f64 name = {n, m,    0,   KQ_STEADY_LEN_F64(n), 0, name##_memory, NULL,       \
                                 0, NULL, NULL}

/**
 * Sizes and memory known at run time only (the macros do the same at compile time).
 *   n, m     1..16
 *   memory   KQ_STEADY_LEN_<T>(n) words or more
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY.
 */
KQ_NODISCARD kq_status kq_steady_assign_f32(kq_steady_f32 *st, int n, int m, float *memory, size_t length);
KQ_NODISCARD kq_status kq_steady_assign_f64(kq_steady_f64 *st, int n, int m, double *memory, size_t length);

/**
 * The model, the mean before the first measurement, and the gains.
 *   p, s     kept by reference.  They must not change: after a change of them call this again
 *   x0       n; not kept
 *   gains    count x n x m, kept by reference, const and in flash if you like: the t-th update
 *            takes gain t, from the last one on always that.  count = 1: the steady gain alone
 *   count    1 .. KQ_COUNT_MAX
 * KQ_ERR_NULL, KQ_ERR_SIZE (count, or sizes never given), KQ_ERR_MEMORY, KQ_ERR_NOT_READY
 * (p, s), KQ_ERR_MISMATCH (sizes), KQ_ERR_NOT_FINITE.
 */
KQ_NODISCARD kq_status kq_steady_init_f32(kq_steady_f32 *st, const kq_process_f32 *p, const kq_sensor_f32 *s,
                             const float *x0, const float *gains, size_t count);
KQ_NODISCARD kq_status kq_steady_init_f64(kq_steady_f64 *st, const kq_process_f64 *p, const kq_sensor_f64 *s,
                             const double *x0, const double *gains, size_t count);

/**
 * predict   x <- A x + B u              u: l, or NULL: no control
 * update    x <- x + K (z - H x)        z: m; of a correlated sensor, too
 * step      predict, then update; refused as a whole
 *
 * A step without a measurement is a predict.  After it the gain is too small, of which this filter
 * knows nothing (kq_freeze does); the estimate stays unbiased.
 * Cost: n^2 + 2 n m multiplications (n (n + 1) / 2 for an upper triangular A).
 * kq_fixed_steady_step (src/fixed_size/kq_fixed_<T>.h), for sizes that the compiler knows, at n, m = 4, 2: 90
 * instructions on a Cortex-M4F in f32, 459 on an M3 in q31, A upper triangular, H selecting states
 * (tools/cost.csv; tests/cost/goals.py); more with a dense A or H that scales.
 * Stack: 54 words.
 * Accuracy against the full filter with the same gains: the mean has one float in f32.  Every step
 * rounds it at its size, eps |x| / 2, of which about eps |x| / (1 - rho) adds up; a correction K e
 * below eps |x| / 2 is lost.  Where sigma is below 1e-5 of the state's range take kq_freeze, whose
 * mean is a pair, or f64 or q31.  Where the gain has settled to 2^-b of itself, the mean is within
 * about 2^-b |e| / (1 - rho)^2.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_NOT_FINITE (u, z; a mean or an innovation not representable, and
 * nothing has changed: kq_steady_init begins anew).
 */
KQ_NODISCARD kq_status kq_steady_predict_f32(kq_steady_f32 *st, const float *u);
KQ_NODISCARD kq_status kq_steady_predict_f64(kq_steady_f64 *st, const double *u);
KQ_NODISCARD kq_status kq_steady_update_f32(kq_steady_f32 *st, const float *z);
KQ_NODISCARD kq_status kq_steady_update_f64(kq_steady_f64 *st, const double *z);
KQ_NODISCARD kq_status kq_steady_step_f32(kq_steady_f32 *st, const float *u, const float *z);
KQ_NODISCARD kq_status kq_steady_step_f64(kq_steady_f64 *st, const double *u, const double *z);

/** x_i, in the state's unit.  NaN where st or i is bad. */
float kq_steady_mean_f32(const kq_steady_f32 *st, int i);
double kq_steady_mean_f64(const kq_steady_f64 *st, int i);

/**
 * e = z - H x.  Call it before the update.
 *   e        m, written; may be z
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_NOT_FINITE (z, or an e not representable).
 */
KQ_NODISCARD kq_status kq_steady_innovation_f32(const kq_steady_f32 *st, const float *z, float *e);
KQ_NODISCARD kq_status kq_steady_innovation_f64(const kq_steady_f64 *st, const double *z, double *e);

/* ------------------------------------------------------------------ settling
 *
 * An ordinary kq_filter that stops working on its covariance once that has settled, and begins
 * again when something is different: a measurement is missing; the process or the sensor is another
 * object; A or Q of the process are others, told by an init or a kq_process_change_... (its fingerprint,
 * smoother.h); H of the sensor is another array; or something else has moved the covariance.  Other
 * numbers than these are not noticed: a new R by a sensor's init, new content of H's array.  After them
 * call kq_freeze_release.
 *
 *     kq_attach_f32(&track, &lazy.attached);
 *     kq_update_f32(&track, &radar, z);                             the first measurement
 *     ... kq_step_f32(&track, &motion, NULL, &radar, z);            or kq_predict: no measurement
 *
 * While it is settled kq_step moves the mean alone, by A and the gain as it has become; the root stays the
 * filtered one.  So the filter can be read as ever, but it judges no measurement: kq_nis, kq_taken and
 * kq_log_likelihood_last are those of the last step that was not settled, kq_log_likelihood is the sum up
 * to it, and kq_consistency_record refuses such a step (KQ_ERR_NOT_READY, consistency.h).
 */

/** Words and gains of memory. */
#define KQ_FREEZE_LEN_F32(n) KQ_TRIANGLE(n)
#define KQ_FREEZE_LEN_F64(n) KQ_TRIANGLE(n)

/* The fields are the library's. */
typedef struct {
    struct kq_attached_f32 attached;
    uint8_t states;
    uint8_t components;
    uint8_t bits;  /* 0: not initialised */
    uint8_t phase; /* moving, calm, settled */
    uint16_t length;
    float *memory; /* the caller's: the root of the step before */
    float *gain;   /* the caller's, n x m */
    const kq_process_f32 *process;
    uint32_t fingerprint; /* of the process at the last step */
    const kq_sensor_f32 *sensor;
    const float *measurement;
    kq_filter_f32 *filter; /* attached to */
} kq_freeze_f32;

extern const struct kq_hooks_f32 kq_freeze_hooks_f32; /* what it does in the steps */

typedef struct {
    struct kq_attached_f64 attached;
    uint8_t states;
    uint8_t components;
    uint8_t bits;
    uint8_t phase;
    uint16_t length;
    double *memory;
    double *gain;
    const kq_process_f64 *process;
    uint32_t fingerprint;
    const kq_sensor_f64 *sensor;
    const double *measurement;
    kq_filter_f64 *filter; /* attached to */
} kq_freeze_f64;

extern const struct kq_hooks_f64 kq_freeze_hooks_f64;

/** A freeze `name` for n states and m components with its storage, in static memory. */
#define KQ_FREEZE_F32(name, n, m)                                                                \
    static float name##_memory[KQ_FREEZE_LEN_F32(n)], name##_gain[(n) * (m)];                    \
    static kq_freeze_f32 name = {                                                                \
        {&kq_freeze_hooks_f32}, n, m, 0, 0, KQ_FREEZE_LEN_F32(n), name##_memory, name##_gain, NULL, 0, NULL, NULL, NULL}
#define KQ_FREEZE_F64(name, n, m)                                                                \
    static double name##_memory[KQ_FREEZE_LEN_F64(n)], name##_gain[(n) * (m)];                   \
    static kq_freeze_f64 name = {                                                                \
        {&kq_freeze_hooks_f64}, n, m, 0, 0, KQ_FREEZE_LEN_F64(n), name##_memory, name##_gain, NULL, 0, NULL, NULL, NULL}

/**
 * Sizes and memory known at run time only (the macros do the same at compile time).
 *   memory   KQ_FREEZE_LEN_<T>(n) words or more
 *   gain     n x m numbers
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY.
 */
KQ_NODISCARD kq_status kq_freeze_assign_f32(kq_freeze_f32 *w, int n, int m, float *memory, size_t length,
                                 float *gain);
KQ_NODISCARD kq_status kq_freeze_assign_f64(kq_freeze_f64 *w, int n, int m, double *memory, size_t length,
                                 double *gain);

/**
 * Not settled, and when it will be.
 *   bits     1 .. KQ_FREEZE_BITS_MAX_<T>: when a step changes no row of the filtered root by more
 *            than 2^-bits of the row's norm.  The gain is then within about 2^-bits / (1 - rho^2)
 *            of the steady one; 10 costs less than 1 % of the innovation's variance where rho is
 *            below 0.9
 * KQ_ERR_NULL, KQ_ERR_SIZE (bits, or sizes never given), KQ_ERR_MEMORY.
 */
KQ_NODISCARD kq_status kq_freeze_init_f32(kq_freeze_f32 *w, int bits);
KQ_NODISCARD kq_status kq_freeze_init_f64(kq_freeze_f64 *w, int bits);

/*
 * From now on kq_step of f, by a sensor of m components, may rest on what has settled.  kq_predict and
 * kq_update by themselves are the filter's own, and unsettle it.
 *   f        with nothing attached but w itself, which then begins again.  w and f have to outlive each
 *            other until kq_detach.  kq_filter_init detaches f and does not tell w, which may be
 *            gone: a freeze still has the filter that it was attached to, and goes to another one when
 *            it is detached, or assigned anew where that filter is gone
 * A process is known again by its address and fingerprint (a const table has none: an assigned one is
 * not noticed), a sensor by its address and that of H: after new numbers in the same sensor, or in an
 * array without a call, call kq_freeze_release.
 * Cost: settled, n^2 + 2 n m multiplications and n^2 comparisons; otherwise that of kq_step and n^2
 * more, at the step where it settles also that of kq_gain.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY (w, f), KQ_ERR_MISMATCH (states), KQ_ERR_RECORDING (w has another filter, or
 * something else is attached to f: detach it).  kq_step then answers KQ_ERR_MISMATCH also for a sensor of
 * other than m components.
 */

/** Did the last step move the mean alone?  0 for NULL. */
int kq_freeze_is_active_f32(const kq_freeze_f32 *w);
int kq_freeze_is_active_f64(const kq_freeze_f64 *w);

/** Back to the full filter at the next step, until it has settled again: what has to be called where a
    sensor has got new numbers (above).  KQ_ERR_NULL, KQ_ERR_NOT_READY. */
KQ_NODISCARD kq_status kq_freeze_release_f32(kq_freeze_f32 *w);
KQ_NODISCARD kq_status kq_freeze_release_f64(kq_freeze_f64 *w);

/* ------------------------------------------------------------------ q31
 *
 * As in f32, but for the equation, which is solved in f64 and its gain K made into a table by
 * kq_matrix_prepare_q31 with the formats of states and measurements (prepare.h).  A word is a
 * word of its component's format; gains are in units of words (fixed_point.h).
 */

/** Words of memory: the mean in 32 + 24 bits. */
#define KQ_STEADY_LEN_Q31(n) (2 * (n))

/* The fields are the library's. */
typedef struct {
    uint8_t states;
    uint8_t components;
    uint8_t events;
    uint8_t length;
    uint16_t plain;
    int32_t *memory;
    const kq_scaled_q31 *gain;
    size_t left;
    const kq_process_q31 *process;
    const kq_sensor_q31 *sensor;
} kq_steady_q31;

#define KQ_STEADY_Q31(name, n, m)                                                                  \
    static int32_t name##_memory[KQ_STEADY_LEN_Q31(n)];                                            \
    static kq_steady_q31 name = {n, m,    0,   KQ_STEADY_LEN_Q31(n), 0, name##_memory, NULL,       \
                                 0, NULL, NULL}

KQ_NODISCARD kq_status kq_steady_assign_q31(kq_steady_q31 *st, int n, int m, int32_t *memory, size_t length);

/**
 * As in f32.
 * KQ_ERR_RANGE (x0 outside its declared range), KQ_ERR_COEFFICIENT (a gain that is not normalised
 * or beyond the exponents' limit), KQ_ERR_MISMATCH also where p and s differ in the states'
 * formats.
 */
KQ_NODISCARD kq_status kq_steady_init_q31(kq_steady_q31 *st, const kq_process_q31 *p, const kq_sensor_q31 *s,
                             const int32_t *x0, const kq_scaled_q31 *gains, size_t count);

/**
 * As in f32; KQ_ERR_RANGE for u and z.  A mean that would leave its word is held there, with
 * KQ_EVENT_SATURATED; so is a part K_ic e_c of more than 8 words, but not the sum of the parts.
 * Accuracy: each product with a coefficient other than 1 is rounded to 2^-24 word, the innovation
 * truncated to 30 bits.
 */
KQ_NODISCARD kq_status kq_steady_predict_q31(kq_steady_q31 *st, const int32_t *u);
KQ_NODISCARD kq_status kq_steady_update_q31(kq_steady_q31 *st, const int32_t *z);
KQ_NODISCARD kq_status kq_steady_step_q31(kq_steady_q31 *st, const int32_t *u, const int32_t *z);

/** The events, and back to none.  A NULL st has none. */
unsigned kq_steady_events_q31(const kq_steady_q31 *st);
void kq_steady_events_clear_q31(kq_steady_q31 *st);

/** x_i rounded to a word, and what the rounding left in 2^-24 of a word (kq_mean_q31). */
int32_t kq_steady_mean_q31(const kq_steady_q31 *st, int i);
int32_t kq_steady_mean_low_q31(const kq_steady_q31 *st, int i);

/** Rounded to words of the measurement, held at +-(2^31 - 1). */
KQ_NODISCARD kq_status kq_steady_innovation_q31(const kq_steady_q31 *st, const int32_t *z, int32_t *e);

#define KQ_FREEZE_LEN_Q31(n) KQ_ROOT_LEN_Q31(n)

/* The fields are the library's. */
typedef struct {
    struct kq_attached_q31 attached;
    uint8_t states;
    uint8_t components;
    uint8_t bits;
    uint8_t phase;
    uint16_t length;
    int32_t *memory;
    kq_scaled_q31 *gain;
    const kq_process_q31 *process;
    uint32_t fingerprint;
    const kq_sensor_q31 *sensor;
    const kq_scaled_q31 *measurement;
    kq_filter_q31 *filter; /* attached to */
} kq_freeze_q31;

extern const struct kq_hooks_q31 kq_freeze_hooks_q31;

#define KQ_FREEZE_Q31(name, n, m)                                                                \
    static int32_t name##_memory[KQ_FREEZE_LEN_Q31(n)];                                          \
    static kq_scaled_q31 name##_gain[(n) * (m)];                                                   \
    static kq_freeze_q31 name = {                                                                \
        {&kq_freeze_hooks_q31}, n, m, 0, 0, KQ_FREEZE_LEN_Q31(n), name##_memory, name##_gain, NULL, 0, NULL, NULL, NULL}

KQ_NODISCARD kq_status kq_freeze_assign_q31(kq_freeze_q31 *w, int n, int m, int32_t *memory, size_t length,
                                 kq_scaled_q31 *gain);
KQ_NODISCARD kq_status kq_freeze_init_q31(kq_freeze_q31 *w, int bits);
int kq_freeze_is_active_q31(const kq_freeze_q31 *w);
KQ_NODISCARD kq_status kq_freeze_release_q31(kq_freeze_q31 *w);

#ifdef __cplusplus
}
#endif
#endif
