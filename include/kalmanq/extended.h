/*
 * kalmanq: nonlinear models, the extended filter and smoothers.
 *
 *     x[t+1] = f(x[t]) + w,   w ~ N(0, Q)          z[t] = h(x[t]) + v,   v ~ N(0, R)
 *
 * You evaluate f, h and their Jacobians A = df/dx, H = dh/dx at the mean:
 *     predict   x <- x + d,  d = f(x) - x                       P <- A P A' + Q
 *     update    e = z - h(x),  x <- x + K e                     P <- P - K S K'
 * The library calls no function of yours.  kq_predict_extended takes the increment d.  A sensor of
 * kq_sensor_init_extended takes the innovation e in place of z, in all updates:
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
 * If only one of f and h is nonlinear, use kq_predict, or kq_update with a plain sensor, for the other one.
 *
 * Form d without f(x): a float of f(x) has lost bits that d has.  If x' = x + v dt, d is v dt.  Form all components
 * of e at the same x, and wrap the innovation of an angle to -pi .. pi.
 *
 * Error states.  An attitude may be a quaternion of yours and a small rotation in the state.  After an update put the
 * rotation into the quaternion and take it out of the mean: kq_move(&track, -mean).  P stays.
 *
 * Smoothing.  All smoothers smooth these runs as linear ones; kq_smooth is the extended Rauch-Tung-Striebel
 * smoother.  A history needs a kq_jacobians, with room for the A of each step; one process may then change at every
 * step.  A smoothed mean is of the state as the next predict found it: after a kq_move, the moved one.
 *
 * If R is much smaller than H P H', linearise h where the update ends, not where it begins: sigma_points.h.
 *
 * An adaptation and a freeze refuse linearised predicts and innovations (KQ_ERR_RECORDING), kq_steady_init such a
 * sensor (KQ_ERR_MISMATCH).  kq_innovation, kq_consistency_watch and the z of kq_measurement use H x.  Give the first
 * two e, and a copy of the filter (kq_filter_copy) that kq_move has set to 0.  The S of kq_measurement is right;
 * kq_nis, kq_taken and log-likelihoods are of e.
 */
#ifndef KALMANQ_EXTENDED_H
#define KALMANQ_EXTENDED_H

#include "sensor.h"
#include "smoother.h"

#ifdef __cplusplus
extern "C" {
#endif

/** x <- x + d,  P <- A P A' + Q.
 *   f        changed
 *   p        its A is the Jacobian of f at the mean (kq_process_change_transition).  B is not used.
 *   d        n, f(x) - x in the states' units
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_MISMATCH (number of states), KQ_ERR_NOT_FINITE (d), KQ_ERR_RECORDING (an
 * adaptation, a freeze, or a history without a kq_jacobians is attached).
 * Events: KQ_EVENT_OVERFLOW as kq_predict; KQ_EVENT_HISTORY_FULL: the history or its kq_jacobians is full.
 * Accuracy: P as kq_predict; the mean is rounded at d, not at x.
 * Cost: kq_predict without the n^2 multiplications of A x.  With a history n^2 words are copied and
 * n (n + 1) / 2 compared.  Stack: as kq_predict; with a lag or an instant 2n words (f64: n) more. */
KQ_NODISCARD kq_status kq_predict_extended_f32(kq_filter_f32 *f, const kq_process_f32 *p, const float *d);
KQ_NODISCARD kq_status kq_predict_extended_f64(kq_filter_f64 *f, const kq_process_f64 *p, const double *d);

/** As kq_sensor_init, kq_sensor_init_diagonal and kq_sensor_init_lean (sensor.h), for a sensor that takes innovations:
 * kq_update, kq_update_subset and kq_update_robust take in place of z
 *     e        m, z - h(x); not the filter's memory.  If h is linearised at c: z - h(c) - H (x - c).
 *   s        as for those
 *   H        m x n, the Jacobian of h at the mean (kq_sensor_change_measurement); kept by reference
 *   R        as for kq_sensor_init
 *   r        as for kq_sensor_init_diagonal
 * kq_step takes e at the mean that its predict leaves.  A fixed_size step leaves such a sensor to the library.
 * Errors: of the init.  An update also answers KQ_ERR_RECORDING (an adaptation or a freeze is attached) and
 * KQ_ERR_NOT_READY (a diffuse start has unknown states).  Events of an update: KQ_EVENT_OVERFLOW also if the mean
 * overflows, as in kq_predict.  Cost of an update: 4n additions, stack: 32 words more (f64: 16). */
KQ_NODISCARD kq_status kq_sensor_init_extended_f32(kq_sensor_f32 *s, const float *H, const float *R);
KQ_NODISCARD kq_status kq_sensor_init_extended_f64(kq_sensor_f64 *s, const double *H, const double *R);
KQ_NODISCARD kq_status kq_sensor_init_diagonal_extended_f32(kq_sensor_f32 *s, const float *H, const float *r);
KQ_NODISCARD kq_status kq_sensor_init_diagonal_extended_f64(kq_sensor_f64 *s, const double *H, const double *r);
KQ_NODISCARD kq_status kq_sensor_init_lean_extended_f32(kq_sensor_f32 *s, const float *H, const float *r);
KQ_NODISCARD kq_status kq_sensor_init_lean_extended_f64(kq_sensor_f64 *s, const double *H, const double *r);

/** x <- x + d, P stays: an error state goes back to 0, an angle turns by 2 pi, an origin moves.
 *   f        changed
 *   d        n, in the states' units
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_NOT_FINITE (d), KQ_ERR_RECORDING (an adaptation, a freeze).
 * Events: KQ_EVENT_OVERFLOW: a mean overflowed, as in kq_predict.  Cost: 3n additions. */
KQ_NODISCARD kq_status kq_move_f32(kq_filter_f32 *f, const float *d);
KQ_NODISCARD kq_status kq_move_f64(kq_filter_f64 *f, const double *d);

/* The fields are the library's (see process.h). */
typedef struct {
    struct kq_attached_f32 attached;
    uint8_t states;            /* n */
    size_t predicts, length;   /* at processes; words at memory */
    kq_process_f32 *processes; /* yours: a copy of each predict's process */
    float *memory;             /* yours: their A, and G where it has changed */
    size_t kept, used;         /* of both */
    const float *noise;        /* G of the last one */
    kq_history_f32 *history;   /* whose predicts they are */
} kq_jacobians_f32;

typedef struct {
    struct kq_attached_f64 attached; uint8_t states; size_t predicts, length; kq_process_f64 *processes;
    double *memory; size_t kept, used; const double *noise; kq_history_f64 *history;
} kq_jacobians_f64;

extern const struct kq_hooks_f32 kq_jacobians_hooks_f32; /* what it does in the steps */
extern const struct kq_hooks_f64 kq_jacobians_hooks_f64;

/** Words at `memory` of what a history keeps of linearised predicts, besides its own memory (KQ_HISTORY_LEN: each of
 * them is a change there).
 *   predicts   the most linearised predicts; as many processes
 *   noises     how many of them have another Q than the one before, the first included: 1 if Q never changes; all of
 *              them with kq_predict_sigma_points (sigma_points.h)
 * One in f32 on a 32-bit chip, Q constant, with its history: 232, 416, 752 bytes at (4,2), (6,3), (9,3). */
#define KQ_JACOBIANS_LEN_F32(n, predicts, noises) \
    ((kq_length)(predicts) * (kq_length)(n) * (kq_length)(n) + \
        (kq_length)(noises)*KQ_TRIANGLE((kq_length)(n)))
#define KQ_JACOBIANS_LEN_F64 KQ_JACOBIANS_LEN_F32

/** Declares a kq_jacobians `name` of the history `tape`, with its memory, static. */
#define KQ_JACOBIANS_F32(name, tape, n, predicts, noises) \
    KQ_PRIVATE_JACOBIANS(f32, float, name, tape, n, predicts, KQ_JACOBIANS_LEN_F32(n, predicts, noises))
#define KQ_JACOBIANS_F64(name, tape, n, predicts, noises) \
    KQ_PRIVATE_JACOBIANS(f64, double, name, tape, n, predicts, KQ_JACOBIANS_LEN_F64(n, predicts, noises))
#define KQ_PRIVATE_JACOBIANS(T, number, name, tape, n, predicts, length) \
    static kq_process_##T name##_processes[predicts]; \
    static number name##_memory[length]; \
    static kq_jacobians_##T name = {{&kq_jacobians_hooks_##T}, n, predicts, length, name##_processes, \
        name##_memory, 0, 0, NULL, &tape}

/** Gives a kq_jacobians its size and memory at run time.
 *   j          written
 *   h          the history whose predicts it keeps; by reference
 *   n          1..16 states
 *   processes  `predicts` of them, yours while in use; need not be initialised
 *   predicts   1 or more
 *   memory     `length` words, yours while in use
 *   length     KQ_JACOBIANS_LEN_<T>(n, predicts, noises), or at least enough for one predict
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY.
 * Attach it in place of the history, which is empty then and records:
 *
 *     KQ_HISTORY_F32(tape, N, M, STEPS, STEPS);
 *     KQ_JACOBIANS_F32(jacobians, tape, N, STEPS, 1);
 *     kq_attach_f32(&track, &jacobians.attached);
 *
 * It copies the process of each linearised predict: you may change A and Q at once.  A plain kq_predict is recorded
 * by reference: its process must not change (smoother.h).  j and its memory must stay until the history is smoothed
 * or detached; kq_detach of either detaches both.
 * kq_smooth, kq_smooth_states, kq_smooth_step (p: NULL) and fixed_size steps smooth the history; kq_smooth_reweighted
 * answers KQ_ERR_RECORDING.
 * kq_attach answers what it answers for a history, and KQ_ERR_SIZE or KQ_ERR_MEMORY (j without its own),
 * KQ_ERR_MISMATCH (states), KQ_ERR_NOT_READY (a diffuse start has unknown states). */
KQ_NODISCARD kq_status kq_jacobians_assign_f32(kq_jacobians_f32 *j, kq_history_f32 *h, int n,
    kq_process_f32 *processes, size_t predicts, float *memory, size_t length);
KQ_NODISCARD kq_status kq_jacobians_assign_f64(kq_jacobians_f64 *j, kq_history_f64 *h, int n,
    kq_process_f64 *processes, size_t predicts, double *memory, size_t length);

/* ------------------------------------------------------------------ q31, as in f32
 *
 * d is in the states' formats, e in the sensor's.  The format and range of a sensor describe its INNOVATION,
 * not h(x).  The bearing of a target at 4 m has 1 / r in H: its format needs room for
 * sum_k |H_ck| (fixed_point.h), however small z is.
 * The mean does not go through A, so kq_process_change_jacobian_q31 limits neither its row sums nor A_ii.
 */

typedef struct {
    struct kq_attached_q31 attached; uint8_t states; size_t predicts, length; kq_process_q31 *processes;
    int32_t *memory; size_t kept, used; const int32_t *noise; kq_history_q31 *history;
} kq_jacobians_q31;

extern const struct kq_hooks_q31 kq_jacobians_hooks_q31;

#define KQ_JACOBIANS_LEN_Q31(n, predicts, noises) \
    ((kq_length)(predicts)*2 * (kq_length)(n) * (kq_length)(n) + \
        (kq_length)(noises)*KQ_ROOT_LEN_Q31((kq_length)(n)))

#define KQ_JACOBIANS_Q31(name, tape, n, predicts, noises) \
    KQ_PRIVATE_JACOBIANS(q31, int32_t, name, tape, n, predicts, KQ_JACOBIANS_LEN_Q31(n, predicts, noises))

KQ_NODISCARD kq_status kq_jacobians_assign_q31(kq_jacobians_q31 *j, kq_history_q31 *h, int n,
    kq_process_q31 *processes, size_t predicts, int32_t *memory, size_t length);

/** Changes A for kq_predict_extended alone and keeps the noise.  All other calls with p then answer KQ_ERR_NOT_READY
 * until p is initialised again.  A history with a plain predict by p answers KQ_ERR_CHANGED.
 *   p            initialised; changed
 *   A            n x n in raw values, kept by reference.  New content in the same array is a change too.
 *   range_error  written: KQ_NO_RANGE_ERROR, or the row that is refused (KQ_STATE, the row, 0 bits); or NULL
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_COEFFICIENT (see fixed_point.h).
 * Cost: n^2 comparisons, 1.5 n^2 integer multiplications. */
KQ_NODISCARD kq_status kq_process_change_jacobian_q31(kq_process_q31 *p, const kq_scaled_q31 *A,
    kq_range_error_q31 *range_error);

/** As kq_sensor_init_extended_f32, from a table.
 *   s            written; needs no memory
 *   table        as for kq_sensor_init_q31; its arrays are kept by reference
 *   range_error  as for kq_sensor_init_q31, or NULL
 * Errors: as kq_sensor_init_q31. */
KQ_NODISCARD kq_status kq_sensor_init_extended_q31(kq_sensor_q31 *s, const kq_sensor_table_q31 *table,
    kq_range_error_q31 *range_error);
KQ_NODISCARD kq_status kq_sensor_init_diagonal_extended_q31(kq_sensor_q31 *s,
    const kq_sensor_table_q31 *table, kq_range_error_q31 *range_error);
KQ_NODISCARD kq_status kq_sensor_init_lean_extended_q31(kq_sensor_q31 *s, const kq_sensor_table_q31 *table,
    kq_range_error_q31 *range_error);

/** As the f32 functions.  KQ_ERR_RANGE: also an entry of d is KQ_NOT_A_VALUE_Q31, or in an update an entry of e is
 * outside the sensor's declared range.  KQ_EVENT_SATURATED: the mean was saturated.
 * With a lag or an instant attached A must keep the limits of kq_process_init_q31 (KQ_ERR_RANGE, KQ_ERR_COEFFICIENT),
 * and KQ_EVENT_SATURATED also says that A x would have been saturated. */
KQ_NODISCARD kq_status kq_predict_extended_q31(kq_filter_q31 *f, const kq_process_q31 *p, const int32_t *d);
KQ_NODISCARD kq_status kq_move_q31(kq_filter_q31 *f, const int32_t *d);

#ifdef __cplusplus
}
#endif
#endif
