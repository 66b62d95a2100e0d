/* Declares the functions of user.c for the size N, M; no guard: once for each size. */
kq_status SIZED(user_predict)(TYPED(kq_filter) * f, const TYPED(kq_process) * p, const word *u);
kq_status SIZED(user_update)(TYPED(kq_filter) * f, const TYPED(kq_sensor) * s, const word *z);
kq_status SIZED(user_step)(TYPED(kq_filter) * f, const TYPED(kq_process) * p, const word *u,
                           const TYPED(kq_sensor) * s, const word *z);
kq_status SIZED(user_smooth_step)(TYPED(kq_history) * h, const TYPED(kq_process) * p,
                                  const TYPED(kq_smooth_extras) * extras);
#ifdef KQ_COST_MODULES
kq_status SIZED(user_steady_step)(TYPED(kq_steady) * st, const word *u, const word *z);
#endif
