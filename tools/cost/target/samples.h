/* Declares the functions of samples.c, after library.h. */
#ifndef KALMANQ_COST_SAMPLES_H
#define KALMANQ_COST_SAMPLES_H

enum {
    LAG = 10,               /* steps back */
    PHASES = (LAG + 1) / 2, /* samples after which a lag's work is the same again: a block */
    LONGEST_PHASE = 2       /* since a block began: predict composes two maps, the answer three */
};

kq_status TYPED(user_lag)(TYPED(kq_lag) * past, const TYPED(kq_process) * p, TYPED(kq_filter) * f,
                          const TYPED(kq_sensor) * s, const word *z);
kq_status TYPED(user_lag_states)(TYPED(kq_lag) * past, const TYPED(kq_process) * p,
                                 TYPED(kq_filter) * f, const TYPED(kq_sensor) * s, const word *z);
kq_status TYPED(user_point)(TYPED(kq_point) * start, const TYPED(kq_process) * p,
                            TYPED(kq_filter) * f, const TYPED(kq_sensor) * s, const word *z);
kq_status TYPED(user_adapted)(TYPED(kq_adaptation) * tuner, TYPED(kq_filter) * f, const word *z);

#endif
