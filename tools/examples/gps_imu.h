/*
 * Position, speed and heading of a vehicle from an IMU in the plane (10 Hz) with two biases, and a GPS receiver (1 Hz).
 *
 *     x = (east, north, speed, heading, bias of the accelerometer, bias of the gyro): m, m/s, rad, m/s^2, rad/s
 *     d = dt (speed cos(heading), speed sin(heading), a - bias_a, w - bias_w, 0, 0), the increment f(x) - x
 *
 * The IMU's readings a and w move the state; the position is linear in it and takes the plain kq_update.  The
 * increment's Jacobian is given, or sigma points find it (gps_imu_start: by_points).
 *     East and north are of a point near by: a float has 24 bits, 0.06 m at 1000 km.
 * The heading is not wrapped: nothing measures it.
 */
#ifndef GPS_IMU_H
#define GPS_IMU_H

#include <kalmanq/sigma_points.h>

enum {
    GPS_IMU_STATES = 6,
    GPS_IMU_STEPS = 300, /* that the tape has room for: 30 s */
    GPS_IMU_FIXES = 30   /* of these, steps with a position */
};

/** x0 is known to 2 m, 1 m/s, 0.2 rad, 0.1 m/s^2 and 0.01 rad/s (1 sigma).
 *   by_points  0: Jacobians; otherwise sigma points */
kq_status gps_imu_start(const float x0[GPS_IMU_STATES], int by_points);

/** 0.1 s have passed.
 *   acceleration   along the vehicle, m/s^2
 *   rate           to the left, rad/s */
kq_status gps_imu_move(float acceleration, float rate);

/** A position: east, north, m. */
kq_status gps_imu_locate(const float position[2]);

/** The state now: its mean and its covariance, row by row. */
kq_status gps_imu_read(float mean[GPS_IMU_STATES], float P[GPS_IMU_STATES * GPS_IMU_STATES]);

/** Ends the recording; then each step of it, 0 the start, given all measurements. */
kq_status gps_imu_smooth(void);
kq_status gps_imu_read_smoothed(size_t step, float mean[GPS_IMU_STATES],
                                   float P[GPS_IMU_STATES * GPS_IMU_STATES]);

/** KQ_EVENT_... of the run and of the smoother: 0 is as it should be. */
unsigned gps_imu_events(void);

#endif
