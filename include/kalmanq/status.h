/*
 * kalmanq: what a call answers, and what a filter remembers.
 *
 * A call that is given something wrong is REFUSED: it returns a negative kq_status, and every
 * object and every output array is byte for byte what it was (but for a kq_range_error_q31, which says
 * why).  A positive kq_status is not an error: the call is done, and there is something to know of
 * it.  A numeric EVENT is not an error: the call does what is best, and a sticky bit in the filter
 * says that it happened.
 */
#ifndef KALMANQ_STATUS_H
#define KALMANQ_STATUS_H

#include <limits.h> /* INT_MAX: every enumeration that lies in an object is an int with it, whatever a
                       compiler's flags say of short ones (KQ_..._IS_INT) */

/** Before a function whose status must be looked at: a compiler that can warns of one that is dropped. */
#if (defined(__cplusplus) && __cplusplus >= 201703L) || (defined(__STDC_VERSION__) && __STDC_VERSION__ >= 202311L)
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
    /** q31: a result that no object keeps events for was held at the end of its word. */
    KQ_SATURATED = 2,
    /** EM: the free parameters are not all determined by data. */
    KQ_NOT_IDENTIFIED = 1,
    KQ_OK = 0,
    /** A pointer that the call needs is NULL. */
    KQ_ERR_NULL = -1,
    /** A size is 0 or above KQ_SIZE_MAX, an index or a step count is out of its range. */
    KQ_ERR_SIZE = -2,
    /** The caller's memory is shorter than the object's length constant asks for. */
    KQ_ERR_MEMORY = -3,
    /** A matrix, a vector or a measurement holds a NaN or an infinity. */
    KQ_ERR_NOT_FINITE = -4,
    /** A covariance differs from its transpose by more than rounding. */
    KQ_ERR_NOT_SYMMETRIC = -5,
    /** A covariance has a negative eigenvalue beyond rounding (or a negative variance). */
    KQ_ERR_NOT_SEMIDEFINITE = -6,
    /** The object was never initialised, or its initialisation was refused. */
    KQ_ERR_NOT_READY = -7,
    /** Two objects of one call have different numbers of states, q31: different formats of the
        states, or one is given twice. */
    KQ_ERR_MISMATCH = -8,
    /** The history holds nothing to smooth, or has been smoothed already. */
    KQ_ERR_HISTORY_EMPTY = -9,
    /** The history ran out of memory while it was recording. */
    KQ_ERR_HISTORY_FULL = -10,
    /** A value is outside its range (q31: its declared one), or a range does not fit its format. */
    KQ_ERR_RANGE = -11,
    /** q31: a coefficient has no mantissa and exponent within their limits, or |A_ii| > 16. */
    KQ_ERR_COEFFICIENT = -12,
    /** An object (kq_..._check) or a q31 table contradicts itself, as a corrupted one does. */
    KQ_ERR_TABLE = -13,
    /** A history, a lag or an instant is attached to the filter, and what is asked for cannot be recorded on
        it; or what is to be attached has another filter; or something is attached already, and that or what
        is to be attached is an adaptation or a freeze: detach it first.  (A history, a lag and an instant take
        each other's place.) */
    KQ_ERR_RECORDING = -14,
    /** No steady state: a state that does not decay by itself is not seen by the sensor. */
    KQ_ERR_NOT_DETECTABLE = -15,
    /** No steady state: a state that does not decay by itself is not moved by the noise. */
    KQ_ERR_NOT_STABILISABLE = -16,
    /** An iteration did not settle within its bound. */
    KQ_ERR_NO_CONVERGENCE = -17,
    /** EM: every component of every recording is missing. */
    KQ_ERR_NO_DATA = -18,
    /** EM: there are fewer measurements than free parameters. */
    KQ_ERR_FEW_DATA = -19,
    /** EM: the likelihood of the parameters is infinite or zero, or they are not representable, or
        it is lower than that of the last ones. */
    KQ_ERR_LIKELIHOOD = -20,
    /** EM: a parameter is not of the form that it is to keep. */
    KQ_ERR_FORM = -21,
    /** A process that a history refers to is not what it was when the history recorded it. */
    KQ_ERR_CHANGED = -22,
    /** The self test: this build does not compute as it should (self_test.h). */
    KQ_ERR_ARITHMETIC = -23,
    KQ_STATUS_IS_INT = INT_MAX
} kq_status;

/** The status in words, for a log: never NULL, static storage. */
const char *kq_status_text(kq_status status);

/** Sticky event bits of a filter: read by kq_events_<T>, cleared by kq_events_clear_<T>.  Those of
    smoothing are in its views (smoother.h). */
enum {
    /** A measurement was expected to carry no information beyond rounding (its innovation
        variance was at the rounding floor): it was not taken.  This is what the
        pseudo-inverse does with a redundant noise-free sensor. */
    KQ_EVENT_REDUNDANT = 1,
    /** An innovation or its variance left the number range: the measurement was not taken.  Or predict
        held a state that grew without end (filter.h); or a variance that was to fade would have left
        the range: nothing faded (least_squares.h); or P was to be raised beyond its limit: it was
        raised so far (robust.h, jump). */
    KQ_EVENT_OVERFLOW = 2,
    /** The attached history had no room for a record, or was assigned anew meanwhile, or this filter
        is an assigned copy of the one it belongs to, or predict had to hold a state: the recording has
        ended. */
    KQ_EVENT_HISTORY_FULL = 4,
    /** q31: a state that a call has left, or has smoothed, was held at the end of its word; or what
        led to it was beyond all bounds (fixed_point.h). */
    KQ_EVENT_SATURATED = 8,
    /** A gate rejected a measurement: the state was left as it was predicted. */
    KQ_EVENT_GATED = 16,
    /** A gate rejected as many measurements in a row as it bears: the next one was taken. */
    KQ_EVENT_REJECTIONS = 32,
    /** A measurement was taken for a jump of the state: P was raised before it was taken. */
    KQ_EVENT_JUMP = 64,
    /** Precision lost: a sigma may be wrong by more than 5 %.  What a low-noise measurement said is within the
        rounding of P after a predict, or the rounding of many updates has become information (filter.h,
        kq_predict), or very many said less than its last bits (kq_update). */
    KQ_EVENT_PRECISION = 128,
    /** A lean sensor took a low-noise measurement coarsely: its noise was raised (kq_sensor_init_lean_<T>). */
    KQ_EVENT_LOW_NOISE = 256,
    /** Contradiction: a low-noise measurement is more than 2^12 (f32), 2^26.5 (f64) or 2^25 (q31) sigma
        from its prediction.  What it makes of other states may be rounding. */
    KQ_EVENT_CONTRADICTION = 512
};

#ifdef __cplusplus
}
#endif
#endif
