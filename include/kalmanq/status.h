/*
 * kalmanq: what a call answers, and what a filter remembers.
 *
 * An ERROR is a negative kq_status: the call was given something wrong and changed nothing, byte for byte (but for a
 * kq_range_error_q31, which says why).  A positive kq_status is not an error: the call is done, with a remark.  An
 * EVENT is not an error: numbers made the call do something unusual, with a sticky bit.
 */
#ifndef KALMANQ_STATUS_H
#define KALMANQ_STATUS_H

#include <limits.h> /* INT_MAX: makes every enumeration in an object an int, also with short enumerations */

/** Before a function whose status must be looked at: compilers that can warn if it is dropped. */
#if (defined(__cplusplus) && __cplusplus >= 201703L) || \
    (defined(__STDC_VERSION__) && __STDC_VERSION__ >= 202311L)
#define KQ_NODISCARD [[nodiscard]]
#elif defined(__GNUC__) || defined(__clang__)
#define KQ_NODISCARD __attribute__((warn_unused_result))
#else
#define KQ_NODISCARD
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    KQ_SATURATED = 2,         /**< q31: a result was saturated that no object keeps events for. */
    KQ_NOT_IDENTIFIED = 1,    /**< EM: the data do not determine all free parameters: hold H or Q. */
    KQ_OK = 0,
    KQ_ERR_NULL = -1,         /**< A pointer that the call needs is NULL. */
    KQ_ERR_SIZE = -2,         /**< A size is 0 or above KQ_SIZE_MAX; an index or a count is out of range. */
    KQ_ERR_MEMORY = -3,       /**< Your memory is shorter than the object's KQ_..._LEN. */
    KQ_ERR_NOT_FINITE = -4,   /**< A matrix, vector or measurement holds NaN or infinity.  Missing: kq_update_subset. */
    KQ_ERR_NOT_SYMMETRIC = -5,     /**< A covariance differs from its transpose by more than rounding. */
    KQ_ERR_NOT_SEMIDEFINITE = -6,  /**< A negative variance, or an eigenvalue negative beyond rounding: give a root. */
    KQ_ERR_NOT_READY = -7,         /**< Not initialised, init was refused, or a diffuse start still counts down. */
    KQ_ERR_MISMATCH = -8,          /**< Objects differ in states (q31: or formats), or one is given twice. */
    KQ_ERR_HISTORY_EMPTY = -9,     /**< The history has nothing to smooth, or is smoothed already. */
    KQ_ERR_HISTORY_FULL = -10,     /**< The history ran out of memory while recording: give it more steps. */
    KQ_ERR_RANGE = -11,            /**< A value is outside its range; q31: a range does not fit its format. */
    KQ_ERR_COEFFICIENT = -12,      /**< q31: a mantissa or exponent is outside its limits, or |A_ii| > 16: other units. */
    KQ_ERR_TABLE = -13,            /**< An object (kq_..._check) or a q31 table contradicts itself. */
    /** An attached object does not allow the call.  kq_attach: the object has another filter, or the filter
        has an object that is not replaced: detach it first.  (A history, a lag and an instant replace each
        other.) */
    KQ_ERR_RECORDING = -14,
    KQ_ERR_NOT_DETECTABLE = -15,   /**< No steady state: no sensor sees a state that does not decay. */
    KQ_ERR_NOT_STABILISABLE = -16, /**< No steady state: no noise moves a state that does not decay. */
    KQ_ERR_NO_CONVERGENCE = -17,   /**< An iteration did not converge within its bound: take f64, or an ordinary filter. */
    KQ_ERR_NO_DATA = -18,          /**< EM: every component of every recording is missing. */
    KQ_ERR_FEW_DATA = -19,         /**< EM: there are fewer measurements than free parameters: free fewer. */
    /** EM: the likelihood is 0, infinite or lower than before, or a parameter is not representable: begin elsewhere.
        Your arrays have the last good ones. */
    KQ_ERR_LIKELIHOOD = -20,
    KQ_ERR_FORM = -21,             /**< EM: a parameter does not begin in the form that it must keep. */
    KQ_ERR_CHANGED = -22,          /**< A process changed after a history recorded it: attach kq_jacobians. */
    KQ_ERR_ARITHMETIC = -23,       /**< The self test: this build computes wrongly: no -ffast-math (self_test.h). */
    KQ_STATUS_IS_INT = INT_MAX
} kq_status;

/** The status in words, for a log.
 *   status   any number
 * A static text, never NULL. */
const char *kq_status_text(kq_status status);

/** Sticky event bits: kq_events_<T> reads a filter's, kq_events_clear_<T> clears them.  Smoothing sets them in its
 * views (smoother.h). */
enum {
    /** A measurement was redundant and not taken: its innovation variance was rounding (kq_update).  The
        pseudo-inverse does the same. */
    KQ_EVENT_REDUNDANT = 1,
    /** Overflow.  An update: of an innovation or its variance; the measurement was not taken.  A predict: of
        a sigma or a mean, which was limited (kq_predict).  kq_forget: of a variance; nothing was forgotten.
        A jump loss: P was raised to its limit only. */
    KQ_EVENT_OVERFLOW = 2,
    /** The recording has ended: the history had no room, was assigned anew, or belongs to another copy of
        this filter; or a state overflowed. */
    KQ_EVENT_HISTORY_FULL = 4,
    /** q31: a state, filtered or smoothed, was saturated; or what led to it overflowed (fixed_point.h). */
    KQ_EVENT_SATURATED = 8,
    KQ_EVENT_GATED = 16,      /**< A gate rejected a measurement: the state stayed as predicted. */
    KQ_EVENT_REJECTIONS = 32, /**< A gate rejected `run` measurements in a row, and took the next: a fault or a jump. */
    KQ_EVENT_JUMP = 64,       /**< A jump loss raised P before the measurement was taken.  Often: Q is too small. */
    /** Precision lost: a sigma may be wrong by more than 5 %, or a mean by more than a hundredth of it.  Rounding
        hides what a low-noise measurement said or, over many updates, has become information (kq_predict); later
        measurements left next to nothing of a sigma (kq_smooth, kq_lagged, kq_instant_smooth); H x is rounded
        beside its innovation's sigma (f32, f64); or the ranges of q31 are the prior of a diffuse start (diffuse.h). */
    KQ_EVENT_PRECISION = 128,
    KQ_EVENT_LOW_NOISE = 256, /**< A lean sensor took a measurement in part: R is 0, or the rest was rounding (sensor.h). */
    /** Contradiction: a low-noise measurement is more than 2^12 (f32), 2^26.5 (f64) or 2^25 (q31) sigma from
        its prediction.  What it did to other states may be rounding.  Check sensor, prior, units. */
    KQ_EVENT_CONTRADICTION = 512
};

#ifdef __cplusplus
}
#endif
#endif
