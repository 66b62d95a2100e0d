/* Lengths of what one arithmetic alone has: floats, memory for matrices and EM; q31, the root that a table has. */
#ifndef KQ_SRC_LENGTHS_TWINS_H
#define KQ_SRC_LENGTHS_TWINS_H

#include "../arithmetic/arithmetic.h"

#if KQ_FLOATING

static kq_length length_of_own(kq_object object, int n, int m, size_t k)
{
    switch (object) {
    case KQ_OBJECT_PROCESS: return (kq_length)KQ_PROCESS_LEN(n);
    case KQ_OBJECT_SENSOR: return (kq_length)KQ_SENSOR_LEN(m);
    case KQ_OBJECT_STEADY_SOLVE: return (kq_length)STEADY_SOLVE_LEN(n, m);
    case KQ_OBJECT_CONTINUOUS: return k <= KQ_SIZE_MAX ? (kq_length)CONTINUOUS_LEN(n, k) : 0;
    case KQ_OBJECT_CORRELATED: return k + (size_t)m <= KQ_SIZE_MAX ? (kq_length)CORRELATED_LEN(n, k, m) : 0;
    case KQ_OBJECT_EM: return k <= KQ_COUNT_MAX ? (kq_length)EM_LEN(n, m, k) : 0;
    default: return 0;
    }
}

static size_t size_of_own(kq_object object) { return object == KQ_OBJECT_EM ? sizeof(T(kq_em)) : 0; }

#else

static kq_length length_of_own(kq_object object, int n, int m, size_t k)
{
    (void)m, (void)k;
    return object == KQ_OBJECT_ROOT ? (kq_length)KQ_ROOT_LEN_Q31(n) : 0;
}

static size_t size_of_own(kq_object object)
{
    (void)object;
    return 0;
}

#endif

#endif
