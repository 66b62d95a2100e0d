/*
 * The state of charge of a lithium cell from its current and its voltage, every 10 s.
 *
 *     x = (s, v): the charge, 0 .. 1, and the voltage of the polarisation, an RC pair
 *     s <- s - dt i / capacity           v <- a v + (1 - a) R1 i,  a = exp(-dt / (R1 C1))
 *     terminal voltage  u = ocv(s) - v - R0 i
 *
 * The process is linear, with the current as its control: it takes the plain kq_predict, and an ordinary history
 * records it.  Only the open-circuit voltage bends: the update takes the innovation and ocv's slope.
 * Source: Plett, Extended Kalman filtering for battery management systems, J. Power Sources 134 (2004).
 */
#ifndef BATTERY_H
#define BATTERY_H

#include <kalmanq/extended.h>

enum {
    BATTERY_STATES = 2,
    BATTERY_STEPS = 200 /* that the tape has room for */
};

/** The charge is not known better than +-0.1 (1 sigma). */
kq_status battery_start(void);

/** 10 s have passed.
 *   current  A, out of the cell, during them */
kq_status battery_discharge(float current);

/** The terminal voltage while the current flows, V and A. */
kq_status battery_measure(float voltage, float current);

/** The state now: its mean and its covariance, row by row. */
kq_status battery_read(float mean[BATTERY_STATES], float P[BATTERY_STATES * BATTERY_STATES]);

/** Ends the recording; then each step of it, 0 the start, given all measurements. */
kq_status battery_smooth(void);
kq_status battery_read_smoothed(size_t step, float mean[BATTERY_STATES],
                                   float P[BATTERY_STATES * BATTERY_STATES]);

/** KQ_EVENT_... of the run and of the smoother: 0 is as it should be. */
unsigned battery_events(void);

#endif
