/*
 * A user's own functions.  With KQ_COST_FIXED those for one size, USER_N, USER_M, OPTIONS: the one
 * place that knows how the library is specialised.  Without it those for one sample.
 */
#include "program.h"

#ifdef KQ_COST_FIXED

#if defined(KQ_COST_f32)
#include "fixed_size/kq_fixed_f32.h"
#elif defined(KQ_COST_f64)
#include "fixed_size/kq_fixed_f64.h"
#elif defined(KQ_COST_q31)
#include "fixed_size/kq_fixed_q31.h"
#endif

/* not before: the library's headers have an M of their own */
#define N USER_N
#define M USER_M
#include "user.h"

#ifdef KQ_COST_MODULES

kq_status SIZED(user_steady_step)(T(kq_steady) * st, const word *u, const word *z)
{
    return T(kq_fixed_steady_step)(st, u, z, N, M, 0, OPTIONS);
}

#else

kq_status SIZED(user_predict)(T(kq_filter) * f, const T(kq_process) * p, const word *u)
{
    return T(kq_fixed_predict)(f, p, u, N, 0, OPTIONS);
}

kq_status SIZED(user_update)(T(kq_filter) * f, const T(kq_sensor) * s, const word *z)
{
    return T(kq_fixed_update)(f, s, z, N, M, OPTIONS);
}

kq_status SIZED(user_step)(T(kq_filter) * f, const T(kq_process) * p, const word *u,
                           const T(kq_sensor) * s, const word *z)
{
    return T(kq_fixed_step)(f, p, u, s, z, N, M, 0, OPTIONS);
}

kq_status SIZED(user_smooth_step)(T(kq_history) * h, const T(kq_process) * p,
                                  const T(kq_smooth_extras) * extras)
{
#if SMOOTHS
    return T(kq_fixed_smooth_step)(h, p, extras, N, OPTIONS);
#else /* and is not in the table */
    return T(kq_smooth_step)(h, p, extras);
#endif
}

#endif

#else

#include "user.h"

/* A sample: predict, update, and then what is past anew, LAG steps back or the chosen instant. */
#define SAMPLE(name, object, answer)                                                               \
    kq_status T(user_##name)(T(object) * past, const T(kq_process) * p, T(kq_filter) * f,          \
                             const T(kq_sensor) * s, const word *z)                                \
    {                                                                                              \
        T(kq_filter) view;                                                                         \
        kq_status status = T(kq_predict)(f, p, NULL);                                              \
        if (!status) status = T(kq_update)(f, s, z);                                               \
        return status ? status : answer;                                                           \
    }

SAMPLE(lag, kq_lag, T(kq_lagged)(past, LAG, &view))
SAMPLE(lag_states, kq_lag, T(kq_lagged_states)(past, LAG, &view))
SAMPLE(point, kq_instant, T(kq_instant_smooth)(past, &view))

/* With scales of the noises that adapt: predict and update. */
kq_status T(user_adapted)(T(kq_filter) * f, const T(kq_process) * p, const T(kq_sensor) * s,
                          const word *z)
{
    const kq_status status = T(kq_predict)(f, p, NULL);
    return status ? status : T(kq_update)(f, s, z);
}

#endif
