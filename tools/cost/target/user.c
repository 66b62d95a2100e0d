/*
 * A user's file with functions for one size: USER_N, USER_M, OPTIONS.  The one place that knows how
 * the library is specialised.
 */
#include "library.h"

#if defined(KQ_COST_f32)
#include "known_sizes/kq_fixed_f32.h"
#elif defined(KQ_COST_f64)
#include "known_sizes/kq_fixed_f64.h"
#elif defined(KQ_COST_q31)
#include "known_sizes/kq_fixed_q31.h"
#endif

/* not before: the library's headers have an M of their own */
#define N USER_N
#define M USER_M
#include "user.h"

#ifdef STEADY_ONLY

kq_status SIZED(user_steady_step)(TYPED(kq_steady) * st, const word *u, const word *z)
{
    return TYPED(kq_fixed_steady_step)(st, u, z, N, M, 0, OPTIONS);
}

#else

kq_status SIZED(user_predict)(TYPED(kq_filter) * f, const TYPED(kq_process) * p, const word *u)
{
    return TYPED(kq_fixed_predict)(f, p, u, N, 0, OPTIONS);
}

kq_status SIZED(user_update)(TYPED(kq_filter) * f, const TYPED(kq_sensor) * s, const word *z)
{
    return TYPED(kq_fixed_update)(f, s, z, N, M, OPTIONS);
}

kq_status SIZED(user_step)(TYPED(kq_filter) * f, const TYPED(kq_process) * p, const word *u,
                           const TYPED(kq_sensor) * s, const word *z)
{
    return TYPED(kq_fixed_step)(f, p, u, s, z, N, M, 0, OPTIONS);
}

kq_status SIZED(user_smooth_step)(TYPED(kq_history) * h, const TYPED(kq_process) * p,
                                  const TYPED(kq_smooth_extras) * extras)
{
#if SMOOTHS
    return TYPED(kq_fixed_smooth_step)(h, p, extras, N, OPTIONS);
#else /* and is not in the table */
    return TYPED(kq_smooth_step)(h, p, extras);
#endif
}

#endif
