/*
 * kalmanq: outliers and jumps.
 *
 * A Kalman filter believes that every surprise is Gaussian.  Two switches, each for one way in
 * which the world is not, and each HARMFUL on the other's noise: a filter cannot tell a wrong
 * measurement from a state that has jumped by looking at one of them.  Choose by what your sensors
 * and your states do; do not use both.
 *
 *   measurement outliers   kq_update_gated     a measurement that is too far off is not taken
 *                          kq_update_huber     ... moves the mean as far as k sigma would
 *                          kq_update_student   ... counts the less, the farther off it is
 *   jumps of the state     kq_update_jump      P is raised until the measurement is likely
 *                          kq_step_student     the process noise is raised as far as is likely
 *                          kq_smooth_reweighted   the same, with all data: for the smoother
 *
 * What they gain and what they cost: root mean square errors of a random walk over those of the
 * plain filter, from 500 or 2000 runs of 100 or 200 steps (tests/reference/test_robust.cpp, which
 * also has the mean errors and the standard errors; on jumps the plain filter's error has no finite
 * mean square, so read those ratios as "much").
 *
 *                                     outliers             jumps                    Gaussian
 *                                  (10 %, sd 10)   (alpha-stable, 1.5, see below)
 *                                                   Q/R = 2        Q/R = 0.02   Q/R = 2   0.02
 *   gate, 99.99 %                       0.43           8.3             1.5       1.005    1.00
 *   Huber, k = 1.5                      0.44          12               3.1       1.07     1.01
 *   Student-t update, nu = 4            0.43          19               4.8       1.01     1.03
 *   jump gate, g = 9                    2.35           0.27            0.30      1.005    1.13
 *   Student-t state noise (a)           2.33           0.27            0.27      1.03     1.09
 *   reweighted smoother (b)                            0.22            0.26      1.03     1.02
 *
 *   (a) nu = 2; for jumps with Q/R = 2, nu = 2.5    (b) over the plain smoother
 *
 * Outliers: R = 1, Q = 0.1.  Jumps: increments S(alpha, 0, sigma), the filter being given
 * Q = 2 sigma^2.  On them a switch for outliers holds the state back where it was.
 *
 * When nothing is known of the noise: kq_update_student with nu = 10, or kq_update_huber with k = 3
 * where instructions count.  Jump and step_student only where the sensor is trusted.  Root mean
 * square errors over those of the exact posterior mean for the noise that was drawn
 * (tests/reference/test_robust_models.cpp, 3 seeds, 100 runs of 200 steps each: the largest of the
 * three; R = 1, position measured; Q of a velocity q (1/3 1/2; 1/2 1)):
 *
 *                              random walk, Q =     constant velocity, q =
 *                                 0.1      1       0.001   0.01    0.1      1
 *   Gaussian
 *     Student-t, nu = 10         1.01    1.00       1.01   1.01   1.01    1.00
 *     Student-t, nu = 4          1.03    1.02       1.05   1.04   1.03    1.01
 *     Huber, k = 3               1.00    1.00       1.00   1.00   1.00    1.00
 *     Huber, k = 1.5             1.02    1.05       1.03   1.03   1.05    1.10
 *     jump, g = 9                1.05    1.01       1.06   1.03   1.01    1.00
 *     step_student, nu = 2       1.10    1.06       1.03   1.03   1.02    1.02
 *   1 % outliers of sd 10
 *     plain filter               1.23    1.25       1.25   1.25   1.25    1.23
 *     gate, 99.99 %              1.00    1.01       1.00   1.01   1.29    2.05
 *     Student-t, nu = 10         1.01    1.02       1.01   1.01   1.02    1.05
 *     Student-t, nu = 4          1.03    1.01       1.04   1.03   1.03    1.02
 *     Huber, k = 3               1.02    1.04       1.03   1.03   1.04    1.05
 *     jump, step_student         2.10    1.56       2.07   1.74   1.51    1.35
 *   10 % outliers of sd 10
 *     plain filter               2.35    2.32       2.69   2.60   2.40    2.03
 *     gate, 99.99 %              1.05    1.17       1.14   1.14   2.71    4.35
 *     Student-t, nu = 10         1.05    1.17       1.08   1.09   1.18    1.35
 *     Student-t, nu = 4          1.03    1.04       1.05   1.04   1.06    1.20
 *     Huber, k = 3               1.20    1.28       1.24   1.26   1.34    1.37
 *     Huber, k = 1.5             1.06    1.09       1.09   1.10   1.14    1.19
 *     jump, step_student         5.52    3.33       5.89   4.59   3.44    2.42
 *
 * Within 3 % of the best that is possible is Student-t with nu = 4 on random walks with
 * Q of 0.1 R or less; there it does for Student-t noise of 3 degrees and alpha-stable noise of
 * alpha 1.5, too.  Where Q is near R, or a velocity has to be followed, an outlier and a manoeuvre
 * look more alike.
 *
 * What is told of an update stays that of the model as given, before any weight: kq_nis shows the
 * outlier or the jump, and kq_log_likelihood is comparable between runs.
 *
 * Sources: Huber, Robust Statistics (1981); Masreliez and Martin, Robust Bayesian estimation for
 * the linear model and robustifying the Kalman filter, IEEE Trans. Automatic Control 22 (1977);
 * Lange, Little and Taylor, Robust statistical modeling using the t distribution, J. Amer. Statist.
 * Assoc. 84 (1989); Roth, Ozkan and Gustafsson, A Student's t filter for heavy tailed process and
 * measurement noise, ICASSP (2013); Bar-Shalom, Li and Kirubarajan, Estimation with Applications to
 * Tracking and Navigation (2001), for gates; Chambers, Mallows and Stuck, A method for simulating
 * stable random variables, J. Amer. Statist. Assoc. 71 (1976), as corrected by Weron (1996).
 */
#ifndef KALMANQ_ROBUST_H
#define KALMANQ_ROBUST_H

#include "smoother.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------ measurement outliers */

/** How many rejections in a row a gate bears if it is not told; and a `run` that is never over. */
#define KQ_GATE_RUN 8
#define KQ_GATE_CLOSED 65535

/**
 * A chi-square gate, of one sensor: set limit and run, and rejected to 0.
 *     kq_gate_f32 gate = {kq_chi_square_limit_f32(2, KQ_LEVEL_9999), 0, 0};
 */
typedef struct {
    float limit;       /* of NIS: > 0, may be infinite */
    uint16_t run;      /* after so many rejections in a row one is taken; 0: KQ_GATE_RUN */
    uint16_t rejected; /* in a row so far, counted up to 65535 */
} kq_gate_f32;

typedef struct {
    double limit;
    uint16_t run;
    uint16_t rejected;
} kq_gate_f64;

/** The probability that a good measurement passes: 0.9, 0.95, 0.99, 0.999, 0.9999. */
typedef enum { KQ_LEVEL_90, KQ_LEVEL_95, KQ_LEVEL_99, KQ_LEVEL_999, KQ_LEVEL_9999 } kq_level;

/**
 * The value that NIS stays below with that probability, if the model is right.
 *   m        1..16 components that are taken
 * A table of 320 bytes; to 2^-25.  NaN where m or level is bad.
 */
float kq_chi_square_limit_f32(int m, kq_level level);
double kq_chi_square_limit_f64(int m, kq_level level);

/**
 * kq_update_subset, unless NIS of the whole measurement is above the limit: then it is rejected.
 * Mean, covariance, history and the run's log-likelihood are what they were; kq_nis is that of
 * the measurement, kq_taken is 0.
 *   g        its count of rejections in a row is written
 *   present  as in kq_update_subset; UINT32_MAX: all of z
 * A measurement that passes leaves the very bits of the plain update, and ends the run; one of
 * which nothing was taken (not present, at the floor) does neither.
 * After `run` rejections in a row, the next measurement above the limit is taken by kq_update_jump
 * with g = 1 (where a history records: by kq_update_subset, since a raised P is no step that it
 * could undo), and the count begins anew.  So many are no outliers: the state has jumped, x0 was
 * wrong, or Q or R is too small.  With KQ_GATE_CLOSED nothing is ever taken that is above the
 * limit, and what is to be done is yours: see g.rejected.
 * Protects against: single measurements that are wrong altogether.  Simple, and what is
 * rejected is known.
 * Harms: what would correct an error of the velocity is what a gate drops, so it may lose a state
 * that is well.  Take KQ_LEVEL_9999.  Gaussian noise and the right model, RMSE over that of the
 * plain filter with a gate that stays closed, and with a run of 8 (R = 1, position measured; Q of
 * an acceleration q (1/20 1/8 1/6; 1/8 1/3 1/2; 1/6 1/2 1); 3 seeds, 500 runs of 200 steps each:
 * the largest; tests/reference/test_robust_models.cpp):
 *
 *                                    95 %              99 %             99.99 %
 *                                closed   run 8    closed   run 8    closed   run 8
 *   random walk, Q = 0.1           1.18    1.15      1.04    1.04     1.00    1.00
 *                    1             2.36    1.53      1.13    1.12     1.00    1.00
 *   velocity, q = 0.001             66     1.46       30     1.10     1.00    1.00
 *                 0.01              64     1.63       10     1.10     1.00    1.00
 *                 0.1              149     2.88       41     1.46     1.00    1.00
 *                 1                392     7.2       112     3.1      1.01    1.01
 *   acceleration, q = 0.1        10600     12       4800     5.5      1.25    1.16
 *                     1          30400     31      12800     14       1.44    1.44
 * Events: KQ_EVENT_GATED; KQ_EVENT_REJECTIONS where a run is over, with those of kq_update_jump;
 * those of the update, if it was taken.
 * Cost: the update and two copies of the filter; at the end of a run a second update.
 * Stack: KQ_FILTER_LEN(n) words more, n rounded up to 4, 9 or 16; at the end of a run that of
 * kq_update_jump beside it.
 * KQ_ERR_RANGE (limit not above 0), and the errors of kq_update_subset.
 */
kq_status kq_update_gated_f32(kq_filter_f32 *f, kq_gate_f32 *g, const kq_sensor_f32 *s,
                              const float *z, uint32_t present);
kq_status kq_update_gated_f64(kq_filter_f64 *f, kq_gate_f64 *g, const kq_sensor_f64 *s,
                              const double *z, uint32_t present);

/**
 * An update in which every scalar measurement has a noise of its own (a component's or, where R
 * is not diagonal, a decorrelated one's), chosen from its innovation e, f'f = h'P h, s = r + f'f:
 *     Huber        |e| <= k sqrt(s): r' = r;  beyond it r' = s / w - f'f, w = k sqrt(s) / |e|:
 *                  the mean moves as if e were +-k sqrt(s)
 *     Student-t    v ~ t(nu) of scale sqrt(r): three steps, from r' = r, of
 *                  r' = (nu r + E[v^2]) / (nu + 1),
 *                  E[v^2] = (e r' / (f'f + r'))^2 + f'f r' / (f'f + r')
 *   present  as in kq_update_subset; UINT32_MAX: all of z
 *   k, nu    > 0, nu 2^-20 or more.  Usual: 3 and 10; 1.5 and 4 where outliers are frequent
 *   weights  m, written: r / r' of each, 1 for one that was taken as it is, 0 for one that was not
 *            taken (not present, at the floor); or NULL.  Not in the place of z.
 * Where R is not diagonal, decorrelated component c is a combination of components c, c + 1, ...:
 * an outlier of the last one spoils them all.  Put the one that fails first.  Two sensors of a
 * level of correlation 0.7, one of them with 10 % outliers of sd 10, RMSE over that of a filter
 * that knows which: bad first 1.04, bad last 1.09 (nu = 4; nu = 10: 1.02 and 1.07; plain 1.64).
 * NIS, log-likelihood and count are those of r, not of r'.  A history records the update that
 * was made: the smoother needs nothing special.  A Huber update that clips nothing leaves the
 * bits of the plain one in mean and covariance; Student-t with a very large nu is the plain one
 * up to rounding.
 * Protects against: outliers of any size.  The smaller nu and k, the more: nu = 4 and k = 1.5 are
 * for sensors that are known to fail, nu = 10 and k = 3 cost nothing where they do not (the table
 * above).
 * Harms: a jump of the state is followed in steps of k sigma (Huber), or not at all as long as an
 * outlier explains it better (Student-t).
 * Events: those of the update.  What kq_update would not take with r (at the floor, beyond the
 * numbers) is not taken with r' either, and one without noise that contradicts is told of as there;
 * KQ_EVENT_OVERFLOW also where r' is beyond the numbers: not taken.  One without noise that was clipped
 * has had some: a component after it that says the same may be taken.
 * Cost: the update, and per scalar n^2/2 + n multiplications, a root and a division (Huber), 8
 * multiplications and 7 divisions (Student-t).
 * Stack: 240 words more than the update (q31: 480).
 * KQ_ERR_RANGE (k not above 0, nu below 2^-20), KQ_ERR_NOT_FINITE (z, k, nu), and the errors of
 * kq_update_subset.
 */
kq_status kq_update_huber_f32(kq_filter_f32 *f, const kq_sensor_f32 *s, const float *z,
                              uint32_t present, float k, float *weights);
kq_status kq_update_huber_f64(kq_filter_f64 *f, const kq_sensor_f64 *s, const double *z,
                              uint32_t present, double k, double *weights);
kq_status kq_update_student_f32(kq_filter_f32 *f, const kq_sensor_f32 *s, const float *z,
                                uint32_t present, float nu, float *weights);
kq_status kq_update_student_f64(kq_filter_f64 *f, const kq_sensor_f64 *s, const double *z,
                                uint32_t present, double nu, double *weights);

/* ------------------------------------------------------------------ jumps of the state */

/**
 * An update that raises P first where a scalar measurement is too far off: if e^2 > g s, then
 * P becomes c^2 P with c^2 = (e^2 - r) / f'f, so that s is e^2.  It is raised for no measurement that
 * kq_update would not take, nor where f'f is rounding (kq_update's floor): that is taken as it is.
 *   g        >= 1.  Usual: 9 for Q near R, 12 to 16 for Q far below R
 * NIS and log-likelihood are those before P was raised.  All of P is raised, also where the jump
 * was not.  No variance, f'f being one, is raised beyond 2^96 (f32), 2^360 (f64) or 2^200 squared
 * words (q31): then the mean follows as far as that P lets it.
 * Protects against: jumps, a wrong initial state.  Cheap.  (See kq_step_student for figures.)
 * Harms: the state follows every outlier, all of the way.
 * It is no step that a history could undo.
 * Events: KQ_EVENT_JUMP where P was raised; KQ_EVENT_OVERFLOW where that limit stopped it, or where
 * NIS is beyond the numbers and nothing was taken; those of the update.
 * Cost: the update, and per scalar n^2/2 + n multiplications; where P is raised n^2 and two roots
 * more.
 * Stack: as kq_update_huber.
 * KQ_ERR_RECORDING (a history, a lag or an instant is attached), KQ_ERR_RANGE (g below 1), KQ_ERR_NOT_FINITE (z, g),
 * and the errors of kq_update_subset.
 */
kq_status kq_update_jump_f32(kq_filter_f32 *f, const kq_sensor_f32 *s, const float *z,
                             uint32_t present, float g);
kq_status kq_update_jump_f64(kq_filter_f64 *f, const kq_sensor_f64 *s, const double *z,
                             uint32_t present, double g);

/**
 * The process with its noise scaled: q Q in the place of Q.
 *   target   a process of n states with its own memory (KQ_PROCESS_F32(name, n, l), or assigned);
 *            written: A, B are those of the source, by reference
 *   source   read; may be a const table
 *   q        >= 0
 * A variance that is none (process.h) stays none.  q = 1 gives the very bits of the source's
 * root.
 * Use: more noise while a target manoeuvres; steps with weights (below).
 * Cost: n^2/2 multiplications, one root.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY (source), KQ_ERR_SIZE, KQ_ERR_MEMORY (target), KQ_ERR_MISMATCH
 * (states, or target is source), KQ_ERR_NOT_FINITE (q, or a root beyond the numbers),
 * KQ_ERR_NOT_SEMIDEFINITE (q < 0).
 */
kq_status kq_process_scale_noise_f32(kq_process_f32 *target, const kq_process_f32 *source, float q);
kq_status kq_process_scale_noise_f64(kq_process_f64 *target, const kq_process_f64 *source,
                                     double q);

/**
 * A step whose process noise is Student-t: from one measurement to the next as kq_step, with
 * q Q in the place of Q, and q from what the measurement says of it.
 *     w ~ t(nu) of scale Q:  w ~ N(0, q Q),  nu / q chi-square with nu degrees of freedom
 * The step is tried with q_k = 1, 16, 256, 4096, 65536, and on to 16^7 while that makes the
 * measurement more likely; then it is taken with
 *     sqrt(q) = sum p_k sqrt(q_k),   p_k ~ q_k^(-nu/2) exp(-nu / (2 q_k)) p(z | q_k)
 *   u        l, or NULL
 *   present  as in kq_update_subset; UINT32_MAX: all of z
 *   nu       > 0.  Usual: 4; 2 where jumps are frequent.  For alpha-stable noise of alpha 1.3, 1.5,
 *            1.7: 1.75, 2, 2.5 for Q far below R; for Q near R 2.5 is 1.4 % above the RMSE of the
 *            exact posterior mean at most, and 4 is 0.3 % (kalmanq study heavy-tails)
 *   target   a process with its own memory, as for kq_process_scale_noise; written
 *   q        one number, written: the scale of this step; or NULL
 * Without a measurement (nothing present or taken) q is 1.  NIS and log-likelihood are those of
 * Q as given.  Mean and covariance are, bit for bit, those of kq_process_scale_noise with q,
 * kq_predict by target and kq_update_subset.  So a history can record it, and refers to target:
 * keep q of each step, and smooth by kq_smooth_reweighted, or by kq_smooth_step with target
 * scaled again and given (kq_smooth answers KQ_ERR_CHANGED).
 * The p(z | q_k) are compared by what NIS falls from one to the next, formed without a difference
 * of the two: q is right to 1e-4 (f32) also where sensors contradict each other by 1000 sigma.
 * Protects against: jumps of the state in the directions of Q, of any size.  Not against a wrong
 * x0: q is not a scale of P0.  With x0 off by 100 sigma the error is 50 sigma at the first
 * measurement and 1 at the second (a walk, Q = 0.1 R = 0.1 P0); take the first measurement by
 * kq_update_jump (1 sigma at once), or begin by kq_start (start.h).
 * RMSE / sqrt(R) of a random walk with alpha-stable increments, alpha 1.3, 1.5, 1.7: 0.904, 0.894,
 * 0.888 (Q/R = 2) and 0.541, 0.483, 0.430 (Q/R = 0.02).  Where w is 10 or 30 times as large now and
 * then, RMSE over that of the exact posterior mean, the largest of 3 seeds:
 *
 *                              random walk, Q =          constant velocity, q =
 *                             0.02    0.1     1        0.001   0.01    0.1      1
 *   no jumps
 *     step_student, nu = 4    1.00   1.01   1.01        1.00   1.00   1.00   1.00
 *                   nu = 2    1.09   1.10   1.06        1.03   1.03   1.02   1.02
 *     jump, g = 9             1.16   1.05   1.01        1.07   1.03   1.02   1.01
 *           g = 16            1.01   1.00   1.00        1.01   1.00   1.00   1.00
 *   0.2 % of 30 times
 *     plain filter            1.31   1.34   1.26        1.12   1.14   1.13   1.10
 *     step_student, nu = 4    1.04   1.01   1.01        1.10   1.05   1.01   1.00
 *                   nu = 2    1.07   1.09   1.06        1.04   1.03   1.02   1.02
 *     jump, g = 16            1.03   1.01   1.00        1.05   1.02   1.00   1.00
 *   2 % of 10 times
 *     plain filter            1.13   1.22   1.24        1.09   1.10   1.11   1.09
 *     plain filter, Q x 3     1.05   1.12   1.12        1.02   1.03   1.05   1.04
 *     step_student, nu = 4    1.09   1.04   1.01        1.07   1.08   1.05   1.01
 *                   nu = 2    1.03   1.04   1.05        1.02   1.02   1.02   1.01
 *     jump, g = 9             1.15   1.05   1.01        1.11   1.06   1.02   1.00
 *   2 % of 30 times
 *     plain filter            2.35   2.75   2.47        1.80   1.90   1.93   1.76
 *     plain filter, Q x 9     1.50   1.60   1.26        1.14   1.18   1.19   1.12
 *     step_student, nu = 2    1.05   1.05   1.05        1.22   1.08   1.02   1.01
 *     jump, g = 9             1.12   1.04   1.01        1.16   1.07   1.02   1.00
 *
 * So with several states it is no better than kq_update_jump, at six times the cost; what it has is
 * that a history can record it, and that P is raised along Q alone.  With a velocity, jumps of sd
 * 10 are followed as well by a plain filter whose Q is 3 times as large (what they make Q on the
 * average).
 * Harms: measurement outliers are followed all of the way.  Where the measurement says little,
 * q is that of the prior: 2.5 for nu = 2.
 * Not by the fixed point q = (nu + E[w'Q^-1 w]) / (nu + n): where Q is far below R there are two,
 * and from q = 1 it misses jumps, from above it takes the noise for them.
 * Events: KQ_EVENT_JUMP where q above 1 is more likely than 1; KQ_EVENT_OVERFLOW where NIS of Q as
 * given is beyond the numbers: it is infinite then, and the run does not count it; those of predict
 * and update.
 * Cost: 6 steps (up to 9 at a jump out of all proportion); for each trial n^3 multiplications more,
 * and per scalar measurement 4.5 n^2, n roots and 2 n divisions; about 5 exponentials of 25
 * multiplications and 13 divisions.
 * Stack, in bytes on a Cortex-M4, for n up to 4, 9 and 16: 1920, 2660, 4540 (q31: 3370, 4410,
 * 7040), and an update by a scalar measurement.
 * KQ_ERR_RANGE (nu not above 0), the errors of kq_step, and those of kq_process_scale_noise with
 * q = 1 and q = 16^7.
 */
kq_status kq_step_student_f32(kq_filter_f32 *f, const kq_process_f32 *p, const float *u,
                              const kq_sensor_f32 *s, const float *z, uint32_t present, float nu,
                              kq_process_f32 *target, float *q);
kq_status kq_step_student_f64(kq_filter_f64 *f, const kq_process_f64 *p, const double *u,
                              const kq_sensor_f64 *s, const double *z, uint32_t present, double nu,
                              kq_process_f64 *target, double *q);

/**
 * Smooths a history whose steps were predicted with scaled noise, and says how it should be
 * scaled: one pass of an iteration that gives the smoother Student-t process noise.
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
 *         kq_filter_init, kq_history_attach
 *         for each t:  kq_process_scale_noise(&target, &source, q[t]);
 *                      kq_predict(&filter, &target, u[t]);  kq_update(&filter, &sensor, z[t]);
 *         kq_smooth_reweighted(&history, &target, &source, nu, q);
 *
 * Begin above 1, or large jumps are found slowly: from q = 16 four to eight passes are as good as
 * any, from 1 it takes twelve.  The q of a run of kq_step_student are a beginning, too.
 * Protects against: jumps, which the plain smoother smears over many steps.  On the walks of
 * kq_step_student: 0.824, 0.808, 0.797 and 0.403, 0.353, 0.314 (nu = 2, five passes).
 * Harms: outliers become jumps.  P0 is not weighed: an x0 off by many sigma bends the first steps
 * as it does in kq_smooth.  Begin by kq_start (start.h), or with a P0 that is wide enough.
 * Cost: kq_smooth and 3 n^3 multiplications a step more.
 * KQ_ERR_RANGE (nu not above 0), KQ_ERR_MISMATCH (states of source or target, or they are one),
 * KQ_ERR_RECORDING (a history that each linearised predict leaves its process in: extended.h), the errors of
 * kq_smooth, and of kq_process_scale_noise with each q.
 */
kq_status kq_smooth_reweighted_f32(kq_history_f32 *h, kq_process_f32 *target,
                                   const kq_process_f32 *source, float nu, float *q);
kq_status kq_smooth_reweighted_f64(kq_history_f64 *h, kq_process_f64 *target,
                                   const kq_process_f64 *source, double nu, double *q);

/* ------------------------------------------------------------------ q31, as in f32
 *
 * k, nu, g, q and the weights are kq_scaled_q31, as in a table: a mantissa that is not normalised,
 * or an exponent beyond 1000, is KQ_ERR_COEFFICIENT.  The noise of a target is in memory of the
 * caller's: root, KQ_ROOT_LEN_Q31(n) words, written, for as long as the target is used; not the
 * source's own (KQ_ERR_MISMATCH).  A root whose exponents would leave +-1000 is KQ_ERR_COEFFICIENT.
 * The target itself is written as a whole: it needs no init, sizes or memory before, so that of
 * kq_process_scale_noise's errors KQ_ERR_SIZE, KQ_ERR_MEMORY and KQ_ERR_NOT_FINITE are not answered, and
 * KQ_ERR_MISMATCH where it is the source, never for its states; KQ_ERR_NULL stands for root, too.
 * Mean and covariance are those of f64 up to 1e-6 sigma.
 */

/** limit in Q39.24, as kq_nis_q31. */
typedef struct {
    int64_t limit;
    uint16_t run;
    uint16_t rejected;
} kq_gate_q31;

/** In Q39.24.  KQ_NOT_A_SCORE_Q31 where m or level is bad. */
int64_t kq_chi_square_limit_q31(int m, kq_level level);

kq_status kq_update_gated_q31(kq_filter_q31 *f, kq_gate_q31 *g, const kq_sensor_q31 *s,
                              const int32_t *z, uint32_t present);
kq_status kq_update_huber_q31(kq_filter_q31 *f, const kq_sensor_q31 *s, const int32_t *z,
                              uint32_t present, kq_scaled_q31 k, kq_scaled_q31 *weights);
kq_status kq_update_student_q31(kq_filter_q31 *f, const kq_sensor_q31 *s, const int32_t *z,
                                uint32_t present, kq_scaled_q31 nu, kq_scaled_q31 *weights);
kq_status kq_update_jump_q31(kq_filter_q31 *f, const kq_sensor_q31 *s, const int32_t *z,
                             uint32_t present, kq_scaled_q31 g);
kq_status kq_process_scale_noise_q31(kq_process_q31 *target, const kq_process_q31 *source,
                                     int32_t *root, kq_scaled_q31 q);
kq_status kq_step_student_q31(kq_filter_q31 *f, const kq_process_q31 *p, const int32_t *u,
                              const kq_sensor_q31 *s, const int32_t *z, uint32_t present,
                              kq_scaled_q31 nu, kq_process_q31 *target, int32_t *root,
                              kq_scaled_q31 *q);
kq_status kq_smooth_reweighted_q31(kq_history_q31 *h, kq_process_q31 *target,
                                   const kq_process_q31 *source, int32_t *root, kq_scaled_q31 nu,
                                   kq_scaled_q31 *q);

#ifdef __cplusplus
}
#endif
#endif
