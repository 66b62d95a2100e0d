/* Declares the functions of user.c, after program.h: those for one sample, */
#ifndef KALMANQ_COST_USER_H
#define KALMANQ_COST_USER_H

#ifdef KQ_COST_MODULES
enum {
    LAG = 10,               /* steps back */
    PHASES = (LAG + 1) / 2, /* samples after which a lag's work is the same again: a block */
    LONGEST_PHASE = 2       /* since a block began: predict composes two maps, the answer three */
};

kq_status T(user_lag)(T(kq_lag) * past, const T(kq_process) * p, T(kq_filter) * f,
                      const T(kq_sensor) * s, const word *z);
kq_status T(user_lag_states)(T(kq_lag) * past, const T(kq_process) * p, T(kq_filter) * f,
                             const T(kq_sensor) * s, const word *z);
kq_status T(user_point)(T(kq_instant) * start, const T(kq_process) * p, T(kq_filter) * f,
                        const T(kq_sensor) * s, const word *z);
kq_status T(user_adapted)(T(kq_filter) * f, const T(kq_process) * p, const T(kq_sensor) * s,
                          const word *z);
#endif

#endif

/* and, once for each size, those for N and M. */
#if defined(KQ_COST_FIXED) && defined(N)
kq_status SIZED(user_predict)(T(kq_filter) * f, const T(kq_process) * p, const word *u);
kq_status SIZED(user_update)(T(kq_filter) * f, const T(kq_sensor) * s, const word *z);
kq_status SIZED(user_step)(T(kq_filter) * f, const T(kq_process) * p, const word *u,
                           const T(kq_sensor) * s, const word *z);
kq_status SIZED(user_smooth_step)(T(kq_history) * h, const T(kq_process) * p,
                                  const T(kq_smooth_extras) * extras);
#ifdef KQ_COST_MODULES
kq_status SIZED(user_steady_step)(T(kq_steady) * st, const word *u, const word *z);
#endif
#endif
