/*
 * kalmanq: the parameters of a model from recorded measurements, by EM; the likelihood and its
 * gradient.  f32 and f64.
 *
 *     x[t+1] = A x[t] + B u[t] + F q[t],  q ~ N(0, Q)       z[t] = H x[t] + v[t],  v ~ N(0, R)
 *     x[0] ~ N(x0, P0), before the first measurement;  F is I where none is given
 *
 * One iteration takes (A, H, Q, R, x0, P0), or those of them that are free, to values under which
 * the recordings are at least as likely.  The E-step runs filter and smoother over every
 * recording; the M-step makes new parameters of the smoothed noises:
 *
 *     Q  = mean of E[q q' | all]            A + sum E[w x'] (sum E[x x'])^-1,  w = F q
 *     R  = mean of E[v v' | all]            H + sum E[v x'] (sum E[x x'])^-1
 *     x0 = mean of E[x[0] | all]            P0 = mean of E[(x[0] - x0)(x[0] - x0)' | all]
 *
 * These are the results; the arithmetic carries the triangular root of
 * sum E[(noise; x)(noise; x)'], noises in units of their own roots: nothing is subtracted, A and H
 * move by increments, and every covariance is a sum of squares, positive semi-definite whatever
 * the rounding.
 *
 * H and R are means over the steps that have a measurement; within such a step, a component that is
 * missing counts with what is expected of it: its noise is the current R, given the noises of the
 * components that are there.  (A step without any could count with the current R, too, as Shumway
 * and Stoffer have it.  Both ways the likelihood never falls, and both stop at the same parameters;
 * but R and H then move by the share of the measured steps only: where 3 of 10 steps are empty the
 * iterations to a given distance are 1.4 times as many, where 6 of 10 are, 2.4 times and more:
 * tests/em/test_em.py.)
 *
 *     static kq_parameters_f32 model = {0, 0, A, NULL, NULL, Q, H, R, x0, P0};
 *     static const kq_recording_f32 night = {STEPS, z, NULL, NULL};
 *     KQ_EM_F32(em, 2, 1, STEPS);
 *     kq_em_init_f32(&em, &model, NULL, &night, 1);
 *     for (int k = 0; k < 1000 && !status; k++) {
 *         status = kq_em_iterate_f32(&em);
 *         if (kq_em_is_settled_f32(&em, 1e-2f) && kq_em_distance_f32(&em) <= 0.02f) break;
 *     }
 *
 * In slices, over idle time: kq_em_advance does one step of the filter or of the smoother a call,
 * until kq_em_remaining is 0; then kq_em_maximise.
 *
 * What to expect of it.  EM converges linearly, and slowly where a noise is hard to see: a small
 * change in an iteration is not yet a small distance from the maximum (kq_em_distance).  Where the
 * maximum is at a variance of 0 it is never reached: the variance falls as 1 / k in k iterations.
 * Where there are few measurements for a full R there may be no maximum: R becomes singular, and
 * the likelihood rises beyond all limits; that ends with KQ_ERR_LIKELIHOOD and with the last
 * parameters that the arithmetic tells apart from worse ones.  A covariance that is 0
 * stays 0, and so does a direction without noise: Q and the A that it could explain do not leave
 * the space that F and the first Q span.  Not everything is determined by data (KQ_NOT_IDENTIFIED):
 * H and Q only as H^2 Q, A as a whole only where enough of the state is measured.
 *
 * q31: estimate in f32 or f64, and prepare tables of the result (prepare.h).
 *
 * Sources: Shumway and Stoffer, An approach to time series smoothing and forecasting using the EM
 * algorithm, J. Time Series Anal. 3 (1982); Koopman, Disturbance smoother for state space models,
 * Biometrika 80 (1993), for the noises; Meng and Rubin, Maximum likelihood estimation via the ECM
 * algorithm, Biometrika 80 (1993), for held entries; Fisher's identity: Segal and Weinstein, A new
 * method for evaluating the log-likelihood gradient, the Hessian, and the Fisher information
 * matrix, IEEE Trans. Information Theory 35 (1989).
 */
#ifndef KALMANQ_EM_H
#define KALMANQ_EM_H

#include "smoother.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------ what is estimated, of what */

/** The model, in the caller's arrays: where the estimate begins, and where it is written.  All are
    dense and row-major. */
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
    int32_t controls;
    int32_t noises;
    double *A;
    const double *B;
    const double *F;
    double *Q;
    double *H;
    double *R;
    double *x0;
    double *P0;
} kq_parameters_f64;

/** One recorded sequence. */
typedef struct {
    size_t steps;            /* T: 1 .. KQ_COUNT_MAX */
    const float *z;          /* T x m; what is not present is not read */
    const uint16_t *present; /* T masks, bit c: component c was measured; NULL: all were */
    const float *u;          /* T - 1 rows of l: u[t] moves x[t] to x[t+1]; NULL: no control */
} kq_recording_f32;

typedef struct {
    size_t steps;
    const double *z;
    const uint16_t *present;
    const double *u;
} kq_recording_f64;

/** What may be free: one of these, or their sum. */
enum {
    KQ_EM_A = 1,
    KQ_EM_H = 2,
    KQ_EM_Q = 4,
    KQ_EM_R = 8,
    KQ_EM_X0 = 16,
    KQ_EM_P0 = 32,
    KQ_EM_ALL = 63
};

/** The form of Q or R: any, DIAGONAL, or a MULTIPLE of what it was at first, but for rounding. */
typedef enum { KQ_EM_FULL, KQ_EM_DIAGONAL, KQ_EM_MULTIPLE, KQ_EM_IS_INT = INT_MAX } kq_em_form;

/** Which parameters are free, and what is known of them. */
typedef struct {
    unsigned free; /* KQ_EM_... */
    kq_em_form Q_form;
    kq_em_form R_form;
    const uint8_t *A_held; /* n x n, not 0: the entry stays as it is; NULL: none is held */
    const uint8_t *H_held; /* m x n */
} kq_em_choice;

/* ------------------------------------------------------------------ the object */

/* The parts of the memory: the work of one step (k = n + max(n, m) rows), the roots of sums, the
   parameters that the caller's arrays do not hold: the new ones, then the last ones */
#define KQ_PRIVATE_EM_ROWS(n, m) ((size_t)(n) + ((n) > (m) ? (size_t)(n) : (size_t)(m)))
#define KQ_PRIVATE_EM_WORK_LEN(n, m)                                                               \
    (KQ_PRIVATE_EM_ROWS(n, m) * (KQ_PRIVATE_EM_ROWS(n, m) + 3) + KQ_TRIANGLE(KQ_PRIVATE_EM_ROWS(n, m)) + \
     (size_t)(m) * (size_t)(m))
#define KQ_PRIVATE_EM_SUMS_LEN(n, m)                                                               \
    (2 * (KQ_TRIANGLE(2 * (size_t)(n)) + KQ_TRIANGLE((size_t)(n) + (size_t)(m))) +                 \
     KQ_TRIANGLE((size_t)(n) + 1))
#define KQ_PRIVATE_EM_NEW_LEN(n, m)                                                                \
    (((size_t)(n)*3 + (size_t)(m) + 1) * (size_t)(n) + (size_t)(m) * (size_t)(m))
#define KQ_PRIVATE_EM_ROOTS_LEN(n, m)                                                              \
    (3 * KQ_TRIANGLE((size_t)(n)) + 2 * KQ_TRIANGLE((size_t)(m)) + (size_t)(n) * (size_t)(n))

/**
 * Words of memory for n states, m components and recordings of at most `steps` steps: the history
 * of the longest recording, and about 15 n^2 + 7 m n + 5 m^2 words.  f32, n = 2, m = 1, T = 200:
 * 9368 bytes.
 */
#define KQ_EM_LEN_F32(n, m, steps)                                                                 \
    (KQ_HISTORY_LEN_F32(n, m, steps, 0) + KQ_FILTER_LEN_F32((size_t)(n)) + KQ_PRIVATE_EM_WORK_LEN(n, m) + \
     KQ_PRIVATE_EM_SUMS_LEN(n, m) + KQ_PRIVATE_EM_NEW_LEN(n, m) + KQ_PRIVATE_EM_ROOTS_LEN(n, m))
#define KQ_EM_LEN_F64(n, m, steps)                                                                 \
    (KQ_HISTORY_LEN_F64(n, m, steps, 0) + KQ_FILTER_LEN_F64((size_t)(n)) + KQ_PRIVATE_EM_WORK_LEN(n, m) + \
     KQ_PRIVATE_EM_SUMS_LEN(n, m) + KQ_PRIVATE_EM_NEW_LEN(n, m) + KQ_PRIVATE_EM_ROOTS_LEN(n, m))

/* The fields are the library's (see process.h). */
typedef struct {
    uint8_t states;     /* n */
    uint8_t components; /* m */
    uint8_t phase;      /* unused, ready, in the E-step's filter or smoother, at its end */
    uint8_t kept;       /* KQ_EM_...: of those the memory has what they were before the M-step */
    size_t length;      /* words at memory */
    float *memory;      /* the caller's */
    const kq_parameters_f32 *model;     /* the caller's */
    const kq_em_choice *choice;         /* the caller's, or NULL */
    const kq_recording_f32 *recordings; /* the caller's */
    size_t count;                       /* of recordings */
    size_t recording;                   /* the one at work */
    size_t step;                        /* of it, the one to be done next */
    uint32_t remaining;                 /* steps to the end of the E-step */
    float log_likelihood;
    float before; /* the log-likelihood of the parameters before the M-step */
    float gain;   /* of the M-step, in log-likelihood */
    float change; /* of the last M-step, NaN: there was none */
    float rate;   /* of the change, from M-step to M-step */
    kq_process_f32 process;
    kq_sensor_f32 sensor;
    kq_filter_f32 filter;
    kq_history_f32 history;
} kq_em_f32;

typedef struct {
    uint8_t states;
    uint8_t components;
    uint8_t phase;
    uint8_t kept;
    size_t length;
    double *memory;
    const kq_parameters_f64 *model;
    const kq_em_choice *choice;
    const kq_recording_f64 *recordings;
    size_t count;
    size_t recording;
    size_t step;
    uint32_t remaining;
    double log_likelihood;
    double before;
    double gain;
    double change;
    double rate;
    kq_process_f64 process;
    kq_sensor_f64 sensor;
    kq_filter_f64 filter;
    kq_history_f64 history;
} kq_em_f64;

/* What is behind the memory, before init: nothing yet */
#define KQ_PRIVATE_EM_OBJECT(n, m, length, memory)                                                 \
    {                                                                                              \
        n, m, 0, 0, length, memory, NULL, NULL, NULL, 0, 0, 0, 0, 0, 0, 0, 0, 0,                   \
            {0, 0, 0, NULL, NULL, NULL, NULL, {0}, 0, 0, 0},                                       \
            {0, 0, 0, 0, NULL, NULL, NULL, NULL, {0}, 0, 0, 0, NULL},                              \
            {0, 0, 0, 0, 0, 0, NULL, NULL, 0, {0, 0, 0, 0}, {{0, 0, 0}, 0, 0, 0}},                 \
        {                                                                                          \
            {NULL}, 0, 0, 0, 0, 0, 0, 0, 0, NULL, NULL, NULL, 0                                    \
        }                                                                                          \
    }

/** An object `name` with its storage, in static memory, to be initialised. */
#define KQ_EM_F32(name, n, m, steps)                                                               \
    static float name##_memory[KQ_EM_LEN_F32(n, m, steps)];                                        \
    static kq_em_f32 name = KQ_PRIVATE_EM_OBJECT(n, m, KQ_EM_LEN_F32(n, m, steps), name##_memory)
#define KQ_EM_F64(name, n, m, steps)                                                               \
    static double name##_memory[KQ_EM_LEN_F64(n, m, steps)];                                       \
    static kq_em_f64 name = KQ_PRIVATE_EM_OBJECT(n, m, KQ_EM_LEN_F64(n, m, steps), name##_memory)

/**
 * Sizes and memory known at run time only (the macros do the same at compile time).
 *   em       written
 *   n, m     1..16
 *   length   words at memory: KQ_EM_LEN_<T>(n, m, steps)
 *
 * KQ_ERR_NULL, KQ_ERR_SIZE, KQ_ERR_MEMORY (not even for one step).
 */
KQ_NODISCARD kq_status kq_em_assign_f32(kq_em_f32 *em, int n, int m, float *memory, size_t length);
KQ_NODISCARD kq_status kq_em_assign_f64(kq_em_f64 *em, int n, int m, double *memory, size_t length);

/**
 * Checks model and recordings.  Nothing is computed yet.
 *   model       kept by reference; its arrays are written by kq_em_maximise, and by kq_em_advance
 *               where it takes back what that has written
 *   choice      kept by reference; NULL: Q and R are free, both of full form
 *   recordings  `count` of them, kept by reference: they and their arrays have to stay as they are
 *   count       1 .. KQ_COUNT_MAX
 *
 * KQ_NOT_IDENTIFIED (not an error: all is ready): H and Q are both free and no entry of H that is
 * not 0 is held, so that the data determine them up to a factor.
 *
 * KQ_ERR_NULL, KQ_ERR_SIZE (noises, controls, steps, count, choice), KQ_ERR_MEMORY (a recording has
 * more steps than there is memory for), KQ_ERR_NOT_FINITE (parameters, or z or u, present),
 * KQ_ERR_NOT_SYMMETRIC, KQ_ERR_NOT_SEMIDEFINITE (Q, R, P0),
 * KQ_ERR_NO_DATA (every component of every step is missing), KQ_ERR_FEW_DATA (fewer
 * scalar measurements than free parameters), KQ_ERR_FORM (Q or R is not of its form; a multiple
 * of 0; the columns of F are not independent).
 */
KQ_NODISCARD kq_status kq_em_init_f32(kq_em_f32 *em, const kq_parameters_f32 *model, const kq_em_choice *choice,
                         const kq_recording_f32 *recordings, size_t count);
KQ_NODISCARD kq_status kq_em_init_f64(kq_em_f64 *em, const kq_parameters_f64 *model, const kq_em_choice *choice,
                         const kq_recording_f64 *recordings, size_t count);

/* ------------------------------------------------------------------ iterations */

/**
 * One iteration: the whole E-step, and the M-step.
 * Cost: for every step of every recording a predict, an update and a step of the smoother, and
 * about 4 n^3 multiplications, 12 n^3 where A is free, 3 n^3 more where H is.  Stack: 430 words.
 * Accuracy: of parameters after 50 iterations 2e-14 (f64), 7e-6 (f32) of their size, with 20,000
 * steps 1e-6 in f32 (tests/em/test_em.py).
 *
 * The errors of kq_em_advance and kq_em_maximise.
 */
KQ_NODISCARD kq_status kq_em_iterate_f32(kq_em_f32 *em);
KQ_NODISCARD kq_status kq_em_iterate_f64(kq_em_f64 *em);

/**
 * One slice of the E-step: one step of the filter, or one of the smoother, of one recording.  The
 * first call after init, kq_em_maximise or the end of an E-step begins a new one, with the model
 * as it then is: it prepares process and sensor (process.h, sensor.h), too.
 *
 * KQ_ERR_NULL, KQ_ERR_NOT_READY, and those of kq_em_init about the model, which the caller may have
 * changed.
 *
 * KQ_ERR_LIKELIHOOD: the E-step is given up, for one of two reasons.  The likelihood is infinite or
 * zero: the model takes a measurement for free of noise and error, or is not representable.  Or it
 * is lower than before kq_em_maximise, by more than rounding: 64 eps (measurements + |L|), where
 * 1.2 eps (...) is what rounding does; eps is 1.2e-7 in f32, 2.2e-16 in f64.  EM does not do that
 * but where rounding rules: a covariance is as good as singular.  In both cases the parameters that
 * kq_em_maximise has replaced are put back, and kq_em_log_likelihood is theirs: they are the best
 * that were found, and to go on from them leads here again.  A model that the caller has changed
 * since kq_em_maximise is judged in the same way: kq_em_init begins anew.
 */
KQ_NODISCARD kq_status kq_em_advance_f32(kq_em_f32 *em);
KQ_NODISCARD kq_status kq_em_advance_f64(kq_em_f64 *em);

/** Calls of kq_em_advance until the E-step is complete; 0 when it is, or has not begun.  (32 bits: two a
    step of every recording, together more than a size_t of 16 bits holds.) */
uint32_t kq_em_remaining_f32(const kq_em_f32 *em);
uint32_t kq_em_remaining_f64(const kq_em_f64 *em);

/**
 * log p(all recordings) of the parameters that the last complete E-step was run with, those before
 * the last kq_em_maximise, or those that were put back.  NaN where there was none, and while one is
 * under way.
 */
float kq_em_log_likelihood_f32(const kq_em_f32 *em);
double kq_em_log_likelihood_f64(const kq_em_f64 *em);

/**
 * The M-step: the free parameters, written to the caller's arrays.
 * Where x does not move in some direction, what A and H make of it is not determined: a component
 * of x that is always 0 leaves its columns as they are, a combination of components that is 0
 * leaves them what fits the others.  Held entries of A (H): the free ones of each row are the best
 * for the other rows as they are, last row first; the likelihood rises all the same.  A row of A
 * that Q moves only together with other rows stays as it is then.
 *
 * KQ_ERR_NULL, KQ_ERR_NOT_READY (the E-step is not complete).
 * KQ_ERR_LIKELIHOOD: a new parameter would be not representable; a new covariance would not be one
 * to rounding; or the new R would be singular in a direction in which it is not so far: what was
 * measured is explained without noise there.  The model is as it was, and so is all that can be
 * read of the object (scratch in its memory is not).
 */
KQ_NODISCARD kq_status kq_em_maximise_f32(kq_em_f32 *em);
KQ_NODISCARD kq_status kq_em_maximise_f64(kq_em_f64 *em);

/**
 * The largest change of the last M-step: of an entry of a covariance, in sigma_i sigma_j; of A, H
 * and x0 the root mean square of what they move, in standard deviations of the noise.  NaN before
 * the first M-step.
 */
float kq_em_change_f32(const kq_em_f32 *em);
double kq_em_change_f64(const kq_em_f64 *em);

/**
 * How far kq_em_log_likelihood is below the maximum that the iterations go to, extrapolated from
 * the last gain of log-likelihood and the last two changes: gain rate^2 / (1 - rate), rate = change
 * / change before.  That is what is left where a variance goes to 0, and once to twice what is left
 * where EM converges linearly.  A gain that rounding hides counts as what it can hide,
 * eps (measurements + |L|), and 16 eps are added to the last change: where f32 no longer sees how
 * slow it is, it does not say that it is near.
 *
 * A difference of 0.1 is of no interest to statistics: two standard deviations of a parameter are a
 * difference of 2.  An extrapolation sees no further than the last iterations: on a plateau, and in
 * the first iterations, it may be small.  Ask for a small change as well (the loop above).
 *
 * NaN where it is not known: before the third E-step, while one is under way, after one that was
 * given up, and where the changes do not become smaller.
 */
float kq_em_distance_f32(const kq_em_f32 *em);
double kq_em_distance_f64(const kq_em_f64 *em);

/**
 * Was the last change at most `tolerance`?  Less than 1e-6 is rounding in f32.  0 before the first
 * M-step.  By itself this is a weak stop rule: at a change of 1e-4, 1e-6 to 2e-2 of log-likelihood
 * are left, and where a variance goes to 0 it takes 10,000 iterations and more to come there.
 */

/* ------------------------------------------------------------------ gradient */

/**
 * The derivatives of the log-likelihood; each pointer may be NULL.  Entries of a covariance are
 * taken for independent: the derivative along a symmetric change E of Q is sum_ij Q_ij E_ij.
 */
typedef struct {
    float *A;  /* n x n; needs a free A */
    float *H;  /* m x n; needs a free H */
    float *Q;  /* r x r */
    float *R;  /* m x m */
    float *x0; /* n; needs a free x0 */
    float *P0; /* n x n */
} kq_gradient_f32;

typedef struct {
    double *A;
    double *H;
    double *Q;
    double *R;
    double *x0;
    double *P0;
} kq_gradient_f64;

/**
 * The gradient at the end of an E-step, before kq_em_maximise, by Fisher's identity, from the
 * same sums:  dL/dA = Q^-1 sum E[w x'],  dL/dQ = (Q^-1 (sum E[w w'] - N Q) Q^-1) / 2,  and so on.
 * Forms and held entries play no part.  Where a covariance is singular the identity says nothing of
 * the directions without noise: those entries are NaN.
 * Accuracy: 3e-14 (f64), 8e-6 (f32) of its size (tests/em/test_em.py); the smoothed noises of a
 * covariance that the data hardly see are nearly the noise itself, and the difference loses that
 * many digits.
 *
 * KQ_ERR_NULL, KQ_ERR_NOT_READY (the E-step is not complete, or a parameter that has to be free is
 * not).
 */
KQ_NODISCARD kq_status kq_em_gradient_f32(const kq_em_f32 *em, const kq_gradient_f32 *gradient);
KQ_NODISCARD kq_status kq_em_gradient_f64(const kq_em_f64 *em, const kq_gradient_f64 *gradient);

#ifdef __cplusplus
}
#endif
#endif
