/*
 * kalmanq: the diffuse start: some components of x0, or all, are unknown ("P0_ii = infinity").
 *
 * This is exact diffuse initialisation, without a large number in P0.  The state is x = x^ + S xi + D delta with xi ~
 * N(0, I) and delta flat; D has a column for each of the d dimensions that are still unknown.  A scalar measurement z
 * = h'x + v with D'h = 0 is an ordinary update.  Any other removes one dimension.  At d = 0 the filter is the limit
 * of ever larger P0: the least-squares solution.
 *
 *     kq_diffuse_init_f32(&start, &track, x0, P0, 3);         components 0 and 1 are unknown
 *     ... kq_update_f32(&track, &radar, z);
 *         kq_predict_f32(&track, &motion, NULL);
 *         if (kq_diffuse_count_f32(&start) == 0) ...          track is ready
 *
 * The start is attached to its filter and takes part in its steps until d = 0.  Until then kq_mean(f, i), kq_mean_low
 * and kq_sigma are NaN (q31: KQ_NOT_A_VALUE_Q31) for each component i that is not determined yet.  Calls that need
 * the whole state (kq_covariance, kq_gain, kq_forecast, robust updates, a lag, ...) answer KQ_ERR_NOT_READY.
 *
 * Limits (tests/README.md, "Accuracy").  h'D within 16 standard errors of its rounding counts as 0.
 * KQ_EVENT_PRECISION: a measurement saw 4 to 32 standard errors, and sigmas of states that it determined may be
 * wrong.  Modes of A that grow far apart hide small dependences: where they have grown for many predicts before the first
 * measurements, a start may not end, and sigmas may be wrong without an event.  Begin it with the measurements.
 *
 * Log-likelihood: the exact diffuse one (Durbin and Koopman's L_d, statsmodels' llf).  Packages that leave log 2 pi
 * out of the diffuse steps differ by (d / 2) log 2 pi.  kq_taken counts a measurement that removes a dimension, NIS
 * does not: its degrees of freedom are kq_taken() less the fall of kq_diffuse_count().
 */
#ifndef KALMANQ_DIFFUSE_H
#define KALMANQ_DIFFUSE_H

#include "smoother.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Length of a start's memory, in words.
 *   n        states
 *   early    early steps to smooth (below); 0 without a smoother
 * Bytes in f32 at n = 2, 4: 76 and 244; with early steps 132 and 420, and 72 and 220 for each. */
#define KQ_PRIVATE_DIFFUSE_PAST_LEN_F32(n) (KQ_FILTER_LEN_F32(n) + (2 * (n) + 1) * (n) + 1)
#define KQ_PRIVATE_DIFFUSE_PAST_LEN_F64(n) (KQ_FILTER_LEN_F64(n) + (2 * (n) + 1) * (n) + 1)
#define KQ_DIFFUSE_LEN_F32(n, early) \
    (3 * (kq_length)(n) * ((kq_length)(n) + 1) + 1 + ((early) > 0) * (2 * (kq_length)(n) + \
        3) * (kq_length)(n) + (kq_length)(early) * (kq_length)KQ_PRIVATE_DIFFUSE_PAST_LEN_F32(n))
#define KQ_DIFFUSE_LEN_F64(n, early) \
    (3 * (kq_length)(n) * ((kq_length)(n) + 1) + 1 + ((early) > 0) * (2 * (kq_length)(n) + \
        3) * (kq_length)(n) + (kq_length)(early) * (kq_length)KQ_PRIVATE_DIFFUSE_PAST_LEN_F64(n))

/* The fields are the library's (see process.h). */
typedef struct {
    struct kq_attached_f32 attached;
    uint8_t states, unknowns, ready; /* n; d; what the filter's `ready` is when the start works on it */
    uint8_t phase; /* unused, waiting, smoothed, means smoothed */
    uint16_t early, next; /* room for so many instants; index of the next step's */
    uint32_t steps; /* predicts before the filter was ready */
    float *memory; /* the caller's: D, workspace, instants */
    kq_filter_f32 *filter;
    kq_history_f32 *tape; /* records from d = 0 on, or NULL */
} kq_diffuse_f32;
typedef struct {
    struct kq_attached_f64 attached; uint8_t states, unknowns, ready, phase; uint16_t early, next;
    uint32_t steps; double *memory; kq_filter_f64 *filter; kq_history_f64 *tape;
} kq_diffuse_f64;

/** Declares a start `name` with its static memory. */
#define KQ_DIFFUSE_F32(name, n, early) \
    static float name##_memory[KQ_DIFFUSE_LEN_F32(n, early)]; \
    static kq_diffuse_f32 name = {{NULL}, n, 0, 0, 0, early, 0, 0, name##_memory, NULL, NULL}
#define KQ_DIFFUSE_F64(name, n, early) \
    static double name##_memory[KQ_DIFFUSE_LEN_F64(n, early)]; \
    static kq_diffuse_f64 name = {{NULL}, n, 0, 0, 0, early, 0, 0, name##_memory, NULL, NULL}

/** Sets sizes and memory at run time.
 *   s        written
 *   n        1..16 states
 *   early    0..65534 early steps to smooth
 *   memory   `length` words, yours while in use
 *   length   KQ_DIFFUSE_LEN_<T>(n, early) or more
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY. */
KQ_NODISCARD kq_status kq_diffuse_assign_f32(kq_diffuse_f32 *s, int n, size_t early, float *memory, size_t length);
KQ_NODISCARD kq_status kq_diffuse_assign_f64(kq_diffuse_f64 *s, int n, size_t early, double *memory, size_t length);

/** Initialises a filter whose x0 is in part unknown.
 *   s        has sizes and memory; written, and attached to f until d = 0.  s and f must both exist until then; s
 *            refers to f until the next init, which does not look at it
 *   f        written; not ready while d > 0
 *   x0       n.  For an unknown component any value will do; near the truth it rounds least
 *   P0       n x n; rows and columns of unknown components are not read.  May be NULL if all are unknown
 *   unknown  bit i: component i is unknown (bits n and above are ignored); 0: as kq_filter_init
 * Events: KQ_EVENT_OVERFLOW: a move of the mean was not representable, and was not made; or a measurement left a
 * sigma above 2^60 (f32), 2^500 (f64), and 2^60 or 2^500 is its prior.
 * Accuracy: a mean is off by about eps times its distance from x0, a row of S by a few n eps of the sigma of z in its
 * units.  An observability below 16 eps counts as 0.
 * Cost: as kq_filter_init.  While d > 0, besides the filter's, in multiplications: a predict 2.3 n^3 + n^2 d, a
 * measurement n^2 + n d, one that removes a dimension n^3 + 2 n^2 more.  Each early step adds 3 n^3 to a predict, n^2
 * to a measurement, 4 n^3 to the removal of a dimension.
 * Stack: 680 words; while d > 0 n^2 numbers and 280 (f32) or 550 (q31) words more than the filter.
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY (s or f was never assigned), KQ_ERR_MISMATCH (states), KQ_ERR_NOT_FINITE,
 * KQ_ERR_NOT_SYMMETRIC, KQ_ERR_NOT_SEMIDEFINITE, KQ_ERR_RANGE (a known variance or any |x0_i| above 2^120 in f32,
 * 2^1000 in f64). */
KQ_NODISCARD kq_status kq_diffuse_init_f32(kq_diffuse_f32 *s, kq_filter_f32 *f, const float *x0,
    const float *P0, uint32_t unknown);
KQ_NODISCARD kq_status kq_diffuse_init_f64(kq_diffuse_f64 *s, kq_filter_f64 *f, const double *x0,
    const double *P0, uint32_t unknown);

/** d, the number of unknown dimensions; 0: the filter is ready.
 *   s        read; -1 if it is NULL or not initialised */
int kq_diffuse_count_f32(const kq_diffuse_f32 *s);
int kq_diffuse_count_f64(const kq_diffuse_f64 *s);

/* ------------------------------------------------------------------ smoother
 *
 * A history attached to a filter with a start records from d = 0 on.  Until then the start keeps the latest
 * `early` steps, and smoothing completes them.
 *
 *     KQ_HISTORY_F32(tape, 2, 1, 100, 0);
 *     KQ_DIFFUSE_F32(start, 2, 4);                        room for 4 early steps
 *     kq_diffuse_init_f32(...);   kq_attach_f32(&track, &tape.attached);
 *     ... updates and predicts ...
 *     kq_diffuse_smooth_f32(&start);
 *     kq_diffuse_smoothed_f32(&start, t, &view);          t = 0, 1, ... from kq_attach on
 *
 * Step t is step t - kq_diffuse_steps() of the history.  Only steps of the history have lag-one covariances
 * and noises.  Until d = 0 the history's memory is scratch: it needs room for one step of one measurement
 * (KQ_ERR_MEMORY of kq_attach).  Start, filter and history must all exist until kq_detach, the history also
 * while its steps are shown.  kq_diffuse_init forgets the history without looking at it.
 */

/** The number of early steps: predicts from kq_attach until the filter was ready, or until now.  After a
 * kq_diffuse_smooth with d > 0: the steps up to then, the last one included.
 *   s        read
 *   first    written: the first step that can be smoothed, above 0 if there was no room for all; or NULL
 * 0, and first 0, where s is NULL or not initialised. */
size_t kq_diffuse_steps_f32(const kq_diffuse_f32 *s, size_t *first);
size_t kq_diffuse_steps_f64(const kq_diffuse_f64 *s, size_t *first);

/** Smooths the history and the early steps.
 *   s        of a filter with a history; changed.  kq_smooth, or kq_smooth_step to the end, may have smoothed the
 *            history already; after kq_smooth_states there are means only
 * If d > 0 still, all steps are early, the present one too, which needs room as well.  The components that all data
 * determine are smoothed.  The start goes on without a history.  The results stay until kq_attach.
 * Events: as kq_smooth.  Cost: the history's, and 2.5 n^3 multiplications an early step.
 * KQ_SATURATED (q31): a state saturated, results may be wrong; KQ_EVENT_SATURATED is set.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_HISTORY_EMPTY (no history, or it has another filter; smoothed already; d > 0
 * and no room), KQ_ERR_HISTORY_FULL, KQ_ERR_CHANGED (not by early steps). */
KQ_NODISCARD kq_status kq_diffuse_smooth_f32(kq_diffuse_f32 *s);
KQ_NODISCARD kq_status kq_diffuse_smooth_f64(kq_diffuse_f64 *s);

/** Shows step t, given all measurements, in a view (kq_smoothed).
 *   s        smoothed; keeps what is shown, with its history
 *   t        0, 1, ... from kq_attach on
 *   view     written; without memory.  A component that is not determined reads NaN, and kq_covariance then answers
 *            KQ_ERR_NOT_READY.  After an error all readings are NaN
 * KQ_ERR_NULL, KQ_ERR_SIZE (t), KQ_ERR_NOT_READY (not smoothed, or t is before `first` of kq_diffuse_steps),
 * KQ_ERR_MISMATCH (view is the start's filter).  Cost: at most n^2 comparisons. */
KQ_NODISCARD kq_status kq_diffuse_smoothed_f32(const kq_diffuse_f32 *s, size_t t, kq_filter_f32 *view);
KQ_NODISCARD kq_status kq_diffuse_smoothed_f64(const kq_diffuse_f64 *s, size_t t, kq_filter_f64 *view);

/* ------------------------------------------------------------------ q31, as f32
 *
 * The declared ranges are knowledge: an unknown direction has a sigma of one third of the range.  A
 * measurement that tells more than half of it determines the direction exactly, as f32.  One that tells less
 * is an ordinary measurement, and the direction gets this prior with mean x0.  So put x0 in the middle of the
 * range, and declare a range of 10 sigma where the start has to be exact.  KQ_EVENT_PRECISION: a direction got
 * this prior.  An exact start's mean or sigma then differs by 5 % of sigma or more.  Clear it once later
 * measurements tell more than the ranges.  While d > 0 the log-likelihood counts the unknown in ranges, from d = 0
 * on in physical units.
 * KQ_EVENT_SATURATED (in the filter): a state left its range.  Early steps may be up to 64 * 2^31 raw values
 * from 0 until they are smoothed; what is shown of them saturates.
 * Accuracy: a row of S to 2^-26 of the sigma of z in its units each time a dimension goes.  An observability
 * below 2^-26 counts as 0.
 */

#define KQ_PRIVATE_DIFFUSE_PAST_LEN_Q31(n) (KQ_FILTER_LEN_Q31(n) + (4 * (n) + 2) * (n) + 1)
#define KQ_DIFFUSE_LEN_Q31(n, early) \
    ((5 * (kq_length)(n) + 4) * (kq_length)(n) + 4 + ((early) > 0) * (2 * (kq_length)(n) + \
        4) * (kq_length)(n) + (kq_length)(early) * (kq_length)KQ_PRIVATE_DIFFUSE_PAST_LEN_Q31(n))

typedef struct {
    struct kq_attached_q31 attached; uint8_t states, unknowns, ready, phase; uint16_t early, next;
    uint32_t steps; int32_t *memory; kq_filter_q31 *filter; kq_history_q31 *tape;
} kq_diffuse_q31;

#define KQ_DIFFUSE_Q31(name, n, early) \
    static int32_t name##_memory[KQ_DIFFUSE_LEN_Q31(n, early)]; \
    static kq_diffuse_q31 name = {{NULL}, n, 0, 0, 0, early, 0, 0, name##_memory, NULL, NULL}

KQ_NODISCARD kq_status kq_diffuse_assign_q31(kq_diffuse_q31 *s, int n, size_t early, int32_t *memory, size_t length);

/** As kq_diffuse_init_f32, from a table.
 *   prior    read; checked but for the root's rows of unknown components.  Their means are as x0 of f32
 *   range_error   as for kq_filter_init_q31, or NULL
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY, KQ_ERR_MISMATCH (states), KQ_ERR_RANGE, KQ_ERR_TABLE. */
KQ_NODISCARD kq_status kq_diffuse_init_q31(kq_diffuse_q31 *s, kq_filter_q31 *f,
    const kq_prior_table_q31 *prior, uint32_t unknown, kq_range_error_q31 *range_error);

int kq_diffuse_count_q31(const kq_diffuse_q31 *s);
size_t kq_diffuse_steps_q31(const kq_diffuse_q31 *s, size_t *first);
KQ_NODISCARD kq_status kq_diffuse_smooth_q31(kq_diffuse_q31 *s);
KQ_NODISCARD kq_status kq_diffuse_smoothed_q31(const kq_diffuse_q31 *s, size_t t, kq_filter_q31 *view);

#ifdef __cplusplus
}
#endif
#endif
