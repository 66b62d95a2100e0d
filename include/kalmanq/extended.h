/*
 * kalmanq: nonlinear models, the extended filter and smoothers.
 *
 *     x[t+1] = f(x[t]) + w,   w ~ N(0, Q)          z[t] = h(x[t]) + v,   v ~ N(0, R)
 *
 * You evaluate f and h and their Jacobians A = df/dx and H = dh/dx at the mean; the library does the rest as
 * it does for a linear model:
 *     predict   x <- x + d,  d = f(x) - x                       P <- A P A' + Q
 *     update    e = z - h(x),  x <- x + K e                     P <- P - K S K'
 * No function of yours is called.  A predict takes the increment d (kq_predict_extended).  A sensor that was prepared
 * by kq_sensor_init_extended takes the innovation e in the place of a measurement, in all updates:
 *
 *     kq_sensor_init_extended_f32(&radar, H, R);
 *     ...
 *     increment(&track, d), jacobian_of_f(&track, A);       yours: read kq_mean, write d (n) and A (n x n)
 *     kq_process_change_transition_f32(&motion, A);
 *     kq_predict_extended_f32(&track, &motion, d);
 *     innovation(&track, z, e), jacobian_of_h(&track, H);   yours: e (m) and H (m x n)
 *     kq_sensor_change_measurement_f32(&radar, H);
 *     kq_update_f32(&track, &radar, e);
 *
 * If only one of f and h is nonlinear, the other one's step is the plain one: kq_predict, or kq_update by a plain
 * sensor.
 *
 * You give the increment d = f(x) - x, not f(x).  Where the state is 1000 m and moves by 0.1 m a step, a float of
 * f(x) has lost bits that a float of d still has, and the mean of f32 is a pair of floats.  Form d without f(x): if
 * x' = x + v dt, it is v dt.
 * You give e, not h(x), because only you know which component is an angle: wrap its innovation to -pi .. pi.  All
 * components of e are at the same x; the library takes them one after the other, and corrects each for what those
 * before it have moved.
 *
 * Error states.  Of an attitude the state may be a small rotation beside a quaternion of yours: after an update
 * put it into the quaternion and take it out of the mean, kq_move(&track, -mean).  The covariance stays.
 *
 * Smoothing.  No smoother reads how a mean has moved, so all of them smooth these runs, exactly as the linear
 * ones: kq_smooth is the extended Rauch-Tung-Striebel smoother.  A fixed lag (lag.h) and an instant (instant.h)
 * are attached as usual.  A history needs room for the A of each step: kq_jacobians.  One process
 * may then change at every step.  A smoothed mean is that of the state as it was when its step was left by a
 * predict: after a kq_move, that of the moved one.
 *
 * Iterating.  Where R is much smaller than H P H', h is to be linearised where the update comes out,
 * not where it begins: sigma_points.h says when and how.
 *
 * What else takes a measurement or predicts: an adaptation (adaptation.h) and a freeze (steady.h) refuse
 * linearised predicts and innovations (KQ_ERR_RECORDING).  kq_innovation, kq_consistency_watch and the
 * measurement of kq_measurement mean H x, whatever the sensor takes: on a copy (kq_filter_copy) moved to 0 by kq_move
 * the first two take e for z.  kq_measurement's S is right.  kq_nis, kq_taken, the log-likelihoods are those of e.
 *
 * Sources: Jazwinski, Stochastic Processes and Filtering Theory (1970), chapter 8; Lefferts, Markley and
 * Shuster, Kalman filtering for spacecraft attitude estimation, J. Guidance 5 (1982), for error states.
 */
#ifndef KALMANQ_EXTENDED_H
#define KALMANQ_EXTENDED_H

#include "sensor.h"
#include "smoother.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * x <- x + d,  P <- A P A' + Q.
 *   p        A is the Jacobian of f at the mean (kq_process_change_transition).  Its B is not used.
 *   d        n, f(x) - x in the states' units
 * Cost: kq_predict's, without the n^2 multiplications of A x.  With a history attached n^2 words are copied, and
 * n (n + 1) / 2 compared with those of the predict before it.
 * Stack: as kq_predict; with a lag or an instant 2n words (f64: n) more.
 * Accuracy: of P that of kq_predict; the mean is rounded at d, not at x.
 * Events: KQ_EVENT_OVERFLOW as kq_predict.  KQ_EVENT_HISTORY_FULL where the history or its room is full.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_MISMATCH (number of states), KQ_ERR_NOT_FINITE (d), KQ_ERR_RECORDING (an
 * adaptation, a freeze, or a history without a kq_jacobians).
 */
KQ_NODISCARD kq_status kq_predict_extended_f32(kq_filter_f32 *f, const kq_process_f32 *p, const float *d);
KQ_NODISCARD kq_status kq_predict_extended_f64(kq_filter_f64 *f, const kq_process_f64 *p, const double *d);

/**
 * kq_sensor_init, kq_sensor_init_diagonal and kq_sensor_init_lean (sensor.h) of a sensor that takes innovations.
 * Where an update has z, it has
 *     e        m, z - h(x).  With h linearised at another point c than the mean: z - h(c) - H (x - c).
 *              Read before anything is written; may not be the filter's memory.
 * and H is the Jacobian of h at the mean (kq_sensor_change_measurement).  kq_update, kq_update_subset and
 * kq_update_robust take it.  kq_step is kq_predict, then kq_update: e is at the mean that the predict leaves.
 * The functions for compile-time sizes (src/fixed_size/) leave such a sensor to these.
 * Of an update, beside what it says itself:
 * Cost: 4n additions.  Stack: 32 words more (f64: 16).
 * Events: a mean that overflows is lost as by kq_predict, with KQ_EVENT_OVERFLOW (filter.h).
 * KQ_ERR_RECORDING: an adaptation or a freeze is attached.  KQ_ERR_NOT_READY: a start of which something is
 * unknown (diffuse.h).
 * The errors of the init.
 */
KQ_NODISCARD kq_status kq_sensor_init_extended_f32(kq_sensor_f32 *s, const float *H, const float *R);
KQ_NODISCARD kq_status kq_sensor_init_extended_f64(kq_sensor_f64 *s, const double *H, const double *R);
KQ_NODISCARD kq_status kq_sensor_init_diagonal_extended_f32(kq_sensor_f32 *s, const float *H, const float *r);
KQ_NODISCARD kq_status kq_sensor_init_diagonal_extended_f64(kq_sensor_f64 *s, const double *H, const double *r);
KQ_NODISCARD kq_status kq_sensor_init_lean_extended_f32(kq_sensor_f32 *s, const float *H, const float *r);
KQ_NODISCARD kq_status kq_sensor_init_lean_extended_f64(kq_sensor_f64 *s, const double *H, const double *r);

/**
 * x <- x + d, P as it is: an error state goes back to 0, an angle turns by 2 pi, an origin moves.
 *   d        n, in the states' units
 * Cost: 3n additions.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_NOT_FINITE (d), KQ_ERR_RECORDING (an adaptation or a freeze is attached).
 */
KQ_NODISCARD kq_status kq_move_f32(kq_filter_f32 *f, const float *d);
KQ_NODISCARD kq_status kq_move_f64(kq_filter_f64 *f, const double *d);

/* The fields are the library's (see process.h). */
typedef struct {
    struct kq_attached_f32 attached;
    uint8_t states;            /* n */
    size_t predicts;           /* at processes */
    size_t length;             /* words at memory */
    kq_process_f32 *processes; /* the caller's: a copy of each predict's process */
    float *memory;             /* the caller's: their A, and G where it has changed */
    size_t kept, used;         /* of both */
    const float *noise;        /* G of the last one */
    kq_history_f32 *history; /* whose predicts they are */
} kq_jacobians_f32;

extern const struct kq_hooks_f32 kq_jacobians_hooks_f32; /* what it does in the steps */

typedef struct {
    struct kq_attached_f64 attached;
    uint8_t states;
    size_t predicts;
    size_t length;
    kq_process_f64 *processes;
    double *memory;
    size_t kept, used;
    const double *noise;
    kq_history_f64 *history;
} kq_jacobians_f64;

extern const struct kq_hooks_f64 kq_jacobians_hooks_f64;

/**
 * What a history keeps of linearised predicts, beside its own memory, of which each of them is a change
 * (KQ_HISTORY_LEN, KQ_HISTORY_F32).  Words at `memory`:
 *   n          states, 1..16
 *   predicts   the most linearised predicts; as many processes
 *   noises     of how many of them Q is not what it was at the one before, the first one among them: 1 where Q
 *              never changes; all of them with kq_predict_sigma_points (sigma_points.h)
 * Bytes of a linearised predict on a 32-bit chip in f32, Q constant, the tape's own included: 232, 416, 752 at
 * (n, m) = (4,2), (6,3), (9,3).
 */
#define KQ_JACOBIANS_LEN_F32(n, predicts, noises)                                                  \
    ((kq_length)(predicts) * (kq_length)(n) * (kq_length)(n) +                                     \
     (kq_length)(noises)*KQ_TRIANGLE((kq_length)(n)))
#define KQ_JACOBIANS_LEN_F64 KQ_JACOBIANS_LEN_F32

/** Such a keeper `name` of the history `tape`, with its storage, in static memory. */
#define KQ_JACOBIANS_F32(name, tape, n, predicts, noises)                                          \
    static kq_process_f32 name##_processes[predicts];                                              \
    static float name##_memory[KQ_JACOBIANS_LEN_F32(n, predicts, noises)];                         \
    static kq_jacobians_f32 name = {                                                               \
        {&kq_jacobians_hooks_f32}, n, predicts, KQ_JACOBIANS_LEN_F32(n, predicts, noises), name##_processes, \
        name##_memory, 0, 0, NULL, &tape}
#define KQ_JACOBIANS_F64(name, tape, n, predicts, noises)                                          \
    static kq_process_f64 name##_processes[predicts];                                              \
    static double name##_memory[KQ_JACOBIANS_LEN_F64(n, predicts, noises)];                        \
    static kq_jacobians_f64 name = {                                                               \
        {&kq_jacobians_hooks_f64}, n, predicts, KQ_JACOBIANS_LEN_F64(n, predicts, noises), name##_processes, \
        name##_memory, 0, 0, NULL, &tape}

/**
 * Sizes and memory known at run time only (the macros do the same at compile time).
 *   j          written
 *   h          the history whose predicts it keeps; by reference
 *   n          1..16
 *   processes  `predicts` of them, at least 1; need not be initialised
 *   memory     KQ_JACOBIANS_LEN_<T>(n, predicts, noises) words, at least those of one predict
 *   length     words at memory
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY.
 */
KQ_NODISCARD kq_status kq_jacobians_assign_f32(kq_jacobians_f32 *j, kq_history_f32 *h, int n, kq_process_f32 *processes,
                                  size_t predicts, float *memory, size_t length);
KQ_NODISCARD kq_status kq_jacobians_assign_f64(kq_jacobians_f64 *j, kq_history_f64 *h, int n, kq_process_f64 *processes,
                                  size_t predicts, double *memory, size_t length);

/*
 * For a run with kq_predict_extended attach j, in the place of its history:
 *
 *     KQ_HISTORY_F32(tape, N, M, STEPS, STEPS);
 *     KQ_JACOBIANS_F32(jacobians, tape, N, STEPS, 1);
 *     kq_attach_f32(&track, &jacobians.attached);
 *
 * The history is empty then, and records.  j keeps a copy of the process of each linearised predict, so that its A and
 * its Q may change at once.  A plain kq_predict is recorded by reference, and its process must not change (smoother.h).
 * j and its memory have to stay until the history is smoothed or detached.  kq_detach of either detaches both.
 *
 * kq_smooth, kq_smooth_states, kq_smooth_step (p: NULL) and what src/fixed_size/ has of them then smooth it.
 * kq_smooth_reweighted, which has one process for all steps, is refused (KQ_ERR_RECORDING).
 * kq_attach answers what it answers of a history; KQ_ERR_SIZE, KQ_ERR_MEMORY for a j that was never given its own,
 * KQ_ERR_MISMATCH (states), KQ_ERR_NOT_READY for a filter whose start is in part unknown.
 */

/* ------------------------------------------------------------------ q31, as in f32
 *
 * d is in words of the states' formats, e in those of the sensor's.  So a sensor's format is that of its
 * INNOVATION, and its range is that of e and not of h(x): the bearing of a target 4 m away, whose H has 1 / r in
 * it, needs a format with room for sum_k |H_ck| of the other states' words (fixed_point.h), be z ever so small.
 *
 * No mean goes through A, so the sums of its rows, and A_ii, are not limited where A is given by
 * kq_process_change_jacobian_q31.
 */

/* The fields are the library's. */
typedef struct {
    struct kq_attached_q31 attached;
    uint8_t states;
    size_t predicts;
    size_t length;
    kq_process_q31 *processes;
    int32_t *memory;
    size_t kept, used;
    const int32_t *noise;
    kq_history_q31 *history;
} kq_jacobians_q31;

extern const struct kq_hooks_q31 kq_jacobians_hooks_q31;

#define KQ_JACOBIANS_LEN_Q31(n, predicts, noises)                                                  \
    ((kq_length)(predicts)*2 * (kq_length)(n) * (kq_length)(n) +                                   \
     (kq_length)(noises)*KQ_ROOT_LEN_Q31((kq_length)(n)))

#define KQ_JACOBIANS_Q31(name, tape, n, predicts, noises)                                          \
    static kq_process_q31 name##_processes[predicts];                                              \
    static int32_t name##_memory[KQ_JACOBIANS_LEN_Q31(n, predicts, noises)];                       \
    static kq_jacobians_q31 name = {                                                               \
        {&kq_jacobians_hooks_q31}, n, predicts, KQ_JACOBIANS_LEN_Q31(n, predicts, noises), name##_processes, \
        name##_memory, 0, 0, NULL, &tape}

KQ_NODISCARD kq_status kq_jacobians_assign_q31(kq_jacobians_q31 *j, kq_history_q31 *h, int n, kq_process_q31 *processes,
                                  size_t predicts, int32_t *memory, size_t length);

/**
 * Another A with the noise as it is, for kq_predict_extended alone: to all else p is not ready from then on, until
 * it is initialised again, and a history that recorded a plain predict by it is not smoothed (KQ_ERR_CHANGED).
 *   p        initialised before
 *   A        n x n in words, kept by reference.  The same array with new content counts as another A.
 *   range_error   written: KQ_NO_RANGE_ERROR, or the row that is refused (KQ_STATE, the row, 0 bits); or NULL
 * Checked: each coefficient has a mantissa and an exponent within their limits (fixed_point.h), of any size.
 * Cost: n^2 comparisons, 1.5 n^2 integer multiplications.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_COEFFICIENT.
 */
KQ_NODISCARD kq_status kq_process_change_jacobian_q31(kq_process_q31 *p, const kq_scaled_q31 *A,
                                         kq_range_error_q31 *range_error);

KQ_NODISCARD kq_status kq_sensor_init_extended_q31(kq_sensor_q31 *s, const kq_sensor_table_q31 *table, kq_range_error_q31 *range_error);
KQ_NODISCARD kq_status kq_sensor_init_diagonal_extended_q31(kq_sensor_q31 *s, const kq_sensor_table_q31 *table,
                                               kq_range_error_q31 *range_error);
KQ_NODISCARD kq_status kq_sensor_init_lean_extended_q31(kq_sensor_q31 *s, const kq_sensor_table_q31 *table,
                                           kq_range_error_q31 *range_error);

/**
 * KQ_ERR_RANGE also where an entry of d is KQ_NOT_A_VALUE_Q31; an update's also where an entry of e is beyond the
 * sensor's declared range.  KQ_EVENT_SATURATED where the mean is held at the end of its word.
 *     With a lag or an instant attached, whose predict forms A x before it is replaced, A is held to the limits of
 * kq_process_init_q31 (KQ_ERR_RANGE, KQ_ERR_COEFFICIENT), and KQ_EVENT_SATURATED also tells that A x would have left its
 * word.
 */
KQ_NODISCARD kq_status kq_predict_extended_q31(kq_filter_q31 *f, const kq_process_q31 *p, const int32_t *d);
KQ_NODISCARD kq_status kq_move_q31(kq_filter_q31 *f, const int32_t *d);

#ifdef __cplusplus
}
#endif
#endif
