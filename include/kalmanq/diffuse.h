/*
 * kalmanq: the diffuse start: a state of which some components, or all, are not known at all (exact diffuse
 * initialisation).
 *
 *     x0_i known:     as in kq_filter_init       x0_i unknown:   "P0_ii = infinity"
 *
 * It is exact: no large number in P0, which would leave its trace in the estimates and cost digits.  The state is
 * x = x^ + S xi + D delta with xi ~ N(0, I) and delta flat.  D has a column for each of the d dimensions that are
 * still unknown.  A scalar measurement z = h'x + v with D'h = 0 is an ordinary update of x^ and S.  Any other takes
 * one dimension away.  At d = 0 the filter has the limit of ever larger P0: the least-squares solution.
 *
 * The start is attached to its filter, and takes its predicts, updates and steps until d = 0; then the filter goes
 * on by itself.  While d > 0, a component that is not determined reads NaN.  What needs all of the state
 * (kq_covariance, kq_gain, kq_measurement, kq_forecast, robust updates, a lag) answers KQ_ERR_NOT_READY.
 *
 *     kq_diffuse_init_f32(&start, &track, x0, P0, 3);         components 0 and 1 are unknown
 *     ... kq_update_f32(&track, &radar, z);
 *         kq_predict_f32(&track, &motion, NULL);
 *         if (kq_diffuse_count_f32(&start) == 0) ...          track is ready
 *
 * What counts as 0.  The start follows the covariance of D's rounding errors through every step: h'D within 16
 * standard errors of 0 is 0.  A component counts as determined when its row of D is 0.
 *   - What little information determines is as uncertain as rounding: about eps over its share of the terms.
 *     KQ_EVENT_PRECISION: a measurement saw 4 to 32 standard errors; sigmas of states just determined may be wrong.
 *   - Where modes of A grow apart, by g in all steps since the start, what has grown hides the others from eps g on.
 *     A component then may count as determined though it depends, by that little, on something unknown.
 *   - What is hidden keeps d > 0, unless the volumes |det A| of all steps multiply to less than 1/256: then it counts
 *     as decayed.  So an A of determinant 0 that also grows may have the filter ready too early.
 * Measured against ranks in exact arithmetic: tests/README.md, Accuracy.
 *
 * Log-likelihood: the exact diffuse filter's.  A measurement that takes a dimension away adds
 * -(log 2 pi + log phi^2) / 2, phi^2 = h'D D'h in the states' physical units; the others add as usual.  The sum is
 * the limit of log L + (d / 2) log kappa for P0_ii = kappa -> infinity (Durbin and Koopman's L_d; the same number as
 * statsmodels' exact diffuse llf).  Packages that leave log 2 pi out of the diffuse steps differ by (d / 2) log 2 pi.
 * kq_taken counts such a measurement, NIS does not: NIS is chi-square with kq_taken() less the fall of
 * kq_diffuse_count().
 *
 * Sources: Durbin and Koopman, Time Series Analysis by State Space Methods, 2nd ed. (2012), ch. 5 and 7; Koopman,
 * Exact initial Kalman filtering and smoothing, JASA 92 (1997); de Jong, The diffuse Kalman filter, Ann. Statist. 19
 * (1991), whose augmented state this is, with the unknowns removed one by one.
 */
#ifndef KALMANQ_DIFFUSE_H
#define KALMANQ_DIFFUSE_H

#include "smoother.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * Words of memory of a start.
 *   n        states
 *   early    instants that are to be smoothed (below); 0 without a smoother
 * Bytes in f32 at n = 2, 4: 76 and 244; with instants 132 and 420, and for each of them 72 and 220.
 */
#define KQ_PRIVATE_DIFFUSE_PAST_LEN_F32(n) (KQ_FILTER_LEN_F32(n) + (2 * (n) + 1) * (n) + 1)
#define KQ_PRIVATE_DIFFUSE_PAST_LEN_F64(n) (KQ_FILTER_LEN_F64(n) + (2 * (n) + 1) * (n) + 1)
#define KQ_DIFFUSE_LEN_F32(n, early)                                                                 \
    (3 * (kq_length)(n) * ((kq_length)(n) + 1) + 1 +                                               \
     ((early) > 0) * (2 * (kq_length)(n) + 3) * (kq_length)(n) +                                   \
     (kq_length)(early) * (kq_length)KQ_PRIVATE_DIFFUSE_PAST_LEN_F32(n))
#define KQ_DIFFUSE_LEN_F64(n, early)                                                                 \
    (3 * (kq_length)(n) * ((kq_length)(n) + 1) + 1 +                                               \
     ((early) > 0) * (2 * (kq_length)(n) + 3) * (kq_length)(n) +                                   \
     (kq_length)(early) * (kq_length)KQ_PRIVATE_DIFFUSE_PAST_LEN_F64(n))

/* The fields are the library's (see process.h). */
typedef struct {
    struct kq_attached_f32 attached;
    uint8_t states;   /* n */
    uint8_t unknowns; /* d */
    uint8_t ready;    /* what the filter's `ready` is when the start works on it */
    uint8_t phase;    /* unused, waiting, smoothed, means smoothed */
    uint16_t early;   /* instants that there is room for */
    uint16_t next;    /* of them: that of the step to come */
    uint32_t steps;   /* predicts before the filter was ready */
    float *memory;    /* the caller's: D, workspace, instants */
    kq_filter_f32 *filter;
    kq_history_f32 *tape; /* records from d = 0 on, or NULL */
} kq_diffuse_f32;

typedef struct {
    struct kq_attached_f64 attached;
    uint8_t states;   /* n */
    uint8_t unknowns; /* d */
    uint8_t ready;    /* what the filter's `ready` is when the start works on it */
    uint8_t phase;    /* unused, waiting, smoothed, means smoothed */
    uint16_t early;   /* instants that there is room for */
    uint16_t next;    /* of them: that of the step to come */
    uint32_t steps;   /* predicts before the filter was ready */
    double *memory;   /* the caller's: D, workspace, instants */
    kq_filter_f64 *filter;
    kq_history_f64 *tape; /* records from d = 0 on, or NULL */
} kq_diffuse_f64;

/** A start `name` with its storage, in static memory. */
#define KQ_DIFFUSE_F32(name, n, early)                                                               \
    static float name##_memory[KQ_DIFFUSE_LEN_F32(n, early)];                                        \
    static kq_diffuse_f32 name = {{NULL}, n, 0, 0, 0, early, 0, 0, name##_memory, NULL, NULL}
#define KQ_DIFFUSE_F64(name, n, early)                                                               \
    static double name##_memory[KQ_DIFFUSE_LEN_F64(n, early)];                                       \
    static kq_diffuse_f64 name = {{NULL}, n, 0, 0, 0, early, 0, 0, name##_memory, NULL, NULL}

/**
 * Sizes and memory known at run time only (the macros do the same at compile time).
 *   s        written
 *   n        1..16
 *   early    0..65534
 *   length   words at memory: KQ_DIFFUSE_LEN_<T>(n, early)
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY.
 */
KQ_NODISCARD kq_status kq_diffuse_assign_f32(kq_diffuse_f32 *s, int n, size_t early, float *memory, size_t length);
KQ_NODISCARD kq_status kq_diffuse_assign_f64(kq_diffuse_f64 *s, int n, size_t early, double *memory, size_t length);

/**
 * The state before the first measurement, in part unknown; otherwise as kq_filter_init.
 *   s        sizes and memory read, the rest written.  Attached to f until d = 0.  s and f refer to each other until
 *            then, s to f until the next init, which does not look at it.
 *   f        written; not ready while a component is unknown
 *   x0       n.  For an unknown component it is the origin of its numbers: any value gives the same result but for
 *            rounding, and one near the truth rounds less.
 *   P0       n x n; rows and columns of unknown components are not read; may be NULL where all are unknown
 *   unknown  bit i set: component i is unknown (bits n and above are ignored); 0: as kq_filter_init
 * Cost: as kq_filter_init.  While d > 0, besides the filter's: a predict 2 n^3 + n^3 / 3 + n^2 d multiplications, a
 * measurement n^2 + n d, one that takes a dimension away n^3 + 2 n^2 more; each early instant 3 n^3 a predict, n^2 a
 * measurement, 4 n^3 to take a dimension away.
 * Stack: 680 words.  While d > 0, besides the filter's: n^2 numbers, 280 words in f32 and 550 in q31.
 * Accuracy: a mean is off by about eps times the distance that it has moved from x0, a row of S by a few n eps of
 * the sigma of z in its units.  An observability (D'h against the terms h_i D_ij of its sum) below 16 eps counts as
 * none.  A column of D below 2^-120 (f32), 2^-400 (f64) of its unit counts as forgotten; below the root of these its
 * rounding is no longer followed.
 * KQ_EVENT_OVERFLOW: a move was not representable, and was not taken.
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY (s or f was never given them), KQ_ERR_MISMATCH (states),
 * KQ_ERR_NOT_FINITE, KQ_ERR_NOT_SYMMETRIC, KQ_ERR_NOT_SEMIDEFINITE, KQ_ERR_RANGE (a known variance or the size of any
 * x0_i above 2^120 in f32, 2^1000 in f64).
 */
KQ_NODISCARD kq_status kq_diffuse_init_f32(kq_diffuse_f32 *s, kq_filter_f32 *f, const float *x0, const float *P0,
                            uint32_t unknown);
KQ_NODISCARD kq_status kq_diffuse_init_f64(kq_diffuse_f64 *s, kq_filter_f64 *f, const double *x0, const double *P0,
                            uint32_t unknown);

/** d: how many dimensions are still unknown.  0: the filter is ready.  -1 where s is bad. */
int kq_diffuse_count_f32(const kq_diffuse_f32 *s);
int kq_diffuse_count_f64(const kq_diffuse_f64 *s);

/** Is component i determined by what has come so far?  0 where s or i is bad. */

/* ------------------------------------------------------------------ smoother
 *
 * A history cannot record a state that is not determined.  Attached to a filter with a start, it begins when d = 0.
 * Until then the start carries the early instants along, the latest `early` of them, and smoothing completes them.
 *
 *     KQ_HISTORY_F32(tape, 2, 1, 100, 0);
 *     KQ_DIFFUSE_F32(start, 2, 4);                        room for the first 4 steps
 *     kq_filter_f32 view;                               without memory
 *     kq_diffuse_init_f32(...);   kq_attach_f32(&track, &tape.attached);
 *     ... updates and predicts ...
 *     kq_diffuse_smooth_f32(&start);
 *     kq_diffuse_smoothed_f32(&start, t, &view);          t = 0, 1, ... from the start
 *     kq_mean_f32(&view, i);   kq_sigma_f32(&view, i);
 *
 * Steps are counted from kq_attach.  Step t is step t - kq_diffuse_steps() of the history where that is not
 * negative: lag-one covariances and noises are to be had from there on only.
 *     Until d = 0 the history's memory is scratch; it needs room for one step of one measurement (KQ_ERR_MEMORY).
 * Start, filter and history have to outlive each other until kq_detach, and the history also as long as its
 * steps are shown.  kq_diffuse_init forgets the history, without looking at it.
 */

/** The number of early steps: predicts from attach until the filter was ready, or until now; where the state was
    smoothed before it was determined, the steps that were.  And the first step that can be smoothed: not 0 where
    there were more than there is room for.  0 where s is bad. */
size_t kq_diffuse_steps_f32(const kq_diffuse_f32 *s, size_t *first);
size_t kq_diffuse_steps_f64(const kq_diffuse_f64 *s, size_t *first);

/**
 * Smooths the history and the early steps, before the history is used for anything else.
 *   s        of a filter with a history.  The history may be smoothed already, by kq_smooth or kq_smooth_step to the
 *            end; by kq_smooth_states: then there are means only.
 * If the state is still not determined, all steps are early ones.  The present one is the last of them and needs
 * room, too.  The components that all data determine are smoothed.  The start goes on without a history, and what has
 * been smoothed stays, until kq_attach.
 * Cost: the history's, and n^3 / 2 + 2 n^3 an early step.
 * KQ_SATURATED (q31): a state saturated (KQ_EVENT_SATURATED, not cleared): the results may be wrong.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_HISTORY_EMPTY (no history attached, or it has another filter; smoothed
 * already; not determined and no room), KQ_ERR_HISTORY_FULL, KQ_ERR_CHANGED (smoother.h; the processes of early steps
 * may change).
 */
KQ_NODISCARD kq_status kq_diffuse_smooth_f32(kq_diffuse_f32 *s);
KQ_NODISCARD kq_status kq_diffuse_smooth_f64(kq_diffuse_f64 *s);

/**
 * Shows step t, given all measurements, in a view, as kq_smoothed does.
 *   s        smoothed; keeps what is shown, with its history
 *   t        0, 1, ...: counted from kq_attach
 *   view     written; without memory.  A component that all data do not determine reads NaN, and then
 *            kq_covariance answers KQ_ERR_NOT_READY.  After an error all readings are NaN.
 * KQ_ERR_NULL, KQ_ERR_SIZE (t), KQ_ERR_NOT_READY (not smoothed, or t is before kq_diffuse_first()).
 */
KQ_NODISCARD kq_status kq_diffuse_smoothed_f32(const kq_diffuse_f32 *s, size_t t, kq_filter_f32 *view);
KQ_NODISCARD kq_status kq_diffuse_smoothed_f64(const kq_diffuse_f64 *s, size_t t, kq_filter_f64 *view);

/* ------------------------------------------------------------------ q31, as in f32
 *
 * The declared ranges are knowledge: a direction of the unknown has a sigma of one third of the range.  A
 * measurement that tells more than half of that defines the direction exactly, as in f32.  One that tells less is an
 * ordinary measurement: the direction gets that prior, with mean x0.  So give an x0 in the middle of the range, and a
 * range of 10 sigma where the start has to be exact.  While d > 0 the log-likelihood counts the unknown in ranges,
 * from d = 0 on in physical units.
 * KQ_EVENT_SATURATED (in the filter): a state was beyond its range.  Early instants may be up to 64 words from 0 until
 * they are smoothed; what is shown of them then saturates.
 * Accuracy: a row of S to 2^-26 of the sigma of z in its units each time a dimension goes; an observability below
 * 2^-26 counts as none.
 */

#define KQ_PRIVATE_DIFFUSE_PAST_LEN_Q31(n) (KQ_FILTER_LEN_Q31(n) + (4 * (n) + 2) * (n) + 1)
#define KQ_DIFFUSE_LEN_Q31(n, early)                                                                 \
    ((5 * (kq_length)(n) + 4) * (kq_length)(n) + 4 +                                               \
     ((early) > 0) * (2 * (kq_length)(n) + 4) * (kq_length)(n) +                                   \
     (kq_length)(early) * (kq_length)KQ_PRIVATE_DIFFUSE_PAST_LEN_Q31(n))

/* The fields are the library's. */
typedef struct {
    struct kq_attached_q31 attached;
    uint8_t states;
    uint8_t unknowns;
    uint8_t ready;
    uint8_t phase;
    uint16_t early;
    uint16_t next;
    uint32_t steps;
    int32_t *memory;
    kq_filter_q31 *filter;
    kq_history_q31 *tape;
} kq_diffuse_q31;

#define KQ_DIFFUSE_Q31(name, n, early)                                                               \
    static int32_t name##_memory[KQ_DIFFUSE_LEN_Q31(n, early)];                                      \
    static kq_diffuse_q31 name = {{NULL}, n, 0, 0, 0, early, 0, 0, name##_memory, NULL, NULL}

KQ_NODISCARD kq_status kq_diffuse_assign_q31(kq_diffuse_q31 *s, int n, size_t early, int32_t *memory, size_t length);

/**
 * As in f32, of a table.
 *   prior    all of it is checked but the rows of the root of unknown components, which are not
 *            looked at; their means are where their words are counted from
 *   range_error   as for kq_filter_init_q31, or NULL
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY, KQ_ERR_MISMATCH (states), KQ_ERR_RANGE, KQ_ERR_TABLE.
 */
KQ_NODISCARD kq_status kq_diffuse_init_q31(kq_diffuse_q31 *s, kq_filter_q31 *f, const kq_prior_table_q31 *prior,
                            uint32_t unknown, kq_range_error_q31 *range_error);

int kq_diffuse_count_q31(const kq_diffuse_q31 *s);

size_t kq_diffuse_steps_q31(const kq_diffuse_q31 *s, size_t *first);
KQ_NODISCARD kq_status kq_diffuse_smooth_q31(kq_diffuse_q31 *s);

/** As in f32. */
KQ_NODISCARD kq_status kq_diffuse_smoothed_q31(const kq_diffuse_q31 *s, size_t t, kq_filter_q31 *view);

#ifdef __cplusplus
}
#endif
#endif
