/*
 * kalmanq: parameters of a model from recorded measurements, by EM; likelihood and gradient.  f32 and f64.
 *
 *     x[t+1] = A x[t] + B u[t] + F q[t],  q ~ N(0, Q)       z[t] = H x[t] + v[t],  v ~ N(0, R)
 *     x[0] ~ N(x0, P0), before the first measurement;  F is I if it is NULL
 *
 * An iteration moves the free ones of (A, H, Q, R, x0, P0) to values under which the recordings are at least as
 * likely.  The E-step smooths every recording; the M-step makes new parameters of the smoothed noises:
 *
 *     Q  = mean of E[q q' | all]            A + sum E[w x'] (sum E[x x'])^-1,  w = F q
 *     R  = mean of E[v v' | all]            H + sum E[v x'] (sum E[x x'])^-1
 *     x0 = mean of E[x[0] | all]            P0 = mean of E[(x[0] - x0)(x[0] - x0)' | all]
 *
 * All sums are carried as triangular roots: every covariance is positive semi-definite, whatever the rounding.  H and
 * R are means over the steps that have a measurement; a missing component of such a step counts with its expectation.
 *
 *     static kq_parameters_f32 model = {0, 0, A, NULL, NULL, Q, H, R, x0, P0};
 *     static const kq_recording_f32 night = {STEPS, z, NULL, NULL};
 *     KQ_EM_F32(em, 2, 1, STEPS);
 *     kq_em_init_f32(&em, &model, NULL, &night, 1);
 *     for (int k = 0; k < 1000 && !status; k++) {
 *         status = kq_em_iterate_f32(&em);
 *         if (kq_em_change_f32(&em) <= 1e-2f && kq_em_distance_f32(&em) <= 0.02f) break;
 *     }
 *
 * In slices: call kq_em_advance until kq_em_remaining is 0, then kq_em_maximise.
 *
 * Limits.
 *   - EM converges linearly, and slowly where a noise is hard to see.  A variance falls to 0 as 1 / k.
 *   - A covariance that is 0 stays 0.  Q, and the A that it could explain, stay in the span of F and Q.
 *   - Data do not determine everything (KQ_NOT_IDENTIFIED): H and Q only as H^2 Q, A as a whole only if
 *     enough of the state is measured.
 *   - With few measurements for a full R there may be no maximum: R becomes singular, and EM ends with
 *     KQ_ERR_LIKELIHOOD and the last good parameters.
 * q31: estimate in f32 or f64, and prepare tables of the result (prepare.h).
 */
#ifndef KALMANQ_EM_H
#define KALMANQ_EM_H

#include "smoother.h"

#ifdef __cplusplus
extern "C" {
#endif

/** The model in your arrays, dense and row-major: the first guess, and the result. */
typedef struct {
    int32_t controls; /* l: 0..16 */
    int32_t noises;   /* r: columns of F, 1..n; 0 without F, then r = n */
    float *A;         /* n x n */
    const float *B;   /* n x l, not estimated; NULL if l = 0 */
    const float *F;   /* n x r, of full column rank, not estimated; NULL: the identity */
    float *Q;         /* r x r */
    float *H;         /* m x n */
    float *R;         /* m x m */
    float *x0;        /* n */
    float *P0;        /* n x n */
} kq_parameters_f32;
typedef struct {
    int32_t controls, noises; double *A; const double *B, *F; double *Q, *H, *R, *x0, *P0;
} kq_parameters_f64;

/** One recorded sequence. */
typedef struct {
    size_t steps;            /* T: 1 .. KQ_COUNT_MAX */
    const float *z;          /* T x m; what is not present is not read */
    const uint16_t *present; /* T masks, bit c: component c was measured; NULL: all were */
    const float *u;          /* T - 1 rows of l: u[t] moves x[t] to x[t+1]; NULL: no control */
} kq_recording_f32;
typedef struct { size_t steps; const double *z; const uint16_t *present; const double *u; } kq_recording_f64;

/** What may be free: one of these, or a sum. */
enum { KQ_EM_A = 1, KQ_EM_H = 2, KQ_EM_Q = 4, KQ_EM_R = 8, KQ_EM_X0 = 16, KQ_EM_P0 = 32, KQ_EM_ALL = 63 };

/** The form of Q or R: any, diagonal, or a multiple of the first one (to rounding). */
typedef enum { KQ_EM_FULL, KQ_EM_DIAGONAL, KQ_EM_MULTIPLE, KQ_EM_IS_INT = INT_MAX } kq_em_form;

/** Which parameters are free, and how. */
typedef struct {
    unsigned free; /* KQ_EM_... */
    kq_em_form Q_form, R_form;
    const uint8_t *A_held; /* n x n, not 0: the entry stays as it is; or NULL */
    const uint8_t *H_held; /* m x n */
} kq_em_choice;

/* The parts of the memory: the work of one step, the roots of sums, new parameters, and the last ones */
#define KQ_PRIVATE_EM_ROWS(n, m) ((size_t)(n) + ((n) > (m) ? (size_t)(n) : (size_t)(m)))
#define KQ_PRIVATE_EM_WORK_LEN(n, m) \
    (KQ_PRIVATE_EM_ROWS(n, m) * (KQ_PRIVATE_EM_ROWS(n, m) + 3) + KQ_TRIANGLE(KQ_PRIVATE_EM_ROWS(n, m)) + \
        (size_t)(m) * (size_t)(m))
#define KQ_PRIVATE_EM_SUMS_LEN(n, m) \
    (2 * (KQ_TRIANGLE(2 * (size_t)(n)) + KQ_TRIANGLE((size_t)(n) + (size_t)(m))) + \
        KQ_TRIANGLE((size_t)(n) + 1))
#define KQ_PRIVATE_EM_NEW_LEN(n, m) \
    (((size_t)(n)*3 + (size_t)(m) + 1) * (size_t)(n) + (size_t)(m) * (size_t)(m))
#define KQ_PRIVATE_EM_ROOTS_LEN(n, m) \
    (3 * KQ_TRIANGLE((size_t)(n)) + 2 * KQ_TRIANGLE((size_t)(m)) + (size_t)(n) * (size_t)(n))

/** Length of the memory, in words, for n states, m components and recordings of at most `steps` steps: a history of
 * the longest recording, and about 15 n^2 + 7 m n + 5 m^2.  9368 bytes in f32 at n = 2, m = 1, 200 steps. */
#define KQ_EM_LEN_F32(n, m, steps) \
    (KQ_HISTORY_LEN_F32(n, m, steps, 0) + KQ_FILTER_LEN_F32((size_t)(n)) + KQ_PRIVATE_EM_WORK_LEN(n, m) + \
        KQ_PRIVATE_EM_SUMS_LEN(n, m) + KQ_PRIVATE_EM_NEW_LEN(n, m) + KQ_PRIVATE_EM_ROOTS_LEN(n, m))
#define KQ_EM_LEN_F64(n, m, steps) \
    (KQ_HISTORY_LEN_F64(n, m, steps, 0) + KQ_FILTER_LEN_F64((size_t)(n)) + KQ_PRIVATE_EM_WORK_LEN(n, m) + \
        KQ_PRIVATE_EM_SUMS_LEN(n, m) + KQ_PRIVATE_EM_NEW_LEN(n, m) + KQ_PRIVATE_EM_ROOTS_LEN(n, m))

/* The fields are the library's (see process.h). */
typedef struct {
    uint8_t states, components; /* n, m */
    uint8_t phase; /* unused, ready, in the E-step's filter or smoother, at its end */
    uint8_t kept; /* KQ_EM_...: of those the memory has what they were before the M-step */
    size_t length; /* words at memory */
    float *memory; /* the caller's */
    const kq_parameters_f32 *model; const kq_em_choice *choice; const kq_recording_f32 *recordings;
    size_t count, recording, step; /* of recordings; the one at work; of it, the one to be done next */
    uint32_t remaining; /* steps to the end of the E-step */
    float log_likelihood;
    float before; /* the log-likelihood of the parameters before the M-step */
    float gain, change; /* of the M-step, in log-likelihood; of the last M-step, NaN: there was none */
    float rate; /* of the change, from M-step to M-step */
    kq_process_f32 process; kq_sensor_f32 sensor; kq_filter_f32 filter; kq_history_f32 history;
} kq_em_f32;
typedef struct {
    uint8_t states, components, phase, kept; size_t length; double *memory; const kq_parameters_f64 *model;
    const kq_em_choice *choice; const kq_recording_f64 *recordings; size_t count, recording, step;
    uint32_t remaining; double log_likelihood, before, gain, change, rate; kq_process_f64 process;
    kq_sensor_f64 sensor; kq_filter_f64 filter; kq_history_f64 history;
} kq_em_f64;

/* An object before init */
#define KQ_PRIVATE_EM_OBJECT(n, m, length, memory) \
    { n, m, 0, 0, length, memory, NULL, NULL, NULL, 0, 0, 0, 0, 0, 0, 0, 0, 0, {0, 0, 0, NULL, NULL, NULL, \
        NULL, {0}, 0, 0, 0}, {0, 0, 0, 0, NULL, NULL, NULL, NULL, {0}, 0, 0, 0, NULL}, {0, 0, 0, 0, 0, 0, \
        NULL, NULL, 0, 0, {0, 0, 0, 0}, {{0, 0, 0}, 0, 0, 0}}, { {NULL}, 0, 0, 0, 0, \
        0, 0, 0, 0, NULL, NULL, NULL, 0, 0 } }

/** Declares an object `name` with its static memory. */
#define KQ_EM_F32(name, n, m, steps) \
    static float name##_memory[KQ_EM_LEN_F32(n, m, steps)]; \
    static kq_em_f32 name = KQ_PRIVATE_EM_OBJECT(n, m, KQ_EM_LEN_F32(n, m, steps), name##_memory)
#define KQ_EM_F64(name, n, m, steps) \
    static double name##_memory[KQ_EM_LEN_F64(n, m, steps)]; \
    static kq_em_f64 name = KQ_PRIVATE_EM_OBJECT(n, m, KQ_EM_LEN_F64(n, m, steps), name##_memory)

/** Sets sizes and memory at run time.
 *   em       written
 *   n        1..16 states
 *   m        1..16 components
 *   memory   `length` words, yours while in use
 *   length   KQ_EM_LEN_<T>(n, m, steps) or more
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY. */
KQ_NODISCARD kq_status kq_em_assign_f32(kq_em_f32 *em, int n, int m, float *memory, size_t length);
KQ_NODISCARD kq_status kq_em_assign_f64(kq_em_f64 *em, int n, int m, double *memory, size_t length);

/** Checks model and recordings, and computes nothing.
 *   em          has sizes and memory; written
 *   model       kept by reference; kq_em_maximise writes its arrays, kq_em_advance may put them back
 *   choice      kept by reference; NULL: Q and R are free, of full form
 *   recordings  `count` of them, kept by reference.  You must not change them or their arrays
 *   count       1 .. KQ_COUNT_MAX
 * KQ_NOT_IDENTIFIED (no error, em is ready): H and Q are both free and no entry of H other than 0 is fixed.
 * KQ_ERR_NULL, KQ_ERR_SIZE (noises, controls, steps, count, choice), KQ_ERR_MEMORY (a recording is too long),
 * KQ_ERR_NOT_FINITE (parameters, z, u), KQ_ERR_NOT_SYMMETRIC, KQ_ERR_NOT_SEMIDEFINITE (Q, R, P0), KQ_ERR_NO_DATA (all
 * is missing), KQ_ERR_FEW_DATA (fewer scalar measurements than free parameters), KQ_ERR_FORM (Q or R does not have
 * its form; a multiple of 0; the columns of F are dependent).
 * Cost: each number of the recordings is looked at.  200 rows take 1 to 6 calls of kq_em_advance (n = 16 .. 2). */
KQ_NODISCARD kq_status kq_em_init_f32(kq_em_f32 *em, const kq_parameters_f32 *model,
    const kq_em_choice *choice, const kq_recording_f32 *recordings, size_t count);
KQ_NODISCARD kq_status kq_em_init_f64(kq_em_f64 *em, const kq_parameters_f64 *model,
    const kq_em_choice *choice, const kq_recording_f64 *recordings, size_t count);

/** One iteration: the whole E-step and the M-step.
 *   em       changed, with the model's free arrays
 * Accuracy: parameters after 50 iterations to 2e-14 (f64), 7e-6 (f32) of their size (tests/README.md).
 * Cost, for every step of every recording: a predict, an update, a smoother's step and about 4 n^3 multiplications;
 * 12 n^3 if A is free, 3 n^3 more if H is.  Stack: 430 words.  Errors of kq_em_advance and kq_em_maximise. */
KQ_NODISCARD kq_status kq_em_iterate_f32(kq_em_f32 *em);
KQ_NODISCARD kq_status kq_em_iterate_f64(kq_em_f64 *em);

/** One slice of the E-step: one step of the filter or of the smoother.  The first call after init, kq_em_maximise or a
 * complete E-step begins a new one with the model as it is.
 *   em       changed
 * Cost: less than a step of kq_em_iterate.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, and the errors of kq_em_init about the model.
 * KQ_ERR_LIKELIHOOD: a state overflows (KQ_EVENT_OVERFLOW of its filter), or the likelihood is infinite, 0 or not
 * representable, or lower than before kq_em_maximise by more than 64 eps (measurements + |L|).  The E-step ends.  The parameters before kq_em_maximise are put back, and
 * kq_em_log_likelihood is theirs: going on leads here again.  A model that you changed after kq_em_maximise is judged
 * in the same way; call kq_em_init. */
KQ_NODISCARD kq_status kq_em_advance_f32(kq_em_f32 *em);
KQ_NODISCARD kq_status kq_em_advance_f64(kq_em_f64 *em);

/** Calls of kq_em_advance until the E-step is complete.
 *   em       read; 0 if it is complete or has not begun, or for NULL */
uint32_t kq_em_remaining_f32(const kq_em_f32 *em);
uint32_t kq_em_remaining_f64(const kq_em_f64 *em);

/** log p(all recordings) of the parameters of the last complete E-step (those before the last kq_em_maximise), or of
 * those that were put back.
 *   em       read
 * NaN before the first one, during an E-step, and for NULL. */
float kq_em_log_likelihood_f32(const kq_em_f32 *em);
double kq_em_log_likelihood_f64(const kq_em_f64 *em);

/** The M-step: writes the free parameters to your arrays.
 *   em       changed, with the model's free arrays
 * Columns of A and H for a component of x that is always 0 stay.  With fixed entries of A (H) each row's free ones
 * are the best for the other rows as they are, last row first; the likelihood still rises.  A row of A that Q moves
 * only together with other rows stays then.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY (the E-step is not complete).
 * KQ_ERR_LIKELIHOOD: a new parameter overflows, a new covariance is not positive semi-definite, or the new R would be
 * singular in a new direction.  Model and readings stay.
 * Cost: 2 to 6 calls of kq_em_advance (n = 16 .. 2); fixed entries of A or H cost more. */
KQ_NODISCARD kq_status kq_em_maximise_f32(kq_em_f32 *em);
KQ_NODISCARD kq_status kq_em_maximise_f64(kq_em_f64 *em);

/** The largest change of the last M-step: of a covariance's entry in sigma_i sigma_j; of A, H and x0 the RMS of what
 * they move, in standard deviations of the noise.
 *   em       read
 * NaN before the first M-step, and for NULL: `kq_em_change(&em) <= tolerance` is false then.  Below 1e-6 it is
 * rounding in f32.  Alone it is a weak stop rule: use kq_em_distance, too. */
float kq_em_change_f32(const kq_em_f32 *em);
double kq_em_change_f64(const kq_em_f64 *em);

/** How far kq_em_log_likelihood is below the maximum, extrapolated: gain rate^2 / (1 - rate) of the last gain, rate =
 * change / change before.
 *   em       read
 * A difference of 0.1 does not matter: two standard deviations of a parameter are 2.  On a plateau, and in the first
 * iterations, it may be too small: ask for a small change as well.
 * NaN before the third E-step, during one, after a failed one, if the changes do not fall, and for NULL. */
float kq_em_distance_f32(const kq_em_f32 *em);
double kq_em_distance_f64(const kq_em_f64 *em);

/** The derivatives of the log-likelihood; each pointer may be NULL.  Entries of a covariance count as independent:
 * along a symmetric change E of Q it is sum_ij Q_ij E_ij. */
typedef struct {
    float *A;  /* n x n; needs a free A */
    float *H;  /* m x n; needs a free H */
    float *Q;  /* r x r */
    float *R;  /* m x m */
    float *x0; /* n; needs a free x0 */
    float *P0; /* n x n */
} kq_gradient_f32;
typedef struct { double *A, *H, *Q, *R, *x0, *P0; } kq_gradient_f64;

/** The gradient at the end of an E-step, before kq_em_maximise, by Fisher's identity from the same sums: dL/dA = Q^-1
 * sum E[w x'],  dL/dQ = (Q^-1 (sum E[w w'] - N Q) Q^-1) / 2, and so on.
 *   em       read
 *   gradient   its arrays are written.  NaN in directions in which a covariance is singular
 * Forms and fixed entries are ignored.
 * Accuracy: 3e-14 (f64), 8e-6 (f32) of its size; fewer digits for a covariance that the data hardly see.
 * Cost: 1 to 3 calls of kq_em_advance.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY (the E-step is not complete, or a parameter that must be free is not). */
KQ_NODISCARD kq_status kq_em_gradient_f32(const kq_em_f32 *em, const kq_gradient_f32 *gradient);
KQ_NODISCARD kq_status kq_em_gradient_f64(const kq_em_f64 *em, const kq_gradient_f64 *gradient);

#ifdef __cplusplus
}
#endif
#endif
