/* The statuses in words. */
#ifndef KQ_SRC_MESSAGES_STATUS_H
#define KQ_SRC_MESSAGES_STATUS_H

#include "kalmanq/status.h"

const char *kq_status_text(kq_status status)
{
    switch (status) {
    case KQ_SATURATED: return "done, but a result saturated";
    case KQ_NOT_IDENTIFIED: return "done, but data do not determine all free parameters";
    case KQ_OK: return "done";
    case KQ_ERR_NULL: return "a pointer that the call needs is NULL";
    case KQ_ERR_SIZE: return "a size, index or step count is out of range";
    case KQ_ERR_MEMORY: return "the caller's memory is too short for these sizes, or for a correlated R";
    case KQ_ERR_NOT_FINITE: return "a number is NaN or infinite";
    case KQ_ERR_NOT_SYMMETRIC: return "a covariance is not symmetric";
    case KQ_ERR_NOT_SEMIDEFINITE: return "a covariance is not positive semi-definite";
    case KQ_ERR_NOT_READY: return "an object is not initialised, or its init was refused";
    case KQ_ERR_MISMATCH: return "the objects do not fit together, or one is given twice";
    case KQ_ERR_HISTORY_EMPTY:
        return "the history holds nothing to smooth, or has been smoothed already";
    case KQ_ERR_HISTORY_FULL: return "the history ran out of memory";
    case KQ_ERR_RANGE: return "a value is out of its range, or a range does not fit its Q format";
    case KQ_ERR_COEFFICIENT: return "a coefficient is beyond its limit, or a mantissa is not 2^30 to 2^31";
    case KQ_ERR_TABLE: return "a table contradicts itself";
    case KQ_ERR_RECORDING: return "the history cannot record this, or something else is attached";
    case KQ_ERR_NOT_DETECTABLE: return "no steady state: a lasting state is not measured";
    case KQ_ERR_NOT_STABILISABLE: return "no steady state: a lasting state has no noise";
    case KQ_ERR_NO_CONVERGENCE: return "an iteration did not settle";
    case KQ_ERR_NO_DATA: return "every measurement is missing";
    case KQ_ERR_FEW_DATA: return "there are fewer measurements than free parameters";
    case KQ_ERR_LIKELIHOOD: return "the likelihood is infinite or zero, or it falls";
    case KQ_ERR_CHANGED: return "a process has changed since the history recorded it";
    case KQ_ERR_FORM: return "a parameter is not of the form that it is to keep";
    case KQ_ERR_ARITHMETIC: return "this build does not compute as it should";
    case KQ_STATUS_IS_INT: break;
    }
    return "unknown status";
}

#endif
