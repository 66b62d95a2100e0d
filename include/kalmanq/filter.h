/*
 * kalmanq: the filter, the estimate of the state.
 *
 *     predict   x <- A x + B u           P <- A P A' + Q
 *     update    e = z - H x              S = H P H' + R          K = P H' S^-1
 *               x <- x + K e             P <- P - K S K'
 *
 * The filter keeps the upper triangular root of P, so P is positive semi-definite whatever the rounding.  Predict is
 * a Householder triangularisation.  Update takes one scalar measurement after the other (Carlson).  Nothing is
 * inverted; a singular S takes the pseudo-inverse.  The mean is a pair of floats in f32 (about 48 bits), a double in
 * f64, 56 bits in q31.
 *
 * A run is init, update, predict, update, predict, ...: x0 and P0 hold before the first measurement.  Any number of
 * processes and sensors, of any size m, may take turns.
 *
 * A LOW-NOISE MEASUREMENT has R much smaller than H P H': below 2^-16 S (f32), 2^-48 S (f64), 2^-8 S (q31).
 *
 * Sharing and interrupts.  All state is in the objects that you pass.  Calls that write different objects may run at
 * the same time and may read the same process, sensor or table.  There are no locks: you must not change an object
 * while another call uses it.  A filter and what is attached to it count as one object.  An interrupt that reads a
 * filter during a predict or update gets a mixture of old and new numbers, within one kq_mean too: turn interrupts
 * off while you read it or copy it (kq_filter_copy).  kq_events and kq_taken read one memory word each: on a 32-bit
 * chip you may call them at any time.
 * Assigning the struct copies a pointer: both filters then use one memory.  Use kq_filter_copy.
 *
 * Attaching.  One object at a time takes part in a filter's kq_predict, kq_update, kq_update_subset and kq_step: a
 * history (smoother.h), a lag, an instant, a diffuse start, an adaptation or a freeze.  Its header says what it adds
 * to their costs and errors.  A program links only what it declares.
 */
#ifndef KALMANQ_FILTER_H
#define KALMANQ_FILTER_H

#include "process.h"
#include "sensor.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Words of memory of a filter with n states: the mean, then the root of P. */
#define KQ_FILTER_LEN_F32(n) (2 * (n) + KQ_TRIANGLE(n))
#define KQ_FILTER_LEN_F64(n) ((n) + KQ_TRIANGLE(n))

/* The first field of every object that can be attached: the functions that its steps call */
struct kq_attached_f32 { const struct kq_hooks_f32 *hooks; };
struct kq_attached_f64 { const struct kq_hooks_f64 *hooks; };

/* The fields of the structs that follow are the library's (see process.h). */

/* A sum over a run, high + sum + low: 3 x 24 bits in f32, 3 x 53 in f64 */
typedef struct { float high, sum, low; } kq_compensated_f32;
typedef struct { double high, sum, low; } kq_compensated_f64;

/* Of an update: NIS, and det S = determinant * 2^exponent, over `count` scalar measurements.  Of a run: `sum`
   has the NIS, and what `count` and `exponent` stood for before they could wrap. */
typedef struct { float nis, determinant; int32_t exponent, count; } kq_likelihood_f32;
typedef struct { double nis, determinant; int32_t exponent, count; } kq_likelihood_f64;
typedef struct { kq_compensated_f32 sum; float determinant; int32_t exponent, count; } kq_likelihood_run_f32;
typedef struct { kq_compensated_f64 sum; double determinant; int32_t exponent, count; } kq_likelihood_run_f64;

typedef struct {
    uint8_t states;                   /* n */
    uint8_t ready;                    /* 0: not initialised; otherwise flags */
    uint16_t events;                  /* KQ_EVENT_... */
    uint8_t plain;                    /* n if an ordinary step will do, otherwise 0 */
    uint8_t seal;                     /* of sizes and addresses (kq_filter_check) */
    uint16_t known;                   /* bit i: component i can be read */
    float *memory;                    /* yours: mean, then root */
    struct kq_attached_f32 *attached; /* or NULL */
    uint32_t weak, losses;            /* measurements that take little of P; what rounding takes of it, times 2^32 */
    kq_likelihood_f32 last;           /* of the last update */
    kq_likelihood_run_f32 run;        /* since init */
} kq_filter_f32;

typedef struct {
    uint8_t states, ready; uint16_t events; uint8_t plain, seal; uint16_t known; double *memory;
    struct kq_attached_f64 *attached; uint32_t weak, losses; kq_likelihood_f64 last; kq_likelihood_run_f64 run;
} kq_filter_f64;

/** Declares a filter `name` of n states with its memory, static. */
#define KQ_FILTER_F32(name, n) \
    static float name##_memory[KQ_FILTER_LEN_F32(n)]; \
    static kq_filter_f32 name = {n, 0, 0, 0, 0, 0, name##_memory, NULL, 0, 0, {0, 0, 0, 0}, {{0, 0, 0}, 0, 0, 0}}
#define KQ_FILTER_F64(name, n) \
    static double name##_memory[KQ_FILTER_LEN_F64(n)]; \
    static kq_filter_f64 name = {n, 0, 0, 0, 0, 0, name##_memory, NULL, 0, 0, {0, 0, 0, 0}, {{0, 0, 0}, 0, 0, 0}}

/** Gives a filter its size and memory at run time; the macros do it at compile time.
 *   f        written
 *   n        1..16 states
 *   memory   `length` words, yours while the filter is in use
 *   length   KQ_FILTER_LEN_<T>(n) or more
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY. */
KQ_NODISCARD kq_status kq_filter_assign_f32(kq_filter_f32 *f, int n, float *memory, size_t length);
KQ_NODISCARD kq_status kq_filter_assign_f64(kq_filter_f64 *f, int n, double *memory, size_t length);

/** Sets the state before the first measurement: x ~ N(x0, P0).
 *   f        with sizes and memory; written
 *   x0       n, in the states' units; not kept
 *   P0       n x n, symmetric positive semi-definite, may be singular or 0; not kept.  The upper triangle is used,
 *            the lower one compared with it.
 * Clears events and log-likelihood.  Detaches what is attached without reading it: it may be gone.
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY, KQ_ERR_NOT_FINITE, KQ_ERR_NOT_SYMMETRIC, KQ_ERR_NOT_SEMIDEFINITE,
 * KQ_ERR_RANGE (a variance or |x0_i| is above 2^120 in f32, 2^1000 in f64: use diffuse.h).
 * Cost: about 2 n^3 multiplications, 2n square roots.  Stack: 424 words.  Accuracy: as Q in kq_process_init. */
KQ_NODISCARD kq_status kq_filter_init_f32(kq_filter_f32 *f, const float *x0, const float *P0);
KQ_NODISCARD kq_status kq_filter_init_f64(kq_filter_f64 *f, const double *x0, const double *P0);

/** kq_filter_init with P0 = S S' given by its root.
 *   f, x0    as in kq_filter_init
 *   S        upper triangular, diagonal >= 0, KQ_TRIANGLE(n) numbers by columns; not kept
 * Cost and errors: as kq_process_init_root. */
KQ_NODISCARD kq_status kq_filter_init_root_f32(kq_filter_f32 *f, const float *x0, const float *S);
KQ_NODISCARD kq_status kq_filter_init_root_f64(kq_filter_f64 *f, const double *x0, const double *S);

/** Copies mean, covariance, events and likelihoods, bit for bit.
 *   to       n states, its own memory; written.  Nothing is attached to it afterwards; what was is not read.
 *   from     read; keeps what is attached to it
 * KQ_ERR_NULL, KQ_ERR_NOT_READY (from), KQ_ERR_MEMORY (to), KQ_ERR_MISMATCH (states, or `to` is `from` or has its
 * memory).  Cost: a copy of KQ_FILTER_LEN(n) words. */
KQ_NODISCARD kq_status kq_filter_copy_f32(kq_filter_f32 *to, const kq_filter_f32 *from);
KQ_NODISCARD kq_status kq_filter_copy_f64(kq_filter_f64 *to, const kq_filter_f64 *from);

/** Attaches an object to a filter: kq_attach_f32(&cart, &tape.attached).
 *   f        ready; changed
 *   object   the field `attached` of a history, a lag, an instant, an adaptation, a freeze or a kq_jacobians;
 *            changed.  A diffuse start attaches itself (kq_diffuse_init).
 * f and the object must outlive each other until kq_detach.  A history, a lag or an instant replaces another one of
 * these, which ends its recording and still has the filter: detach it while the filter exists.  kq_filter_init and
 * kq_filter_assign of f detach without telling the object: call kq_detach before you attach the object to another
 * filter, or assign it anew if its filter is gone.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY (f; an object never assigned), KQ_ERR_SIZE or KQ_ERR_MEMORY (an object without sizes
 * or memory), KQ_ERR_MISMATCH (states), KQ_ERR_RECORDING (the object has another filter, or f has an object that
 * cannot be replaced). */
KQ_NODISCARD kq_status kq_attach_f32(kq_filter_f32 *f, struct kq_attached_f32 *object);
KQ_NODISCARD kq_status kq_attach_f64(kq_filter_f64 *f, struct kq_attached_f64 *object);

/** Detaches an object from its filter, which goes on without it.  Each may then go before the other.
 *   object   as in kq_attach.  Without a filter it stays as it is.  Its filter must still exist.
 * A history loses what it has not smoothed; what it has smoothed can still be read.  A diffuse start keeps its filter
 * and loses the history that it has taken along.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY (an object never assigned or initialised). */
KQ_NODISCARD kq_status kq_detach_f32(struct kq_attached_f32 *object);
KQ_NODISCARD kq_status kq_detach_f64(struct kq_attached_f64 *object);

/** Time update: x <- A x + B u,  P <- A P A' + Q.
 *   f        changed
 *   p        of n states; read
 *   u        l controls, or NULL for none at this step; not read if l = 0
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_MISMATCH (number of states), KQ_ERR_NOT_FINITE (u).
 * Events: KQ_EVENT_OVERFLOW: the sigma of a state that nothing measures has reached 2^60 (f32), 2^500 (f64) or 2^8160
 * raw values (q31).  In f32 and f64 it becomes 2^-16 of that and the state loses its correlations.  A mean beyond 2^120 (f32) or
 * 2^1000 (f64), or whose A x + B u overflows, becomes 0 (q31: it is saturated).  A state that A does not couple to it
 * keeps its mean.  Measurements bring the state back.  A history ends.  KQ_EVENT_PRECISION: rounding hides what a
 * low-noise measurement said, or the rounding of many updates may have moved a sigma by 5 %: use f64.  One
 * measurement in 8 is looked at for the latter (64 at compile-time sizes), none of lean sensors and KQ_FIXED_BARE.
 * Or what A S adds to S is rounded away at each step, and what measurements say of a rate may be with it: looked
 * at after 64 scalar measurements of such sensors.
 * Accuracy: P is exact for rows of the root perturbed by a few n eps of their norm.  A conditional sigma smaller than
 * this error is lost.  In f32 a mean with 1/2 <= A_ii <= 2 is rounded at its increment, not at its own size.
 * Cost: about n^3 multiplications, n^3/2 if A is upper triangular (states in the order position, velocity, ...), n
 * square roots, 2n divisions.  Stack: n^2 + 2n words, n rounded up to 4, 9 or 16. */
KQ_NODISCARD kq_status kq_predict_f32(kq_filter_f32 *f, const kq_process_f32 *p, const float *u);
KQ_NODISCARD kq_status kq_predict_f64(kq_filter_f64 *f, const kq_process_f64 *p, const double *u);

/** Measurement update: takes z = H x + v.
 *   f        changed
 *   s        of n states; read
 *   z        m, in the sensor's units
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_MISMATCH, KQ_ERR_NOT_FINITE (z).
 * Events: KQ_EVENT_REDUNDANT, KQ_EVENT_OVERFLOW: a component was not taken.  Where H P H' overflows in f32 and f64, states
 * lose their correlations as in kq_predict, here from a sigma of 2^57 (2^497) over the largest entry of the row: the
 * component is taken then.  A component is redundant if its
 * innovation variance is below 2^-96 (f32) or 2^-360 (f64): choose units above it.  A noise-free one, or one after a
 * low-noise measurement, is redundant if its innovation variance is rounding.  KQ_EVENT_CONTRADICTION: see status.h.
 * KQ_EVENT_PRECISION: H x of a low-noise component is rounded by an eighth of sqrt(R), for R = 0 of its innovation's
 * sigma, or overflows (f32, f64).
 * Accuracy: P is exact for rows of the root perturbed by a few eps of their norm for each component.  Of a component with
 * H P H' below 2^-14 of its innovation variance (q31: 2^-17) what is taken from the root is rounded up or down as often as is
 * right: with Q = 0 P is off by 4e-4 after 2e6 of them, by 3e-3 after 8e6 (f32).  They cost as low-noise ones (below).  Put noise-free
 * components that may repeat each other into one sensor: a later call may take their rounding for information.  A
 * noise-free component can leave a state with sigma 0, and may measure it again.
 * Cost: 2 n^2 multiplications, n square roots, 2n divisions a component.  A correlated R adds m n / 2 multiplications
 * a component; a row of H that selects one state saves n^2 / 2.  With a low-noise measurement up to 7 times as much at
 * n = 2, 10 times at n = 9 (instructions_worst in tools/cost.csv).  One component in 8 also has its rounding looked at
 * (kq_predict): at most 2 n multiplications more in that call. */
KQ_NODISCARD kq_status kq_update_f32(kq_filter_f32 *f, const kq_sensor_f32 *s, const float *z);
KQ_NODISCARD kq_status kq_update_f64(kq_filter_f64 *f, const kq_sensor_f64 *s, const double *z);

/** kq_update with some components missing.
 *   f, s     as in kq_update
 *   z        m; a missing component is not read
 *   present  bit c: component c was measured; bits from m on are ignored.  0 leaves the state as it is.
 * Cost: 2 m^3 multiplications more if R is correlated and a component missing; then stack: 424 words. */
KQ_NODISCARD kq_status kq_update_subset_f32(kq_filter_f32 *f, const kq_sensor_f32 *s, const float *z,
    uint32_t present);
KQ_NODISCARD kq_status kq_update_subset_f64(kq_filter_f64 *f, const kq_sensor_f64 *s, const double *z,
    uint32_t present);

/** kq_predict of f by p and u, then kq_update by s and z.
 *   f        changed
 *   p        of n states; read
 *   u        l controls, or NULL for none
 *   s        of n states; read
 *   z        m, in the sensor's units
 * Errors, events and cost: as kq_predict and kq_update.  After an error neither is done. */
KQ_NODISCARD kq_status kq_step_f32(kq_filter_f32 *f, const kq_process_f32 *p, const float *u,
    const kq_sensor_f32 *s, const float *z);
KQ_NODISCARD kq_status kq_step_f64(kq_filter_f64 *f, const kq_process_f64 *p, const double *u,
    const kq_sensor_f64 *s, const double *z);

/** The mean x_i in the state's unit.  kq_mean_low is what rounding it to one number leaves (0 in f64).
 *   f        read: a filter, a forecast or a view
 *   i        0 .. n-1
 * The sum of both is all of it.  NaN if f or i is bad. */
float kq_mean_f32(const kq_filter_f32 *f, int i);
double kq_mean_f64(const kq_filter_f64 *f, int i);
float kq_mean_low_f32(const kq_filter_f32 *f, int i);
double kq_mean_low_f64(const kq_filter_f64 *f, int i);

/** sqrt(P_ii) in the state's unit; the 95 % interval is mean +- 1.96 sigma.
 *   f        read: a filter, a forecast or a view
 *   i        0 .. n-1
 * NaN if f or i is bad.  Cost: n - i multiplications, a square root. */
float kq_sigma_f32(const kq_filter_f32 *f, int i);
double kq_sigma_f64(const kq_filter_f64 *f, int i);

/** The covariance P, exactly symmetric.
 *   f        read
 *   P        n x n, written
 * KQ_ERR_NULL, KQ_ERR_NOT_READY.  Cost: n^3/6 multiplications. */
KQ_NODISCARD kq_status kq_covariance_f32(const kq_filter_f32 *f, float *P);
KQ_NODISCARD kq_status kq_covariance_f64(const kq_filter_f64 *f, double *P);

/** The predicted measurement z = H x and its covariance S = H P H' + R, of a filter or of a forecast.
 *   f        read
 *   s        of n states; read
 *   z        m, written, or NULL; rounded to numbers.  kq_innovation of it shows the mean's low part.
 *   S        m x m, exactly symmetric, written, or NULL
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_MISMATCH.  Cost: m n^2 + m^2 n / 2 multiplications. */
KQ_NODISCARD kq_status kq_measurement_f32(const kq_filter_f32 *f, const kq_sensor_f32 *s, float *z, float *S);
KQ_NODISCARD kq_status kq_measurement_f64(const kq_filter_f64 *f, const kq_sensor_f64 *s, double *z, double *S);

/** The innovation e = z - H x, with the low part of the mean.  Call it before the update.
 *   f        read
 *   s        of n states; read
 *   z        m, in the sensor's units
 *   e        m, written; may be z
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_MISMATCH, KQ_ERR_NOT_FINITE (z, or e is NaN or infinite).
 * Cost: m n multiplications. */
KQ_NODISCARD kq_status kq_innovation_f32(const kq_filter_f32 *f, const kq_sensor_f32 *s, const float *z, float *e);
KQ_NODISCARD kq_status kq_innovation_f64(const kq_filter_f64 *f, const kq_sensor_f64 *s, const double *z, double *e);

/** The gain K = P H' S^-1 of the next update.
 *   f        read
 *   s        of n states; read
 *   K        n x m, written.  A component that says nothing new has a zero column (pseudo-inverse).
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_MISMATCH.  Cost: about an update.  Stack: 168 words more. */
KQ_NODISCARD kq_status kq_gain_f32(const kq_filter_f32 *f, const kq_sensor_f32 *s, float *K);
KQ_NODISCARD kq_status kq_gain_f64(const kq_filter_f64 *f, const kq_sensor_f64 *s, double *K);

/** NIS = e' S^-1 e of the last update: chi-square with kq_taken() degrees of freedom if the model is right.
 *   f        read
 * 0 before any update, NaN if f is bad.  A step of an active kq_freeze (steady.h) leaves NIS, kq_taken and the
 * log-likelihoods as they were. */
float kq_nis_f32(const kq_filter_f32 *f);
double kq_nis_f64(const kq_filter_f64 *f);

/** Scalar measurements that the last update took: present and not redundant.
 *   f        read; -1 if it is bad */
int kq_taken_f32(const kq_filter_f32 *f);
int kq_taken_f64(const kq_filter_f64 *f);

/** log p(z) = -(m log 2 pi + log det S + e' S^-1 e) / 2 of the last update, and summed since init; m counts the
 * measurements taken.
 *   f        read
 * NaN if f is bad.  Accuracy of the sum: each of the three terms to an eps of its size, however long the run.
 * Cost: a logarithm. */
float kq_log_likelihood_last_f32(const kq_filter_f32 *f);
double kq_log_likelihood_last_f64(const kq_filter_f64 *f);
float kq_log_likelihood_f32(const kq_filter_f32 *f);
double kq_log_likelihood_f64(const kq_filter_f64 *f);

/** Reads and clears the sticky events (KQ_EVENT_... in status.h).
 *   f        read; kq_events_clear changes it.  0 if it is NULL */
unsigned kq_events_f32(const kq_filter_f32 *f);
unsigned kq_events_f64(const kq_filter_f64 *f);
void kq_events_clear_f32(kq_filter_f32 *f);
void kq_events_clear_f64(kq_filter_f64 *f);

/** The state `steps` steps ahead, without measurements.
 *   f        read
 *   p        of n states; read
 *   u        steps x l controls, or NULL for none
 *   steps    0 copies
 *   ahead    another filter of n states with its own memory; written, with nothing attached.  kq_measurement of it is
 *            the forecast of the measurement.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_SIZE (above KQ_COUNT_MAX steps), KQ_ERR_MEMORY (ahead), KQ_ERR_MISMATCH
 * (states, or ahead is f), KQ_ERR_NOT_FINITE (u).  Cost: a predict a step. */
KQ_NODISCARD kq_status kq_forecast_f32(const kq_filter_f32 *f, const kq_process_f32 *p, const float *u,
    size_t steps, kq_filter_f32 *ahead);
KQ_NODISCARD kq_status kq_forecast_f64(const kq_filter_f64 *f, const kq_process_f64 *p, const double *u,
    size_t steps, kq_filter_f64 *ahead);

/** Checks whether memory errors have damaged f.  Call it between two calls, also during a diffuse start.
 *   f        read, with its memory.  The first check after an init, copy, attach or detach writes a seal of sizes and
 *            addresses; later checks compare it.
 * It compares the numbers with what a call can leave, so it finds few of the turned bits in mean, root and
 * likelihoods (tests/ACCURACY.md).  Measurements correct the others: watch kq_nis.
 * What is attached (history, lag, instant, start, adaptation, freeze) and its memory are not checked.  A turned bit there
 * may mislead a smoother or a frozen step, or make it write outside its memory: assign it anew for each recording.
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, KQ_ERR_NOT_FINITE (the mean), KQ_ERR_TABLE (damaged: initialise f again).
 * Cost: about n^2 operations. */
KQ_NODISCARD kq_status kq_filter_check_f32(kq_filter_f32 *f);
KQ_NODISCARD kq_status kq_filter_check_f64(kq_filter_f64 *f);

/* ------------------------------------------------------------------ q31
 *
 * The same filter in integers.  Means, sigmas, controls, measurements and innovations are raw values in the
 * formats of their components; P, S and K are kq_scaled_q31 in units of raw values (fixed_point.h).
 */

/** Words of memory of a filter with n states. */
#define KQ_FILTER_LEN_Q31(n) (2 * (n) + KQ_ROOT_LEN_Q31(n))

struct kq_attached_q31 { const struct kq_hooks_q31 *hooks; };

/** The state before the first measurement as a table (process.h, fixed_point.h). */
typedef struct {
    int32_t states;                    /* n: 1..16 */
    const kq_format_q31 *state_format; /* n */
    const int32_t *mean;               /* x0, n raw values */
    const int32_t *root;               /* of P0, KQ_ROOT_LEN_Q31(n) words */
} kq_prior_table_q31;

/* nis: Q39.24; determinant: in physical units.  A run's sum is carried 2^37 + sum 2^-24, |sum| <= 2^61. */
typedef struct { int64_t nis; kq_scaled_q31 determinant; int32_t count; } kq_likelihood_q31;
typedef struct { int64_t sum; int32_t carried, count; kq_scaled_q31 determinant; } kq_likelihood_run_q31;

typedef struct {
    uint8_t states, ready; uint16_t events; uint8_t plain, seal; uint16_t known; int32_t *memory;
    struct kq_attached_q31 *attached; const kq_format_q31 *state_format; uint32_t weak, losses; kq_likelihood_q31 last;
    kq_likelihood_run_q31 run;
} kq_filter_q31;

/** As KQ_FILTER_F32. */
#define KQ_FILTER_Q31(name, n) \
    static int32_t name##_memory[KQ_FILTER_LEN_Q31(n)]; \
    static kq_filter_q31 name = {n, 0, 0, 0, 0, 0, name##_memory, NULL, NULL, 0, 0, {0, {0, 0}, 0}, \
        {0, 0, 0, {0, 0}}}

/** As kq_filter_assign_f32; KQ_FILTER_LEN_Q31(n) words. */
KQ_NODISCARD kq_status kq_filter_assign_q31(kq_filter_q31 *f, int n, int32_t *memory, size_t length);

/** As kq_filter_init_f32, from a table.
 *   prior        mean and root are copied; the formats are kept by reference
 *   range_error  written: KQ_NO_RANGE_ERROR, or the mean beyond its declared range (KQ_ERR_RANGE); or NULL
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY, KQ_ERR_MISMATCH (states), KQ_ERR_RANGE, KQ_ERR_TABLE (a row of the root
 * has a norm above 2^30, an exponent beyond 1000 or a negative diagonal). */
KQ_NODISCARD kq_status kq_filter_init_q31(kq_filter_q31 *f, const kq_prior_table_q31 *prior,
    kq_range_error_q31 *range_error);

/** As kq_update_f32, with these differences, which also hold for predict, step and forecast.  KQ_ERR_MISMATCH: also
 * if the states' formats differ.  KQ_ERR_RANGE: a control or measurement is outside its declared range.
 * Events: KQ_EVENT_SATURATED: a mean, the only number that can overflow, is saturated at +-2^31 raw values.  Between
 * the components of one measurement it may be 64 times as far; the components that follow then cost as low-noise
 * ones.  kq_step leaves a predicted mean as kq_predict does.  KQ_EVENT_OVERFLOW: predict alone sets it.
 * KQ_EVENT_REDUNDANT: also an innovation variance below 2^-200 squared raw values.
 * Accuracy: rows of the root to about (2n + 4) 2^-29 of their norm, the mean to 2^-24 raw value.  Choose formats
 * whose last bit is not far above the sigmas: a sigma below 2^-20 raw value does not reach the mean.  A process noise
 * below 2^-15 sigma of its state is lost.  A noise-free measurement counts as one of 2^-24 raw value in every state.
 * With Q = 0 each predict rounds P up: sigma is off by 0.2 % after 5e6 of them, by 0.7 % after 2e7.
 * Cost: the multiplications of f32, as 32 x 32 -> 64 bits; integer instructions only.  A correlated R is decorrelated
 * at every update.  With a low-noise measurement up to 8 times as much at n = 2, 19 times at n = 9 (instructions_worst
 * in tools/cost.csv). */
KQ_NODISCARD kq_status kq_update_q31(kq_filter_q31 *f, const kq_sensor_q31 *s, const int32_t *z);
/** As kq_update_subset_f32; errors, events and accuracy: as kq_update_q31. */
KQ_NODISCARD kq_status kq_update_subset_q31(kq_filter_q31 *f, const kq_sensor_q31 *s, const int32_t *z,
    uint32_t present);
/** As kq_predict_f32; errors, events and accuracy: as kq_update_q31. */
KQ_NODISCARD kq_status kq_predict_q31(kq_filter_q31 *f, const kq_process_q31 *p, const int32_t *u);
/** As kq_step_f32; errors, events and accuracy: as kq_update_q31. */
KQ_NODISCARD kq_status kq_step_q31(kq_filter_q31 *f, const kq_process_q31 *p, const int32_t *u,
    const kq_sensor_q31 *s, const int32_t *z);
/** As kq_forecast_f32; errors, events and accuracy: as kq_update_q31. */
KQ_NODISCARD kq_status kq_forecast_q31(const kq_filter_q31 *f, const kq_process_q31 *p, const int32_t *u,
    size_t steps, kq_filter_q31 *ahead);
/** As kq_filter_copy_f32, kq_attach_f32 and kq_detach_f32.  A copy takes the formats, too. */
KQ_NODISCARD kq_status kq_filter_copy_q31(kq_filter_q31 *to, const kq_filter_q31 *from);
KQ_NODISCARD kq_status kq_attach_q31(kq_filter_q31 *f, struct kq_attached_q31 *object);
KQ_NODISCARD kq_status kq_detach_q31(struct kq_attached_q31 *object);

/** x_i rounded to a raw value, and the rest in 2^-24 raw value: -2^23 .. 2^23, more only if x_i is saturated.
 * KQ_NOT_A_VALUE_Q31 if f or i is bad. */
int32_t kq_mean_q31(const kq_filter_q31 *f, int i);
int32_t kq_mean_low_q31(const kq_filter_q31 *f, int i);

/** sqrt(P_ii) rounded to a raw value, at most 2^31 - 1 (kq_covariance_q31 is finer). */
int32_t kq_sigma_q31(const kq_filter_q31 *f, int i);

/** As the f32 functions.  Entries of P, S, K have 31 bits; z, e are raw values, saturated at +-(2^31 - 1).
 * kq_innovation: KQ_ERR_RANGE (z is outside its declared range) in place of KQ_ERR_NOT_FINITE. */
KQ_NODISCARD kq_status kq_covariance_q31(const kq_filter_q31 *f, kq_scaled_q31 *P);
KQ_NODISCARD kq_status kq_measurement_q31(const kq_filter_q31 *f, const kq_sensor_q31 *s, int32_t *z,
    kq_scaled_q31 *S);
KQ_NODISCARD kq_status kq_innovation_q31(const kq_filter_q31 *f, const kq_sensor_q31 *s, const int32_t *z,
    int32_t *e);
KQ_NODISCARD kq_status kq_gain_q31(const kq_filter_q31 *f, const kq_sensor_q31 *s, kq_scaled_q31 *K);

/** As the f32 functions, as scores in Q39.24: value = score * 2^-24.  The log-likelihood is of z in physical units.
 * Scores saturate at +-2^61, which is 1.4e11: at 10 kHz and 3 a measurement after 53 days.  The filter is not
 * affected.  KQ_NOT_A_SCORE_Q31 if f is bad. */
int64_t kq_nis_q31(const kq_filter_q31 *f);
int64_t kq_log_likelihood_last_q31(const kq_filter_q31 *f);
int64_t kq_log_likelihood_q31(const kq_filter_q31 *f);

/** As the f32 functions. */
int kq_taken_q31(const kq_filter_q31 *f);
unsigned kq_events_q31(const kq_filter_q31 *f);
void kq_events_clear_q31(kq_filter_q31 *f);
KQ_NODISCARD kq_status kq_filter_check_q31(kq_filter_q31 *f);

#ifdef __cplusplus
}
#endif
#endif
