/* Sizes and lengths as functions. */
#ifndef KQ_SRC_LENGTHS_API_H
#define KQ_SRC_LENGTHS_API_H

#include <stddef.h>
#include <stdint.h>

#include "kalmanq/lengths.h"
#include "kalmanq/size.h"

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/size.h"
#include "lengths.h"

kq_length T(kq_filter_length)(int n)
{
    return size_is_valid(n) ? (kq_length)FILTER_LEN(n) : 0;
}

/* A step records no more measurements than 16 bits count (tape.h); so many, of as many steps as there may
   be, have a length that does not wrap. */
static int is_recordable(int m) { return m >= 1 && (uint32_t)m <= UINT16_MAX; }

kq_length T(kq_history_length)(int n, int m, size_t steps, size_t changes)
{
    if (!(size_is_valid(n) && is_recordable(m) && steps <= KQ_COUNT_MAX && changes <= KQ_COUNT_MAX)) return 0;
    return (kq_length)HISTORY_LEN(n, m, steps, changes);
}

kq_length T(kq_lag_length)(int n, int m, size_t L)
{
    if (!(size_is_valid(n) && m >= 1 && L <= KQ_COUNT_MAX)) return 0;
    return (kq_length)LAG_LEN(n, m, L);
}

kq_length T(kq_instant_length)(int n, int m)
{
    return size_is_valid(n) && m >= 1 ? (kq_length)INSTANT_LEN(n, m) : 0;
}

kq_length T(kq_start_length)(int n, size_t early)
{
    return size_is_valid(n) && early < UINT16_MAX ? (kq_length)START_LEN(n, early) : 0;
}

kq_length T(kq_adaptation_length)(int n, int m)
{
    return size_is_valid(n) && size_is_valid(m) ? (kq_length)ADAPTATION_LEN(n, m) : 0;
}

kq_length T(kq_consistency_length)(int m, size_t window)
{
    if (!(size_is_valid(m) && window >= 1 && window <= KQ_WINDOW_MAX)) return 0;
    return (kq_length)CONSISTENCY_LEN(m, window);
}

kq_length T(kq_steady_length)(int n)
{
    return size_is_valid(n) ? (kq_length)STEADY_LEN(n) : 0;
}

kq_length T(kq_steady_work_length)(int n, int m)
{
    return size_is_valid(n) && size_is_valid(m) ? (kq_length)STEADY_WORK_LEN(n, m) : 0;
}

kq_length T(kq_settling_length)(int n)
{
    return size_is_valid(n) ? (kq_length)SETTLING_LEN(n) : 0;
}

size_t T(kq_process_size)(void) { return sizeof(T(kq_process)); }

size_t T(kq_sensor_size)(void) { return sizeof(T(kq_sensor)); }

size_t T(kq_filter_size)(void) { return sizeof(T(kq_filter)); }

size_t T(kq_history_size)(void) { return sizeof(T(kq_history)); }

size_t T(kq_lag_size)(void) { return sizeof(T(kq_lag)); }

size_t T(kq_instant_size)(void) { return sizeof(T(kq_instant)); }

size_t T(kq_start_size)(void) { return sizeof(T(kq_start)); }

size_t T(kq_adaptation_size)(void) { return sizeof(T(kq_adaptation)); }

size_t T(kq_consistency_size)(void) { return sizeof(T(kq_consistency)); }

size_t T(kq_least_squares_size)(void) { return sizeof(T(kq_least_squares)); }

size_t T(kq_steady_size)(void) { return sizeof(T(kq_steady)); }

size_t T(kq_settling_size)(void) { return sizeof(T(kq_settling)); }

size_t T(kq_gate_size)(void) { return sizeof(T(kq_gate)); }

#endif
