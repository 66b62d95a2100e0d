/* Sizes and lengths as functions. */
#ifndef KQ_SRC_LENGTHS_LENGTHS_H
#define KQ_SRC_LENGTHS_LENGTHS_H

#include "twins.h"

/* Which arguments of kq_length are sizes of 1..16 */
enum { TAKES_N = 1, TAKES_M = 2 };

static int takes(kq_object object)
{
    switch (object) {
    case KQ_OBJECT_SENSOR:
    case KQ_OBJECT_CONSISTENCY: return TAKES_M;
    case KQ_OBJECT_ADAPTATION:
    case KQ_OBJECT_EM:
    case KQ_OBJECT_STEADY_SOLVE:
    case KQ_OBJECT_CORRELATED: return TAKES_N | TAKES_M;
    default: return TAKES_N;
    }
}

/* A step records no more measurements than 16 bits count (tape.h); so many, of as many steps as there may
   be, have a length that does not wrap. */
static int is_recordable(int m) { return m >= 1 && (uint32_t)m <= UINT16_MAX; }

kq_length T(kq_length)(kq_object object, int n, int m, size_t k, size_t l)
{
    const int sizes = takes(object), is_count = k <= KQ_COUNT_MAX && l <= KQ_COUNT_MAX;
    if ((sizes & TAKES_N && !size_is_valid(n)) || (sizes & TAKES_M && !size_is_valid(m))) return 0;
    switch (object) {
    case KQ_OBJECT_FILTER: return (kq_length)FILTER_LEN(n);
    case KQ_OBJECT_HISTORY: return is_count && is_recordable(m) ? (kq_length)HISTORY_LEN(n, m, k, l) : 0;
    case KQ_OBJECT_LAG: return is_count && m >= 1 ? (kq_length)LAG_LEN(n, m, k) : 0;
    case KQ_OBJECT_INSTANT: return m >= 1 ? (kq_length)INSTANT_LEN(n, m) : 0;
    case KQ_OBJECT_DIFFUSE: return k < UINT16_MAX ? (kq_length)DIFFUSE_LEN(n, k) : 0;
    case KQ_OBJECT_ADAPTATION: return (kq_length)ADAPTATION_LEN(n, m);
    case KQ_OBJECT_CONSISTENCY: return k >= 1 && k <= KQ_WINDOW_MAX ? (kq_length)CONSISTENCY_LEN(m, k) : 0;
    case KQ_OBJECT_STEADY: return (kq_length)STEADY_LEN(n);
    case KQ_OBJECT_FREEZE: return (kq_length)FREEZE_LEN(n);
    default: return length_of_own(object, n, m, k);
    }
}

size_t T(kq_object_size)(kq_object object)
{
    switch (object) {
    case KQ_OBJECT_PROCESS: return sizeof(T(kq_process));
    case KQ_OBJECT_SENSOR: return sizeof(T(kq_sensor));
    case KQ_OBJECT_FILTER: return sizeof(T(kq_filter));
    case KQ_OBJECT_HISTORY: return sizeof(T(kq_history));
    case KQ_OBJECT_LAG: return sizeof(T(kq_lag));
    case KQ_OBJECT_INSTANT: return sizeof(T(kq_instant));
    case KQ_OBJECT_DIFFUSE: return sizeof(T(kq_diffuse));
    case KQ_OBJECT_ADAPTATION: return sizeof(T(kq_adaptation));
    case KQ_OBJECT_CONSISTENCY: return sizeof(T(kq_consistency));
    case KQ_OBJECT_LEAST_SQUARES: return sizeof(T(kq_least_squares));
    case KQ_OBJECT_STEADY: return sizeof(T(kq_steady));
    case KQ_OBJECT_FREEZE: return sizeof(T(kq_freeze));
    case KQ_OBJECT_LOSS: return sizeof(T(kq_loss));
    default: return size_of_own(object);
    }
}

#endif
