/*
 * The attitude of a body that turns, from a gyro (100 Hz) with a bias, an accelerometer and a magnetometer (10 Hz).
 *
 * The quaternion and the bias are kept beside the filter, whose state is their ERROR: a small rotation of the body
 * (rad) and what is wrong in the bias (rad/s), n = 6.  After each update the error goes into quaternion and bias, and
 * the filter's mean back to 0 by kq_move.
 *
 * World axes: x to the north, z up.  Body axes: those of the sensors.
 * Source: Lefferts, Markley and Shuster, Kalman filtering for spacecraft attitude estimation, J. Guidance 5 (1982).
 */
#ifndef ATTITUDE_H
#define ATTITUDE_H

#include <kalmanq/extended.h>

enum {
    ATTITUDE_STATES = 6,     /* rotation x, y, z; bias x, y, z */
    ATTITUDE_STEPS = 1000,   /* that the tape has room for: 10 s */
    ATTITUDE_SIGHTINGS = 100 /* of these, steps with a sighting */
};

typedef struct {
    float quaternion[4]; /* w, x, y, z: turns what is given in body axes into world axes */
    float bias[3];       /* of the gyro, rad/s */
} attitude;

/** Level and to the north, 17 degrees (1 sigma) of each axis unknown. */
kq_status attitude_start(void);

/** 10 ms have passed.
 *   gyro     rad/s, body axes, at their beginning */
kq_status attitude_turn(const float gyro[3]);

/** A sighting of what points up and of the Earth's field.
 *   up       the accelerometer's reading at rest or in steady motion, in g
 *   field    the magnetometer's, its length 1 */
kq_status attitude_sight(const float up[3], const float field[3]);

/** The attitude now; the covariance of its error, row by row. */
kq_status attitude_read(attitude *estimate, float P[ATTITUDE_STATES * ATTITUDE_STATES]);

/** Ends the recording; then each step of it, 0 the start, given all sightings. */
kq_status attitude_smooth(void);
kq_status attitude_read_smoothed(size_t step, attitude *estimate,
                                 float P[ATTITUDE_STATES * ATTITUDE_STATES]);

/** KQ_EVENT_... of the run and of the smoother: 0 is as it should be.  So is KQ_EVENT_PRECISION here: of a body that
 * is level the accelerometer's z says next to nothing, and x and y say it. */
unsigned attitude_events(void);

#endif
