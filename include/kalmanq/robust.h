/*
 * kalmanq: outliers and jumps.
 *
 * A Kalman filter believes that every surprise is Gaussian.  A loss says what an update does with a surprise that is
 * not.  A filter cannot tell a wrong measurement from a state that has jumped by looking at one of them, and a loss
 * against one of the two does harm on the other.  Choose by what your sensors and your states do.
 *
 *   measurement outliers   gate       a measurement that is too far off is not taken
 *                          Huber      ... moves the mean as far as k sigma would
 *                          Student    ... counts the less, the farther off it is
 *   jumps of the state     jump       P is raised until the measurement is likely
 *
 *     static kq_loss_f32 loss = {.kind = &kq_loss_student_f32, .parameter = 10};
 *     kq_update_robust_f32(&track, &radar, z, UINT32_MAX, &loss);
 *
 * When nothing is known of the noise: Student with nu = 10, or Huber with k = 3 where instructions count.  Where
 * outliers are frequent: nu = 4, k = 1.5.  Jump only where the sensor is trusted.  With 10 % outliers of sd 10 the
 * Student update with nu = 4 is within 6 % of the exact posterior mean while Q is at most 0.1 R, and the plain
 * filter is 2.3 to 2.7 times off (tests/README.md, "Accuracy", has all figures).
 *
 * For jumps there are also kq_process_scale_noise and kq_smooth_reweighted, which raise the process noise.
 *
 * Sources: Huber, Robust Statistics (1981); Masreliez and Martin, Robust Bayesian estimation for
 * the linear model and robustifying the Kalman filter, IEEE Trans. Automatic Control 22 (1977);
 * Lange, Little and Taylor, Robust statistical modeling using the t distribution, J. Amer. Statist.
 * Assoc. 84 (1989); Bar-Shalom, Li and Kirubarajan, Estimation with Applications to
 * Tracking and Navigation (2001), for gates.
 */
#ifndef KALMANQ_ROBUST_H
#define KALMANQ_ROBUST_H

#include "smoother.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------ losses */

/**
 * What is done for a loss.  A program links the losses that its initialisers name.
 *   kq_loss_huber    parameter: k > 0.  Usual: 3; 1.5 where outliers are frequent
 *   kq_loss_student  parameter: nu, 2^-20 or more.  Usual: 10; 4 where outliers are frequent
 *   kq_loss_jump     parameter: g >= 1.  Usual: 9 for Q near R, 12 to 16 for Q far below R
 *   kq_loss_gate     limit, run and rejected
 */
extern const struct kq_loss_kind_f32 kq_loss_huber_f32, kq_loss_student_f32, kq_loss_jump_f32, kq_loss_gate_f32;
extern const struct kq_loss_kind_f64 kq_loss_huber_f64, kq_loss_student_f64, kq_loss_jump_f64, kq_loss_gate_f64;

/** How many rejections in a row a gate allows if `run` is 0; and a `run` that never ends. */
#define KQ_GATE_RUN 8
#define KQ_GATE_CLOSED 65535

/**
 * A loss.  You initialise it and may change it between updates.  Only a gate's `rejected` is written: each sensor
 * needs a gate of its own, and any number of sensors may share another loss.
 *     kq_loss_f32 huber = {.kind = &kq_loss_huber_f32, .parameter = 3, .weights = weights};
 *     kq_loss_f32 gate = {.kind = &kq_loss_gate_f32, .limit = kq_chi_square_limit_f32(2, KQ_LEVEL_9999)};
 */
typedef struct kq_loss_f32 {
    const struct kq_loss_kind_f32 *kind; /* &kq_loss_..._f32 */
    float parameter;                     /* k, nu or g */
    float *weights;                      /* m, written by Huber, Student and jump: r / r' of each component, 1 for one
                                            that was taken as it is, 0 for one that was not taken; or NULL.  Not in
                                            the place of z */
    float limit;                         /* of NIS: > 0, may be infinite */
    uint16_t run;                        /* after so many rejections in a row one is taken; 0: KQ_GATE_RUN */
    uint16_t rejected;                   /* in a row so far, counted up to 65535; begin with 0 */
} kq_loss_f32;

typedef struct kq_loss_f64 {
    const struct kq_loss_kind_f64 *kind;
    double parameter;
    double *weights;
    double limit;
    uint16_t run;
    uint16_t rejected;
} kq_loss_f64;

/** The probability that a good measurement passes: 0.9, 0.95, 0.99, 0.999, 0.9999. */
typedef enum { KQ_LEVEL_90, KQ_LEVEL_95, KQ_LEVEL_99, KQ_LEVEL_999, KQ_LEVEL_9999 } kq_level;

/**
 * The value that NIS stays below with that probability, if the model is right.
 *   m        1..16 components that are taken
 * A table of 320 bytes; to 2^-25.  NaN where m or level is bad.
 */
float kq_chi_square_limit_f32(int m, kq_level level);
double kq_chi_square_limit_f64(int m, kq_level level);

/* ------------------------------------------------------------------ the update */

/**
 * kq_update_subset with a loss.
 *   f        moved
 *   s        the sensor.  One that takes innovations (extended.h) is taken with an innovation in z.
 *   z        m, read before anything is written
 *   present  as in kq_update_subset; UINT32_MAX: all of z
 *   loss     what to do with a surprise
 *
 * Huber and Student give every scalar measurement a noise r' of its own: a component or, where R is not diagonal,
 * a decorrelated one.  With its innovation e and s = r + h'P h:
 *     Huber    |e| <= k sqrt(s): r' = r;  beyond it r' = s / w - h'P h, w = k sqrt(s) / |e|:
 *              the mean moves as if e were +-k sqrt(s)
 *     Student  v ~ t(nu) of scale sqrt(r): three steps, from r' = r, of
 *              r' = (nu r + E[v^2]) / (nu + 1),
 *              E[v^2] = (e r' / (h'P h + r'))^2 + h'P h r' / (h'P h + r')
 *   Protects against outliers of any size.  Harms: Huber follows a jump of the state in steps of k sigma; Student does
 *   not follow it while an outlier explains it better.
 *   Where R is not diagonal, decorrelated component c combines components c, c + 1, ...: an outlier of the last one
 *   spoils them all.  Put the one that fails first.
 *   A Huber update that clips nothing is bit-identical to the plain one in mean and covariance.
 *
 * Jump raises P where e^2 > g s: P becomes c^2 P with c^2 = (e^2 - r) / h'P h, so that s is e^2.
 *   Protects against jumps and a wrong initial state.  Harms: the state follows every outlier, all of the way, and all
 *   of P is raised, also where the jump was not.
 *   Where kq_update would not take the measurement, or h'P h is rounding, P stays.  No variance, h'P h among them, is
 *   raised beyond 2^96 (f32), 2^360 (f64) or 2^200 squared raw values (q31).
 *   A history cannot undo it.
 *
 * Gate rejects the whole measurement where its NIS is above the limit.  Mean, covariance, history and the run's
 * log-likelihood stay; kq_nis is that of the measurement, kq_taken is 0.
 *   Protects against single measurements that are wrong altogether.  Harms: a gate drops what would correct the
 *   velocity, and may lose a state that is well.  Take KQ_LEVEL_9999.
 *   A measurement that passes leaves what the plain update leaves, bit for bit, and ends the run.  After `run`
 *   rejections in a row the next measurement above the limit is taken by jump with g = 1, or by the plain update where
 *   a history records; the count begins anew.  With KQ_GATE_CLOSED nothing above the limit is ever taken.
 *
 * NIS, log-likelihood and count are those of the model as given: of r and of P before it is raised.  So kq_nis shows
 * the outlier or the jump.  A history records the update that was made: the smoother needs nothing special.  An
 * adaptation ignores it.
 * Events: those of kq_update.  What kq_update would not take is not taken.  KQ_EVENT_OVERFLOW also where r' overflows
 * (not taken) or a limit stopped the raise of P; KQ_EVENT_JUMP where P was raised; KQ_EVENT_GATED where a measurement
 * was rejected; KQ_EVENT_REJECTIONS where a run of rejections has ended.  A component without noise that was clipped
 * has had some: a redundant one after it may be taken.
 * Cost: the update and, per scalar, n^2/2 + n multiplications; Huber a root and a division, Student 8 multiplications
 * and 7 divisions, jump n^2 multiplications and two roots where P is raised.  Gate: two copies of the filter, and
 * a second update where a run ends.
 * Stack: 240 words more than the update (q31: 480).  Gate: KQ_FILTER_LEN(n) words more than the update, n rounded up
 * to 4, 9 or 16, and at the end of a run those of jump.  With innovations 32 words more (f64: 16).
 * KQ_ERR_NULL (loss or its kind, too), KQ_ERR_RANGE (k not above 0, nu below 2^-20, g below 1, limit not above 0),
 * KQ_ERR_NOT_FINITE (z, parameter), KQ_ERR_RECORDING (jump: a history, a lag or a point is attached; innovations: an
 * adaptation or a freeze), and the errors of kq_update_subset.
 */
KQ_NODISCARD kq_status kq_update_robust_f32(kq_filter_f32 *f, const kq_sensor_f32 *s, const float *z, uint32_t present,
                               kq_loss_f32 *loss);
KQ_NODISCARD kq_status kq_update_robust_f64(kq_filter_f64 *f, const kq_sensor_f64 *s, const double *z, uint32_t present,
                               kq_loss_f64 *loss);

/* ------------------------------------------------------------------ a process noise that is scaled */

/**
 * The process with its noise scaled: q Q in the place of Q.
 *   target   a process of n states with its own memory (KQ_PROCESS_F32(name, n, l), or assigned);
 *            written: A, B are those of the source, by reference
 *   source   read; may be a const table
 *   q        >= 0
 * A variance that is none (process.h) stays none.  With q = 1 the root is bit-identical to the source's.
 * Use: more noise while a target manoeuvres; steps with weights (below).
 * Cost: n^2/2 multiplications, one root.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY (source), KQ_ERR_SIZE, KQ_ERR_MEMORY (target), KQ_ERR_MISMATCH
 * (states, or target is source), KQ_ERR_NOT_FINITE (q, or a root that overflows),
 * KQ_ERR_NOT_SEMIDEFINITE (q < 0).
 */
KQ_NODISCARD kq_status kq_process_scale_noise_f32(kq_process_f32 *target, const kq_process_f32 *source, float q);
KQ_NODISCARD kq_status kq_process_scale_noise_f64(kq_process_f64 *target, const kq_process_f64 *source,
                                     double q);

/**
 * Smooths a history whose steps were predicted with scaled noise, and answers how to scale it next: one pass of
 * an iteration that gives the smoother Student-t process noise,
 *     w ~ t(nu) of scale Q:  w ~ N(0, q Q),  nu / q chi-square with nu degrees of freedom
 *     q[t] becomes (nu + E[w_t'Q^-1 w_t | T]) / (nu + rank of Q)
 *   h        a recorded run, in which step t was left by kq_predict with target scaled by q[t]
 *   target   as for kq_process_scale_noise; written
 *   source   the process with q = 1
 *   nu       > 0.  Usual: 2
 *   q        kq_history_steps() - 1 numbers.  Read: those of the run.  Written: those of the next.
 * Afterwards the history is smoothed as by kq_smooth.  The loop is yours, as the measurements
 * are:
 *
 *     q[t] = 16 for all t
 *     five times:
 *         kq_filter_init, kq_attach
 *         for each t:  kq_process_scale_noise(&target, &source, q[t]);
 *                      kq_predict(&filter, &target, u[t]);  kq_update(&filter, &sensor, z[t]);
 *         kq_smooth_reweighted(&history, &target, &source, nu, q);
 *
 * Begin above 1, or large jumps are found slowly: from q = 16 four to eight passes are as good as
 * any, from 1 it takes twelve.
 * Protects against jumps, which the plain smoother smears over many steps: on random walks with alpha-stable steps
 * (1.5) its error is 0.22 to 0.26 of the plain smoother's (tests/README.md, "Accuracy").
 * Harms: outliers become jumps.  P0 is not weighed: an x0 off by many sigma bends the first steps
 * as it does in kq_smooth.  Begin by kq_diffuse (diffuse.h), or with a P0 that is wide enough.
 * Cost: kq_smooth and 3 n^3 multiplications a step more.
 * KQ_ERR_RANGE (nu not above 0), KQ_ERR_MISMATCH (states of source or target, or they are one),
 * KQ_ERR_RECORDING (a history that each linearised predict leaves its process in: extended.h), the errors of
 * kq_smooth, and of kq_process_scale_noise with each q.
 */
KQ_NODISCARD kq_status kq_smooth_reweighted_f32(kq_history_f32 *h, kq_process_f32 *target,
                                   const kq_process_f32 *source, float nu, float *q);
KQ_NODISCARD kq_status kq_smooth_reweighted_f64(kq_history_f64 *h, kq_process_f64 *target,
                                   const kq_process_f64 *source, double nu, double *q);

/* ------------------------------------------------------------------ q31, as in f32
 *
 * A loss's parameter and weights, and q, are kq_scaled_q31, as in a table: a mantissa that is not normalised,
 * or an exponent beyond 1000, is KQ_ERR_COEFFICIENT.  The noise of a target is in memory of the
 * caller's: root, KQ_ROOT_LEN_Q31(n) words, written, for as long as the target is used; not the
 * source's own (KQ_ERR_MISMATCH).  A root whose exponents would leave +-1000 is KQ_ERR_COEFFICIENT.
 * The target itself is written as a whole: it needs no init, sizes or memory before, so that of
 * kq_process_scale_noise's errors KQ_ERR_SIZE, KQ_ERR_MEMORY and KQ_ERR_NOT_FINITE are not answered, and
 * KQ_ERR_MISMATCH where it is the source, never for its states; KQ_ERR_NULL stands for root, too.
 * Mean and covariance are those of f64 up to 1e-6 sigma.
 */

extern const struct kq_loss_kind_q31 kq_loss_huber_q31, kq_loss_student_q31, kq_loss_jump_q31, kq_loss_gate_q31;

typedef struct kq_loss_q31 {
    const struct kq_loss_kind_q31 *kind;
    kq_scaled_q31 parameter;
    kq_scaled_q31 *weights;
    int64_t limit; /* in Q39.24, as kq_nis_q31 */
    uint16_t run;
    uint16_t rejected;
} kq_loss_q31;

/** In Q39.24.  KQ_NOT_A_SCORE_Q31 where m or level is bad. */
int64_t kq_chi_square_limit_q31(int m, kq_level level);

KQ_NODISCARD kq_status kq_update_robust_q31(kq_filter_q31 *f, const kq_sensor_q31 *s, const int32_t *z, uint32_t present,
                               kq_loss_q31 *loss);
KQ_NODISCARD kq_status kq_process_scale_noise_q31(kq_process_q31 *target, const kq_process_q31 *source,
                                     int32_t *root, kq_scaled_q31 q);
KQ_NODISCARD kq_status kq_smooth_reweighted_q31(kq_history_q31 *h, kq_process_q31 *target,
                                   const kq_process_q31 *source, int32_t *root, kq_scaled_q31 nu,
                                   kq_scaled_q31 *q);

#ifdef __cplusplus
}
#endif
#endif
