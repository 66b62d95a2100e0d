/*
 * kalmanq: the filter, what is known of the state.
 *
 *     predict   x- = A x + B u           P- = A P A' + Q
 *     update    e  = z - H x-            S  = H P- H' + R         K = P- H' S^-1
 *               x  = x- + K e            P  = P- - K S K'
 *
 * These are the results, not the arithmetic.  The filter carries the upper triangular root of
 * P = S S', so P is positive semi-definite whatever the rounding; predict is a Householder
 * triangularisation of [A S, G], update takes one scalar measurement after the other with
 * Carlson's form, nothing is inverted.  A singular innovation covariance takes the
 * pseudo-inverse.  The mean is a pair of floats in f32: a float's 24 bits plus what the
 * increments below its last bit add up to; one double in f64; 56 bits in q31.
 *
 * A run is init, update, predict, update, predict, ...: x0 and P0 hold before the first
 * measurement.  Any number of processes and sensors, of any size m, may take turns.
 *
 * Sharing, copying, interrupts.  The library has no state of its own: all is in the objects that a
 * call is given.  Calls that write different objects may run at once, on several cores, in tasks and
 * in interrupts, while they read the same process, sensor or table.  There is no lock: you must not
 * change one of those while a call reads it.  To one filter, and to what is attached to it, goes one call at a time.  A predict or update overwrites mean, root and likelihood as it
 * goes: an interrupt or a task that comes in between reads numbers that do not belong together, and
 * that of kq_mean alone may be neither the old nor the new one.  Single machine words are whole
 * whenever they are read: kq_events and kq_taken can be.  So whoever steps the filter publishes: with
 * interrupts off for the time of a copy, of the few readings that are wanted, or of all of the
 * filter by kq_filter_copy.
 *     A filter is its struct and its memory.  Assigning the struct (other = track) copies a
 * pointer: both then move one mean and one root.  kq_filter_copy makes a filter of its own.
 *
 * Attaching.  A history (smoother.h), a lag, an instant, a start, an adaptation or a freeze is attached to a
 * filter, one of them at a time (KQ_ERR_RECORDING in status.h: what takes whose place); then kq_predict, kq_update, kq_update_subset and kq_step have it do its
 * part, and its own header says what that adds to their costs and errors.  kq_attach attaches, kq_detach
 * detaches.  A program links nothing of what it never declares.  Updates of robust.h are recorded, and teach nothing.
 *
 * Sources: Carlson, Fast triangular formulation of the square root filter, AIAA J. 11 (1973);
 * Bierman, Factorization Methods for Discrete Sequential Estimation (1977).
 */
#ifndef KALMANQ_FILTER_H
#define KALMANQ_FILTER_H

#include "process.h"
#include "sensor.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Words of memory of a filter with n states: the mean (2 words a state in f32, 1 in f64) and
    the root of the covariance. */
#define KQ_FILTER_LEN_F32(n) (2 * (n) + KQ_TRIANGLE(n))
#define KQ_FILTER_LEN_F64(n) ((n) + KQ_TRIANGLE(n))

/* What is attached to a filter (a history, a lag, an instant, a start, an adaptation, a freeze) begins with
   this: what it does in the steps is linked by its attach alone. */
struct kq_attached_f32 {
    const struct kq_hooks_f32 *hooks;
};

struct kq_attached_f64 {
    const struct kq_hooks_f64 *hooks;
};

/* The fields of these four are the library's (see process.h). */

/* A sum over a run, high + sum + low: 3 x 24 bits in f32, 3 x 53 in f64. */
typedef struct {
    float high, sum, low;
} kq_compensated_f32;

typedef struct {
    double high, sum, low;
} kq_compensated_f64;

/* Of an update: NIS, and det S = determinant * 2^exponent, over `count` scalar measurements */
typedef struct {
    float nis;
    float determinant;
    int32_t exponent;
    int32_t count;
} kq_likelihood_f32;

typedef struct {
    double nis;
    double determinant;
    int32_t exponent;
    int32_t count;
} kq_likelihood_f64;

/* Of a run.  Before `count` and `exponent` can wrap, what they stand for goes into the sum, which
   is otherwise that of the NIS. */
typedef struct {
    kq_compensated_f32 sum;
    float determinant;
    int32_t exponent;
    int32_t count;
} kq_likelihood_run_f32;

typedef struct {
    kq_compensated_f64 sum;
    double determinant;
    int32_t exponent;
    int32_t count;
} kq_likelihood_run_f64;

typedef struct {
    uint8_t states;  /* n */
    uint8_t ready;   /* 0: not initialised; otherwise flags */
    uint16_t events; /* KQ_EVENT_... */
    uint8_t plain;   /* n where an ordinary step will do, otherwise 0 */
    uint8_t seal;    /* of sizes and addresses (kq_filter_check) */
    uint16_t known;  /* bit i: component i can be read */
    float *memory;   /* the caller's: mean, then root */
    struct kq_attached_f32 *attached; /* what takes part in its steps, or NULL */
    uint32_t weak;                   /* measurements that were within the last bits of S */
    kq_likelihood_f32 last;         /* of the last update */
    kq_likelihood_run_f32 run;      /* since init */
} kq_filter_f32;

typedef struct {
    uint8_t states;
    uint8_t ready;
    uint16_t events;
    uint8_t plain;
    uint8_t seal;
    uint16_t known;
    double *memory;
    struct kq_attached_f64 *attached;
    uint32_t weak;
    kq_likelihood_f64 last;
    kq_likelihood_run_f64 run;
} kq_filter_f64;

/** A filter `name` of n states with its storage, in static memory. */
#define KQ_FILTER_F32(name, n)                                                                     \
    static float name##_memory[KQ_FILTER_LEN_F32(n)];                                              \
    static kq_filter_f32 name = {                                                                  \
        n, 0, 0, 0, 0, 0, name##_memory, NULL, 0, {0, 0, 0, 0}, {{0, 0, 0}, 0, 0, 0}}
#define KQ_FILTER_F64(name, n)                                                                     \
    static double name##_memory[KQ_FILTER_LEN_F64(n)];                                             \
    static kq_filter_f64 name = {                                                                  \
        n, 0, 0, 0, 0, 0, name##_memory, NULL, 0, {0, 0, 0, 0}, {{0, 0, 0}, 0, 0, 0}}

/**
 * Sizes and memory known at run time only (the macros do the same at compile time).
 *   f        written
 *   n        1..16
 *   memory   KQ_FILTER_LEN_<T>(n) words or more
 *   length   words at memory
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY.
 */
KQ_NODISCARD kq_status kq_filter_assign_f32(kq_filter_f32 *f, int n, float *memory, size_t length);
KQ_NODISCARD kq_status kq_filter_assign_f64(kq_filter_f64 *f, int n, double *memory, size_t length);

/**
 * The state before the first measurement: x ~ N(x0, P0).  Clears the events and the
 * log-likelihood, and detaches what is attached, which is not looked at: it may be gone
 * (smoother.h: who has to outlive whom).
 *   x0       n
 *   P0       n x n, symmetric positive semi-definite, may be singular or 0; both triangles are
 *            compared, the upper one is used
 * Neither is kept.
 * Cost: about 2 n^3 multiplications, 2n square roots; stack: 424 words.
 * Accuracy: as Q in process.h.
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY, KQ_ERR_NOT_FINITE, KQ_ERR_NOT_SYMMETRIC,
 * KQ_ERR_NOT_SEMIDEFINITE, KQ_ERR_RANGE (a variance or the size of a mean above 2^120 in f32, 2^1000 in
 * f64: what is not known at all has diffuse.h).
 */
KQ_NODISCARD kq_status kq_filter_init_f32(kq_filter_f32 *f, const float *x0, const float *P0);
KQ_NODISCARD kq_status kq_filter_init_f64(kq_filter_f64 *f, const double *x0, const double *P0);

/**
 * The same with P0 = S S' given by its root, as kq_process_init_root takes Q's.
 *   S        upper triangular, diagonal >= 0, packed by columns (KQ_TRIANGLE(n)); not kept
 * Errors as kq_process_init_root.
 */
KQ_NODISCARD kq_status kq_filter_init_root_f32(kq_filter_f32 *f, const float *x0, const float *S);
KQ_NODISCARD kq_status kq_filter_init_root_f64(kq_filter_f64 *f, const double *x0, const double *S);

/**
 * The state of another filter: mean, covariance, events and likelihoods, bit for bit.
 *   to       of n states, with its own memory; written.  Nothing is attached to it; what was is not
 *            looked at.
 *   from     read; what is attached to it stays its own
 * Cost: a copy of KQ_FILTER_LEN(n) words.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY (from), KQ_ERR_MEMORY (to), KQ_ERR_MISMATCH (states, or to is from
 * or has its memory).
 */
KQ_NODISCARD kq_status kq_filter_copy_f32(kq_filter_f32 *to, const kq_filter_f32 *from);
KQ_NODISCARD kq_status kq_filter_copy_f64(kq_filter_f64 *to, const kq_filter_f64 *from);

/**
 * Attaches an object to a filter: it takes part in the filter's steps from now on.
 *   f        a filter that is ready; changed
 *   object   the `attached` of a history, a lag, a point, an adaptation, a freeze or a kq_jacobians; changed
 *
 *     kq_attach_f32(&cart, &tape.attached);
 *
 * The object's header says what begins with it, and its errors.  f and the object have to outlive each other until
 * kq_detach.  A history, a lag or a point takes the place of another one.  kq_filter_init and kq_filter_assign of f
 * detach what is attached and do not tell it: the object may be gone.  It still has the filter then: call kq_detach
 * before you attach it to another filter, or assign it anew where the filter is gone.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY (f; an object that was never assigned), KQ_ERR_SIZE or KQ_ERR_MEMORY (an object without
 * sizes or memory), KQ_ERR_MISMATCH (states), KQ_ERR_RECORDING (the object has another filter, or something is attached
 * to f that does not give way).
 */
KQ_NODISCARD kq_status kq_attach_f32(kq_filter_f32 *f, struct kq_attached_f32 *object);
KQ_NODISCARD kq_status kq_attach_f64(kq_filter_f64 *f, struct kq_attached_f64 *object);

/**
 * Detaches an object from the filter that it has: each may go before the other.
 *   object   as in kq_attach.  One that has no filter stays as it is.  The filter that it has must not be gone
 * The filter goes on without it.  What a history has recorded and not smoothed is lost; what was smoothed can still be
 * read.  An unknown start keeps its filter, and loses the history that it has taken along.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY (an object that was never assigned or initialised).
 */
KQ_NODISCARD kq_status kq_detach_f32(struct kq_attached_f32 *object);
KQ_NODISCARD kq_status kq_detach_f64(struct kq_attached_f64 *object);

/**
 * x <- A x + B u,  P <- A P A' + Q.
 *   u        l, or NULL: no control at this step; not read if l = 0
 * Cost: about n^3 multiplications for a dense A, n^3/2 for an upper triangular one (kinematic
 * models in the order position, velocity, ...), n square roots, 2n divisions.
 * Stack: n^2 + 2n words with n rounded up to 4, 9 or 16.
 * Accuracy of P: each step is exact for rows of S perturbed by a few n eps of their norm.  So what a
 * state's sigma is, given another that is far less certain, is lost where it is below that: in f32
 * with R = 1e-10 and P0 = 1e6 P may be wrong by 2e-3 from the second measurement on, where a UD filter
 * in float keeps 1e-7.  The cause is the reflector, whose pivot is the noise's: with predict in double
 * alone it is gone.  tests/campaign counts the random models where P is more than twice, and five
 * times, as far off as a UD filter's: take f64 or q31 there.
 * KQ_EVENT_PRECISION: after a low-noise measurement (kq_update) the condition number of S, its rows scaled to
 * norm 1, is above 7e6 (f32), 3.9e15 (f64) or 1.3e8 (q31; seen in the next update, too).  Of 12,600
 * random models with P0 / R of 1e12, 1e13 and 1e14 in f32 a fifth is off by more than 5 %: 13 % of these
 * without the event; 43 % of the events are for nothing.  It is the same in f64 at 3e29 to 3e31.  In q31, at
 * 4e15 to 4e17, half are off: 4 % of these without it, a quarter of the events for nothing.  Of 2,100
 * ordinary models with two sensors none has it, in any arithmetic (tests/campaign/precision).
 *     Many updates: each rounds S, also where h does not see it, and takes what is rounding for information.  The event
 * tells where that may have moved a sigma by 5 %; it is looked for once in 64 measurements.  Steps of lean sensors and
 * KQ_FIXED_BARE do not look.  Of 2,100 random models whose sensors do not see all of 3 to 5 constants (P0 / R from 1e4
 * to 1e12 in f32, 1500 steps; tests/campaign/precision, unseen) 649 have a sigma that is off by more than 5 %: 10 without
 * the event; half of the events are for nothing.  q31, at 4e7 to 4e15: 318, 15, four of five.
 * The mean is rounded at its increment, not at its own size, where 1/2 <= A_ii <= 2.
 * Events: KQ_EVENT_OVERFLOW where a state that nothing measures has grown beyond sigma = 2^60 (f32),
 * 2^500 (f64) or 2^8160 raw values (q31).  Its sigma is held there; in f32 and f64 it has no correlations then.  If its
 * mean has grown beyond the square of that (2^120, 2^1000), the mean is 0 from then on (q31: KQ_EVENT_SATURATED, held
 * at the end of its word).  So is A x + B u beyond that, by this call at the latest where it overflows.  A state that A
 * does not couple to it keeps its mean.  What the others know of one another stays.  Measurements bring the state
 * back.  A history ends there (KQ_EVENT_HISTORY_FULL).
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_MISMATCH (number of states), KQ_ERR_NOT_FINITE (u).
 */
KQ_NODISCARD kq_status kq_predict_f32(kq_filter_f32 *f, const kq_process_f32 *p, const float *u);
KQ_NODISCARD kq_status kq_predict_f64(kq_filter_f64 *f, const kq_process_f64 *p, const double *u);

/**
 * Takes a measurement z = H x + v into the state.
 *   z        m
 * Cost: 2 n^2 multiplications, n square roots and 2n divisions a component; a correlated R
 * adds m n / 2 multiplications a component, a row of H that takes one state as it is saves n^2 / 2.
 * One that is far sharper than what was known (R below 2^-16 S in f32, 2^-48 in f64), and those that
 * follow it, are taken with more care, in one pass whatever R and P are: an update costs 4.2 times as
 * much at most up to n = 3, and 7 times up to n = 9 (instructions_worst in tools/cost.csv).
 * Accuracy of P: each component is exact for rows of S perturbed by a few eps of their norm (2^-24
 * in f32), so that what it tells of a state has to be well above that.  Where nothing moves the
 * states (Q = 0) it tells 1 / N after N of them: in f32 sigma is off by 0.4 % at N = 4e5, by 4 %
 * at 5e6 and by 16 % at 1.5e7; soon after it stays where it is, twice too large at N = 1e8.  In f64
 * that begins beyond 1e13.  Give such states a process noise, or use f64 or q31 (below).
 * Events: KQ_EVENT_PRECISION (f32): 2^19 components since init told so little, H P H' was within the last
 * four bits of S.  Fewer cannot show, nor can they where process noise or other components tell more: there
 * it may be cleared.  In f64 it would take 1e13, which are not counted.  KQ_EVENT_CONTRADICTION: see
 * status.h.  KQ_EVENT_REDUNDANT, KQ_EVENT_OVERFLOW: the component was not taken.  The floor is 64 eps of
 * the terms that H x is the sum of, where a noise-free or very low-noise measurement came before,
 * or 8 times the sigma that rounding has left in those terms of a noise-free component before it in
 * the same z, if that is more; and an innovation variance of 2^-96 (f32) or 2^-360 (f64) always:
 * choose units above it.  A state of which a noise-free component leaves no more than rounding has a
 * sigma of 0 from then on, and may be measured so again.  What else calls before have left is not known,
 * and components that may say the same belong into one sensor: of random models with small whole numbers,
 * 2 or 3 exact rows and a sum of them in another call, 1 of 300 takes rounding for knowledge.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_MISMATCH, KQ_ERR_NOT_FINITE (z).
 */
KQ_NODISCARD kq_status kq_update_f32(kq_filter_f32 *f, const kq_sensor_f32 *s, const float *z);
KQ_NODISCARD kq_status kq_update_f64(kq_filter_f64 *f, const kq_sensor_f64 *s, const double *z);

/**
 * The same with some components missing.
 *   z        m; a component that is not present is not read
 *   present  bit c set: component c was measured (bits m and above are ignored); 0: none was,
 *            and the state stays as it is, bit for bit
 * Cost: where a correlated R has components missing, the decorrelation of the others is made
 * anew: about 2 m^3 multiplications, 424 words of stack.
 */
KQ_NODISCARD kq_status kq_update_subset_f32(kq_filter_f32 *f, const kq_sensor_f32 *s, const float *z,
                               uint32_t present);
KQ_NODISCARD kq_status kq_update_subset_f64(kq_filter_f64 *f, const kq_sensor_f64 *s, const double *z,
                               uint32_t present);

/**
 * From one measurement to the next: predict, then update.  Refused as a whole.
 * The errors of both.
 */
KQ_NODISCARD kq_status kq_step_f32(kq_filter_f32 *f, const kq_process_f32 *p, const float *u,
                      const kq_sensor_f32 *s, const float *z);
KQ_NODISCARD kq_status kq_step_f64(kq_filter_f64 *f, const kq_process_f64 *p, const double *u,
                      const kq_sensor_f64 *s, const double *z);

/**
 * x_i, rounded to a float, and what the rounding left: mean + mean_low is the whole word
 * (0 in f64).  In the state's unit.  NaN where f or i is bad.
 */
float kq_mean_f32(const kq_filter_f32 *f, int i);
double kq_mean_f64(const kq_filter_f64 *f, int i);
float kq_mean_low_f32(const kq_filter_f32 *f, int i);
double kq_mean_low_f64(const kq_filter_f64 *f, int i);

/** sqrt(P_ii), in the state's unit; the 95 % interval is mean +- 1.96 sigma.  NaN where f or i
    is bad. */
float kq_sigma_f32(const kq_filter_f32 *f, int i);
double kq_sigma_f64(const kq_filter_f64 *f, int i);

/**
 * P = S S', exactly symmetric.
 *   P        n x n, written
 * Cost: n^3/6 multiplications.  KQ_ERR_NULL, KQ_ERR_NOT_READY.
 */
KQ_NODISCARD kq_status kq_covariance_f32(const kq_filter_f32 *f, float *P);
KQ_NODISCARD kq_status kq_covariance_f64(const kq_filter_f64 *f, double *P);

/**
 * The measurement that the state implies: z^ = H x, with S = H P H' + R.  Before an update it
 * is the predicted measurement and S the innovation covariance; on a forecast it is the
 * forecast of the measurement.  Changes nothing.
 *   z        m, written, or NULL
 *   S        m x m, exactly symmetric, written, or NULL
 * Cost: m n^2 + m^2 n / 2 multiplications.  KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_MISMATCH.
 */
KQ_NODISCARD kq_status kq_measurement_f32(const kq_filter_f32 *f, const kq_sensor_f32 *s, float *z, float *S);
KQ_NODISCARD kq_status kq_measurement_f64(const kq_filter_f64 *f, const kq_sensor_f64 *s, double *z, double *S);

/**
 * e = z - H x, from the whole word of the mean.  Call it before the update.
 *   z        m
 *   e        m, written; may be z
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_MISMATCH, KQ_ERR_NOT_FINITE (z, or an e not representable).
 */
KQ_NODISCARD kq_status kq_innovation_f32(const kq_filter_f32 *f, const kq_sensor_f32 *s, const float *z,
                            float *e);
KQ_NODISCARD kq_status kq_innovation_f64(const kq_filter_f64 *f, const kq_sensor_f64 *s, const double *z,
                            double *e);

/**
 * K = P H' S^-1, the gain that the next update would use.  Changes nothing.  Where S is
 * singular, the component that says nothing new has a zero column: for consistent data K e is
 * that of the pseudo-inverse.
 *   K        n x m, written
 * Cost: about that of the update.
 * Stack: 168 words more.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_MISMATCH.
 */
KQ_NODISCARD kq_status kq_gain_f32(const kq_filter_f32 *f, const kq_sensor_f32 *s, float *K);
KQ_NODISCARD kq_status kq_gain_f64(const kq_filter_f64 *f, const kq_sensor_f64 *s, double *K);

/** e' S^-1 e of the last update (normalised innovation squared): chi-square with kq_taken()
    degrees of freedom if the model is right.  NaN where f is bad, 0 before any update.  A step of a settled
    kq_freeze (steady.h) is no update: this, kq_taken and the log-likelihoods stay as they were. */
float kq_nis_f32(const kq_filter_f32 *f);
double kq_nis_f64(const kq_filter_f64 *f);

/** Scalar measurements that the last update took: present, and not at the floor.  -1 where f
    is bad. */
int kq_taken_f32(const kq_filter_f32 *f);
int kq_taken_f64(const kq_filter_f64 *f);

/**
 * log p(z) = -(m log 2 pi + log det S + e' S^-1 e) / 2, of the last update, and summed over
 * all updates since init; m counts the measurements taken.  NaN where f is bad.
 * Accuracy of the sum: each of the three terms to an eps of its own size (f32: 2^-23) whatever the
 * length of the run, 100 years at 10 kHz and longer; then the sum is rounded to a number.
 */
float kq_log_likelihood_last_f32(const kq_filter_f32 *f);
double kq_log_likelihood_last_f64(const kq_filter_f64 *f);
float kq_log_likelihood_f32(const kq_filter_f32 *f);
double kq_log_likelihood_f64(const kq_filter_f64 *f);

/** The sticky events (KQ_EVENT_..., status.h), and back to none.  A NULL f has none. */
unsigned kq_events_f32(const kq_filter_f32 *f);
unsigned kq_events_f64(const kq_filter_f64 *f);
void kq_events_clear_f32(kq_filter_f32 *f);
void kq_events_clear_f64(kq_filter_f64 *f);

/**
 * The state k steps ahead, without measurements; the filter does not change.
 *   f        read
 *   u        k x l, the controls of the k steps, or NULL: none
 *   steps    k; 0 copies
 *   ahead    another filter of n states with its own memory; written.  It is a filter like any
 *            other, with nothing attached: read it with kq_mean, kq_sigma, kq_covariance and, for
 *            the measurement to come, kq_measurement.
 * Cost: k predicts.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_SIZE (more than KQ_COUNT_MAX steps), KQ_ERR_MEMORY (ahead),
 * KQ_ERR_MISMATCH (states, or ahead is f), KQ_ERR_NOT_FINITE (u).
 */
KQ_NODISCARD kq_status kq_forecast_f32(const kq_filter_f32 *f, const kq_process_f32 *p, const float *u,
                          size_t steps, kq_filter_f32 *ahead);
KQ_NODISCARD kq_status kq_forecast_f64(const kq_filter_f64 *f, const kq_process_f64 *p, const double *u,
                          size_t steps, kq_filter_f64 *ahead);

/**
 * Can f be what a call has left?  Call it between two calls, also while a start has unknown states.
 *   f        read, with its memory; its seal is written
 * The first call after an init, a copy, an attach or a detach keeps a seal of sizes and addresses, later calls
 * compare.  Flags, counts, mean and root change with every step: it is asked whether a call may leave them so.
 * Of 100 turned bits of a filter's mean and root 0.4 to 2.5 are found in floats, 12 and 24 in q31.  What is not found
 * is a state that may be; measurements correct it.  In no part has a turned bit crashed a step after this check, nor has
 * one of the struct misled the state.  Of 100 bits of the mean 1 (f32) to 3 (q31) still mislead after 50 steps: watch
 * kq_nis.  Of 100 bits of the likelihoods 13 to 31 falsify kq_log_likelihood (three models, three seeds;
 * tests/campaign/turned.c prints it).
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_NOT_FINITE (the mean: damaged, or driven there by A or a control),
 * KQ_ERR_TABLE (f is damaged: initialise it again).
 */
KQ_NODISCARD kq_status kq_filter_check_f32(kq_filter_f32 *f);
KQ_NODISCARD kq_status kq_filter_check_f64(kq_filter_f64 *f);

/* ------------------------------------------------------------------ q31
 *
 * The same filter in integers: rows of S with 32-bit mantissas and an exponent each, the mean in
 * 32 + 24 bits.  Means, sigmas, controls, measurements and innovations are words in the formats of
 * their components; P, S and K are kq_scaled_q31 in units of those words (fixed_point.h).
 */

/** Words of memory of a filter with n states. */
#define KQ_FILTER_LEN_Q31(n) (2 * (n) + KQ_ROOT_LEN_Q31(n))

struct kq_attached_q31 {
    const struct kq_hooks_q31 *hooks;
};

/** The state before the first measurement as a table (process.h, fixed_point.h). */
typedef struct {
    int32_t states;                    /* n: 1..16 */
    const kq_format_q31 *state_format; /* n */
    const int32_t *mean;               /* x0, n words */
    const int32_t *root;               /* of P0, KQ_ROOT_LEN_Q31(n) words */
} kq_prior_table_q31;

/* The fields of these three are the library's. */
typedef struct {
    int64_t nis;               /* Q39.24 */
    kq_scaled_q31 determinant; /* in physical units */
    int32_t count;
} kq_likelihood_q31;

/* Of a run: the sum is carried 2^37 + sum 2^-24 (see kq_likelihood_run_f32). */
typedef struct {
    int64_t sum; /* within +-2^61 */
    int32_t carried;
    int32_t count;
    kq_scaled_q31 determinant;
} kq_likelihood_run_q31;

typedef struct {
    uint8_t states;
    uint8_t ready;
    uint16_t events;
    uint8_t plain;
    uint8_t seal;
    uint16_t known;
    int32_t *memory;
    struct kq_attached_q31 *attached;
    const kq_format_q31 *state_format;
    uint32_t weak;
    kq_likelihood_q31 last;
    kq_likelihood_run_q31 run;
} kq_filter_q31;

/** A filter `name` of n states with its storage, in static memory. */
#define KQ_FILTER_Q31(name, n)                                                                     \
    static int32_t name##_memory[KQ_FILTER_LEN_Q31(n)];                                            \
    static kq_filter_q31 name = {n,                                                                \
                                 0,                                                                \
                                 0,                                                                \
                                 0,                                                                \
                                 0,                                                                \
                                 0,                                                                \
                                 name##_memory,                                                    \
                                 NULL,                                                             \
                                 NULL,                                                             \
                                 0,                                                                \
                                 {0, {0, 0}, 0},                                                   \
                                 {0, 0, 0, {0, 0}}}

/** As kq_filter_assign_f32; KQ_FILTER_LEN_Q31(n) words. */
KQ_NODISCARD kq_status kq_filter_assign_q31(kq_filter_q31 *f, int n, int32_t *memory, size_t length);

/**
 * x ~ N(x0, P0) from a table; mean and root are copied, the formats kept by reference.  Clears
 * the events and the log-likelihood, detaches the history.
 *   range_error   written: KQ_NO_RANGE_ERROR, or the mean that is beyond its declared range where that is refused
 *            (KQ_ERR_RANGE); or NULL
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY, KQ_ERR_MISMATCH (states), KQ_ERR_RANGE, KQ_ERR_TABLE
 * (a row of the root whose norm is above 2^30, an exponent beyond 1000, a negative pivot).
 */
KQ_NODISCARD kq_status kq_filter_init_q31(kq_filter_q31 *f, const kq_prior_table_q31 *prior,
                             kq_range_error_q31 *range_error);

/**
 * As in f32.
 * KQ_ERR_MISMATCH also where filter and process or sensor do not agree on the states' formats;
 * KQ_ERR_RANGE for a control or a measurement outside its declared range. Nothing can overflow but
 * the mean, which a call leaves within +-2^31 words, held there with KQ_EVENT_SATURATED if need be;
 * between the components of one measurement it may be 64 times as far, at the cost of a sharp
 * measurement for the components that follow.  (kq_step leaves a predicted mean as kq_predict
 * does.)  KQ_EVENT_OVERFLOW is predict's alone.  An innovation variance of 2^-200 squared words is
 * at the floor.
 * Accuracy: each step is exact for rows of S perturbed by about (2n + 4) 2^-29 of their norm, and
 * for a mean rounded to 2^-24 word.  Choose formats whose last bit is not far above the sigmas: a
 * sigma below 2^-20 word is nothing to the mean.  A process noise below 2^-15 sigma of its state
 * is lost; a noise-free measurement counts as one of 2^-24 word in every state.  With Q = 0 sigma is
 * off by 0.2 % after 5e6 measurements and by 0.7 % after 2e7; KQ_EVENT_PRECISION: H P H' was within
 * the last six bits of S in 2^24 components since init.
 * Cost: the multiplications of f32, as 32 x 32 -> 64 bits; integer instructions only.  A
 * correlated R is decorrelated at every update.  One with R below 2^-8 S, and those that follow it, are
 * taken with more care, in one pass: an update costs 8 times as much at most up to n = 3, and 14
 * times up to n = 9 (instructions_worst in tools/cost.csv).
 */
KQ_NODISCARD kq_status kq_filter_copy_q31(kq_filter_q31 *to, const kq_filter_q31 *from);
KQ_NODISCARD kq_status kq_attach_q31(kq_filter_q31 *f, struct kq_attached_q31 *object);
KQ_NODISCARD kq_status kq_detach_q31(struct kq_attached_q31 *object);
KQ_NODISCARD kq_status kq_predict_q31(kq_filter_q31 *f, const kq_process_q31 *p, const int32_t *u);
KQ_NODISCARD kq_status kq_update_q31(kq_filter_q31 *f, const kq_sensor_q31 *s, const int32_t *z);
KQ_NODISCARD kq_status kq_update_subset_q31(kq_filter_q31 *f, const kq_sensor_q31 *s, const int32_t *z,
                               uint32_t present);
KQ_NODISCARD kq_status kq_step_q31(kq_filter_q31 *f, const kq_process_q31 *p, const int32_t *u,
                      const kq_sensor_q31 *s, const int32_t *z);
KQ_NODISCARD kq_status kq_forecast_q31(const kq_filter_q31 *f, const kq_process_q31 *p, const int32_t *u,
                          size_t steps, kq_filter_q31 *ahead);

/** x_i rounded to a word, and what the rounding left, in 2^-24 of a word: -2^23 .. 2^23,
    beyond it only at the word's end.
    KQ_NOT_A_VALUE_Q31 where f or i is bad. */
int32_t kq_mean_q31(const kq_filter_q31 *f, int i);
int32_t kq_mean_low_q31(const kq_filter_q31 *f, int i);

/** sqrt(P_ii) rounded to a word, at most 2^31 - 1.  (Finer: kq_covariance_q31.) */
int32_t kq_sigma_q31(const kq_filter_q31 *f, int i);

/** As in f32, entries to 31 bits. */
KQ_NODISCARD kq_status kq_covariance_q31(const kq_filter_q31 *f, kq_scaled_q31 *P);
KQ_NODISCARD kq_status kq_measurement_q31(const kq_filter_q31 *f, const kq_sensor_q31 *s, int32_t *z,
                             kq_scaled_q31 *S);
KQ_NODISCARD kq_status kq_gain_q31(const kq_filter_q31 *f, const kq_sensor_q31 *s, kq_scaled_q31 *K);

/** As in f32; e is held at +-(2^31 - 1) words. */
KQ_NODISCARD kq_status kq_innovation_q31(const kq_filter_q31 *f, const kq_sensor_q31 *s, const int32_t *z,
                            int32_t *e);

/** Scores are Q39.24: value = score * 2^-24, held at +-2^61.  The log-likelihood is that of z in
    physical units.  KQ_NOT_A_SCORE_Q31 where f is bad. */
int64_t kq_nis_q31(const kq_filter_q31 *f);
int64_t kq_log_likelihood_last_q31(const kq_filter_q31 *f);
int64_t kq_log_likelihood_q31(const kq_filter_q31 *f);

int kq_taken_q31(const kq_filter_q31 *f);
unsigned kq_events_q31(const kq_filter_q31 *f);
void kq_events_clear_q31(kq_filter_q31 *f);

/** As kq_filter_check_f32. */
KQ_NODISCARD kq_status kq_filter_check_q31(kq_filter_q31 *f);

#ifdef __cplusplus
}
#endif
#endif
