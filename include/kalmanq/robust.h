/*
 * kalmanq: outliers and jumps.
 *
 * A Kalman filter assumes that every innovation is Gaussian.  A loss says what an update does with a larger one.  One
 * measurement cannot tell an outlier from a jump of the state: a loss for one harms with the other.
 *
 *   measurement outliers   gate       rejects a measurement that is too far off
 *                          Huber      moves the mean at most as far as k sigma would
 *                          Student    gives a measurement the less weight, the farther off it is
 *   jumps of the state     jump       raises P until the measurement is likely
 *
 *     static kq_loss_f32 loss = {.kind = &kq_loss_student_f32, .parameter = 10};
 *     kq_update_robust_f32(&track, &radar, z, UINT32_MAX, &loss);
 *
 * If you know nothing of the noise: Student with nu = 10, or Huber with k = 3 (fewer instructions).  If outliers are
 * frequent: nu = 4, k = 1.5.  Jump only if you trust the sensor.  Figures: tests/README.md, "Robust losses".  For
 * jumps there are also kq_process_scale_noise and kq_smooth_reweighted.
 */
#ifndef KALMANQ_ROBUST_H
#define KALMANQ_ROBUST_H

#include "smoother.h"

#ifdef __cplusplus
extern "C" {
#endif

/** The kinds of losses.  A program links those that it names.
 *   kq_loss_huber    parameter: k > 0.  Usual: 3; 1.5 if outliers are frequent
 *   kq_loss_student  parameter: nu, 2^-20 or more.  Usual: 10; 4 if outliers are frequent
 *   kq_loss_jump     parameter: g >= 1.  Usual: 9 for Q near R, 12 to 16 for Q far below R
 *   kq_loss_gate     limit, run and rejected */
extern const struct kq_loss_kind_f32 kq_loss_huber_f32, kq_loss_student_f32, kq_loss_jump_f32, kq_loss_gate_f32;
extern const struct kq_loss_kind_f64 kq_loss_huber_f64, kq_loss_student_f64, kq_loss_jump_f64, kq_loss_gate_f64;

/** The rejections in a row that a gate allows for run = 0; and a `run` without end. */
#define KQ_GATE_RUN 8
#define KQ_GATE_CLOSED 65535

/** A loss.  You initialise it and may change it between updates.  A gate's `rejected` is written: use a gate for each
 * sensor.  Sensors may share the other losses.
 *     kq_loss_f32 huber = {.kind = &kq_loss_huber_f32, .parameter = 3, .weights = weights};
 *     kq_loss_f32 gate = {.kind = &kq_loss_gate_f32, .limit = kq_chi_square_limit_f32(2, KQ_LEVEL_9999)}; */
typedef struct kq_loss_f32 {
    const struct kq_loss_kind_f32 *kind; /* &kq_loss_..._f32 */
    float parameter;                     /* k, nu or g */
    float *weights;                      /* m, written by Huber, Student, jump: r / r' of each component
                                            (1: as it is, 0: not taken); or NULL.  Not the array z */
    float limit;                         /* of NIS: > 0, may be infinite */
    uint16_t run;                        /* after so many rejections in a row one is taken; 0: KQ_GATE_RUN */
    uint16_t rejected;                   /* in a row so far, counted up to 65535; begin with 0 */
} kq_loss_f32;
typedef struct kq_loss_f64 {
    const struct kq_loss_kind_f64 *kind; double parameter, *weights, limit; uint16_t run, rejected;
} kq_loss_f64;

/** The probability that a good measurement passes: 0.9, 0.95, 0.99, 0.999, 0.9999. */
typedef enum { KQ_LEVEL_90, KQ_LEVEL_95, KQ_LEVEL_99, KQ_LEVEL_999, KQ_LEVEL_9999 } kq_level;

/** NIS is below this limit with that probability, if the model is right.
 *   m        1..16 components that are taken
 *   level    KQ_LEVEL_...
 * From a table of 320 bytes, to 2^-25.  NaN where m or level is bad. */
float kq_chi_square_limit_f32(int m, kq_level level);
double kq_chi_square_limit_f64(int m, kq_level level);

/** kq_update_subset with a loss.
 *   f        changed
 *   s        the sensor; if it takes innovations (extended.h), z is an innovation
 *   z        m, read before anything is written
 *   present  as in kq_update_subset; UINT32_MAX: all of z
 *   loss     read; `weights` and a gate's `rejected` are written
 *
 * Huber and Student give every scalar measurement a noise r' in place of r: a component or, if R is not diagonal, a
 * decorrelated one.  With its innovation e and s = r + h'P h:
 *     Huber    r' = r for |e| <= k sqrt(s), otherwise r' = s / w - h'P h, w = k sqrt(s) / |e|:
 *              the mean moves as if e were +-k sqrt(s)
 *     Student  v ~ t(nu) of scale sqrt(r): three steps of r' = (nu r + E[v^2]) / (nu + 1) from r' = r,
 *              E[v^2] = (e r' / (h'P h + r'))^2 + h'P h r' / (h'P h + r')
 *   They protect against outliers of any size.  After a jump of the state Huber follows in steps of k sigma;
 *   Student does not follow while an outlier explains it better.  A Huber update that clips nothing is
 *   bit-identical to the plain one in mean and covariance.  If R is not diagonal, put the component first
 *   that fails first: decorrelated component c combines components c, c + 1, ...: an outlier of the last
 *   spoils all.
 * Jump replaces P by c^2 P, c^2 = (e^2 - r) / h'P h, where e^2 > g s, so that s is e^2.
 *   It protects against jumps and a wrong initial state.  The state follows every outlier, and all of P is
 *   raised.  P stays where kq_update would not take the measurement, or h'P h is rounding.  No variance is
 *   raised beyond 2^96 (f32), 2^360 (f64), 2^200 squared raw values (q31).  A history cannot undo it.
 * Gate rejects the whole measurement if its NIS is above the limit.  Mean, covariance, history and the
 *   log-likelihood of the run stay; kq_nis is the measurement's, kq_taken is 0.  It protects against single
 *   wrong measurements.  It also rejects what would correct a velocity, and may lose a state: take
 *   KQ_LEVEL_9999.  A measurement that passes gives the plain update, bit for bit, and ends the run.  After
 *   `run` rejections in a row the next measurement above the limit is taken by jump with g = 1, or plainly if
 *   a history records.  KQ_GATE_CLOSED takes none above the limit.
 *
 * NIS, log-likelihood and count are of r and of P before it is raised.  A history records the update that was made.
 * An adaptation ignores it.  A component without noise that was clipped gets some: a redundant one after it may be
 * taken.
 * Events of kq_update.  KQ_EVENT_OVERFLOW also where r' overflows (not taken) or a limit stopped the raise of P.
 * KQ_EVENT_JUMP: P was raised.  KQ_EVENT_GATED: rejected.  KQ_EVENT_REJECTIONS: a run ended.  KQ_EVENT_PRECISION
 * (jump): the raised H P H' is above 5e10 R (f32), 3e28 R (f64) or 1.8e13 R (q31); or H P H' is rounding, and P was
 * not raised.
 * Cost: the update and n^2/2 + n multiplications a scalar; Huber a root and a division, Student 8 multiplications and
 * 7 divisions, jump n^2 multiplications and two roots where P is raised.  Gate: two copies of the filter, and a
 * second update at the end of a run.
 * Stack, more than the update: 240 words (q31: 480); gate: KQ_FILTER_LEN(n) words, n rounded up to 4, 9 or 16, and at
 * the end of a run the words of jump; with innovations 32 words (f64: 16).
 * KQ_ERR_NULL (loss or its kind, too), KQ_ERR_RANGE (parameter, limit), KQ_ERR_NOT_FINITE (z, parameter),
 * KQ_ERR_RECORDING (jump: a history, a lag or an instant is attached; innovations: an adaptation or a freeze), and
 * the errors of kq_update_subset. */
KQ_NODISCARD kq_status kq_update_robust_f32(kq_filter_f32 *f, const kq_sensor_f32 *s, const float *z,
    uint32_t present, kq_loss_f32 *loss);
KQ_NODISCARD kq_status kq_update_robust_f64(kq_filter_f64 *f, const kq_sensor_f64 *s, const double *z,
    uint32_t present, kq_loss_f64 *loss);

/** Makes a process with q Q in place of Q: more noise during a manoeuvre, steps with weights (below).
 *   target   a process of n states with its own memory; written.  A and B are the source's, by reference
 *   source   read; may be a const table
 *   q        >= 0; 1 gives a root that is bit-identical to the source's.  A variance of 0 stays 0
 * Cost: n^2/2 multiplications, one root.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY (source), KQ_ERR_SIZE, KQ_ERR_MEMORY (target), KQ_ERR_MISMATCH (states, or target is
 * source), KQ_ERR_NOT_FINITE (q, or the root overflows), KQ_ERR_NOT_SEMIDEFINITE (q < 0). */
KQ_NODISCARD kq_status kq_process_scale_noise_f32(kq_process_f32 *target, const kq_process_f32 *source, float q);
KQ_NODISCARD kq_status kq_process_scale_noise_f64(kq_process_f64 *target, const kq_process_f64 *source, double q);

/** Smooths a history whose steps had scaled noise, and writes the scales of the next pass.  The passes give the
 * smoother Student-t process noise: w ~ N(0, q Q), nu / q chi-square with nu degrees of freedom;
 *     q[t] becomes (nu + E[w_t'Q^-1 w_t | T]) / (nu + rank of Q)
 *   h        recorded; step t by kq_predict with target scaled by q[t].  Smoothed as by kq_smooth
 *   target   as for kq_process_scale_noise; written
 *   source   the process with q = 1, read
 *   nu       > 0.  Usual: 2
 *   q        kq_history_steps() - 1 numbers, read and written: of this pass, of the next
 *
 *     q[t] = 16 for all t
 *     five times:
 *         kq_filter_init, kq_attach
 *         for each t:  kq_process_scale_noise(&target, &source, q[t]);
 *                      kq_predict(&filter, &target, u[t]);  kq_update(&filter, &sensor, z[t]);
 *         kq_smooth_reweighted(&history, &target, &source, nu, q);
 *
 * Begin above 1, or large jumps are found slowly: 4 to 8 passes from q = 16, 12 from 1.  It protects against jumps,
 * which the plain smoother smears; outliers become jumps.  P0 is not weighed: an x0 off by many sigma bends the first
 * steps.  Begin with a diffuse start (diffuse.h) or a wide P0.
 * Cost: kq_smooth, and 3 n^3 multiplications a step.
 * KQ_ERR_RANGE (nu), KQ_ERR_MISMATCH (states, or source is target), KQ_ERR_RECORDING (the history of a kq_jacobians),
 * and the errors of kq_smooth and kq_process_scale_noise. */
KQ_NODISCARD kq_status kq_smooth_reweighted_f32(kq_history_f32 *h, kq_process_f32 *target,
    const kq_process_f32 *source, float nu, float *q);
KQ_NODISCARD kq_status kq_smooth_reweighted_f64(kq_history_f64 *h, kq_process_f64 *target,
    const kq_process_f64 *source, double nu, double *q);

/* ------------------------------------------------------------------ q31, as f32
 *
 * Parameters, weights and q are kq_scaled_q31 as in a table (KQ_ERR_COEFFICIENT: mantissa not normalised,
 * exponent beyond 1000).  As f64 to 1e-6 sigma.
 */

extern const struct kq_loss_kind_q31 kq_loss_huber_q31, kq_loss_student_q31, kq_loss_jump_q31, kq_loss_gate_q31;

typedef struct kq_loss_q31 {
    const struct kq_loss_kind_q31 *kind; kq_scaled_q31 parameter, *weights;
    int64_t limit; /* in Q39.24, as kq_nis_q31 */
    uint16_t run, rejected;
} kq_loss_q31;

/** In Q39.24.  KQ_NOT_A_SCORE_Q31 where m or level is bad. */
int64_t kq_chi_square_limit_q31(int m, kq_level level);

/** As kq_update_robust_f32; also KQ_ERR_COEFFICIENT (parameter). */
KQ_NODISCARD kq_status kq_update_robust_q31(kq_filter_q31 *f, const kq_sensor_q31 *s, const int32_t *z,
    uint32_t present, kq_loss_q31 *loss);
/** As kq_process_scale_noise_f32.
 *   target   needs no init or memory
 *   root     KQ_ROOT_LEN_Q31(n) words, written; yours while the target is in use; not the source's own
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_MISMATCH (target is source, or has its root), KQ_ERR_COEFFICIENT (q; an
 * exponent of the root), KQ_ERR_NOT_SEMIDEFINITE. */
KQ_NODISCARD kq_status kq_process_scale_noise_q31(kq_process_q31 *target, const kq_process_q31 *source,
    int32_t *root, kq_scaled_q31 q);
/** As kq_smooth_reweighted_f32.  Errors and KQ_EVENT_SATURATED: as kq_process_scale_noise_q31 and kq_smooth_q31.
 *   root     as for kq_process_scale_noise_q31 */
KQ_NODISCARD kq_status kq_smooth_reweighted_q31(kq_history_q31 *h, kq_process_q31 *target,
    const kq_process_q31 *source, int32_t *root, kq_scaled_q31 nu, kq_scaled_q31 *q);

#ifdef __cplusplus
}
#endif
#endif
