/* Lengths of what floating point alone has memory for */
#ifndef KQ_SRC_LENGTHS_LENGTHS_FLOAT_H
#define KQ_SRC_LENGTHS_LENGTHS_FLOAT_H

#include <stddef.h>

#include "kalmanq/lengths.h"
#include "kalmanq/size.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/size.h"

kq_length T(kq_process_length)(int n)
{
    return size_is_valid(n) ? (kq_length)KQ_PROCESS_LEN(n) : 0;
}

kq_length T(kq_sensor_length)(int m)
{
    return size_is_valid(m) ? (kq_length)KQ_SENSOR_LEN(m) : 0;
}

kq_length T(kq_steady_solve_length)(int n, int m)
{
    return size_is_valid(n) && size_is_valid(m) ? (kq_length)STEADY_SOLVE_LEN(n, m) : 0;
}

kq_length T(kq_em_length)(int n, int m, size_t steps)
{
    if (!(size_is_valid(n) && size_is_valid(m) && steps <= KQ_COUNT_MAX)) return 0;
    return (kq_length)EM_LEN(n, m, steps);
}

size_t T(kq_em_size)(void) { return sizeof(T(kq_em)); }

#endif
